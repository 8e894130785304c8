"""Obstacle avoidance judged: the paper's course (A1, A2), random worlds (A3) and crossers (A4), bars beside figures.

    python benchmarks/avoidance.py [--worlds 3000] [--crossed 1000] [--first 100000] [--seeds 10] [--save]

Robot hybrid3_table_x (75 rpm motors, footprint 23 cm), RPLIDAR A1 at 5.5 Hz with 1 % noise and motion distortion,
wheel odometry, first_order unless said. Worlds from seed 100000 on were never looked at while designing or tuning.
Peers are the rule tables as printed and the same goal seeking and barrier without any rule. Exit code 1 when a bar is
missed. `holodrive reproduce hybrid --part a3 --worlds 3000` gives the same numbers as a page.
"""

import argparse
import contextlib
import io
import sys
import time
from pathlib import Path

from holodrive import worlds
from holodrive.experiments import Setting
from holodrive.experiments.hybrid import courses, variants

A1_BARS = {"path_length_m": 4.35, "turns": 3, "time_s": 25.4}
A1_CLEARANCE_M = 0.05
A3_BARS = {"repaired": 99.0, "tuned": 99.5}  # % success
A4_BAR = 95.0
A3_VARIANTS = (*variants.AVOIDERS, variants.WITHOUT_RULES)


def main(arguments):
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--worlds", type=int, default=3000)
    parser.add_argument("--crossed", type=int, default=1000)
    parser.add_argument("--first", type=int, default=100_000)
    parser.add_argument("--seeds", type=int, default=10, help="noise seeds on the fixed courses")
    parser.add_argument("--save", action="store_true", help="keep the output in benchmarks/results/")
    options = parser.parse_args(arguments)
    text = io.StringIO()
    with contextlib.redirect_stdout(_Both(sys.stdout, text)):
        missed = [*a1(options), *a2(options), *a3(options), *a4(options)]
        print("\nall bars met" if not missed else "\nmissed: " + "; ".join(missed))
    if options.save:
        (Path(__file__).parent / "results" / "avoidance.txt").write_text(text.getvalue())
    return 1 if missed else 0


def a1(options):
    """The paper's course without obstacle 4; what the bars name is the default controller on first_order."""
    m = _course("A1, walls 3 x 5 m, obstacles 1 to 3", worlds.load("paper_course"), options.seeds)["repaired"]
    missed = [f"A1 {name} {m[name]:.3g}, bar {bar:g}" for name, bar in A1_BARS.items() if not m[name] <= bar]
    if not m["min_clearance_m"] >= A1_CLEARANCE_M:
        missed.append(f"A1 clearance {m['min_clearance_m']:.3f} m, bar {A1_CLEARANCE_M}")
    return missed + _unclean("A1", m, options)


def a2(options):
    world = worlds.load("paper_course_printed", {"goal.tolerance": 0.48})
    return _unclean("A2", _course("A2, obstacle 4 kept, walls 3 x 4.5 m", world, options.seeds)["repaired"], options)


def _unclean(name, m, options):
    clean = m["arrived"] == f"{options.seeds} of {options.seeds}" and not m["collisions"]
    return [] if clean else [f"{name} did not arrive cleanly"]


def _course(title, world, seeds):
    print(f"\n{title}, medians of {seeds} noise seeds (turns also, and clearance only, at their worst)")
    print(f"{'':28s} arrived  path m  time s  turns (most)  clearance m  collisions")
    rows = {}
    for variant in courses.ON_COURSE:
        m = courses.figures([courses.on_course(variant, world, seed) for seed in range(1, seeds + 1)])
        rows[variant.name] = m
        print(
            f"{variant.name:28s} {m['arrived']:>7s}  {m['path_length_m']:6.3f}  {m['time_s']:6.2f}"
            f"  {m['turns']:5.1f} {'(' + format(m['most_turns'], '.0f') + ')':>6s}"
            f"  {m['min_clearance_m']:11.3f}  {m['collisions']:10.0f}"
        )
    return rows


def a3(options):
    setting = Setting(worlds=options.worlds, first_seed=options.first)
    rows = _random("A3", A3_VARIANTS, setting, 0)
    missed = [
        f"A3 {name} {rows[name]['success_pct']:.2f} %, bar {bar} %"
        for name, bar in A3_BARS.items()
        if rows[name]["success_pct"] < bar
    ]
    return missed + [f"A3 {name}: {rows[name]['hit_pct']:.2f} % hit" for name in ("repaired",) if rows[name]["hit_pct"]]


def a4(options):
    setting = Setting(worlds=options.crossed, first_seed=options.first)
    rows = _random("A4", (variants.REPAIRED, variants.TUNED, variants.WITHOUT_RULES), setting, 2)
    share = rows["repaired"]["success_pct"]
    return [] if share >= A4_BAR else [f"A4 repaired {share:.2f} %, bar {A4_BAR} %"]


def _random(title, chosen, setting, crossers):
    what = "arrived, no collision in which the robot moved" if crossers else "arrived, no collision"
    print(f"\n{title}, {setting.worlds} worlds from seed {setting.first_seed}, success = {what}")
    print(f"{'':44s} success %  95 % Wilson       hit %  not there %  time s  path/straight  clearance p5 m")
    rows = {}
    for variant in chosen:
        begin = time.perf_counter()
        row = courses.judged(variants.swept(variant, setting, crossers), crossers > 0)
        rows[variant.name] = row
        print(
            f"{variant.name:44s} {row['success_pct']:9.2f}  {row['interval_pct']:15s} {row['hit_pct']:6.2f}"
            f"  {row['not_there_pct']:11.2f}  {row['time_s']:6.1f}  {row['length_over_straight']:13.3f}"
            f"  {row['clearance_p5_m']:14.3f}   ({time.perf_counter() - begin:.0f} s)"
        )
    return rows


class _Both(io.TextIOBase):
    def __init__(self, *streams):
        self.streams = streams

    def write(self, text):
        for stream in self.streams:
            stream.write(text)
        return len(text)

    def flush(self):
        for stream in self.streams:
            stream.flush()


if __name__ == "__main__":
    raise SystemExit(main(sys.argv[1:]))
