"""Claims about recording a run and reading it back."""

import json
import logging
import os
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from logged import scan, tick, ticks
from mcap.reader import make_reader
from rosbags.highlevel import AnyReader

from holodrive import log, robots, worlds
from holodrive.errors import LogError
from holodrive.log import Recorder, RunBuilder
from holodrive.robots.spec import Robot
from holodrive.types import Event, Pose

SETTINGS = {"controller": "go_to_pose", "seed": 3, "params": {"gain": 1.5, "path": [[0.0, 1.0], [2.0, 3.0]]}}
EVENT = Event(0.5, "collision", "hit the wall «north»", Pose(1.0, 2.0, 3.0), {"at": [0.1, 0.2], "mover": "robot"})


@pytest.mark.parametrize("name", robots.names())
@pytest.mark.parametrize("command", ["twist", "wheels", "duty"])
def test_a_run_is_read_back_bit_for_bit(name: str, command: str, tmp_path: Path) -> None:
    robot, world = robots.load(name), worlds.load("open")
    builder = RunBuilder(robot, world, SETTINGS)
    recorder = Recorder(tmp_path / "run.mcap", robot, world, SETTINGS)
    for each in ticks(robot, 57, command=command):
        builder.tick(each)
        recorder.tick(each)
    metrics = {"path_length_m": 1.0 / 3.0, "unknown": float("nan")}
    recorder.close(metrics)
    run = log.read(tmp_path / "run.mcap")
    assert log.compare(builder.build(), run) == ()
    assert run.damage == ""
    assert run.robot == robot
    assert run.world == world
    assert run.settings == SETTINGS
    assert run.metrics["path_length_m"] == 1.0 / 3.0
    assert np.isnan(run.metrics["unknown"])
    assert np.isnan(run.decided).all() == (command != "twist")


def test_what_a_real_robot_does_not_know_is_nan(hybrid3: Robot, tmp_path: Path) -> None:
    with Recorder(tmp_path / "run.mcap", hybrid3) as recorder:
        for each in ticks(hybrid3, 5, truth=False):
            recorder.tick(each)
    run = log.read(tmp_path / "run.mcap")
    assert np.isnan(run.pose).all()
    assert np.isnan(run.twist).all()
    assert np.isnan(run.duty).all()
    assert run.world is None
    assert run.estimate.shape == (5, 3)


def test_scans_and_events_come_back(hybrid3: Robot, tmp_path: Path) -> None:
    assert hybrid3.lidar is not None
    mount = hybrid3.lidar.mount
    scans = [
        scan(0.0, 360, mount),  # its first beam lies before time zero
        scan(0.2, 360, mount),
        scan(0.4, 40, mount, even=False),
        scan(0.6, 360, Pose(0.1, 0.0, 0.5)),
    ]
    builder, recorder = RunBuilder(hybrid3, None, {}), Recorder(tmp_path / "run.mcap", hybrid3)
    for sink in (builder, recorder):
        for each in scans:
            sink.scan(each)
        sink.event(EVENT)
    recorder.close()
    run = log.read(tmp_path / "run.mcap")
    assert [difference.text for difference in log.compare(builder.build(), run)] == []
    assert run.events == (EVENT,)
    for written, read in zip(scans, run.scans, strict=True):
        np.testing.assert_allclose(read.angles, written.angles, atol=1e-6)
        np.testing.assert_allclose(read.offsets, written.offsets, atol=1e-6)
        assert read.mount == written.mount
        assert (read.range_min, read.range_max) == pytest.approx((written.range_min, written.range_max))


def test_other_tools_read_every_message(tmp_path: Path) -> None:
    """rosbags decodes each channel by the definition in the file; mcap finds all by the index."""
    robot = robots.load("swerve3")
    path = tmp_path / "run.mcap"
    given = ticks(robot, 45)
    with Recorder(path, robot, None, SETTINGS) as recorder:
        for each in given:
            recorder.tick(each)
        recorder.scan(scan(0.2, 90, Pose(0, 0, 0)))
        recorder.event(EVENT)
    counts: dict[str, int] = {}
    with AnyReader([path]) as reader:
        for connection, _, raw in reader.messages():
            message = reader.deserialize(raw, connection.msgtype)
            if connection.topic == "/odom" and counts.get("/odom", 0) == 7:
                assert message.pose.pose.position.x == given[7].estimate.pose.x  # type: ignore[attr-defined]
                assert message.pose.covariance[5] == given[7].estimate.covariance[0, 2]  # type: ignore[attr-defined]
                assert message.header.stamp.nanosec == 70_000_000  # type: ignore[attr-defined]
            if connection.topic == "/joint_states" and counts.get("/joint_states", 0) == 7:
                steered = [f"{wheel.name}_steer" for wheel in robot.wheels]
                assert message.name == [wheel.name for wheel in robot.wheels] + steered  # type: ignore[attr-defined]
                expected = [*given[7].wheels.position, *given[7].wheels.steer]
                assert message.position.tolist() == expected  # type: ignore[attr-defined]
            counts[connection.topic] = counts.get(connection.topic, 0) + 1
    every_tick = ("/holodrive/tick", "/odom", "/truth", "/cmd_vel", "/joint_states", "/joint_commands", "/reference")
    assert {topic: counts[topic] for topic in (*every_tick, "/tf")} == dict.fromkeys((*every_tick, "/tf"), 45)
    assert (counts["/holodrive/events"], counts["/holodrive/description"]) == (1, 1)
    with path.open("rb") as file:
        reader_ = make_reader(file)
        summary = reader_.get_summary()
        assert summary is not None
        assert summary.statistics is not None
        assert summary.statistics.message_count == sum(counts.values()) == sum(1 for _ in reader_.iter_messages())
        texts = {each.name: each.data.decode() for each in reader_.iter_attachments()}
    assert texts["robot.toml"] == robot.text
    assert json.loads(texts["settings.json"]) == SETTINGS


