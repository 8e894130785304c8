"""What can be computed from the runs of Tables I and II alone: deviations both ways, misprints, copies, bounds."""

from dataclasses import dataclass
from itertools import combinations

import numpy as np

from holodrive.experiments.mecanum.printed import Row
from holodrive.types import Array

DIGIT = 1.0001e-4  # one unit of the last printed digit; the runs are rounded too, so half of it is too strict


@dataclass(frozen=True)
class Columns:
    """Statistics of each row, all (rows,), in the unit of the runs.

    Attributes:
        angle_deg, mean: of the row.
        population, sample: standard deviation with n and with n - 1 below the line.
    """

    angle_deg: Array
    mean: Array
    population: Array
    sample: Array

    @classmethod
    def of(cls, rows: tuple[Row, ...]) -> "Columns":
        """From the runs."""
        runs = values(rows)
        angle = np.array([row.angle_deg for row in rows])
        return cls(angle, runs.mean(axis=1), runs.std(axis=1), runs.std(axis=1, ddof=1))


@dataclass(frozen=True)
class Twin:
    """Two runs of one table with the same value: row and number of each, counted from 0 and from 1."""

    first: tuple[int, int]
    second: tuple[int, int]
    difference: float


def values(rows: tuple[Row, ...]) -> Array:
    """Runs (rows, 4)."""
    return np.array([row.runs for row in rows])


def fits(printed: Array, found: Array) -> Array:
    """Where found values are the printed ones but for rounding, (rows,) of truth values."""
    return np.asarray(np.abs(printed - found) <= DIGIT)


def deviations(rows: tuple[Row, ...]) -> Array:
    """The printed SD (rows,)."""
    return np.array([row.deviation for row in rows])


def variations(rows: tuple[Row, ...]) -> Array:
    """The printed COV (rows,)."""
    return np.array([row.variation for row in rows])


def misprints(row: Row) -> tuple[int, list[tuple[int, float]]]:
    """Which single wrong digit in a run explains a row whose SD and COV do not fit its runs.

    Returns:
        How many single digits were tried, and each (number of the run, value) with which the population's SD and the
        sample's COV both come out as printed.
    """
    tried, found = 0, []
    for number, value in enumerate(row.runs):
        for changed in _one_digit_off(f"{value:.4f}"):
            tried += 1
            runs = np.array([*row.runs[:number], changed, *row.runs[number + 1 :]])
            variation = runs.std(ddof=1) / runs.mean()
            if abs(runs.std() - row.deviation) <= DIGIT and abs(variation - row.variation) <= DIGIT:
                found.append((number + 1, changed))
    return tried, found


def twins(rows: tuple[Row, ...], within: float = 1.5e-4) -> list[Twin]:
    """All pairs of runs of a table that are equal but for one unit of the last digit."""
    runs = values(rows)
    flat = [((i, j + 1), float(runs[i, j])) for i in range(runs.shape[0]) for j in range(runs.shape[1])]
    return [Twin(a, b, abs(x - y)) for (a, x), (b, y) in combinations(flat, 2) if abs(x - y) <= within]


def least_samples(absolute: Array, squared: Array) -> Array:
    """The least number of samples that can have these sums of |e| and of e^2 (Cauchy and Schwarz).

    The same numbers are the least duration, if the sums were integrals over time in seconds.
    """
    return np.asarray(absolute**2 / squared)


def weighted_error(absolute: Array, squared: Array) -> Array:
    """Mean of |e| weighted with |e|: the same whether sums or integrals were printed, at most the largest |e|."""
    return np.asarray(squared / absolute)


def _one_digit_off(text: str) -> list[float]:
    return [
        float(text[:i] + digit + text[i + 1 :])
        for i, old in enumerate(text)
        if old.isdigit()
        for digit in "0123456789"
        if digit != old
    ]
