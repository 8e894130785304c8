"""Proportional control of the pose: the go-to-pose law of the swerve paper, and its screw-motion variant."""

import math
from dataclasses import dataclass
from typing import Any, ClassVar, Literal

import numpy as np
from numba import njit

from holodrive import layout
from holodrive.control.parameters import checked
from holodrive.interfaces import CommandKind
from holodrive.kinematics.kernel import wrap
from holodrive.robots.spec import Robot
from holodrive.types import Array

_K_XY, _K_THETA, _SCREW, _ARRIVE_M, _ARRIVE_RAD, _FEED, _V_MAX, _W_MAX, _BRAKE, _YAW_BRAKE = range(10)
# where to look for good values (`holodrive tune`) [1/s]
BOUNDS = {"k_xy": (0.2, 10.0, "log"), "k_theta": (0.2, 10.0, "log")}
BRAKING_SHARE = 0.6  # of the acceleration limit: what the lag of wheels and steering leaves


@njit(cache=True)
def go_to_pose_kernel(obs, memory, params, command):  # type: ignore[no-untyped-def]
    """v* = K (p* - p) + feed-forward in the world, turned into the body; or xi = K log(T^-1 T*)."""
    theta = obs[layout.POSE + 2]
    dx = obs[layout.REF_POSE] - obs[layout.POSE]
    dy = obs[layout.REF_POSE + 1] - obs[layout.POSE + 1]
    turn = wrap(obs[layout.REF_POSE + 2] - theta)
    c, s = math.cos(theta), math.sin(theta)
    ex, ey = c * dx + s * dy, c * dy - s * dx
    if params[_SCREW] != 0.0:
        half = 1.0 if abs(turn) < 1e-6 else 0.5 * turn / math.tan(0.5 * turn)
        ex, ey = half * ex + 0.5 * turn * ey, half * ey - 0.5 * turn * ex
    # from this far one can still stop with the braking allowed: v^2 = 2 a d, one factor for all three
    slow = min(
        1.0,
        math.sqrt(2.0 * params[_BRAKE] / max(math.hypot(ex, ey), 1e-12)) / params[_K_XY],
        math.sqrt(2.0 * params[_YAW_BRAKE] / max(abs(turn), 1e-12)) / params[_K_THETA],
    )
    fx, fy = obs[layout.REF_TWIST], obs[layout.REF_TWIST + 1]
    vx = slow * params[_K_XY] * ex + params[_FEED] * (c * fx + s * fy)
    vy = slow * params[_K_XY] * ey + params[_FEED] * (c * fy - s * fx)
    omega = slow * params[_K_THETA] * turn + params[_FEED] * obs[layout.REF_TWIST + 2]
    # one factor for all three: the motion slows down, its shape stays
    scale = min(
        1.0,
        params[_V_MAX] / max(math.hypot(vx, vy), 1e-12),
        params[_W_MAX] / max(abs(omega), 1e-12),
    )
    command[0], command[1], command[2] = scale * vx, scale * vy, scale * omega
    near = math.hypot(dx, dy) <= params[_ARRIVE_M] and abs(turn) <= params[_ARRIVE_RAD]
    command[layout.ARRIVED] = 1.0 if near and obs[layout.REF_LAST] != 0.0 else 0.0


@dataclass(frozen=True)
class GoToPose:
    """Go to the reference pose, and along with it while it moves (the law of the third paper, which gives no gains).

    Where the robot has acceleration limits, it nears its goal no faster than it can brake.

    Attributes:
        k_xy, k_theta: gains [1/s].
        law: "world" pulls position and heading each straight to the goal; "screw" follows the SE(2) geodesic,
            the motion of constant body twist (k_theta is not used; singular when the goal heading is straight behind).
        feed_forward: share of the reference's own velocity that is added.
        max_speed_m_s, max_yaw_rate_rad_s: of the command; infinite leaves it to the wheels' limits.
        arrive_m, arrive_rad: how near is there.
    """

    k_xy: float = 1.0
    k_theta: float = 1.0
    law: Literal["world", "screw"] = "world"
    feed_forward: float = 1.0
    max_speed_m_s: float = math.inf
    max_yaw_rate_rad_s: float = math.inf
    arrive_m: float = 0.02
    arrive_rad: float = math.radians(2.0)

    command_kind: ClassVar[CommandKind] = "twist"
    kernel: ClassVar[Any] = staticmethod(go_to_pose_kernel)

    def __post_init__(self) -> None:
        checked(self, positive=("k_xy", "k_theta", "max_speed_m_s", "max_yaw_rate_rad_s", "arrive_m", "arrive_rad"))

    def memory_size(self, robot: Robot) -> int:
        """No memory."""
        return 0

    def pack(self, robot: Robot) -> Array:
        """As the kernel's index constants say."""
        screw = self.law == "screw"
        k_theta = self.k_xy if screw else self.k_theta
        return np.array(
            [
                self.k_xy,
                k_theta,
                float(screw),
                self.arrive_m,
                self.arrive_rad,
                self.feed_forward,
                min(self.max_speed_m_s, robot.limits.speed_m_s),
                min(self.max_yaw_rate_rad_s, robot.limits.yaw_rate_rad_s),
                BRAKING_SHARE * robot.limits.accel_m_s2,
                BRAKING_SHARE * robot.limits.yaw_accel_rad_s2,
            ]
        )
