"""The command step and the forward map for compiled loops: twins of `pipeline.CommandPipeline` and `Chassis.forward`.

Kernels take the robot as one flat float64 vector, made once by `arrays(robot)`: it travels well inside the packed
parameters of a compiled plug (pass the slice), and one array costs a kernel call far less than ten.

Why it is written as it is (measured, hybrid3 in a compiled loop, 153 ns -> 27 ns a command step): a function with
array arguments has one exit and loops without `break`, or Numba cannot remove its reference counting; branches live
in functions of scalars; `forceinline` for the same reason; `error_model="numpy"` makes x / 0 infinite, as the limits
want it.
"""

import math
from typing import TYPE_CHECKING

import numpy as np
from numba import njit

from holodrive.kinematics import caster_motion
from holodrive.kinematics.chassis import Chassis
from holodrive.kinematics.settings import BAND as FLIP_BAND
from holodrive.kinematics.settings import (
    CASTER_ROUNDS,
    FLIP_SLACK,
    GOAL,
    HOLD_SPEED,
    POWERED,
    SLOW_DOWN_ROUNDS,
    TIGHT,
)
from holodrive.leaf import leaf
from holodrive.types import Array

if TYPE_CHECKING:
    from holodrive.robots.spec import Limits, Robot

KinematicsArrays = Array  # the flat vector; its layout follows

follow = njit(cache=True, error_model="numpy")(caster_motion.follow)
lean = njit(cache=True, error_model="numpy")(caster_motion.lean)
headroom = njit(cache=True, error_model="numpy")(caster_motion.headroom)
time_of_turn = njit(cache=True, error_model="numpy")(caster_motion.time_of_turn)

# header
N_WHEELS, N_STEER, N_ROWS = 0, 1, 2
SPEED, YAW_RATE, ACCEL, YAW_ACCEL = 3, 4, 5, 6  # m/s, rad/s, m/s^2, rad/s^2
HOLD, BAND = 7, 8  # m/s, rad
TRAILS = 9  # 0, or 1 with a caster or a coupling somewhere, or POWERED where modules are driven as powered casters
WHEELS = 10  # first wheel block
# one block for each wheel
STEER_INDEX = 0  # place in steering arrays, -1 for a fixed wheel
RADIUS, MAX_SPEED, STEER_RATE = 1, 2, 3  # m, rad/s, rad/s
RIM = 4  # m/s of rim per unit of its rows
LOAD = 5  # share of the wheel's limit per unit of its rows
ROWS = 6  # 2 x 3: rows of the Jacobian; the second is 0 for a fixed wheel
BACK = 12  # 2 x 3: its columns of the least-squares inverse, each as (vx, vy, omega)
CASTER, COUPLING = 18, 19  # m, 1; 0 for a fixed wheel
WEIGHT = 20  # of the squares of its rows in least squares
BLOCK = 21

# memory of a command step; after the angles [rad] come the drive signs (m)
LAST_TWIST = 0  # of the tick before, in the axes of this one; used by the acceleration limits only
STEER = 3


def arrays(robot: "Robot | Chassis", limits: "Limits | None" = None) -> KinematicsArrays:
    """What the kernels need of a robot (or of a chassis and limits), as one vector."""
    chassis = robot if isinstance(robot, Chassis) else Chassis.of(robot)
    if limits is None and not isinstance(robot, Chassis):
        limits = robot.limits
    kin = np.zeros(WHEELS + BLOCK * len(chassis.wheels))
    kin[: YAW_ACCEL + 1] = [len(chassis.wheels), len(chassis.steered), len(chassis.jacobian), *([math.inf] * 4)]
    if limits is not None:
        kin[SPEED : YAW_ACCEL + 1] = [
            limits.speed_m_s, limits.yaw_rate_rad_s, limits.accel_m_s2, limits.yaw_accel_rad_s2
        ]  # fmt: skip
    kin[HOLD], kin[BAND], kin[TRAILS] = HOLD_SPEED, FLIP_BAND, chassis.trails
    for i, (wheel, row) in enumerate(zip(chassis.wheels, chassis.row, strict=True)):
        block = kin[WHEELS + BLOCK * i :][:BLOCK]
        rim, rows = (1.0, 2) if wheel.steered else (wheel.radius, 1)
        block[STEER_INDEX] = chassis.steered.index(i) if wheel.steered else -1
        block[RADIUS : LOAD + 1] = [wheel.radius, wheel.max_speed, wheel.steer_rate, rim, rim / wheel.max_rim_speed]
        block[ROWS : ROWS + 3 * rows] = chassis.jacobian[row : row + rows].ravel()
        block[BACK : BACK + 3 * rows] = chassis.least_squares[:, row : row + rows].T.ravel()
        block[CASTER], block[COUPLING], block[WEIGHT] = wheel.caster, wheel.coupling, chassis.row_scale[row] ** 2
    return kin


