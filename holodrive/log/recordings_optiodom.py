"""The data set "optiodom": runs of a three-omni robot, each an array of time, true pose and encoder pulses."""

from pathlib import Path

import numpy as np

from holodrive.errors import LogError
from holodrive.log.encoders import counts_per_turn
from holodrive.log.npz import arrays, is_npz, one_array
from holodrive.log.recording import Recording

ROBOT = "optiodom_omni3"
# columns: t [s], x [m], y [m], theta [rad], pulses since the last row of the wheels in this order
WHEELS = ("front_right", "front_left", "rear")
_COLUMNS = 7


def fits(path: Path, head: bytes) -> bool:
    """Whether every array of the file is a table of seven columns."""
    if not is_npz(head):
        return False
    shapes = arrays(path)
    return bool(shapes) and all(len(shape) == 2 and shape[1] == _COLUMNS for shape in shapes.values())


def runs(path: Path) -> list[str]:
    """Names of the runs, as `circular_221220201643_run-01`."""
    return [_name(key) for key in arrays(path)]


def read(path: Path, run: str, robot: str | None) -> Recording:
    """One run. Its first row holds the start: the pulses in it came before."""
    key = {_name(key): key for key in arrays(path)}[run]
    table = one_array(path, key)
    if not len(table) or not np.isfinite(table).all():
        raise LogError(f"{path}: run {run} is empty or holds numbers that are not finite")
    turn = counts_per_turn(robot or ROBOT, WHEELS, "an optiodom recording")
    pulses = table[:, 4:].copy()
    pulses[0] = 0.0
    return Recording(
        name=run,
        robot=robot or ROBOT,
        time=table[:, 0].copy(),
        wheels=WHEELS,
        position=np.cumsum(pulses, axis=0) * (2.0 * np.pi / turn)[None, :],
        truth_time=table[:, 0].copy(),
        truth=table[:, 1:4].copy(),
        family=run.partition("_")[0],
        source="optiodom, data/omni3 (github.com/sousarbarb/optiodom)",
        licence="MIT, (c) 2021 Ricardo Sousa, Marcelo Petry, António Moreira, Paulo Costa",
        path=path,
    )


def _name(key: str) -> str:
    """`circular__221220201643__221220201643_run-01.csv` says its stamp twice."""
    family, _, rest = key.removesuffix(".csv").partition("__")
    return f"{family}_{rest.rpartition('__')[2]}" if rest else family
