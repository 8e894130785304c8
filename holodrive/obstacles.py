"""A world as one flat vector, and distances to what stands and moves in it: for simulator and metrics alike.

Obstacles are numbered: circles, then segments (the arena's border first), then boxes, then movers.
Circles, boxes and movers are filled: inside them the distance is negative.
"""

import math
from typing import TYPE_CHECKING, Any

import numpy as np
from numba import njit
from numpy.typing import ArrayLike

from holodrive.leaf import leaf
from holodrive.types import Array

if TYPE_CHECKING:
    from holodrive.worlds.spec import Mover, World

# header: how many of each, and where the rows of each begin; edges are the segments, then the sides of the boxes
N_CIRCLES, N_SEGMENTS, N_EDGES, N_BOXES, N_MOVERS = range(5)
CIRCLES, EDGES, BOXES, MOVERS, FRAMES = range(5, 10)
FASTEST = 10  # m/s, speed of the fastest mover
HEADER = 11
# widths of rows
CIRCLE = 3  # x, y, radius [m]
EDGE = 4  # x1, y1, x2, y2 [m]
BOX = 6  # x, y, cos, sin, half length, half width
MOVER = 5  # radius, first key frame, key frames, loop (0 or 1), time of the path [s]
FRAME = 3  # time, x, y


def obstacles_of(world: "World | None") -> Array:
    """The obstacles of a world as one vector; none for None."""
    circles: list[Any] = [(c.x, c.y, c.radius) for c in world.circles] if world else []
    edges: list[Any] = [(s.x1, s.y1, s.x2, s.y2) for s in (*world.border(), *world.segments)] if world else []
    segments = len(edges)
    boxes = [_box(b.x, b.y, b.theta, b.length, b.width) for b in world.boxes] if world else []
    edges += [side for box in boxes for side in _sides(*box)]
    movers, frames = _movers(world.movers if world else ())
    groups = (circles, edges, boxes, movers, frames)
    flat = [np.asarray(group, dtype=np.float64).ravel() for group in groups]
    begins = HEADER + np.cumsum([0, *(len(rows) for rows in flat)])[:-1]
    counts = (len(circles), segments, len(edges), len(boxes), len(movers))
    return np.concatenate([counts, begins, [_fastest(world.movers if world else ())], *flat])


def obstacle_names(world: "World | None") -> tuple[str, ...]:
    """What to call each obstacle, by number: its own name or its kind and place in the file."""
    if world is None:
        return ()
    groups: list[tuple[str, Any]] = [
        ("circle", world.circles),
        ("segment", (*world.border(), *world.segments)),
        ("box", world.boxes),
        ("mover", world.movers),
    ]
    return tuple(item.name or f"{kind} {i + 1}" for kind, items in groups for i, item in enumerate(items))


def clearance(world: "World | None", time: ArrayLike, points: ArrayLike, footprint_m: float) -> Array:
    """Distance (T,) [m] from a round footprint to the nearest obstacle; infinite in an empty world.

    Args:
        world: where.
        time: (T,) [s], when: movers move.
        points: (T, 2 or more) x, y of the robot [m].
        footprint_m: radius of the robot.
    """
    points = np.ascontiguousarray(np.asarray(points, dtype=np.float64)[:, :2])
    return np.asarray(_clearances(obstacles_of(world), np.asarray(time, dtype=np.float64), points)) - footprint_m


@njit(cache=True, error_model="numpy")
def _clearances(obstacles, time, points):  # type: ignore[no-untyped-def]
    out = np.empty(points.shape[0])
    for i in range(points.shape[0]):
        out[i] = nearest(obstacles, time[i], points[i, 0], points[i, 1])[0]
    return out


@leaf
def nearest(obstacles, time, x, y):  # type: ignore[no-untyped-def]
    """The obstacle nearest to a point at a time.

    Returns:
        distance [m] (negative inside), direction away from the obstacle (2), its velocity (2) [m/s], its number (-1:
        there is none).
    """
    best, number, nx, ny, vx, vy = math.inf, -1, 1.0, 0.0, 0.0, 0.0
    at, count = int(obstacles[CIRCLES]), int(obstacles[N_CIRCLES])
    for i in range(count):
        dx, dy, radius = x - obstacles[at], y - obstacles[at + 1], obstacles[at + 2]
        # only below best + radius: most circles are far and cost no root
        reach, square = best + radius, dx * dx + dy * dy
        if reach > 0.0 and square < reach * reach:
            d = math.sqrt(square)
            best, number = d - radius, i
            nx, ny = (dx / d, dy / d) if d > 0.0 else (1.0, 0.0)
        at += CIRCLE
    base, at, count = count, int(obstacles[EDGES]), int(obstacles[N_SEGMENTS])
    for i in range(count):
        dx, dy = from_segment(obstacles[at], obstacles[at + 1], obstacles[at + 2], obstacles[at + 3], x, y)
        square = dx * dx + dy * dy
        if best > 0.0 and square < best * best:
            best, number = math.sqrt(square), base + i
            nx, ny = (dx / best, dy / best) if best > 0.0 else (1.0, 0.0)
        at += EDGE
    base, at, count = base + count, int(obstacles[BOXES]), int(obstacles[N_BOXES])
    for i in range(count):
        d, bx, by = from_box(obstacles, at, x, y)
        if d < best:
            best, number, nx, ny = d, base + i, bx, by
        at += BOX
    base, at, count = base + count, int(obstacles[MOVERS]), int(obstacles[N_MOVERS])
    for i in range(count):
        mx, my, mvx, mvy = mover_at(obstacles, at, time)
        d = math.hypot(x - mx, y - my)
        if d - obstacles[at] < best:
            best, number, vx, vy = d - obstacles[at], base + i, mvx, mvy
            nx, ny = ((x - mx) / d, (y - my) / d) if d > 0.0 else (1.0, 0.0)
        at += MOVER
    return best, nx, ny, vx, vy, number


