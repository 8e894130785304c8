"""How soon is a failing mouse found, and what does a failing sensor cost in the end?

    python benchmarks/sensor_faults.py [--runs 30] [--drives 4] [--save]

First table: mice alone. Random motions of some 40 mm/s and 0.3 rad/s, 20 s each; mounts wrong by 1 degree, 1 mm and
1 % (standard deviations); each mouse read every 5 +- 1 ms by its own clock, ticks of 15 +- 3 ms; one mouse counts
nothing, half, four fifths, or its y only (`stuck x`) from 8 to 12 s. Time from the fault until that mouse alone is
left out, and until any doubt is told; both count whether the robot moves just then or not. `false` is the part of
ticks before the fault in which any mouse was doubted, `wrong` that in the fault in which only sound ones were; `back`
how often, a run, the failing mouse was trusted again before the fault ended; `mm` and `sigma` the error of the
position at its end and what the covariance says of it (medians).
Second table: mecanum4 in the simulator, 0.5 m in 20 s open loop; from 8 to 12 s a mouse or both count nothing, or the
encoders of one or all wheels count on as if they spun. Median end error of the three odometries.
Third: the error of the twist over the time constant of its filter, read at the tick and as in the first table.
Exit code 1 when four mice need more than 0.2 s (median), or a fault that can be told costs `fused_odometry` 2 mm.
"""

import argparse
import platform
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np

from holodrive import build, estimation, robots
from holodrive.estimation.dead_reckoning import advance
from holodrive.estimation.mice import rows_of
from holodrive.estimation.mouse_odometry import MouseOdometry
from holodrive.kinematics import Chassis
from holodrive.robots.spec import Mouse
from holodrive.types import Observation, Pose, WheelState

LAYOUTS = {
    2: [(0.0, 0.0), (0.1, 0.0)],
    3: [(0.1, 0.0), (-0.05, 0.08), (-0.05, -0.08)],
    4: [(0.1, 0.08), (0.1, -0.08), (-0.1, 0.08), (-0.1, -0.08)],
}
FAULTS = {"counts nothing": 0.0, "loses half": 0.5, "loses a fifth": 0.8, "stuck x": np.array([0.0, 1.0])}
BEGIN_S, END_S, LAST_S, TICK_S, FINE_S = 8.0, 12.0, 20.0, 0.015, 1e-3
NAMES = ("wheel_odometry", "mouse_odometry", "fused_odometry")


def motion(rng, highest_hz=0.5, seconds=LAST_S):
    """(N, 3) displacements every millisecond."""
    t = np.arange(round(seconds / FINE_S)) * FINE_S

    def wave(size):
        rate, phase, share = rng.uniform(0.05, highest_hz, 4), rng.uniform(0, 2 * np.pi, 4), rng.normal(size=4)
        return 0.5 * size * (share[:, None] * np.sin(2 * np.pi * rate[:, None] * t + phase[:, None])).sum(axis=0)

    return np.stack([wave(0.037), wave(0.037), wave(0.3)], axis=-1) * FINE_S


def told(displacements, places, rng, factor=1.0, wrong=1.0, late=True):
    """Times (N,) of ticks [s], and counts (N - 1, k, 2) [m], of which the second mouse tells `factor` in the fault."""
    seconds, k = len(displacements) * FINE_S, len(places)
    spread = 0.003 if late else 0.0
    ticks = np.cumsum(rng.uniform(TICK_S - spread, TICK_S + spread, int(1.3 * seconds / TICK_S)))
    ticks = ticks[ticks < seconds - 0.01]
    out = np.empty((len(ticks) - 1, k, 2))
    for m, (x, y) in enumerate(places):
        off = wrong * rng.normal(size=4) * [1e-3, 1e-3, np.radians(1.0), 0.01]
        ways = displacements @ rows_of(Pose(x + off[0], y + off[1], off[2])).T * (1.0 + off[3])
        if m == 1:
            ways[round(BEGIN_S / FINE_S) : round(END_S / FINE_S)] *= factor
        total = np.concatenate([np.zeros((1, 2)), np.cumsum(ways, axis=0)])
        read = ticks
        if late:
            clock = np.cumsum(rng.uniform(0.004, 0.006, int(1.4 * seconds / 0.005)))
            read = clock[np.searchsorted(clock, ticks) - 1]
        out[:, m] = np.diff(np.floor(total[(read / FINE_S).astype(int)] / 1e-5 + rng.random(2)), axis=0) * 1e-5
    return ticks, out


