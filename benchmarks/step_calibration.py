"""Does a step calibration find what actuators really do? 200 hidden plants, and others that no cubic fits.

    python benchmarks/step_calibration.py [--plants 200] [--odd 50] [--save]

Each plant is the paper's robot with two ball mice (10 um counts, 15 ms ticks) and other actuators: four monotone
cubics around the printed ones, dead zones of 30 to 70 counts, dead time 20 to 80 ms (spread 10 ms from start to start),
lag 20 to 100 ms, speed noise of 0 to 2 % a control period. The compiled schedule steps each of them open-loop in one
roll-out, its log is analysed, and the linearizer that comes out is asked for speeds from 5 to 100 % of full scale (the
slowest top speed of the four curves, as in the paper); what the hidden curve makes of its duty is compared with the
speed that was asked for. `eq. 8, plain cubic` is the paper's way on the same steps; `tail, plain cubic` takes only its
cubic. `whole counts` is ours again, with the duty rounded to whole PWM counts as a driver takes it: no linearizer can
do better than half a count. The odd plants have curves that no cubic fits. `root`: PWM^0.35 to 0.6, several mm/s at the
first count. `square`: PWM^1.8 to 2.6, which creeps off slower than the mice can see, so that its dead zone seems longer
than it is. `saturating`: 1 - exp. `kink`: three straight lines.
Exit code 1 when a bar is missed: on every one of the cubic plants the dead zone within 0.5 % of full PWM, and the speed
within 2 % of full scale.
"""

import argparse
import math
import platform
import sys
import time
from dataclasses import replace
from pathlib import Path

import numpy as np

from holodrive import build, references, robots
from holodrive.calibration import steps
from holodrive.control.duty_steps import DutySteps
from holodrive.robots import curves
from holodrive.robots.spec import DutyMap

PRINTED = {  # Keek et al., eq. 9 to 12, constant first
    ("W1W4", "forward"): (43.4929, 2.8629, -0.1603, 0.0056),
    ("W1W4", "backward"): (43.4521, 4.0447, -0.2702, 0.0077),
    ("W2W3", "forward"): (53.9554, 3.4245, -0.2335, 0.0061),
    ("W2W3", "backward"): (54.96069, 1.7440, -0.1041, 0.0055),
}
COUNTS, DEAD_BAR, SPEED_BAR = 255, 0.5, 2.0  # PWM counts, % of full PWM, % of full scale
SHAPES = ("root", "square", "saturating", "kink")
ASKED = np.linspace(0.05, 1.0, 96)  # of full scale


def scale(robot):
    return {"speed_unit_m_s": 1e-3, "counts": COUNTS, "speed_scale": math.sqrt(2.0), "radius_m": robot.wheels[0].radius}


def cubic(rng, robot, printed):
    """A monotone cubic around a printed one."""
    while True:
        c = np.array(printed) * (1.0 + rng.uniform(-0.25, 0.25, size=4))
        c[0] = rng.uniform(30.0, 70.0)
        v = np.linspace(0.0, 50.0, 501)
        if (c[1] + 2.0 * c[2] * v + 3.0 * c[3] * v**2).min() > 0.3:
            return curves.from_cubic(c.tolist(), **scale(robot))


def odd(rng, robot, k):
    """A curve that no cubic fits: PWM over speed by many points."""
    dead, top, pwm = rng.uniform(30.0, 70.0), rng.uniform(34.0, 44.0), np.linspace(0.0, 1.0, 80)
    shape = (
        pwm ** rng.uniform(0.35, 0.6),
        pwm ** rng.uniform(1.8, 2.6),
        (1.0 - np.exp(-pwm * (sharp := rng.uniform(3.0, 5.0)))) / (1.0 - math.exp(-sharp)),
        np.interp(pwm, (0.0, 0.35, 0.5, 1.0), (0.0, 0.1, 0.8, 1.0)),
    )[k % 4]
    points = np.column_stack([dead + (COUNTS - dead) * pwm, top * shape])
    return curves.from_points(points, **scale(robot))


