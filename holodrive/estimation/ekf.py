"""Kalman filter over all that tells motion: wheels, steering, gyro with its bias, measuring wheels and mice.

An extended Kalman filter (Smith, Self and Cheeseman 1990, for poses in the plane) with the state

    pose (3), twist (3), gyro bias, timing of steering angles and of the gyro,
    and of each sensor what its count or sample hides.

The twist strays as a random walk; the pose follows it by the exact step on SE(2); every sensor is a row of
`estimation.ekf_rows`, gated by its innovation. A sensor that the robot lacks, or that falls silent, is left out.
Noise comes from the robot's file: counts, the gyro's noise, bias and walk, the relative noise of ground sensors; what
no file tells, how wheels slip, is a parameter here.
"""

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np
from numba import njit

from holodrive.errors import InputError
from holodrive.estimation import ekf_rows as rw
from holodrive.estimation import ekf_state as es
from holodrive.estimation import ekf_tick
from holodrive.types import Array

if TYPE_CHECKING:
    from holodrive.robots.spec import Robot

_SURGE_S = 0.1  # for which an acceleration lasts
_RAMP_S = 0.3  # in which a robot without acceleration limits reaches its speed


@dataclass(frozen=True)
class Ekf:
    """Parameters of the filter; also an estimator plug.

    Attributes:
        wheel_noise: standard deviation of a wheel's angle after it turned by 1 rad [rad]: slip along its direction;
            grows with the square root of the way.
        side_noise: the same for how far a steered wheel slips sideways, in radians of rim [rad].
        way_noise: standard deviation of what a ground sensor tells after 1 m [m], besides its file's relative noise.
        steer_noise: standard deviation of a measured steering angle [rad].
        steer_timing: of how much sooner or later than told a module points where it is told to, as a share of a tick.
        gyro_timing: the same of the gyro's sample.
        accel_m_s2, yaw_accel_rad_s2: that the robot may have for a tenth of a second; None takes its limits, or what
            brings it to its largest speed in 0.3 s.
        gyro_bias_rad_s: standard deviation of the bias at the start; None takes the amount in the robot's file.
        gate: standard deviations of an innovation beyond which a reading is not believed.
        jump_factor: an increment that would need this many times the wheel's largest speed is not believed.
    """

    wheel_noise: float = 0.02
    side_noise: float = 0.02
    way_noise: float = 1e-4
    steer_noise: float = 0.0
    steer_timing: float = 0.1
    gyro_timing: float = 0.05
    accel_m_s2: float | None = None
    yaw_accel_rad_s2: float | None = None
    gyro_bias_rad_s: float | None = None
    gate: float = 5.0
    jump_factor: float = 1.5

    kernel: ClassVar[Any]

    def __post_init__(self) -> None:
        names = (
            "wheel_noise",
            "side_noise",
            "way_noise",
            "steer_noise",
            "steer_timing",
            "gyro_timing",
            "gyro_bias_rad_s",
        )
        for name in names:
            value = getattr(self, name)
            if value is not None and not value >= 0.0:
                raise InputError(f"ekf: {name} = {value} is not 0 or more")
        for name in ("accel_m_s2", "yaw_accel_rad_s2", "gate", "jump_factor"):
            value = getattr(self, name)
            if value is not None and not value > 0.0:
                raise InputError(f"ekf: {name} = {value} is not above 0")

    def rows(self, robot: "Robot") -> Array:
        """(R, BLOCK) what it measures on this robot.

        Raises:
            InputError: the robot has nothing that tells how it moves.
        """
        rows = rw.table(robot, self.wheel_noise, self.side_noise, self.way_noise, self.jump_factor)
        if not rw.tells_motion(rows):
            raise InputError(
                f"{robot.name} has no encoder, mouse or measuring wheel, so an ekf cannot tell how it moves; "
                "give a wheel an encoder or add [sensor.mouse.NAME]"
            )
        return rows

    def memory_size(self, robot: "Robot") -> int:
        """How many float64 the kernel keeps between ticks."""
        rows = self.rows(robot)
        n = state_size(rows)
        return n + es.FLAGS + n * n + n + n * n + es.ROW * len(rows) + n

    def pack(self, robot: "Robot") -> Array:
        """The parameters, the robot's speeds and the table of its rows, as one vector."""
        rows, imu = self.rows(robot), robot.imu
        speed = max(wheel.max_speed_rad_s * wheel.radius for wheel in robot.wheels)
        yaw_rate = speed / max(1e-3, *(math.hypot(wheel.x, wheel.y) for wheel in robot.wheels))
        head = np.zeros(es.TABLE)
        head[es.SIZE], head[es.ROWS], head[es.GATE] = state_size(rows), len(rows), self.gate**2
        accel = _accel(self.accel_m_s2, robot.limits.accel_m_s2, speed)
        yaw_accel = _accel(self.yaw_accel_rad_s2, robot.limits.yaw_accel_rad_s2, yaw_rate)
        head[es.SURGE], head[es.YAW_SURGE] = accel**2 * _SURGE_S, yaw_accel**2 * _SURGE_S
        head[es.STRAY], head[es.YAW_STRAY] = speed, yaw_rate
        bias = self.gyro_bias_rad_s
        head[es.BIAS] = (abs(imu.gyro_bias_rad_s) if imu else 0.0) if bias is None else bias
        head[es.BIAS_WALK] = imu.gyro_bias_walk_rad_s**2 if imu else 0.0
        head[es.GYRO_PERIOD] = 1.0 / imu.rate_hz if imu else 1.0
        head[es.STEER_NOISE] = self.steer_noise
        head[es.TIMING] = self.steer_timing if robot.steered else 0.0
        head[es.GYRO_TIMING] = self.gyro_timing if imu else 0.0
        return np.concatenate([head, rows.ravel()])


def state_size(rows: Array) -> int:
    """Numbers in the state for a table of rows."""
    return rw.SENSOR_STATES + int(np.sum(rows[:, rw.SLOT] >= 0)) + 1


def _accel(given: float | None, limit: float, speed: float) -> float:
    if given is not None:
        return given
    return limit if math.isfinite(limit) else speed / _RAMP_S


@njit(cache=True, error_model="numpy")
def kernel(obs: Array, memory: Array, params: Array, estimate: Array) -> None:
    """One tick over the arrays of `holodrive.layout`."""
    ekf_tick.tick(obs, memory, params, estimate)


Ekf.kernel = staticmethod(kernel)
