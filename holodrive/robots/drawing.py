"""A robot from above as SVG: wheels with the direction of their rollers, names, footprint and axes.

Coordinates are those of the map the robot stands in, x to the right and y up, times `scale` pixels a metre;
SVG's y points down, so signs are turned here and nowhere else. Hatches show the axes of the rollers that touch the
ground; the rollers one sees on top of a Mecanum wheel run the other way.
"""

import math
from collections.abc import Sequence

from holodrive import svg
from holodrive.robots.checks import trail, turning_radius
from holodrive.robots.spec import Robot, WheelSpec
from holodrive.types import Pose

INK, PALE, BODY, TYRE, ROLLER, AHEAD, LEFT = "#333", "#bbb", "#f4f4f4", "#dde6ee", "#0072B2", "#D55E00", "#009E73"
HATCHES = 7  # lines on a wheel
ORIGIN = Pose(0.0, 0.0, 0.0)


def robot_svg(robot: Robot, *, size: int = 360, steer: Sequence[float] = ()) -> str:
    """A whole picture of `size` pixels, ahead is up."""
    scale = size / (2.7 * robot.footprint_radius_m)
    half = 0.5 * size
    view = f"{-half:g} {-half:g} {size} {size}"
    title = f"{robot.name}: {robot.title}" if robot.title else robot.name
    ground = svg.element("rect", x=-half, y=-half, width=size, height=size, fill="#fff")
    shapes = robot_shapes(robot, pose=Pose(0.0, 0.0, 0.5 * math.pi), scale=scale, steer=steer)
    return svg.document(size, size, ground, shapes, view_box=view, title=title)


def robot_shapes(
    robot: Robot,
    *,
    pose: Pose = ORIGIN,
    scale: float = 100.0,
    names: bool = True,
    steer: Sequence[float] = (),
) -> str:
    """The robot at a pose [m, m, rad] as one SVG group, `scale` pixels a metre.

    Args:
        robot: what to draw.
        pose: in the map that the picture shows.
        scale: pixels a metre.
        names: whether to write the wheels' names and draw the axes.
        steer: (m,) angles of the steered wheels [rad], in the robot's order; zeros when empty.
    """
    frame = _Frame(pose, scale)
    x, y = frame.point(0.0, 0.0)
    radius = robot.footprint_radius_m * scale
    parts = [svg.element("circle", cx=x, cy=y, r=radius, fill=BODY, stroke=PALE, stroke_dasharray="4 3")]
    angles = dict(zip(robot.steered, steer, strict=False))
    for number, wheel in enumerate(robot.wheels):
        parts += _wheel(frame, wheel, angles.get(number, 0.0))
    if names:
        parts += _axes(frame, robot) + [_name(frame, wheel) for wheel in robot.wheels]
    else:
        parts.append(_line(frame, (0.0, 0.0), (robot.footprint_radius_m, 0.0), AHEAD, 2.0))
    return svg.element("g", *parts, font_family="sans-serif", font_size=11, fill=INK)


class _Frame:
    """From `base_link` metres to picture pixels."""

    def __init__(self, pose: Pose, scale: float) -> None:
        self.pose, self.scale = pose, scale
        self.cos, self.sin = math.cos(pose.theta), math.sin(pose.theta)

    def point(self, x: float, y: float) -> tuple[float, float]:
        world_x = self.pose.x + self.cos * x - self.sin * y
        world_y = self.pose.y + self.sin * x + self.cos * y
        return self.scale * world_x, -self.scale * world_y


