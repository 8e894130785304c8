"""Any drive in a log as a calibration of mice: its track is the truth, or wheel odometry, and no tape is needed."""

from collections.abc import Sequence

import numpy as np

from holodrive.calibration.mouse_runs import Accuracy, MouseRun, tracked
from holodrive.errors import InputError
from holodrive.log.run import Run

BY_WHEELS = "wheel_odometry"


def runs_of(run: Run, mice: Sequence[str], accuracy: Accuracy) -> list[MouseRun]:
    """The pieces of a recorded drive.

    Args:
        run: from `log.read`; its mice are in metres by the resolution of its own robot.
        mice: names that it must have.
        accuracy: of its track.

    Raises:
        InputError: other mice, or neither truth nor wheel odometry in it.
    """
    found = [mouse.name for mouse in run.robot.mice]
    if found != list(mice):
        raise InputError(
            f"the log is of a robot with the mice {', '.join(found) or 'none'}; asked for {', '.join(mice)}"
        )
    known = bool(np.isfinite(run.pose).all(axis=1).any())
    if not known and run.settings.get("estimator") != BY_WHEELS:
        raise InputError(
            "the log holds no track to calibrate mice by: no truth, and an estimate by "
            f"{run.settings.get('estimator')!r}; drive with --estimator {BY_WHEELS}, "
            "or use a spin and two straight runs"
        )
    # whole counts again: metres of the log are counts times a resolution that may be wrong
    counts = np.round(run.mice / np.array([mouse.resolution_m for mouse in run.robot.mice])[:, None])
    name = run.path.stem if run.path else "log"
    return tracked(name, np.nan_to_num(counts), run.pose if known else run.estimate, accuracy)
