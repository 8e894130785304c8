"""What moves: round things in one scan found again in the next, their velocities estimated in the odometry frame.

A run of neighbouring points that ends on both sides in front of something farther is taken for a disc between its
two tangents. Discs become tracks by their nearest predicted place; place and velocity follow by the filter of
expanding memory (least squares over the scans seen), which forgets after `MEMORY` scans.
"""

import math

from holodrive.leaf import leaf

TRACKS = 12  # at most
# one row a track: scans it was seen in (0 = free), x, y [m], vx, vy [m/s], radius [m], time [s], moves (0 or 1), when
# it comes to something that stands and may turn back [s]
SEEN, X, Y, VX, VY, RADIUS, TIME, MOVES, BACK, ROW = range(10)
MEMORY = 7  # scans
SURPRISE_M, SURPRISE = 0.03, 0.03  # m, share of range: farther from its place than noise explains
GATE_M = 0.20  # farther from its predicted place it is something else
WIDEST_M = 0.40  # radius above which something is a wall
FARTHEST_M = 2.5  # from the sensor; noise and the beams' distance grow with range
FEWEST = 4  # points
STANDING_M_S = 0.05  # an estimate below this stands; of young tracks, one below more
FASTEST_M_S = 0.6  # an estimate above this is a mistake
YOUNG, YOUNG_EDGE = 1.2, 0.4  # [1/s] times range, over the square of the scans seen; of discs, of leading edges
LOST_S = 0.5  # unseen for longer, a track ends
BELIEVED = 3.0  # scans after which a motion counts
SURE, SURELY = 6.0, 2.0  # scans after which a motion is sure, and how `MOVES` says so
SAME_M, SAME = 0.025, 0.15  # m, share of radius: a disc of another size is another thing
LOST_MOVING_S = 3.0  # a mover may be hidden by something, or beside it
AGAIN_S = 0.05  # what comes sooner is another piece of the same scan
ITS_OWN_M = 0.08  # points this far outside a mover's disc still are its own
_PARTED_M, _PARTED = 0.06, 0.067  # m, share of range (1 deg from beam to beam on a surface 15 deg flat): a new thing


@leaf
def follow(xs, ys, ts, count, sx, sy, tracks):  # type: ignore[no-untyped-def]
    """Bring tracks (TRACKS * ROW,) up to a new scan.

    Args:
        xs, ys, ts, count: points in the order of the beams and their times [m, s], odometry frame.
        sx, sy: where the sensor is [m].
        tracks: see `SEEN` to `BACK`; zeros at the beginning.
    """
    first = -1
    for i in range(count):
        if parted(xs, ys, i - 1 if i > 0 else count - 1, i, sx, sy):
            first = i
            break
    if first >= 0:
        begin = first
        for k in range(1, count + 1):
            last, i = (first + k - 1) % count, (first + k) % count
            if k == count or parted(xs, ys, last, i, sx, sy):
                size = (last - begin) % count + 1
                offer(xs, ys, ts, count, begin, size, sx, sy, tracks)
                begin = i


@leaf
def forget(stamp, lasting, tracks):  # type: ignore[no-untyped-def]
    """End the tracks of what was not seen for long [s]; discs that surely move may be hidden for `lasting`."""
    for at in range(0, tracks.shape[0], ROW):
        limit = lasting if tracks[at + MOVES] == SURELY else min(lasting, LOST_S)
        if stamp - tracks[at + TIME] > limit:
            tracks[at + SEEN] = tracks[at + MOVES] = 0.0


@leaf
def parted(xs, ys, i, j, sx, sy):  # type: ignore[no-untyped-def]
    """Whether two neighbouring points belong to different things."""
    allowed = _PARTED_M + _PARTED * math.sqrt((xs[i] - sx) ** 2 + (ys[i] - sy) ** 2)
    return (xs[i] - xs[j]) ** 2 + (ys[i] - ys[j]) ** 2 > allowed * allowed


@leaf
def offer(xs, ys, ts, count, begin, size, sx, sy, tracks):  # type: ignore[no-untyped-def]
    """Take a run of points for a disc if it looks like one, and give it to a track."""
    if size < FEWEST:
        return
    end = (begin + size - 1) % count
    before, after = (begin - 1) % count, (end + 1) % count
    if beyond(xs, ys, begin, sx, sy) > beyond(xs, ys, before, sx, sy):
        return  # its edge is hidden by something nearer
    if beyond(xs, ys, end, sx, sy) > beyond(xs, ys, after, sx, sy):
        return
    mx, my = 0.5 * (xs[begin] + xs[end]) - sx, 0.5 * (ys[begin] + ys[end]) - sy
    m, half = math.hypot(mx, my), 0.5 * math.hypot(xs[begin] - xs[end], ys[begin] - ys[end])
    if m <= half or m > FARTHEST_M:
        return
    # both ends are tangent points: sin(angle) = r / d, and the middle of the chord lies at d cos^2(angle)
    distance, radius = m + half * half / m, half * math.hypot(m, half) / m
    if radius <= WIDEST_M:
        share = distance / m
        assign(sx + share * mx, sy + share * my, radius, 0.5 * (ts[begin] + ts[end]), m, BELIEVED, tracks)


