"""A world as arrays, and distances to what stands and moves in it: one definition for simulator and metrics.

Obstacles are numbered: circles, then segments (the arena's border first), then boxes, then movers.
Circles, boxes and movers are filled: inside them the distance is negative.
"""

import math
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numba import njit
from numpy.typing import ArrayLike

from holodrive.types import Array

if TYPE_CHECKING:
    from holodrive.worlds.spec import Mover, World

BOX = 6  # x, y, cos, sin, half length, half width
MOVER = 5  # radius, first key frame, key frames, loop, period [s]


class Obstacles(NamedTuple):
    """A world for kernels.

    Attributes:
        circles: (c, 3) x, y, radius [m].
        segments: (s, 4) x1, y1, x2, y2 [m], border first.
        boxes: (b, 6) x, y, cos, sin of its turn, half length, half width.
        edges: (s + 4 b, 4) segments and the boxes' sides: what a ray can meet.
        movers: (k, 5) radius, first row and number of key frames, loop (0 or 1), time of the path [s].
        frames: (f, 3) time, x, y of all movers' key frames.
        fastest: speed of the fastest mover [m/s].
    """

    circles: Array
    segments: Array
    boxes: Array
    edges: Array
    movers: Array
    frames: Array
    fastest: float


def obstacles_of(world: "World | None") -> Obstacles:
    """The obstacles of a world; none for None."""
    if world is None:
        none = [np.zeros((0, width)) for width in (3, 4, BOX, 4, MOVER, 3)]
        return Obstacles(none[0], none[1], none[2], none[3], none[4], none[5], 0.0)
    segments = _rows([(s.x1, s.y1, s.x2, s.y2) for s in (*world.border(), *world.segments)], 4)
    boxes = [(b.x, b.y, math.cos(b.theta), math.sin(b.theta), 0.5 * b.length, 0.5 * b.width) for b in world.boxes]
    edges = [side for box in boxes for side in _sides(*box)]
    movers, frames = _movers(world.movers)
    return Obstacles(
        circles=_rows([(c.x, c.y, c.radius) for c in world.circles], 3),
        segments=segments,
        boxes=_rows(boxes, BOX),
        edges=np.ascontiguousarray(np.concatenate([segments, _rows(edges, 4)])),
        movers=_rows(movers, MOVER),
        frames=_rows(frames, 3),
        fastest=_fastest(world.movers),
    )


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


@njit(cache=True, error_model="numpy")
def nearest(obstacles, time, x, y):  # type: ignore[no-untyped-def]
    """The obstacle nearest to a point at a time.

    Returns:
        distance [m] (negative inside), direction away from the obstacle (2), its velocity (2) [m/s], its number (-1:
        there is none).
    """
    best, number, nx, ny, vx, vy = math.inf, -1, 1.0, 0.0, 0.0, 0.0
    circles, segments, boxes, movers = obstacles.circles, obstacles.segments, obstacles.boxes, obstacles.movers
    for i in range(circles.shape[0]):
        dx, dy = x - circles[i, 0], y - circles[i, 1]
        # below best + radius only: most circles are far and cost no root
        reach = best + circles[i, 2]
        square = dx * dx + dy * dy
        if reach > 0.0 and square < reach * reach:
            d = math.sqrt(square)
            best, number = d - circles[i, 2], i
            nx, ny = (dx / d, dy / d) if d > 0.0 else (1.0, 0.0)
    base = circles.shape[0]
    for i in range(segments.shape[0]):
        dx, dy = from_segment(segments[i, 0], segments[i, 1], segments[i, 2], segments[i, 3], x, y)
        square = dx * dx + dy * dy
        if best > 0.0 and square < best * best:
            best, number = math.sqrt(square), base + i
            nx, ny = (dx / best, dy / best) if best > 0.0 else (1.0, 0.0)
    base += segments.shape[0]
    for i in range(boxes.shape[0]):
        d, bx, by = from_box(boxes[i], x, y)
        if d < best:
            best, number, nx, ny = d, base + i, bx, by
    base += boxes.shape[0]
    for i in range(movers.shape[0]):
        mx, my, mvx, mvy = mover_at(obstacles, i, time)
        d = math.hypot(x - mx, y - my)
        if d - movers[i, 0] < best:
            best, number, vx, vy = d - movers[i, 0], base + i, mvx, mvy
            nx, ny = ((x - mx) / d, (y - my) / d) if d > 0.0 else (1.0, 0.0)
    return best, nx, ny, vx, vy, number


@njit(cache=True, error_model="numpy")
def from_segment(x1, y1, x2, y2, x, y):  # type: ignore[no-untyped-def]
    """Vector from the nearest point of a segment to a point."""
    ex, ey, px, py = x2 - x1, y2 - y1, x - x1, y - y1
    length = ex * ex + ey * ey
    t = min(1.0, max(0.0, (px * ex + py * ey) / length)) if length > 0.0 else 0.0
    return px - t * ex, py - t * ey


@njit(cache=True, error_model="numpy")
def from_box(box, x, y):  # type: ignore[no-untyped-def]
    """Signed distance to a filled box and the direction away from it."""
    c, s = box[2], box[3]
    dx, dy = x - box[0], y - box[1]
    u, v = c * dx + s * dy, c * dy - s * dx
    ou, ov = abs(u) - box[4], abs(v) - box[5]
    su, sv = math.copysign(1.0, u), math.copysign(1.0, v)
    if ou > 0.0 and ov > 0.0:
        d = math.hypot(ou, ov)
        nu, nv = su * ou / d, sv * ov / d
    elif ou > ov:
        d, nu, nv = ou, su, 0.0
    else:
        d, nu, nv = ov, 0.0, sv
    return d, c * nu - s * nv, s * nu + c * nv


@njit(cache=True, error_model="numpy")
def mover_at(obstacles, i, time):  # type: ignore[no-untyped-def]
    """Place (2) [m] and velocity (2) [m/s] of mover `i`: even motion between key frames, waiting at the ends."""
    frames = obstacles.frames
    first = int(obstacles.movers[i, 1])
    last = first + int(obstacles.movers[i, 2]) - 1
    if obstacles.movers[i, 3] != 0.0 and obstacles.movers[i, 4] > 0.0:
        time = frames[first, 0] + (time - frames[first, 0]) % obstacles.movers[i, 4]
    if time < frames[first, 0] or first == last:
        return frames[first, 1], frames[first, 2], 0.0, 0.0
    if time >= frames[last, 0]:
        return frames[last, 1], frames[last, 2], 0.0, 0.0
    k = first
    while frames[k + 1, 0] <= time:
        k += 1
    span = frames[k + 1, 0] - frames[k, 0]
    vx, vy = (frames[k + 1, 1] - frames[k, 1]) / span, (frames[k + 1, 2] - frames[k, 2]) / span
    t = time - frames[k, 0]
    return frames[k, 1] + t * vx, frames[k, 2] + t * vy, vx, vy


def _rows(rows: list[Any], width: int) -> Array:
    return np.ascontiguousarray(np.array(rows, dtype=np.float64).reshape(-1, width))


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
    speeds = [
        math.hypot(b.x - a.x, b.y - a.y) / (b.time - a.time) if b.time > a.time else math.inf
        for mover in movers
        for a, b in zip(mover.path, mover.path[1:], strict=False)
    ]
    return max(speeds, default=0.0)