def believed(places, counts, params=None):
    """Estimates of one run of counts."""
    mice = tuple(Mouse(f"m{k}", Pose(x, y, 0.0)) for k, (x, y) in enumerate(places))
    # faster than the paper's robot: no reading is too fast here
    plug = replace(params or MouseOdometry(), jump_factor=20.0)
    robot = replace(robots.load("mecanum4"), mice=mice)
    loop = estimation.KernelEstimator(plug, robot)
    blind = WheelState(np.full(4, np.nan), np.full(4, np.nan), np.empty(0))
    loop.reset(Pose(0.0, 0.0, 0.0))
    rows = np.concatenate([0.0 * counts[:1], counts])
    return [loop.step(Observation(TICK_S * k, TICK_S, blind, mice=row)) for k, row in enumerate(rows)]


def found(mice, factor, runs):
    """Times [s] until left out and until told; means of false, of wrong, of back; medians of error and sigma [m]."""
    rng, out, doubt, shares, ends = np.random.default_rng(1), [], [], [], []
    for _ in range(runs):
        moves = motion(rng)
        ticks, counts = told(moves, LAYOUTS[mice], rng, factor)
        beliefs = believed(LAYOUTS[mice], counts)
        suspect = np.array([belief.suspect for belief in beliefs])
        during = (ticks >= BEGIN_S) & (ticks < END_S)
        out += [ticks[during & (suspect == 2)][:1] - BEGIN_S]
        doubt += [ticks[during & (suspect > 0)][:1] - BEGIN_S]
        false = np.mean(suspect[ticks < BEGIN_S] > 0)
        wrong = np.mean((suspect[during] > 0) & (suspect[during] & 2 == 0))
        seen = suspect[during]
        back = np.sum((seen[:-1] == 2) & (seen[1:] & 2 == 0))
        shares.append((false, wrong, back))
        end = np.flatnonzero(during)[-1]
        pose, truth = np.array(beliefs[end].pose), np.zeros(3)
        for move in moves[round(ticks[0] / FINE_S) : round(ticks[end] / FINE_S)]:
            advance(truth, move)
        ends.append((np.hypot(*(pose - truth)[:2]), np.sqrt(np.trace(np.asarray(beliefs[end].covariance)[:2, :2]))))
    return np.concatenate(out), np.concatenate(doubt), np.mean(shares, axis=0), np.median(ends, axis=0)


def drive(plant, fault, seed):
    """End errors [m] of the three odometries on one open-loop drive of mecanum4."""
    robot = robots.load("mecanum4")
    base, chassis, rng = build.simulate(robot, plant=plant, seed=seed), Chassis.of(robot), np.random.default_rng(seed)
    loops = [estimation.estimator(name, robot) for name in NAMES]
    for loop in loops:
        loop.reset(base.truth)
    rate, phase, spun = rng.uniform(0.05, 0.3, (3, 3)), rng.uniform(0.0, 2 * np.pi, (3, 3)), np.zeros(4)
    for k in range(round(LAST_S / TICK_S)):
        t, seen = k * TICK_S, base.observe()
        if BEGIN_S <= t < END_S:
            mice = seen.mice.copy()
            mice[{"mouse one": [0], "mouse two": [1], "both mice": [0, 1]}.get(fault, [])] = 0.0
            seen = replace(seen, mice=mice)
            spin = {"one wheel": [0.8, 0.0, 0.0, 0.0], "all wheels": [0.5] * 4}.get(fault, [0.0] * 4)
            spun = spun + TICK_S * robot.wheels[0].max_speed_rad_s * np.array(spin)
        wheels = WheelState(seen.wheels.position + spun, seen.wheels.speed, seen.wheels.steer)
        poses = [loop.step(replace(seen, wheels=wheels)).pose for loop in loops]
        truth = base.truth
        twist = np.array([0.1, 0.1, 0.5]) * np.sin(2 * np.pi * rate * t + phase).mean(axis=1)
        base.apply(chassis.inverse(twist))
    return [np.hypot(pose.x - truth.x, pose.y - truth.y) for pose in poses]


