"""Table X and the claims that the text makes of it: bee colony against fuzzy control."""

import math
from typing import Any

import numpy as np

from holodrive import build, worlds
from holodrive.experiments.claims import Claim, claimed
from holodrive.experiments.experiment import Result, Setting
from holodrive.experiments.hybrid import courses, printed, robots, variants
from holodrive.experiments.pictures import Gallery, paths_over
from holodrive.planning import Plan

ABC_NOTE = "followed by a PID tracker, 5 cm farther from the obstacles than the planned length above"
COLONIES = 10  # searches, of which the median is told


def table_x(setting: Setting) -> Result:
    """Lengths, times, turns and via points."""
    world, robot = worlds.load("paper_course"), robots.table_x()
    exact = build.plan(robot, world, "visibility", margin_m=0.0)
    colony = [build.plan(robot, world, "bee_colony", seed=seed, margin_m=0.0) for seed in range(1, COLONIES + 1)]
    plan = sorted(colony, key=lambda p: p.length_m)[len(colony) // 2]
    fuzzy = courses.on_course(variants.REPAIRED, world)
    bees = courses.on_course(next(v for v in courses.ON_COURSE if v.plan == "bee_colony"), world)
    claims = (
        *_lengths(exact, plan, fuzzy.metrics),
        *_times(bees.metrics, fuzzy.metrics),
        *_via(plan),
        *_shares(plan, fuzzy.metrics),
    )
    drawn = paths_over(
        world,
        [("fuzzy", fuzzy.pose), ("bee colony", plan.points), ("shortest", exact.points)],
        width=360.0,
        height=560.0,
    )
    data = {
        "shortest_m": exact.length_m,
        "bee_colony_m": [p.length_m for p in colony],
        "fuzzy": fuzzy.metrics,
        "bee_colony_followed": bees.metrics,
    }
    return Result(claims, (Gallery("Table X: paths", ((world.name, drawn),)),), data)


def _lengths(exact: Plan, plan: Plan, fuzzy: dict[str, float]) -> list[Claim]:
    note = f"no path is shorter than {100.0 * exact.length_m:.1f} cm (tangents at 23 cm); the course without obstacle 4"
    abc, flc = printed.ABC, printed.FLC
    return [
        claimed("Table X", "ABC: path length", abc[0], 100.0 * plan.length_m, "cm", note=note),
        claimed("Table X", "FLC: path length", flc[0], 100.0 * fuzzy["path_length_m"], "cm"),
        Claim("Table X", "ABC: turns", float(abc[3]), float(plan.turns), "not comparable", "",
              "what counts as a turn is not said; ours: changes of heading above 10 degrees"),
        Claim("Table X", "FLC: turns", float(flc[3]), fuzzy["turns"], "not comparable"),
    ]  # fmt: skip


def _times(bees: dict[str, float], fuzzy: dict[str, float]) -> list[Claim]:
    note = "the motors are chosen for the mean speed of Table X: ours is no independent check of the time"
    return [
        claimed(
            "Table X",
            "ABC: time",
            printed.ABC[1],
            bees["time_s"],
            "s",
            note=ABC_NOTE,
        ),
        claimed("Table X", "FLC: time", printed.FLC[1], fuzzy["time_s"], "s", note=note),
        claimed(
            "Table X",
            "FLC: mean speed",
            printed.FLC[0] / printed.FLC[1],
            100.0 * fuzzy["mean_speed_m_s"],
            "cm/s",
            within=0.1,
        ),
    ]


def _via(plan: Plan) -> list[Claim]:
    claims = []
    for name, (length, _, via, _) in (("ABC", printed.ABC), ("FLC", printed.FLC)):
        points = np.array([printed.START_CM, *via, printed.END_CM])
        found = float(np.sum(np.hypot(*np.diff(points, axis=0).T)))
        note = "the path through the printed points is longer than the printed path"
        claims.append(Claim("Table X", f"{name}: length through its via points", length, found, "contradicts itself",
                            "cm", note))  # fmt: skip
    (x, y), obstacle = printed.ABC[2][0], printed.OBSTACLES_CM[0]
    gap = math.hypot(x - obstacle[0], y - obstacle[1]) - obstacle[2]
    claims.append(Claim("Table X", "P1: distance from obstacle 1", None, gap, "not printed", "cm",
                        "so the paper's planner reckons with a robot of 23 cm radius"))  # fmt: skip
    return [*claims, _beyond()]


def _beyond() -> Claim:
    """With x = 275 cm in the second via point no y makes the path as short as printed."""
    first, end, x = np.array(printed.FLC[2][0]), np.array(printed.END_CM), printed.FLC[2][1][0]
    y = np.linspace(-100.0, 600.0, 70_001)
    through = np.hypot(x - first[0], y - first[1]) + np.hypot(x - end[0], y - end[1])
    least = float(np.hypot(*(first - np.array(printed.START_CM))) + through.min())
    return Claim("Table X", "FLC: least length with x = 275 cm in P2", printed.FLC[0], least, "cannot be", "cm",
                 "no misprint of y explains the printed length")  # fmt: skip


def _shares(plan: Plan, fuzzy: dict[str, float]) -> list[Claim]:
    length = 1.0 - printed.FLC[0] / printed.ABC[0]
    time = 1.0 - printed.FLC[1] / printed.ABC[1]
    return [
        claimed("conclusion", "FLC shorter than ABC, by Table X's lengths", 100.0 * printed.SHORTER, 100.0 * length,
                "%", within=0.1, note="of the printed numbers; ours is the next line"),
        claimed("conclusion", "FLC shorter than ABC, driven here", 100.0 * printed.SHORTER,
                100.0 * (1.0 - fuzzy["path_length_m"] / plan.length_m), "%", within=0.1,
                note="a bee colony that works plans nearly the shortest path; the fuzzy path is a little longer"),
        Claim("conclusion", "FLC faster than ABC", 100.0 * printed.FASTER, 100.0 * time, "contradicts itself", "%",
              "from the times of Table X"),
        Claim("text", "where 25.44 s comes from", "Table X: MATLAB; text: the robot", None,
              "contradicts itself", note="the same number is given for a simulation and for the robot"),
    ]  # fmt: skip


def library(setting: Setting) -> Result:
    """The paper's library exchanges the two outputs."""
    from holodrive.control import fuzzy

    exact, theirs = fuzzy.load("paper_viii"), fuzzy.load("paper_viii", fuzzylab_compat=True)
    grid = np.random.default_rng(0).uniform(*printed.UNIVERSE_MM, (20_000, 3))
    ours, swapped = exact.evaluate(grid), theirs.evaluate(grid)
    both = np.isfinite(ours).all(axis=1) & np.isfinite(swapped).all(axis=1)
    as_given = float(np.max(np.abs(ours - swapped)[both]))
    exchanged = float(np.max(np.abs(ours - swapped[:, ::-1])[both]))
    right = [1500.0, 1500.0, 200.0]
    data: dict[str, Any] = {"as_given": as_given, "exchanged": exchanged}
    note = "evalfis.py of fuzzylab 0.13 counts columns from 1 in an array that counts from 0"
    claims = (
        Claim("section VI.B", "outputs of fuzzylab's evalfis", "L, R", "R, L", "differs", note=note),
        Claim("section VI.B", "largest error of its centroid as given", None, as_given, "differs", "of 300"),
        Claim("section VI.B", "after exchanging the outputs", None, exchanged, "differs", "of 300",
              "what 101 samples cost against the exact centroid"),
        Claim("section VI.B", "L, R with an obstacle near on the right", _pair(exact.evaluate(right)),
              _pair(theirs.evaluate(right)), "differs", note="Table VIII exact, and through the library"),
    )  # fmt: skip
    return Result(claims, data=data)


def _pair(values: Any) -> str:
    return ", ".join(f"{value:.1f}" for value in values)
