"""Benchmarks A1 to A4: fixed courses and random worlds, standing and crossed."""

import math
from collections.abc import Sequence
from typing import Any

import numpy as np

from holodrive import build, worlds
from holodrive.experiments.experiment import Result, Setting
from holodrive.experiments.hybrid import printed, variants
from holodrive.experiments.hybrid.variants import Variant, drive, path, swept
from holodrive.experiments.pictures import Gallery, paths_over
from holodrive.log.run import Run
from holodrive.reports.sections import ComparisonSection, Section, TableSection
from holodrive.reports.tables import table
from holodrive.tuning import Sweep, wilson
from holodrive.types import Array
from holodrive.worlds.spec import World

SHOWN = 12  # random worlds in a picture

ON_COURSE = (
    variants.REPAIRED,
    variants.TUNED,
    variants.DIFFERENTIAL,
    Variant("repaired, slip", plant="slip"),
    Variant("repaired, 22 rpm", slow=True),
    Variant("repaired, 22 rpm, slip", slow=True, plant="slip"),
    variants.PRINTED_VIII,
    variants.PRINTED_VII,
    Variant("FLC + MPC", controller="fuzzy_mpc"),
    Variant("FLC + PID", controller="fuzzy_pid"),
    Variant("bee colony + PID", controller="pid", plan="bee_colony"),
    Variant("shortest path + PID", controller="pid", plan="visibility"),
)
DRAWN = ("repaired", "repaired, differential", "Table VIII as printed", "Table VII as printed", "bee colony + PID")
REPLAYED = ("repaired", "Table VIII as printed", "bee colony + PID")


def a1(setting: Setting) -> Result:
    """The course of the paper without the obstacle on its goal, walls 3 x 5 m."""
    world = worlds.load("paper_course")
    shortest = build.plan(variants.REPAIRED.robot, world, "visibility", margin_m=0.0).length_m
    note = (
        "From (0.5, 0.5) m heading +y to (0.5, 4.5) m within 5 cm, footprint 23 cm, lidar noise 1 %, wheel odometry. "
        f"The shortest possible path is {100.0 * shortest:.1f} cm; Table X has {printed.FLC[0]:g} cm (FLC) and "
        f"{printed.ABC[0]:g} cm (bee colony). Turns are bends of more than 10 degrees."
    )
    return _fixed("Benchmark A1: the paper's course", world, note, setting)


def a2(setting: Setting) -> Result:
    """The course with obstacle 4 on the goal: stop 48 cm before its centre; walls 3 x 4.5 m."""
    world = worlds.load("paper_course_printed", {"goal.tolerance": "48 cm"})
    note = "Obstacle 4 stands on the goal; arriving means 48 cm from its centre."
    return _fixed("Benchmark A2: obstacle 4 kept", world, note, setting)


def _fixed(title: str, world: World, note: str, setting: Setting) -> Result:
    rows, runs = [], {}
    for variant in ON_COURSE:
        setting.tell(f"            {variant.name}")
        found = [on_course(variant, world, seed) for seed in range(1, setting.seeds + 1)]
        rows.append({"controller": variant.name, **figures(found)})
        runs[variant.name] = found[0]
    paths = paths_over(world, [(name, runs[name].pose) for name in DRAWN], 620.0, 760.0)
    note += f" Medians over {setting.seeds} noise seeds; turns and clearance also at their worst."
    sections: tuple[Section, ...] = (
        TableSection(title, table(rows), note),
        Gallery(f"{title}, paths", ((world.title, paths),)),
        ComparisonSection(tuple(runs[name] for name in REPLAYED), REPLAYED, f"{title}, replay"),
    )
    return Result(sections=sections, data={"rows": rows})


def on_course(variant: Variant, world: World, seed: int = 1) -> Run:
    """One run over a fixed course; a planner's path is followed where the variant has one."""
    if not variant.plan:
        return drive(variant, world, seed, 240.0 if variant.slow else 120.0)
    plan = build.plan(variant.robot, world, variant.plan, seed=seed)
    return drive(variant, world, seed, trajectory=plan.reference(variant.robot))


