"""Every tracker on the robot of the second paper, the same actuators, sensors and paths: one table.

    python benchmarks/mecanum_trackers.py [--seeds 8] [--save]

mecanum4_mice on the plant pwm_map (dead time 40 +- 10 ms, lag 50 ms, whole PWM counts), mouse odometry, everything at
its defaults. Paths at 20 mm/s: a lying and an upright lemniscate of half-width 150 mm, a circle of radius 100 mm, and
straight lines of 150 mm at 0, 22.5, 45, 67.5 and 90 deg to the robot, each from rest to rest and 1 s more. The hidden
plants have a battery of 11.2 V and of 13.2 V where the linearizer was measured at 12.2 V, and once a lag and a dead
time twice as long; all trackers that model the wheels are told the lag of the robot's file. Errors are of the true
pose. IAE is summed over the paths of a group, then taken as median over
seeds with its range in brackets; max is the largest of all; `times` is the IAE of LA-G as printed over the tracker's.
`full` is the share of ticks with a wheel at its limit, `starts` how often a wheel starts or reverses in a second.
Exit code 1 when the best tracker's IAE is not at least 5 times lower than that of LA-G as printed, of both kinds, over
all paths of a plant.
"""

import argparse
import math
import platform
import sys
import time
from dataclasses import replace
from pathlib import Path

import numpy as np

from holodrive import build, control, planning, robots

BAR = 5.0
SPEED, AFTER = 0.02, 1.0  # m/s, s
PRINTED = "la_g printed"
ROWS = {
    PRINTED: ("la_g", {"variant": "printed"}),
    "la_g clean": ("la_g", {"variant": "clean"}),
    "la_g cosine": ("la_g", {"variant": "cosine"}),
    "pid": ("pid", {}),
    "ff_pi": ("ff_pi", {}),
    "dob": ("dob", {}),
    "mpc": ("mpc", {}),
    "ff_pi, no integrals": ("ff_pi", {"ki": 0.0, "ki_theta": 0.0, "wheel_kp": 0.0, "wheel_ki": 0.0}),
    "dob, no observer": ("dob", {"trust": 0.0}),
    "mpc, no observer": ("mpc", {"trust": 0.0}),
    "dob, faster": ("dob", {"kp": 12.0, "kp_theta": 8.0, "q_s": 0.05}),
}
RIVALS = ("ff_pi", "dob", "mpc")
TOLD_LAG_S = robots.load("mecanum4_mice").pwm_map.lag_s  # by default they would read it off the plant that is driven
KINDS = ("IAE", "IAE to path")
COLUMNS = ("IAE", "max", "path", "path max", "heading", "full", "starts")


def paths():
    """Group -> references."""

    def straight(degrees):
        angle = math.radians(degrees)
        return planning.line((0.0, 0.0), (0.15 * math.cos(angle), 0.15 * math.sin(angle)))

    groups = {
        "signs": [planning.lemniscate(0.15), planning.lemniscate(0.15, upright=True)],
        "circle": [planning.circle(0.1)],
        "lines": [straight(angle) for angle in (0.0, 22.5, 45.0, 67.5, 90.0)],
    }
    return {name: [planning.follow(path, SPEED) for path in members] for name, members in groups.items()}


def plants():
    """Name -> robot whose actuators are, then are not, what its controllers believe."""
    robot = robots.load("mecanum4_mice")
    slow = replace(robot.pwm_map, lag_s=2.0 * robot.pwm_map.lag_s, dead_time_s=2.0 * robot.pwm_map.dead_time_s)
    return {
        "as measured": robot,
        "11.2 V": replace(robot, battery=replace(robot.battery, voltage_v=11.2)),
        "13.2 V": replace(robot, battery=replace(robot.battery, voltage_v=13.2)),
        "twice the lag": replace(robot, pwm_map=slow),
    }


def tracks(robot, name, params, reference, seeds, costs):
    """True poses, references (n, T, 3) and wheel commands (n, T, wheels) of n seeds."""
    length = reference.duration_s + AFTER
    start = reference.rows[0, 1:4]
    if hasattr(control.plug_class(name), "kernel"):
        out = build.rollout(
            robot, None, name, params=params, n=seeds, seed=1, reference=reference, starts=start, t=length,
            plant="pwm_map", log_every=1, workers=1,
        )  # fmt: skip
        pose, wanted = (np.stack([out.column(before + c) for c in ("x", "y", "theta")], -1) for before in ("", "ref_"))
        commands = np.stack([out.column(f"command:{wheel.name}") for wheel in robot.wheels], -1)
        cost_of(robot, control.controller(name, robot, params), reference, 200, costs)
        return pose, wanted, commands
    found = []
    for seed in range(seeds):
        driver = Timed(control.controller(name, robot, params), costs)
        base = build.simulate(robot, plant="pwm_map", seed=seed, start=start)
        found.append(build.drive(base, driver, trajectory=reference, duration_s=length, stop_on_arrival=False))
    return (np.stack([getattr(run, what) for run in found]) for what in ("pose", "reference", "wheel_commands"))


