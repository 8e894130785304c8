"""What was found goes into the robot's file, and nothing else of it changes."""

import math
from dataclasses import replace

import pytest
from made_up_runs import FOOTPRINT_M, MICE, SCALES, runs

from holodrive import robots
from holodrive.calibration.mice import MiceCalibration, calibrate
from holodrive.calibration.mouse_file import rewritten
from holodrive.calibration.mouse_notes import moved
from holodrive.errors import InputError

TEXT = robots.load("mecanum4").text


def found(*kinds: str) -> MiceCalibration:
    return calibrate(runs(0, kinds or ("spin", "ahead", "left")), MICE, FOOTPRINT_M)  # type: ignore[arg-type]


def test_the_file_says_what_was_found() -> None:
    """To a thousandth of a millimetre, a ten-thousandth of a degree, five digits of a count."""
    result = found()
    robot = robots.parse(rewritten(TEXT, "robot.toml", result))
    for mouse, mount, scale in zip(robot.mice, result.mounts, result.scales_m[:, 0], strict=True):
        assert mouse.mount.x == pytest.approx(mount.x, abs=5.1e-7)
        assert mouse.mount.y == pytest.approx(mount.y, abs=5.1e-7)
        assert mouse.mount.theta == pytest.approx(mount.theta, abs=math.radians(5.1e-5))
        assert mouse.resolution_m == pytest.approx(scale, abs=5.1e-12)
    assert replace(robot, mice=(), text="") == replace(robots.parse(TEXT), mice=(), text="")


def test_comments_and_order_stay() -> None:
    """But for those that told where the old numbers came from."""
    new = rewritten(TEXT, "robot.toml", found()).splitlines()
    old = TEXT.splitlines()
    kept = [line for line in new if line in old]
    assert kept == [line for line in old if "mount" not in line]
    assert not any("# Keek: mouse 1 is the robot's position" in line for line in new)
    assert sum("# calibrated, standard deviations x 0" in line and " mm, yaw " in line for line in new) == 2
    assert sum("# calibrated, standard deviation " in line for line in new) == 2


def test_what_was_not_told_stays_what_it_was() -> None:
    """Without a spin the lever arms are those of the file; angle and scale are new."""
    robot = robots.parse(rewritten(TEXT, "robot.toml", found("ahead", "left")))
    for mouse, old, scale in zip(robot.mice, robots.parse(TEXT).mice, SCALES[:, 0], strict=True):
        assert mouse.mount[:2] == old.mount[:2]
        assert mouse.mount.theta != old.mount.theta
        assert mouse.resolution_m == pytest.approx(scale, rel=0.01)


def test_a_result_that_tells_nothing_is_not_written() -> None:
    result = found("spin")
    nothing = replace(result, parameters=tuple(replace(each, told=False) for each in result.parameters))
    with pytest.raises(InputError, match="tell nothing that could be written"):
        rewritten(TEXT, "robot.toml", nothing)


def test_a_file_of_other_mice_is_refused() -> None:
    with pytest.raises(InputError, match="has no mouse 'one'; it has eins, two"):
        rewritten(TEXT.replace("[sensor.mouse.one]", "[sensor.mouse.eins]"), "robot.toml", found())


def test_mice_that_come_out_far_from_the_file_are_told() -> None:
    """A wrong sign of the turns contradicts nothing in the runs; the file does."""
    mice, result = robots.parse(TEXT).mice, found()
    assert moved(result.parameters, mice, FOOTPRINT_M) == ()
    one, two = mice
    other = replace(two, mount=two.mount._replace(x=-two.mount.x), resolution_m=40.0 * two.resolution_m)
    place, scale = moved(result.parameters, (one, other), FOOTPRINT_M)
    assert "mouse two comes out 198 mm from" in place
    assert "look at the number and the sign of the turns" in place
    assert "a count of mouse two comes out 0.0227 times that of the file" in scale
