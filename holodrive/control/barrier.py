"""A barrier between the robot and all that its lidar sees: how fast it may come nearer to each point.

With h = distance - radius - margin the velocity v must keep h' >= -gain h, for each point v . n <= gain h, n the
direction to the point: a control barrier function (Ames et al. 2017) for a robot that can go anywhere. The nearest
velocity to the wanted one is approached by projection onto one half plane after the other.
"""

import math

from holodrive.leaf import leaf

SWEEPS = 3


@leaf
def hold_back(xs, ys, count, x, y, vx, vy, radius, gain, limits):  # type: ignore[no-untyped-def]
    """Velocity (2) [m/s] that keeps off all points, in the points' axes, near to the wanted (vx, vy).

    Args:
        xs, ys, count: points [m].
        x, y: the robot's centre.
        vx, vy: wanted [m/s].
        radius: of the robot and the margin about it [m].
        gain: [1/s]; at a distance h outside the margin it may near a point with gain h.
        limits: scratch (3 * count,).
    """
    reach = radius + math.hypot(vx, vy) / gain
    found = 0
    for i in range(count):
        dx, dy = xs[i] - x, ys[i] - y
        square = dx * dx + dy * dy
        if square < reach * reach and square > 0.0:
            d = math.sqrt(square)
            limits[found], limits[found + 1], limits[found + 2] = dx / d, dy / d, gain * (d - radius)
            found += 3
    for _ in range(SWEEPS):
        for k in range(0, found, 3):
            over = vx * limits[k] + vy * limits[k + 1] - limits[k + 2]
            if over > 0.0:
                vx, vy = vx - over * limits[k], vy - over * limits[k + 1]
    # what three sweeps have left in a narrow place is taken by going slower, where that helps
    share = 1.0
    for k in range(0, found, 3):
        nearing = vx * limits[k] + vy * limits[k + 1]
        if nearing > limits[k + 2]:
            share = min(share, max(0.0, limits[k + 2]) / nearing)
    return share * vx, share * vy


@leaf
def hold_back_ahead(xs, ys, count, x, y, c, s, v, radius, gain):  # type: ignore[no-untyped-def]
    """Speed ahead [m/s] of a robot that only goes ahead and back and keeps off all points, near to the wanted v.

    Args:
        xs, ys, count, x, y, radius, gain: as `hold_back`.
        c, s: cosine and sine of the heading.
        v: wanted [m/s].
    """
    low, high = -math.inf, math.inf
    for i in range(count):
        dx, dy = xs[i] - x, ys[i] - y
        d = math.hypot(dx, dy)
        if d > 0.0:
            ahead, bound = (c * dx + s * dy) / d, gain * (d - radius)
            if ahead > 1e-6:
                high = min(high, bound / ahead)
            elif ahead < -1e-6:
                low = max(low, bound / ahead)
    # between what is too near ahead and what is too near behind it stands
    return min(max(v, low), high) if low <= high else 0.0
