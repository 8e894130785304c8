"""Tracker with a disturbance observer on the body twist.

    e  = v - v_n                    v measured, v_n that of the nominal wheels (delay, lag) for what was sent
    d' = (e - d) / q                the disturbance, as the twist that it adds
    u  = feed-forward with lead + PI on the pose - d

For linear wheels P_n = 1 / (1 + lag s) this is the usual d = Q (P_n^-1 v - u) with the low-pass
Q = 1 / ((1 + q s) (1 + lag s)) (K. Ohnishi, M. Shibata and T. Murakami, Motion control for advanced mechatronics,
IEEE/ASME Trans. Mechatronics 1, 1996), written so that nothing is differentiated, counts of a sensor least of all, and
that it holds for the wheels' limits as well. In the nominal case it does nothing at all.
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
from holodrive.kinematics.kernel import N_STEER, N_WHEELS, command_step, forward_step
from holodrive.leaf import leaf
from holodrive.robots.spec import Robot
from holodrive.types import Array

# packed parameters: pose loop, wheel model, low-pass (2) [s], bound of the estimate (2), threshold of standing wheels,
# kinematics
_MODEL = pose_loop.LOOP
_Q = _MODEL + wheel_model.MODEL
_BOUND = _Q + 2  # m/s, rad/s
_STILL = _BOUND + 2
_KIN = _STILL + 1
# memory: pose loop, ticks so far, disturbance, displacement to come, poses, command step, scratch (n), ways of the
# wheels (n), wheel model
_TICKS = pose_loop.MEMORY
DISTURBANCE = _TICKS + 1  # m/s, m/s, rad/s
AHEAD = DISTURBANCE + 3
_TWIST = AHEAD + 3  # measured
_LAST = _TWIST + 3  # pose at the tick before
_PIPE = _LAST + 3

# where to look for good values (`holodrive tune`)
BOUNDS: dict[str, tuple[float, float] | tuple[float, float, str]] = {
    "kp": (1.0, 30.0, "log"),
    "kp_theta": (1.0, 30.0, "log"),
    "ki": (0.0, 10.0),
    "ki_theta": (0.0, 10.0),
    "q_s": (0.02, 1.0, "log"),
    "q_theta_s": (0.02, 1.0, "log"),
}


@leaf
def observe(expected, measured, q, bound, dt, disturbance):  # type: ignore[no-untyped-def]
    """One tick of the observer.

    Args:
        expected, measured: (3,) mean twists of the tick that has passed [m/s, m/s, rad/s]; NaN changes nothing.
        q: (2,) time constants of the low-pass, for moving and for turning [s].
        bound: (2,) the most that is believed [m/s, rad/s].
        dt: length of the tick [s].
        disturbance: (3,) in and out [m/s, m/s, rad/s].
    """
    for i in range(3):
        new = -math.expm1(-dt / (q[1] if i == 2 else q[0]))
        residual = measured[i] - expected[i]
        if math.isfinite(residual):
            most = bound[1] if i == 2 else bound[0]
            disturbance[i] = min(most, max(-most, disturbance[i] + new * (residual - disturbance[i])))


@leaf
def dob_kernel(obs, memory, params, command):  # type: ignore[no-untyped-def]
    """One tick; see the module's text and `Dob.pack`."""
    foresee(obs, memory, params)
    rests = wanted(obs, memory, params, command)
    free = to_wheels(obs, memory, params, command)
    pose_loop.integrate(free and not rests, obs[layout.DT], memory)


@leaf
def wanted(obs, memory, params, command):  # type: ignore[no-untyped-def]
    """The body twist to command, by the pose loop and less the disturbance; whether it is none, for the base rests."""
    lead, ahead = params[_MODEL:_Q], memory[AHEAD:_TWIST]
    rests = outer_loop(obs, params[:_MODEL], lead, ahead, memory[: pose_loop.MEMORY], command)
    for i in range(3):
        command[i] = 0.0 if rests else command[i] - memory[DISTURBANCE + i]
    return rests


