"""Is the way to the goal free? A straight corridor of the robot's width, asked of the points that a lidar has left."""

import math

from holodrive.leaf import leaf

WAYS = 24  # directions tried for a via point
LEG_M, LEGS = 0.3, 5  # lengths tried: multiples of this [m]
BLOCKED_COST = 3.0  # of a metre of the second leg that is not free
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


@leaf
def via_point(xs, ys, count, x, y, goal_x, goal_y, half_width, via):  # type: ignore[no-untyped-def]
    """Write the via point (2) [m] of the shortest way to a goal in two straight legs; gives the first one's length.

    The first leg is free; if no second one is, the way whose second leg is free for longest is taken. 0 where the
    robot cannot go anywhere.
    """
    best, chosen = math.inf, 0.0
    bearing = math.atan2(goal_y - y, goal_x - x)
    for k in range(WAYS):
        ux, uy = math.cos(bearing + 2.0 * math.pi * k / WAYS), math.sin(bearing + 2.0 * math.pi * k / WAYS)
        first = free_length(xs, ys, count, x, y, ux, uy, half_width) - half_width
        for part in range(1, LEGS + 1):
            leg = LEG_M * part
            if leg <= first:
                px, py = x + leg * ux, y + leg * uy
                rest = math.hypot(goal_x - px, goal_y - py)
                free = free_length(
                    xs, ys, count, px, py, (goal_x - px) / max(rest, 1e-9), (goal_y - py) / max(rest, 1e-9), half_width
                )
                cost = leg + rest + (BLOCKED_COST * (rest - free) if free < rest else 0.0)
                if cost < best:
                    best, chosen = cost, leg
                    via[0], via[1] = px, py
    return chosen