def memory_size(kin: KinematicsArrays) -> int:
    """How many float64 `command_step` keeps between ticks; zeros are a base at rest with wheels at angle 0."""
    return STEER + 2 * int(kin[N_STEER])


@njit(cache=True, error_model="numpy", forceinline=True)
def command_step(kin: Array, twist: Array, dt: float, memory: Array, speeds_out: Array, steer_out: Array) -> float:
    """One tick: limit, accelerate, scale into what the wheels can do, discretise, invert, optimise modules.

    Args:
        kin: the robot.
        twist: (3,) wanted [m/s, m/s, rad/s].
        dt: control period [s].
        memory: (memory_size,) state; the twist of the tick before in the axes of this one, angles, drive signs.
        speeds_out: (n,) [rad/s].
        steer_out: (m,) [rad], not wrapped.

    Returns:
        How much speed limits and wheels scaled the command, 1 when not at all (what acceleration limits took is not
        in it). A twist or period that is not finite, or a period not above 0, gives NaN, here and for every wheel
        speed, so that the gate refuses it; the modules keep their angles.
    """
    wanted_vx, wanted_vy, wanted_omega = twist[0], twist[1], twist[2]
    valid = math.isfinite(wanted_vx + wanted_vy + wanted_omega + dt) and dt > 0.0
    if not valid:
        wanted_vx = wanted_vy = wanted_omega = memory[0] = memory[1] = memory[2] = 0.0
        dt = 1.0  # any sound one: zero times an infinite period would be NaN in the memory
    scale = limit_scale(kin, wanted_vx, wanted_vy, wanted_omega, dt)
    vx, vy, omega = scale * wanted_vx, scale * wanted_vy, scale * wanted_omega
    share = accel_share(kin, memory, vx, vy, omega, dt)
    if share < 1.0:
        vx, vy = memory[0] + share * (vx - memory[0]), memory[1] + share * (vy - memory[1])
        omega = memory[2] + share * (omega - memory[2])
    factor = fit(kin, vx, vy, omega, dt, speeds_out, steer_out)
    if kin[TRAILS] == 0.0:
        drive_modules(kin, dt, memory, speeds_out, steer_out)
    else:
        factor = drive_trailing(kin, vx, vy, omega, dt, factor, memory, speeds_out, steer_out)
    remember(factor * vx, factor * vy, factor * omega, dt, memory)
    if not valid:
        for i in range(int(kin[N_WHEELS])):
            speeds_out[i] = math.nan
    return scale * factor if valid else math.nan


@njit(cache=True, error_model="numpy", forceinline=True)
def limit_scale(kin: Array, vx: float, vy: float, omega: float, dt: float) -> float:
    """Common factor that brings a twist inside the robot's own limits and under half a turn a tick."""
    return float(min(1.0, kin[SPEED] / math.hypot(vx, vy), min(kin[YAW_RATE], math.pi / dt) / abs(omega)))


@njit(cache=True, error_model="numpy", forceinline=True)
def accel_share(kin: Array, memory: Array, vx: float, vy: float, omega: float, dt: float) -> float:
    """How far from the last twist towards the wanted one the acceleration limits let go, all parts alike."""
    change = math.hypot(vx - memory[0], vy - memory[1])
    return float(min(1.0, kin[ACCEL] * dt / change, kin[YAW_ACCEL] * dt / abs(omega - memory[2])))


