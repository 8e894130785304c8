"""Ray casting of a planar range sensor against circles, segments, boxes and movers.

A scan turns every obstacle into the sensor's frame once and then only visits the beams inside the angle that the
obstacle covers (`cast`, the interval method). `cast_beam` asks every obstacle for one beam: the plain method, used
beam by beam while the robot moves, and the test's oracle. Inside a filled obstacle the distance is 0.
"""

import math
from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from holodrive.obstacles import mover_at
from holodrive.robots.spec import Lidar
from holodrive.sim.streams import DROPOUT, LIDAR, draw, draw_index, gauss, hash_of, uniform
from holodrive.types import Array


class LidarModel(NamedTuple):
    """A range sensor for kernels; `beams` 0 = none.

    Beam i looks along `first + i * step` [rad] in the sensor's frame (`cos`, `sin`), negative step for a clockwise
    sensor. A scan takes `period` seconds; beam i of a distorted scan is taken `(i + 1) * beam_period` after its
    start, an instantaneous scan has a `beam_period` of 0. `hashes` are of the beams' numbers.
    """

    beams: int
    x: float
    y: float
    theta: float
    period: float
    beam_period: float
    first: float
    step: float
    cos: Array
    sin: Array
    hashes: NDArray[np.uint64]
    range_min: float
    range_max: float
    noise: float
    noise_relative: float
    dropout: float


def lidar_model(lidar: Lidar | None) -> LidarModel:
    """The kernels' form of a described sensor."""
    if lidar is None:
        empty = np.zeros(0)
        return LidarModel(
            0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, empty, empty, np.zeros(0, np.uint64), 0.0, 0.0, 0.0, 0.0, 0.0
        )
    full = lidar.field_of_view_rad >= 2.0 * math.pi - 1e-9
    gaps = lidar.beams if full else max(1, lidar.beams - 1)
    turn = -1.0 if lidar.clockwise else 1.0
    first = 0.0 if full else -0.5 * turn * lidar.field_of_view_rad
    step = turn * min(lidar.field_of_view_rad, 2.0 * math.pi) / gaps
    # the mirror turns evenly, so that a narrow field of view is seen in a part of the revolution only
    beam_period = abs(step) / (2.0 * math.pi) / lidar.rate_hz if lidar.motion_distortion else 0.0
    angles = first + step * np.arange(lidar.beams)
    return LidarModel(
        beams=lidar.beams,
        x=lidar.mount.x,
        y=lidar.mount.y,
        theta=lidar.mount.theta,
        period=1.0 / lidar.rate_hz,
        beam_period=beam_period,
        first=first,
        step=step,
        cos=np.cos(angles),
        sin=np.sin(angles),
        hashes=np.array([hash_of(i) for i in range(lidar.beams)], dtype=np.uint64),
        range_min=lidar.range_min,
        range_max=lidar.range_max,
        noise=lidar.noise_m,
        noise_relative=lidar.noise_relative,
        dropout=lidar.dropout,
    )


@njit(cache=True, error_model="numpy")
def cast(ranges, lidar, obstacles, time, x, y, theta):  # type: ignore[no-untyped-def]
    """True distances (b,) [m] of a whole scan taken at once from a base at (x, y, theta); infinite = nothing there."""
    c, s = math.cos(theta), math.sin(theta)
    ox, oy = x + c * lidar.x - s * lidar.y, y + s * lidar.x + c * lidar.y
    c, s = math.cos(theta + lidar.theta), math.sin(theta + lidar.theta)
    for i in range(ranges.shape[0]):
        ranges[i] = math.inf
    circles, edges = obstacles.circles, obstacles.edges
    for k in range(circles.shape[0]):
        dx, dy = circles[k, 0] - ox, circles[k, 1] - oy
        circle_over(ranges, lidar, c * dx + s * dy, c * dy - s * dx, circles[k, 2])
    for k in range(obstacles.movers.shape[0]):
        mx, my, _, _ = mover_at(obstacles, k, time)
        dx, dy = mx - ox, my - oy
        circle_over(ranges, lidar, c * dx + s * dy, c * dy - s * dx, obstacles.movers[k, 0])
    for k in range(edges.shape[0]):
        px, py = edges[k, 0] - ox, edges[k, 1] - oy
        ex, ey = edges[k, 2] - edges[k, 0], edges[k, 3] - edges[k, 1]
        segment_over(ranges, lidar, c * px + s * py, c * py - s * px, c * ex + s * ey, c * ey - s * ex)
    for k in range(obstacles.boxes.shape[0]):
        if inside_box(obstacles.boxes[k], ox, oy):
            ranges[:] = 0.0


