"""What a robot file may say in right form and still be wrong: wheels in one another, limits out of reach."""

import math
from collections.abc import Iterable, Mapping
from itertools import combinations, product
from typing import Any

from holodrive.files.source import Source
from holodrive.robots.spec import Mouse, WheelSpec

WHEELS_OUTSIDE = "wheels-outside-footprint"  # what a file accepts when its footprint is meant to be that small
ACCEPTABLE = (WHEELS_OUTSIDE,)
NEAREST_DEG = 1.0  # to 0 and 90 deg: nearer, a Mecanum roller is an omni's, or cannot be driven


def mecanum_roller(roller: float) -> str:
    """What is wrong with the roller angle [rad] of a Mecanum wheel, or nothing."""
    shown = f"a Mecanum wheel with its rollers at {math.degrees(roller):.4g} deg"
    if abs(math.cos(roller)) < math.sin(math.radians(NEAREST_DEG)):
        return f"{shown} cannot drive: the rollers roll in the wheel's own direction"
    if abs(math.sin(roller)) < math.sin(math.radians(NEAREST_DEG)):
        return f'{shown} is an omni wheel; write kind = "omni"'
    return ""


def whole(
    wheels: Mapping[str, WheelSpec | None], robot: Mapping[str, Any], limits: Mapping[str, Any], source: Source
) -> None:
    """Note the faults that lie between the tables."""
    good = [wheel for wheel in wheels.values() if wheel is not None]
    for a, b in combinations(good, 2):
        if overlap(a, b):
            source.fault(("wheel", b.name, "at"), f"wheel {b.name} stands in wheel {a.name}")
    _footprint(good, robot, source)
    if good and robot and robot.get("inertia") is None and all(math.hypot(w.x, w.y) == 0.0 for w in good):
        source.fault(("robot",), "[robot] needs 'inertia': it cannot be derived from wheels at the centre", at_key=True)
    if len(good) == len(wheels) and limits.get("speed") is not None:
        _speed(good, limits["speed"], source)


def _footprint(wheels: list[WheelSpec], robot: Mapping[str, Any], source: Source) -> None:
    stated, accepts = robot.get("footprint_radius"), WHEELS_OUTSIDE in robot.get("accept", [])
    if not wheels:
        return
    far = max(wheels, key=lambda wheel: reach([wheel]))
    outside = stated is not None and reach([far]) > stated * (1.0 + 1e-9)
    if outside and not accepts:
        source.fault(
            ("robot", "footprint_radius"),
            f"the footprint must enclose all wheels: {far.name} reaches {reach([far]):.4g} m, found {stated:.4g} m",
            f'if that is meant, write accept = ["{WHEELS_OUTSIDE}"] under [robot]',
        )
    if accepts and not outside:
        source.fault(("robot", "accept"), "all wheels are inside the footprint; leave 'accept' out")


def mice(
    found: Iterable[Mouse], wheels: Mapping[str, WheelSpec | None], robot: Mapping[str, Any], source: Source
) -> None:
    """Note ground sensors that sit outside the footprint, which encloses all parts."""
    good = [wheel for wheel in wheels.values() if wheel is not None]
    radius = robot.get("footprint_radius") or (reach(good) if good and len(good) == len(wheels) else math.inf)
    for mouse in found:
        far = math.hypot(mouse.mount.x, mouse.mount.y)
        if far > radius * (1.0 + 1e-9):
            source.fault(
                ("sensor", "mouse", mouse.name, "mount"),
                f"mouse {mouse.name} sits {far:.4g} m from the robot's centre, outside its footprint of {radius:.4g} m",
                "correct the mount, or make footprint_radius enclose all parts",
            )


def _speed(wheels: list[WheelSpec], stated: float, source: Source) -> None:
    best = top_speed(wheels)
    if stated > best * (1.0 + 1e-9):
        source.fault(
            ("limits", "speed"),
            f"the wheels give at most {best:.3g} m/s in the base's best direction, limit says {stated:.3g} m/s",
        )