@leaf
def beyond(xs, ys, i, sx, sy):  # type: ignore[no-untyped-def]
    """Squared distance of point i from the sensor [m^2]."""
    return (xs[i] - sx) ** 2 + (ys[i] - sy) ** 2


@leaf
def assign(x, y, radius, time, away, enough, tracks):  # type: ignore[no-untyped-def]
    """Give a disc to the track that expects it there, or begin a track."""
    best, chosen, free = GATE_M * GATE_M, -1, -1
    for at in range(0, tracks.shape[0], ROW):
        if tracks[at + SEEN] == 0.0:
            free = at
        else:
            dt = time - tracks[at + TIME]
            ex, ey = x - tracks[at + X] - dt * tracks[at + VX], y - tracks[at + Y] - dt * tracks[at + VY]
            alike = abs(radius - tracks[at + RADIUS]) < SAME_M + SAME * tracks[at + RADIUS]
            if alike and dt > AGAIN_S and ex * ex + ey * ey < best:
                best, chosen = ex * ex + ey * ey, at
    if chosen >= 0:
        improve(x, y, radius, time, away, enough, tracks[chosen : chosen + ROW])
    elif free >= 0:
        tracks[free + SEEN], tracks[free + X], tracks[free + Y] = 1.0, x, y
        tracks[free + VX], tracks[free + VY], tracks[free + RADIUS] = 0.0, 0.0, radius
        tracks[free + TIME], tracks[free + MOVES], tracks[free + BACK] = time, 0.0, math.inf


@leaf
def improve(x, y, radius, time, away, enough, track):  # type: ignore[no-untyped-def]
    """One step of the expanding-memory filter (alpha-beta gains of a least-squares line through n places)."""
    dt = time - track[TIME]
    ex, ey = x - track[X] - dt * track[VX], y - track[Y] - dt * track[VY]
    if track[SEEN] > 2.0 and math.hypot(ex, ey) > SURPRISE_M + SURPRISE * away:
        track[SEEN] = 1.0  # it has turned: what was before does not count any more
    n = min(track[SEEN] + 1.0, float(MEMORY))
    alpha, beta = 2.0 * (2.0 * n - 1.0) / (n * (n + 1.0)), 6.0 / (n * (n + 1.0))
    track[X] += dt * track[VX] + alpha * ex
    track[Y] += dt * track[VY] + alpha * ey
    track[VX] += beta * ex / dt
    track[VY] += beta * ey / dt
    # slowly: a disc that seems to grow is one thing that comes out from beside another
    track[RADIUS] += (radius - track[RADIUS]) / (track[SEEN] + 1.0)
    track[TIME] = time
    track[SEEN] += 1.0
    # what surely moved and has turned is believed at once, what is new after some scans
    surely = track[MOVES] == SURELY
    known = n >= enough or surely
    young = (YOUNG if enough >= BELIEVED else YOUNG_EDGE) * away / (n * n)
    slowest = STANDING_M_S + (young if n >= enough else 0.0)
    track[MOVES] = 0.0
    if known and slowest < math.hypot(track[VX], track[VY]) < FASTEST_M_S:
        track[MOVES] = SURELY if surely or n >= SURE else 1.0


@leaf
def is_moving(tracks, at):  # type: ignore[no-untyped-def]
    """Whether the row at `at` is a track that moves."""
    return tracks[at + SEEN] > 0.0 and tracks[at + MOVES] != 0.0


@leaf
def any_moving(tracks):  # type: ignore[no-untyped-def]
    """Whether anything moves."""
    count = 0
    for at in range(0, tracks.shape[0], ROW):
        count += 1 if is_moving(tracks, at) else 0
    return count > 0


@leaf
def mover_of(x, y, time, least, tracks):  # type: ignore[no-untyped-def]
    """Place in `tracks` of the track with `MOVES` >= least that a point seen at `time` belongs to; -1 for none."""
    for at in range(0, tracks.shape[0], ROW):
        if is_moving(tracks, at) and tracks[at + MOVES] >= least:
            dt = time - tracks[at + TIME]
            ex, ey = x - tracks[at + X] - dt * tracks[at + VX], y - tracks[at + Y] - dt * tracks[at + VY]
            if ex * ex + ey * ey < (tracks[at + RADIUS] + ITS_OWN_M) ** 2:
                return at
    return -1


@leaf
def expect_back(xs, ys, count, tracks):  # type: ignore[no-untyped-def]
    """Write when each moving track comes to points that stand: there it may turn back."""
    for at in range(0, tracks.shape[0], ROW):
        if is_moving(tracks, at):
            speed, reach = math.hypot(tracks[at + VX], tracks[at + VY]), 0.5 * tracks[at + RADIUS]
            ux, uy = tracks[at + VX] / speed, tracks[at + VY] / speed
            way = math.inf
            for i in range(count):
                dx, dy = xs[i] - tracks[at + X], ys[i] - tracks[at + Y]
                along, across = ux * dx + uy * dy, ux * dy - uy * dx
                # not its own points, and what it may brush past is no end of its way
                if along > tracks[at + RADIUS] + ITS_OWN_M and abs(across) < reach:
                    way = min(way, along - tracks[at + RADIUS])
            tracks[at + BACK] = tracks[at + TIME] + way / speed
