"""The inner loop of a cascade: one PID for each wheel on its encoder's speed, around a feed-forward.

A robot's motor board has a speed loop of its own, which lets a wheel keep its speed; this one is an outer trim, which
makes up for what that loop is late: it commands a wheel faster than wanted while the wheel is behind. A wheel without
encoder (its speed is NaN) gets the feed-forward alone.
"""

import math
from typing import NamedTuple

from holodrive import layout
from holodrive.kinematics.kernel import (
    BLOCK,
    MAX_SPEED,
    N_STEER,
    N_WHEELS,
    RADIUS,
    WHEELS,
    command_step,
    saturate_wheels,
)
from holodrive.leaf import leaf

GAINS = 6  # kp, ki, kd, feed-forward, slew, share: numbers at the front of the packed parameters
(KP, KI, KD, FEED, SLEW, SHARE) = range(GAINS)
PER_WHEEL = 4  # memory: integral of the error [rad], command and error of the tick before [rad/s], trim was bounded
_STANDS = 1e-3  # of a wheel's limit


class Gains(NamedTuple):
    """The packed parameters by name.

    Attributes:
        kp: [-]. ki: [1/s]. kd: [s], on the error's change.
        feed_forward: share of the wanted speed that is commanded at once.
        slew_m_s2: fastest change of a command, at the rim; infinite leaves it to the motors.
        share: of a wheel's limit that the trim may add or take; 0 is the feed-forward alone.
    """

    kp: float
    ki: float
    kd: float
    feed_forward: float
    slew_m_s2: float
    share: float


def memory_size(wheels: int) -> int:
    """How many float64 `wheel_pid_step` keeps between ticks; zeros are wheels at rest."""
    return PER_WHEEL * wheels


@leaf
def twist_to_wheels(kin, gains, obs, pipe, memory, command):  # type: ignore[no-untyped-def]
    """The body twist in a command becomes wheel speeds: limits, discretisation, inverse, then the inner loop.

    Args:
        kin: the robot (`kinematics.kernel.arrays`).
        gains: (GAINS,).
        obs: observation, for the encoders and the period.
        pipe: memory of the command step.
        memory: (memory_size(n),) of the inner loop.
        command: twist [m/s, m/s, rad/s] in, wheel speeds [rad/s] and steering angles [rad] out.
    """
    n, m = int(kin[N_WHEELS]), int(kin[N_STEER])
    speeds = command[layout.VALUE : layout.VALUE + n]
    steer = command[layout.COMMAND_STEER : layout.COMMAND_STEER + m]
    # the step reads the whole twist before it writes a speed
    command_step(kin, command[layout.VALUE : layout.VALUE + 3], obs[layout.DT], pipe, speeds, steer)
    measured = obs[layout.WHEEL_SPEED : layout.WHEEL_SPEED + n]
    wheel_pid_step(kin, gains, measured, obs[layout.DT], memory, speeds)


@leaf
def wheel_pid_step(kin, gains, measured, dt, memory, speeds):  # type: ignore[no-untyped-def]
    """One tick of all wheels.

    command = feed * wanted + sat(kp e + ki int e + kd de/dt, share), e = wanted - measured; then all commands are
    scaled by one factor into the wheels' limits, so that the motion keeps its direction, and changed no faster than
    the slew limit, again by one factor for all. An integral grows only while neither its trim nor a command is at a
    limit, or to unwind (anti-windup); a wheel that is told to stand and stands lets it go.

    Args:
        kin: the robot (`kinematics.kernel.arrays`).
        gains: (GAINS,) as `Gains`.
        measured: (n,) encoder speeds [rad/s], NaN without an encoder.
        dt: since the last tick [s].
        memory: (memory_size(n),).
        speeds: (n,) wanted in, commanded out [rad/s]. NaN comes out as NaN.
    """
    n = int(kin[N_WHEELS])
    for i in range(n):
        at, limit = PER_WHEEL * i, kin[WHEELS + BLOCK * i + MAX_SPEED]
        error = speeds[i] - measured[i]
        if speeds[i] == 0.0 and abs(measured[i]) < _STANDS * limit:
            error = memory[at] = 0.0
        speeds[i] = gains[FEED] * speeds[i] + wheel_trim(gains, error, dt, gains[SHARE] * limit, memory, at)
    free = saturate_wheels(kin, speeds) >= 1.0
    for i in range(n):
        at = PER_WHEEL * i
        unwinds = memory[at] * memory[at + 2] < 0.0
        if unwinds or (free and memory[at + 3] == 0.0):
            memory[at] += memory[at + 2] * dt
    slew(kin, gains[SLEW] * dt, memory, speeds)


@leaf
def wheel_trim(gains, error, dt, bound, memory, at):  # type: ignore[no-untyped-def]
    """PID of one wheel's speed error [rad/s], within +-bound; the error and whether the bound held it are remembered.

    No error is known without an encoder, and none of a command that is not finite.
    """
    if not math.isfinite(error):
        memory[at + 2], memory[at + 3] = 0.0, 1.0
        return 0.0
    trim = gains[KP] * error + gains[KI] * memory[at] + gains[KD] * (error - memory[at + 2]) / dt
    memory[at + 2], memory[at + 3] = error, 1.0 if abs(trim) > bound else 0.0
    return min(bound, max(-bound, trim))


@leaf
def slew(kin, reach, memory, speeds):  # type: ignore[no-untyped-def]
    """Let no command change by more than `reach` [m/s of rim], all in the same proportion; remember the commands."""
    n, most, sound = int(kin[N_WHEELS]), 0.0, True
    for i in range(n):
        change = abs(speeds[i] - memory[PER_WHEEL * i + 1])
        most = max(most, change * kin[WHEELS + BLOCK * i + RADIUS])
        sound = sound and math.isfinite(speeds[i])
    share = reach / most if most > reach else 1.0
    if sound:
        for i in range(n):
            at = PER_WHEEL * i + 1
            if share < 1.0:
                speeds[i] = memory[at] + share * (speeds[i] - memory[at])
            memory[at] = speeds[i]


__all__ = ["GAINS", "PER_WHEEL", "Gains", "memory_size", "twist_to_wheels", "wheel_pid_step"]
