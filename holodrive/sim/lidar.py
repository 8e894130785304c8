"""Ray casting of a planar range sensor against circles, segments, boxes and movers.

A scan turns every obstacle into the sensor's frame once and then only visits the beams inside the angle that the
obstacle covers (`cast`, the interval method). `cast_beam` asks every obstacle for one beam: the plain method, used
beam by beam while the robot moves, and the test's oracle. Inside a filled obstacle the distance is 0.
"""

import math

import numpy as np

from holodrive import obstacles as ob
from holodrive.leaf import leaf, set_all
from holodrive.sim import model as md
from holodrive.sim.streams import DROPOUT, LIDAR, draw, draw_index, gauss, uniform


@leaf
def cast(ranges, model, obstacles, time, x, y, theta):  # type: ignore[no-untyped-def]
    """True distances (b,) [m] of a whole scan taken at once from a base at (x, y, theta); infinite = nothing there."""
    ox, oy, c, s = sensor(model, x, y, theta)
    beams, at = ranges.shape[0], int(model[md.BEAMS_AT])
    cos, sin = model[at : at + beams], model[at + beams : at + 2 * beams]
    # rad; beams per rad, per turn; turns per beam
    first, per, turn = model[md.FIRST_BEAM], 1.0 / model[md.BEAM_STEP], 2.0 * math.pi / abs(model[md.BEAM_STEP])
    share = 1.0 / turn
    for i in range(beams):
        ranges[i] = math.inf
    at = int(obstacles[ob.CIRCLES])
    for _ in range(int(obstacles[ob.N_CIRCLES])):
        dx, dy = obstacles[at] - ox, obstacles[at + 1] - oy
        circle_over(ranges, cos, sin, first, per, turn, share, c * dx + s * dy, c * dy - s * dx, obstacles[at + 2])
        at += ob.CIRCLE
    at = int(obstacles[ob.MOVERS])
    for _ in range(int(obstacles[ob.N_MOVERS])):
        mx, my, _, _ = ob.mover_at(obstacles, at, time)
        dx, dy = mx - ox, my - oy
        circle_over(ranges, cos, sin, first, per, turn, share, c * dx + s * dy, c * dy - s * dx, obstacles[at])
        at += ob.MOVER
    at = int(obstacles[ob.EDGES])
    for _ in range(int(obstacles[ob.N_EDGES])):
        px, py = obstacles[at] - ox, obstacles[at + 1] - oy
        ex, ey = obstacles[at + 2] - obstacles[at], obstacles[at + 3] - obstacles[at + 1]
        px, py, ex, ey = c * px + s * py, c * py - s * px, c * ex + s * ey, c * ey - s * ex
        segment_over(ranges, cos, sin, first, per, turn, share, px, py, ex, ey)
        at += ob.EDGE
    at = int(obstacles[ob.BOXES])
    for _ in range(int(obstacles[ob.N_BOXES])):
        if ob.from_box(obstacles, at, ox, oy)[0] < 0.0:
            set_all(ranges, 0.0)
        at += ob.BOX


@leaf
def cast_beam(beam, model, obstacles, time, x, y, theta):  # type: ignore[no-untyped-def]
    """True distance [m] of one beam from a base at (x, y, theta): every obstacle is asked."""
    ox, oy, c, s = sensor(model, x, y, theta)
    at = int(model[md.BEAMS_AT]) + beam
    cos, sin = model[at], model[at + int(model[md.BEAMS])]
    bx, by = c * cos - s * sin, s * cos + c * sin
    best, at = math.inf, int(obstacles[ob.CIRCLES])
    for _ in range(int(obstacles[ob.N_CIRCLES])):
        best = min(best, to_circle(bx, by, obstacles[at] - ox, obstacles[at + 1] - oy, obstacles[at + 2]))
        at += ob.CIRCLE
    at = int(obstacles[ob.MOVERS])
    for _ in range(int(obstacles[ob.N_MOVERS])):
        mx, my, _, _ = ob.mover_at(obstacles, at, time)
        best = min(best, to_circle(bx, by, mx - ox, my - oy, obstacles[at]))
        at += ob.MOVER
    at = int(obstacles[ob.EDGES])
    for _ in range(int(obstacles[ob.N_EDGES])):
        ex, ey = obstacles[at + 2] - obstacles[at], obstacles[at + 3] - obstacles[at + 1]
        best = min(best, to_segment(bx, by, obstacles[at] - ox, obstacles[at + 1] - oy, ex, ey))
        at += ob.EDGE
    at = int(obstacles[ob.BOXES])
    for _ in range(int(obstacles[ob.N_BOXES])):
        if ob.from_box(obstacles, at, ox, oy)[0] < 0.0:
            best = 0.0
        at += ob.BOX
    return best


