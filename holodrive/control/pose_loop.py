"""The outer loop of the trackers that know their wheels' lag: feed-forward with lead, and a PI that looks ahead.

With wheels that lag by tau and act after a delay d, the place z = p + tau v (v the twist, p the pose once all that is
on its way has acted) moves as the command says, z' = u. So the reference is taken as far ahead,

    z_r = r + (d + tau) r' + (d^2 / 2 + tau d) r'',    u = z_r' + kp (z_r - z) + ki int (r - p)

and the loop has no lag left to be unstable with: kp may be several times what it may be on the pose itself. All is
resolved in the axes that the base is expected to have when the command acts.
"""

import math

import numpy as np

from holodrive import layout
from holodrive.control.pid import top_speeds
from holodrive.kinematics.kernel import wrap
from holodrive.leaf import leaf
from holodrive.robots.spec import Robot
from holodrive.types import Array

LOOP = 10  # packed parameters
(KP, KP_THETA, KI, KI_THETA, V_MAX, W_MAX, ARRIVE_M, ARRIVE_RAD, REST_M, REST_RAD) = range(LOOP)
MEMORY = 7  # error of the pose (3) [m, m, rad] and its integral (3) in body axes; 1 while the base rests
(ERROR, INTEGRAL, RESTING) = (0, 3, 6)
_WAKES = 3.0  # how many times the error at which a base comes to rest it takes to wake it


def packed(
    robot: Robot,
    gains: tuple[float, float, float, float],
    max_speed_m_s: float,
    max_yaw_rate_rad_s: float,
    arrive: tuple[float, float],
    rest: tuple[float, float],
) -> Array:
    """The parameters of the loop: kp, kp_theta [1/s], ki, ki_theta [1/s^2], limits, how near is there, and at rest."""
    speed, yaw_rate = top_speeds(robot)
    return np.array([*gains, min(max_speed_m_s, speed), min(max_yaw_rate_rad_s, yaw_rate), *arrive, *rest])


@leaf
def pose_loop(obs, loop, lead, ahead, memory, command):  # type: ignore[no-untyped-def]
    """The wanted body twist into `command`, with the flag of arrival.

    Args:
        obs: observation.
        loop: (LOOP,) parameters.
        lead: (2,) lag and delay of the wheels [s].
        ahead: (3,) displacement still to come of what was commanded, body axes [m, m, rad].
        memory: (MEMORY,).
        command: out.

    Returns:
        Whether the base shall rest: the reference does, and the pose is near enough for the wheels to be let alone.
    """
    lag, delay, dt = lead[0], lead[1], obs[layout.DT]
    theta, middle = obs[layout.POSE + 2] + ahead[2], obs[layout.POSE + 2] + 0.5 * ahead[2]
    c, s = math.cos(middle), math.sin(middle)
    x = obs[layout.POSE] + c * ahead[0] - s * ahead[1]
    y = obs[layout.POSE + 1] + s * ahead[0] + c * ahead[1]
    once, twice = delay + lag, 0.5 * delay * delay + lag * delay
    ex = reference_ahead(obs, 0, once, twice) - x
    ey = reference_ahead(obs, 1, once, twice) - y
    et = wrap(reference_ahead(obs, 2, once, twice) - theta)
    # a command holds for a tick: its middle is half a tick ahead
    later = once + 0.5 * dt
    fx = obs[layout.REF_TWIST] + later * obs[layout.REF_ACCEL]
    fy = obs[layout.REF_TWIST + 1] + later * obs[layout.REF_ACCEL + 1]
    ft = obs[layout.REF_TWIST + 2] + later * obs[layout.REF_ACCEL + 2]
    c, s = math.cos(theta), math.sin(theta)
    ux, uy = fx + loop[KP] * ex, fy + loop[KP] * ey
    command[0] = c * ux + s * uy + loop[KI] * memory[INTEGRAL]
    command[1] = c * uy - s * ux + loop[KI] * memory[INTEGRAL + 1]
    command[2] = ft + loop[KP_THETA] * et + loop[KI_THETA] * memory[INTEGRAL + 2]
    # what is on its way is a matter of the model; in the long run it is the pose itself that counts
    ex, ey = obs[layout.REF_POSE] - obs[layout.POSE], obs[layout.REF_POSE + 1] - obs[layout.POSE + 1]
    memory[ERROR], memory[ERROR + 1] = c * ex + s * ey, c * ey - s * ex
    memory[ERROR + 2] = wrap(obs[layout.REF_POSE + 2] - obs[layout.POSE + 2])
    fast = max(math.hypot(command[0], command[1]) / loop[V_MAX], abs(command[2]) / loop[W_MAX])
    if fast > 1.0:
        for i in range(3):
            command[i] /= fast
    return arrival(obs, loop, memory, command)


@leaf
def reference_ahead(obs, axis, once, twice):  # type: ignore[no-untyped-def]
    """One coordinate of the reference, `once` seconds on by its velocity and with `twice` [s^2] of its acceleration."""
    moved = once * obs[layout.REF_TWIST + axis] + twice * obs[layout.REF_ACCEL + axis]
    return obs[layout.REF_POSE + axis] + moved


@leaf
def arrival(obs, loop, memory, command):  # type: ignore[no-untyped-def]
    """Set the flag of arrival; whether the base shall rest, with a hysteresis, for each start costs a dead time."""
    far = math.hypot(obs[layout.REF_POSE] - obs[layout.POSE], obs[layout.REF_POSE + 1] - obs[layout.POSE + 1])
    turned = abs(wrap(obs[layout.REF_POSE + 2] - obs[layout.POSE + 2]))
    last = obs[layout.REF_LAST] != 0.0
    command[layout.ARRIVED] = 1.0 if last and far <= loop[ARRIVE_M] and turned <= loop[ARRIVE_RAD] else 0.0
    wide = _WAKES if memory[RESTING] != 0.0 else 1.0
    rests = last and far <= wide * loop[REST_M] and turned <= wide * loop[REST_RAD]
    memory[RESTING] = 1.0 if rests else 0.0
    return rests


@leaf
def integrate(free, dt, memory):  # type: ignore[no-untyped-def]
    """Add the error of this tick to the integral: while the wheels are `free` of their limits, or to unwind it."""
    for i in range(3):
        if free or memory[ERROR + i] * memory[INTEGRAL + i] < 0.0:
            memory[INTEGRAL + i] += memory[ERROR + i] * dt


__all__ = ["LOOP", "MEMORY", "RESTING", "integrate", "packed", "pose_loop"]
