"""The whole command step for plain floats, unrolled for one chassis and its limits: twin of `kernel.command_step`."""

import math
from collections.abc import Callable, Sequence
from math import cos, sin, sqrt
from typing import TYPE_CHECKING, Any

from holodrive.kinematics.scalar import compile_functions, function, linear_maps, times
from holodrive.kinematics.settings import FOUR_GOALS, GOAL, HOLD_SPEED, HYSTERESIS, SLOW_DOWN_ROUNDS, TIGHT, TWO_GOALS
from holodrive.robots.spec import Limits

if TYPE_CHECKING:
    from holodrive.kinematics.chassis import Chassis

NOTHING, SPEED, YAW_RATE, ACCEL = -1, -2, -3, -4  # what binds, beside wheel numbers

Step = Callable[[float, float, float, float, list[float]], tuple[Any, ...]]


def command_step(chassis: "Chassis", limits: Limits | None = None) -> Step:
    # the text and the arithmetic must stay those of kernel.py: a test compares the two tick by tick
    """A function (vx, vy, omega, dt, memory) -> (speeds, steer, vx, vy, omega, scale, binding).

    `memory` is a list of 3 + 2 m floats, changed in place: the applied twist in the axes of the next tick, the
    steering angles [rad] and the drive signs. Speeds [rad/s] and angles [rad] are tuples; the twist is the applied
    one before discretisation; `scale` is what limits and wheels took; `binding` the number of the wheel that bound,
    or one of NOTHING, SPEED, YAW_RATE, ACCEL.
    """
    names = {
        "isfinite": math.isfinite,
        "remainder": math.remainder,
        "nan": math.nan,
        "slow_down": slow_down,
        "joint": joint,
    }
    return compile_functions(source(chassis, limits or Limits()), "command step", **names)["command_step"]  # type: ignore[no-any-return]


def source(chassis: "Chassis", limits: Limits) -> str:
    """The text of `command_step`."""
    m = len(chassis.steered)
    angles, signs = [f"s{j}" for j in range(m)], [f"g{j}" for j in range(m)]
    speeds = ", ".join(f"w{i}" for i in range(len(chassis.wheels)))
    accelerates = math.isfinite(limits.accel_m_s2) or math.isfinite(limits.yaw_accel_rad_s2)
    memory = ["lx", "ly", "lw", *angles, *signs]
    lines = [
        f"{', '.join(memory)} = memory",
        "if not (isfinite(vx + vy + omega) and dt > 0.0):",
        "    memory[0] = memory[1] = memory[2] = 0.0",
        f"    return ({'nan, ' * len(chassis.wheels)}), {_tuple(angles)}, nan, nan, nan, nan, {NOTHING}",
        "scale, binding = 1.0, -1",
        *_limit_lines(limits),
        *(_accelerate_lines(limits) if accelerates else []),
        "half = 0.5 * omega * dt",
        *_discrete_lines(),
        *_row_lines(chassis),
        *_fit_lines(chassis),
        *(["turn = omega * dt", "c, s = cos(turn), sin(turn)"] if accelerates else []),
        "memory[0] = c * vx + s * vy" if accelerates else "memory[0] = vx",
        "memory[1] = c * vy - s * vx" if accelerates else "memory[1] = vy",
        "memory[2] = omega",
        *_module_lines(chassis),
        f"return ({speeds},), {_tuple(angles)}, vx, vy, omega, scale, binding",
    ]
    if m:
        lines.insert(-1, f"memory[3:] = ({', '.join(angles + signs)})")
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
    lines += [
        "rate = omega if omega > 0.0 else -omega",
        f"top = {math.pi!r} / dt",
        *([f"top = min(top, {limits.yaw_rate_rad_s!r})"] if math.isfinite(limits.yaw_rate_rad_s) else []),
        "if rate * scale > top:",
        f"    scale, binding = top / rate, {YAW_RATE}",
        "if scale != 1.0:",
        "    vx *= scale",
        "    vy *= scale",
        "    omega *= scale",
    ]
    return lines


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
        "q = half * half",
        "k = 1.0 - q * (1/3 + q * (1/45 + q * (2/945 + q * (1/4725 + q * (2/93555))))) if q < 0.0225 else "
        "half * cos(half) / sin(half)",
        "ux = k * vx + half * vy",
        "uy = k * vy - half * vx",
    ]
    return [indent + line for line in lines]


