"""Is the covariance of the Kalman filter `ekf` right, and what is each sensor worth?

    python benchmarks/nees.py [--runs 100] [--save]

A swerve base (`swerve3_sensors`: wheels, gyro, two measuring wheels) wanders for 11 s, from the same seeds in five
set-ups; the filter begins after the first second, at the true pose. Each run draws its gyro's bias from the size in
the robot's file.

- drawn: the plant without slip, and on top what wheels tell as if they had slipped along and across by Gaussian
  random walks, of the size that the filter is told;
- plain: the plant without slip as the robot is, the filter with its defaults: wheels are better than it thinks;
- slip: the plant with slip, and a robot that reverses all the time, where nothing about wheels is Gaussian;
- jerks: the plant with slip, and a new random twist every 0.8 s: modules swing far and wheels contradict each other;
- motors: the same commands on the plant with motors, which lag more.

NEES of the pose is the mean over the runs at ten times; 3 is right, the 95 % band is printed. NIS is the mean square of
innovations over their variances, a row; it is below 1 because the robot accelerates less, and more smoothly, than its
limits let the filter expect. Then the error of the pose at the end, and that of `wheel_odometry` with
the gyro on the same runs. Where a plant has no slip, that is no merit: it makes one motion of wheels that contradict
each other as the plant does. Exit code 1 when a bar is missed: NEES averaged over the ten times inside the band, for
every choice of sensors in `drawn`, for gyro and measuring wheels and for all in `plain`; and the error with all sensors
below that of the wheels alone wherever these slip; and in `motors` the error of wheels and gyro below three times that
of `wheel_odometry`.
"""

import argparse
import platform
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np

from holodrive import robots
from holodrive.estimation import consistency, ekf_track
from holodrive.estimation.ekf import Ekf
from holodrive.estimation.wheel_odometry import WheelOdometry
from holodrive.geometry import rotate, wrap
from holodrive.kinematics.pipeline import CommandPipeline
from holodrive.layout import ESTIMATE_SIZE, OBS_HEADER, STEER, WHEEL_POSITION
from holodrive.observation_array import fill_observation
from holodrive.sim import SimBase

RUN_IN_S, LENGTH_S, TIMES = 1.0, 10.0, 10
SLIP = 0.01  # rad after 1 rad, along wheels and across
DRAWN = Ekf(wheel_noise=SLIP, side_noise=SLIP, way_noise=0.0)
WANDERS, REVERSES, JERKS = range(3)
JERK_S, JERK = 0.8, np.array([0.6, 0.6, 0.8])  # how long a twist lasts, its largest [m/s, m/s, rad/s]
# plant, way of driving, parameters
SETUPS = {
    "drawn": ("first_order", WANDERS, DRAWN),
    "plain": ("first_order", WANDERS, Ekf()),
    "slip": ("slip", REVERSES, Ekf()),
    "jerks": ("slip", JERKS, Ekf()),
    "motors": ("motors", JERKS, Ekf()),
}
BARS = {
    "drawn": None,
    "plain": ("gyro + measuring wheels", "all"),
    "slip": (),
    "jerks": (),
    "motors": (),
}  # None: every choice


def sensors(robot):
    """Name -> the robot with some of its sensors."""
    blind = tuple(replace(wheel, encoder=None) for wheel in robot.wheels)
    return {
        "wheels": replace(robot, imu=None, mice=()),
        "wheels + gyro": replace(robot, mice=()),
        "wheels + measuring wheels": replace(robot, imu=None),
        "gyro + measuring wheels": replace(robot, wheels=blind),
        "all": robot,
    }


def wander(robot, plant, seed, way_of_driving):
    """Observations (T, ...) and true poses (T, 3) of one run, after its run-in."""
    hard = way_of_driving == REVERSES
    rng = np.random.default_rng(seed)
    bias = rng.normal() * robot.imu.gyro_bias_rad_s
    robot = replace(robot, imu=replace(robot.imu, gyro_bias_rad_s=bias))
    base, pipeline, dt = SimBase(robot, plant=plant, seed=seed), CommandPipeline(robot), robot.control_period_s
    heading, frequency, phase = (
        rng.uniform(-np.pi, np.pi),
        rng.uniform(0.05, 0.2, 3) * (1 + hard),
        rng.uniform(0.0, 2.0 * np.pi, 3),
    )
    skip, total = round(RUN_IN_S / dt), round((RUN_IN_S + LENGTH_S) / dt) + 1
    rows, truth = np.zeros((total, OBS_HEADER)), np.zeros((total, 3))
    for k in range(total):
        fill_observation(rows[k], base.observe())
        truth[k] = base.truth
        a, b, c = np.sin(2.0 * np.pi * frequency * k * dt + phase)
        way, speed = heading + 0.8 * a, 0.6 + 0.3 * b
        twist = (speed * np.cos(way), speed * np.sin(way), 0.3 * c)
        if hard:
            twist = (0.7 * a, 0.7 * b, c)
        elif way_of_driving == JERKS:
            twist = np.random.default_rng((seed, 2, int(k * dt / JERK_S))).uniform(-JERK, JERK)
        base.apply(pipeline.step(twist, dt))
    return rows[skip:], truth[skip:]