def cost_of(robot, driver, reference, ticks, costs):
    """Times of single ticks of a compiled controller in the ordinary loop."""
    base = build.simulate(robot, plant="pwm_map", start=reference.rows[0, 1:4])
    build.drive(base, Timed(driver, costs), trajectory=reference, duration_s=ticks * robot.control_period_s)


class Timed:
    """A controller whose ticks are timed [us of the processor]."""

    def __init__(self, inner, times):
        self.inner, self.times, self.command_kind = inner, times, inner.command_kind

    def reset(self):
        self.inner.reset()

    def step(self, reference, estimate, observation):
        begin = time.thread_time()
        decision = self.inner.step(reference, estimate, observation)
        self.times.append(1e6 * (time.thread_time() - begin))
        return decision


def figures(robot, reference, pose, wanted, commands):
    """(n, COLUMNS) of n runs: mm s, mm, mm s, mm, mrad, share, 1/s."""
    dt = robot.control_period_s
    error = 1e3 * np.hypot(*(pose - wanted)[..., :2].transpose(2, 0, 1))
    away = 1e3 * planning.distance_to_path(reference, pose)
    heading = 1e3 * np.sqrt(np.mean((pose - wanted)[..., 2] ** 2, axis=1))
    limits = np.array([wheel.max_speed_rad_s for wheel in robot.wheels])
    full = np.mean(np.any(np.abs(commands) >= (1.0 - 1e-9) * limits, axis=-1), axis=1)
    ways = np.sign(commands)
    starts = np.sum((np.diff(ways, axis=1) != 0.0) & (ways[:, 1:] != 0.0), axis=(1, 2))
    seconds = dt * error.shape[1]
    return np.stack(
        [dt * error.sum(axis=1), error.max(axis=1), dt * away.sum(axis=1), away.max(axis=1), heading, full,
         starts / seconds], axis=-1,
    )  # fmt: skip


def measure(robot, groups, seeds):
    """(Row, group) -> (paths, seeds, COLUMNS), and row -> median cost of a tick [us]."""
    found, spent = {}, {}
    for label, (name, params) in ROWS.items():
        told = params | ({"lag_s": TOLD_LAG_S} if name in RIVALS else {})
        costs = []
        for group, members in groups.items():
            found[label, group] = np.stack(
                [figures(robot, each, *tracks(robot, name, told, each, seeds, costs)) for each in members]
            )
        spent[label] = float(np.median(costs))
    return found, spent


def line(label, rows, printed, cost):
    """One row of the table."""
    sums = rows.sum(axis=0)[:, [0, 2]]  # of each seed over the paths

    def told(values):
        return f"{np.median(values):8.3g} [{values.min():.3g}, {values.max():.3g}]".ljust(26)

    base = np.median(printed.sum(axis=0)[:, [0, 2]], axis=0)
    times = base / np.median(sums, axis=0)
    worst = rows.max(axis=(0, 1))
    heading, full, starts = np.median(rows.mean(axis=0)[:, 4:], axis=0)
    text = (
        f"{label:20s} {told(sums[:, 0])} {times[0]:7.1f} {worst[1]:8.3f}  {told(sums[:, 1])} {times[1]:7.1f} "
        f"{worst[3]:8.3f} {heading:8.3f} {100 * full:6.1f} {starts:7.2f} {cost:7.0f}"
    )
    return text, times


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--seeds", type=int, default=8)
    parser.add_argument("--save", action="store_true", help="write the table into results/")
    arguments = parser.parse_args()
    groups, missed = paths(), []
    lines = [f"{platform.machine()}, Python {platform.python_version()}, {arguments.seeds} seeds each: median [range]"]
    head = (
        f"{'':20s} {'IAE mm s':26s} {'times':>7s} {'max mm':>8s}  {'IAE to path mm s':26s} {'times':>7s} "
        f"{'max mm':>8s} {'mrad':>8s} {'full %':>6s} {'starts':>7s} {'us/tick':>7s}"
    )
    for plant, robot in plants().items():
        found, spent = measure(robot, groups, arguments.seeds)
        best = np.zeros(2)
        for group in (*groups, "all"):
            lines += ["", f"{plant}, {group}", head]
            for label in ROWS:
                chosen = [found[label, g] for g in groups] if group == "all" else [found[label, group]]
                base = [found[PRINTED, g] for g in groups] if group == "all" else [found[PRINTED, group]]
                text, times = line(label, np.concatenate(chosen), np.concatenate(base), spent[label])
                lines.append(text)
                if group == "all" and label in RIVALS:
                    best = np.maximum(best, times)
                    reached = [what for what, ratio in zip(KINDS, times, strict=True) if ratio >= BAR]
                    lines[-1] += f"   {BAR:g} x reached: {', '.join(reached) or 'neither'}"
        missed += [f"{what} on {plant}" for what, ratio in zip(KINDS, best, strict=True) if ratio < BAR]
        print("\n".join(lines[-len(ROWS) - 2 :]), flush=True)
    lines.append(f"bars: {'MISSED: ' + '; '.join(missed) if missed else 'kept'}")
    print(lines[-1])
    if arguments.save:
        (Path(__file__).parent / "results" / "mecanum_trackers.txt").write_text("\n".join(lines) + "\n")
    sys.exit(int(bool(missed)))


if __name__ == "__main__":
    main()
