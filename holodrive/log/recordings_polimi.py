"""The PoliMi recordings: a four-Mecanum robot with encoder counts and motion capture, each with its own stamps."""

from pathlib import Path

import numpy as np

from holodrive.errors import LogError
from holodrive.log.encoders import counts_per_turn
from holodrive.log.npz import arrays, is_npz, one_array
from holodrive.log.recording import Recording

ROBOT = "polimi_mecanum4"
WHEELS = ("fl", "fr", "rl", "rr")  # order of the columns of `ticks`
_KEYS = {"wheel_stamp", "ticks", "pose_stamp", "pose_xyyaw"}


def fits(path: Path, head: bytes) -> bool:
    """Whether the file has the four arrays."""
    return is_npz(head) and set(arrays(path)) >= _KEYS


def runs(path: Path) -> list[str]:
    """The one run."""
    return [path.stem]


def read(path: Path, run: str, robot: str | None) -> Recording:
    """The run, its time from the first wheel sample on; the true yaw wraps."""
    stamp, ticks, truth_stamp, truth = (
        one_array(path, key) for key in ("wheel_stamp", "ticks", "pose_stamp", "pose_xyyaw")
    )
    if not len(stamp) or ticks.shape != (len(stamp), len(WHEELS)) or truth.shape != (len(truth_stamp), 3):
        raise LogError(
            f"{path}: found {stamp.shape} stamps, {ticks.shape} ticks, {truth_stamp.shape} and {truth.shape} poses; "
            "expected (N,), (N, 4), (M,), (M, 3)"
        )
    turn = counts_per_turn(robot or ROBOT, WHEELS, "a PoliMi recording")
    return Recording(
        name=run,
        robot=robot or ROBOT,
        time=stamp - stamp[0],
        wheels=WHEELS,
        position=(ticks - ticks[0]) * (2.0 * np.pi / turn),
        truth_time=truth_stamp - stamp[0],
        truth=truth,
        family="polimi",
        source="PoliMi four-Mecanum recordings",
        licence="none stated: for own tests only",
        path=path,
    )