def slipping(rows, n, seed):
    """The same observations as if wheels had slipped: along by their angles, across by where they seem to point."""
    rng, rows = np.random.default_rng((seed, 1)), rows.copy()
    angles = rows[:, WHEEL_POSITION : WHEEL_POSITION + n]
    turned = np.maximum(np.abs(np.diff(angles, axis=0)), 1e-3)
    angles[1:] += np.cumsum(SLIP * np.sqrt(turned) * rng.normal(size=turned.shape), axis=0)
    rows[1:, STEER : STEER + n] += SLIP / np.sqrt(turned) * rng.normal(size=turned.shape)
    return rows


def measure(robot, recordings, params):
    """NEES (times,) and NIS a row, end error [mm, mrad], refused a thousand rows."""
    found, ends, sums = [], [], np.zeros(3)
    for rows, truth in recordings:
        track = ekf_track.track(robot, rows, params, truth[0])
        at = np.linspace(0, len(truth) - 1, TIMES + 1).astype(int)[1:]
        found.append(consistency.nees(track.pose[at], track.covariance[at], truth[at]))
        ends.append(apart(track.pose[-1], truth[-1]))
        sums += track.nis[10:].sum(), track.nis_rows[10:].sum(), track.refused
    return np.mean(found, axis=0), sums[0] / sums[1], *rms(ends), 1e3 * sums[2] / sums[1]


def apart(pose, truth):
    """Error of a pose."""
    return np.array([*(pose - truth)[:2], wrap(pose[2] - truth[2])])


def rms(ends):
    """Of errors at the end [mm, mrad]."""
    x, y, turn = 1e3 * np.sqrt(np.mean(np.square(ends), axis=0))
    return float(np.hypot(x, y)), float(turn)


def by_wheels(robot, recordings):
    """End error of `wheel_odometry` [mm, mrad]."""
    plug, ends = WheelOdometry(), []
    params = plug.pack(robot)
    for rows, truth in recordings:
        memory, estimate = np.zeros(plug.memory_size(robot)), np.zeros(ESTIMATE_SIZE)
        for row in rows:
            plug.kernel(row, memory, params, estimate)
        pose = truth[0] + rotate(truth[0, 2], estimate[:3])
        ends.append(apart(pose, truth[-1]))
    return rms(ends)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--runs", type=int, default=100)
    parser.add_argument("--save", action="store_true", help="write the table into results/")
    arguments = parser.parse_args()
    robot, missed = robots.load("swerve3_sensors"), []
    low, high = consistency.band(3.0, arguments.runs)
    lines = [f"{platform.machine()}, Python {platform.python_version()}, {arguments.runs} runs of {LENGTH_S:g} s"]
    lines.append(f"NEES of the pose: 3 is right, 95 % band of the mean over runs {low:.2f} to {high:.2f}")
    head = f"{'NEES':>6s} {'least':>6s} {'most':>6s} {'inside':>7s} {'NIS/row':>8s}"
    lines.append(f"{'':6s} {'sensors':27s} {head} {'end mm':>8s} {'mrad':>7s} {'refused':>8s}")
    for setup, (plant, driving, params) in SETUPS.items():
        recordings, errors = [wander(robot, plant, seed, driving) for seed in range(arguments.runs)], {}
        if setup == "drawn":
            recordings = [(slipping(rows, len(robot.wheels), k), true) for k, (rows, true) in enumerate(recordings)]
        for name, seen in sensors(robot).items():
            nees, nis, error, turn, refused = measure(seen, recordings, params)
            inside, errors[name] = int(np.sum((nees >= low) & (nees <= high))), error
            figures = f"{nees.mean():6.2f} {nees.min():6.2f} {nees.max():6.2f} {inside:4d}/{TIMES} {nis:8.3f}"
            lines.append(f"{setup:6s} {name:27s} {figures} {error:8.2f} {turn:7.2f} {refused:7.2f}k")
            if name == "wheels + gyro":
                error, turn = by_wheels(seen, recordings)
                lines.append(f"{'':6s} {'   by wheel_odometry':27s} {'':38s} {error:8.2f} {turn:7.2f}")
                if setup == "motors" and errors[name] > 3.0 * error:
                    missed.append("wheels + gyro far from wheel_odometry, motors")
            if (BARS[setup] is None or name in BARS[setup]) and not low <= nees.mean() <= high:
                missed.append(f"NEES of {name}, {setup}")
        missed += (
            []
            if setup == "plain" or errors["all"] < errors["wheels"]
            else [f"all sensors no better than wheels, {setup}"]
        )
    lines.append(f"bars: {'MISSED: ' + '; '.join(missed) if missed else 'kept'}")
    print(text := "\n".join(lines))
    if arguments.save:
        (Path(__file__).parent / "results" / "nees.txt").write_text(text + "\n")
    sys.exit(int(bool(missed)))


if __name__ == "__main__":
    main()