def test_a_robot_changed_after_reading_is_recorded_as_changed(hybrid3: Robot, tmp_path: Path) -> None:
    """Its text no longer tells what it is."""
    heavy = replace(hybrid3, mass_kg=99.0)
    with Recorder(tmp_path / "run.mcap", heavy) as recorder:
        recorder.tick(ticks(heavy, 1)[0])
    assert log.read(tmp_path / "run.mcap").robot.mass_kg == 99.0


def test_equal_runs_make_equal_files(hybrid3: Robot, tmp_path: Path) -> None:
    for name in ("a", "b"):
        with Recorder(tmp_path / name, hybrid3, None, SETTINGS, clock=lambda: 0.0) as recorder:
            for each in ticks(hybrid3, 100):
                recorder.tick(each)
    assert (tmp_path / "a").read_bytes() == (tmp_path / "b").read_bytes()


def test_a_chunk_closes_after_200_ms_of_log_time_or_of_wall_time(hybrid3: Robot, tmp_path: Path) -> None:
    """Whichever is first; what is closed is in the file at once."""
    now, path = [0.0], tmp_path / "run.mcap"
    recorder = Recorder(path, hybrid3, clock=lambda: now[0])
    given = ticks(hybrid3, 60)
    for each in given[:21]:
        recorder.tick(each)
    assert len(log.read(path).time) == 21  # log time 0 to 0.2 s
    for each in given[21:24]:
        recorder.tick(each)
    assert len(log.read(path).time) == 21
    now[0] = 0.2
    recorder.tick(given[24])
    assert len(log.read(path).time) == 25
    recorder.tick(given[25])
    recorder.event(EVENT)
    assert len(log.read(path).time) == 26
    recorder.close()


def test_a_run_whose_command_changes_its_kind_is_kept_whole(hybrid3: Robot, tmp_path: Path) -> None:
    rng = np.random.default_rng(1)
    kinds = ["twist", "twist", "wheels", "duty", "twist"]
    given = [tick(hybrid3, 0.01 * i, rng, command=kind, truth=i != 1) for i, kind in enumerate(kinds)]
    builder = RunBuilder(hybrid3, None, {})
    with Recorder(tmp_path / "run.mcap", hybrid3) as recorder:
        for each in given:
            builder.tick(each)
            recorder.tick(each)
    assert log.compare(builder.build(), log.read(tmp_path / "run.mcap")) == ()


def test_a_folder_that_is_not_there_is_told_before_anything_moves(hybrid3: Robot, tmp_path: Path) -> None:
    with pytest.raises(LogError, match=r"no folder .*nowhere.*; make it") as error:
        Recorder(tmp_path / "nowhere" / "run.mcap", hybrid3)
    assert "\n" not in str(error.value)


@pytest.mark.skipif(os.geteuid() == 0, reason="root may write everywhere")
def test_a_folder_that_may_not_be_written_is_told(hybrid3: Robot, tmp_path: Path) -> None:
    tmp_path.chmod(0o500)
    with pytest.raises(LogError, match="Permission denied"):
        Recorder(tmp_path / "run.mcap", hybrid3)


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="needs /dev/full")
def test_a_full_disk_is_told_before_anything_moves(hybrid3: Robot) -> None:
    with pytest.raises(LogError, match="No space left on device; free some space"):
        Recorder("/dev/full", hybrid3)


def test_settings_that_json_does_not_know_are_refused(hybrid3: Robot, tmp_path: Path) -> None:
    with pytest.raises(LogError, match="JSON-able"):
        Recorder(tmp_path / "run.mcap", hybrid3, None, {"controller": object()})


def test_a_recorder_that_fails_never_raises_and_says_why(
    hybrid3: Robot, tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    """A tick that cannot be written ends the recording, not the loop; what was written stays readable."""
    path = tmp_path / "run.mcap"
    recorder = Recorder(path, hybrid3)
    given = ticks(hybrid3, 30)
    for each in given[:21]:
        recorder.tick(each)
    wrong = ticks(robots.load("mecanum4"), 1)[0]
    with caplog.at_level(logging.ERROR):
        recorder.tick(wrong)
        for each in given[22:]:
            recorder.tick(each)
    recorder.scan(scan(0.3, 8, Pose(0, 0, 0)))
    recorder.event(EVENT)
    recorder.close({"x": 1.0})
    recorder.close()
    assert "recording stopped" in recorder.fault
    assert recorder.lost == 8
    assert len(caplog.records) == 1
    assert len(log.read(path).time) == 21


def test_closing_twice_is_harmless_and_later_ticks_are_counted(hybrid3: Robot, tmp_path: Path) -> None:
    recorder = Recorder(tmp_path / "run.mcap", hybrid3)
    recorder.close()
    recorder.close()
    recorder.tick(ticks(hybrid3, 1)[0])
    assert (recorder.lost, recorder.fault) == (1, "")
    assert len(log.read(tmp_path / "run.mcap").time) == 0