@leaf
def sensor(model, x, y, theta):  # type: ignore[no-untyped-def]
    """Place (2) [m] and direction (cosine, sine) of the sensor on a base at (x, y, theta)."""
    c, s = math.cos(theta), math.sin(theta)
    ox, oy = x + c * model[md.LIDAR_X] - s * model[md.LIDAR_Y], y + s * model[md.LIDAR_X] + c * model[md.LIDAR_Y]
    if model[md.LIDAR_THETA] != 0.0:
        c, s = math.cos(theta + model[md.LIDAR_THETA]), math.sin(theta + model[md.LIDAR_THETA])
    return ox, oy, c, s


@leaf
def to_circle(bx, by, cx, cy, radius):  # type: ignore[no-untyped-def]
    """Distance along the unit vector b to a filled circle about c; 0 inside, infinite when it is missed."""
    outside = cx * cx + cy * cy - radius * radius
    along = cx * bx + cy * by
    under = along * along - outside
    if outside <= 0.0:
        return 0.0
    return along - math.sqrt(under) if along > 0.0 and under >= 0.0 else math.inf


@leaf
def to_segment(bx, by, px, py, ex, ey):  # type: ignore[no-untyped-def]
    """Distance along the unit vector b to the segment p .. p + e; infinite when it is missed or parallel."""
    turn = bx * ey - by * ex
    share, distance = (px * by - py * bx) / turn, (px * ey - py * ex) / turn
    return distance if turn != 0.0 and distance >= 0.0 and 0.0 <= share <= 1.0 else math.inf


@leaf
def circle_over(ranges, cos, sin, first, per, turn, share, cx, cy, radius):  # type: ignore[no-untyped-def]
    """Lower the ranges of the beams that a circle covers; (cx, cy) in the sensor's frame."""
    outside = cx * cx + cy * cy - radius * radius
    if outside <= 0.0:
        set_all(ranges, 0.0)
        return
    # the tangents' half angle, asin(r / d) = atan(r / tangent length)
    half = rough_angle(math.sqrt(outside), radius)
    middle = rough_angle(cx, cy)
    low, high, before, after = beam_span(first, per, turn, share, middle - half, middle + half)
    for k in range(before, after):
        a, b = beams_of(low + k * turn, high + k * turn, ranges.shape[0])
        for i in range(a, b):
            along = cx * cos[i] + cy * sin[i]
            under = along * along - outside
            hit = along - math.sqrt(max(under, 0.0))
            old = ranges[i]
            ranges[i] = hit if (under >= 0.0) & (along > 0.0) & (hit < old) else old


@leaf
def segment_over(ranges, cos, sin, first, per, turn, share, px, py, ex, ey):  # type: ignore[no-untyped-def]
    """Lower the ranges of the beams that a segment p .. p + e covers, in the sensor's frame."""
    qx, qy = px + ex, py + ey
    start = rough_angle(px, py)
    # signed angle from p to q, the short way round
    swing = rough_angle(px * qx + py * qy, px * qy - py * qx)
    low, high, before, after = beam_span(first, per, turn, share, start + min(swing, 0.0), start + max(swing, 0.0))
    area = px * ey - py * ex
    for k in range(before, after):
        a, b = beams_of(low + k * turn, high + k * turn, ranges.shape[0])
        for i in range(a, b):
            bx, by = cos[i], sin[i]
            over = 1.0 / (bx * ey - by * ex)
            where, hit = (px * by - py * bx) * over, area * over
            old = ranges[i]
            ranges[i] = hit if (hit >= 0.0) & (where >= 0.0) & (where <= 1.0) & (hit < old) else old


