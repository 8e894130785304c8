"""The whole command step for plain floats, unrolled for one chassis and its limits: twin of `kernel.command_step`."""

import math
from collections.abc import Callable, Sequence
from math import sqrt, tan
from typing import TYPE_CHECKING, Any

from holodrive.errors import CommandError
from holodrive.kinematics.caster_motion import headroom
from holodrive.kinematics.caster_step import leans, powered
from holodrive.kinematics.scalar import compile_functions, function, linear_maps, times
from holodrive.kinematics.settings import BAND, FLIP_SLACK, GOAL, HOLD_SPEED, POWERED, SLOW_DOWN_ROUNDS, TIGHT
from holodrive.robots.spec import Limits

if TYPE_CHECKING:
    from holodrive.kinematics.chassis import Chassis
    from holodrive.kinematics.wheel import Wheel

NOTHING, SPEED, YAW_RATE, ACCEL = -1, -2, -3, -4  # what binds, beside wheel numbers

Step = Callable[[float, float, float, float, list[float]], tuple[Any, ...]]


def command_step(chassis: "Chassis", limits: Limits | None = None) -> Step:
    # the text and the arithmetic must stay those of kernel.py: a test compares the two tick by tick
    """A function (vx, vy, omega, dt, memory) -> (speeds, steer, vx, vy, omega, scale, binding, share).

    `memory` is a list of 3 + 2 m floats, changed in place: the applied twist in the axes of the next tick, the
    steering angles [rad] and the drive signs. Speeds [rad/s] and angles [rad] are tuples; the twist is the applied
    one before discretisation; `scale` is what limits and wheels took; `binding` the number of the wheel that bound,
    or one of NOTHING, SPEED, YAW_RATE, ACCEL; `share` is how far towards the wanted twist acceleration limits let go.
    """
    names = {
        "remainder": math.remainder,
        "nan": math.nan,
        "tan": math.tan,
        "slowing": _slowing(chassis),
        "joint": joint,
        "refuse_tick": refuse_tick,
        "headroom": headroom,
    }
    if chassis.trails == POWERED:
        names["powered"] = powered(chassis)
    elif chassis.castered:
        names["leans"] = leans(chassis)
    return compile_functions(source(chassis, limits or Limits()), "command step", **names)["command_step"]  # type: ignore[no-any-return]


def refuse_tick(dt_s: float) -> None:
    """Raise for a tick that no clock can give; one without length (0) is only a tick without a command."""
    if not 0.0 <= dt_s < math.inf:
        raise CommandError(f"a tick of {dt_s} s; its length must be finite and greater than 0")


def source(chassis: "Chassis", limits: Limits) -> str:
    """The text of `command_step`."""
    m = len(chassis.steered)
    angles, signs = [f"s{j}" for j in range(m)], [f"g{j}" for j in range(m)]
    speeds = ", ".join(f"w{i}" for i in range(len(chassis.wheels)))
    accelerates = math.isfinite(limits.accel_m_s2) or math.isfinite(limits.yaw_accel_rad_s2)
    memory = ["lx", "ly", "lw", *angles, *signs]
    remembers = accelerates or chassis.castered
    last = ["c * vx + s * vy", "c * vy - s * vx", "omega"] if remembers else ["vx", "vy", "omega"]
    lines = [
        f"{', '.join(memory)} = memory",
        "sum_ = vx + vy + omega + dt",
        "if not (sum_ - sum_ == 0.0 and dt > 0.0):",  # not finite: inf - inf is NaN
        "    refuse_tick(dt)",
        "    memory[0] = memory[1] = memory[2] = 0.0",
        f"    return ({'nan, ' * len(chassis.wheels)}), {_tuple(angles)}, nan, nan, nan, nan, {NOTHING}, nan",
        "scale, binding = 1.0, -1",
        *_limit_lines(limits),
        *(_accelerate_lines(limits) if accelerates else []),
        "half = 0.5 * omega * dt",
        *_discrete_lines(),
        *_row_lines(chassis),
        *_fit_lines(chassis),
        *(_powered_lines(chassis) if chassis.trails == POWERED else _module_lines(chassis)),
        *(["turn = omega * dt", "c, s = cos(turn), sin(turn)"] if remembers else []),
        f"memory[:] = ({', '.join([*last, *angles, *signs])})",
        f"return ({speeds},), {_tuple(angles)}, vx, vy, omega, scale, binding, {'share' if accelerates else 1.0}",
    ]
    return function("command_step", ["vx", "vy", "omega", "dt", "memory"], lines)


