"""Claims about IMU and mice in a log: exact, beside their ticks, readable by other tools, no topic without them."""

import math
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from logged import ticks
from mcap.reader import make_reader
from mcap.writer import CompressionType, Writer
from rosbags.highlevel import AnyReader

from holodrive import log, robots
from holodrive.estimation import evaluate
from holodrive.log import Recorder, RunBuilder, recordings
from holodrive.robots.spec import Mouse, Robot
from holodrive.types import Pose


@pytest.fixture(scope="module")
def both(hybrid3: Robot) -> Robot:
    """A robot with an IMU that sits askew, and two mice."""
    assert hybrid3.imu is not None
    mice = (Mouse("left", Pose(0.0, 0.1, 0.5)), Mouse("right", Pose(0.0, -0.1, 0.0)))
    return replace(hybrid3, imu=replace(hybrid3.imu, mount=Pose(0.02, 0.0, 1.0)), mice=mice)


def messages(path: Path, *topics: str) -> list[Any]:
    """What rosbags makes of the messages of some topics."""
    with AnyReader([path]) as reader:
        wanted = [each for each in reader.connections if each.topic in topics]
        return [reader.deserialize(raw, each.msgtype) for each, _, raw in reader.messages(wanted)]


def rewritten(source: Path, target: Path, without: tuple[str, ...] = ()) -> Path:
    """The log as another tool writes it: other numbers of channels and messages, some topics left out."""
    writer, channels = Writer(str(target), compression=CompressionType.NONE), dict[str, int]()
    writer.start("ros2", "other")
    with source.open("rb") as file:
        for schema, channel, message in make_reader(file).iter_messages():
            assert schema is not None
            if channel.topic in without:
                continue
            if channel.topic not in channels:
                number = writer.register_schema(schema.name, schema.encoding, schema.data)
                channels[channel.topic] = writer.register_channel(channel.topic, "cdr", number)
            writer.add_message(channels[channel.topic], message.log_time, message.data, message.publish_time)
    writer.finish()  # type: ignore[no-untyped-call]
    return target


def test_gyro_accel_and_mice_come_back_exactly(both: Robot, tmp_path: Path) -> None:
    given = ticks(both, 57)
    builder = RunBuilder(both, None, {})
    with Recorder(tmp_path / "run.mcap", both) as recorder:
        for each in given:
            builder.tick(each)
            recorder.tick(each)
    run = log.read(tmp_path / "run.mcap")
    for found in (run, builder.build()):
        np.testing.assert_array_equal(found.gyro, [each.gyro for each in given])
        np.testing.assert_array_equal(found.accel, [each.accel for each in given])
        np.testing.assert_array_equal(found.mice, [each.mice for each in given])
    assert log.compare(builder.build(), run) == ()


@pytest.mark.parametrize("name", ["swerve3", "mecanum4", "hybrid3"])
def test_what_was_not_measured_is_nan_and_has_no_topic(name: str, tmp_path: Path) -> None:
    robot = robots.load(name)
    with Recorder(tmp_path / "run.mcap", robot) as recorder:
        for each in ticks(robot, 5, sensors=False):
            recorder.tick(each)
    run = log.read(tmp_path / "run.mcap")
    assert (run.gyro.shape, run.accel.shape, run.mice.shape) == ((5,), (5, 2), (5, len(robot.mice), 2))
    assert all(np.isnan(values).all() for values in (run.gyro, run.accel, run.mice))
    assert messages(tmp_path / "run.mcap", "/imu", "/mice") == []


def test_a_sensor_that_comes_late_or_falls_out_is_nan_meanwhile(both: Robot, tmp_path: Path) -> None:
    """The ticks before it, and those between, stay in their places."""
    given = ticks(both, 70)
    for k in range(10):
        given[k] = given[k]._replace(gyro=None, accel=None, mice=None)
    for k in range(30, 40):
        given[k] = given[k]._replace(gyro=None, mice=None)
    given[50] = given[50]._replace(accel=None)
    builder = RunBuilder(both, None, {})
    with Recorder(tmp_path / "run.mcap", both) as recorder:
        for each in given:
            builder.tick(each)
            recorder.tick(each)
    run = log.read(tmp_path / "run.mcap")
    assert log.compare(builder.build(), run) == ()
    assert np.flatnonzero(np.isnan(run.gyro)).tolist() == [*range(10), *range(30, 40)]
    found = messages(tmp_path / "run.mcap", "/imu")
    assert len(found) == 60
    assert found[20].angular_velocity_covariance[0] == -1.0  # no gyro at this tick
    assert found[20].linear_acceleration_covariance[0] != -1.0
    assert found[40].linear_acceleration_covariance[0] == -1.0


def test_rosbags_reads_imu_and_mice(both: Robot, tmp_path: Path) -> None:
    given = ticks(both, 30)
    with Recorder(tmp_path / "run.mcap", both) as recorder:
        for each in given:
            recorder.tick(each)
    imu, mice = messages(tmp_path / "run.mcap", "/imu"), messages(tmp_path / "run.mcap", "/mice")
    assert len(imu) == len(mice) == 30
    tick, first, second = given[7], imu[7], mice[7]
    assert tick.accel is not None
    assert tick.mice is not None
    assert both.imu is not None
    assert (first.header.frame_id, first.header.stamp.nanosec) == ("imu", 70_000_000)
    assert first.angular_velocity.z == tick.gyro
    assert (first.linear_acceleration.x, first.linear_acceleration.y) == tuple(tick.accel)
    assert first.orientation_covariance[0] == -1.0  # there is no compass
    assert first.angular_velocity_covariance[8] == both.imu.gyro_noise_rad_s**2
    assert math.isnan(first.angular_velocity.x)
    assert math.isnan(first.linear_acceleration.z)
    assert second.name == ["left", "right"]
    np.testing.assert_array_equal(np.stack([second.x, second.y], axis=-1), tick.mice)


