"""Tracker by feed-forward with lead, PI on the pose and a PI on the speed of each wheel.

    u   = feed-forward with lead + PI on the pose to come           (`pose_loop`)
    w   = limits, discretisation, inverse kinematics of u           what each wheel shall do
    c_i = w_i + kp (n_i - m_i) + I_i                                n: nominal wheel that follows w with lag and delay
    I_i' = ki (n_i - m_i)                                           m: the wheel as it is measured

A wheel with an encoder is measured by it; one without, by the estimate's motion through the inverse kinematics. The
error is taken from the nominal wheel, not from w, so that a wheel which lags as it should is left alone. What is wrong
with an actuator (a linearizer for another voltage, friction) turns its sign with the wheel and differs between
directions, so each wheel has an integral for each direction; the first time round it begins as the mirror of the other.
"""

import math
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from holodrive import layout
from holodrive.control import pose_loop, wheel_model
from holodrive.control.parameters import checked
from holodrive.control.pose_loop import pose_loop as outer_loop
from holodrive.control.standstill import hold_still
from holodrive.interfaces import CommandKind
from holodrive.kinematics import kernel as kinematics
from holodrive.kinematics.kernel import (
    BLOCK,
    MAX_SPEED,
    N_STEER,
    N_WHEELS,
    RADIUS,
    ROWS,
    STEER_INDEX,
    WHEELS,
    command_step,
    forward_step,
    row,
    saturate_wheels,
)
from holodrive.leaf import leaf
from holodrive.robots.spec import Robot
from holodrive.types import Array

# packed parameters: pose loop, wheel model, wheels' kp [-], ki [1/s], filter [s], shares of trim and start, kinematics
_MODEL = pose_loop.LOOP
_WHEEL_KP = _MODEL + wheel_model.MODEL
(_WHEEL_KI, _FILTER, _SHARE, _STILL, _KIN) = range(_WHEEL_KP + 1, _WHEEL_KP + 6)
# memory: pose loop, ticks so far, displacement to come, poses, command step, scratch (n), ways of the wheels (n),
# wheels, wheel model
_TICKS = pose_loop.MEMORY
_AHEAD = _TICKS + 1
_TWIST = _AHEAD + 3  # measured
_LAST = _TWIST + 3  # pose at the tick before
_PIPE = _LAST + 3
# of one wheel: integrals forward and backward [rad/s], whether each has begun, nominal and measured speed, filtered
PER_WHEEL = 6
(_BEGUN, _NOMINAL, _MEASURED) = (2, 4, 5)

# where to look for good values (`holodrive tune`)
BOUNDS: dict[str, tuple[float, float] | tuple[float, float, str]] = {
    "kp": (1.0, 30.0, "log"),
    "kp_theta": (1.0, 30.0, "log"),
    "ki": (0.0, 10.0),
    "ki_theta": (0.0, 10.0),
    "wheel_kp": (0.0, 3.0),
    "wheel_ki": (0.0, 30.0),
}


@leaf
def ff_pi_kernel(obs, memory, params, command):  # type: ignore[no-untyped-def]
    """One tick; see the module's text and `FfPi.pack`."""
    kin, model = params[_KIN:], params[_MODEL:_WHEEL_KP]
    n, m, dt = int(kin[N_WHEELS]), int(kin[N_STEER]), obs[layout.DT]
    angles_at = _PIPE + kinematics.STEER + 2 * m
    wheels_at = angles_at + 2 * n
    pipe, angles, ways = memory[_PIPE:angles_at], memory[angles_at : angles_at + n], memory[angles_at + n : wheels_at]
    wheels, state = memory[wheels_at : wheels_at + PER_WHEEL * n], memory[wheels_at + PER_WHEEL * n :]
    steer_now, ahead = obs[layout.STEER : layout.STEER + m], memory[_AHEAD:_TWIST]
    twist = memory[_TWIST:_LAST]
    wheel_model.measured_twist(obs, memory[_LAST:_PIPE], twist)
    if memory[_TICKS] > 0.0:
        wheel_model.model_step(kin, model, dt, state)
        measure(kin, params[_FILTER], obs, twist, state, wheels)
    else:
        for j in range(m):
            pipe[kinematics.STEER + j] = steer_now[j]
    memory[_TICKS] += 1.0
    wheel_model.still_to_come(kin, model, dt, state, angles)
    forward_step(kin, angles, steer_now, ahead)
    rests = outer_loop(obs, params[:_MODEL], model[:2], ahead, memory[: pose_loop.MEMORY], command)
    want = command[layout.VALUE : layout.VALUE + 3]
    if rests:
        want[0] = want[1] = want[2] = 0.0
    speeds = command[layout.VALUE : layout.VALUE + n]
    steer = command[layout.COMMAND_STEER : layout.COMMAND_STEER + m]
    scale = command_step(kin, want, dt, pipe, speeds, steer)
    wheel_model.remember(kin, model, speeds, state)
    free = trim_wheels(kin, params[_WHEEL_KP:_KIN], dt, wheels, speeds)
    hold_still(kin, params[_STILL], ways, speeds)
    pose_loop.integrate(free and scale >= 1.0 and not rests, dt, memory)