def plant(rng, robot, groups, curve):
    """A robot with hidden actuators, and its curves by group and direction."""
    hidden = {
        (group.name, direction): curve(group.name, direction)
        for group in groups for direction in steps.DIRECTIONS
    }  # fmt: skip
    owner = {wheel: group.name for group in groups for wheel in group.wheels}
    maps = tuple(
        DutyMap(hidden[owner[i], "forward"], hidden[owner[i], "backward"]) for i in range(len(robot.wheels))
    )  # fmt: skip
    pwm_map = replace(
        robot.pwm_map, wheels=maps, voltage_v=robot.battery.voltage_v, dead_time_s=rng.uniform(0.02, 0.08),
        dead_time_spread_s=0.01, lag_s=rng.uniform(0.02, 0.1), speed_spread=0.0, speed_noise=rng.uniform(0.0, 0.02),
    )  # fmt: skip
    # the board's own linearizer plays no part in open-loop steps
    return replace(robot, pwm_map=pwm_map, linearizer=None, text=""), hidden


def calibrated(robot, groups, seed):
    """The calibration of one plant, and how long it took on the robot's clock [s] and on ours."""
    wheels = tuple((group.wheels, group.diagonal, group.resolution_m) for group in groups)
    plug = DutySteps(wheels, counts=COUNTS)
    begin = time.perf_counter()
    roll = build.rollout(
        robot, None, plug, estimator="mouse_odometry", n=1, reference=references.fixed_goal((0.0, 0.0, 0.0)), t=400.0,
        plant="pwm_map", seed=seed, log_every=1, stop_on_arrival=True, workers=1,
    )  # fmt: skip
    ran = time.perf_counter() - begin
    log = roll.log[0][np.isfinite(roll.log[0][:, 0])]
    columns = {name: log[:, k] for k, name in enumerate(roll.columns)}
    pose = np.column_stack([columns[name] for name in ("est_x", "est_y", "est_theta")])
    duty = np.column_stack([columns[f"command:{wheel.name}"] for wheel in robot.wheels])
    stray = np.hypot(columns["x"], columns["y"]).max()
    found = steps.calibrate(robot, steps.records_of(robot, groups, columns["time"], pose, duty, counts=COUNTS), COUNTS)
    return found, columns["time"][-1], ran, stray


def inverse(curve, duty):
    """Speeds of a curve [rad/s] at duties; 0 in the dead zone."""
    low, high = np.zeros_like(duty), np.full_like(duty, 3.0 * curve.knots[-1])
    for _ in range(60):
        middle = 0.5 * (low + high)
        above = steps.duty_values(curve, middle) > duty
        low, high = np.where(above, low, middle), np.where(above, middle, high)
    return 0.5 * (low + high)


def judged(robot, groups, hidden, duty_at, dead_zone):
    """Largest error of the dead zone [% of full PWM] and of the speed [% of full scale]."""
    radius = robot.wheels[0].radius
    tops = [inverse(curve, np.array([1.0]))[0] * radius / math.sqrt(2.0) for curve in hidden.values()]
    asked = min(tops) * ASKED
    dead = speed = 0.0
    for (group, direction), curve in hidden.items():
        duty = np.clip(duty_at(group, direction, asked), 0.0, 1.0)
        got = inverse(curve, duty) * radius / math.sqrt(2.0)
        speed = max(speed, float(np.abs(got - asked).max()) / min(tops))
        dead = max(dead, abs(dead_zone(group, direction) - COUNTS * curve.pieces[0][0]) / COUNTS)
    return 100.0 * dead, 100.0 * speed


def ways(robot, groups, found, hidden):
    """Errors of the ways to a linearizer, and what the fits were."""
    linearizer = found.linearizer(robot)
    by_name = {group.name: group for group in groups}

    def ours(group, direction, v):
        return steps.curve_values(robot, linearizer, by_name[group], direction, COUNTS, v) / COUNTS

    def whole(group, direction, v):
        return np.rint(COUNTS * ours(group, direction, v)) / COUNTS

    def offset(group, direction):
        return found.fit_of(group, direction).dead_zone

    plain = {
        (one.group, one.direction): steps.cubic_of(1e3 * one.speed_eq8_m_s, one.pwm) for one in found.fits
    }  # fmt: skip

    def eq8(group, direction, v):
        return np.polyval(plain[group, direction][::-1], 1e3 * v) / COUNTS

    def tail(group, direction, v):
        return np.polyval(found.fit_of(group, direction).printed[::-1], 1e3 * v) / COUNTS

    return {
        "ours": judged(robot, groups, hidden, ours, offset),
        "tail, plain cubic": judged(robot, groups, hidden, tail, lambda g, d: found.fit_of(g, d).printed[0]),
        "eq. 8, plain cubic": judged(robot, groups, hidden, eq8, lambda g, d: plain[g, d][0]),
        "ours, whole counts": judged(robot, groups, hidden, whole, offset),
    }


