"""Is the way to the goal free? A straight corridor of the robot's width, asked of the points that a lidar has left."""

import math

from holodrive.leaf import leaf

BEHIND_M = 0.02  # points this far behind the robot's centre still count, for its own flanks


@leaf
def free_length(xs, ys, count, x, y, ux, uy, half_width):  # type: ignore[no-untyped-def]
    """Distance along a ray [m] to the first point that lies in the corridor about it; infinite when there is none.

    Args:
        xs, ys, count: points [m].
        x, y, ux, uy: start of the ray and its direction, a unit vector, in the points' frame.
        half_width: of the corridor [m].
    """
    best = math.inf
    for i in range(count):
        dx, dy = xs[i] - x, ys[i] - y
        along, across = ux * dx + uy * dy, ux * dy - uy * dx
        inside = (abs(across) < half_width) & (along > -BEHIND_M) & (along < best)
        best = along if inside else best
    return best


@leaf
def freedom(length, look, blocked, free):  # type: ignore[no-untyped-def]
    """Degree 0..1 to which the fuzzy set "the way is free" holds.

    1 where nothing lies within `look`; else a ramp from 0 at `blocked` to 1 at `free` [m].
    """
    if length >= look:
        return 1.0
    return min(1.0, max(0.0, (length - blocked) / (free - blocked)))
