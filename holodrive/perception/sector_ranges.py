"""Distances ahead, to the left and to the right: a scan in three numbers, as the fuzzy controller reads it.

Tuama and Hadi count angles as the RPLIDAR does, clockwise from ahead, and never give their four limits; "three
45-degree-spaced sectors" suggests 22.5, 67.5, 292.5 and 337.5 degrees. Their inequalities leave out the limits
themselves; here sectors are half open, so that no beam falls between two of them.
"""

import math
from dataclasses import dataclass
from typing import Literal

import numpy as np

from holodrive.errors import InputError
from holodrive.leaf import leaf
from holodrive.perception.scan_points import points
from holodrive.types import Array, Scan

RangeFrom = Literal["sensor", "hull", "offset"]


@dataclass(frozen=True, slots=True)
class Sectors:
    """Limits of the sectors [deg], clockwise from ahead: DH [th4, th1) over 0, DR [th1, th2), DL [th3, th4).

    Raises:
        InputError: limits that do not rise, or a sector of 180 degrees or more.
    """

    th1_deg: float = 22.5
    th2_deg: float = 67.5
    th3_deg: float = 292.5
    th4_deg: float = 337.5

    def __post_init__(self) -> None:
        limits = (self.th1_deg, self.th2_deg, self.th3_deg, self.th4_deg)
        rising = 0.0 < limits[0] < limits[1] <= limits[2] < limits[3] < 360.0
        widths = (limits[0] + 360.0 - limits[3], limits[1] - limits[0], limits[3] - limits[2])
        if not rising or max(widths) >= 180.0:
            raise InputError(
                f"sector limits are {', '.join(f'{v:g}' for v in limits)} deg; they must rise between 0 and 360, "
                "and each sector be narrower than 180 deg"
            )

    @property
    def edges(self) -> Array:
        """(12,) unit vectors in `base_link` where DH, DL, DR begin and end, clockwise: x, y, x, y each."""
        sectors = ((self.th4_deg, self.th1_deg), (self.th3_deg, self.th4_deg), (self.th1_deg, self.th2_deg))
        angles = -np.radians(np.array(sectors).ravel())
        return np.stack([np.cos(angles), np.sin(angles)], axis=1).ravel()


@leaf
def sector_minima(xs, ys, count, x, y, c, s, edges, offset, far, out):  # type: ignore[no-untyped-def]
    """Write the least distances (3,) [m] of points in the sectors DH, DL, DR; `far` where a sector is empty.

    Args:
        xs, ys, count: points in any frame [m].
        x, y, c, s: pose of the robot in that frame, heading as cosine and sine.
        edges: (12,) as `Sectors.edges`.
        offset: taken off every distance from the robot's centre, which stays 0 or more [m].
        far: largest distance told [m].
        out: (3,).
    """
    square = (far + offset) ** 2
    for k in range(3):
        out[k] = square
    for i in range(count):
        dx, dy = xs[i] - x, ys[i] - y
        d = dx * dx + dy * dy
        if d < square:
            bx, by = c * dx + s * dy, c * dy - s * dx
            for k in range(3):
                at = 4 * k
                # clockwise behind the first edge, or on it, and before the second
                inside = (edges[at + 1] * bx - edges[at] * by >= 0.0) & (edges[at + 2] * by - edges[at + 3] * bx > 0.0)
                if inside and d < out[k]:
                    out[k] = d
    for k in range(3):
        out[k] = max(0.0, math.sqrt(out[k]) - offset)


def sectors(
    scan: Scan,
    limits: Sectors | None = None,
    offset_m: float = 0.0,
    far_m: float = 3.0,
    twist: tuple[float, float, float] = (0.0, 0.0, 0.0),
) -> tuple[float, float, float]:
    """Least distances (dh, dl, dr) [m] ahead, left and right, from the robot's centre less `offset_m`.

    Args:
        scan: of a sensor anywhere on the robot.
        limits: of the sectors; the first paper's when None.
        offset_m: such as the footprint's radius, to measure from the hull.
        far_m: what a sector without a return tells, and the most that any tells.
        twist: of the robot while the scan was taken.
    """
    found = points(scan, twist)
    out = np.empty(3)
    edges = (limits or Sectors()).edges
    xs, ys = np.ascontiguousarray(found[:, 0]), np.ascontiguousarray(found[:, 1])
    sector_minima(xs, ys, len(found), 0.0, 0.0, 1.0, 0.0, edges, offset_m, far_m, out)
    dh, dl, dr = out.tolist()
    return dh, dl, dr