def _row_lines(chassis: "Chassis", indent: str = "") -> list[str]:
    """Wheel rows of (ux, uy, omega) into w (fixed wheels) and a, b with rim speed u (modules); then the loads."""
    lines, rows = linear_maps(chassis.jacobian, ("ux", "uy", "omega"), "p")
    for i, (wheel, row) in enumerate(zip(chassis.wheels, chassis.row, strict=True)):
        if wheel.steered:
            lines += [f"a{i} = {rows[row]}", f"b{i} = {rows[row + 1]}", f"u{i} = sqrt(a{i} * a{i} + b{i} * b{i})"]
        else:
            lines.append(f"w{i} = {rows[row]}")
    return [indent + line for line in lines]


def _loads(chassis: "Chassis") -> list[str]:
    """Speed of each limited wheel relative to its limit."""
    loads = []
    for i, wheel in enumerate(chassis.wheels):
        if math.isfinite(wheel.max_speed):
            bound = wheel.max_rim_speed if wheel.steered else wheel.max_speed
            loads.append(f"{f'u{i}' if wheel.steered else f'abs(w{i})'} * {1.0 / bound!r}")
    return loads


def _fit_lines(chassis: "Chassis") -> list[str]:
    """Scale into what the wheels can do: only a command that is too fast pays for more than one comparison."""
    limited = [i for i, wheel in enumerate(chassis.wheels) if math.isfinite(wheel.max_speed)]
    if not limited:
        return []
    loads = _loads(chassis)
    bounds = {wheel.max_rim_speed if wheel.steered else wheel.max_speed for wheel in chassis.wheels}
    top = 1.0
    if len(bounds) == 1:  # speeds can be compared as they are
        top, loads = bounds.pop(), [load.partition(" * ")[0] for load in loads]
    table = tuple(_wheel_rows(chassis, i) for i in limited)
    numbers = "worst" if limited == list(range(len(chassis.wheels))) else f"{tuple(limited)!r}[worst]"
    return [
        f"while (load := {_largest(loads)}) > {top!r}:",
        f"    worst = ({', '.join(loads)},).index(load)",
        f"    factor, binding = slow_down({table!r}[worst], vx, vy, omega, half, k, load{times(1.0 / top)}), {numbers}",
        "    scale *= factor",
        "    vx *= factor",
        "    vy *= factor",
        "    omega *= factor",
        "    half *= factor",
        *_discrete_lines("    "),
        *_row_lines(chassis, "    "),
    ]


def _wheel_rows(chassis: "Chassis", i: int) -> tuple[float, ...]:
    """The rows of one wheel in units of its limit, both rows (the second 0 for a fixed wheel)."""
    wheel, row = chassis.wheels[i], chassis.row[i]
    bound = wheel.max_rim_speed if wheel.steered else wheel.max_speed
    first = [float(value) / bound for value in chassis.jacobian[row]]
    second = [float(value) / bound for value in chassis.jacobian[row + 1]] if wheel.steered else [0.0] * 3
    return (*first, *second)


