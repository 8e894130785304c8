"""The paths of section V: straight ones at 32 angles, the 8 and the infinity; sizes and speed are ours."""

import math
from functools import lru_cache

import numpy as np

from holodrive import planning
from holodrive.references import Table

STEP_DEG = 5.625
ANGLES_DEG = tuple(float(first + STEP_DEG * k) for first in (0.0, 180.0) for k in range(16))
LENGTH_M = 0.15  # of a straight path; not printed
HALF_WIDTH_M = 0.15  # of the 8 and the infinity; not printed, the figure shows 90 mm of it at least
SPEED_M_S = 0.02  # of the ramp; not printed
SETTLE_S = 2.0  # of a run after its path's end


@lru_cache(maxsize=64)
def straight(alpha_deg: float) -> Table:
    """A straight path from (0, 0) whose direction from the target back to the start is `alpha_deg`.

    The angle is the paper's: counter-clockwise from its x axis, which points to the robot's right, as seen from the
    target (figure 12); so the robot leaves in the opposite direction.
    """
    alpha = math.radians(alpha_deg)
    right, ahead = -LENGTH_M * math.cos(alpha), -LENGTH_M * math.sin(alpha)
    return planning.follow(planning.line((0.0, 0.0), (ahead, -right)), SPEED_M_S)


@lru_cache(maxsize=2)
def eight() -> Table:
    """The 8: a lemniscate whose long axis lies ahead of the robot."""
    return planning.follow(planning.lemniscate(HALF_WIDTH_M), SPEED_M_S)


@lru_cache(maxsize=2)
def infinity() -> Table:
    """The infinity sign: the same across the robot."""
    return planning.follow(planning.lemniscate(HALF_WIDTH_M, upright=True), SPEED_M_S)


def duration(table: Table) -> float:
    """How long a run along a path lasts [s]: the ramp, and what it takes to settle."""
    return table.duration_s + SETTLE_S


def nearness_deg(alpha_deg: float) -> float:
    """Angle between a path and 90 or 270 deg, where all wheels turn the same way [deg]."""
    return float(abs(np.mod(alpha_deg, 180.0) - 90.0))


__all__ = [
    "ANGLES_DEG",
    "HALF_WIDTH_M",
    "LENGTH_M",
    "SETTLE_S",
    "SPEED_M_S",
    "duration",
    "eight",
    "infinity",
    "nearness_deg",
    "straight",
]
