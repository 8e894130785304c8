"""What recording costs the loop: microseconds a tick with and without scans, and bytes of log a second.

Run: python benchmarks/log_cost.py
"""

import tempfile
import time
from pathlib import Path

import numpy as np

from holodrive import log, robots
from holodrive.log import Recorder, RunBuilder, Tick
from holodrive.robots.spec import Robot
from holodrive.types import Estimate, Pose, Reference, Scan, Twist, WheelCommand, WheelState

TICKS, PERIOD_S, AIM_US = 6000, 0.01, 40.0


def motion(robot: Robot) -> list[Tick]:
    """A minute of smooth motion at 100 Hz, with encoder noise."""
    n, m, rng = len(robot.wheels), len(robot.steered), np.random.default_rng(0)
    ticks = []
    for k in range(TICKS):
        t = k * PERIOD_S
        pose = Pose(np.sin(t), np.cos(0.7 * t), 0.3 * t)
        twist = Twist(0.3 * np.cos(t), 0.1 * np.sin(t), 0.3)
        speeds = np.array([np.sin(t + i) for i in range(n)]) * 5 + rng.normal(size=n) * 0.05
        steer = np.full(m, 0.2 * t)
        wheels = WheelState(np.round(5 * t * np.arange(n), 3), speeds, steer)
        ticks.append(
            Tick(
                t,
                Estimate(pose, twist, np.diag([1e-4, 1e-4, 1e-5]) * t, 0.0),
                Reference(Pose(1.0, 2.0, 0.0)),
                twist,
                WheelCommand(speeds + 0.01, steer),
                wheels,
                Pose(pose.x + 1e-3, pose.y, pose.theta),
                twist,
                speeds / 10,
            )
        )
    return ticks


def room(mount: Pose) -> list[Scan]:
    """Scans of 360 beams in a room, 1 cm of noise."""
    rng = np.random.default_rng(1)
    angles = -2.0 * np.pi * np.arange(360) / 360
    walls = np.minimum(2.0 / np.abs(np.cos(angles) + 1e-9), 3.0 / np.abs(np.sin(angles) + 1e-9))
    offsets = np.linspace(-0.1, 0.0, 360)
    return [
        Scan(0.1 * k, angles, walls + 0.01 * rng.normal(size=360), offsets, mount, 0.15, 12.0)
        for k in range(TICKS // 10)
    ]


def cost(sink: Recorder | RunBuilder, ticks: list[Tick], scans: list[Scan]) -> float:
    """Microseconds a tick, scans included."""
    begin = time.perf_counter()
    for k, tick in enumerate(ticks):
        sink.tick(tick)
        if scans and k % 10 == 0:
            sink.scan(scans[k // 10])
    return (time.perf_counter() - begin) / len(ticks) * 1e6


def main() -> None:
    """Print the table."""
    print(f"{TICKS} ticks at {1 / PERIOD_S:g} Hz, 360 beams at 10 Hz; best of three; aim {AIM_US:g} us a tick")
    print(f"{'robot':>14}  {'memory':>9}  {'log':>9}  {'log+scans':>9}  {'kB/s':>6}  {'with scans':>10}  {'read s':>7}")
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "run.mcap"
        for name in ("hybrid3", "mecanum4", "swerve4"):
            robot = robots.load(name)
            ticks = motion(robot)
            scans = room(robot.lidar.mount if robot.lidar else Pose(0.0, 0.0, 0.0))
            times, sizes = {}, {}
            for kind, given in (("log", []), ("log+scans", scans)):
                costs = []
                for _ in range(3):
                    with Recorder(path, robot) as recorder:
                        costs.append(cost(recorder, ticks, given))
                    assert not recorder.fault, recorder.fault
                times[kind], sizes[kind] = min(costs), path.stat().st_size / (TICKS * PERIOD_S) / 1e3
            memory = min(cost(RunBuilder(robot, None, {}), ticks, []) for _ in range(3))
            begin = time.perf_counter()
            run = log.read(path)
            reading = time.perf_counter() - begin
            assert len(run.time) == TICKS
            print(
                f"{name:>14}  {memory:9.1f}  {times['log']:9.1f}  {times['log+scans']:9.1f}  "
                f"{sizes['log']:6.1f}  {sizes['log+scans']:10.1f}  {reading:7.3f}"
            )


if __name__ == "__main__":
    main()
