"""Obstacle points to half-planes: the convex room about a place, for a controller that can only keep linear limits.

The nearest point gives the first half-plane, square to the line to it; what lies behind that one needs no other. The
nearest of the rest gives the next, and so on (the greedy polyhedra of Liu et al. 2017, about a disc).
"""

import math

from holodrive.leaf import leaf

NO_PLANE = -math.inf  # distance of a half-plane that keeps nothing out


@leaf
def half_planes(xs, ys, count, places, x, y, radius, reach, taken, out):  # type: ignore[no-untyped-def]
    """Write half-planes (N, k, 3) n . (p - (x, y)) >= d that keep discs about the points out, one set for each place.

    Standing still at (x, y) keeps all of them, even where the robot is too near already: then it may not come nearer.

    Args:
        xs, ys, count: points [m].
        places: (N, >= 2) where the robot is expected, x and y first [m].
        x, y: where it is, the origin of the half-planes [m]; all in the axes of the points.
        radius: of the robot and the margin about it [m].
        reach: points farther than this from a place are left out [m].
        taken: (count,) scratch.
        out: (N, k, 3) normal and distance [-, -, m]; unused ones get `NO_PLANE`.
    """
    for k in range(out.shape[0]):
        px, py = places[k, 0], places[k, 1]
        for i in range(count):
            square = (xs[i] - px) ** 2 + (ys[i] - py) ** 2
            taken[i] = square if square < reach * reach else math.inf
        for j in range(out.shape[1]):
            nearest, least = -1, math.inf
            for i in range(count):
                if taken[i] < least:
                    nearest, least = i, taken[i]
            out[k, j, 0], out[k, j, 1], out[k, j, 2] = 0.0, 0.0, NO_PLANE
            if nearest < 0:
                continue
            qx, qy = xs[nearest], ys[nearest]
            nx, ny = px - qx, py - qy
            length = math.sqrt(least)
            if length < 1e-9:  # the place is on a point: away from it is where the robot is now
                nx, ny = x - qx, y - qy
                length = max(math.hypot(nx, ny), 1e-9)
            nx, ny = nx / length, ny / length
            now = nx * (x - qx) + ny * (y - qy)
            out[k, j, 0], out[k, j, 1], out[k, j, 2] = nx, ny, min(radius - now, 0.0)
            for i in range(count):
                if nx * (xs[i] - qx) + ny * (ys[i] - qy) <= 0.0:
                    taken[i] = math.inf
            taken[nearest] = math.inf