def slow_down(row: tuple[float, ...], vx: float, vy: float, omega: float, half: float, k: float, load: float) -> float:
    """Factor that brings one wheel with `load` > 1 to its limit.

    The wheel's relative speed under discretise(f twist) is f g(f), and g is nearly straight, for it bends only as the
    turn in the tick does: g(f) = |k(f h) P + f h Q + R|, k(x) = x cot x. Each round lays g's tangent and solves the
    quadratic. The same arithmetic as `kernel.slow_down`.

    Args:
        row: both rows of the wheel in units of its limit.
        vx, vy, omega: twist at factor 1.
        half: h, half its turn in the tick [rad]; k: k(h).
        load: g(1).
    """
    ax, ay, aw, bx, by, bw = row
    pa, qa, ra = ax * vx + ay * vy, (ax * vy - ay * vx) * half, aw * omega
    pb, qb, rb = bx * vx + by * vy, (bx * vy - by * vx) * half, bw * omega
    f, h = 1.0, half
    for _ in range(SLOW_DOWN_ROUNDS):
        q = h * h
        slope = half * h * (q * -0.08888888888888889 - 0.6666666666666666) if q < 0.0225 else half * (k - k * k - q) / h
        a, b = k * pa + f * qa + ra, k * pb + f * qb + rb
        g = sqrt(a * a + b * b)
        tilt = (a * (slope * pa + qa) + b * (slope * pb + qb)) / g
        base = g - tilt * f
        root = base * base + tilt * FOUR_GOALS
        guess = TWO_GOALS / (base + sqrt(root)) if root > 0.0 else GOAL / load
        if not 0.0 < guess < 1.0:
            guess = GOAL / load
        step = (guess - f) * half
        f = guess
        if step * step <= TIGHT:
            break
        h = f * half
        q = h * h
        k = 1.0 - q * (1 / 3 + q * (1 / 45 + q * (2 / 945 + q / 4725))) if q < 0.0225 else h * cos(h) / sin(h)
    return f


def _module_lines(chassis: "Chassis") -> list[str]:
    """Steered wheels: shortest turn with hysteresis, hold at rest, steering rate, cosine scaling."""
    if not chassis.steered:
        return []
    count = range(len(chassis.steered))
    pairs = ", ".join(f"(a{i}, b{i}, s{j}, g{j})" for j, i in enumerate(chassis.steered))
    lines = [
        "together = False",
        f"if not ({' and '.join(f'g{j}' for j in count)}):",
        f"    together = joint(({pairs},))",
    ]
    for j, i in enumerate(chassis.steered):
        wheel = chassis.wheels[i]
        lines += _one_module_lines(i, j, 1.0 / wheel.radius, wheel.steer_rate)
    return lines


def _one_module_lines(i: int, j: int, per_radius: float, rate: float) -> list[str]:
    lines = [
        f"turn = atan2(b{i}, a{i}) - s{j}",
        f"if turn > {math.pi!r} or turn < {-math.pi!r}:",
        f"    turn = remainder(turn, {math.tau!r})",
        f"if u{i} < {HOLD_SPEED!r}:",
        f"    w{i}, g{j} = u{i} * cos(turn) * {per_radius!r}, 0.0",
        "else:",
        f"    error = (turn if turn > 0.0 else -turn) - {math.pi / 2!r}",
        f"    if error > g{j} * {HYSTERESIS!r} if g{j} or error * error > {HYSTERESIS**2!r} else together:",
        f"        turn += {-math.pi!r} if turn > 0.0 else {math.pi!r}",
        f"        w{i}, g{j} = u{i} * {-per_radius!r}, -1.0",
        "    else:",
        f"        w{i}, g{j} = u{i} * {per_radius!r}, 1.0",
    ]
    if math.isfinite(rate):
        lines += [
            f"    reach = {rate!r} * dt",
            "    if turn > reach:",
            f"        w{i} *= cos(turn - reach)",
            "        turn = reach",
            "    elif turn < -reach:",
            f"        w{i} *= cos(turn + reach)",
            "        turn = -reach",
        ]
    return [*lines, f"    s{j} += turn"]


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
        if abs(error) <= HYSTERESIS:
            total += error
    return total > 0.0


def _largest(terms: Sequence[str]) -> str:
    return f"max({', '.join(terms)})" if len(terms) > 1 else terms[0]


def _tuple(names: Sequence[str]) -> str:
    return f"({', '.join(names)},)" if names else "()"
