"""PID on each of x, y and heading, in world axes, with feed-forward and anti-windup."""

import math
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np
from numba import njit

from holodrive import layout
from holodrive.control.parameters import checked, speed_of_slowest_wheel
from holodrive.interfaces import CommandKind
from holodrive.kinematics.kernel import wrap
from holodrive.robots.spec import Robot
from holodrive.types import Array

_KP, _KI, _KD = 0, 2, 4  # two each: position, heading
_FEED, _V_MAX, _W_MAX, _ARRIVE_M, _ARRIVE_RAD = range(6, 11)

# where to look for good values (`holodrive tune`)
BOUNDS: dict[str, tuple[float, float]] = {
    "kp": (0.1, 15.0),
    "ki": (0.0, 5.0),
    "kd": (0.0, 0.8),
    "kp_theta": (0.1, 15.0),
    "ki_theta": (0.0, 5.0),
    "kd_theta": (0.0, 0.8),
}


@njit(cache=True)
def pid_kernel(obs, memory, params, command):  # type: ignore[no-untyped-def]
    """u = Kp e + Ki int e + Kd (reference twist - twist) + feed-forward, per world axis; then into the body.

    memory: integral of the error (3) [m s, m s, rad s].
    """
    theta = obs[layout.POSE + 2]
    c, s = math.cos(theta), math.sin(theta)
    ex = obs[layout.REF_POSE] - obs[layout.POSE]
    ey = obs[layout.REF_POSE + 1] - obs[layout.POSE + 1]
    et = wrap(obs[layout.REF_POSE + 2] - theta)
    vx = c * obs[layout.TWIST] - s * obs[layout.TWIST + 1]
    vy = s * obs[layout.TWIST] + c * obs[layout.TWIST + 1]
    fx, fy, ft = obs[layout.REF_TWIST], obs[layout.REF_TWIST + 1], obs[layout.REF_TWIST + 2]
    feed, dt = params[_FEED], obs[layout.DT]
    # the derivative acts on velocities that are measured, not on a difference of noisy positions
    ux = params[_KP] * ex + params[_KI] * memory[0] + params[_KD] * (fx - vx) + feed * fx
    uy = params[_KP] * ey + params[_KI] * memory[1] + params[_KD] * (fy - vy) + feed * fy
    ut = params[_KP + 1] * et + params[_KI + 1] * memory[2] + params[_KD + 1] * (ft - obs[layout.TWIST + 2]) + feed * ft
    speed = math.hypot(ux, uy)
    scale = min(1.0, params[_V_MAX] / max(speed, 1e-12))
    # anti-windup: an axis integrates only while the command is inside the limits or the error unwinds it
    if scale >= 1.0 or ex * ux < 0.0:
        memory[0] += ex * dt
    if scale >= 1.0 or ey * uy < 0.0:
        memory[1] += ey * dt
    if abs(ut) <= params[_W_MAX] or et * ut < 0.0:
        memory[2] += et * dt
    ux, uy = scale * ux, scale * uy
    command[0], command[1] = c * ux + s * uy, c * uy - s * ux
    command[2] = min(max(ut, -params[_W_MAX]), params[_W_MAX])
    near = math.hypot(ex, ey) <= params[_ARRIVE_M] and abs(et) <= params[_ARRIVE_RAD]
    command[layout.ARRIVED] = 1.0 if near and obs[layout.REF_LAST] != 0.0 else 0.0


@dataclass(frozen=True)
class Pid:
    """Pose tracker with one PID per axis (the first paper's rival; its gains are not given there).

    Attributes:
        kp, kp_theta: [1/s].
        ki, ki_theta: [1/s^2].
        kd, kd_theta: [-], on the velocity error.
        feed_forward: share of the reference's own velocity that is added.
        max_speed_m_s, max_yaw_rate_rad_s: of the command; infinite takes what the slowest wheel's rim can do.
        arrive_m, arrive_rad: how near is there.
    """

    kp: float = 1.5
    ki: float = 0.2
    kd: float = 0.05
    kp_theta: float = 1.5
    ki_theta: float = 0.1
    kd_theta: float = 0.02
    feed_forward: float = 1.0
    max_speed_m_s: float = math.inf
    max_yaw_rate_rad_s: float = math.inf
    arrive_m: float = 0.02
    arrive_rad: float = math.radians(2.0)

    command_kind: ClassVar[CommandKind] = "twist"
    kernel: ClassVar[Any] = staticmethod(pid_kernel)

    def __post_init__(self) -> None:
        checked(
            self,
            positive=("kp", "kp_theta", "max_speed_m_s", "max_yaw_rate_rad_s", "arrive_m", "arrive_rad"),
            not_negative=("ki", "kd", "ki_theta", "kd_theta"),
        )

    def memory_size(self, robot: Robot) -> int:
        """Three integrals."""
        return 3

    def pack(self, robot: Robot) -> Array:
        """As the kernel's index constants say."""
        speed, yaw_rate = top_speeds(robot)
        return np.array(
            [
                self.kp,
                self.kp_theta,
                self.ki,
                self.ki_theta,
                self.kd,
                self.kd_theta,
                self.feed_forward,
                min(self.max_speed_m_s, speed),
                min(self.max_yaw_rate_rad_s, yaw_rate),
                self.arrive_m,
                self.arrive_rad,
            ]
        )


def top_speeds(robot: Robot) -> tuple[float, float]:
    """Speed [m/s] and yaw rate [rad/s] that a tracker commands at most: the robot's limits and its wheels' rims."""
    rim = speed_of_slowest_wheel(robot)
    far = max(math.hypot(wheel.x, wheel.y) for wheel in robot.wheels)
    return min(robot.limits.speed_m_s, rim), min(robot.limits.yaw_rate_rad_s, rim / far)