@pytest.mark.parametrize("name", robots.names())
def test_map_and_odom_are_connected_for_every_robot(name: str, tmp_path: Path) -> None:
    """Beliefs are told in world coordinates from the true start on, so the two frames are one."""
    robot = robots.load(name)
    with Recorder(tmp_path / "run.mcap", robot) as recorder:
        recorder.tick(ticks(robot, 1)[0])
    (static,) = messages(tmp_path / "run.mcap", "/tf_static")
    frames = {each.child_frame_id: each for each in static.transforms}
    assert frames["odom"].header.frame_id == "map"
    place, turn = frames["odom"].transform.translation, frames["odom"].transform.rotation
    assert (place.x, place.y, place.z, turn.x, turn.y, turn.z, turn.w) == (0, 0, 0, 0, 0, 0, 1)
    assert ("laser" in frames, "imu" in frames) == (robot.lidar is not None, robot.imu is not None)
    assert {f"mouse_{mouse.name}" for mouse in robot.mice} <= set(frames)


def test_sensors_have_their_mounts_as_frames(both: Robot, tmp_path: Path) -> None:
    with Recorder(tmp_path / "run.mcap", both):
        pass
    (static,) = messages(tmp_path / "run.mcap", "/tf_static")
    frames = {each.child_frame_id: each for each in static.transforms}
    assert list(frames) == ["odom", "laser", "imu", "mouse_left", "mouse_right"]
    imu, left = frames["imu"], frames["mouse_left"]
    assert imu.header.frame_id == left.header.frame_id == "base_link"
    assert (imu.transform.translation.x, imu.transform.rotation.z) == (0.02, math.sin(0.5))
    assert (left.transform.translation.y, left.transform.rotation.z) == (0.1, math.sin(0.25))


def test_a_log_without_these_topics_is_read_and_compared_as_before(both: Robot, tmp_path: Path) -> None:
    """As all logs of the first days are."""
    with Recorder(tmp_path / "run.mcap", both) as recorder:
        for each in ticks(both, 40):
            recorder.tick(each)
    new = log.read(tmp_path / "run.mcap")
    old = log.read(rewritten(tmp_path / "run.mcap", tmp_path / "old.mcap", ("/imu", "/mice")))
    assert old.damage == ""
    assert np.isnan(old.gyro).all()
    assert old.mice.shape == (40, 2, 2)
    assert log.compare(old, new) == log.compare(new, old) == ()


def test_readings_find_their_ticks_without_the_numbers_of_messages(both: Robot, tmp_path: Path) -> None:
    """Other tools number messages anew, and ticks may share a time."""
    given = [each._replace(time=0.01 * (i // 3)) for i, each in enumerate(ticks(both, 40))]
    with Recorder(tmp_path / "run.mcap", both) as recorder:
        for each in given:
            recorder.tick(each)
    run = log.read(rewritten(tmp_path / "run.mcap", tmp_path / "other.mcap"))
    np.testing.assert_array_equal(run.gyro, [each.gyro for each in given])
    np.testing.assert_array_equal(run.mice, [each.mice for each in given])


def test_one_other_bit_of_a_reading_is_a_difference(both: Robot) -> None:
    builder = RunBuilder(both, None, {})
    for each in ticks(both, 20):
        builder.tick(each)
    run = builder.build()
    for name in ("gyro", "accel", "mice"):
        other = getattr(run, name).copy()
        other[7] = np.nextafter(other[7], np.inf)
        (difference,) = log.compare(run, replace(run, **{name: other}))
        assert (difference.channel, difference.count) == (name, 1)


def test_a_run_made_by_hand_may_leave_the_sensors_out(both: Robot) -> None:
    builder = RunBuilder(both, None, {})
    for each in ticks(both, 4, sensors=False):
        builder.tick(each)
    run = builder.build()
    empty = np.empty(0)
    bare = replace(run, gyro=empty, accel=empty, mice=empty)
    assert (bare.gyro.shape, bare.accel.shape, bare.mice.shape) == ((4,), (4, 2), (4, 2, 2))


def test_a_reading_of_another_number_of_mice_ends_the_recording_and_not_the_run(both: Robot, tmp_path: Path) -> None:
    with Recorder(tmp_path / "run.mcap", both) as recorder:
        recorder.tick(ticks(both, 1)[0]._replace(mice=np.zeros((1, 2))))
    assert recorder.fault.endswith("the robot has 2 mice, a tick has displacements of shape (1, 2)")


def test_the_gyro_of_a_log_goes_into_its_recording(tmp_path: Path) -> None:
    robot = robots.load("hybrid3")
    given = [
        each._replace(
            wheels=replace(each.wheels, position=np.full(3, 0.02 * i)),
            gyro=0.2 if i else None,
            truth=Pose(0.0, 0.0, 0.0),
        )
        for i, each in enumerate(ticks(robot, 101))
    ]
    for name, some in (("with", given), ("without", [each._replace(gyro=None, accel=None) for each in given])):
        with Recorder(tmp_path / f"{name}.mcap", robot) as recorder:
            for each in some:
                recorder.tick(each)
    recording = recordings.read(tmp_path / "with.mcap")
    np.testing.assert_array_equal(recording.gyro, [math.nan] + [0.2] * 100)
    blind = recordings.read(tmp_path / "without.mcap")
    assert blind.gyro.size == 0
    assert evaluate(recording).pose[-1, 2] != evaluate(blind).pose[-1, 2]