def table(name, rows):
    """Lines for one kind of plant; whether all pass by our way."""
    lines = [f"{name}: worst, p95 and median of the largest error of each plant"]
    lines.append(f"{'':20s} {'dead zone, % of full PWM':>30s} {'speed, % of full scale':>30s} {'pass':>12s}")
    for way in rows[0]:
        values = np.array([row[way] for row in rows])  # (plants, 2)
        good = np.count_nonzero((values[:, 0] <= DEAD_BAR) & (values[:, 1] <= SPEED_BAR))
        cells = [" ".join(f"{q:9.3f}" for q in np.quantile(values[:, k], (1.0, 0.95, 0.5))) for k in (0, 1)]
        lines.append(f"{way:20s} {cells[0]:>30s} {cells[1]:>30s} {f'{good} of {len(rows)}':>12s}")
    return lines, all(row["ours"][0] <= DEAD_BAR and row["ours"][1] <= SPEED_BAR for row in rows)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--plants", type=int, default=200)
    parser.add_argument("--odd", type=int, default=50)
    parser.add_argument("--save", action="store_true", help="write the table into results/")
    arguments = parser.parse_args()
    robot = robots.load("mecanum4_mice")
    groups = steps.groups_of(robot)
    rng = np.random.default_rng(20260722)
    kinds = {"cubic": [], **{shape: [] for shape in SHAPES}}
    methods = {kind: {"cubic": 0, "points": 0} for kind in kinds}
    timing, dead_times, lags = [], [], []
    for i in range(arguments.plants + arguments.odd):
        k = i - arguments.plants
        kind = "cubic" if k < 0 else SHAPES[k % len(SHAPES)]
        draw = (
            (lambda g, d: cubic(rng, robot, PRINTED[g, d]))
            if kind == "cubic" else (lambda g, d, k=k: odd(rng, robot, k))
        )  # fmt: skip
        hidden_robot, hidden = plant(rng, robot, groups, draw)
        begin = time.perf_counter()
        found, lasted, ran, stray = calibrated(hidden_robot, groups, seed=i)
        kinds[kind].append(ways(hidden_robot, groups, found, hidden))
        timing.append((lasted, ran, time.perf_counter() - begin, stray))
        for one in found.fits:
            methods[kind][one.method] += 1
            dead_times.append(1e3 * (one.dead_time_s - hidden_robot.pwm_map.dead_time_s))
            lags.append(1e3 * (one.lag_s - hidden_robot.pwm_map.lag_s))
    lines = [f"{platform.machine()}, Python {platform.python_version()}; bars {DEAD_BAR} % and {SPEED_BAR} %"]
    kept = True
    for kind, rows in kinds.items():
        if rows:
            text, fine = table(f"{len(rows)} {kind} plants", rows)
            used = ", ".join(f"{count} by {name}" for name, count in methods[kind].items())
            lines += [*text, f"curves of ours: {used}"]
            kept = kept and (fine or kind != "cubic")
    lasted, ran, spent, stray = np.median(timing, axis=0)
    lines.append(f"a calibration: {lasted:.0f} s on the robot's clock, {1e3 * ran:.0f} ms to simulate, "
                 f"{1e3 * (spent - ran):.0f} ms to analyse and judge; strays {1e2 * stray:.0f} cm (median), "
                 f"{1e2 * np.max(timing, axis=0)[3]:.0f} cm (most)")  # fmt: skip
    for name, errors in (("dead time", dead_times), ("lag", lags)):
        lines.append(f"{name} of a curve: median error {np.median(errors):+.1f} ms, "
                     f"p95 of its size {np.quantile(np.abs(errors), 0.95):.1f} ms")  # fmt: skip
    lines.append(f"bars: {'kept' if kept else 'MISSED'}")
    print(text := "\n".join(lines))
    if arguments.save:
        (Path(__file__).parent / "results" / "step_calibration.txt").write_text(text + "\n")
    sys.exit(int(not kept))


if __name__ == "__main__":
    main()
