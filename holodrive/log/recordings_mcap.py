"""Our own logs as recordings: the wheels' angles of a run, gyro and true pose where they were known."""

from pathlib import Path

import numpy as np

from holodrive.errors import LogError
from holodrive.log.reader import MAGIC_START, read_content
from holodrive.log.recording import Recording
from holodrive.log.rows import columns_of


def fits(path: Path, head: bytes) -> bool:
    """Whether the file is MCAP."""
    return head.startswith(MAGIC_START)


def runs(path: Path) -> list[str]:
    """The one run."""
    return [path.stem]


def read(path: Path, run: str, robot: str | None) -> Recording:
    """The run; a damaged log gives what is left of it."""
    content = read_content(path)
    recorded, at = content.robot, columns_of(content.robot)
    rows = content.rows
    if not len(rows):
        raise LogError(f"{path}: no control tick in this log" + (f" ({content.damage})" if content.damage else ""))
    truth = rows[:, at["truth"]]
    known = np.isfinite(truth).all(axis=1)
    time, gyro = rows[:, at["time"].start], rows[:, at["gyro"].start]
    return Recording(
        name=run,
        robot=robot or recorded.name,
        time=time.copy(),
        wheels=tuple(wheel.name for wheel in recorded.wheels),
        position=rows[:, at["wheel_position"]].copy(),
        steered=tuple(recorded.wheels[i].name for i in recorded.steered),
        steer=rows[:, at["steer"]].copy(),
        gyro=np.empty(0) if np.isnan(gyro).all() else gyro.copy(),
        truth_time=time[known],
        truth=truth[known],
        family=str(content.settings.get("controller", "")),
        source="holodrive log",
        path=path,
        spec=recorded if robot is None else None,
    )
