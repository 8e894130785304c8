"""Fuzzy sets as polylines with one-sided limits: what lint and explain reckon with, exact for straight-sided sets."""

from dataclasses import dataclass
from itertools import combinations

import numpy as np
from numpy.typing import ArrayLike

from holodrive.control.fuzzy.membership import polyline
from holodrive.control.fuzzy.sets import Set
from holodrive.control.fuzzy.system import Variable
from holodrive.types import Array


@dataclass(frozen=True)
class Shape:
    """A membership function as straight pieces; an upright side is two vertices at one place.

    Attributes:
        x, m: (k,) places, not falling, and memberships; level at m[0] before the first and at m[-1] after the last.
    """

    x: Array
    m: Array

    @classmethod
    def of(cls, one: Set, low: float, high: float) -> "Shape":
        """The shape of a set; `low` and `high` bound the piece of a curved set that is drawn out."""
        if one.kind == "singleton":
            return cls(np.array([one.params[0]] * 3), np.array([0.0, 1.0, 0.0]))
        return cls(*polyline(one, low, high))

    def before(self, x: ArrayLike) -> Array:
        """Limit from the left at x (...)."""
        return self._beside(x, "left")

    def after(self, x: ArrayLike) -> Array:
        """Limit from the right at x (...)."""
        return self._beside(x, "right")

    def at(self, x: ArrayLike) -> Array:
        """Membership at x (...): the top of an upright side belongs to the set."""
        x = np.asarray(x, dtype=np.float64)
        value = np.maximum(self.before(x), self.after(x))
        for place, height in zip(self.x, self.m, strict=True):
            value = np.where(x == place, np.maximum(value, height), value)
        return np.asarray(value)

    def _beside(self, x: ArrayLike, side: str) -> Array:
        x = np.asarray(x, dtype=np.float64)
        upper = np.searchsorted(self.x, x, side="right" if side == "right" else "left")
        a, b = np.clip(upper - 1, 0, len(self.x) - 1), np.clip(upper, 0, len(self.x) - 1)
        width = self.x[b] - self.x[a]
        share = np.where(width > 0.0, (x - self.x[a]) / np.where(width > 0.0, width, 1.0), 0.0)
        value = self.m[a] + share * (self.m[b] - self.m[a])
        return np.where(upper == 0, self.m[0], np.where(upper == len(self.x), self.m[-1], value))


def shapes(variable: Variable, low: float | None = None, high: float | None = None) -> list[Shape]:
    """The shapes of all sets of a variable, drawn out over its universe, or as far as told."""
    low = variable.low if low is None else min(low, variable.low)
    high = variable.high if high is None else max(high, variable.high)
    return [Shape.of(one, low, high) for one in variable.sets]


def breaks(curves: list[Shape], low: float, high: float, crossings: bool = True) -> Array:
    """The places (k,) in [low, high], both ends among them, between which all curves are straight and keep order."""
    places = np.unique(np.concatenate([[low, high], *(curve.x for curve in curves)]))
    places = places[(places >= low) & (places <= high)]
    if not crossings or len(curves) < 2:
        return places
    left, right = places[:-1], places[1:]
    starts, ends = np.stack([c.after(left) for c in curves]), np.stack([c.before(right) for c in curves])
    found = [places]
    for a, b in combinations(range(len(curves)), 2):
        d0, d1 = starts[a] - starts[b], ends[a] - ends[b]
        cross = d0 * d1 < 0.0
        found.append(left[cross] + (right - left)[cross] * d0[cross] / (d0 - d1)[cross])
    return np.unique(np.concatenate(found))
