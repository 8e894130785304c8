"""Tracker by second-order kinematics: wheels and modules get what they need to be where the reference is, when it is.

    u  = r' + k (r - p)                     velocity to have, world axes; p the believed pose
    u' = r'' + k (r' - p')
    v_i = J_i u_b,   v_i' = J_i (u_b' )     of each contact, body axes: u_b' holds the turn of the axes, -omega x u_b
    d_i' = v_i x v_i' / v_i^2               how fast a module steers
    w_i' = e_i . v_i' / r                   how fast a wheel speeds up

All is taken at the middle of the tick for which the command holds. A module is told d + lag d', a drive what its
loop and lag take for w and w' (`actuator_lead`). Modules flip, rest and keep to their rate as in the command pipeline
(`kinematics.kernel.drive_modules`); a drive turns with the part of the wanted motion along where its module points.

Second-order kinematics of wheeled bases: G. Campion, G. Bastin, B. d'Andrea-Novel, "Structural properties and
classification of kinematic and dynamic models of wheeled mobile robots", IEEE T-RA 12(1), 1996.
"""

import math
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from holodrive import layout
from holodrive.control import actuator_lead
from holodrive.control.actuator_lead import ACTUATOR, ACTUATORS, DRIVE_LAG, EASE, STEER_LAG, Lags, lead_drives, wrench
from holodrive.control.go_to_pose import BRAKING_SHARE
from holodrive.control.parameters import checked
from holodrive.interfaces import CommandKind
from holodrive.kinematics import kernel as kinematics
from holodrive.kinematics.kernel import (
    BACK,
    BLOCK,
    CASTER,
    HOLD,
    LAST_TWIST,
    LOAD,
    N_STEER,
    N_WHEELS,
    RADIUS,
    ROWS,
    STEER,
    STEER_INDEX,
    STEER_RATE,
    TRAILS,
    WHEELS,
    accel_share,
    drive_leaning,
    drive_modules,
    limit_scale,
    remember,
    row,
    wrap,
)
from holodrive.kinematics.settings import POWERED
from holodrive.leaf import leaf
from holodrive.robots.spec import Robot
from holodrive.types import Array

# packed parameters; after them the kinematics, then the lead
(_K, _K_THETA, _BRAKE, _YAW_BRAKE, _ARRIVE_M, _ARRIVE_RAD, _KIN) = range(7)
# memory: whether a tick has passed, twist and its rate in the body axes of the middle of the tick; then the command
# step, the drives, and for wheels (n) and modules (m) what is worked out in a tick
_BEGUN, _TWIST, _RATE, _PIPE = 0, 1, 4, 7

# where to look for good values (`holodrive tune`) [1/s]
BOUNDS = {"k": (0.2, 10.0, "log"), "k_theta": (0.2, 10.0, "log")}


@leaf
def feed_forward_kernel(obs, memory, params, command):  # type: ignore[no-untyped-def]
    """One tick; see the module's text and `FeedForward.pack`."""
    n, m, dt = int(params[_KIN + N_WHEELS]), int(params[_KIN + N_STEER]), obs[layout.DT]
    kin_end = _KIN + WHEELS + BLOCK * n
    kin, lead = params[_KIN:kin_end], params[kin_end:]
    drives_at = _PIPE + STEER + 2 * m
    work_at = drives_at + actuator_lead.PER_WHEEL * n
    pipe, drives = memory[_PIPE:drives_at], memory[drives_at:work_at]
    wanted, duties = memory[work_at : work_at + n], memory[work_at + n : work_at + 2 * n]
    speeds = command[layout.VALUE : layout.VALUE + n]
    steer = command[layout.COMMAND_STEER : layout.COMMAND_STEER + m]
    if memory[_BEGUN] == 0.0:
        for j in range(m):
            pipe[STEER + j] = obs[layout.STEER + j]
        memory[_BEGUN] = 1.0
    motion, valid = memory[_TWIST:_PIPE], True
    motion_wanted(obs, params, motion)
    for i in range(6):
        valid = valid and math.isfinite(motion[i])
    if not (valid and dt > 0.0):
        for i in range(n):
            speeds[i] = math.nan
        for j in range(m):
            steer[j] = pipe[STEER + j]
        return
    keep_limits(kin, dt, pipe, motion)
    steer_modules(kin, lead, obs, motion, pipe, speeds, steer)
    remember(motion[0], motion[1], motion[2], dt, pipe)
    turn_wheels(kin, lead, obs, motion, steer, wanted, duties)
    lead_drives(kin, lead, dt, wanted, duties, drives, speeds)
    command[layout.ARRIVED] = arrived(obs, params)


