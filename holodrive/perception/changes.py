"""What has come where nothing was: points in space that an earlier scan has seen through.

A thing that passes in front of another, or comes out from beside it, is no disc of its own for a while, and
`tracking.follow` cannot tell it apart. But its leading edge lies where an earlier beam went on. Such points, the
crescent of ground that it has won since then, keep their shape while it goes on, and their middle has its velocity.
"""

import math

from holodrive.leaf import leaf
from holodrive.perception import tracking as tr

SCANS = 5  # back to the scan that is compared with; a mover of 0.1 m/s wins 9 cm in that time
FEWEST = 3  # points
ALREADY_M, ALREADY = 0.06, 0.02  # m, share of range: nearer than this to what was there is there already
LOST_S = 0.3  # one scan without it, and it is another thing
AGAIN = 2.0  # scans after which such a thing is believed
HEAD = 2  # of one table: x, y of the place it was seen from; then ranges by direction


def memory_size(beams: int) -> int:
    """Numbers kept for scans of `beams`."""
    return SCANS * (HEAD + beams)


@leaf
def find(xs, ys, ts, count, sx, sy, scan, beams, tables, discs, tracks):  # type: ignore[no-untyped-def]
    """Find what has come since `SCANS` scans ago and track it.

    Args:
        xs, ys, ts, count: points in the order of the beams and their times [m, s], odometry frame.
        sx, sy: where the sensor is [m].
        scan: number of this scan from 0.
        beams: directions of a table.
        tables: (SCANS * (HEAD + beams),) earlier scans, oldest overwritten.
        discs: tracks of discs; what belongs to one that surely moves is known already.
        tracks: of what has come, as `tracking.follow` has them.
    """
    at = (scan % SCANS) * (HEAD + beams)
    table = tables[at : at + HEAD + beams]
    if scan >= SCANS:
        begin = -1
        for i in range(count):
            new = seen_through(xs[i], ys[i], beams, table) and tr.mover_of(xs[i], ys[i], ts[i], tr.SURELY, discs) < 0
            if begin >= 0 and (not new or tr.parted(xs, ys, i - 1, i, sx, sy)):
                offer(xs, ys, ts, count, begin, i - begin, sx, sy, tracks)
                begin = -1
            if new and begin < 0:
                begin = i
        if begin >= 0:
            offer(xs, ys, ts, count, begin, count - begin, sx, sy, tracks)
    table[0], table[1] = sx, sy
    for k in range(beams):
        table[HEAD + k] = 0.0  # not looked at: nothing is known to be free
    for i in range(count):
        dx, dy = xs[i] - sx, ys[i] - sy
        k = HEAD + direction(dx, dy, beams)
        r = math.hypot(dx, dy)
        table[k] = r if table[k] == 0.0 else min(table[k], r)


@leaf
def direction(dx, dy, beams):  # type: ignore[no-untyped-def]
    """Number of the direction (dx, dy), 0 .. beams - 1."""
    return int((math.atan2(dy, dx) / (2.0 * math.pi) + 0.5) * beams) % beams


@leaf
def seen_through(x, y, beams, table):  # type: ignore[no-untyped-def]
    """Whether all neighbouring beams of the earlier scan went on beyond this point."""
    dx, dy = x - table[0], y - table[1]
    k, r = direction(dx, dy, beams), math.hypot(dx, dy)
    least = math.inf
    for j in range(-1, 2):
        least = min(least, table[HEAD + (k + j) % beams])
    return least > r + ALREADY_M + ALREADY * r


@leaf
def offer(xs, ys, ts, count, begin, size, sx, sy, tracks):  # type: ignore[no-untyped-def]
    """Give a run of new points to a track, half its width as the radius.

    Its place is its middle; but while it comes out from beside something, it grows at one end only, and its place is
    the other end, which goes as fast as the thing does.
    """
    if size < FEWEST:
        return
    end = begin + size - 1
    x, y = 0.0, 0.0
    for i in range(begin, begin + size):
        x, y = x + xs[i] / size, y + ys[i] / size
    opens = is_open(xs, ys, begin, (begin - 1) % count, sx, sy)
    closes = is_open(xs, ys, end, (end + 1) % count, sx, sy)
    if opens != closes:
        tip = begin if opens else end
        x, y = xs[tip], ys[tip]
    away = math.hypot(x - sx, y - sy)
    radius = max(0.05, 0.5 * math.hypot(xs[end] - xs[begin], ys[end] - ys[begin]))
    if away <= tr.FARTHEST_M and radius <= tr.WIDEST_M:
        tr.assign(x, y, radius, 0.5 * (ts[begin] + ts[end]), away, AGAIN, tracks)


@leaf
def is_open(xs, ys, i, neighbour, sx, sy):  # type: ignore[no-untyped-def]
    """Whether a run ends at point i in front of something farther."""
    farther = tr.beyond(xs, ys, neighbour, sx, sy) > tr.beyond(xs, ys, i, sx, sy)
    return farther and tr.parted(xs, ys, i, neighbour, sx, sy)
