"""A barrier between the robot and all that its lidar sees: how fast it may come nearer to each point.

With h = distance - radius - margin the velocity v must keep h' >= -gain h, for each point v . n <= gain h with n the
direction to the point: a control barrier function (Ames et al. 2017) for a robot that can go anywhere. Each point
gives a half plane of velocities, three numbers nx, ny, b: v . n <= b. The velocity taken is the nearest one inside.
"""

import math

from holodrive.leaf import leaf

_TOUCH = 1e-9  # m/s
_PARALLEL = 1e-9
_RUNAWAY_M_S = 1.0  # beyond the wanted speed: where half planes almost exclude each other their corner lies far off


@leaf
def point_limits(xs, ys, vxs, vys, count, late, x, y, radius, gain, fastest, limits):  # type: ignore[no-untyped-def]
    """Write the half planes of points near enough to matter; gives how many.

    Args:
        xs, ys, vxs, vys, count: points and their velocities [m, m/s], seen `late` s ago.
        x, y: the robot's centre [m].
        radius: of the robot and the margin about it [m].
        gain: [1/s].
        fastest: no velocity above this will be asked for [m/s].
        limits: (3 * count,) is written.
    """
    reach = radius + fastest / gain
    found = 0
    for i in range(count):
        dx, dy, ux, uy = xs[i] - x, ys[i] - y, vxs[i], vys[i]
        square = dx * dx + dy * dy
        moves = ux != 0.0 or uy != 0.0
        if moves:
            # where it is by now, if that is nearer: what seems to go away may yet stand
            mx, my = dx + late * ux, dy + late * uy
            if mx * mx + my * my < square:
                dx, dy, square = mx, my, mx * mx + my * my
        if square < reach * reach:
            d = max(math.sqrt(square), 1e-9)
            b = gain * (d - radius)
            # being pushed back by what moves is the work of `foresight`, which sees where to
            limits[found], limits[found + 1], limits[found + 2] = dx / d, dy / d, max(b, 0.0) if moves else b
            found += 3
    return found // 3


@leaf
def nearest_allowed(vx, vy, limits, count):  # type: ignore[no-untyped-def]
    """Velocity (2) nearest to (vx, vy) inside all half planes, exactly; rest where there is none, or none near.

    Incremental (Seidel 1991): a half plane that the best velocity so far breaks has the new best one on its line.
    """
    x, y = vx, vy
    for i in range(count):
        nx, ny, b = limits[3 * i], limits[3 * i + 1], limits[3 * i + 2]
        if nx * x + ny * y <= b + _TOUCH:
            continue
        # p + t d runs along the line; the half planes before cut it
        over = nx * vx + ny * vy - b
        px, py, dx, dy = vx - over * nx, vy - over * ny, -ny, nx
        low, high = -math.inf, math.inf
        for j in range(i):
            slope = limits[3 * j] * dx + limits[3 * j + 1] * dy
            rest = limits[3 * j + 2] - limits[3 * j] * px - limits[3 * j + 1] * py
            if slope > _PARALLEL:
                high = min(high, rest / slope)
            elif slope < -_PARALLEL:
                low = max(low, rest / slope)
            elif rest < -_TOUCH:
                return 0.0, 0.0
        if low > high:
            return 0.0, 0.0
        t = min(max(0.0, low), high)
        x, y = px + t * dx, py + t * dy
    if math.hypot(x, y) > math.hypot(vx, vy) + _RUNAWAY_M_S:
        return 0.0, 0.0
    return x, y


@leaf
def hold_back_ahead(v, c, s, limits, count):  # type: ignore[no-untyped-def]
    """Speed ahead [m/s] nearest to v of a robot that only goes ahead and back (heading c, s); 0 where none is left."""
    low, high = -math.inf, math.inf
    for i in range(count):
        ahead, b = c * limits[3 * i] + s * limits[3 * i + 1], limits[3 * i + 2]
        if ahead > 1e-6:
            high = min(high, b / ahead)
        elif ahead < -1e-6:
            low = max(low, b / ahead)
    return min(max(v, low), high) if low <= high else 0.0
