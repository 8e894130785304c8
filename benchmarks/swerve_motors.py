"""A swerve robot with all its motors: how much faster than real time, and how straight it drives while it spins.

    python benchmarks/swerve_motors.py [--rounds 9] [--seconds 10] [--save]

Workload: swerve3_motors on the plant "motors", go-to-pose over 14 m with a turn of 180 degrees (Rosyidin et al.,
section 3), 1 ms control and physics, three drives and three steerings in sub-steps of 20 us, wheel odometry; one robot
on one core after compilation, medians. The line: 1 m/s in one direction of the world while turning at 1 rad/s, started
in 2 s, the world's direction turned into the robot's axes each tick by its true heading and nothing else fed back.
Exit code 1 when a bar is missed.
"""

import argparse
import math
import platform
import statistics
import sys
import time
from dataclasses import replace
from pathlib import Path

import numba
import numpy as np

from holodrive import robots
from holodrive.control.go_to_pose import GoToPose
from holodrive.estimation import WheelOdometry
from holodrive.kinematics.pipeline import CommandPipeline
from holodrive.robots import motors
from holodrive.sim import SimBase, rollout

REAL_TIME, STRAIGHT_M = 8.0, 1e-3  # bars
START_S, LINE_S = 2.0, 6.0
GOAL = (5.0, 10.0, math.pi)
DRIVES = {"six_step": "bldc-16pole-9to1", "foc": "bldc-sine-16pole-9to1", "averaged": "bldc-16pole-9to1"}


def machine(drive):
    """swerve3_motors with one kind of motor everywhere, at its own sub-step."""
    robot, motor = robots.load("swerve3_motors"), replace(motors.load(DRIVES[drive]), drive=drive)
    wheels = tuple(replace(w, motor=motor, steering=replace(w.steering, motor=motor)) for w in robot.wheels)
    return replace(robot, wheels=wheels)


def real_time(drive, rounds, seconds):
    """Simulated seconds per second of one core."""
    robot = machine(drive)
    controller, estimator = GoToPose(), WheelOdometry()

    def once():
        begin = time.perf_counter()
        out = rollout(robot, None, controller, estimator=estimator, t=seconds, goals=GOAL, plant="motors", workers=1)
        return time.perf_counter() - begin, out

    _, out = once()  # compiling is not measured here
    assert out.metrics["path_length_m"][0] > 1.0, "the robot is under way"
    return seconds / statistics.median(once()[0] for _ in range(rounds))


def straightness(drive):
    """Largest distance [m] from the straight line through the path at full speed, and from the commanded direction."""
    robot = machine(drive)
    base, pipeline, period = SimBase(robot, plant="motors"), CommandPipeline(robot), robot.control_period_s
    path = []
    for k in range(round((START_S + LINE_S) / period)):
        share = 0.5 - 0.5 * math.cos(math.pi * min(1.0, k * period / START_S))
        theta = base.truth.theta
        base.apply(pipeline.step((share * math.cos(theta), -share * math.sin(theta), share), period))
        if k * period >= START_S:
            path.append(base.truth[:2])
    x, y = np.transpose(path)
    return float(np.abs(y - np.polyval(np.polyfit(x, y, 1), x)).max()), float(np.abs(y - y[0]).max()), float(np.ptp(x))


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--rounds", type=int, default=9)
    parser.add_argument("--seconds", type=float, default=10.0)
    parser.add_argument("--save", action="store_true", help="keep the lines in benchmarks/results")
    options = parser.parse_args()
    lines = [f"Python {platform.python_version()}, Numba {numba.__version__}, {options.rounds} rounds, medians"]
    good = True
    for drive in DRIVES:
        rate = real_time(drive, options.rounds, options.seconds)
        off, aside, length = straightness(drive)
        good &= rate >= REAL_TIME and off <= STRAIGHT_M
        lines.append(
            f"{drive:9s} six motors, one core  {rate:6.1f} x real time (bar {REAL_TIME:g});  1 m/s, 1 rad/s over "
            f"{length:.1f} m: {1e3 * off:.2f} mm from straight (bar {1e3 * STRAIGHT_M:g}), "
            f"{1e3 * aside:.2f} mm from the commanded direction"
        )
    print("\n".join(lines))
    if options.save:
        Path(__file__).with_name("results").joinpath("swerve_motors.txt").write_text("\n".join(lines) + "\n")
    return 0 if good else 1


if __name__ == "__main__":
    sys.exit(main())
