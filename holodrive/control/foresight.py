"""Looking ahead among things that move: a few simple motions are played out against their predicted paths.

A motion is to go one way for a while and then to stand. Movers are discs that go on as they do (and, where they come
to something that stands, turn back or go on). Of the motions that stay clear for the whole horizon the one nearest to
the wanted velocity is taken; if there is none, the one that stays clear longest.
"""

import math

from holodrive.leaf import leaf

WAYS = 16  # directions of a robot that can go anywhere
LASTING = 3  # how long to go on: a quarter of the horizon, a half, all of it
STEP_S = 0.2  # between two looks at the future
MOVER = 6  # a row: x, y, vx, vy, radius, time until it may turn back [s]
TOUCH_M = 0.02  # nearer than this is a touch
STOP_S = 0.8  # a touch that is nearer than this is met standing
SHORTEST_S = 0.3  # what stops sooner is no motion
LATER_S = 0.4
_UNTOUCHED, _ROOM = 10.0, 10.0
_KEEP = 0.15  # what changing one's mind must win, in shares of cruising speed
_WAIT = 0.1  # what standing costs less than going somewhere else


@leaf
def play(px, py, vx, vy, go_s, movers, count, radius, margin, horizon):  # type: ignore[no-untyped-def]
    """Play a motion out: when [s] it comes nearer to a mover than `margin`, and than `TOUCH_M`; its least gap [m].

    The times are `horizon` if never. The gap counts from `LATER_S` on: what is near now may be on its way out.

    Args:
        px, py: start [m].
        vx, vy: velocity [m/s] for `go_s`; afterwards it stands.
        movers, count: rows of `MOVER` numbers.
        radius: of the robot [m].
    """
    near, touch, least = horizon, horizon, math.inf
    for i in range(int(horizon / STEP_S) + 1):
        t = i * STEP_S
        gone = min(t, go_s)
        x, y = px + gone * vx, py + gone * vy
        gap = math.inf
        for k in range(0, MOVER * count, MOVER):
            mx, my = movers[k] + t * movers[k + 2] - x, movers[k + 1] + t * movers[k + 3] - y
            way = math.hypot(mx, my)
            # turned back where it may; the nearer of both futures counts
            back = max(0.0, t - movers[k + 5])
            if back > 0.0:
                way = min(way, math.hypot(mx - 2.0 * back * movers[k + 2], my - 2.0 * back * movers[k + 3]))
            gap = min(gap, way - radius - movers[k + 4])
        near = t if gap < margin and t < near else near
        touch = t if gap < TOUCH_M and t < touch else touch
        least = gap if t >= LATER_S and gap < least else least
    return near, touch, least


@leaf
def free_way(xs, ys, count, x, y, ux, uy, radius):  # type: ignore[no-untyped-def]
    """How far [m] a disc gets from (x, y) along the unit vector u before it touches a point."""
    best = math.inf
    square = radius * radius
    for i in range(count):
        dx, dy = xs[i] - x, ys[i] - y
        along, across = ux * dx + uy * dy, ux * dy - uy * dx
        if along > 0.0 and across * across < square:
            best = min(best, along - math.sqrt(square - across * across))
    return max(0.0, best)


@leaf
def evade(  # type: ignore[no-untyped-def]
    vx, vy, x, y, xs, ys, points, movers, count, radius, margin, gap, horizon, speed, angle, ways, chosen
):
    """Choose the velocity (2) [m/s] that keeps clear of what moves.

    Args:
        vx, vy: wanted [m/s].
        x, y: the robot's centre [m].
        xs, ys, points: what stands [m].
        movers, count: see `play`.
        radius: of the robot; margin: to what moves; gap: to what stands [m].
        horizon: [s].
        speed: of evasive motions [m/s].
        angle, ways: first of their directions [rad], and how many spread over a turn.
        chosen: (2,) velocity that was chosen before [m/s]; the new one is written.
    """
    wanted = max(math.hypot(vx, vy), 1e-9)
    length = free_way(xs, ys, points, x, y, vx / wanted, vy / wanted, radius + gap)
    near, _, _ = play(x, y, vx, vy, length / wanted, movers, count, radius, margin, horizon)
    if near >= horizon:
        chosen[0], chosen[1] = vx, vy
        return
    best, soonest, last_x, last_y = math.inf, 0.0, chosen[0], chosen[1]
    for way in range(-1, ways):
        ux = uy = length = 0.0  # way -1 is to stand
        if way >= 0:
            ux, uy = math.cos(angle + 2.0 * math.pi * way / ways), math.sin(angle + 2.0 * math.pi * way / ways)
            length = free_way(xs, ys, points, x, y, ux, uy, radius + gap)
        for part in range(LASTING if way >= 0 else 1):
            go_s = min(length / speed, horizon * 2.0**part / 4.0)
            near, touch, least = play(x, y, speed * ux, speed * uy, go_s, movers, count, radius, margin, horizon)
            cx, cy = (speed * ux, speed * uy) if go_s > SHORTEST_S else (0.0, 0.0)
            cost = math.hypot(cx - vx, cy - vy) / speed - (_WAIT if way < 0 else 0.0)
            if math.hypot(cx - last_x, cy - last_y) < 0.1 * speed:
                cost -= _KEEP
            if near < horizon:  # not to touch comes before room, and room before what is wanted
                cost += _UNTOUCHED * (1.0 + horizon - touch) + _ROOM * max(0.0, margin - least) / margin
            if cost < best:
                best, soonest = cost, touch
                chosen[0], chosen[1] = cx, cy
    if soonest < STOP_S:
        chosen[0] = chosen[1] = 0.0