@leaf
def foresee(obs, memory, params):  # type: ignore[no-untyped-def]
    """Look back on the last tick, and ahead: what disturbs, and the displacement that is still to come.

    Args:
        obs: observation.
        memory, params: of `Dob`; `memory[DISTURBANCE:]` (3) and `memory[AHEAD:]` (3) are written, body axes.
    """
    kin, model = params[_KIN:], params[_MODEL:_Q]
    n, m, dt = int(kin[N_WHEELS]), int(kin[N_STEER]), obs[layout.DT]
    wheels = _PIPE + kinematics.STEER + 2 * m
    angles, state, ahead = memory[wheels : wheels + n], memory[wheels + 2 * n :], memory[AHEAD:_TWIST]
    steer, lag, measured = obs[layout.STEER : layout.STEER + m], model[wheel_model.LAG], memory[_TWIST:_LAST]
    wheel_model.measured_twist(obs, memory[_LAST:_PIPE], measured)
    if memory[_TICKS] > 0.0:
        wheel_model.model_step(kin, model, dt, state)
        for i in range(n):
            angles[i] = state[wheel_model.PER_WHEEL * i + wheel_model.MEAN]
        forward_step(kin, angles, steer, ahead)
        observe(ahead, measured, params[_Q:_BOUND], params[_BOUND:_STILL], dt, memory[DISTURBANCE:AHEAD])
    else:
        for j in range(m):
            memory[_PIPE + kinematics.STEER + j] = steer[j]
    memory[_TICKS] += 1.0
    wheel_model.still_to_come(kin, model, dt, state, angles)
    forward_step(kin, angles, steer, ahead)
    for i in range(3):
        ahead[i] += (lag + model[wheel_model.DELAY]) * memory[DISTURBANCE + i]


@leaf
def to_wheels(obs, memory, params, command):  # type: ignore[no-untyped-def]
    """The body twist in a command becomes wheel speeds, and is kept for the wheels' model.

    Returns:
        Whether no limit took any of it.
    """
    kin, model, dt = params[_KIN:], params[_MODEL:_Q], obs[layout.DT]
    n, m = int(kin[N_WHEELS]), int(kin[N_STEER])
    wheels = _PIPE + kinematics.STEER + 2 * m
    ways, state = memory[wheels + n : wheels + 2 * n], memory[wheels + 2 * n :]
    speeds = command[layout.VALUE : layout.VALUE + n]
    steer = command[layout.COMMAND_STEER : layout.COMMAND_STEER + m]
    # the step reads the whole twist before it writes a speed
    scale = command_step(kin, command[layout.VALUE : layout.VALUE + 3], dt, memory[_PIPE:wheels], speeds, steer)
    hold_still(kin, params[_STILL], ways, speeds)
    wheel_model.remember(kin, model, speeds, state)
    return scale >= 1.0


@dataclass(frozen=True)
class Dob:
    """Pose tracker with a disturbance observer; commands wheel speeds.

    Attributes:
        kp, kp_theta: of the pose to come [1/s].
        ki, ki_theta: of the pose [1/s^2]; the observer takes what disturbs the twist, so that they may be 0.
        q_s, q_theta_s: time constants of the observer's low-pass for moving and for turning, beside the wheels' lag
            [s]: shorter is faster and noisier. Two mice 100 mm apart see a turn in steps of 6.7 mrad/s a tick.
        trust: the most that is believed to disturb the twist, as a part of the top speeds.
        still_m_s: rim speed that it takes to start a wheel, see `standstill`; 0 starts it for anything.
        lag_s: of the wheels; None takes what the robot's file tells (`wheel_model.lag_of`).
        delay_s: from a command to its beginning to act, beside the tick for which it holds.
        max_speed_m_s, max_yaw_rate_rad_s: of the command; infinite takes what the slowest wheel's rim can do.
        arrive_m, arrive_rad: how near is there.
        rest_m, rest_rad: how near the wheels are let alone at a reference that rests; three times that wakes them.
    """

    kp: float = 5.0
    kp_theta: float = 5.0
    ki: float = 0.0
    ki_theta: float = 0.0
    q_s: float = 0.08
    q_theta_s: float = 0.2
    trust: float = 0.5
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
    kernel: ClassVar[Any] = staticmethod(dob_kernel)

    def __post_init__(self) -> None:
        checked(
            self,
            positive=(
                "kp",
                "kp_theta",
                "q_s",
                "q_theta_s",
                "max_speed_m_s",
                "max_yaw_rate_rad_s",
                "arrive_m",
                "arrive_rad",
            ),
            not_negative=("ki", "ki_theta", "trust", "still_m_s", "lag_s", "delay_s", "rest_m", "rest_rad"),
        )

    def memory_size(self, robot: Robot) -> int:
        """Pose loop, observer, command step, wheel model."""
        pipe = kinematics.memory_size(kinematics.arrays(robot))
        return _PIPE + pipe + 2 * len(robot.wheels) + wheel_model.memory_size(robot, self.delay_s)

    def pack(self, robot: Robot) -> Array:
        """As the index constants of this module say."""
        loop = pose_loop.packed(
            robot, (self.kp, self.kp_theta, self.ki, self.ki_theta), self.max_speed_m_s, self.max_yaw_rate_rad_s,
            (self.arrive_m, self.arrive_rad), (self.rest_m, self.rest_rad),
        )  # fmt: skip
        model = wheel_model.packed(robot, self.lag_s, self.delay_s)
        observer = [
            self.q_s,
            self.q_theta_s,
            *(self.trust * loop[pose_loop.V_MAX : pose_loop.W_MAX + 1]),
            self.still_m_s,
        ]
        return np.concatenate([loop, model, observer, kinematics.arrays(robot)])