@njit(cache=True, error_model="numpy", forceinline=True)
def remember(vx: float, vy: float, omega: float, dt: float, memory: Array) -> None:
    """Keep the applied twist in the axes that `base_link` has at the end of the tick, where the next one starts.

    So a base that spins along a straight line does not count as accelerating.
    """
    c, s = math.cos(omega * dt), math.sin(omega * dt)
    memory[0], memory[1], memory[2] = c * vx + s * vy, c * vy - s * vx, omega


@njit(cache=True, error_model="numpy", forceinline=True)
def fit(kin: Array, vx: float, vy: float, omega: float, dt: float, first: Array, second: Array) -> float:
    """Largest factor at most 1 for which the discretised twist is inside every wheel's limit; writes the rows.

    Slows the worst wheel down to its limit, then looks again.
    """
    factor = 1.0
    load = discrete_rows(kin, vx, vy, omega, dt, factor, first, second)
    while load > 1.0:
        b = WHEELS + BLOCK * worst_wheel(kin, load, first, second)
        c, at = kin[b + LOAD] * factor, b + ROWS
        factor *= slow_down(
            c * (kin[at] * vx + kin[at + 1] * vy),
            c * (kin[at] * vy - kin[at + 1] * vx),
            c * kin[at + 2] * omega,
            c * (kin[at + 3] * vx + kin[at + 4] * vy),
            c * (kin[at + 3] * vy - kin[at + 4] * vx),
            c * kin[at + 5] * omega,
            0.5 * omega * dt * factor,
            load,
        )
        load = discrete_rows(kin, vx, vy, omega, dt, factor, first, second)
    return factor


@njit(cache=True, error_model="numpy", forceinline=True)
def worst_wheel(kin: Array, load: float, first: Array, second: Array) -> int:
    """The wheel that has the largest `load`."""
    worst = -1
    for i in range(int(kin[N_WHEELS])):
        b = WHEELS + BLOCK * i
        j = int(kin[b + STEER_INDEX])
        speed = abs(first[i]) if j < 0 else math.sqrt(first[i] * first[i] + second[j] * second[j])
        worst = i if worst < 0 and speed * kin[b + LOAD] >= load else worst
    return worst


@njit(cache=True, error_model="numpy")
def slow_down(pa: float, qa: float, ra: float, pb: float, qb: float, rb: float, half: float, load: float) -> float:
    """Factor that brings one wheel to its limit; `scalar_step.slow_fixed` and `slow_module` say how."""
    f, h = 1.0, half
    for _ in range(SLOW_DOWN_ROUNDS):
        k = half_cotangent(h)
        a, b = k * pa + h * qa + ra, k * pb + h * qb + rb
        g = math.sqrt(a * a + b * b)
        slope = (k - k * k - h * h) / f
        tilt = (a * (slope * pa + half * qa) + b * (slope * pb + half * qb)) / g
        base = g - tilt * f
        root = base * base + 4.0 * tilt * GOAL
        old, f = f, 2.0 * GOAL / (base + math.sqrt(root)) if root > 0.0 else -1.0
        if not 0.0 < f < 1.0:
            f = GOAL / load
        h = f * half
        if ((f - old) * half) ** 2 <= TIGHT:
            break
    return f


@njit(cache=True, error_model="numpy", forceinline=True)
def discrete_rows(
    kin: Array, vx: float, vy: float, omega: float, dt: float, scale: float, first: Array, second: Array
) -> float:
    """J . discretise(scale * twist): wheel speeds into `first`, or the module's velocity into `first`, `second`.

    Returns:
        The largest wheel speed relative to its limit.
    """
    vx, vy, omega = scale * vx, scale * vy, scale * omega
    half = 0.5 * omega * dt
    k = half_cotangent(half)
    vx, vy = k * vx + half * vy, k * vy - half * vx
    worst = 0.0
    for i in range(int(kin[N_WHEELS])):
        b = WHEELS + BLOCK * i
        value = row(kin, b + ROWS, vx, vy, omega)
        first[i] = value
        j = int(kin[b + STEER_INDEX])
        if j < 0:
            load = abs(value) * kin[b + LOAD]
        else:
            across = row(kin, b + ROWS + 3, vx, vy, omega)
            second[j] = across
            load = math.sqrt(value * value + across * across) * kin[b + LOAD]
        worst = max(worst, load)
    return worst


