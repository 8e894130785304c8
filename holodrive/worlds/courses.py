"""Random courses to judge obstacle avoidance by: the arena of the first paper with four obstacles at random places."""

import math
from dataclasses import replace
from itertools import combinations

import numpy as np

from holodrive.types import Array, Pose
from holodrive.worlds.files import dump
from holodrive.worlds.spec import Circle, Goal, KeyFrame, Mover, World

SIZE = (3.0, 4.5)  # m
RADIUS = 0.15  # m, of every obstacle (Tuama and Hadi, Table IX)
PASSABLE = 0.66  # m: wider gaps can be driven through
CLOSED = 0.02  # m: narrower gaps to a wall cannot be mistaken for a way
SPEED = (0.1, 0.3)  # m/s, of those who cross


def course(seed: int, crossers: int = 0) -> World:
    """A walled arena 3 x 4.5 m with four circles of r 0.15 m between a start at y = 0.5 m and a goal at y = 4 m.

    Centres are uniform in x 0.2..2.8 m, y 1.0..3.6 m and drawn again until every gap between two surfaces is wider
    than 0.66 m or the circles overlap (centres nearer than 0.3 m), and every gap to a side wall is wider than 0.66 m
    or below 0.02 m. Start (0.5..2.5, 0.5) m heading +y, goal (0.5..2.5, 4.0) m within 5 cm.

    Args:
        seed: the same seed gives the same world, on any machine; the circles do not depend on `crossers`.
        crossers: circles of r 0.15 m that go from side wall to side wall and back at 0.1 to 0.3 m/s, without minding
            anybody, at a height y of 1.0 to 3.6 m.
    """
    random = np.random.Generator(np.random.Philox(key=seed % 2**64))
    start, goal = (float(value) for value in random.uniform(0.5, 2.5, 2))
    while True:
        centres = random.uniform((0.2, 1.0), (2.8, 3.6), (4, 2))
        if _fair(centres):
            break
    crossing = np.random.Generator(np.random.Philox(key=[seed % 2**64, 1]))
    world = World(
        name=f"course_{seed}" + (f"_crossers_{crossers}" if crossers else ""),
        title="Four round obstacles at random places" + (f", {crossers} crossers" if crossers else ""),
        source=f"generated with seed {seed}",
        size=SIZE,
        start=Pose(start, 0.5, 0.5 * math.pi),
        goal=Goal(Pose(goal, 4.0, 0.5 * math.pi), tolerance_m=0.05),
        circles=tuple(Circle(float(x), float(y), RADIUS, f"c{i}") for i, (x, y) in enumerate(centres, 1)),
        movers=tuple(_crosser(crossing, i) for i in range(1, crossers + 1)),
    )
    return replace(world, text=dump(world))


def _fair(centres: Array) -> bool:
    sides = np.minimum(centres[:, 0], SIZE[0] - centres[:, 0]) - RADIUS
    if not np.all((sides > PASSABLE) | (sides < CLOSED)):
        return False
    between = (math.dist(a, b) for a, b in combinations(centres, 2))
    return all(d - 2.0 * RADIUS > PASSABLE or d < 2.0 * RADIUS for d in between)


def _crosser(random: np.random.Generator, number: int) -> Mover:
    y, speed, phase = (float(random.uniform(*span)) for span in ((1.0, 3.6), SPEED, (0.0, 1.0)))
    west, east = RADIUS, SIZE[0] - RADIUS
    way = (east - west) / speed  # s for one crossing
    x = west + phase * (east - west)
    frames = ((0.0, x), ((1.0 - phase) * way, east), ((2.0 - phase) * way, west), (2.0 * way, x))
    path = [frame for k, frame in enumerate(frames) if k == 0 or frame[0] > frames[k - 1][0]]
    return Mover(RADIUS, tuple(KeyFrame(t, at, y) for t, at in path), loop=True, name=f"crosser_{number}")
