"""The compiled closed loop: robot-steps per second, two cores against one, and against ir-sim and MuJoCo.

    python benchmarks/rollout.py [--rounds 15] [--seconds 30] [--peers PYTHON] [--save]

Workload: hybrid3 on world `bench` (12 circles, 8 segments), 1 ms physics, a control tick each 10 ms (wheel odometry,
go-to-pose, limits - discretisation - Jacobian, three wheel PI loops), a noisy 360-beam lidar, whole scans at 10 Hz,
30 s of simulated time. The catalog's robot but for its lidar's rate and its IMU, which this workload has not.

Peers run in a process of their own (`--peers` names a Python that has ir-sim and mujoco; this one by default), in turn
with ours, so that other load meets all alike; figures are medians. They are not like for like: ir-sim is kinematic at
0.1 s a step with general shapes, MuJoCo has 3-D contacts and wheels without rollers. Exit code 1 when a ratio misses
its bar; rates alone depend on the machine and are printed beside their bars.
"""

import argparse
import json
import math
import os
import platform
import statistics
import subprocess
import sys
import tempfile
import time
from dataclasses import replace
from pathlib import Path

import numba

from holodrive import robots, worlds
from holodrive.control.go_to_pose import GoToPose
from holodrive.estimation import WheelOdometry
from holodrive.sim import rollout

BARS = {"first_order": (12.0, 400.0), "slip": (3.0, 80.0)}  # M robot-steps/s on one core, times ir-sim's rate
TWO_CORES, BATCH = 1.8, 1024
STEPS_PER_S = 1000
# between the obstacles without a collision, far enough to be under way all the time
START, GOAL = (5.5, 3.73, math.pi), (1.5, 3.73, math.pi)
# one robot on one core for all; ir-sim is also some five times faster without its linear algebra's threads
ONE_CORE = {"OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1", "MKL_NUM_THREADS": "1"}
PEER_SECONDS = {"irsim": 30.0, "mujoco": 30.0}


def workload():
    robot = robots.load("hybrid3")
    return replace(robot, imu=None, lidar=replace(robot.lidar, rate_hz=10.0, motion_distortion=False))


def timed(robot, world, plugs, **options):
    controller, estimator = plugs
    begin = time.perf_counter()
    out = rollout(robot, world, controller, estimator=estimator, starts=START, goals=GOAL, **options)
    return time.perf_counter() - begin, out


class Peers:
    """The other process; `run` gives simulated seconds per second, or None when the peer is not there."""

    def __init__(self, python, world):
        self.folder = tempfile.TemporaryDirectory()
        segments = [(s.x1, s.y1, s.x2, s.y2) for s in (*world.border(), *world.segments)]
        circles = [(c.x, c.y, c.radius) for c in world.circles]
        told = {"circles": circles, "segments": segments, "start": START, "goal": GOAL}
        Path(self.folder.name, "world.json").write_text(json.dumps(told))
        script = Path(__file__).parent / "_peers.py"
        self.process = subprocess.Popen(
            [python, str(script), self.folder.name],
            stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True,
            env=os.environ | ONE_CORE,
        )  # fmt: skip
        self.versions = {}

    def run(self, name):
        if self.versions.get(name, "").startswith("not"):
            return None
        self.process.stdin.write(f"{name} {PEER_SECONDS[name]}\n")
        self.process.stdin.flush()
        answer = json.loads(self.process.stdout.readline() or '{"error": "not running"}')
        self.versions[name] = answer.get("version", answer.get("error"))
        return PEER_SECONDS[name] / answer["wall_s"] if "wall_s" in answer else None

    def close(self):
        self.process.stdin.close()
        self.process.wait(30)
        self.folder.cleanup()


def measure(options):
    robot, world = workload(), worlds.load("bench")
    plugs = GoToPose(), WheelOdometry()
    peers = Peers(options.peers, world)
    rates = {name: [] for name in (*BARS, *PEER_SECONDS, "one", "two")}
    for plant in BARS:  # compiling is not measured here
        _, out = timed(robot, world, plugs, t=options.seconds, plant=plant)
        assert out.metrics["collisions"][0] == 0, "the workload is a free run"
    for _ in range(options.rounds):
        for plant in BARS:
            walls = [timed(robot, world, plugs, t=options.seconds, plant=plant, workers=1)[0] for _ in range(5)]
            rates[plant] += [options.seconds / wall for wall in walls]
        for name in PEER_SECONDS:
            if (rate := peers.run(name)) is not None:
                rates[name].append(rate)
    for _ in range(max(3, options.rounds // 4)):
        for name, workers in (("one", 1), ("two", 2)):
            wall, _ = timed(robot, world, plugs, t=options.batch_seconds, n=BATCH, workers=workers)
            rates[name].append(BATCH * options.batch_seconds / wall)
    peers.close()
    return {name: statistics.median(values) if values else None for name, values in rates.items()}, peers.versions


def report(rates, versions):
    """Lines to print, and whether all ratios reach their bars."""
    lines, good = [], True
    for plant, (bar, _) in BARS.items():
        million = rates[plant] * STEPS_PER_S / 1e6
        lines.append(f"{plant:12s} one robot, one core   {million:7.2f} M robot-steps/s   (bar {bar:g})")
    two = rates["two"] / rates["one"]
    good &= two >= TWO_CORES
    lines.append(
        f"{'first_order':12s} {BATCH} robots         {rates['one'] * STEPS_PER_S / 1e6:7.2f} M on one thread, "
        f"{rates['two'] * STEPS_PER_S / 1e6:.2f} M on two: {two:.2f} x   (bar {TWO_CORES})"
    )
    for name in PEER_SECONDS:
        if rates[name] is None:
            lines.append(f"{name:12s} {versions[name]}: no ratio")
            continue
        lines.append(f"{name:12s} {versions[name]:8s}  {rates[name]:.1f} x real time")
        for plant, (_, bar) in BARS.items():
            ratio = rates[plant] / rates[name]
            told = f"   (bar {bar:g})" if name == "irsim" else ""
            good &= name != "irsim" or ratio >= bar
            lines.append(f"    {plant:12s} {rates[plant]:9.0f} x real time: {ratio:6.0f} x {name}{told}")
    return lines, good


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--rounds", type=int, default=15)
    parser.add_argument("--seconds", type=float, default=30.0, help="simulated, one robot")
    parser.add_argument("--batch-seconds", type=float, default=5.0, help="simulated, each of the batch")
    parser.add_argument("--peers", default=sys.executable, help="Python that has ir-sim and mujoco")
    parser.add_argument("--save", action="store_true", help="keep the lines in benchmarks/results")
    options = parser.parse_args()
    rates, versions = measure(options)
    lines, good = report(rates, versions)
    head = f"Python {platform.python_version()}, Numba {numba.__version__}, {options.rounds} rounds, medians"
    text = "\n".join([head, *lines])
    print(text)
    if options.save:
        (Path(__file__).parent / "results" / "rollout.txt").write_text(text + "\n")
    sys.exit(0 if good else 1)


if __name__ == "__main__":
    main()