def figures(runs: Sequence[Run]) -> dict[str, Any]:
    """Of the same drive under several noise seeds: shares, medians, and the worst of what must not be bad."""
    values = {name: np.array([run.metrics[name] for run in runs]) for name in runs[0].metrics}
    return {
        "arrived": f"{int(values['arrived'].sum())} of {len(runs)}",
        "time_s": float(np.median(values["time_s"])),
        "path_length_m": float(np.median(values["path_length_m"])),
        "turns": float(np.median(values["turns"])),
        "most_turns": float(values["turns"].max()),
        "min_clearance_m": float(values["min_clearance_m"].min()),
        "collisions": int(values["collisions"].sum()),
    }


def a3(setting: Setting) -> Result:
    """Random worlds with four standing obstacles."""
    note = (
        f"{setting.worlds} worlds from seed {setting.first_seed} on, never looked at while designing; 90 s; success: "
        "arrived and touched nothing. Intervals are Wilson's, 95 %."
    )
    return _random("Benchmark A3: random worlds", variants.AVOIDERS, setting, 0, note)


def a4(setting: Setting) -> Result:
    """Random worlds with two obstacles that cross them."""
    note = (
        f"{setting.worlds} worlds as in A3 with two more circles that go from wall to wall at 0.1 to 0.3 m/s and mind "
        "nobody. Success: arrived without a collision in which the robot itself moved."
    )
    return _random("Benchmark A4: crossers", (variants.REPAIRED, variants.TUNED), setting, 2, note)


def _random(title: str, chosen: Sequence[Variant], setting: Setting, crossers: int, note: str) -> Result:
    rows, sections = [], []
    for variant in chosen:
        setting.tell(f"            {variant.name}: {setting.worlds} worlds")
        found = swept(variant, setting, crossers)
        rows.append({"controller": variant.name, **judged(found, moved_only=crossers > 0)})
        if variant is variants.REPAIRED:
            sections += _failures(found, variant, crossers)
    sections.insert(0, _first_ones(title, setting, crossers))
    return Result(sections=(TableSection(title, table(rows), note), *sections), data={"rows": rows})


def judged(found: Sweep, moved_only: bool) -> dict[str, Any]:
    """Success with its interval, collisions, time-outs, and what successful runs are like; one variant's sweep."""
    hit = found["moved_collisions" if moved_only else "collisions"][0] > 0
    good = succeeded(found, moved_only)
    low, high = wilson(int(good.sum()), len(good))
    return {
        "success_pct": 100.0 * float(good.mean()),
        "interval_pct": f"{100.0 * low:.2f} to {100.0 * high:.2f}",
        "hit_pct": 100.0 * float(hit.mean()),
        "touched_pct": 100.0 * float((found["collisions"][0] > 0).mean()),
        "not_there_pct": 100.0 * float(((found["arrived"][0] == 0.0) & ~hit).mean()),
        "time_s": _median(found["time_s"][0][good]),
        "length_over_straight": _median((found["path_length_m"] / found["straight_m"])[0][good]),
        "clearance_p5_m": float(np.quantile(found["min_clearance_m"][0][good], 0.05)) if good.any() else math.nan,
    }


def succeeded(found: Sweep, moved_only: bool) -> Any:
    """(n,) whether each robot arrived and hit nothing (while it moved)."""
    return found.succeeded[0] & (found["moved_collisions" if moved_only else "collisions"][0] == 0.0)


def _median(values: Array) -> float:
    return float(np.median(values)) if len(values) else math.nan


def _first_ones(title: str, setting: Setting, crossers: int) -> Section:
    drawn = (variants.REPAIRED, variants.PRINTED_VIII)
    pictures = []
    for number in range(setting.first_seed, setting.first_seed + min(SHOWN, setting.worlds)):
        world = worlds.course(number, crossers)
        pictures.append((world.name, paths_over(world, [(v.name, path(v, number, crossers)) for v in drawn])))
    note = "Crossers are drawn where they begin." if crossers else ""
    return Gallery(f"{title}, the first of them", tuple(pictures), note)


def _failures(found: Sweep, variant: Variant, crossers: int) -> list[Section]:
    failed = np.flatnonzero(~succeeded(found, crossers > 0))[:SHOWN]
    pictures = []
    for number in (found.job.first + int(k) for k in failed):
        world = worlds.course(number, crossers)
        pictures.append((world.name, paths_over(world, [(variant.name, path(variant, number, crossers))])))
    return [Gallery(f"Where {variant.name} failed", tuple(pictures))] if pictures else []