@njit(cache=True, error_model="numpy", forceinline=True)
def row(kin: Array, at: int, vx: float, vy: float, omega: float) -> float:
    """One row of J . twist."""
    return float(kin[at] * vx + kin[at + 1] * vy + kin[at + 2] * omega)


@njit(cache=True, error_model="numpy", forceinline=True)
def half_cotangent(half: float) -> float:
    """h cot(h): how much a straight line shrinks to the chord's twist; 1 without turning."""
    return half / math.tan(half) if half != 0.0 else 1.0


@njit(cache=True, error_model="numpy", forceinline=True)
def drive_modules(kin: Array, dt: float, memory: Array, first: Array, second: Array) -> None:
    """Steered wheels from contact velocities (`first`, `second`) to speeds and angles, see `swerve.drive`."""
    signs = STEER + int(kin[N_STEER])
    flip_together = joint_flip(kin, memory, first, second)
    for i in range(int(kin[N_WHEELS])):
        b = WHEELS + BLOCK * i
        j = int(kin[b + STEER_INDEX])
        if j < 0:
            continue
        now = memory[STEER + j]
        speed, turn = shorter_turn(kin, memory, j, first[i], second[j], flip_together)
        if memory[signs + j] == 0.0:
            first[i], second[j] = speed * math.cos(turn) / kin[b + RADIUS], now
            continue
        reach = kin[b + STEER_RATE] * dt
        if abs(turn) > reach:
            step = reach if turn > 0.0 else -reach
            speed *= math.cos(turn - step)
            turn = step
        first[i], second[j], memory[STEER + j] = speed / kin[b + RADIUS], now + turn, now + turn


@njit(cache=True, error_model="numpy", forceinline=True)
def shorter_turn(
    kin: Array, memory: Array, j: int, along: float, across: float, flip_together: bool
) -> tuple[float, float]:
    """Signed speed [m/s] of a module and how far it turns for it [rad]; its drive sign is remembered, 0 at rest."""
    sign = STEER + int(kin[N_STEER]) + j
    speed = math.sqrt(along * along + across * across)
    turn = float(wrap(math.atan2(across, along) - memory[STEER + j]))
    if speed < kin[HOLD]:
        memory[sign] = 0.0
        return speed, turn
    if flips(turn, memory[sign], flip_together, kin[BAND]):
        turn += -math.pi if turn > 0.0 else math.pi
        speed = -speed
    memory[sign] = -1.0 if speed < 0.0 else 1.0
    return speed, turn


@njit(cache=True, error_model="numpy", forceinline=True)
def flips(turn: float, sign: float, flip_together: bool, band: float) -> bool:
    """Whether a module drives backwards: above 90 degrees, later or sooner by what it did before."""
    error = abs(turn) - 0.5 * math.pi
    if sign == 0.0 and abs(error) <= band:
        return flip_together
    return error > sign * band


@njit(cache=True, error_model="numpy", forceinline=True)
def joint_flip(kin: Array, memory: Array, first: Array, second: Array) -> bool:
    """Modules at rest that stand about square to their goal flip all or none: whichever turns less in sum."""
    m = int(kin[N_STEER])
    total = 0.0
    for i in range(int(kin[N_WHEELS])):
        j = int(kin[WHEELS + BLOCK * i + STEER_INDEX])
        if j < 0 or memory[STEER + m + j] != 0.0:
            continue
        along, across = first[i], second[j]
        if along * along + across * across < kin[HOLD] * kin[HOLD]:
            continue
        error = abs(wrap(math.atan2(across, along) - memory[STEER + j])) - 0.5 * math.pi
        if abs(error) <= kin[BAND]:
            total += error
    return total > FLIP_SLACK


@njit(cache=True, error_model="numpy", forceinline=True)
def wrap(angle: float) -> float:
    """Angle [rad] in (-pi, pi]; one in range stays as it is to the last bit."""
    turns = np.round(angle / (2.0 * math.pi))
    rest = angle - 2.0 * math.pi * turns if turns != 0.0 else angle
    # rounding may leave it outside by some last digits
    if rest > math.pi:
        return float(rest - 2.0 * math.pi)
    return float(rest + 2.0 * math.pi) if rest <= -math.pi else float(rest)


