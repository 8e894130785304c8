"""What a real robot's encoders told, and where the robot truly was: one recorded run."""

from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from holodrive.errors import LogError
from holodrive.robots.spec import Robot
from holodrive.types import Array


def _nothing() -> Array:
    return np.empty(0)


def _no_poses() -> Array:
    return np.empty((0, 3))


@dataclass(frozen=True)
class Recording:
    """One recorded run; N samples of n wheels, M truth poses.

    Attributes:
        name: of the run.
        robot: name in the catalog, or path, of the robot that was recorded.
        spec: the robot itself, where the file brings it.
        time: (N,) stamp of each sample [s]; stamps may repeat.
        wheels: names of the wheels, in the order of the columns of `position`.
        position: (N, n) wheel angles since some zero [rad], positive as the robot's file says.
        steered, steer: names of the steered wheels and their angles (N, m) [rad].
        gyro: (N,) yaw rate [rad/s], NaN where there is none; empty without a gyro.
        truth_time, truth: (M,) [s] and (M, 3) pose by motion capture or simulation, heading of any turn.
        family: kind of motion, for tables of medians.
        source, licence: where it comes from.
        path: of the file.
    """

    name: str
    robot: str
    time: Array
    wheels: tuple[str, ...]
    position: Array
    steered: tuple[str, ...] = ()
    steer: Array = field(default_factory=_nothing)
    gyro: Array = field(default_factory=_nothing)
    truth_time: Array = field(default_factory=_nothing)
    truth: Array = field(default_factory=_no_poses)
    family: str = ""
    source: str = ""
    licence: str = ""
    path: Path | None = None
    spec: Robot | None = None

    def truth_at(self, time: Array) -> Array:
        """(k, 3) true pose at times (k,): linear between truth poses, held before the first and after the last.

        The heading comes out continuous, so that errors of more than a turn stay visible.

        Raises:
            LogError: the recording has no truth.
        """
        if not len(self.truth_time):
            raise LogError(f"recording {self.name!r} has no true poses to compare with")
        poses = self.truth.copy()
        poses[:, 2] = np.unwrap(poses[:, 2])
        return np.stack([np.interp(time, self.truth_time, poses[:, i]) for i in range(3)], axis=-1)

    def positions_of(self, robot: Robot) -> tuple[Array, Array]:
        """Wheel angles (N, n) and steering angles (N, m) in the order of the robot's own wheels.

        Raises:
            LogError: the robot has other wheels.
        """
        names = [wheel.name for wheel in robot.wheels]
        steered = [names[i] for i in robot.steered]
        if sorted(names) != sorted(self.wheels) or sorted(steered) != sorted(self.steered):
            raise LogError(
                f"recording {self.name!r} has the wheels {', '.join(self.wheels)} (steered: "
                f"{', '.join(self.steered) or 'none'}), robot {robot.name!r} has {', '.join(names)} "
                f"(steered: {', '.join(steered) or 'none'})"
            )
        position = self.position[:, [self.wheels.index(name) for name in names]]
        steer = (
            self.steer[:, [self.steered.index(name) for name in steered]] if steered else np.empty((len(position), 0))
        )
        return position, steer
