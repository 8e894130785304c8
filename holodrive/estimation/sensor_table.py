"""The sensors that tell a displacement, as one table for kernels: mice, wheels, gyro, each a row or two.

All rows are in metres (a mouse's way, a wheel's rim, the gyro's turn times a length), so one solver and one judge of
health serve them all. In a tick in which the sensor passes s and the base moves by m it gathers noise of the variance

    (relative s)^2 + walk m + drift dt

and beside it is never more than one count wrong, however many ticks are added up, for counts are carried on.
"""

import math
from typing import TYPE_CHECKING

import numpy as np

from holodrive.estimation.mice import rows_of
from holodrive.kinematics.chassis import Chassis
from holodrive.types import Array

if TYPE_CHECKING:
    from collections.abc import Sequence

    from holodrive.robots.spec import Mouse, Robot

# --- one sensor in the table -----------------------------------------------------------------------
KIND = 0  # MOUSE, WHEEL, MODULE or GYRO
INDEX = 1  # which mouse or wheel
ROWS = 2  # 1 or 2
H = 3  # 2 x 3 [1, 1, m]
QUANTUM = 9  # m
RELATIVE, WALK, DRIFT = 10, 11, 12  # as variances: 1, m^2/m, m^2/s
TOLERANCE = 13  # share of its way that a healthy one may be wrong by
REACH = 14  # m/s: faster is not believed
RADIUS = 15  # m per unit of what is read
STEER = 16  # place in steering arrays
BLOCK = 17
MOUSE, WHEEL, MODULE, GYRO = 0, 1, 2, 3

WHEEL_TOLERANCE = 0.1  # rollers, and a radius that load changes
GYRO_TOLERANCE = 0.02


def of_mice(mice: "Sequence[Mouse]", way_noise: float, tolerance: float, reach_m_s: float) -> Array:
    """(k, BLOCK) for ground sensors.

    Args:
        mice: k of them.
        way_noise: standard deviation after the base moved 1 m [m].
        tolerance: share of its way that a healthy one may be wrong by.
        reach_m_s: the fastest that one can go over the ground.
    """
    table = np.zeros((len(mice), BLOCK))
    for k, mouse in enumerate(mice):
        table[k, [KIND, INDEX, ROWS, STEER]] = MOUSE, k, len(mouse.axes), -1  # a measuring wheel tells its x alone
        table[k, H : H + 6] = rows_of(mouse.mount).ravel()
        table[k, QUANTUM : REACH + 1] = (
            mouse.resolution_m,
            mouse.noise_relative**2,
            way_noise**2,
            0.0,
            tolerance,
            reach_m_s,
        )
        table[k, RADIUS] = 1.0
    return table


def of_wheels(robot: "Robot", wheel_noise: float, jump_factor: float) -> Array:
    """(w, BLOCK) for the wheels that have encoders.

    Args:
        robot: any.
        wheel_noise: standard deviation of a wheel's angle after the base moved by a wheel's radius [rad].
        jump_factor: an increment that would need this many times the wheel's largest speed is not believed.
    """
    chassis, blocks = Chassis.of(robot), []
    for i, (wheel, spec) in enumerate(zip(chassis.wheels, robot.wheels, strict=True)):
        if spec.encoder is None:
            continue
        block, row = np.zeros(BLOCK), chassis.row[i]
        kind, rows, unit = (MODULE, 2, 1.0) if wheel.steered else (WHEEL, 1, wheel.radius)
        block[[KIND, INDEX, ROWS]] = kind, i, rows
        block[H : H + 3 * rows] = unit * chassis.jacobian[row : row + rows].ravel()
        quantum = 2.0 * math.pi * wheel.radius / spec.encoder.counts_per_turn
        walk = wheel_noise**2 * wheel.radius
        reach = jump_factor * wheel.max_speed * wheel.radius
        block[QUANTUM : REACH + 1] = quantum, 0.0, walk, 0.0, WHEEL_TOLERANCE, reach
        block[RADIUS] = wheel.radius
        block[STEER] = chassis.steered.index(i) if wheel.steered else -1
        blocks.append(block)
    return np.array(blocks).reshape(-1, BLOCK)


def of_gyro(noise: float, length_m: float) -> Array:
    """(1, BLOCK) for a gyro with that standard deviation of its heading after 1 s [rad]."""
    block = np.zeros(BLOCK)
    block[[KIND, ROWS, STEER]] = GYRO, 1, -1
    block[H : H + 3] = 0.0, 0.0, length_m
    block[QUANTUM : REACH + 1] = 0.0, 0.0, 0.0, (noise * length_m) ** 2, GYRO_TOLERANCE, math.inf
    block[RADIUS] = length_m
    return block[None]


def length_of(table: Array) -> float:
    """How many metres a radian counts: the mean lever of the rows, so that columns are alike [m]."""
    rows = np.concatenate([block[H : H + 6].reshape(2, 3)[: int(block[ROWS])] for block in table])
    flat = np.hypot(rows[:, 0], rows[:, 1])
    levers = np.abs(rows[:, 2])[flat > 0.0] / flat[flat > 0.0]
    return max(float(levers.mean()), 1e-3) if len(levers) else 1.0


def stray(robot: "Robot | None") -> tuple[float, float]:
    """How fast a robot of which nobody knows anything may move [m/s, rad/s]: as its wheels allow."""
    if robot is None:
        return 0.1, 0.5
    speed = max(wheel.max_speed_rad_s * wheel.radius for wheel in robot.wheels)
    arm = max(1e-3, *(math.hypot(wheel.x, wheel.y) for wheel in robot.wheels))
    return speed, speed / arm
