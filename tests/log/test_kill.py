"""Claims about what survives the end of the process: real children, really killed."""

import random
import signal
import subprocess
import sys
import textwrap
from pathlib import Path

import numpy as np
import pytest

from holodrive import log

CHILD = """
import os, resource, sys, time
sys.path.insert(0, {folder!r})
from logged import ticks
from holodrive import robots
from holodrive.log import Recorder
robot = robots.load("hybrid3")
given = ticks(robot, 400)
{body}
"""
DRIVE = """
with Recorder(sys.argv[1], robot, None, {"seed": 1}) as recorder:
    for i in range(1_000_000):
        recorder.tick(given[i % 400]._replace(time=0.01 * i))
        os.write(1, f"{0.01 * i}\\n".encode())
        time.sleep(PAUSE)
"""


def child(body: str, path: Path) -> "subprocess.Popen[bytes]":
    code = CHILD.format(folder=str(Path(__file__).parent), body=textwrap.dedent(body))
    return subprocess.Popen([sys.executable, "-c", code, str(path)], stdout=subprocess.PIPE, stderr=subprocess.DEVNULL)


def end(process: "subprocess.Popen[bytes]", after: int, how: signal.Signals) -> float:
    """Send a signal after so many ticks; time of the last tick that was recorded [s]."""
    with process:
        assert process.stdout is not None
        seen = [process.stdout.readline() for _ in range(after)]
        process.send_signal(how)
        seen += process.stdout.readlines()
    return float([line for line in seen if line.endswith(b"\n")][-1])


def kill_some(count: int, pause_s: float, folder: Path, seed: int) -> None:
    rng = random.Random(seed)
    body = DRIVE.replace("PAUSE", str(pause_s))
    paths = [folder / f"{seed}-{i}.mcap" for i in range(count)]
    processes = [child(body, path) for path in paths]
    for process, path in zip(processes, paths, strict=True):
        last = end(process, rng.randrange(1, 150), signal.SIGKILL)
        run = log.read(path)
        assert last - (run.time[-1] if len(run.time) else 0.0) <= 0.25
        assert run.robot.name == "hybrid3"
        assert run.settings == {"seed": 1}
        assert "was not closed" in run.damage
        np.testing.assert_allclose(np.diff(run.time), 0.01)


@pytest.mark.parametrize("pause_s", [0.0, 0.01], ids=["simulated", "real time"])
def test_kill_9_loses_a_quarter_of_a_second_at_most(pause_s: float, tmp_path: Path) -> None:
    """The file is readable as it is, without repair, and says that it was not closed."""
    kill_some(3, pause_s, tmp_path, seed=1)


@pytest.mark.campaign
def test_two_hundred_kills(tmp_path: Path) -> None:
    for seed in range(50):
        kill_some(4, 0.01 * (seed % 2), tmp_path, seed)


def test_ctrl_c_closes_the_file_well(tmp_path: Path) -> None:
    process = child(DRIVE.replace("PAUSE", "0.005"), tmp_path / "run.mcap")
    last = end(process, 50, signal.SIGINT)
    run = log.read(tmp_path / "run.mcap")
    assert run.damage == ""
    assert run.time[-1] >= last


def test_an_exception_closes_the_file_well(tmp_path: Path) -> None:
    body = "with Recorder(sys.argv[1], robot) as r:\n    for t in given[:33]: r.tick(t)\n    raise RuntimeError('x')"
    with child(body, tmp_path / "run.mcap") as process:
        assert process.wait() == 1
    run = log.read(tmp_path / "run.mcap")
    assert (len(run.time), run.damage) == (33, "")


def test_a_disk_that_fills_up_stops_the_recording_and_not_the_loop(tmp_path: Path) -> None:
    """The loop goes on to its end; the file holds whole chunks up to the fault, and no torn one."""
    body = """
        import signal
        signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
        resource.setrlimit(resource.RLIMIT_FSIZE, (60_000, 60_000))
        recorder = Recorder(sys.argv[1], robot)
        for tick in given:
            recorder.tick(tick)
        recorder.close({"x": 1.0})
        print(recorder.fault, recorder.lost, sep="|")
        """
    with child(body, tmp_path / "run.mcap") as process:
        out, _ = process.communicate()
    fault, lost = out.decode().strip().split("|")
    assert fault.startswith(f"cannot write the log {tmp_path / 'run.mcap'}: File too large; free some space")
    run = log.read(tmp_path / "run.mcap")
    assert 40 < len(run.time) <= 400 - int(lost)
    assert run.damage.endswith(f"the recording was not closed, its last tick is at {run.time[-1]:.3f} s")
    assert "bytes" not in run.damage
