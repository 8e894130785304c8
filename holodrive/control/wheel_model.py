"""What wheels are expected to make of their commands: a pure delay, then a first-order lag.

    lag dw/dt = c(t - delay) - w

Commands are held for one tick; the model is exact for that. Trackers compare it with what is measured, and take from
it the motion that is still to come of what has been commanded already. The dead time of a wheel that starts or
reverses is left out: on the plant "pwm_map" its knowledge changed the error by less than 0.02 mm.
"""

import math

import numpy as np

from holodrive import layout
from holodrive.kinematics.kernel import N_WHEELS
from holodrive.leaf import leaf
from holodrive.robots.spec import Robot, WheelSpec
from holodrive.types import Array

MODEL = 3  # packed parameters: lag [s], delay [s], room of the memory for commands [ticks]
(LAG, DELAY, ROOM) = range(MODEL)
PER_WHEEL = 2  # memory: speed now, mean over the last tick [rad/s]; after all wheels the commands, the newest first
(SPEED, MEAN) = range(PER_WHEEL)


def packed(robot: Robot, lag_s: float | None, delay_s: float) -> Array:
    """The parameters of the model; a lag of None is the one that the robot's file tells, see `lag_of`."""
    lag = lag_of(robot) if lag_s is None else lag_s
    return np.array([lag, delay_s, room(robot, delay_s)])


def room(robot: Robot, delay_s: float) -> int:
    """How many ticks back a command may be that still acts."""
    return math.ceil(delay_s / robot.control_period_s - 1e-9) + 1


def memory_size(robot: Robot, delay_s: float) -> int:
    """How many float64 `model_step` keeps; zeros are wheels at rest."""
    return len(robot.wheels) * (PER_WHEEL + room(robot, delay_s))


def lag_of(robot: Robot) -> float:
    """Time constant [s] of the wheels, the slowest one's.

    It is what was measured of the actuators, if anybody did; else what the motors' library says, or what the mass
    that a wheel moves makes of its motor, whichever is slower: a lag that is taken too long costs speed, one that is
    taken too short costs stability. The speed loop of the motor board makes wheels with encoders faster, by 1 + kp.
    """
    if robot.pwm_map is not None:
        lag = robot.pwm_map.lag_s
    else:
        share_kg = robot.mass_kg / len(robot.wheels)
        lag = max(max(wheel.motor.lag_s, _mechanical_lag(wheel, share_kg)) for wheel in robot.wheels)
    looped = all(wheel.encoder is not None for wheel in robot.wheels)
    return lag / (1.0 + robot.speed_loop.kp) if looped else lag


def _mechanical_lag(wheel: WheelSpec, mass_kg: float) -> float:
    """Time constant [s] of a DC motor that moves its own inertia and a mass by its wheel: J R / K^2."""
    motor = wheel.motor
    inertia = motor.inertia_kg_m2 + mass_kg * wheel.radius**2
    return inertia * motor.resistance_ohm / (motor.efficiency * motor.back_emf_v_s_rad**2)


@leaf
def model_step(kin, model, dt, memory):  # type: ignore[no-untyped-def]
    """Let the wheels of the model turn for the tick that has just passed.

    Args:
        kin: the robot (`kinematics.kernel.arrays`).
        model: (MODEL,) parameters.
        dt: length of the tick [s].
        memory: of the model.
    """
    n, behind = int(kin[N_WHEELS]), model[DELAY] / dt
    newest = min(int(behind), int(model[ROOM]) - 1)
    older = min(newest + 1, int(model[ROOM]) - 1)
    share = behind - newest
    for i in range(n):
        at, sent = PER_WHEEL * i, PER_WHEEL * n + i
        # a delay of part of a tick: part of the tick the older command acts
        target = (1.0 - share) * memory[sent + newest * n] + share * memory[sent + older * n]
        memory[at + SPEED], angle = lagged(memory[at + SPEED], target, model[LAG], dt)
        memory[at + MEAN] = angle / dt


@leaf
def lagged(speed, target, lag, time):  # type: ignore[no-untyped-def]
    """Speed after `time` [s] of following `target` with a lag, and the angle turned meanwhile."""
    if not lag > 0.0:
        return target, target * time
    gap = (speed - target) * -math.expm1(-time / lag)
    return speed - gap, target * time + lag * gap


@leaf
def measured_twist(obs, last, twist):  # type: ignore[no-untyped-def]
    """Mean body twist of the tick that has passed, by the believed poses at its ends; the pose is kept for the next.

    The estimate's own twist is no measure for a model: estimators filter it, each in its own way.

    Args:
        obs: observation.
        last: (3,) believed pose at the tick before; the present one afterwards.
        twist: (3,) out [m/s, m/s, rad/s].
    """
    dt, p = obs[layout.DT], layout.POSE
    dx, dy, turn = obs[p] - last[0], obs[p + 1] - last[1], obs[p + 2] - last[2]
    half = 0.5 * turn
    # the chord of an arc points half the turn ahead, and is shorter than the arc
    stretch = half / math.sin(half) / dt if half != 0.0 else 1.0 / dt
    c, s = math.cos(last[2] + half), math.sin(last[2] + half)
    twist[0], twist[1], twist[2] = stretch * (c * dx + s * dy), stretch * (c * dy - s * dx), turn / dt
    for i in range(3):
        last[i] = obs[p + i]


@leaf
def remember(kin, model, speeds, memory):  # type: ignore[no-untyped-def]
    """Keep the commands (n,) of the tick that begins [rad/s]; those that are not finite count as none."""
    n = int(kin[N_WHEELS])
    first = PER_WHEEL * n
    for k in range(int(model[ROOM]) - 1, 0, -1):
        for i in range(n):
            memory[first + k * n + i] = memory[first + (k - 1) * n + i]
    for i in range(n):
        memory[first + i] = speeds[i] if math.isfinite(speeds[i]) else 0.0


@leaf
def still_to_come(kin, model, dt, memory, out):  # type: ignore[no-untyped-def]
    """Angles (n,) [rad] that the wheels would still turn were they told to stand from now on."""
    n, behind = int(kin[N_WHEELS]), model[DELAY] / dt
    for i in range(n):
        angle = model[LAG] * memory[PER_WHEEL * i + SPEED]
        for k in range(int(model[ROOM]) - 1):
            angle += memory[PER_WHEEL * n + k * n + i] * dt * min(1.0, max(0.0, behind - k))
        out[i] = angle


__all__ = [
    "MODEL",
    "PER_WHEEL",
    "lag_of",
    "lagged",
    "measured_twist",
    "memory_size",
    "model_step",
    "packed",
    "remember",
    "still_to_come",
]