def _limit_lines(limits: Limits) -> list[str]:
    """Direction-keeping limits of the base: speed, yaw rate, half a turn a tick."""
    lines = []
    if math.isfinite(limits.speed_m_s):
        lines += [
            "speed = sqrt(vx * vx + vy * vy)",
            f"if speed > {limits.speed_m_s!r}:",
            f"    scale, binding = {limits.speed_m_s!r} / speed, {SPEED}",
        ]
    if math.isfinite(limits.yaw_rate_rad_s):
        lines += [
            f"if abs(omega) * scale > {limits.yaw_rate_rad_s!r}:",
            f"    scale, binding = {limits.yaw_rate_rad_s!r} / abs(omega), {YAW_RATE}",
        ]
    return [
        *lines,
        "turn = omega * dt * scale",
        f"if not {-math.pi!r} <= turn <= {math.pi!r}:",
        f"    scale, binding = {math.pi!r} / abs(omega * dt), {YAW_RATE}",
        "if scale != 1.0:",
        "    vx *= scale",
        "    vy *= scale",
        "    omega *= scale",
    ]


def _accelerate_lines(limits: Limits) -> list[str]:
    return [
        "dx, dy, dw = vx - lx, vy - ly, omega - lw",
        "share, change = 1.0, sqrt(dx * dx + dy * dy)",
        f"top = {limits.accel_m_s2!r} * dt" if math.isfinite(limits.accel_m_s2) else "top = change",
        "if change > top:",
        "    share = top / change",
        f"top = {limits.yaw_accel_rad_s2!r} * dt" if math.isfinite(limits.yaw_accel_rad_s2) else "top = abs(dw)",
        "if abs(dw) * share > top:",
        "    share = top / abs(dw)",
        "if share < 1.0:",
        f"    vx, vy, omega, binding = lx + share * dx, ly + share * dy, lw + share * dw, {ACCEL}",
    ]


def _discrete_lines(indent: str = "") -> list[str]:
    """(ux, uy): the twist that holds a straight line while turning by 2 half in the tick."""
    lines = [
        "k = half / tan(half) if half else 1.0",
        "ux = k * vx + half * vy",
        "uy = k * vy - half * vx",
    ]
    return [indent + line for line in lines]


def _row_lines(chassis: "Chassis", indent: str = "") -> list[str]:
    """Wheel rows of (ux, uy, omega): w (fixed wheels), or a, b, and the square q of the rim speed (modules)."""
    lines, rows = linear_maps(chassis.jacobian, ("ux", "uy", "omega"), "p")
    names = _contact_names(chassis)
    used = [name for pair in names.values() for name in pair]
    for i, (wheel, row) in enumerate(zip(chassis.wheels, chassis.row, strict=True)):
        if not wheel.steered:
            lines.append(f"w{i} = {rows[row]}")
            continue
        squares = []
        for name, expression in zip(names[i], (rows[row], rows[row + 1]), strict=True):
            if f"{name} = {expression}" not in lines:
                lines.append(f"{name} = {expression}")
                if used.count(name) > 1:
                    lines.append(f"{name}2 = {name} * {name}")
            squares.append(f"{name}2" if used.count(name) > 1 else f"{name} * {name}")
        lines.append(f"q{i} = {squares[0]} + {squares[1]}")
    return [indent + line for line in lines]