def twist_error(twist_s, highest_hz, late):
    """Root mean square error of the speed [m/s] and of the yaw rate [rad/s]."""
    rng, squares = np.random.default_rng(5), []
    for _ in range(6):
        moves = motion(rng, highest_hz, 15.0)
        ticks, counts = told(moves, LAYOUTS[2], rng, wrong=0.0, late=late)
        twist = np.array([belief.twist for belief in believed(LAYOUTS[2], counts, MouseOdometry(twist_s=twist_s))])
        squares.append(np.mean((twist - moves[(ticks / FINE_S).astype(int)] / FINE_S)[5:] ** 2, axis=0))
    x, y, turn = np.mean(squares, axis=0)
    return np.sqrt(0.5 * (x + y)), np.sqrt(turn)


def times(values, runs):
    """Median and 90 % of times [s], and how many of the runs have one."""
    if not len(values):
        return f"{'-':>13s} {0:3d}/{runs}"
    return f"{np.median(values):6.2f} {np.percentile(values, 90):6.2f} {len(values):3d}/{runs}"


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--runs", type=int, default=30)
    parser.add_argument("--drives", type=int, default=4)
    parser.add_argument("--save", action="store_true", help="write the tables into results/")
    arguments = parser.parse_args()
    missed = []
    machine = f"{platform.machine()}, Python {platform.python_version()}"
    lines = [f"{machine}, {arguments.runs} runs, {arguments.drives} drives"]
    lines.append(
        "mice fault             left out, s 50 90 %    told, s 50 90 %        false     wrong  back      mm   sigma"
    )
    for mice in LAYOUTS:
        for fault, factor in FAULTS.items():
            out, doubt, (false, wrong, back), ends = found(mice, factor, arguments.runs)
            lines.append(
                f"{mice:4d} {fault:15s} {times(out, arguments.runs):>22s} {times(doubt, arguments.runs):>22s} "
                f"{100 * false:7.3f} % {100 * wrong:7.3f} % {back:5.1f} {1e3 * ends[0]:7.2f} {1e3 * ends[1]:7.2f}"
            )
            if mice == 4 and fault == "counts nothing" and not (len(out) == arguments.runs and np.median(out) <= 0.2):
                missed.append("four mice, one dead, within 0.2 s")
    lines.append(f"end error, mm               {'  '.join(NAMES)}")
    for plant in ("first_order", "slip"):
        for fault in ("none", "mouse one", "mouse two", "both mice", "one wheel", "all wheels"):
            ends = 1e3 * np.median([drive(plant, fault, seed) for seed in range(arguments.drives)], axis=0)
            lines.append(f"{plant:12s} {fault:11s} " + " ".join(f"{end:15.2f}" for end in ends))
            if fault != "both mice" and ends[2] > 2.0:
                missed.append(f"fused, {plant}, {fault}")
    lines.append("twist_s  read at the tick, 0.5 Hz   2 Hz               as above, 0.5 Hz     2 Hz   [mm/s, deg/s]")
    for twist_s in (0.0, 0.01, 0.02, 0.03, 0.05):
        errors = [twist_error(twist_s, highest, late) for late in (False, True) for highest in (0.5, 2.0)]
        lines.append(f"{twist_s:7.2f}  " + "   ".join(f"{1e3 * v:8.2f} {np.degrees(w):6.2f}" for v, w in errors))
    lines.append("bars: reached" if not missed else f"bars missed: {'; '.join(missed)}")
    text = "\n".join(lines)
    print(text)
    if arguments.save:
        (Path(__file__).parent / "results" / "sensor_faults.txt").write_text(text + "\n", encoding="utf-8")
    return 1 if missed else 0


if __name__ == "__main__":
    sys.exit(main())
