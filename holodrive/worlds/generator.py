"""Worlds by the thousand: round obstacles at random places, as a pure function of the seed."""

import math
from dataclasses import replace

import numpy as np

from holodrive.errors import InputError
from holodrive.types import Pose
from holodrive.worlds.files import dump
from holodrive.worlds.spec import Circle, Goal, World

TRIES = 2000  # places tried for one obstacle before the world counts as full
RESTARTS = 20  # of the whole arrangement


def generate(
    seed: int,
    *,
    size: tuple[float, float] = (6.0, 6.0),
    circles: int = 12,
    radius: tuple[float, float] = (0.1, 0.3),
    gap: float = 0.7,
    apart: float | None = None,
    tolerance: float = 0.05,
) -> World:
    """A walled arena with round obstacles, a start and a goal.

    Between any two obstacles, and between an obstacle and a wall, there is at least `gap`; start and goal keep half
    of it from everything. So every robot with a footprint radius below gap / 2 can get from start to goal.

    Args:
        seed: the same seed gives the same world, on any machine.
        size: (width, height) of the arena [m].
        circles: how many obstacles.
        radius: smallest and largest [m].
        gap: least free width [m].
        apart: least distance from start to goal [m]; half the arena's diagonal when None.
        tolerance: of the goal [m].

    Raises:
        InputError: that many obstacles with such gaps do not fit.
    """
    _sensible(size, circles, radius, gap, tolerance)
    random = np.random.Generator(np.random.Philox(key=seed % 2**64))
    least = 0.5 * math.hypot(*size) if apart is None else apart
    for _ in range(RESTARTS):
        ends = _ends(random, size, 0.5 * gap, least)
        found = None if ends is None else _obstacles(random, size, circles, radius, gap, ends)
        if ends is not None and found is not None:
            (x, y), (gx, gy) = ends
            world = World(
                name=f"generated_{seed}",
                title=f"{circles} obstacles, gaps of at least {gap:g} m",
                source=f"generated with seed {seed}",
                size=size,
                start=Pose(x, y, float(random.uniform(-math.pi, math.pi))),
                goal=Goal(Pose(gx, gy, 0.0), tolerance_m=tolerance),
                circles=tuple(found),
            )
            return replace(world, text=dump(world))
    raise InputError(
        f"{circles} obstacles of up to {radius[1]:g} m with gaps of {gap:g} m do not fit in "
        f"{size[0]:g} x {size[1]:g} m; take fewer, smaller gaps or a larger arena"
    )


def _sensible(
    size: tuple[float, float], circles: int, radius: tuple[float, float], gap: float, tolerance: float
) -> None:
    low, high = radius
    numbers = (*size, low, high, gap, tolerance)
    if not (all(math.isfinite(v) and v > 0.0 for v in numbers) and low <= high and 0 <= circles <= 1000):
        raise InputError(
            f"a generated world needs positive sizes, 0 to 1000 circles and radius = (smallest, largest); "
            f"found size {size}, circles {circles}, radius {radius}, gap {gap}, tolerance {tolerance}"
        )


def _ends(
    random: np.random.Generator, size: tuple[float, float], margin: float, apart: float
) -> tuple[tuple[float, float], tuple[float, float]] | None:
    if min(size) <= 2.0 * margin:
        return None
    for _ in range(TRIES):
        x, y, gx, gy = (float(random.uniform(margin, side - margin)) for side in (*size, *size))
        if math.hypot(gx - x, gy - y) >= apart:
            return (x, y), (gx, gy)
    return None


def _obstacles(
    random: np.random.Generator,
    size: tuple[float, float],
    count: int,
    radius: tuple[float, float],
    gap: float,
    ends: tuple[tuple[float, float], tuple[float, float]],
) -> list[Circle] | None:
    found: list[Circle] = []
    for number in range(count):
        for _ in range(TRIES):
            r, u, v = float(random.uniform(*radius)), float(random.random()), float(random.random())
            room = [side - 2.0 * (r + gap) for side in size]
            if min(room) < 0.0:
                continue
            circle = Circle(r + gap + u * room[0], r + gap + v * room[1], r, f"c{number + 1}")
            if _free(circle, found, gap, ends):
                found.append(circle)
                break
        else:
            return None
    return found


def _free(
    circle: Circle, found: list[Circle], gap: float, ends: tuple[tuple[float, float], tuple[float, float]]
) -> bool:
    return all(
        math.hypot(circle.x - other.x, circle.y - other.y) >= circle.radius + other.radius + gap for other in found
    ) and all(math.hypot(circle.x - x, circle.y - y) >= circle.radius + 0.5 * gap for x, y in ends)