def _contact_names(chassis: "Chassis") -> dict[int, tuple[str, str]]:
    """Names of each module's contact velocity along and across; equal ones share a name."""
    _, rows = linear_maps(chassis.jacobian, ("ux", "uy", "omega"), "p")
    known: dict[str, str] = {}
    names = {}
    for i in chassis.steered:
        along, across = rows[chassis.row[i]], rows[chassis.row[i] + 1]
        names[i] = known.setdefault(along, f"a{i}_"), known.setdefault(across, f"b{i}_")
    return names


def _fit_lines(chassis: "Chassis") -> list[str]:
    """Scale into what the wheels can do; squares of speeds are compared, which costs least."""
    limited = [i for i, wheel in enumerate(chassis.wheels) if math.isfinite(wheel.max_speed)]
    if not limited:
        return []
    squares = [f"q{i}" if chassis.wheels[i].steered else f"w{i} * w{i}" for i in limited]
    bounds = [chassis.wheels[i].max_rim_speed if chassis.wheels[i].steered else chassis.max_speeds[i] for i in limited]
    top = 1.0
    if len(set(bounds)) == 1:  # speeds can be compared as they are
        top = float(bounds[0])
    else:
        squares = [f"{square}{times(float(bound) ** -2)}" for square, bound in zip(squares, bounds, strict=True)]
    numbers = "worst" if limited == list(range(len(chassis.wheels))) else f"{tuple(limited)!r}[worst]"
    return [
        f"while (square := {_largest(squares)}) > {top * top!r}:",
        f"    worst = ({', '.join(squares)},).index(square)",
        "    slow, c1, c2, c3 = slowing[worst]",
        f"    factor, binding = slow(c1, c2, c3, vx, vy, omega, half, sqrt(square){times(1.0 / top)}), {numbers}",
        "    scale *= factor",
        "    vx *= factor",
        "    vy *= factor",
        "    omega *= factor",
        "    half *= factor",
        *_discrete_lines("    "),
        *_row_lines(chassis, "    "),
    ]


def _slowing(chassis: "Chassis") -> tuple[tuple[Any, ...], ...]:
    """What slows each limited wheel down: a function and its three numbers."""
    table: list[tuple[Any, ...]] = []
    for wheel, row in zip(chassis.wheels, chassis.row, strict=True):
        if wheel.steered and math.isfinite(wheel.max_speed):
            table.append((slow_module, wheel.x, wheel.y, wheel.max_rim_speed))
        elif math.isfinite(wheel.max_speed):
            table.append((slow_fixed, *(float(value) / wheel.max_speed for value in chassis.jacobian[row])))
    return tuple(table)


def slow_fixed(ax: float, ay: float, aw: float, vx: float, vy: float, omega: float, half: float, load: float) -> float:
    """Factor f that brings one fixed wheel with `load` > 1 to its limit.

    The wheel's relative speed under discretise(f twist) is f g(f), and g is nearly straight, for it bends only as the
    turn in the tick does: g(f) = |k P + h Q + R| with h = f half, k = h cot h. Each round lays g's tangent and solves
    the quadratic. The same arithmetic as `kernel.slow_down`.

    Args:
        ax, ay, aw: row of the wheel in units of its limit.
        vx, vy, omega: twist at factor 1.
        half: half its turn in the tick [rad].
        load: g(1).
    """
    p, q, r = ax * vx + ay * vy, ax * vy - ay * vx, aw * omega
    f, h = 1.0, half
    for _ in range(SLOW_DOWN_ROUNDS):
        k = h / tan(h) if h else 1.0
        g = k * p + h * q + r
        tilt = (k - k * k - h * h) / f * p + half * q
        if g < 0.0:
            g, tilt = -g, -tilt
        g -= tilt * f
        root = g * g + 4.0 * GOAL * tilt
        step = f
        f = 2.0 * GOAL / (g + sqrt(root)) if root > 0.0 else -1.0
        if not 0.0 < f < 1.0:
            f = GOAL / load
        h = f * half
        step = (f - step) * half
        if step * step <= TIGHT:
            break
    return f