@leaf
def beam_span(first, per, turn, share, low, high):  # type: ignore[no-untyped-def]
    """Angles [rad] as beam numbers (real), low <= high, low within one turn from 0.

    The last two say by how many turns the span must be shifted to meet all its beams: range(before, after).
    """
    if per < 0.0:
        low, high = high, low
    low, high = (low - first) * per, (high - first) * per
    shift = turn * np.floor(low * share)
    low, high = low - shift, high - shift
    return low, high, -1 if high > turn - 3.0 else 0, 2 if low < 3.0 else 1


@leaf
def beams_of(low, high, count):  # type: ignore[no-untyped-def]
    """Range [a, b) of beams between two beam numbers, one more at each end for what rounding may have lost."""
    a, b = max(0.0, math.floor(low) - 1.0), min(float(count), math.ceil(high) + 2.0)
    if a >= b:
        return np.uint64(0), np.uint64(0)
    # whole vectors: what they visit beyond the span they miss, and single beams at the end cost more
    first, size = int(a), min(count, (int(b) - int(a) + 3) // 4 * 4)
    first = min(first, count - size)
    # unsigned: Numba need not ask whether an index counts from the end, and the loops become vector code
    return np.uint64(first), np.uint64(first + size)


@leaf
def rough_angle(x, y):  # type: ignore[no-untyped-def]
    """atan2(y, x) [rad] to 2e-5 rad: it only chooses beams, whose own distances are exact."""
    ax, ay = abs(x), abs(y)
    big, small = max(ax, ay), min(ax, ay)
    a = small / big if big > 0.0 else 0.0
    q = a * a
    # minimax polynomial of atan on [0, 1], after Hastings
    angle = a * (
        0.99997726 + q * (-0.33262347 + q * (0.19354346 + q * (-0.11643287 + q * (0.05265332 - q * 0.01172120))))
    )
    if ay > ax:
        angle = 0.5 * math.pi - angle
    if x < 0.0:
        angle = math.pi - angle
    return -angle if y < 0.0 else angle


@leaf
def read(ranges, model, key, scan):  # type: ignore[no-untyped-def]
    """What the sensor tells of true distances (b,), in place: noise, dropouts, limits of range.

    Infinite = no return (too far or dropped), NaN = too near to be measured.
    """
    bits, drops = draw(key, LIDAR, scan), draw(key, DROPOUT, scan)
    low, high, dropout = model[md.RANGE_MIN], model[md.RANGE_MAX], model[md.DROPOUT]
    noise, relative = model[md.RANGE_NOISE], model[md.RANGE_NOISE_RELATIVE]
    if noise > 0.0 or relative > 0.0:
        for i in range(ranges.shape[0]):
            d = ranges[i]
            # beyond the range there is nothing to disturb, and infinity times noise would be NaN
            d = d if d > high else d + max(noise, relative * d) * gauss(draw_index(bits, np.uint64(i)))
            ranges[i] = math.nan if d < low else (math.inf if d > high else d)
    else:
        for i in range(ranges.shape[0]):
            d = ranges[i]
            ranges[i] = math.nan if d < low else (math.inf if d > high else d)
    if dropout > 0.0:
        for i in range(ranges.shape[0]):
            if uniform(draw_index(drops, np.uint64(i))) < dropout:
                ranges[i] = math.inf


@leaf
def read_beam(distance, model, key, scan, beam):  # type: ignore[no-untyped-def]
    """What the sensor tells of one beam's true distance; the same numbers as `read`."""
    low, high, index, d = model[md.RANGE_MIN], model[md.RANGE_MAX], np.uint64(beam), distance
    noise, relative = model[md.RANGE_NOISE], model[md.RANGE_NOISE_RELATIVE]
    if (noise > 0.0 or relative > 0.0) and d <= high:
        d += max(noise, relative * d) * gauss(draw_index(draw(key, LIDAR, scan), index))
    d = math.nan if d < low else (math.inf if d > high else d)
    if model[md.DROPOUT] > 0.0 and uniform(draw_index(draw(key, DROPOUT, scan), index)) < model[md.DROPOUT]:
        d = math.inf
    return d
