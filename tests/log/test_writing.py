"""Claims about the file itself: one writer at a time, and no fault of it that leaves a tick."""

import errno
import logging
import os
import subprocess
import sys
import threading
import warnings
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from logged import ticks

from holodrive import log
from holodrive.errors import LogError
from holodrive.log import Recorder
from holodrive.log.mcap_file import Syncer
from holodrive.robots.spec import Robot

TAKEN = r"cannot write the log .*run\.mcap: another recording is still writing it; close that one, or choose another"


class Faulty:
    """A file whose next write goes wrong in some way; everything else is the real file."""

    def __init__(self, file: Any, write: Callable[[Any, Any], int | None]) -> None:
        self._file, self._write = file, write

    def write(self, data: Any) -> int | None:
        return self._write(self._file, data)

    def close_badly(self) -> None:
        self._file.close()
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    def __getattr__(self, name: str) -> Any:
        return getattr(self._file, name)


def test_a_second_recorder_of_the_same_file_is_refused_and_harms_nothing(hybrid3: Robot, tmp_path: Path) -> None:
    path, given = tmp_path / "run.mcap", ticks(hybrid3, 90)
    with Recorder(path, hybrid3) as recorder:
        for each in given[:60]:
            recorder.tick(each)
        with pytest.raises(LogError, match=TAKEN) as error:
            Recorder(path, hybrid3)
        assert "\n" not in str(error.value)
        for each in given[60:]:
            recorder.tick(each)
    run = log.read(path)
    assert (len(run.time), run.damage, recorder.fault) == (90, "", "")


def test_another_process_is_refused_too(hybrid3: Robot, tmp_path: Path) -> None:
    code = "import sys\nfrom holodrive import log, robots\nlog.Recorder(sys.argv[1], robots.load('hybrid3'))"
    with Recorder(tmp_path / "run.mcap", hybrid3):
        child = subprocess.run(
            [sys.executable, "-c", code, str(tmp_path / "run.mcap")], capture_output=True, text=True, check=False
        )
    assert child.returncode == 1
    assert "another recording is still writing it" in child.stderr.splitlines()[-1]


def test_a_closed_or_ended_recording_lets_its_file_go(hybrid3: Robot, tmp_path: Path) -> None:
    path = tmp_path / "run.mcap"
    Recorder(path, hybrid3).close()
    failed = Recorder(path, hybrid3)
    failed.tick(ticks(hybrid3, 1)[0]._replace(mice=np.zeros((1, 2))))
    assert failed.fault
    with Recorder(path, hybrid3) as recorder:
        recorder.tick(ticks(hybrid3, 1)[0])
    failed.close()
    assert (len(log.read(path).time), log.read(path).damage) == (1, "")
    assert [each.name for each in tmp_path.iterdir()] == ["run.mcap"]  # no lock file stays


def test_a_forked_child_that_lives_on_does_not_keep_the_file(hybrid3: Robot, tmp_path: Path) -> None:
    """As workers of a pool do: a lock belongs to the open file, which they share."""
    recorder = Recorder(tmp_path / "run.mcap", hybrid3)
    wait, go = os.pipe()
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", DeprecationWarning)  # of fork beside threads, from Python 3.12 on
        child = os.fork()
    if child == 0:
        os.close(go)
        os.read(wait, 1)
        os._exit(0)
    recorder.close()
    Recorder(tmp_path / "run.mcap", hybrid3).close()
    os.close(go)
    os.close(wait)
    os.waitpid(child, 0)


def test_a_longer_older_file_is_replaced_wholly(hybrid3: Robot, tmp_path: Path) -> None:
    path = tmp_path / "run.mcap"
    path.write_bytes(bytes(1_000_000))
    with Recorder(path, hybrid3) as recorder:
        recorder.tick(ticks(hybrid3, 1)[0])
    assert path.stat().st_size < 100_000
    assert log.read(path).damage == ""


