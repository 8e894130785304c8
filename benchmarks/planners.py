"""Planners against the exact shortest path and against a grid: lengths and times on the paper's course and others.

    python benchmarks/planners.py [--seeds 10] [--courses 20] [--save]

Bar: the bee colony's median of 10 seeds within 0.5 % of the exact shortest path on the paper's course, for the
footprint radii 0.23 and 0.28 m. The exact path comes from the visibility graph of tangents; a grid A* (1 cm cells, 16
directions, written here) knows nothing of it and must never be shorter: on `course` worlds the exact path is shown to
be a lower bound of both.
"""

import argparse
import heapq
import math
import platform
import statistics
import sys
import time
from pathlib import Path

import numba
import numpy as np

from holodrive import planning, worlds
from holodrive.errors import InputError
from holodrive.worlds.distances import clearance

BAR, CELL_M = 0.005, 0.01
MOVES = [(i, j) for i in (-2, -1, 0, 1, 2) for j in (-2, -1, 0, 1, 2) if math.gcd(i, j) == 1]  # 16 directions


def grid_length(world, need):
    """Length [m] of A*'s way over free cells (None: there is none)."""
    (x, y), (w, h) = world.corner, world.size
    xs, ys = (np.arange(0.0, side + 0.5 * CELL_M, CELL_M) for side in (w, h))
    # no move is longer than sqrt(5) cells: with half of that on top, what lies between two free cells is free
    free = clearance(world, x + xs[:, None], y + ys[None, :]) >= need + 0.5 * math.sqrt(5.0) * CELL_M
    start, goal = (
        tuple(round((place[i] - (x, y)[i]) / CELL_M) for i in (0, 1)) for place in (world.start, world.goal.pose)
    )
    steps = [(i, j, CELL_M * math.hypot(i, j)) for i, j in MOVES]
    best, done, queue = {start: 0.0}, set(), [(0.0, start)]
    while queue:
        _, cell = heapq.heappop(queue)
        if cell == goal:
            return best[cell]
        if cell in done:
            continue
        done.add(cell)
        for i, j, step in steps:
            there = cell[0] + i, cell[1] + j
            if not (0 <= there[0] < len(xs) and 0 <= there[1] < len(ys)) or not free[there]:
                continue
            length = best[cell] + step
            if length < best.get(there, math.inf):
                best[there] = length
                heapq.heappush(queue, (length + CELL_M * math.dist(there, goal), there))
    return None


def timed(function, *arguments, **options):
    begin = time.perf_counter()
    try:
        result = function(*arguments, **options)
    except InputError:
        result = None
    return result, time.perf_counter() - begin


def paper_course(seeds):
    """Lines, and whether the bar is reached."""
    world, lines, good = worlds.load("paper_course"), [], True
    for footprint in (0.23, 0.28):
        plan, wall = timed(planning.visibility, world, footprint)
        exact = plan.length_m
        lines.append(f"paper_course, R = {footprint:.2f} m: exact {100 * exact:.2f} cm in {1e3 * wall:.1f} ms")
        grid, wall = timed(grid_length, world, footprint)
        good &= grid >= exact
        lines.append(f"  grid A* {100 * grid:8.2f} cm ({100 * (grid / exact - 1):+.2f} %) in {1e3 * wall:.0f} ms")
        for name, options in (("plain", {}), ("guided", {"guided": 1.5})):
            runs = [timed(planning.bee_colony, world, footprint, seed=seed, **options) for seed in range(seeds)]
            lengths = [plan.length_m for plan, _ in runs]
            over = statistics.median(lengths) / exact - 1.0
            good &= (name != "plain" or over <= BAR) and min(lengths) >= exact - 1e-9
            lines.append(
                f"  bee colony, {name:6s} best / median / worst of {seeds} seeds "
                f"{100 * min(lengths):.2f} / {100 * statistics.median(lengths):.2f} / {100 * max(lengths):.2f} cm: "
                f"median {100 * over:+.3f} %   (bar {100 * BAR:g} %), "
                f"{1e3 * statistics.median(wall for _, wall in runs):.1f} ms"
            )
    lines.append(
        "  printed (Table X): bee colony 574.7 cm, fuzzy 536.515 cm; its via points measure 705.9 and 807.0 cm"
    )
    return lines, good


def courses(count, footprint=0.23):
    """Lines, and whether the exact path is the lower bound everywhere."""
    rows, good, lost = {"grid A*": [], "bee colony": []}, True, 0
    walls = {"exact": [], "grid A*": [], "bee colony": []}
    for seed in range(count):
        world = worlds.course(seed)
        plan, wall = timed(planning.visibility, world, footprint)
        grid, grid_wall = timed(grid_length, world, footprint)
        bees, bees_wall = timed(planning.bee_colony, world, footprint)
        for name, value in zip(walls, (wall, grid_wall, bees_wall), strict=True):
            walls[name].append(value)
        assert plan is not None, f"no way in course {seed}"
        for name, length in (("grid A*", grid), ("bee colony", bees.length_m if bees else None)):
            if length is None:
                lost += 1
                continue
            # a grid's start and goal lie up to half a cell beside the true ones
            good &= length >= plan.length_m - (2.0 * CELL_M if name == "grid A*" else 1e-9)
            rows[name].append(length / plan.length_m - 1.0)
    lines = [f"course 0 to {count - 1}, R = {footprint:g} m: over the exact length, median / worst; time, median"]
    lines.append(f"  {'exact':12s} {'':24s} {1e3 * statistics.median(walls['exact']):8.1f} ms")
    for name, over in rows.items():
        told = f"{100 * statistics.median(over):+.2f} / {100 * max(over):+.2f} %"
        lines.append(f"  {name:12s} {told:24s} {1e3 * statistics.median(walls[name]):8.1f} ms")
    lines.append(f"  exact is the lower bound of all: {'yes' if good else 'NO'}; ways not found: {lost}")
    return lines, good


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--seeds", type=int, default=10)
    parser.add_argument("--courses", type=int, default=20)
    parser.add_argument("--save", action="store_true", help="keep the lines in benchmarks/results")
    options = parser.parse_args()
    for name in planning.PLANNERS:  # compiling is not measured here
        planning.planner(name)(worlds.load("paper_course"), 0.2)
    (first, good), (second, bound) = paper_course(options.seeds), courses(options.courses)
    head = f"Python {platform.python_version()}, Numba {numba.__version__}"
    text = "\n".join([head, *first, *second])
    print(text)
    if options.save:
        (Path(__file__).parent / "results" / "planners.txt").write_text(text + "\n")
    sys.exit(0 if good and bound else 1)


if __name__ == "__main__":
    main()
