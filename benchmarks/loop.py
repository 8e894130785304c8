"""The ordinary Python loop: times real time for one robot with lidar and log, and memory over an hour.

    python benchmarks/loop.py [--seconds 30] [--hour 3600] [--save]

`base` is the simulated base alone (observe and apply with hybrid3's own lidar), `drive` is the whole loop with
odometry, go-to-pose, gate and an MCAP log. The bar is 50 x real time for `drive`. Memory is this process's resident
set, taken each simulated minute of an hour with the log on; flat means that the second half adds less than 5 %.
"""

import argparse
import platform
import statistics
import sys
import tempfile
import time
from pathlib import Path

from holodrive import build, control, estimation, log, references, robots, worlds
from holodrive.runtime import Loop
from holodrive.sim import SimBase
from holodrive.types import WheelCommand

BAR, GROWTH, ROUNDS = 50.0, 0.05, 5


def resident_mb():
    """Resident memory of this process [MB]."""
    for line in Path("/proc/self/status").read_text().splitlines():
        if line.startswith("VmRSS"):
            return int(line.split()[1]) / 1024.0
    return float("nan")


def base_alone(seconds):
    base = SimBase(robots.load("hybrid3"), worlds.load("bench"), plant="first_order")
    begin = time.perf_counter()
    for _ in range(round(seconds / base.robot.control_period_s)):
        base.observe()
        base.apply(WheelCommand((0.0, 0.5, -0.5)))
    return seconds / (time.perf_counter() - begin)


def whole_drive(seconds, folder, plant):
    base = build.simulate("hybrid3", "bench", plant=plant)
    begin = time.perf_counter()
    build.drive(base, duration_s=seconds, log=Path(folder, "run.mcap"), stop_on_arrival=False)
    return seconds / (time.perf_counter() - begin)


def hour(seconds, folder):
    """(minutes) resident memory [MB] of a long run that only writes its log."""
    robot, world = robots.load("hybrid3"), worlds.load("bench")
    base = SimBase(robot, world)
    recorder = log.Recorder(Path(folder, "hour.mcap"), robot, world, {})
    goals = references.waypoints([(1.0, 0.6, 0.0), world.goal.pose, world.start] * 50)
    loop = Loop(
        base,
        control.controller("go_to_pose", robot),
        estimation.estimator("wheel_odometry", robot),
        references.ReferenceFollower(goals),
        (recorder,),
    )
    loop.reset(base.truth)
    used, ticks = [], round(60.0 / robot.control_period_s)
    for _ in range(max(2, round(seconds / 60.0))):
        for _ in range(ticks):
            loop.step()
        used.append(resident_mb())
    recorder.close()
    base.close()
    return used


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--seconds", type=float, default=30.0)
    parser.add_argument("--hour", type=float, default=3600.0, help="simulated seconds of the memory run")
    parser.add_argument("--save", action="store_true", help="keep the lines in benchmarks/results")
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        base_alone(1.0)
        whole_drive(1.0, folder, "first_order")
        alone = statistics.median(base_alone(options.seconds) for _ in range(ROUNDS))
        drives = {
            plant: statistics.median(whole_drive(options.seconds, folder, plant) for _ in range(ROUNDS))
            for plant in ("first_order", "slip")
        }
        used = hour(options.hour, folder)
    half = used[len(used) // 2]
    growth = used[-1] / half - 1.0
    good = drives["first_order"] >= BAR and growth < GROWTH
    lines = [
        f"Python {platform.python_version()}, medians of {ROUNDS} runs of {options.seconds:g} s",
        f"base alone                 {alone:7.0f} x real time",
        *(
            f"drive, lidar and log, {plant:12s} {rate:5.0f} x real time   (bar {BAR:g})"
            for plant, rate in drives.items()
        ),
        f"memory over {options.hour / 60.0:.0f} min: {used[0]:.0f} MB after one, {half:.0f} MB half-way, "
        f"{used[-1]:.0f} MB at the end: {100.0 * growth:+.1f} % in the second half   (bar {100.0 * GROWTH:g} %)",
    ]
    print("\n".join(lines))
    if options.save:
        (Path(__file__).parent / "results" / "loop.txt").write_text("\n".join(lines) + "\n")
    sys.exit(0 if good else 1)


if __name__ == "__main__":
    main()
