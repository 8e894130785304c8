"""Claims about odometry on recorded robots: the numbers that others measured."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from holodrive import robots
from holodrive.errors import LogError
from holodrive.estimation import WheelOdometry, evaluate, medians
from holodrive.log import recordings


def test_the_shipped_runs_give_the_published_errors() -> None:
    """The circular and the square run are the median runs of their families."""
    found = {each.family: each for each in (evaluate(each) for each in recordings.read_all(recordings.SHIPPED))}
    assert round(found["circular"].end_error_m * 1e3) == 219
    assert round(found["square"].end_error_m * 1e3) == 139
    assert round(found["joystick"].end_error_m * 1e3) == 85
    assert all(each.counts.refused == 0 for each in found.values())


def test_forty_runs_of_a_real_omni_robot(shared_data: Path) -> None:
    """Nominal geometry: 174.8 mm at the end, 216 mm on the way, 12.4 degrees."""
    evaluations = [evaluate(each) for each in recordings.read_all(shared_data / "optiodom_omni3" / "runs.npz")]
    table = {row.family: row for row in medians(evaluations)}
    assert {family: row.runs for family, row in table.items()} == {
        "circular": 22,
        "joystick": 7,
        "square": 11,
        "all": 40,
    }
    assert table["all"].end_error_m * 1e3 == pytest.approx(174.8, abs=0.05)
    assert round(table["circular"].end_error_m * 1e3) == 219
    assert round(table["square"].end_error_m * 1e3) == 139
    assert round(table["joystick"].end_error_m * 1e3) == 84
    assert round(table["all"].max_error_m * 1e3) == 216
    assert np.degrees(table["all"].heading_error_rad) == pytest.approx(12.4, abs=0.05)
    assert table["all"].refused == 0


@pytest.mark.parametrize(("bag", "rmse_m"), [("bag1", 0.215), ("bag2", 1.217)])
def test_a_real_mecanum_robot(bag: str, rmse_m: float, shared_data: Path) -> None:
    found = evaluate(recordings.read(shared_data / "polimi_mecanum" / f"{bag}.npz"))
    assert found.rmse_m == pytest.approx(rmse_m, abs=5e-4)
    assert found.counts.refused == 0


def test_another_geometry_gives_another_way() -> None:
    """Wheels 4 % smaller go 4 % less far."""
    recording = recordings.read("square_221220201934_run-04")
    robot = robots.load("optiodom_omni3")
    smaller = replace(robot, wheels=tuple(replace(wheel, radius=0.96 * wheel.radius) for wheel in robot.wheels))
    way = evaluate(recording).path_length_m
    assert evaluate(recording, smaller).path_length_m == pytest.approx(0.96 * way, rel=1e-4)


def test_a_recording_without_truth_is_integrated_all_the_same() -> None:
    recording = recordings.read("joystick_221220202235_run-08")
    blind = replace(recording, truth_time=np.empty(0), truth=np.empty((0, 3)))
    found = evaluate(blind)
    assert np.isnan([found.end_error_m, found.rmse_m, found.heading_error_rad]).all()
    assert found.path_length_m == pytest.approx(evaluate(recording).path_length_m)
    with pytest.raises(LogError, match="no true poses"):
        blind.truth_at(blind.time)


def test_bad_samples_are_counted_in_the_evaluation() -> None:
    recording = recordings.read("square_221220201934_run-04")
    time, position = recording.time.copy(), recording.position.copy()
    time[100] = time[99]
    position[200, 1] = np.nan
    position[300] += 1e5
    found = evaluate(replace(recording, time=time, position=position))
    clean = evaluate(recording)
    assert (found.counts.duplicates, found.counts.bad_values, found.counts.jumps) == (1, 1, 1)
    assert found.end_error_m == pytest.approx(clean.end_error_m, abs=1e-4)
    assert medians([found, clean])[0].refused == 3


def test_the_columns_find_their_wheels_by_name() -> None:
    recording = recordings.read("square_221220201934_run-04")
    order = [2, 0, 1]
    shuffled = replace(
        recording, wheels=tuple(recording.wheels[i] for i in order), position=recording.position[:, order]
    )
    np.testing.assert_array_equal(evaluate(shuffled).pose, evaluate(recording).pose)


def test_a_robot_with_other_wheels_is_refused_by_their_names() -> None:
    recording = recordings.read("square_221220201934_run-04")
    with pytest.raises(LogError, match=r"front_right, front_left, rear .*'mecanum4' has"):
        evaluate(recording, robots.load("mecanum4"))


def test_the_covariance_of_a_real_run_tells_the_size_of_its_error() -> None:
    """Not calibrated, but of the right order: the error is within six standard deviations and not below a tenth."""
    for recording in recordings.read_all(recordings.SHIPPED):
        found = evaluate(recording, params=WheelOdometry())
        error = found.pose[-1] - found.truth[-1]
        size = float(np.sqrt(error @ np.linalg.solve(found.covariance[-1], error)))
        assert 0.1 < size < 6.0
