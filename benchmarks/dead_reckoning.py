"""How far do wheels, mice, and both together lead astray over 20 m on wheels that slip?

    python benchmarks/dead_reckoning.py [--runs 20] [--metres 20] [--save]

mecanum4 wanders open loop on the plant `slip`: speed, direction and turning rate are sums of slow sines, another for
each run. The same observations go to `wheel_odometry` (encoders), `mouse_odometry` (the two mice) and `fused_odometry`
(both), which never steer. Three conditions: mice as the catalog has them (exact but for counts of 10 um), mice with
1 % of noise on every reading, and the second mouse dead from half the way on. `perfect grip` is the same on the plant
`first_order`, where wheels do not slip, on a quarter of the runs. Errors are of the end position in % of the way, and
of the end heading; the median over the runs, and the largest.
Exit code 1 when fusing with sound mice is worse than the wheels alone, or losing a mouse makes it worse than twice
the wheels.
"""

import argparse
import math
import platform
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np

from holodrive import build, estimation, robots
from holodrive.geometry import wrap
from holodrive.references import ReferenceFollower, fixed_goal
from holodrive.runtime import Loop
from holodrive.types import Decision, Pose, Twist

SINES, LOWEST_HZ, HIGHEST_HZ = 4, 0.005, 0.05
SPEED_M_S, YAW_RATE_RAD_S = 0.035, 0.06  # of mecanum4, whose wheels give 0.042 m/s in the worst direction
NOISE = 0.01
LONGEST_S = 3600.0
CONDITIONS = {
    "mice sound": ("wheel_odometry", "mouse_odometry", "fused_odometry"),
    "1 % noise": ("mouse_odometry", "fused_odometry"),
    "one dead": ("mouse_odometry", "fused_odometry"),
}


class Wander:
    """A controller that follows nothing: a twist of slow sines."""

    command_kind = "twist"

    def __init__(self, seed):
        generator = np.random.default_rng(seed)
        self.size = generator.uniform(0.2, 1.0, size=(3, SINES))
        self.size /= self.size.sum(axis=1, keepdims=True)
        self.rate = 2.0 * np.pi * np.exp(generator.uniform(np.log(LOWEST_HZ), np.log(HIGHEST_HZ), size=(3, SINES)))
        self.phase = generator.uniform(0.0, 2.0 * np.pi, size=(3, SINES))

    def reset(self):
        """Nothing to forget."""

    def step(self, reference, estimate, observation):
        """The twist at this time."""
        change, direction, turn = (self.size * np.sin(self.rate * observation.time + self.phase)).sum(axis=1).tolist()
        speed = SPEED_M_S * (0.75 + 0.25 * change)
        angle = 2.0 * math.pi * direction
        return Decision(Twist(speed * math.cos(angle), speed * math.sin(angle), YAW_RATE_RAD_S * turn))


class Beside:
    """Several estimators that see the same; the loop is given the first. With `dead` the last mouse stops half way."""

    def __init__(self, names, robot):
        self.each = {name: estimation.estimator(name, robot) for name in names}
        self.broken = {name: estimation.estimator(name, robot) for name in names if name != "wheel_odometry"}
        self.dead = False
        self.found, self.found_broken = {}, {}

    def reset(self, pose):
        """Start all of them there."""
        for estimator in (*self.each.values(), *self.broken.values()):
            estimator.reset(pose)

    def step(self, observation):
        """One tick of all of them."""
        self.found = {name: each.step(observation) for name, each in self.each.items()}
        mice = observation.mice.copy()
        if self.dead:
            mice[-1] = 0.0
        blind = replace(observation, mice=mice)
        self.found_broken = {name: each.step(blind) for name, each in self.broken.items()}
        return next(iter(self.found.values()))


