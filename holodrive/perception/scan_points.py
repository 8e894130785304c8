"""Scans to points: bad returns left out, single outliers removed, each beam placed where the robot was at its time.

A lidar that turns 5.5 times a second needs 182 ms for a scan; at 0.2 m/s and 0.5 rad/s the robot moves 36 mm and
5 degrees in that time (Tuama and Hadi use an RPLIDAR A1). So a beam belongs to the pose of its own time, which
odometry knows: a short history of poses, one row a control tick.
"""

import math

import numpy as np
from numpy.typing import ArrayLike

from holodrive.leaf import leaf
from holodrive.types import Array, Scan

# one row of a pose history: time [s], x, y [m], cosine and sine of the heading
ROW = 5
_STEPS = 33  # rows with which the plain face follows a constant twist through one scan


@leaf
def remember(history, count, time, x, y, theta):  # type: ignore[no-untyped-def]
    """Write a pose into a history (rows * ROW,) as its number `count`; the oldest makes room."""
    rows = history.shape[0] // ROW
    at = ROW * (count % rows)
    history[at], history[at + 1], history[at + 2] = time, x, y
    history[at + 3], history[at + 4] = math.cos(theta), math.sin(theta)


@leaf
def median_range(beams, i, first, count, low, high):  # type: ignore[no-untyped-def]
    """Median of beam i's range and its two neighbours' [m]; infinite where beam i itself has no valid return.

    A neighbour that sees nothing (farther than high) counts as infinitely far, so a single beam that sees something
    between two that do not is taken for an outlier; one that tells nothing (NaN, below low) has no say. The scan is a
    full turn: its last beam is the first one's neighbour.
    """
    middle = beams[first + i]
    if not (low <= middle <= high):
        return math.inf
    before, after = beams[first + (i - 1) % count], beams[first + (i + 1) % count]
    before = (before if before <= high else math.inf) if before >= low else middle
    after = (after if after <= high else math.inf) if after >= low else middle
    return max(min(before, after), min(max(before, after), middle))


@leaf
def telling(beams, first, count, low):  # type: ignore[no-untyped-def]
    """How many beams tell something: a distance, or that there is nothing; NaN and what is below low tell nothing."""
    found = 0
    for i in range(count):
        if beams[first + i] >= low:
            found += 1
    return found


@leaf
def place_scan(  # type: ignore[no-untyped-def]
    beams, first, count, angle, step, stamp, period, sensor, history, poses, reach, median, xs, ys, ts
):
    """Write the points of a scan (xs, ys) [m], in the frame of the pose history, and their times; gives how many.

    Args:
        beams, first, count: ranges [m] are beams[first : first + count].
        angle, step: direction of beam 0 and from one beam to the next [rad], sensor frame.
        stamp, period: time of the last beam, and from one beam to the next [s].
        sensor: (6,) its pose in `base_link` as x, y, cosine, sine, then range_min, range_max.
        history, poses: pose history and the number of poses that it was given; at least one.
        reach: points farther than this from the sensor are left out [m].
        median: remove single outliers.
        xs, ys, ts: (>= count,).
    """
    rows = history.shape[0] // ROW
    kept = min(rows, poses)
    row, last = poses - kept, poses - 1
    low, high = sensor[4], sensor[5]
    # directions by turning on from beam to beam: 1e-14 of error a scan, and no sine and cosine for each
    bx = math.cos(angle) * sensor[2] - math.sin(angle) * sensor[3]
    by = math.sin(angle) * sensor[2] + math.cos(angle) * sensor[3]
    turn_x, turn_y = math.cos(step), math.sin(step)
    found = 0
    for i in range(count):
        r = median_range(beams, i, first, count, low, high) if median else beams[first + i]
        if low <= r <= high and r <= reach:
            time = stamp - (count - 1 - i) * period
            while row < last - 1 and history[ROW * ((row + 1) % rows)] <= time:
                row += 1
            a, b = ROW * (row % rows), ROW * (min(row + 1, last) % rows)
            span = history[b] - history[a]
            share = min(1.0, max(0.0, (time - history[a]) / span)) if span > 0.0 else 1.0
            px, py = sensor[0] + r * bx, sensor[1] + r * by
            c = history[a + 3] + share * (history[b + 3] - history[a + 3])
            s = history[a + 4] + share * (history[b + 4] - history[a + 4])
            xs[found] = history[a + 1] + share * (history[b + 1] - history[a + 1]) + c * px - s * py
            ys[found] = history[a + 2] + share * (history[b + 2] - history[a + 2]) + s * px + c * py
            ts[found] = time
            found += 1
        bx, by = turn_x * bx - turn_y * by, turn_y * bx + turn_x * by
    return found


def points(scan: Scan, twist: ArrayLike = (0.0, 0.0, 0.0), reach_m: float = math.inf, median: bool = True) -> Array:
    """Valid points (k, 2) [m] of a scan in `base_link` as it stood at the scan's stamp, in the order of the beams.

    Args:
        scan: of evenly spread beams; ranges that are NaN, infinite or outside its range are no points.
        twist: (vx, vy, omega) of `base_link` while the scan was taken [m/s, m/s, rad/s].
        reach_m: points farther from the sensor are left out.
        median: take the median of each three neighbours, which removes single outliers.
    """
    ranges = np.ascontiguousarray(scan.ranges, dtype=np.float64)
    count = len(ranges)
    if not count:
        return np.zeros((0, 2))
    step = math.remainder(scan.angles[1] - scan.angles[0], 2.0 * math.pi) if count > 1 else 0.0
    first, last = float(scan.offsets[0]), float(scan.offsets[-1])
    history = _followed(first, last, twist)
    x, y, theta = scan.mount
    sensor = np.array([x, y, math.cos(theta), math.sin(theta), scan.range_min, scan.range_max])
    period = (last - first) / (count - 1) if count > 1 else 0.0
    xs, ys, ts = np.empty(count), np.empty(count), np.empty(count)
    found = place_scan(
        ranges,
        0,
        count,
        float(scan.angles[0]),
        step,
        last,
        period,
        sensor,
        history,
        _STEPS,
        reach_m,
        median,
        xs,
        ys,
        ts,
    )
    return np.stack([xs[:found], ys[:found]], axis=1)


def _followed(first_s: float, last_s: float, twist: ArrayLike) -> Array:
    """Pose history of a constant twist between two times, its origin the pose at time 0."""
    from holodrive import geometry

    times = np.linspace(first_s, last_s, _STEPS)
    poses = geometry.exp(times[:, None] * np.asarray(twist, dtype=np.float64))
    x, y, theta = poses.T
    return np.ascontiguousarray(np.stack([times, x, y, np.cos(theta), np.sin(theta)], axis=1).ravel())
