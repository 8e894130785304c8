"""Commands that make actuators with a lag do what is wanted now: inverse of a drive's loop, lead of a steering.

A drive follows its duty with a lag, and the motor board closes a loop around it (`actuators.speed_loop`). For the
wheel to turn with w and speed up with w' its duty has to be that of the free speed

    d = w + lag w' + ease tau,   tau = G . f

with f the wrench that the body's acceleration takes and G the column of the least-squares inverse, which shares it
among the wheels: so a base that spins while it drives straight, whose wheels speed up and slow down all the time,
needs no force for that. `ease` is R / (efficiency K^2), the speed that a load costs. The command c then solves

    a c + kp (c - s) + I = d,   I' = ki (c - s),   s = w, as the board's filter shows it

where a is the board's share of feed-forward: a lead at first, which the board's integral takes over with time. This
loop sees the motion that is wanted, not the one that is; so feedback, the board's own as well, is left alone.

A steering that follows with a lag stands at d when it is told d + lag d'.
"""

import math
from typing import Literal

import numpy as np

from holodrive.kinematics.kernel import saturate_wheels
from holodrive.leaf import leaf
from holodrive.robots.spec import Robot, Steering, WheelSpec
from holodrive.types import Array

# What is known of the lags: "stated" are those in the robot's file, measured ones first, which the plants "first_order"
# and "pwm_map" have; "motors" are those that motors with the robot's mass on them have, as on "slip" and "motors".
Lags = Literal["stated", "motors"]

# packed parameters: gains and feed-forward of the board's loop, share of a new speed that its filter lets in; body
# [kg, kg m^2, m, m]; then for each wheel the lag of its drive [s], its ease [rad/s per N m] and its steering's lag [s]
LOOP_KP, LOOP_KI, LOOP_AHEAD, LOOP_NEW, MASS, INERTIA, COM_X, COM_Y, ACTUATORS = range(9)
DRIVE_LAG, EASE, STEER_LAG, ACTUATOR = range(4)
PER_WHEEL = 2  # memory: speed as the board's filter shows it, integral of its loop [rad/s]


def drive_lag(robot: Robot, wheel: WheelSpec, lags: Lags) -> tuple[float, float]:
    """Time constant [s] with which a drive without load follows its duty, and its ease [rad/s per N m].

    A stated lag is that of the loaded drive, so there is no load beside it.
    """
    motor = wheel.motor
    if lags == "stated":
        return (robot.pwm_map.lag_s if robot.pwm_map is not None else motor.lag_s), 0.0
    ease = motor.resistance_ohm / (motor.efficiency * motor.back_emf_v_s_rad**2)
    return motor.inertia_kg_m2 * ease, ease


def steer_lag(robot: Robot, steering: Steering, lags: Lags) -> float:
    """Time constant [s] with which a steering follows an angle that moves evenly.

    Of a motor with a position loop it is (K + kd) / kp, less what the board adds ahead.
    """
    motor = steering.motor
    if lags == "stated" or motor is None:
        return steering.lag_s
    friction = motor.resistance_ohm * motor.viscous_friction_n_m_s_rad / (motor.efficiency * motor.back_emf_v_s_rad)
    behind = max(0.0, 1.0 - robot.speed_loop.feed_forward)
    return behind * (motor.back_emf_v_s_rad + friction + steering.kd_v_s_rad) / steering.kp_v_rad


def packed(robot: Robot, lags: Lags, drive_lag_s: float | None = None, steer_lag_s: float | None = None) -> Array:
    """The parameters; a lag that is given has precedence over `lags`."""
    loop, period = robot.speed_loop, robot.control_period_s
    new = -math.expm1(-period / loop.filter_s) if loop.filter_s > 0.0 else 1.0
    rows = np.zeros((len(robot.wheels), ACTUATOR))
    for row, wheel in zip(rows, robot.wheels, strict=True):
        row[:STEER_LAG] = drive_lag(robot, wheel, lags) if drive_lag_s is None else (drive_lag_s, 0.0)
        if wheel.kind == "swerve":
            row[STEER_LAG] = (
                steer_lag(robot, wheel.steering or Steering(), lags) if steer_lag_s is None else steer_lag_s
            )
    looped = all(wheel.encoder is not None for wheel in robot.wheels)
    board = [loop.kp, loop.ki, loop.feed_forward, new] if looped else [0.0, 0.0, 1.0, 1.0]
    body = [robot.mass_kg, robot.inertia_kg_m2, *robot.centre_of_mass]
    return np.concatenate([board, body, rows.ravel()])


def memory_size(wheels: int) -> int:
    """How many float64 `lead_drives` keeps between ticks; zeros are wheels at rest."""
    return PER_WHEEL * wheels


@leaf
def wrench(lead, motion):  # type: ignore[no-untyped-def]
    """Force (2) [N] and torque about the reference point [N m] that a body's acceleration takes, body axes.

    Args:
        lead: as `packed`.
        motion: (6,) twist and the rate of its components, body axes.
    """
    omega, turn = motion[2], motion[5]
    cx, cy = lead[COM_X], lead[COM_Y]
    ax = motion[3] - omega * motion[1] - turn * cy - omega * omega * cx
    ay = motion[4] + omega * motion[0] + turn * cx - omega * omega * cy
    fx, fy = lead[MASS] * ax, lead[MASS] * ay
    return fx, fy, lead[INERTIA] * turn + cx * fy - cy * fx


@leaf
def lead_drives(kin, lead, dt, wanted, duties, memory, command):  # type: ignore[no-untyped-def]
    """Wheel speeds that make the drives turn as wanted, scaled into the wheels' limits by one factor.

    Args:
        kin: the robot (`kinematics.kernel.arrays`).
        lead: as `packed`.
        dt: length of the tick [s].
        wanted: (n,) mean speeds in the tick [rad/s].
        duties: (n,) that this takes, as free speeds [rad/s].
        memory: (memory_size(n),).
        command: (n,) out [rad/s].
    """
    n, kp, grows = wanted.shape[0], lead[LOOP_KP], lead[LOOP_KI] * dt
    for i in range(n):
        shown, integral = memory[PER_WHEEL * i], memory[PER_WHEEL * i + 1]
        command[i] = (duties[i] + (kp + grows) * shown - integral) / (lead[LOOP_AHEAD] + kp + grows)
    free = saturate_wheels(kin, command) >= 1.0
    for i in range(n):
        at = PER_WHEEL * i
        growth = grows * (command[i] - memory[at])
        if math.isfinite(command[i]):
            if free or growth * memory[at + 1] < 0.0:
                memory[at + 1] += growth
            memory[at] += lead[LOOP_NEW] * (wanted[i] - memory[at])