@leaf
def motion_wanted(obs, params, motion):  # type: ignore[no-untyped-def]
    """Twist (3) and its rate (3) at the middle of the tick, in the body axes expected there."""
    r, p, dt = layout.REF_POSE, layout.POSE, obs[layout.DT]
    c, s = math.cos(obs[p + 2]), math.sin(obs[p + 2])
    ex, ey, et = obs[r] - obs[p], obs[r + 1] - obs[p + 1], wrap(obs[r + 2] - obs[p + 2])
    # as in go_to_pose: no faster than one can brake, one factor for all three
    slow = min(
        1.0,
        math.sqrt(2.0 * params[_BRAKE] / max(math.hypot(ex, ey), 1e-12)) / params[_K],
        math.sqrt(2.0 * params[_YAW_BRAKE] / max(abs(et), 1e-12)) / params[_K_THETA],
    )
    k, kt = slow * params[_K], slow * params[_K_THETA]
    vx = c * obs[layout.TWIST] - s * obs[layout.TWIST + 1]
    vy = s * obs[layout.TWIST] + c * obs[layout.TWIST + 1]
    fx, fy, ft = obs[layout.REF_TWIST], obs[layout.REF_TWIST + 1], obs[layout.REF_TWIST + 2]
    ax = obs[layout.REF_ACCEL] + k * (fx - vx)
    ay = obs[layout.REF_ACCEL + 1] + k * (fy - vy)
    at = obs[layout.REF_ACCEL + 2] + kt * (ft - obs[layout.TWIST + 2])
    ux, uy = fx + k * ex + 0.5 * dt * ax, fy + k * ey + 0.5 * dt * ay
    omega = ft + kt * et + 0.5 * dt * at
    c, s = math.cos(obs[p + 2] + 0.5 * dt * omega), math.sin(obs[p + 2] + 0.5 * dt * omega)
    motion[0], motion[1], motion[2] = c * ux + s * uy, c * uy - s * ux, omega
    motion[3], motion[4], motion[5] = c * ax + s * ay + omega * motion[1], c * ay - s * ax - omega * motion[0], at


@leaf
def keep_limits(kin, dt, pipe, motion):  # type: ignore[no-untyped-def]
    """Bring the motion inside the base's limits and the wheels', each by one factor, so that it keeps its shape."""
    scale = limit_scale(kin, motion[0], motion[1], motion[2], dt)
    for i in range(6):
        motion[i] *= scale
    share = accel_share(kin, pipe, motion[0], motion[1], motion[2], dt)
    if share < 1.0:
        dx, dy = share * (motion[0] - pipe[LAST_TWIST]), share * (motion[1] - pipe[LAST_TWIST + 1])
        dw = share * (motion[2] - pipe[LAST_TWIST + 2])
        motion[0], motion[1] = pipe[LAST_TWIST] + dx, pipe[LAST_TWIST + 1] + dy
        motion[2] = pipe[LAST_TWIST + 2] + dw
        motion[3], motion[4] = dx / dt + motion[2] * motion[1], dy / dt - motion[2] * motion[0]
        motion[5] = dw / dt
    load = 1.0
    for i in range(int(kin[N_WHEELS])):
        b = WHEELS + BLOCK * i
        load = max(load, kin[b + LOAD] * contact_speed(kin, b, motion))
    for i in range(6):
        motion[i] /= load


@leaf
def contact_speed(kin, b, motion):  # type: ignore[no-untyped-def]
    """Size of the rows of one wheel: its speed [rad/s], or that of a module's contact [m/s]."""
    along = row(kin, b + ROWS, motion[0], motion[1], motion[2])
    return math.hypot(along, row(kin, b + ROWS + 3, motion[0], motion[1], motion[2]))


