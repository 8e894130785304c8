"""Odometry by wheels, ground mice and gyro together: one weighted least squares a tick, each by its noise.

Every wheel with an encoder, every mouse and the gyro is a row or two of the same least squares; what a sensor is
worth follows from its counts and its noise. A wheel that slips, a mouse that is lifted off or dead contradicts the
others and is left out (`estimation.sensor_health`) until it agrees again in motion. With four wheels and two mice
one of them is found in nearly any motion; wheels that all slip alike are outvoted, for mice are the finer sensors.
What cannot be told: two mice that both stand still while the wheels turn are on a robot that is stuck, in the air,
or without its mice, and the mice are believed.

`Estimate.slip` is the root mean square over wheels and mice, those left out too, of what they contradict the trusted
ones in [m/s of rim or over the ground], over the last tenth of a second; `Estimate.suspect` has the bit of each mouse
that is left out, not read, or in doubt.
"""

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np
from numba import njit

from holodrive.errors import InputError
from holodrive.estimation import body_motion
from holodrive.estimation import sensor_state as st
from holodrive.estimation import sensor_table as tb
from holodrive.estimation.mice import mice_of
from holodrive.estimation.mouse_odometry import check, header
from holodrive.estimation.wheel_odometry import gyro_noise
from holodrive.kinematics.chassis import Chassis
from holodrive.types import Array

if TYPE_CHECKING:
    from holodrive.robots.spec import Robot

_PIVOT = 1e-6  # of the scaled normal matrix: below it a motion is not told


@dataclass(frozen=True)
class FusedOdometry:
    """Parameters of odometry by wheels and mice; also an estimator plug.

    Attributes:
        wheel_noise: standard deviation of a wheel's angle after the base moved by that wheel's radius [rad].
        gyro_noise: standard deviation of the gyro's heading after 1 s [rad]; None takes the robot's IMU.
        way_noise, twist_s, tolerance, gate, horizon_s, trust_s, coast_s: as in `MouseOdometry`.
        jump_factor: a reading that would need this many times the largest wheel speed is not believed.
    """

    wheel_noise: float = 0.05
    gyro_noise: float | None = None
    way_noise: float = 1e-4
    twist_s: float = 0.01
    tolerance: float = 0.07
    gate: float = 3.0
    horizon_s: float = 0.1
    trust_s: float = 0.3
    coast_s: float = 0.2
    jump_factor: float = 2.0

    kernel: ClassVar[Any]

    def __post_init__(self) -> None:
        check("fused odometry", self, at_least_0=("wheel_noise", "way_noise", "twist_s", "tolerance", "trust_s"))
        check("fused odometry", self, above_0=("gate", "horizon_s", "coast_s", "jump_factor"))
        if self.gyro_noise is not None:
            check("fused odometry", self, at_least_0=("gyro_noise",))

    def memory_size(self, robot: "Robot") -> int:
        """How many float64 the kernel keeps between ticks."""
        return st.STATES + st.STATE * (len(robot.mice) + len(robot.wheels) + 1)

    def pack(self, robot: "Robot") -> Array:
        """The parameters and the sensors of the robot, as one vector.

        Raises:
            InputError: no mouse, a mouse outside the footprint, no encoder at all, or too few of both.
        """
        mice = mice_of(robot, "fused_odometry", at_least=1)
        speed, _ = tb.stray(robot)
        if Chassis.of(robot).trails:
            raise InputError(
                f"fused_odometry does not know casters or couplings of steered wheels, and {robot.name} has them; "
                "ekf and wheel_odometry do"
            )
        wheels = tb.of_wheels(robot, self.wheel_noise, self.jump_factor)
        if not len(wheels):
            raise InputError(
                f"fused_odometry needs encoders, {robot.name} has none; give [defaults.wheel] an encoder, or use "
                "mouse_odometry"
            )
        table = np.concatenate([tb.of_mice(mice, self.way_noise, self.tolerance, self.jump_factor * speed), wheels])
        if robot.imu is not None:
            noise = gyro_noise(robot) if self.gyro_noise is None else self.gyro_noise
            table = np.concatenate([table, tb.of_gyro(noise, tb.length_of(table))])
        _observable(table, robot)
        return header(self, table, robot)


def _observable(table: Array, robot: "Robot") -> None:
    rows = np.concatenate([block[tb.H : tb.H + 6].reshape(2, 3)[: int(block[tb.ROWS])] for block in table])
    values = np.linalg.svd(rows / [1.0, 1.0, tb.length_of(table)], compute_uv=False)
    if len(values) < 3 or values[-1] < _PIVOT * values[0]:
        raise InputError(
            f"fused_odometry: the encoders and mice of {robot.name} cannot tell all three motions; "
            "add a mouse, or encoders"
        )


@njit(cache=True, error_model="numpy")
def kernel(obs: Array, memory: Array, params: Array, estimate: Array) -> None:
    """One tick over the arrays of `holodrive.layout`."""
    body_motion.tick(obs, memory, params, estimate)


FusedOdometry.kernel = staticmethod(kernel)
