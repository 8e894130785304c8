"""Wheel odometry outside the loop: sample by sample, or a whole recording at once."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from holodrive import layout
from holodrive.errors import InputError
from holodrive.estimation import wheel_odometry as wo
from holodrive.estimation.wheel_odometry import WheelOdometry
from holodrive.kinematics.chassis import Chassis
from holodrive.robots.spec import Robot
from holodrive.types import Array, Estimate, Pose, Twist, WheelState

_ORIGIN = Pose(0.0, 0.0, 0.0)


@dataclass(frozen=True, slots=True)
class Counts:
    """What became of the samples.

    Attributes:
        used: moved the pose.
        duplicates: had the time stamp of the one before.
        bad_stamps: went back in time, or had no time.
        bad_values: held NaN or infinite wheel angles.
        jumps: would have needed wheels faster than they are.
    """

    used: int = 0
    duplicates: int = 0
    bad_stamps: int = 0
    bad_values: int = 0
    jumps: int = 0

    @property
    def refused(self) -> int:
        """All that did not move the pose; the first sample, which only starts, is not among them."""
        return self.duplicates + self.bad_stamps + self.bad_values + self.jumps


@dataclass(frozen=True)
class Track:
    """Odometry of a whole recording, one row a sample.

    Attributes:
        pose: (N, 3) in the frame of the start pose, heading not wrapped.
        twist: (N, 3) in `base_link`.
        covariance: (N, 3, 3) of the pose, world axes.
        slip: (N,) [m/s of rim].
        counts: of the samples.
    """

    pose: Array
    twist: Array
    covariance: Array
    slip: Array
    counts: Counts


class Odometry:
    """Wheel odometry of a robot or a chassis, one `update` for each encoder reading.

    Example:
        >>> from holodrive.kinematics import Chassis, Wheel
        >>> from math import cos, pi, sin
        >>> wheels = [Wheel.omni(0.2 * cos(a), 0.2 * sin(a), a + pi / 2, 0.05) for a in (0, 2 * pi / 3, 4 * pi / 3)]
        >>> odometry = Odometry(Chassis(wheels))
        >>> odometry.update([0.0, 0.0, 0.0], stamp=0.0).pose
        Pose(x=0.0, y=0.0, theta=0.0)
        >>> round(odometry.update([1.0, 1.0, 1.0], stamp=0.1).pose.theta, 6)  # 5 cm of rim at 20 cm
        0.25
    """

    def __init__(self, robot: Robot | Chassis, params: WheelOdometry | None = None, pose: Pose = _ORIGIN) -> None:
        self.params = params or WheelOdometry()
        self._n, self._m = len(robot.wheels), len(robot.steered)
        self._params = self.params.pack(robot)
        self._memory = np.zeros(self.params.memory_size(robot))
        self.reset(pose)

    def reset(self, pose: Pose = _ORIGIN) -> None:
        """Start anew from a known pose; the next sample only starts, it does not move."""
        self._memory[:] = 0.0
        self._memory[:3] = pose

    def update(
        self,
        wheels: WheelState | ArrayLike,
        heading: float | None = None,
        *,
        stamp: float,
        steer: ArrayLike = (),
        gyro: float | None = None,
    ) -> Estimate:
        """Take one reading.

        Args:
            wheels: a `WheelState`, or the wheel angles (n,) [rad] with `steer` (m,) [rad] beside them.
            heading: of a compass or an integrated gyro [rad]; any zero, turns need not be counted.
            stamp: time of the reading [s].
            gyro: yaw rate [rad/s], used when there is no heading.
        """
        if isinstance(wheels, WheelState):
            position, angles = wheels.position, wheels.steer
        else:
            position, angles = np.asarray(wheels, dtype=np.float64), np.asarray(steer, dtype=np.float64)
        if position.shape != (self._n,) or angles.shape != (self._m,):
            raise InputError(
                f"odometry of {self._n} wheels, {self._m} steered, was given "
                f"{position.shape} wheel and {angles.shape} steering angles"
            )
        nan = np.nan
        wo.step(
            self._params,
            self._memory,
            float(stamp),
            position,
            angles,
            nan if gyro is None else float(gyro),
            nan if heading is None else float(heading),
        )
        return self.estimate

    @property
    def estimate(self) -> Estimate:
        """The belief after the last reading."""
        memory = self._memory.tolist()
        return Estimate(
            Pose(*memory[:3]),
            Twist(*memory[wo.TWIST : wo.TWIST + 3]),
            self._memory[wo.COVARIANCE : wo.COVARIANCE + 9].reshape(3, 3).copy(),
            memory[wo.SLIP],
        )

    @property
    def counts(self) -> Counts:
        """What became of the readings since the last reset."""
        return Counts(*(int(value) for value in self._memory[wo.USED : wo.JUMPS + 1]))


def track(
    robot: Robot | Chassis,
    time: ArrayLike,
    position: ArrayLike,
    *,
    steer: ArrayLike | None = None,
    gyro: ArrayLike | None = None,
    heading: ArrayLike | None = None,
    start: Pose = _ORIGIN,
    params: WheelOdometry | None = None,
) -> Track:
    """Odometry over a whole recording: times (N,) [s], wheel angles (N, n) [rad], steering angles (N, m) [rad]."""
    params = params or WheelOdometry()
    times = np.ascontiguousarray(time, dtype=np.float64)
    n, m = len(robot.wheels), len(robot.steered)
    unknown = np.full(len(times), np.nan)
    wheels = _samples("wheel angles", position, (len(times), n))
    angles = _samples("steering angles", np.zeros((len(times), m)) if steer is None else steer, (len(times), m))
    rates = _samples("gyro", unknown if gyro is None else gyro, (len(times),))
    headings = _samples("heading", unknown if heading is None else heading, (len(times),))
    memory = np.zeros(params.memory_size(robot))
    memory[:3] = start
    out = np.empty((len(times), layout.ESTIMATE_SIZE))
    wo.integrate(params.pack(robot), memory, times, wheels, angles, rates, headings, out)
    return Track(
        pose=out[:, layout.EST_POSE : layout.EST_POSE + 3].copy(),
        twist=out[:, layout.EST_TWIST : layout.EST_TWIST + 3].copy(),
        covariance=out[:, layout.EST_COVARIANCE : layout.EST_COVARIANCE + 9].reshape(-1, 3, 3).copy(),
        slip=out[:, layout.EST_SLIP].copy(),
        counts=Counts(*(int(value) for value in memory[wo.USED : wo.JUMPS + 1])),
    )


def _samples(what: str, values: ArrayLike, shape: tuple[int, ...]) -> Array:
    array = np.ascontiguousarray(values, dtype=np.float64)
    if array.shape != shape:
        raise InputError(f"odometry: {what} have the shape {array.shape}, expected {shape}")
    return array