@leaf
def measure(kin, filter_s, obs, twist, state, wheels):  # type: ignore[no-untyped-def]
    """Nominal and measured speed of each wheel over the tick that has passed, through the same low-pass."""
    new = -math.expm1(-obs[layout.DT] / filter_s) if filter_s > 0.0 else 1.0
    for i in range(int(kin[N_WHEELS])):
        at, encoder = PER_WHEEL * i, obs[layout.WHEEL_SPEED + i]
        nominal = state[wheel_model.PER_WHEEL * i + wheel_model.MEAN]
        wheels[at + _NOMINAL] += new * (nominal - wheels[at + _NOMINAL])
        if not math.isnan(encoder):
            wheels[at + _MEASURED] = encoder  # the motor board has filtered it
            continue
        change = speed_of_wheel(kin, i, obs, twist) - wheels[at + _MEASURED]
        if math.isfinite(change):
            wheels[at + _MEASURED] += new * change


@leaf
def speed_of_wheel(kin, i, obs, twist):  # type: ignore[no-untyped-def]
    """Speed [rad/s] of a wheel by the body's twist (3,), through the inverse kinematics."""
    b = WHEELS + BLOCK * i
    along = row(kin, b + ROWS, twist[0], twist[1], twist[2])
    j = int(kin[b + STEER_INDEX])
    if j < 0:
        return along
    across, angle = row(kin, b + ROWS + 3, twist[0], twist[1], twist[2]), obs[layout.STEER + j]
    return (math.cos(angle) * along + math.sin(angle) * across) / kin[b + RADIUS]


@leaf
def trim_wheels(kin, gains, dt, wheels, speeds):  # type: ignore[no-untyped-def]
    """PI of all wheels on top of the wanted speeds, then one common factor into their limits.

    Args:
        kin: the robot.
        gains: kp, ki, filter, share of a wheel's limit that a trim may have.
        dt: length of a tick [s].
        wheels: (PER_WHEEL n,) memory.
        speeds: (n,) wanted in, commanded out [rad/s]; a wheel that shall stand gets nothing.

    Returns:
        Whether no wheel was at its limit.
    """
    n = int(kin[N_WHEELS])
    for i in range(n):
        error = wheels[PER_WHEEL * i + _NOMINAL] - wheels[PER_WHEEL * i + _MEASURED]
        bound = gains[3] * kin[WHEELS + BLOCK * i + MAX_SPEED]
        if speeds[i] != 0.0 and math.isfinite(error):
            at = integral_of(wheels, PER_WHEEL * i, speeds[i])
            trim = gains[0] * error + wheels[at]
            speeds[i] += min(bound, max(-bound, trim))
    free = saturate_wheels(kin, speeds) >= 1.0
    for i in range(n):
        error = wheels[PER_WHEEL * i + _NOMINAL] - wheels[PER_WHEEL * i + _MEASURED]
        bound = gains[3] * kin[WHEELS + BLOCK * i + MAX_SPEED]
        # the error is of the way in which the nominal wheel turned
        at = integral_of(wheels, PER_WHEEL * i, wheels[PER_WHEEL * i + _NOMINAL])
        if math.isfinite(error) and (free or error * wheels[at] < 0.0):
            wheels[at] = min(bound, max(-bound, wheels[at] + gains[1] * error * dt))
    return free