def slow_module(
    x: float, y: float, bound: float, vx: float, vy: float, omega: float, half: float, load: float
) -> float:
    """`slow_fixed` for a steered wheel at (x, y) [m] with its rim speed limit `bound` [m/s]: P, Q, R are vectors."""
    rx, ry, goal = -omega * y, omega * x, GOAL * bound
    f, h = 1.0, half
    for _ in range(SLOW_DOWN_ROUNDS):
        k = h / tan(h) if h else 1.0
        a, b = k * vx + h * vy + rx, k * vy - h * vx + ry
        g = sqrt(a * a + b * b)
        slope = (k - k * k - h * h) / f
        tilt = (a * (slope * vx + half * vy) + b * (slope * vy - half * vx)) / g
        g -= tilt * f
        root = g * g + 4.0 * goal * tilt
        step = f
        f = 2.0 * goal / (g + sqrt(root)) if root > 0.0 else -1.0
        if not 0.0 < f < 1.0:
            f = GOAL / load
        h = f * half
        step = (f - step) * half
        if step * step <= TIGHT:
            break
    return f


def _module_lines(chassis: "Chassis") -> list[str]:
    """Steered wheels: shortest turn with hysteresis, hold at rest, steering rate, cosine scaling."""
    if not chassis.steered:
        return []
    count = range(len(chassis.steered))
    names = _contact_names(chassis)
    pairs = ", ".join(f"({', '.join(names[i])}, s{j}, g{j})" for j, i in enumerate(chassis.steered))
    lines = [
        "together = False",
        f"if not ({' and '.join(f'g{j}' for j in count)}):",
        f"    together = joint(({pairs},))",
    ]
    for j, i in enumerate(chassis.steered):
        wheel = chassis.wheels[i]
        lines += _one_module_lines(i, j, names[i], wheel)
    if chassis.castered:
        lines.insert(0, f"{', '.join(f'l{j}' for j in count)}, = leans(vx, vy, omega, lx, ly, lw, dt)")
    return lines + (_headroom_lines(chassis) if any(chassis.couplings) else [])


def _one_module_lines(i: int, j: int, contact: tuple[str, str], wheel: "Wheel") -> list[str]:
    """One module. A moving one (g = +-1) keeps its drive sign until the turn for it is beyond 90 deg + hysteresis."""
    along, across = contact
    per_radius, rate = 1.0 / wheel.radius, wheel.steer_rate
    far = math.pi / 2 + BAND
    lines = [
        f"u = sqrt(q{i})",
        f"if u < {HOLD_SPEED!r}:",
        f"    w{i}, g{j} = u * cos(atan2({across}, {along}) - s{j}) * {per_radius!r}, 0.0",
        "else:",
        f"    if g{j}:",
        f"        turn = atan2({across} * g{j}, {along} * g{j}) - s{j}",
        f"        if not {-far!r} <= turn <= {far!r}:",
        f"            turn = remainder(turn, {math.tau!r})",
        f"            if turn > {far!r} or turn < {-far!r}:",
        f"                turn, g{j} = turn - ({math.pi!r} if turn > 0.0 else {-math.pi!r}), -g{j}",
        "    else:",
        f"        turn, g{j} = remainder(atan2({across}, {along}) - s{j}, {math.tau!r}), 1.0",
        f"        error = abs(turn) - {math.pi / 2!r}",
        f"        if error > 0.0 if abs(error) > {BAND!r} else together:",
        f"            turn, g{j} = turn - ({math.pi!r} if turn > 0.0 else {-math.pi!r}), -1.0",
    ]
    if wheel.caster or wheel.coupling:
        return lines + _trailing_module_lines(i, j, wheel)
    if not math.isfinite(rate):
        return [*lines, f"    w{i} = u * g{j} * {per_radius!r}", f"    s{j} += turn"]
    return [
        *lines,
        f"    reach = {rate!r} * dt",
        "    if not -reach <= turn <= reach:",
        "        step = reach if turn > 0.0 else -reach",
        "        u *= cos(turn - step)",
        "        turn = step",
        f"    w{i} = u * g{j} * {per_radius!r}",
        f"    s{j} += turn",
    ]


