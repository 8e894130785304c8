"""What the Kalman filter measures: each encoder, measuring wheel, mouse and gyro as rows of one table.

In one control period of dt with the mean twist xi, a row of ground or wheel sensors tells

    z = h . xi dt + (u - u') + w

with u the part of a count that the sensor has not told (at the end of the period, u' at its beginning) and w slip and
noise that gather. A steered wheel has two rows: along it rolls, across it must not go; a contact that trails its axis
by c goes across as the module turns, c (omega + delta'), and a coupled drive turns with the steering. The gyro tells
(z + z') / 2 = omega + bias + (n + n') / 2 of two samples, one at each end. u and n are states of the filter, so that
what a count hides now is told later, and is not taken for new noise each time.
"""

import math
from typing import TYPE_CHECKING

import numpy as np

from holodrive.kinematics.chassis import Chassis
from holodrive.types import Array

if TYPE_CHECKING:
    from holodrive.robots.spec import Mouse, Robot, WheelSpec

# --- one row --------------------------------------------------------------------------------------
KIND = 0
INDEX = 1  # which wheel, or 2 k + axis for ground sensor k
STEER = 2  # place in steering arrays
H = 3  # 3: row over the twist; of a module the row along its zero direction [1, 1, m]
H_SIDE = 6  # 3: of a module the row across
UNIT = 9  # m per rad of wheel
QUANTUM = 10  # m per count; rad/s, standard deviation of one sample, of a gyro
RELATIVE, WALK = 11, 12  # variances of noise that gathers: per way squared, per way [1, m]
CASTER, COUPLING = 13, 14  # m, 1
SLOT = 15  # place of u or n in the state, -1 for none
REACH = 16  # m/s: faster is not believed
BLOCK = 17
GYRO, MOUSE, WHEEL, ALONG, ACROSS = 0, 1, 2, 3, 4

SENSOR_STATES = 9  # first place of u and n in the state
_UNTOLD = 1e-9  # m: of a sensor whose counts are not known


def table(robot: "Robot", wheel_noise: float, side_noise: float, way_noise: float, jump_factor: float) -> Array:
    """(R, BLOCK) rows of a robot, those first that the others are judged by: gyro, ground sensors, wheels.

    Args:
        robot: any.
        wheel_noise, side_noise: of wheels, as in `Ekf`.
        way_noise: of ground sensors, as in `Ekf`.
        jump_factor: times its largest speed that a wheel may seem to go.
    """
    reach = jump_factor * max(wheel.max_speed_rad_s * wheel.radius for wheel in robot.wheels)
    rows = [_gyro(robot.imu.gyro_noise_rad_s)] if robot.imu else []
    for k, mouse in enumerate(robot.mice):
        # a ground sensor far out goes faster than any wheel when the robot turns
        arm = 1.0 + math.hypot(mouse.mount.x, mouse.mount.y) / _arm(robot)
        rows += [_mouse(mouse, k, axis, way_noise, arm * reach) for axis in range(len(mouse.axes))]
    chassis = Chassis.of(robot)
    for i, wheel in enumerate(robot.wheels):
        if wheel.encoder is not None:
            rows += _wheel(chassis, i, wheel, wheel_noise, side_noise, jump_factor)
    slot = SENSOR_STATES
    for row in rows:
        has = row[KIND] != ACROSS
        row[SLOT] = slot if has else -1
        slot += has
    return np.array(rows).reshape(-1, BLOCK)


def tells_motion(rows: Array) -> bool:
    """Whether any row tells how the robot moves over the ground."""
    return bool(np.any(rows[:, KIND] != GYRO))


def _arm(robot: "Robot") -> float:
    return max(1e-3, *(math.hypot(wheel.x, wheel.y) for wheel in robot.wheels))


def _gyro(noise: float) -> Array:
    row = np.zeros(BLOCK)
    row[[KIND, STEER, QUANTUM, REACH]] = GYRO, -1, noise, math.inf
    row[H + 2] = 1.0
    return row


def _mouse(mouse: "Mouse", k: int, axis: int, way_noise: float, reach_m_s: float) -> Array:
    row, (x, y, theta) = np.zeros(BLOCK), mouse.mount
    c, s = math.cos(theta + 0.5 * math.pi * axis), math.sin(theta + 0.5 * math.pi * axis)
    row[[KIND, INDEX, STEER]] = MOUSE, 2 * k + axis, -1
    row[H : H + 3] = c, s, s * x - c * y
    row[[UNIT, QUANTUM, RELATIVE, WALK, REACH]] = (
        1.0,
        mouse.resolution_m or _UNTOLD,
        mouse.noise_relative**2,
        way_noise**2,
        reach_m_s,
    )
    return row


def _wheel(
    chassis: Chassis, i: int, wheel: "WheelSpec", wheel_noise: float, side_noise: float, jump_factor: float
) -> list[Array]:
    row, at, radius = np.zeros(BLOCK), chassis.row[i], wheel.radius
    counts = wheel.encoder.counts_per_turn if wheel.encoder else math.inf
    row[[INDEX, STEER, UNIT]] = i, -1, radius
    row[QUANTUM], row[WALK] = 2.0 * math.pi * radius / counts, wheel_noise**2 * radius
    row[REACH] = jump_factor * wheel.max_speed_rad_s * radius
    if wheel.kind != "swerve":
        row[KIND], row[H : H + 3] = WHEEL, radius * chassis.jacobian[at]
        return [row]
    row[KIND], row[STEER] = ALONG, chassis.steered.index(i)
    row[H : H + 3], row[H_SIDE : H_SIDE + 3] = chassis.jacobian[at : at + 2]
    if wheel.steering:
        row[CASTER], row[COUPLING] = wheel.steering.caster_m, wheel.steering.coupling
    across = row.copy()
    across[KIND], across[QUANTUM], across[WALK] = ACROSS, 0.0, side_noise**2 * radius
    return [row, across]
