"""Fuzzy avoidance around a cascade of PIDs: position outside, wheel speeds inside (future work of the first paper).

moving reference -> PID on the pose, with feed-forward -> wanted twist
                 -> fuzzy avoidance: blends it with its reaction where the way is not free; barrier
                 -> limits, discretisation, inverse kinematics -> PID on each wheel's encoder speed
"""

import math
from dataclasses import dataclass
from functools import cached_property
from typing import Any, ClassVar, Literal

import numpy as np
from numba import njit

from holodrive.control import wheel_pid
from holodrive.control.fuzzy_avoidance import FuzzyAvoidance, guided
from holodrive.control.parameters import checked
from holodrive.control.pid import Pid, pid_kernel
from holodrive.control.wheel_pid import Gains, twist_to_wheels
from holodrive.interfaces import CommandKind
from holodrive.kinematics import kernel as kinematics
from holodrive.robots.spec import Robot
from holodrive.types import Array

_PID = 11  # numbers of a packed `Pid`
_KIN = _PID + wheel_pid.GAINS  # the robot's kinematics begin here, the fuzzy avoidance follows them
_INTEGRALS = 3  # of the pose error; then wanted twist (3), command step, wheels, fuzzy avoidance
_UNTOUCHED = 1e-9  # m/s or rad/s: what rounding may change of a twist


@njit(cache=True)
def fuzzy_pid_kernel(obs, memory, params, command):  # type: ignore[no-untyped-def]
    """One tick; see the module's text and `FuzzyPid.pack`."""
    n, m = int(params[_KIN + kinematics.N_WHEELS]), int(params[_KIN + kinematics.N_STEER])
    fuzzy = _KIN + kinematics.WHEELS + kinematics.BLOCK * n
    pipe = 2 * _INTEGRALS
    wheels = pipe + kinematics.STEER + 2 * m
    end = wheels + wheel_pid.PER_WHEEL * n
    ix, iy, it = memory[0], memory[1], memory[2]
    pid_kernel(obs, memory[:_INTEGRALS], params[:_PID], command)
    want = memory[_INTEGRALS:pipe]
    want[:] = command[:3]
    guided(obs, memory[end:], params[fuzzy:], want, command)
    change = abs(command[0] - want[0]) + abs(command[1] - want[1]) + abs(command[2] - want[2])
    if not change < _UNTOUCHED:  # what drives now is not the PID: its integrals wait (anti-windup), as they do for NaN
        memory[0], memory[1], memory[2] = ix, iy, it
    twist_to_wheels(params[_KIN:fuzzy], params[_PID:_KIN], obs, memory[pipe:wheels], memory[wheels:end], command)


@dataclass(frozen=True)
class FuzzyPid:
    """Pose tracker that keeps off obstacles: fuzzy avoidance with PIDs on the pose and on each wheel.

    Attributes:
        kp, kp_theta: of the pose [1/s].
        ki, ki_theta: [1/s^2].
        kd, kd_theta: [-], on the velocity error.
        feed_forward: share of the reference's own velocity that is added.
        wheel_kp, wheel_ki, wheel_kd: of each wheel's speed [-, 1/s, s]; a trim on top of the motor board's own loop.
        wheel_feed_forward: share of the wanted wheel speed that is commanded at once.
        wheel_slew_m_s2: fastest change of a wheel's command, at the rim; infinite leaves it to the robot's own
            acceleration limits.
        wheel_share: of a wheel's limit that its trim may add or take.
        profile, no_rule, barrier: of the fuzzy avoidance, see `FuzzyAvoidance`.
        max_speed_m_s, max_yaw_rate_rad_s: of the command; infinite takes what the slowest wheel's rim can do.
        arrive_m, arrive_rad: how near is there.
    """

    kp: float = 1.5
    ki: float = 0.2
    kd: float = 0.05
    kp_theta: float = 1.0
    ki_theta: float = 0.0
    kd_theta: float = 0.02
    feed_forward: float = 1.0
    wheel_kp: float = 0.7
    wheel_ki: float = 0.0
    wheel_kd: float = 0.0
    wheel_feed_forward: float = 1.0
    wheel_slew_m_s2: float = math.inf
    wheel_share: float = 0.3
    profile: str = "repaired"
    no_rule: Literal["hold_then_stop", "stop", "default", "raise"] = "hold_then_stop"
    barrier: bool = True
    max_speed_m_s: float = math.inf
    max_yaw_rate_rad_s: float = math.inf
    arrive_m: float = 0.02
    arrive_rad: float = math.radians(2.0)

    command_kind: ClassVar[CommandKind] = "wheels"
    needs_lidar: ClassVar[bool] = True
    kernel: ClassVar[Any] = staticmethod(fuzzy_pid_kernel)
    faults: ClassVar[dict[int, str]] = FuzzyAvoidance.faults

    def __post_init__(self) -> None:
        checked(
            self,
            positive=("wheel_slew_m_s2",),
            not_negative=("wheel_kp", "wheel_ki", "wheel_kd", "wheel_feed_forward", "wheel_share"),
        )
        self._pid, self._fuzzy  # noqa: B018  both check what is theirs

    @cached_property
    def _pid(self) -> Pid:
        return Pid(
            self.kp, self.ki, self.kd, self.kp_theta, self.ki_theta, self.kd_theta, self.feed_forward,
            self.max_speed_m_s, self.max_yaw_rate_rad_s, self.arrive_m, self.arrive_rad,
        )  # fmt: skip

    @cached_property
    def _fuzzy(self) -> FuzzyAvoidance:
        return FuzzyAvoidance(profile=self.profile, no_rule=self.no_rule, barrier=self.barrier)

    def memory_size(self, robot: Robot) -> int:
        """Integrals, wanted twist, command step, wheels, then the fuzzy avoidance's own."""
        kin = kinematics.arrays(robot)
        own = 2 * _INTEGRALS + kinematics.memory_size(kin) + wheel_pid.memory_size(len(robot.wheels))
        return own + self._fuzzy.memory_size(robot)

    def pack(self, robot: Robot) -> Array:
        """PID of the pose, gains of the wheels, kinematics, fuzzy avoidance."""
        gains = Gains(
            self.wheel_kp,
            self.wheel_ki,
            self.wheel_kd,
            self.wheel_feed_forward,
            self.wheel_slew_m_s2,
            self.wheel_share,
        )
        parts = [self._pid.pack(robot), np.array(gains), kinematics.arrays(robot), self._fuzzy.pack(robot)]
        return np.concatenate(parts)