@njit(cache=True, error_model="numpy", forceinline=True)
def saturate_wheels(kin: Array, speeds: Array) -> float:
    """Scale wheel speeds (n,) in place by one common factor into their limits; give the factor."""
    n = int(kin[N_WHEELS])
    worst = 1.0
    for i in range(n):
        worst = max(worst, abs(speeds[i]) / kin[WHEELS + BLOCK * i + MAX_SPEED])
    if worst > 1.0:
        for i in range(n):
            speeds[i] /= worst
    return 1.0 / worst


@njit(cache=True, error_model="numpy", forceinline=True)
def forward_step(kin: Array, speeds: Array, steer: Array, twist_out: Array) -> float:
    """Least-squares twist (3,) of wheel speeds (n,) [rad/s] and steering angles (m,) [rad], without casters.

    Returns:
        Slip: root mean square over the rows of what the wheels contradict each other in [m/s of rim]; 0 for three
        rows, which cannot contradict each other.
    """
    vx = vy = omega = 0.0
    for i in range(int(kin[N_WHEELS])):
        b = WHEELS + BLOCK * i
        j = int(kin[b + STEER_INDEX])
        along = speeds[i]
        if j >= 0:
            rim = along * kin[b + RADIUS]
            along, across = rim * math.cos(steer[j]), rim * math.sin(steer[j])
            vx += kin[b + BACK + 3] * across
            vy += kin[b + BACK + 4] * across
            omega += kin[b + BACK + 5] * across
        vx += kin[b + BACK] * along
        vy += kin[b + BACK + 1] * along
        omega += kin[b + BACK + 2] * along
    twist_out[0], twist_out[1], twist_out[2] = vx, vy, omega
    if kin[N_ROWS] == 3.0:
        return 0.0
    return slip(kin, speeds, steer, vx, vy, omega)


@njit(cache=True, error_model="numpy", forceinline=True)
def slip(kin: Array, speeds: Array, steer: Array, vx: float, vy: float, omega: float) -> float:
    """Root mean square over the rows of measured minus explained wheel motion [m/s of rim]."""
    total = 0.0
    for i in range(int(kin[N_WHEELS])):
        b = WHEELS + BLOCK * i
        j = int(kin[b + STEER_INDEX])
        along = row(kin, b + ROWS, vx, vy, omega)
        if j < 0:
            total += ((speeds[i] - along) * kin[b + RIM]) ** 2
        else:
            rim = speeds[i] * kin[b + RADIUS]
            across = row(kin, b + ROWS + 3, vx, vy, omega)
            total += (rim * math.cos(steer[j]) - along) ** 2 + (rim * math.sin(steer[j]) - across) ** 2
    return math.sqrt(total / kin[N_ROWS])


@leaf
def drive_trailing(kin, vx, vy, omega, dt, factor, memory, first, second):  # type: ignore[no-untyped-def]
    """Modules with casters or couplings, after `fit` has given `factor`; gives what is left of it."""
    if kin[TRAILS] == POWERED:
        factor = fit_casters(kin, vx, vy, omega, dt, factor, memory, first, second)
        drive_casters(kin, factor * omega, dt, memory, first, second)
        return factor
    return factor * drive_leaning(kin, factor * vx, factor * vy, factor * omega, dt, memory, first, second)


