"""Where a round robot can be: signed distances of points and of whole legs of a path to what stands in a world.

Obstacles are the flat vector of `holodrive.obstacles`, without movers. The distance of a leg is the least over its
points: exact, and negative inside circles and boxes, so that how deep a leg goes is known too.
"""

import math
from dataclasses import replace

import numpy as np
from numba import njit
from numpy.typing import ArrayLike

from holodrive import obstacles as ob
from holodrive.leaf import leaf
from holodrive.types import Array
from holodrive.worlds.spec import World

TOUCH_M = 1e-9  # a path may touch an inflated obstacle: what rounding makes of that is no collision


def standing(world: World) -> Array:
    """What stands in a world, movers left out, as `obstacles.obstacles_of` packs it."""
    return ob.obstacles_of(replace(world, movers=()))


def point_gaps(obstacles: Array, points: ArrayLike) -> Array:
    """Distance (...) [m] from points (..., 2) to the nearest obstacle; negative inside, infinite with none."""
    array = np.ascontiguousarray(np.asarray(points, dtype=np.float64))
    flat = array.reshape(-1, 2)
    return np.asarray(_point_gaps(obstacles, flat)).reshape(array.shape[:-1])


def leg_gaps(obstacles: Array, legs: ArrayLike) -> Array:
    """Distance (k,) [m] from legs (k, 4) = x1, y1, x2, y2 to the nearest obstacle."""
    return np.asarray(_leg_gaps(obstacles, np.ascontiguousarray(np.asarray(legs, dtype=np.float64).reshape(-1, 4))))


@njit(cache=True, error_model="numpy")
def _point_gaps(obstacles, points):  # type: ignore[no-untyped-def]
    out = np.empty(points.shape[0])
    for i in range(points.shape[0]):
        out[i] = ob.nearest(obstacles, 0.0, points[i, 0], points[i, 1])[0]
    return out


@njit(cache=True, error_model="numpy")
def _leg_gaps(obstacles, legs):  # type: ignore[no-untyped-def]
    out = np.empty(legs.shape[0])
    for i in range(legs.shape[0]):
        best = math.inf
        for k in range(int(obstacles[ob.N_CIRCLES] + obstacles[ob.N_SEGMENTS] + obstacles[ob.N_BOXES])):
            best = min(best, leg_to_obstacle(obstacles, k, legs[i, 0], legs[i, 1], legs[i, 2], legs[i, 3]))
        out[i] = best
    return out


@leaf
def penetration(obstacles, need, ax, ay, bx, by):  # type: ignore[no-untyped-def]
    """Sum over all obstacles of max(0, need - distance) [m] of the leg from a to b."""
    total = 0.0
    for k in range(int(obstacles[ob.N_CIRCLES] + obstacles[ob.N_SEGMENTS] + obstacles[ob.N_BOXES])):
        total += max(0.0, need - leg_to_obstacle(obstacles, k, ax, ay, bx, by))
    return total


@leaf
def leg_to_obstacle(obstacles, number, ax, ay, bx, by):  # type: ignore[no-untyped-def]
    """Signed distance [m] from the leg a to b to obstacle `number`, as `holodrive.obstacles` numbers them."""
    circles, segments = int(obstacles[ob.N_CIRCLES]), int(obstacles[ob.N_SEGMENTS])
    if number < circles:
        at = int(obstacles[ob.CIRCLES]) + ob.CIRCLE * number
        return _to_point(ax, ay, bx, by, obstacles[at], obstacles[at + 1]) - obstacles[at + 2]
    if number < circles + segments:
        at = int(obstacles[ob.EDGES]) + ob.EDGE * (number - circles)
        return _to_segment(
            ax, ay, bx, by, obstacles[at], obstacles[at + 1], obstacles[at + 2], obstacles[at + 3]
        )  # fmt: skip
    return _to_box(obstacles, int(obstacles[ob.BOXES]) + ob.BOX * (number - circles - segments), ax, ay, bx, by)


@leaf
def _to_point(ax, ay, bx, by, x, y):  # type: ignore[no-untyped-def]
    dx, dy = ob.from_segment(ax, ay, bx, by, x, y)
    return math.sqrt(dx * dx + dy * dy)


@leaf
def _to_segment(ax, ay, bx, by, cx, cy, dx, dy):  # type: ignore[no-untyped-def]
    """Distance between two segments, 0 when they cross."""
    ux, uy, vx, vy = bx - ax, by - ay, dx - cx, dy - cy
    c, d = ux * (cy - ay) - uy * (cx - ax), ux * (dy - ay) - uy * (dx - ax)
    a, b = vx * (ay - cy) - vy * (ax - cx), vx * (by - cy) - vy * (bx - cx)
    if a * b < 0.0 and c * d < 0.0:
        return 0.0
    return min(
        _to_point(ax, ay, bx, by, cx, cy),
        _to_point(ax, ay, bx, by, dx, dy),
        _to_point(cx, cy, dx, dy, ax, ay),
        _to_point(cx, cy, dx, dy, bx, by),
    )


@leaf
def _to_box(obstacles, at, ax, ay, bx, by):  # type: ignore[no-untyped-def]
    """Signed distance from a leg to a filled box: the deepest point's, where it goes through."""
    c, s, a, b = obstacles[at + 2], obstacles[at + 3], obstacles[at + 4], obstacles[at + 5]
    px, py, qx, qy = ax - obstacles[at], ay - obstacles[at + 1], bx - obstacles[at], by - obstacles[at + 1]
    u, v, du, dv = c * px + s * py, c * py - s * px, c * (qx - px) + s * (qy - py), c * (qy - py) - s * (qx - px)
    low, high = _inside_slab(u, du, a, 0.0, 1.0)
    low, high = _inside_slab(v, dv, b, low, high)
    if low > high:  # passes by: a corner or an end is nearest
        best = min(ob.from_box(obstacles, at, ax, ay)[0], ob.from_box(obstacles, at, bx, by)[0])
        for i in range(4):
            x, y = (a if i % 2 else -a), (b if i >= 2 else -b)
            best = min(best, _to_point(u, v, u + du, v + dv, x, y))
        return best
    # inside, the depth min(a - |u|, b - |v|) is concave and piecewise linear along the leg: its greatest value lies
    # at an end or where two of the four planes meet
    depth = max(_depth(u, v, du, dv, a, b, low), _depth(u, v, du, dv, a, b, high))
    for i in range(6):
        top, slope = 0.0, 0.0
        if i == 0:
            top, slope = -u, du
        elif i == 1:
            top, slope = -v, dv
        else:
            f, g = (1.0 if i % 2 else -1.0), (1.0 if i >= 4 else -1.0)
            top, slope = (a - b) - (f * u - g * v), f * du - g * dv
        if slope != 0.0:
            depth = max(depth, _depth(u, v, du, dv, a, b, min(max(top / slope, low), high)))
    return -depth


@leaf
def _depth(u, v, du, dv, a, b, t):  # type: ignore[no-untyped-def]
    return min(a - abs(u + t * du), b - abs(v + t * dv))


@leaf
def _inside_slab(u, du, half, low, high):  # type: ignore[no-untyped-def]
    """The part of [low, high] in which |u + t du| <= half; empty when low > high."""
    if du == 0.0:
        return (low, high) if abs(u) <= half else (1.0, 0.0)
    first, last = (-half - u) / du, (half - u) / du
    return max(low, min(first, last)), min(high, max(first, last))
