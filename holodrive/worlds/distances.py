"""How far a place is from what stands in a world, and whether a round robot can get from one place to another."""

import math
from collections.abc import Iterator
from dataclasses import replace

import numpy as np
from numpy.typing import ArrayLike

from holodrive.types import Array
from holodrive.worlds.spec import Box, Circle, Mover, Segment, World

Obstacle = Circle | Segment | Box | Mover

GOAL_IN_OBSTACLE = "goal-in-obstacle"  # what a file accepts when `covering` is meant


def clearance(world: World, x: ArrayLike, y: ArrayLike, time: float = 0.0) -> Array:
    """Distance [m] from points (...,) to the nearest obstacle or wall; negative inside one, infinite on open floor."""
    x, y = np.asarray(x, dtype=np.float64), np.asarray(y, dtype=np.float64)
    nearest = np.full(np.broadcast_shapes(x.shape, y.shape), np.inf)
    for _, obstacle in obstacles(world):
        nearest = np.minimum(nearest, distance(obstacle, x, y, time))
    return nearest


def distance(obstacle: Obstacle, x: ArrayLike, y: ArrayLike, time: float = 0.0) -> Array:
    """Distance [m] from points (...,) to one obstacle; negative inside."""
    x, y = np.asarray(x, dtype=np.float64), np.asarray(y, dtype=np.float64)
    match obstacle:
        case Segment():
            return _to_segment(obstacle, x, y)
        case Box():
            return _to_box(obstacle, x, y)
        case Mover():
            at = position(obstacle, time)
            return np.hypot(x - at[0], y - at[1]) - obstacle.radius
        case Circle():
            return np.hypot(x - obstacle.x, y - obstacle.y) - obstacle.radius


def obstacles(world: World) -> Iterator[tuple[str, Obstacle]]:
    """Everything that stands or moves, with what people call it; those without a name by their number."""
    for number, circle in enumerate(world.circles, 1):
        yield f"circle {circle.name or number}", circle
    for number, wall in enumerate(world.segments, 1):
        yield f"wall {wall.name or number}", wall
    for number, box in enumerate(world.boxes, 1):
        yield f"box {box.name or number}", box
    for number, mover in enumerate(world.movers, 1):
        yield f"mover {mover.name or number}", mover
    for side in world.border():
        yield f"the {side.name}", side


def covering(world: World) -> Iterator[tuple[str, float]]:
    """The obstacles that cover the goal, with how deep it is in them [m]; of movers, those that end there."""
    if world.goal is None:
        return
    x, y, _ = world.goal.pose
    for name, obstacle in obstacles(world):
        if isinstance(obstacle, Segment) or (isinstance(obstacle, Mover) and obstacle.loop):
            continue
        end = obstacle.path[-1].time if isinstance(obstacle, Mover) else 0.0
        gap = float(distance(obstacle, x, y, end))
        if gap < 0.0:
            yield name, -gap


def position(mover: Mover, time: float) -> tuple[float, float]:
    """Where a moving obstacle is [m, m]: it waits at the ends of its path, or begins it again."""
    times = [frame.time for frame in mover.path]
    if mover.loop and times[-1] > times[0] and time > times[0]:
        time = times[0] + math.fmod(time - times[0], times[-1] - times[0])
    x = np.interp(time, times, [frame.x for frame in mover.path])
    y = np.interp(time, times, [frame.y for frame in mover.path])
    return float(x), float(y)


def reachable(
    world: World, start: tuple[float, float], goal: tuple[float, float], radius_m: float, *, cell_m: float = 0.02
) -> bool:
    """Whether a round robot gets from start to goal past what stands still, on a grid (so: surely, if it says yes).

    A cell is free when a robot anywhere in it touches nothing; cells join over their sides.
    """
    from scipy.ndimage import label

    still = replace(world, movers=())
    low, high = _extent(still, start, goal, radius_m)
    xs, ys = (np.arange(low[i], high[i] + cell_m, cell_m) for i in (0, 1))
    free = clearance(still, xs[:, None], ys[None, :]) > radius_m + 0.7072 * cell_m
    regions, _ = label(free)
    at = [tuple(round((place[i] - low[i]) / cell_m) for i in (0, 1)) for place in (start, goal)]
    first, second = (int(regions[i, j]) for i, j in at)
    return first == second and first != 0


def _extent(
    world: World, start: tuple[float, float], goal: tuple[float, float], radius_m: float
) -> tuple[Array, Array]:
    """A rectangle around everything, with room to go round."""
    if world.size is not None and world.walls:
        low = np.array(world.corner)
        return low, low + np.array(world.size)
    corners = [start, goal]
    corners += [(c.x + side * c.radius, c.y + side * c.radius) for c in world.circles for side in (-1, 1)]
    corners += [end for s in world.segments for end in ((s.x1, s.y1), (s.x2, s.y2))]
    for box in world.boxes:
        half = 0.5 * math.hypot(box.length, box.width)
        corners += [(box.x - half, box.y - half), (box.x + half, box.y + half)]
    room = 2.0 * radius_m + 0.2
    return np.min(corners, axis=0) - room, np.max(corners, axis=0) + room


def _to_segment(wall: Segment, x: Array, y: Array) -> Array:
    dx, dy = wall.x2 - wall.x1, wall.y2 - wall.y1
    square = dx * dx + dy * dy
    t = ((x - wall.x1) * dx + (y - wall.y1) * dy) / (square if square > 0.0 else 1.0)
    t = np.clip(t, 0.0, 1.0)
    return np.hypot(x - wall.x1 - t * dx, y - wall.y1 - t * dy)


def _to_box(box: Box, x: Array, y: Array) -> Array:
    c, s = math.cos(box.theta), math.sin(box.theta)
    along = np.abs(c * (x - box.x) + s * (y - box.y)) - 0.5 * box.length
    across = np.abs(c * (y - box.y) - s * (x - box.x)) - 0.5 * box.width
    outside = np.hypot(np.maximum(along, 0.0), np.maximum(across, 0.0))
    return outside + np.minimum(np.maximum(along, across), 0.0)
