"""Any recorded drive calibrates mice: by the truth in it, or by wheel odometry."""

from dataclasses import replace

import numpy as np
import pytest

from holodrive import build, planning, robots
from holodrive.calibration.mice import calibrate
from holodrive.calibration.mouse_log import runs_of
from holodrive.calibration.mouse_runs import Accuracy
from holodrive.errors import InputError
from holodrive.log.run import Run

MICE = ("one", "two")


@pytest.fixture(scope="module")
def driven() -> Run:
    """An infinity of a robot whose second mouse is turned by 3 degrees and counts 9.5 um."""
    hidden = {"sensor.mouse.two.mount.yaw": "3 deg", "sensor.mouse.two.resolution": "9.5 um"}
    robot = robots.load("mecanum4", hidden)
    way = planning.follow(planning.lemniscate(0.2), 0.03)
    base = build.simulate(robot, seed=1, start=way.rows[0, 1:4])
    return build.drive(base, "pid", trajectory=way, duration_s=40.0, estimator="wheel_odometry")


@pytest.mark.parametrize("truth", [True, False])
def test_the_mounts_come_out_of_any_drive(driven: Run, truth: bool) -> None:
    """Wheels that do not slip are as good a track as the truth."""
    run = driven if truth else replace(driven, pose=np.full_like(driven.pose, np.nan))
    found = calibrate(runs_of(run, MICE, Accuracy()), MICE, driven.robot.footprint_radius_m)
    for mouse in driven.robot.mice:
        for name, value in (("yaw", mouse.mount.theta), ("scale", mouse.resolution_m)):
            each = found.parameter(mouse.name, name)
            assert each.told
            assert abs(each.value - value) < 4.0 * each.sigma + 2e-3 * abs(value)


def test_a_track_by_the_mice_themselves_is_none(driven: Run) -> None:
    run = replace(driven, pose=np.full_like(driven.pose, np.nan), settings={"estimator": "mouse_odometry"})
    with pytest.raises(InputError, match="no truth, and an estimate by 'mouse_odometry'"):
        runs_of(run, MICE, Accuracy())


def test_a_log_of_other_mice_is_refused(driven: Run) -> None:
    with pytest.raises(InputError, match="a robot with the mice one, two; asked for left, right"):
        runs_of(driven, ("left", "right"), Accuracy())
