"""Points to obstacles: neighbours that are near to each other are one thing, and a circle is fitted to each.

Where neighbours part depends on how far the points are apart at that range anyway: the adaptive break point of
Borges and Aldon (2004). Circles are fitted by the algebraic method of Taubin (1991), which does not shrink the
radius of short noisy arcs as the plain one does.
"""

import math
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from holodrive.types import Array

FEWEST = 4  # points of a cluster
ROUND_M = 0.6  # radius up to which something is taken for round
_STRAIGHT = 1e-9  # share of an arc's spread across it, below which it is a line
_SLOPE = math.radians(10.0)  # a surface that the beams graze flatter than this falls into pieces


@dataclass(frozen=True)
class Cluster:
    """One obstacle as a scan shows it.

    Attributes:
        x, y: centre of the fitted circle [m], or of the points where they lie on a line.
        radius: of the circle [m]; infinite for a line.
        points: (k, 2) [m].
        residual_m: root mean square distance of the points from the circle (or line).
    """

    x: float
    y: float
    radius: float
    points: Array = field(repr=False, compare=False)
    residual_m: float = 0.0

    @property
    def is_round(self) -> bool:
        """Whether it is a pillar and not a wall."""
        return self.radius <= ROUND_M


def clusters(
    points: Array, noise_m: float = 0.02, fewest: int = FEWEST, step_rad: float = math.radians(1.0)
) -> tuple[Cluster, ...]:
    """Obstacles in a scan's points, in the order of the beams.

    Args:
        points: (k, 2) [m] in the order of the beams, as `perception.points` gives them; the sensor is near the origin.
        noise_m: standard deviation of a range.
        fewest: smaller groups are left out.
        step_rad: angle between beams.
    """
    points = np.asarray(points, dtype=np.float64).reshape(-1, 2)
    groups = _groups(points, noise_m, abs(step_rad))
    return tuple(_fitted(points[group]) for group in groups if len(group) >= max(3, fewest))


def _groups(points: Array, noise_m: float, step_rad: float) -> list[Any]:
    count = len(points)
    if count == 0:
        return []
    after = np.roll(points, -1, axis=0)
    ranges = np.linalg.norm(points, axis=1)
    # as far apart as the beams are on a surface that they meet at the flattest angle, and three sigma
    allowed = ranges * math.sin(step_rad) / math.sin(_SLOPE - 0.5 * step_rad) + 3.0 * noise_m
    parted = np.linalg.norm(after - points, axis=1) > allowed
    cuts = np.flatnonzero(parted) + 1
    if len(cuts) == 0:
        return [np.arange(count)]
    # the scan is a turn: what begins at its end goes on at its beginning
    order = np.roll(np.arange(count), -int(cuts[0]))
    return np.split(order, cuts[1:] - cuts[0])


def _fitted(points: Array) -> Cluster:
    """Taubin's fit: least squares of (|p - c|^2 - r^2) / r."""
    middle = points.mean(axis=0)
    u, v = (points - middle).T
    spread = np.linalg.eigvalsh(np.cov(np.stack([u, v])))
    if spread[0] <= _STRAIGHT * spread[1]:
        return Cluster(float(middle[0]), float(middle[1]), math.inf, points)
    square = u * u + v * v
    mean = square.mean()
    scaled = (square - mean) / (2.0 * math.sqrt(mean))
    _, _, rows = np.linalg.svd(np.stack([scaled, u, v], axis=1), full_matrices=False)
    a = rows[2, 0] / (2.0 * math.sqrt(mean))
    if abs(a) < 1e-12:
        return Cluster(float(middle[0]), float(middle[1]), math.inf, points)
    cu, cv = -rows[2, 1] / (2.0 * a), -rows[2, 2] / (2.0 * a)
    radius = math.sqrt(cu * cu + cv * cv + mean)
    residual = float(np.sqrt(np.mean((np.hypot(u - cu, v - cv) - radius) ** 2)))
    return Cluster(float(middle[0] + cu), float(middle[1] + cv), radius, points, residual)