def wander(robot, plant, seed, metres):
    """(condition, estimator) -> (end error as a part of the way, heading error [rad]) for sound and dead mice."""
    names = [name for name in CONDITIONS["mice sound"]]
    base, beside = build.simulate(robot, plant=plant, seed=seed), Beside(names, robot)
    loop = Loop(base, Wander(seed), beside, ReferenceFollower(fixed_goal((0.0, 0.0, 0.0))))
    loop.reset(base.truth)
    way, last = 0.0, base.truth
    while way < metres and base.time < LONGEST_S:
        tick = loop.step()
        way += math.dist(tick.truth[:2], last[:2])
        last = tick.truth
        beside.dead = way > 0.5 * metres
    return (
        {name: off(estimate.pose, last, way) for name, estimate in beside.found.items()},
        {name: off(estimate.pose, last, way) for name, estimate in beside.found_broken.items()},
        way,
    )


def off(pose: Pose, truth: Pose, way: float):
    """End error as a part of the way, heading error [rad]."""
    return math.dist(pose[:2], truth[:2]) / way, abs(float(wrap(pose.theta - truth.theta)))


def noisy(robot):
    """The same with noise on every reading of the mice, and the file saying so."""
    return replace(robot, mice=tuple(replace(mouse, noise_relative=NOISE) for mouse in robot.mice))


def table(robot, plant, runs, metres):
    """(condition, estimator) -> (runs, 2)."""
    rows = {(condition, name): [] for condition, names in CONDITIONS.items() for name in names}
    for seed in range(runs):
        sound, dead, _ = wander(robot, plant, seed, metres)
        rough, _, _ = wander(noisy(robot), plant, seed, metres)
        for condition, found in (("mice sound", sound), ("1 % noise", rough), ("one dead", dead)):
            for name in CONDITIONS[condition]:
                rows[condition, name].append(found[name])
    return {key: np.array(each) for key, each in rows.items()}


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--runs", type=int, default=20)
    parser.add_argument("--metres", type=float, default=20.0)
    parser.add_argument("--save", action="store_true", help="write the table into results/")
    arguments = parser.parse_args()
    robot, missed = robots.load("mecanum4"), []
    lines = [
        f"{platform.machine()}, Python {platform.python_version()}, {robot.name}, {arguments.runs} runs of "
        f"{arguments.metres:g} m",
        f"{'':13s} {'':11s} {'':16s} {'end, % of the way':>20s} {'heading, deg':>16s}",
        f"{'plant':13s} {'mice':11s} {'odometry':16s} {'median':>10s} {'largest':>9s} {'median':>8s} {'largest':>7s}",
    ]
    for plant, label, runs in (
        ("slip", "slip", arguments.runs),
        ("first_order", "perfect grip", max(1, arguments.runs // 4)),  # the check that nothing but slip is at work
    ):
        found = table(robot, plant, runs, arguments.metres)
        for (condition, name), values in found.items():
            end, turn = 100.0 * values[:, 0], np.degrees(values[:, 1])
            lines.append(
                f"{label:13s} {condition:11s} {name:16s} {np.median(end):10.4f} {end.max():9.4f} "
                f"{np.median(turn):8.3f} {turn.max():7.3f}"
            )
        wheels = np.median(found["mice sound", "wheel_odometry"][:, 0])
        if plant == "slip" and np.median(found["mice sound", "fused_odometry"][:, 0]) > wheels:
            missed.append("fused against wheels, mice sound")
        if plant == "slip" and np.median(found["one dead", "fused_odometry"][:, 0]) > 2.0 * wheels:
            missed.append("fused against twice the wheels, one mouse dead")
    lines.append("bars: reached" if not missed else f"bars missed: {'; '.join(missed)}")
    text = "\n".join(lines)
    print(text)
    if arguments.save:
        path = Path(__file__).parent / "results" / "dead_reckoning.txt"
        path.write_text(text + "\n", encoding="utf-8")
    return 1 if missed else 0


if __name__ == "__main__":
    sys.exit(main())
