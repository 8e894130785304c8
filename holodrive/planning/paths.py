"""Paths: smooth curves in the plane, as functions of a parameter u in [0, 1]."""

import math
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from holodrive.errors import InputError
from holodrive.types import Array

# u (K,) -> position, first and second derivative by u, each (K, 2) [m]
Curve = Callable[[Array], tuple[Array, Array, Array]]


@dataclass(frozen=True)
class Path:
    """A curve with what it takes to make it again; `closed` when it ends where it began, with the same direction."""

    curve: Curve
    closed: bool
    recipe: dict[str, Any] = field(default_factory=dict)


def line(start: tuple[float, float], end: tuple[float, float]) -> Path:
    """Straight from `start` to `end` [m]."""
    a, d = np.asarray(start, float), np.subtract(end, start).astype(float)
    if not np.hypot(*d) > 0.0:
        raise InputError(f"a line needs two different ends; both are {tuple(start)}")

    def curve(u: Array) -> tuple[Array, Array, Array]:
        ones = np.ones_like(u)[:, None]
        return a + u[:, None] * d, ones * d, 0.0 * ones * d

    return Path(curve, False, {"path": "line", "start": list(start), "end": list(end)})


def circle(radius_m: float, centre: tuple[float, float] = (0.0, 0.0), start_angle_rad: float = 0.0) -> Path:
    """Once around counter-clockwise, from the point at `start_angle_rad`."""
    _positive("radius", radius_m)

    def curve(u: Array) -> tuple[Array, Array, Array]:
        w = 2.0 * math.pi
        a = start_angle_rad + w * u
        p = np.stack([np.cos(a), np.sin(a)], axis=-1)
        n = np.stack([-np.sin(a), np.cos(a)], axis=-1)
        return np.asarray(centre) + radius_m * p, radius_m * w * n, -radius_m * w * w * p

    return Path(
        curve,
        True,
        {"path": "circle", "radius_m": radius_m, "centre": list(centre), "start_angle_rad": start_angle_rad},
    )


def lemniscate(half_width_m: float, centre: tuple[float, float] = (0.0, 0.0), upright: bool = False) -> Path:
    """Gerono's lemniscate from its crossing: an infinity sign along x, or an 8 along y when `upright`.

    x = a sin(2 pi u), y = a sin(2 pi u) cos(2 pi u): twice as wide as `half_width_m`, half as high as wide.
    """
    _positive("half width", half_width_m)

    def curve(u: Array) -> tuple[Array, Array, Array]:
        w = 2.0 * math.pi
        s, c, s2, c2 = np.sin(w * u), np.cos(w * u), np.sin(2 * w * u), np.cos(2 * w * u)
        long = [s, w * c, -w * w * s]
        short = [0.5 * s2, w * c2, -2.0 * w * w * s2]
        first, second = (short, long) if upright else (long, short)
        p, d, dd = (half_width_m * np.stack([a, b], axis=-1) for a, b in zip(first, second, strict=True))
        return p + np.asarray(centre), d, dd

    recipe = {"path": "lemniscate", "half_width_m": half_width_m, "centre": list(centre), "upright": upright}
    return Path(curve, True, recipe)


PATHS: dict[str, Callable[..., Path]] = {"line": line, "circle": circle, "lemniscate": lemniscate}


def _positive(what: str, value: float) -> None:
    if not (value > 0.0 and math.isfinite(value)):
        raise InputError(f"the path's {what} is {value} m; it must be above 0")
