"""Fuzzy sets: triangle, trapezoid, Gaussian, bell, singleton, polyline; and the conclusions of Sugeno rules."""

import math
from dataclasses import dataclass
from typing import Literal, get_args

from holodrive.errors import InputError, UnknownName

SetKind = Literal[
    "triangle",  # a, b, c: feet a and c, top b; a = b or b = c is an upright side
    "trapezoid",  # a, b, c, d: feet a and d, top from b to c
    "gaussian",  # mean, sigma
    "bell",  # half width a, slope b, centre c: 1 / (1 + |(x - c) / a|^(2 b))
    "singleton",  # x: 1 at x, 0 elsewhere; as an output its weight lies at x
    "polyline",  # x0, m0, x1, m1 ...: straight between the points, level beyond them (IEC 61131-7)
    "constant",  # c: conclusion of a Sugeno rule of order 0
    "linear",  # k1 ... kn, c: k . x + c, of order 1
]
_COUNTS = {"triangle": 3, "trapezoid": 4, "gaussian": 2, "bell": 3, "singleton": 1, "constant": 1}


@dataclass(frozen=True, slots=True)
class Set:
    """A named fuzzy set or Sugeno conclusion; parameters as `SetKind` says, in the units of its variable.

    Raises:
        UnknownName: no such kind.
        InputError: wrong number of parameters, NaN, or an order that makes no set.
    """

    name: str
    kind: SetKind
    params: tuple[float, ...]

    def __post_init__(self) -> None:
        if self.kind not in get_args(SetKind):
            raise UnknownName("kind of fuzzy set", str(self.kind), get_args(SetKind))
        what = f"set {self.name!r} ({self.kind})"
        count = _COUNTS.get(self.kind)
        if count is not None and len(self.params) != count:
            raise InputError(f"{what} has {len(self.params)} parameters; it takes {count}")
        if not all(math.isfinite(value) for value in self.params) or not self.params:
            raise InputError(f"{what} has the parameters {list(self.params)}; they must be finite numbers")
        if self.kind in ("triangle", "trapezoid") and list(self.params) != sorted(self.params):
            raise InputError(f"{what} has the parameters {list(self.params)}; they must not fall")
        if self.kind in ("triangle", "trapezoid") and self.params[0] == self.params[-1]:
            raise InputError(f"{what} has no width; a set of one point is a singleton")
        if self.kind == "gaussian" and not self.params[1] > 0.0:
            raise InputError(f"{what} has sigma {self.params[1]:g}; it must be above 0")
        if self.kind == "bell" and not (self.params[0] > 0.0 and self.params[1] > 0.0):
            raise InputError(f"{what} has width {self.params[0]:g} and slope {self.params[1]:g}; both must be above 0")
        if self.kind == "polyline":
            self._check_polyline(what)

    def _check_polyline(self, what: str) -> None:
        places, heights = self.params[::2], self.params[1::2]
        if len(places) != len(heights) or len(places) < 2:
            raise InputError(f"{what} has {len(self.params)} numbers; it takes pairs of place and height, two at least")
        if list(places) != sorted(places) or not all(0.0 <= height <= 1.0 for height in heights):
            raise InputError(f"{what} has the points {list(self.params)}; places must not fall, heights be in 0..1")

    @property
    def is_conclusion(self) -> bool:
        """Whether it is a conclusion of a Sugeno rule and no fuzzy set."""
        return self.kind in ("constant", "linear")
