"""How far wheel odometry ends from where the robot truly was, for recorded runs."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from holodrive import robots
from holodrive.estimation.odometry import Counts, track
from holodrive.estimation.wheel_odometry import WheelOdometry
from holodrive.geometry import wrap
from holodrive.log.recording import Recording
from holodrive.robots.spec import Robot
from holodrive.types import Array, Pose

_EVERY = "all"


@dataclass(frozen=True)
class Evaluation:
    """Odometry against truth for one run of N samples. Without truth the errors are NaN.

    Attributes:
        name, family, robot: of the run.
        time: (N,) [s].
        pose: (N, 3) by odometry; starts at the first true pose.
        truth: (N, 3) at the same times, headings continuous; NaN without truth.
        covariance: (N, 3, 3) of `pose`; slip: (N,) [m/s of rim].
        end_error_m, max_error_m, rmse_m: distance to the truth at the end, at its largest, root mean square.
        heading_error_rad: at the end, wrapped, odometry minus truth.
        path_length_m: of the odometry.
        counts: what became of the samples.
    """

    name: str
    family: str
    robot: str
    time: Array
    pose: Array
    truth: Array
    covariance: Array
    slip: Array
    end_error_m: float
    max_error_m: float
    rmse_m: float
    heading_error_rad: float
    path_length_m: float
    counts: Counts


@dataclass(frozen=True, slots=True)
class Medians:
    """Medians over the runs of one family; the heading's sign is left out."""

    family: str
    runs: int
    end_error_m: float
    max_error_m: float
    rmse_m: float
    heading_error_rad: float
    path_length_m: float
    refused: int


def evaluate(recording: Recording, robot: Robot | None = None, params: WheelOdometry | None = None) -> Evaluation:
    """Integrate a recording's wheels from its first true pose on and compare.

    Args:
        recording: with or without truth; without, odometry starts at the origin.
        robot: geometry to use; the recorded robot's own file when None.
        params: of the odometry; the nominal ones use a gyro where the recording has one.

    Raises:
        HolodriveError: the robot is not known, or has other wheels than the recording.
    """
    chosen = robot or recording.spec or robots.load(recording.robot)
    position, steer = recording.positions_of(chosen)
    known = len(recording.truth_time) > 0
    truth = recording.truth_at(recording.time) if known else np.full((len(recording.time), 3), np.nan)
    start = Pose(*truth[0].tolist()) if known else Pose(0.0, 0.0, 0.0)
    gyro = recording.gyro if len(recording.gyro) else None
    odometry = track(chosen, recording.time, position, steer=steer, gyro=gyro, start=start, params=params)
    distance = np.hypot(*(odometry.pose - truth)[:, :2].T)
    way = np.hypot(*np.diff(odometry.pose[:, :2], axis=0).T)
    return Evaluation(
        name=recording.name,
        family=recording.family,
        robot=chosen.name,
        time=recording.time,
        pose=odometry.pose,
        truth=truth,
        covariance=odometry.covariance,
        slip=odometry.slip,
        end_error_m=float(distance[-1]),
        max_error_m=float(distance.max()),
        rmse_m=float(np.sqrt(np.mean(distance**2))),
        heading_error_rad=float(wrap(odometry.pose[-1, 2] - truth[-1, 2])),
        path_length_m=float(way.sum()),
        counts=odometry.counts,
    )


def medians(evaluations: Sequence[Evaluation]) -> list[Medians]:
    """One row for each family, in the order in which they appear, and one for all when there are several."""
    families = list(dict.fromkeys(each.family for each in evaluations))
    rows = [_medians(family, [each for each in evaluations if each.family == family]) for family in families]
    return [*rows, _medians(_EVERY, evaluations)] if len(families) > 1 else rows


def _medians(family: str, each: Sequence[Evaluation]) -> Medians:
    def middle(name: str) -> float:
        return float(np.median([abs(getattr(one, name)) for one in each]))

    return Medians(
        family=family,
        runs=len(each),
        end_error_m=middle("end_error_m"),
        max_error_m=middle("max_error_m"),
        rmse_m=middle("rmse_m"),
        heading_error_rad=middle("heading_error_rad"),
        path_length_m=middle("path_length_m"),
        refused=sum(one.counts.refused for one in each),
    )