@leaf
def steer_modules(kin, lead, obs, motion, pipe, work, steer):  # type: ignore[no-untyped-def]
    """Angles (m,) to command: module logic on the wanted velocities, then the lead of the steering.

    A module whose reference rests but speeds up turns into the direction of that already. `work` (n,) is overwritten.
    """
    dt = obs[layout.DT]
    for i in range(int(kin[N_WHEELS])):
        b, lag = WHEELS + BLOCK * i, lead[ACTUATORS + ACTUATOR * i + STEER_LAG]
        j = int(kin[b + STEER_INDEX])
        if j >= 0:
            work[i], steer[j] = direction(kin, b, lag + dt, motion)
    share = 1.0
    if kin[TRAILS] == 0.0:
        drive_modules(kin, dt, pipe, work, steer)
    elif kin[TRAILS] != POWERED:
        share = drive_leaning(kin, motion[0], motion[1], motion[2], dt, pipe, work, steer)
    else:
        share = caster_share(kin, pipe, motion)
    for i in range(6):
        motion[i] *= share
    for i in range(int(kin[N_WHEELS])):
        b, lag = WHEELS + BLOCK * i, lead[ACTUATORS + ACTUATOR * i + STEER_LAG]
        j = int(kin[b + STEER_INDEX])
        if j >= 0 and kin[TRAILS] != POWERED:
            steer[j] += lag * steering_rate(kin, b, motion)
        elif j >= 0:
            # a powered caster takes any twist at any angle, so its angle is what its rates have led to
            begin = pipe[STEER + j]
            middle = begin + 0.5 * dt * caster_rate(kin, b, begin, motion)
            rate = caster_rate(kin, b, middle, motion)
            pipe[STEER + j] = begin + dt * rate
            steer[j] = middle + lag * rate


@leaf
def caster_rate(kin, b, angle, motion):  # type: ignore[no-untyped-def]
    """n . v / c - omega of one powered caster at an angle [rad]: its steering rate [rad/s]."""
    x = row(kin, b + ROWS, motion[0], motion[1], motion[2])
    y = row(kin, b + ROWS + 3, motion[0], motion[1], motion[2])
    return (math.cos(angle) * y - math.sin(angle) * x) / kin[b + CASTER] - motion[2]


@leaf
def caster_share(kin, pipe, motion):  # type: ignore[no-untyped-def]
    """Share of the twist, at most 1, at which no powered caster steers faster than it can."""
    share = 1.0
    for i in range(int(kin[N_WHEELS])):
        b = WHEELS + BLOCK * i
        j = int(kin[b + STEER_INDEX])
        if j >= 0:
            share = min(share, kin[b + STEER_RATE] / abs(caster_rate(kin, b, pipe[STEER + j], motion)))
    return share


@leaf
def direction(kin, b, ahead, motion):  # type: ignore[no-untyped-def]
    """Velocity (2) [m/s] by which a module steers; one that rests for now shows where it will go in `ahead` [s]."""
    x = row(kin, b + ROWS, motion[0], motion[1], motion[2])
    y = row(kin, b + ROWS + 3, motion[0], motion[1], motion[2])
    if math.hypot(x, y) >= kin[HOLD]:
        return x, y
    ax = x + ahead * row(kin, b + ROWS, motion[3], motion[4], motion[5])
    ay = y + ahead * row(kin, b + ROWS + 3, motion[3], motion[4], motion[5])
    return ax, ay


@leaf
def steering_rate(kin, b, motion):  # type: ignore[no-untyped-def]
    """v x v' / v^2 of one module, inside its rate [rad/s]; 0 at rest."""
    x = row(kin, b + ROWS, motion[0], motion[1], motion[2])
    y = row(kin, b + ROWS + 3, motion[0], motion[1], motion[2])
    square = x * x + y * y
    if square < kin[HOLD] * kin[HOLD]:
        return 0.0
    ax = row(kin, b + ROWS, motion[3], motion[4], motion[5])
    ay = row(kin, b + ROWS + 3, motion[3], motion[4], motion[5])
    rate = (x * ay - y * ax) / square
    return min(kin[b + STEER_RATE], max(-kin[b + STEER_RATE], rate))