@njit(cache=True, error_model="numpy")
def cast_beam(lidar, obstacles, beam, time, x, y, theta):  # type: ignore[no-untyped-def]
    """True distance [m] of one beam from a base at (x, y, theta): every obstacle is asked."""
    c, s = math.cos(theta), math.sin(theta)
    ox, oy = x + c * lidar.x - s * lidar.y, y + s * lidar.x + c * lidar.y
    c, s = math.cos(theta + lidar.theta), math.sin(theta + lidar.theta)
    bx, by = c * lidar.cos[beam] - s * lidar.sin[beam], s * lidar.cos[beam] + c * lidar.sin[beam]
    best = math.inf
    circles, edges = obstacles.circles, obstacles.edges
    for k in range(circles.shape[0]):
        best = min(best, to_circle(bx, by, circles[k, 0] - ox, circles[k, 1] - oy, circles[k, 2]))
    for k in range(obstacles.movers.shape[0]):
        mx, my, _, _ = mover_at(obstacles, k, time)
        best = min(best, to_circle(bx, by, mx - ox, my - oy, obstacles.movers[k, 0]))
    for k in range(edges.shape[0]):
        px, py = edges[k, 0] - ox, edges[k, 1] - oy
        best = min(best, to_segment(bx, by, px, py, edges[k, 2] - edges[k, 0], edges[k, 3] - edges[k, 1]))
    for k in range(obstacles.boxes.shape[0]):
        if inside_box(obstacles.boxes[k], ox, oy):
            best = 0.0
    return best


@njit(cache=True, error_model="numpy")
def to_circle(bx, by, cx, cy, radius):  # type: ignore[no-untyped-def]
    """Distance along the unit vector b to a filled circle about c; 0 inside, infinite when it is missed."""
    outside = cx * cx + cy * cy - radius * radius
    along = cx * bx + cy * by
    under = along * along - outside
    if outside <= 0.0:
        return 0.0
    return along - math.sqrt(under) if along > 0.0 and under >= 0.0 else math.inf


@njit(cache=True, error_model="numpy")
def to_segment(bx, by, px, py, ex, ey):  # type: ignore[no-untyped-def]
    """Distance along the unit vector b to the segment p .. p + e; infinite when it is missed or parallel."""
    turn = bx * ey - by * ex
    share, distance = (px * by - py * bx) / turn, (px * ey - py * ex) / turn
    return distance if turn != 0.0 and distance >= 0.0 and 0.0 <= share <= 1.0 else math.inf


@njit(cache=True, error_model="numpy")
def inside_box(box, x, y):  # type: ignore[no-untyped-def]
    """Whether a point is inside a filled box."""
    dx, dy = x - box[0], y - box[1]
    return abs(box[2] * dx + box[3] * dy) < box[4] and abs(box[2] * dy - box[3] * dx) < box[5]


@njit(cache=True, error_model="numpy")
def circle_over(ranges, lidar, cx, cy, radius):  # type: ignore[no-untyped-def]
    """Lower the ranges of the beams that a circle covers; (cx, cy) in the sensor's frame."""
    outside = cx * cx + cy * cy - radius * radius
    if outside <= 0.0:
        ranges[:] = 0.0
        return
    # the tangents' half angle, asin(r / d) = atan(r / tangent length)
    half = rough_angle(math.sqrt(outside), radius)
    middle = rough_angle(cx, cy)
    low, high, turn = beam_span(lidar, middle - half, middle + half)
    for k in range(-1, 2):
        a, b = beams_of(low + k * turn, high + k * turn, ranges.shape[0])
        span, cos, sin = ranges[a:b], lidar.cos[a:b], lidar.sin[a:b]
        for i in range(span.shape[0]):
            along = cx * cos[i] + cy * sin[i]
            under = along * along - outside
            hit = along - math.sqrt(max(under, 0.0))
            span[i] = hit if under >= 0.0 and along > 0.0 and hit < span[i] else span[i]