def _trailing_module_lines(i: int, j: int, wheel: "Wheel") -> list[str]:
    """The rest of one module with a short caster, which leans, or with a coupling, whose turn `t` counts."""
    far = math.pi / 2 + BAND
    reach = f"min({far!r}, {wheel.steer_rate!r} * dt)" if math.isfinite(wheel.steer_rate) else repr(far)
    return [
        f"t{j} = 0.0",
        f"if u >= {HOLD_SPEED!r}:",
        "    goal = turn",
        *([f"    turn -= g{j} * l{j}"] if wheel.caster else []),
        f"    reach = {reach}",
        "    turn = min(reach, max(-reach, turn))",
        f"    w{i} = u * g{j} * cos(goal - turn) * {1.0 / wheel.radius!r}",
        f"    s{j} += turn",
        f"    t{j} = turn",
    ]


def _headroom_lines(chassis: "Chassis") -> list[str]:
    """Slow all wheels down where a drive that makes up for its coupling has no more left."""
    rooms = []
    for j, i in enumerate(chassis.steered):
        wheel = chassis.wheels[i]
        if wheel.coupling:
            rooms.append((i, f"headroom(w{i}, {wheel.coupling!r} * t{j} / dt, {_limit(wheel.max_speed)})"))
    wheels = [f"w{i}" for i in range(len(chassis.wheels))]
    return [
        f"rooms = ({', '.join(text for _, text in rooms)},)",
        "room = min(rooms)",
        "if room < 1.0:",
        f"    binding = {tuple(i for i, _ in rooms)!r}[rooms.index(room)]",
        "    scale *= room",
        "    vx *= room",
        "    vy *= room",
        "    omega *= room",
        f"    {', '.join(wheels)} = {', '.join(f'{name} * room' for name in wheels)}",
    ]


def _limit(value: float) -> str:
    return repr(value) if math.isfinite(value) else "inf"


def _powered_lines(chassis: "Chassis") -> list[str]:
    """All modules as powered casters: see `powered`."""
    m, n = len(chassis.steered), len(chassis.wheels)
    wheels, angles, signs = (", ".join(f"{name}{i}" for i in range(k)) for name, k in (("w", n), ("s", m), ("g", m)))
    return [
        f"factor, worst, ({wheels},), ({angles},), ({signs},) = powered(vx, vy, omega, dt, ({angles},))",
        "if factor < 1.0:",
        "    binding = worst",
        "    scale *= factor",
        "    vx *= factor",
        "    vy *= factor",
        "    omega *= factor",
    ]


def joint(modules: Sequence[tuple[float, float, float, float]]) -> bool:
    """Whether modules at rest that stand about square to their goal flip: all or none, whichever turns less.

    Args:
        modules: contact velocity along and across the zero direction [m/s], angle now [rad], drive sign.
    """
    total = 0.0
    for along, across, now, sign in modules:
        if sign != 0.0 or along * along + across * across < HOLD_SPEED * HOLD_SPEED:
            continue
        error = abs(math.remainder(math.atan2(across, along) - now, math.tau)) - math.pi / 2
        if abs(error) <= BAND:
            total += error
    return total > FLIP_SLACK


def _largest(terms: Sequence[str]) -> str:
    return f"max({', '.join(terms)})" if len(terms) > 1 else terms[0]


def _tuple(names: Sequence[str]) -> str:
    return f"({', '.join(names)},)" if names else "()"