def top_speed(wheels: Iterable[WheelSpec]) -> float:
    """Fastest translation in the best direction, without turning [m/s]: the farthest corner of the speed polygon."""
    disc, strips = math.inf, []
    for wheel in wheels:
        rim = wheel.max_speed_rad_s * wheel.radius
        if wheel.kind == "swerve":
            disc = min(disc, rim)
        else:
            along = wheel.yaw + wheel.roller
            strips.append((math.cos(along), math.sin(along), rim * abs(math.cos(wheel.roller))))
    best = 0.0
    for (ax, ay, a), (bx, by, b) in combinations(strips, 2):
        det = ax * by - ay * bx
        for sa, sb in product((a, -a), (b, -b)) if abs(det) > 1e-9 else ():
            vx, vy = (sa * by - sb * ay) / det, (ax * sb - bx * sa) / det
            if all(abs(cx * vx + cy * vy) <= c * (1.0 + 1e-9) for cx, cy, c in strips):
                best = max(best, math.hypot(vx, vy))
    return min(disc, best) if best else disc  # without two crossing strips only a disc bounds the speed


def reach(wheels: Iterable[WheelSpec]) -> float:
    """Distance from the robot's centre to the farthest point that a wheel can stand at [m]."""
    return max(_reach(wheel) for wheel in wheels)


def _reach(wheel: WheelSpec) -> float:
    if wheel.kind == "swerve":
        return math.hypot(wheel.x, wheel.y) + turning_radius(wheel)
    return max(math.hypot(x, y) for x, y in corners(wheel))


def turning_radius(wheel: WheelSpec) -> float:
    """Radius of the circle that a wheel sweeps when it is steered all round [m]."""
    return math.hypot(wheel.radius + abs(trail(wheel)), 0.5 * wheel.width)


def trail(wheel: WheelSpec) -> float:
    """How far a wheel trails behind its steering axis [m]; 0 for one that does not, or is not steered."""
    return wheel.steering.caster_m if wheel.steering else 0.0


def corners(wheel: WheelSpec) -> list[tuple[float, float]]:
    """The wheel from above at its `yaw`: the corners of a rectangle, in order [m]."""
    c, s = math.cos(wheel.yaw), math.sin(wheel.yaw)
    u, v = wheel.radius, 0.5 * wheel.width
    return [
        (wheel.x + c * along - s * across, wheel.y + s * along + c * across)
        for along, across in ((u, v), (-u, v), (-u, -v), (u, -v))
    ]


def overlap(a: WheelSpec, b: WheelSpec) -> bool:
    """Whether two wheels stand in one another, seen from above; steered wheels count as their turning circles."""
    if a.kind == "swerve" and b.kind == "swerve":
        return math.hypot(a.x - b.x, a.y - b.y) < turning_radius(a) + turning_radius(b)
    if a.kind == "swerve":
        return _in_circle(a, b)
    if b.kind == "swerve":
        return _in_circle(b, a)
    return not any(_apart(a, b, angle) for wheel in (a, b) for angle in (wheel.yaw, wheel.yaw + math.pi / 2))


def _apart(a: WheelSpec, b: WheelSpec, angle: float) -> bool:
    """Whether the two rectangles lie apart along that direction."""
    c, s = math.cos(angle), math.sin(angle)
    first = [c * x + s * y for x, y in corners(a)]
    second = [c * x + s * y for x, y in corners(b)]
    return max(first) <= min(second) or max(second) <= min(first)


def _in_circle(steered: WheelSpec, fixed: WheelSpec) -> bool:
    """Whether the rectangle of the fixed wheel reaches into the turning circle of the steered one."""
    dx, dy = steered.x - fixed.x, steered.y - fixed.y
    c, s = math.cos(fixed.yaw), math.sin(fixed.yaw)
    along = max(abs(c * dx + s * dy) - fixed.radius, 0.0)
    across = max(abs(c * dy - s * dx) - 0.5 * fixed.width, 0.0)
    return math.hypot(along, across) < turning_radius(steered)