@njit(cache=True, error_model="numpy")
def segment_over(ranges, lidar, px, py, ex, ey):  # type: ignore[no-untyped-def]
    """Lower the ranges of the beams that a segment p .. p + e covers, in the sensor's frame."""
    qx, qy = px + ex, py + ey
    start = rough_angle(px, py)
    # signed angle from p to q, the short way round
    swing = rough_angle(px * qx + py * qy, px * qy - py * qx)
    low, high, turn = beam_span(lidar, start + min(swing, 0.0), start + max(swing, 0.0))
    area = px * ey - py * ex
    for k in range(-1, 2):
        a, b = beams_of(low + k * turn, high + k * turn, ranges.shape[0])
        span, cos, sin = ranges[a:b], lidar.cos[a:b], lidar.sin[a:b]
        for i in range(span.shape[0]):
            bx, by = cos[i], sin[i]
            over = 1.0 / (bx * ey - by * ex)
            share, hit = (px * by - py * bx) * over, area * over
            span[i] = hit if hit >= 0.0 and 0.0 <= share <= 1.0 and hit < span[i] else span[i]


@njit(cache=True, error_model="numpy")
def beam_span(lidar, low, high):  # type: ignore[no-untyped-def]
    """Angles [rad] as beam numbers (real) with low <= high, low within one turn from 0; and beams in a turn."""
    if lidar.step < 0.0:
        low, high = high, low
    turn = 2.0 * math.pi / abs(lidar.step)
    first, last = (low - lidar.first) / lidar.step, (high - lidar.first) / lidar.step
    shift = turn * math.floor(first / turn)
    return first - shift, last - shift, turn


@njit(cache=True, error_model="numpy")
def beams_of(low, high, count):  # type: ignore[no-untyped-def]
    """Range [a, b) of beams between two beam numbers, one more at each end for what rounding may have lost."""
    a, b = max(0.0, math.floor(low) - 1.0), min(float(count), math.ceil(high) + 2.0)
    return (int(a), int(b)) if a < b else (0, 0)


@njit(cache=True, error_model="numpy")
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


@njit(cache=True, error_model="numpy")
def read(ranges, lidar, key, scan):  # type: ignore[no-untyped-def]
    """What the sensor tells of true distances (b,), in place: noise, dropouts, limits of range.

    Infinite = no return (too far or dropped), NaN = too near to be measured.
    """
    bits, drops = draw(key, LIDAR, scan), draw(key, DROPOUT, scan)
    hashes, low, high = lidar.hashes, lidar.range_min, lidar.range_max
    if lidar.noise > 0.0 or lidar.noise_relative > 0.0:
        noise, relative = lidar.noise, lidar.noise_relative
        for i in range(ranges.shape[0]):
            d = ranges[i]
            # beyond the range there is nothing to disturb, and infinity times noise would be NaN
            d = d if d > high else d + max(noise, relative * d) * gauss(draw_index(bits, hashes[i]))
            ranges[i] = math.nan if d < low else (math.inf if d > high else d)
    else:
        for i in range(ranges.shape[0]):
            d = ranges[i]
            ranges[i] = math.nan if d < low else (math.inf if d > high else d)
    if lidar.dropout > 0.0:
        for i in range(ranges.shape[0]):
            if uniform(draw_index(drops, hashes[i])) < lidar.dropout:
                ranges[i] = math.inf


@njit(cache=True, error_model="numpy")
def read_beam(distance, lidar, key, scan, beam):  # type: ignore[no-untyped-def]
    """What the sensor tells of one beam's true distance; the same numbers as `read`."""
    low, high, index = lidar.range_min, lidar.range_max, lidar.hashes[beam]
    d = distance
    if (lidar.noise > 0.0 or lidar.noise_relative > 0.0) and d <= high:
        spread = max(lidar.noise, lidar.noise_relative * d)
        d += spread * gauss(draw_index(draw(key, LIDAR, scan), index))
    d = math.nan if d < low else (math.inf if d > high else d)
    if lidar.dropout > 0.0 and uniform(draw_index(draw(key, DROPOUT, scan), index)) < lidar.dropout:
        d = math.inf
    return d
