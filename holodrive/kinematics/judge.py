"""Judging a chassis: can it move in all three ways, how evenly, and if not, which motion is lost and why.

Each wheel row is a line on the ground through the contact along the push axis; three independent motions exist
exactly when the lines are neither all parallel nor all through one point.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from holodrive.kinematics.wheel import Wheel
from holodrive.types import Array

WARN_CONDITION = 10.0
MAX_CONDITION = 1e6
MIN_LEVER = 0.1  # of the wheels' mean distance, see characteristic_length


@dataclass(frozen=True, slots=True)
class Verdict:
    """What the singular values of J diag(1, 1, 1/L_c) say.

    Attributes:
        rank: how many motions the wheels can tell apart: singular values above the largest / 1e6.
        condition: largest over smallest singular value; infinite when one is 0.
        length: L_c [m], mean rim speed per yaw rate with rollers mounted the better way.
        lost: motions that turn no wheel (or nearly none), in words; empty for a sound chassis.
        cause: what is wrong with which wheels, in words.
    """

    rank: int
    condition: float
    length: float
    lost: tuple[str, ...]
    cause: str


def judge(wheels: Sequence[Wheel], rows: Array) -> Verdict:
    """Rank and condition of the rows (rows, 3) of a base, in one common unit, and what is lost."""
    length = characteristic_length(wheels)
    _, singular, right = np.linalg.svd(rows * [1.0, 1.0, 1.0 / length], full_matrices=True)
    values = np.zeros(3)
    values[: len(singular)] = singular
    rank = int(np.count_nonzero(values * MAX_CONDITION >= values[0])) if values[0] > 0.0 else 0
    condition = float(values[0] / values[2]) if values[2] > 0.0 else math.inf
    if rank == 1:
        return Verdict(rank, condition, length, *_one_line(wheels, right[0] * [1.0, 1.0, length]))
    lost = tuple(_in_words(right[i] / [1.0, 1.0, length], length) for i in range(rank, 3))
    return Verdict(rank, condition, length, lost, _cause(wheels, right[2], length) if lost else "")


def characteristic_length(wheels: Sequence[Wheel]) -> float:
    """L_c [m]: mean lever of the wheels, but at least a tenth of their mean distance from `base_link`.

    Each wheel counts with its rollers mounted the better way. Counted as they are, Mecanum rollers that are all
    mounted the wrong way would shrink the yardstick with the levers, and the condition would not show it.
    Without the floor the scaling would make up for any lever however small, and call a base sound whose axes all
    pass through `base_link` up to rounding.
    """
    lever = sum(wheel.best_lever for wheel in wheels) / len(wheels)
    distance = sum(math.hypot(wheel.x, wheel.y) for wheel in wheels) / len(wheels)
    return max(lever, MIN_LEVER * distance) or 1.0


def _in_words(twist: Array, length: float) -> str:
    """Name the motion `twist` that no wheel feels."""
    vx, vy, omega = (float(value) for value in twist)
    speed = math.hypot(vx, vy)
    if abs(omega) * length <= 1e-5 * speed:
        return _direction_in_words(vx, vy)
    x, y = -vy / omega, vx / omega
    if math.hypot(x, y) <= 1e-5 * length:
        return "it cannot turn in place"
    return f"rotation about ({_metres(x)}, {_metres(y)}) m turns no wheel"


def _direction_in_words(vx: float, vy: float) -> str:
    if abs(vy) <= 1e-5 * abs(vx):
        return "it cannot move forwards or back (along x)"
    if abs(vx) <= 1e-5 * abs(vy):
        return "it cannot move sideways (along y)"
    return f"it cannot move along the direction at {math.degrees(math.atan2(vy, vx)) % 180.0:.1f} deg"


def _one_line(wheels: Sequence[Wheel], row: Array) -> tuple[tuple[str, ...], str]:
    """What is lost and why where the push axes share one line, whose row is (a_x, a_y, moment [m])."""
    names = ", ".join(wheel.name for wheel in wheels)
    ax, ay, moment = (float(value) for value in row / math.hypot(row[0], row[1]))
    lost = (_direction_in_words(-ay, ax), "it cannot turn about any point of one line")
    if len(wheels) < 3:
        return lost, _too_few(wheels)
    angle, through = (
        round(math.degrees(math.atan2(ay, ax)), 6) % 180.0,
        f"({_metres(moment * ay)}, {_metres(-moment * ax)}) m",
    )
    return lost, f"the push axes of {names} lie on one line, at {angle:.3g} deg through {through}"


def _too_few(wheels: Sequence[Wheel]) -> str:
    names = ", ".join(wheel.name for wheel in wheels)
    return f"{len(wheels)} fixed wheel{'s' * (len(wheels) > 1)} ({names}) cannot drive three motions"


def _cause(wheels: Sequence[Wheel], null: Array, length: float) -> str:
    """Which wheels share parallel or concurrent axes; `null` in (m/s, m/s, L_c rad/s)."""
    names = ", ".join(wheel.name for wheel in wheels)
    if len(wheels) < 3 and not any(wheel.steered for wheel in wheels):
        return _too_few(wheels)
    if all(wheel.steered for wheel in wheels):
        return f"the steered wheels {names} stand on one point"
    if math.hypot(null[0], null[1]) < 1e-9 or abs(null[2]) > 1e-5 * math.hypot(null[0], null[1]):
        x, y = -null[1] / null[2] * length, null[0] / null[2] * length
        return f"the push axes of {names} all meet in ({_metres(x)}, {_metres(y)}) m"
    return f"the push axes of {names} are parallel"


def _metres(value: float) -> str:
    return f"{value:.3g}" if abs(value) > 1e-9 else "0"