def _nothing_taken(file: Any, data: Any) -> int | None:
    return None


def _zero_taken(file: Any, data: Any) -> int | None:
    return 0


def _refused(file: Any, data: Any) -> int | None:
    file.write(data[:10])
    raise OSError(errno.EIO, os.strerror(errno.EIO))


@pytest.mark.parametrize("write", [_nothing_taken, _zero_taken, _refused])
def test_a_write_that_takes_nothing_or_fails_ends_the_recording_and_not_the_loop(
    write: Callable[[Any, Any], int | None], hybrid3: Robot, tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    """Also when the file cannot even be closed."""
    path, given = tmp_path / "run.mcap", ticks(hybrid3, 60)
    recorder = Recorder(path, hybrid3, clock=lambda: 0.0)
    for each in given[:21]:
        recorder.tick(each)
    file: Any = recorder._file
    file._file = Faulty(file._file, write)
    file._file.close = file._file.close_badly
    with caplog.at_level(logging.ERROR):
        for each in given[21:]:
            recorder.tick(each)
    recorder.close({"x": 1.0})
    assert recorder.fault.startswith(f"cannot write the log {path}: ")
    assert len(caplog.records) == 1
    run = log.read(path)
    assert len(run.time) == 21
    assert "bytes" not in run.damage


def test_ctrl_c_in_the_middle_of_a_write_leaves_a_whole_file(hybrid3: Robot, tmp_path: Path) -> None:
    """The chunk is lost; what comes after it lies where the index says."""
    from mcap.reader import make_reader

    path, given = tmp_path / "run.mcap", ticks(hybrid3, 90)
    recorder = Recorder(path, hybrid3, clock=lambda: 0.0)
    for each in given[:42]:
        recorder.tick(each)
    file: Any = recorder._file
    real = file._file

    def interrupted(file: Any, data: Any) -> int | None:
        file.write(data[:100])
        raise KeyboardInterrupt

    file._file = Faulty(real, interrupted)
    for each in given[42:62]:
        recorder.tick(each)
    with pytest.raises(KeyboardInterrupt):
        recorder.tick(given[62])
    file._file = real
    for each in given[63:]:
        recorder.tick(each)
    recorder.close()
    run = log.read(path)
    assert run.damage == ""
    with path.open("rb") as opened:
        found = sum(channel.topic == "/odom" for _, channel, _ in make_reader(opened).iter_messages())
    assert found == len(run.time) == 42 + 27


def test_the_thread_that_syncs_ends_quietly_when_the_file_is_gone(
    hybrid3: Robot, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A recording that ended of itself, in a program that runs on."""
    told: list[Any] = []
    monkeypatch.setattr(threading, "excepthook", told.append)
    recorder = Recorder(tmp_path / "run.mcap", hybrid3)
    file, reports = recorder._file, list[OSError]()
    file.abandon()
    fast = Syncer(file.sync, reports.append, period_s=0.001)
    fast._thread.join(0.1)
    fast.stop()
    recorder.close()
    assert told == []
    assert reports == []


def test_after_a_fault_nothing_syncs_any_more(hybrid3: Robot, tmp_path: Path) -> None:
    recorder = Recorder(tmp_path / "run.mcap", hybrid3)
    recorder.tick(ticks(hybrid3, 1)[0]._replace(mice=np.zeros((1, 2))))
    recorder._syncer._thread.join(5.0)
    assert not recorder._syncer._thread.is_alive()


def test_a_disk_that_cannot_sync_ends_the_recording_at_the_next_tick(hybrid3: Robot, tmp_path: Path) -> None:
    recorder = Recorder(tmp_path / "run.mcap", hybrid3)
    recorder._sync_failed(OSError(errno.EIO, os.strerror(errno.EIO)))
    for each in ticks(hybrid3, 3):
        recorder.tick(each)
    assert "Input/output error" in recorder.fault
    assert recorder.lost == 2
    recorder.close()