@leaf
def turn_wheels(kin, lead, obs, motion, steer, wanted, duties):  # type: ignore[no-untyped-def]
    """Speeds (n,) that the wheels shall have in the tick, and the duties that it takes, as free speeds [rad/s].

    A module drives with what of its contact's motion is along it. It points where it will stand in the middle of the
    tick, on its way from the measured angle to the command.
    """
    fx, fy, torque = wrench(lead, motion)
    for i in range(int(kin[N_WHEELS])):
        b, at = WHEELS + BLOCK * i, ACTUATORS + ACTUATOR * i
        j = int(kin[b + STEER_INDEX])
        wanted[i] = row(kin, b + ROWS, motion[0], motion[1], motion[2])
        rate = row(kin, b + ROWS, motion[3], motion[4], motion[5])
        load = row(kin, b + BACK, fx, fy, torque)
        if j >= 0:
            half, lag, now = 0.5 * obs[layout.DT], lead[at + STEER_LAG], obs[layout.STEER + j]
            step = (steer[j] - now) * half / max(half, lag)
            reach = kin[b + STEER_RATE] * half
            angle = now + min(reach, max(-reach, step))
            c, s, r = math.cos(angle), math.sin(angle), kin[b + RADIUS]
            across = row(kin, b + ROWS + 3, motion[0], motion[1], motion[2])
            wanted[i], sideways = (c * wanted[i] + s * across) / r, c * across - s * wanted[i]
            rate = (c * rate + s * row(kin, b + ROWS + 3, motion[3], motion[4], motion[5])) / r
            if kin[TRAILS] == POWERED:
                rate += caster_rate(kin, b, angle, motion) * sideways / r
            load = (c * load + s * row(kin, b + BACK + 3, fx, fy, torque)) * r
        duties[i] = wanted[i] + lead[at + DRIVE_LAG] * rate + lead[at + EASE] * load


@leaf
def arrived(obs, params):  # type: ignore[no-untyped-def]
    """1.0 where a reference that rests is near enough."""
    dx, dy = obs[layout.REF_POSE] - obs[layout.POSE], obs[layout.REF_POSE + 1] - obs[layout.POSE + 1]
    turn = abs(wrap(obs[layout.REF_POSE + 2] - obs[layout.POSE + 2]))
    near = math.hypot(dx, dy) <= params[_ARRIVE_M] and turn <= params[_ARRIVE_RAD]
    return 1.0 if near and obs[layout.REF_LAST] != 0.0 else 0.0


@dataclass(frozen=True)
class FeedForward:
    """Trajectory tracker by second-order kinematics and P feedback; commands wheel speeds and steering angles.

    It needs a reference that tells velocity and acceleration (any trajectory of `planning`), and plays out its
    strength where actuators lag.

    Attributes:
        k, k_theta: of the pose error [1/s].
        lags: "stated" takes the lags that the robot's file states (as the plants first_order and pwm_map do); "motors"
            those of motors with the robot's mass on them (as the plants slip and motors have).
        drive_lag_s: instead, with which a drive follows its duty, before the motor board's loop.
        steer_lag_s: instead, with which a steering follows its command.
        max_speed_m_s, max_yaw_rate_rad_s: of the command; infinite leaves it to the wheels' limits.
        arrive_m, arrive_rad: how near is there.
    """

    k: float = 5.0
    k_theta: float = 5.0
    lags: Lags = "stated"
    drive_lag_s: float | None = None
    steer_lag_s: float | None = None
    max_speed_m_s: float = math.inf
    max_yaw_rate_rad_s: float = math.inf
    arrive_m: float = 0.02
    arrive_rad: float = math.radians(2.0)

    command_kind: ClassVar[CommandKind] = "wheels"
    kernel: ClassVar[Any] = staticmethod(feed_forward_kernel)

    def __post_init__(self) -> None:
        checked(
            self,
            positive=("k", "k_theta", "max_speed_m_s", "max_yaw_rate_rad_s", "arrive_m", "arrive_rad"),
            not_negative=("drive_lag_s", "steer_lag_s"),
        )

    def memory_size(self, robot: Robot) -> int:
        """Motion, command step, drives, speeds and rates."""
        n = len(robot.wheels)
        return _PIPE + kinematics.memory_size(kinematics.arrays(robot)) + actuator_lead.memory_size(n) + 2 * n

    def pack(self, robot: Robot) -> Array:
        """As the index constants of this module say."""
        limits, kin = robot.limits, kinematics.arrays(robot)
        kin[kinematics.SPEED] = min(kin[kinematics.SPEED], self.max_speed_m_s)
        kin[kinematics.YAW_RATE] = min(kin[kinematics.YAW_RATE], self.max_yaw_rate_rad_s)
        gains = [
            self.k,
            self.k_theta,
            BRAKING_SHARE * limits.accel_m_s2,
            BRAKING_SHARE * limits.yaw_accel_rad_s2,
            self.arrive_m,
            self.arrive_rad,
        ]
        return np.concatenate([gains, kin, actuator_lead.packed(robot, self.lags, self.drive_lag_s, self.steer_lag_s)])
