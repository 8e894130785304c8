"""Scans of known worlds, cast by formula: the second method beside the simulator."""

import math

import numpy as np

from holodrive.types import Scan

BEAMS = 360


def scan_of(circles, walls=None, noise=0.0, seed=0, mount=(0.0, 0.0, 0.0), clockwise=True, beams=BEAMS):
    """Scan from base_link at the origin. circles: (x, y, r); walls: (x_low, x_high, y_low, y_high) of a room."""
    angles = (-1.0 if clockwise else 1.0) * 2.0 * math.pi * np.arange(beams) / beams
    x, y, theta = mount
    ux, uy = np.cos(angles + theta), np.sin(angles + theta)
    ranges = np.full(beams, math.inf)
    for cx, cy, r in circles:
        along, across = ux * (cx - x) + uy * (cy - y), ux * (cy - y) - uy * (cx - x)
        hit = (along > 0) & (np.abs(across) < r)
        ranges[hit] = np.minimum(ranges[hit], along[hit] - np.sqrt(r * r - across[hit] ** 2))
    if walls is not None:
        with np.errstate(divide="ignore"):
            to_x = np.where(ux > 0, (walls[1] - x) / ux, (walls[0] - x) / ux)
            to_y = np.where(uy > 0, (walls[3] - y) / uy, (walls[2] - y) / uy)
        ranges = np.minimum(ranges, np.minimum(to_x, to_y))
    ranges = ranges * (1.0 + noise * np.random.default_rng(seed).standard_normal(beams))
    return Scan(0.0, angles, ranges, np.zeros(beams), mount, 0.15, 12.0)