def _wheel(frame: _Frame, wheel: WheelSpec, steer: float) -> list[str]:
    turn = wheel.yaw + (steer if wheel.kind == "swerve" else 0.0)
    u, v, back = wheel.radius, 0.5 * wheel.width, trail(wheel)
    shape = svg.points(frame.point(*_on(wheel, turn, a - back, b)) for a, b in ((u, v), (-u, v), (-u, -v), (u, -v)))
    parts = []
    if wheel.kind == "swerve":
        x, y = frame.point(wheel.x, wheel.y)
        swept = turning_radius(wheel) * frame.scale
        parts.append(svg.element("circle", cx=x, cy=y, r=swept, fill="none", stroke=PALE, stroke_dasharray="2 2"))
    parts.append(svg.element("polygon", points=shape, fill=TYRE, stroke=INK))
    if wheel.kind != "swerve":
        parts += [_line(frame, _on(wheel, turn, *a), _on(wheel, turn, *b), ROLLER, 1.0) for a, b in hatches(wheel)]
    tip = _on(wheel, turn, 1.25 * u, 0.0)
    if back:  # the steering axis, which the wheel trails behind
        x, y = frame.point(wheel.x, wheel.y)
        parts.append(svg.element("circle", cx=x, cy=y, r=0.15 * u * frame.scale, fill=INK))
    start = _on(wheel, turn, -back, 0.0)
    return [*parts, _line(frame, start, tip, INK, 1.5), _arrow_head(frame, tip, turn, 0.3 * u)]


def hatches(wheel: WheelSpec) -> list[tuple[tuple[float, float], tuple[float, float]]]:
    """Lines along the roller axes, cut to the wheel's rectangle, in its own axes (ahead, left) [m]."""
    c, s = math.cos(wheel.roller), math.sin(wheel.roller)
    u, v = wheel.radius, 0.5 * wheel.width
    far = u * abs(s) + v * abs(c)  # how far the rectangle reaches across the lines
    found = []
    for k in range(HATCHES):
        offset = far * (2.0 * (k + 0.5) / HATCHES - 1.0)
        px, py = -s * offset, c * offset
        low, high = -math.inf, math.inf
        for at, step, half in ((px, c, u), (py, s, v)):
            if abs(step) > 1e-12:
                near, away = sorted(((-half - at) / step, (half - at) / step))
                low, high = max(low, near), min(high, away)
        if high > low:
            found.append(((px + low * c, py + low * s), (px + high * c, py + high * s)))
    return found


def _axes(frame: _Frame, robot: Robot) -> list[str]:
    length = 0.45 * robot.footprint_radius_m
    parts = []
    for (dx, dy), colour, label in (((1.0, 0.0), AHEAD, "x"), ((0.0, 1.0), LEFT, "y")):
        tip = (length * dx, length * dy)
        parts.append(_line(frame, (0.0, 0.0), tip, colour, 2.0))
        parts.append(_arrow_head(frame, tip, math.atan2(dy, dx), 0.08 * robot.footprint_radius_m, colour))
        x, y = frame.point(1.25 * tip[0], 1.25 * tip[1])
        parts.append(svg.text(x, y + 4.0, label, text_anchor="middle", fill=colour))
    return parts


def _name(frame: _Frame, wheel: WheelSpec) -> str:
    """Outside the wheel, as seen from the robot's centre."""
    distance = math.hypot(wheel.x, wheel.y)
    out = (wheel.x / distance, wheel.y / distance) if distance > 0.0 else (0.0, -1.0)
    away = 1.1 * turning_radius(wheel)
    x, y = frame.point(wheel.x + out[0] * away, wheel.y + out[1] * away)
    middle, _ = frame.point(0.0, 0.0)
    aside = abs(x - middle) > 0.25 * away * frame.scale
    anchor = ("start" if x > middle else "end") if aside else "middle"
    return svg.text(x, y + 4.0, wheel.name, text_anchor=anchor)


def _on(wheel: WheelSpec, turn: float, ahead: float, left: float) -> tuple[float, float]:
    """A point of the wheel's own axes in `base_link` [m]."""
    c, s = math.cos(turn), math.sin(turn)
    return wheel.x + c * ahead - s * left, wheel.y + s * ahead + c * left


def _line(frame: _Frame, a: tuple[float, float], b: tuple[float, float], colour: str, width: float) -> str:
    (x1, y1), (x2, y2) = frame.point(*a), frame.point(*b)
    return svg.element("line", x1=x1, y1=y1, x2=x2, y2=y2, stroke=colour, stroke_width=width)


def _arrow_head(frame: _Frame, tip: tuple[float, float], turn: float, size: float, colour: str = INK) -> str:
    corners = [
        frame.point(tip[0] + size * math.cos(turn + angle), tip[1] + size * math.sin(turn + angle))
        for angle in (0.0, 2.5, -2.5)
    ]
    return svg.element("polygon", points=svg.points(corners), fill=colour)