@leaf
def from_segment(x1, y1, x2, y2, x, y):  # type: ignore[no-untyped-def]
    """Vector from the nearest point of a segment to a point."""
    ex, ey, px, py = x2 - x1, y2 - y1, x - x1, y - y1
    length = ex * ex + ey * ey
    t = min(1.0, max(0.0, (px * ex + py * ey) / length)) if length > 0.0 else 0.0
    return px - t * ex, py - t * ey


@leaf
def from_box(obstacles, at, x, y):  # type: ignore[no-untyped-def]
    """Signed distance to the filled box whose row begins at `at`, and the direction away from it."""
    c, s = obstacles[at + 2], obstacles[at + 3]
    dx, dy = x - obstacles[at], y - obstacles[at + 1]
    u, v = c * dx + s * dy, c * dy - s * dx
    ou, ov = abs(u) - obstacles[at + 4], abs(v) - obstacles[at + 5]
    su, sv = math.copysign(1.0, u), math.copysign(1.0, v)
    if ou > 0.0 and ov > 0.0:
        d = math.hypot(ou, ov)
        nu, nv = su * ou / d, sv * ov / d
    elif ou > ov:
        d, nu, nv = ou, su, 0.0
    else:
        d, nu, nv = ov, 0.0, sv
    return d, c * nu - s * nv, s * nu + c * nv


@leaf
def mover_at(obstacles, at, time):  # type: ignore[no-untyped-def]
    """Place (2) [m] and velocity (2) [m/s] of the mover whose row begins at `at`.

    It moves evenly between key frames and waits at the ends.
    """
    first = int(obstacles[FRAMES]) + FRAME * int(obstacles[at + 1])
    last = first + FRAME * (int(obstacles[at + 2]) - 1)
    if obstacles[at + 3] != 0.0 and obstacles[at + 4] > 0.0 and time > obstacles[first]:
        time = obstacles[first] + (time - obstacles[first]) % obstacles[at + 4]
    if time < obstacles[first] or first == last:
        return obstacles[first + 1], obstacles[first + 2], 0.0, 0.0
    if time >= obstacles[last]:
        return obstacles[last + 1], obstacles[last + 2], 0.0, 0.0
    k = first
    while obstacles[k + FRAME] <= time:
        k += FRAME
    span = obstacles[k + FRAME] - obstacles[k]
    vx, vy = (obstacles[k + FRAME + 1] - obstacles[k + 1]) / span, (obstacles[k + FRAME + 2] - obstacles[k + 2]) / span
    t = time - obstacles[k]
    return obstacles[k + 1] + t * vx, obstacles[k + 2] + t * vy, vx, vy


def _box(x: float, y: float, theta: float, length: float, width: float) -> tuple[float, ...]:
    return x, y, math.cos(theta), math.sin(theta), 0.5 * length, 0.5 * width


def _sides(x: float, y: float, c: float, s: float, a: float, b: float) -> list[tuple[float, float, float, float]]:
    corners = [(x + c * u - s * v, y + s * u + c * v) for u, v in ((-a, -b), (a, -b), (a, b), (-a, b))]
    return [(*corners[i], *corners[(i + 1) % 4]) for i in range(4)]


def _movers(movers: "tuple[Mover, ...]") -> tuple[list[Any], list[Any]]:
    rows: list[Any] = []
    frames: list[Any] = []
    for mover in movers:
        path = mover.path
        rows.append((mover.radius, len(frames), len(path), float(mover.loop), path[-1].time - path[0].time))
        frames += [(frame.time, frame.x, frame.y) for frame in path]
    return rows, frames


def _fastest(movers: "tuple[Mover, ...]") -> float:
    """Speed [m/s] that no mover exceeds; infinite when one jumps, as a loop does that ends elsewhere than it begins."""
    speeds = [
        math.hypot(b.x - a.x, b.y - a.y) / (b.time - a.time) if b.time > a.time else math.inf
        for mover in movers
        for a, b in zip(mover.path, mover.path[1:], strict=False)
    ]
    ends = [(mover.path[0], mover.path[-1]) for mover in movers if mover.loop]
    jumps = any((first.x, first.y) != (last.x, last.y) for first, last in ends)
    return math.inf if jumps else max(speeds, default=0.0)