@leaf
def integral_of(wheels, at, speed):  # type: ignore[no-untyped-def]
    """Where a wheel's integral for the direction of `speed` lies; one that has not begun mirrors the other."""
    here, other = (at, at + 1) if speed >= 0.0 else (at + 1, at)
    if wheels[here + _BEGUN] == 0.0:
        wheels[here], wheels[here + _BEGUN] = -wheels[other], 1.0
    return here


@dataclass(frozen=True)
class FfPi:
    """Pose tracker by feed-forward, PI on the pose and PI on each wheel; commands wheel speeds.

    Attributes:
        kp, kp_theta: of the pose to come [1/s].
        ki, ki_theta: of the pose [1/s^2]; takes what no wheel knows of, such as a wrong radius.
        wheel_kp: of each wheel's speed [-].
        wheel_ki: [1/s].
        wheel_filter_s: low-pass of the speed by the estimate's motion, for wheels without encoder, and of the nominal
            speed beside it; None takes that of the motor board's encoder speed.
        wheel_share: of a wheel's limit that its trim may add or take.
        still_m_s: rim speed that it takes to start a wheel, see `standstill`; 0 starts it for anything.
        lag_s: of the wheels; None takes what the robot's file tells (`wheel_model.lag_of`).
        delay_s: from a command to its beginning to act, beside the tick for which it holds.
        max_speed_m_s, max_yaw_rate_rad_s: of the command; infinite takes what the slowest wheel's rim can do.
        arrive_m, arrive_rad: how near is there.
        rest_m, rest_rad: how near the wheels are let alone at a reference that rests; three times that wakes them.
    """

    kp: float = 5.0
    kp_theta: float = 5.0
    ki: float = 0.5
    ki_theta: float = 0.5
    wheel_kp: float = 0.5
    wheel_ki: float = 5.0
    wheel_filter_s: float | None = None
    wheel_share: float = 0.5
    still_m_s: float = 0.001
    lag_s: float | None = None
    delay_s: float = 0.0
    max_speed_m_s: float = math.inf
    max_yaw_rate_rad_s: float = math.inf
    arrive_m: float = 0.02
    arrive_rad: float = math.radians(2.0)
    rest_m: float = 1e-4
    rest_rad: float = 1e-3

    command_kind: ClassVar[CommandKind] = "wheels"
    kernel: ClassVar[Any] = staticmethod(ff_pi_kernel)

    def __post_init__(self) -> None:
        checked(
            self,
            positive=("kp", "kp_theta", "max_speed_m_s", "max_yaw_rate_rad_s", "arrive_m", "arrive_rad"),
            not_negative=(
                "ki", "ki_theta", "wheel_kp", "wheel_ki", "wheel_filter_s", "wheel_share", "still_m_s",
                "lag_s", "delay_s", "rest_m", "rest_rad",
            ),
        )  # fmt: skip

    def memory_size(self, robot: Robot) -> int:
        """Pose loop, command step, wheels, wheel model."""
        pipe = kinematics.memory_size(kinematics.arrays(robot))
        wheels = (2 + PER_WHEEL) * len(robot.wheels)
        return _PIPE + pipe + wheels + wheel_model.memory_size(robot, self.delay_s)

    def pack(self, robot: Robot) -> Array:
        """As the index constants of this module say."""
        loop = pose_loop.packed(
            robot, (self.kp, self.kp_theta, self.ki, self.ki_theta), self.max_speed_m_s, self.max_yaw_rate_rad_s,
            (self.arrive_m, self.arrive_rad), (self.rest_m, self.rest_rad),
        )  # fmt: skip
        model = wheel_model.packed(robot, self.lag_s, self.delay_s)
        filter_s = robot.speed_loop.filter_s if self.wheel_filter_s is None else self.wheel_filter_s
        gains = [self.wheel_kp, self.wheel_ki, filter_s, self.wheel_share, self.still_m_s]
        return np.concatenate([loop, model, gains, kinematics.arrays(robot)])