@leaf
def drive_leaning(kin, vx, vy, omega, dt, memory, first, second):  # type: ignore[no-untyped-def]
    """`drive_modules` with short casters, which lean against side slip, and with couplings.

    Gives the factor by which all wheels were slowed down where a drive that makes up for its coupling has no more left.
    """
    signs, share = STEER + int(kin[N_STEER]), 1.0
    flip_together = joint_flip(kin, memory, first, second)
    for i in range(int(kin[N_WHEELS])):
        b = WHEELS + BLOCK * i
        j = int(kin[b + STEER_INDEX])
        if j < 0:
            continue
        now = memory[STEER + j]
        speed, turn = shorter_turn(kin, memory, j, first[i], second[j], flip_together)
        if memory[signs + j] == 0.0:
            first[i], second[j] = speed * math.cos(turn) / kin[b + RADIUS], now
            continue
        reach = kin[b + STEER_RATE] * dt
        if kin[b + CASTER] != 0.0:
            goal = turn
            turn -= memory[signs + j] * lean_of(kin, b, vx, vy, omega, dt, memory)
            reach = min(reach, 0.5 * math.pi + kin[BAND])
            turn = min(reach, max(-reach, turn))
            speed *= math.cos(goal - turn)
        elif abs(turn) > reach:
            step = reach if turn > 0.0 else -reach
            speed *= math.cos(turn - step)
            turn = step
        first[i], second[j], memory[STEER + j] = speed / kin[b + RADIUS], now + turn, now + turn
        if kin[b + COUPLING] != 0.0:
            share = min(share, headroom(first[i], kin[b + COUPLING] * turn / dt, kin[b + MAX_SPEED]))
    if share < 1.0:
        for i in range(int(kin[N_WHEELS])):
            first[i] *= share
    return share


@leaf
def lean_of(kin, b, vx, vy, omega, dt, memory):  # type: ignore[no-untyped-def]
    """`caster_motion.lean` of the wheel whose block begins at `b`."""
    at, w = b + ROWS, memory[LAST_TWIST + 2]
    c, s = math.cos(w * dt), math.sin(w * dt)  # back into the axes of the tick before
    x, y = c * memory[LAST_TWIST] - s * memory[LAST_TWIST + 1], s * memory[LAST_TWIST] + c * memory[LAST_TWIST + 1]
    along, across = row(kin, at, vx, vy, omega), row(kin, at + 3, vx, vy, omega)
    return float(lean(along, across, row(kin, at, x, y, w), row(kin, at + 3, x, y, w), omega, kin[b + CASTER], dt))


@leaf
def fit_casters(kin, vx, vy, omega, dt, factor, memory, first, second):  # type: ignore[no-untyped-def]
    """Factor at most `factor` at which no powered caster steers or drives faster than it can; writes the rows."""
    share, rounds = caster_share(kin, factor * omega, dt, memory, first, second), 0
    while share < 1.0 and rounds < CASTER_ROUNDS:
        factor *= GOAL * share
        discrete_rows(kin, vx, vy, omega, dt, factor, first, second)
        share, rounds = caster_share(kin, factor * omega, dt, memory, first, second), rounds + 1
    return factor


@leaf
def caster_share(kin, omega, dt, memory, first, second):  # type: ignore[no-untyped-def]
    """Share at most 1 of the twist that lets every powered caster keep to its limits."""
    share = 1.0
    for i in range(int(kin[N_WHEELS])):
        b = WHEELS + BLOCK * i
        j = int(kin[b + STEER_INDEX])
        if j >= 0:
            c, s = math.cos(memory[STEER + j]), math.sin(memory[STEER + j])
            along, across = c * first[i] + s * second[j], c * second[j] - s * first[i]
            turn, way = follow(along, across, omega, kin[b + CASTER], dt)
            reach = kin[b + STEER_RATE] * dt
            if abs(turn) > reach:
                share = min(share, time_of_turn(along, across, omega, kin[b + CASTER], turn, reach, dt) / dt)
            drive = abs(way / kin[b + RADIUS] + kin[b + COUPLING] * turn) / dt
            if drive > kin[b + MAX_SPEED]:
                share = min(share, kin[b + MAX_SPEED] / drive)
    return share


@leaf
def drive_casters(kin, omega, dt, memory, first, second):  # type: ignore[no-untyped-def]
    """Powered casters from velocities of their axes (`first`, `second`) to speeds and angles."""
    for i in range(int(kin[N_WHEELS])):
        b = WHEELS + BLOCK * i
        j = int(kin[b + STEER_INDEX])
        if j >= 0:
            now = memory[STEER + j]
            c, s = math.cos(now), math.sin(now)
            turn, way = follow(c * first[i] + s * second[j], c * second[j] - s * first[i], omega, kin[b + CASTER], dt)
            memory[STEER + j] = second[j] = now + turn
            memory[STEER + int(kin[N_STEER]) + j] = 1.0 if way > 0.0 else (-1.0 if way < 0.0 else 0.0)
            first[i] = way / (kin[b + RADIUS] * dt)
