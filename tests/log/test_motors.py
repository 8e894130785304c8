"""Claims about what motors do in a log: exact, beside their ticks, in the report and the export, no topic without."""

from pathlib import Path

import numpy as np
import pytest
from logged import ticks
from mcap.reader import make_reader

from holodrive import log, robots
from holodrive.log import Recorder, RunBuilder, Tick
from holodrive.reports.charts import chart_groups
from holodrive.reports.exporting import columns
from holodrive.robots.spec import Robot
from holodrive.types import MotorState


@pytest.fixture(scope="module")
def robot() -> Robot:
    """Three drives and three steerings."""
    return robots.load("swerve3")


def moved(robot: Robot, count: int) -> list[Tick]:
    """Ticks with random motors; the last steering is a servo, of which nothing is known."""
    rng = np.random.default_rng(3)
    values = rng.normal(size=(count, 4, 6))
    values[:, :, 5] = np.nan
    return [each._replace(motors=MotorState(*value)) for each, value in zip(ticks(robot, count), values, strict=True)]


def topics(path: Path) -> set[str]:
    with path.open("rb") as file:
        return {channel.topic for _, channel, _ in make_reader(file).iter_messages()}


def test_currents_torques_and_powers_come_back_exactly(robot: Robot, tmp_path: Path) -> None:
    given = moved(robot, 300)
    builder = RunBuilder(robot, None, {})
    with Recorder(tmp_path / "run.mcap", robot) as recorder:
        for each in given:
            builder.tick(each)
            recorder.tick(each)
    run = log.read(tmp_path / "run.mcap")
    for found in (run, builder.build()):
        for i, name in enumerate(MotorState._fields):
            expected = [np.asarray(each.motors)[i] for each in given]
            np.testing.assert_array_equal(getattr(found.motor_state, name), expected)
    assert log.compare(builder.build(), run) == ()
    assert "/motors" in topics(tmp_path / "run.mcap")


def test_a_run_whose_motors_nobody_knows_has_no_topic_and_no_charts_of_them(robot: Robot, tmp_path: Path) -> None:
    with Recorder(tmp_path / "run.mcap", robot) as recorder:
        for each in ticks(robot, 5):
            recorder.tick(each)
    run = log.read(tmp_path / "run.mcap")
    assert run.motors.shape == (5, 6, 4)
    assert np.isnan(run.motors).all()
    assert "/motors" not in topics(tmp_path / "run.mcap")
    assert "Currents and power" not in [group.title for group in chart_groups(run)]
    assert not [name for name in columns(run) if name.startswith("motor.")]


def test_the_report_draws_and_the_export_names_each_motor(robot: Robot) -> None:
    builder = RunBuilder(robot, None, {})
    for each in moved(robot, 20):
        builder.tick(each)
    run = builder.build()
    (group,) = [group for group in chart_groups(run) if group.title == "Currents and power"]
    by_title = {chart.title: chart for chart in group.charts}
    assert [line.name for line in by_title["Drive current"].known()] == ["front", "right", "left"]
    assert [line.name for line in by_title["Steering current"].known()] == ["front", "right"]
    np.testing.assert_allclose(by_title["Power of all motors"].lines[0].y, np.nansum(run.motors[:, :, 2], axis=1))
    unit, values = columns(run)["motor.left_steer.torque_n_m"]
    assert unit == "N m"
    assert np.isnan(values).all()
    np.testing.assert_array_equal(columns(run)["motor.front.electrical_w"][1], run.motors[:, 0, 2])


def test_motors_of_another_robot_are_refused(robot: Robot) -> None:
    builder = RunBuilder(robot, None, {})
    given = moved(robot, 1)[0]
    with pytest.raises(ValueError, match="6 drives and steerings, a tick has motors of shape"):
        builder.tick(given._replace(motors=MotorState(*np.zeros((4, 3)))))


def test_efficiency_is_known_only_while_a_motor_drives() -> None:
    state = MotorState(
        *(np.array(row) for row in ([1.0] * 5, [1.0] * 5, [4.0, -2.0, 0.0, np.nan, 0.1], [3.0, -4.0, 0.0, 1.0, 8.0]))
    )  # the last lives on what its coils had stored: no efficiency of 8000 %
    np.testing.assert_array_equal(state.efficiency, [0.75, np.nan, np.nan, np.nan, np.nan])
