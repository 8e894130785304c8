"""What wheels are expected to make of their commands: a pure delay, then a first-order lag.

    lag dw/dt = c(t - delay) - w

Commands are held for one tick; the model is exact for that. Trackers compare it with what is measured, and take from
it the motion that is still to come of what has been commanded already. The dead time of a wheel that starts or
reverses is left out: on the plant "pwm_map" its knowledge changed the error by less than 0.02 mm.
"""

import math

import numpy as np

from holodrive.kinematics.kernel import N_WHEELS
from holodrive.leaf import leaf
from holodrive.robots.spec import Robot
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

    Where all wheels have encoders the speed loop of the motor board makes them faster, by 1 + kp; else it is what was
    measured of the actuators, or what the motors' library says.
    """
    lag = max(wheel.motor.lag_s for wheel in robot.wheels)
    if all(wheel.encoder is not None for wheel in robot.wheels):
        return lag / (1.0 + robot.speed_loop.kp)
    return lag if robot.pwm_map is None else robot.pwm_map.lag_s


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
    "memory_size",
    "model_step",
    "packed",
    "remember",
    "still_to_come",
]
