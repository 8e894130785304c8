"""Membership of fuzzy sets by plain NumPy, and sets as polylines; the kernel has its own, compiled form."""

import numpy as np
from numpy.typing import ArrayLike

from holodrive.control.fuzzy.sets import Set
from holodrive.errors import InputError
from holodrive.types import Array

POLYLINE_ERROR = (
    1e-5  # largest difference in membership between a curved output set and the polyline that stands for it
)


def membership(set_: Set, x: ArrayLike) -> Array:
    """Degree of membership (...) of x (...), in the units of the set's variable; NaN for NaN.

    An upright side belongs to the set: where a polyline jumps, the greatest of its heights counts.

    Raises:
        InputError: a conclusion of a Sugeno rule, which is no fuzzy set.
    """
    x = np.asarray(x, dtype=np.float64)
    if set_.is_conclusion:
        raise InputError(f"{set_.name!r} is a {set_.kind} conclusion of a Sugeno rule and has no membership")
    with np.errstate(all="ignore"):  # infinite inputs and powers that overflow have a right limit
        return np.where(np.isnan(x), np.nan, _MEMBERSHIP[set_.kind](x, set_.params))


def corners(set_: Set) -> tuple[float, float, float, float]:
    """Feet and shoulders (a, b, c, d) of a triangle or trapezoid."""
    a, b, *rest = set_.params
    return (a, b, b, rest[0]) if set_.kind == "triangle" else (a, b, rest[0], rest[1])


def polyline(set_: Set, low: float, high: float) -> tuple[Array, Array]:
    """Places and heights (n,), (n,) of a set over at least low..high; at an upright side a place comes twice.

    Exact for piecewise-linear sets; a Gaussian or bell becomes one that is nowhere further off than `POLYLINE_ERROR`.
    """
    if set_.kind in ("triangle", "trapezoid"):
        a, b, c, d = corners(set_)
        places, heights = [a, b, c, d], [0.0, 1.0, 1.0, 0.0]
        if low < a:
            places, heights = [low, *places], [0.0, *heights]
        if high > d:
            places, heights = [*places, high], [*heights, 0.0]
    elif set_.kind == "polyline":
        places, heights = list(set_.params[::2]), list(set_.params[1::2])
        places = [min(low, places[0]), *places, max(high, places[-1])]
        heights = [heights[0], *heights, heights[-1]]
    else:
        curve = _curve_places(set_, low, high)
        return curve, membership(set_, curve)
    return np.array(places, dtype=np.float64), np.array(heights, dtype=np.float64)


def _curve_places(set_: Set, low: float, high: float) -> Array:
    """Where a polyline through a curved set must bend, by halving."""
    if set_.kind == "gaussian":
        centre, width = set_.params
    else:
        width, _, centre = set_.params
    marks = {low, high} | {centre + k * width for k in (-4, -2, -1, 0, 1, 2, 4)}
    places = np.array(sorted(mark for mark in marks if low <= mark <= high))
    quarters = np.array([0.25, 0.5, 0.75])
    for _ in range(60):  # each round halves; a double has no more halves than that
        left, right = places[:-1], places[1:]
        inner = left[:, None] + (right - left)[:, None] * quarters
        at_left, at_right = membership(set_, left), membership(set_, right)
        straight = at_left[:, None] + (at_right - at_left)[:, None] * quarters
        bent = np.max(np.abs(membership(set_, inner) - straight), axis=1) > POLYLINE_ERROR
        if not bent.any():
            break
        places = np.unique(np.concatenate([places, inner[bent, 1]]))
    return places


def _trapezoid(x: Array, params: tuple[float, ...]) -> Array:
    a, b, c, d = params
    mu = np.where(x < b, (x - a) / (b - a), np.where(x <= c, 1.0, (d - x) / (d - c)))
    return np.where((x < a) | (x > d), 0.0, mu)


def _triangle(x: Array, params: tuple[float, ...]) -> Array:
    a, b, c = params
    return _trapezoid(x, (a, b, b, c))


def _gaussian(x: Array, params: tuple[float, ...]) -> Array:
    mean, sigma = params
    return np.asarray(np.exp(-0.5 * ((x - mean) / sigma) ** 2))


def _bell(x: Array, params: tuple[float, ...]) -> Array:
    a, b, centre = params
    return np.asarray(1.0 / (1.0 + np.abs((x - centre) / a) ** (2.0 * b)))


def _singleton(x: Array, params: tuple[float, ...]) -> Array:
    return np.where(x == params[0], 1.0, 0.0)


def _polyline(x: Array, params: tuple[float, ...]) -> Array:
    places, heights = np.array(params[::2]), np.array(params[1::2])
    mu = np.interp(x, places, heights)
    for place in places[:-1][places[:-1] == places[1:]]:
        mu = np.where(x == place, heights[places == place].max(), mu)
    return np.asarray(mu)


_MEMBERSHIP = {
    "triangle": _triangle,
    "trapezoid": _trapezoid,
    "gaussian": _gaussian,
    "bell": _bell,
    "singleton": _singleton,
    "polyline": _polyline,
}
