"""Measured actuators: from wheel speed to duty along a curve, and back (Keek et al., section III).

Curves are packed into one float64 vector so that kernels can read them: for each wheel a forward and a backward curve,
each found by an index. The inverse has no closed form that is worth its branches; the curve rises, so a bracketed
Newton search finds it to the last bits in a few steps.
"""

from collections.abc import Sequence

import numpy as np

from holodrive.leaf import leaf
from holodrive.robots.spec import DutyCurve, DutyMap
from holodrive.types import Array

# one packed curve: number of pieces, then `PIECE` numbers for each, then the end
PIECES = 0
FIRST = 1
START, C0, C1, C2, C3 = range(5)  # of a piece: knot [rad/s], coefficients [1, s/rad ...]
PIECE = 5
# after the last piece: last knot [rad/s], duty there, slope there [s/rad]
END_SPEED, END_DUTY, END_SLOPE, END = 0, 1, 2, 3

_STEPS = 60  # bisection alone would need as many; Newton takes a handful
_CLOSE = 1e-14  # of the last knot


def pack(maps: Sequence[DutyMap]) -> Array:
    """All curves of a robot in one vector: 2 n places (forward and backward of each wheel), then the curves."""
    curves = [_packed(curve) for each in maps for curve in (each.forward, each.backward)]
    places = np.cumsum([len(curves), *(len(curve) for curve in curves[:-1])])
    return np.concatenate([places.astype(np.float64), *curves])


def _packed(curve: DutyCurve) -> Array:
    rows = [(knot, *piece) for knot, piece in zip(curve.knots, curve.pieces, strict=False)]
    c0, c1, c2, c3 = curve.pieces[-1]
    w = curve.knots[-1] - curve.knots[-2]
    end = (curve.knots[-1], c0 + w * (c1 + w * (c2 + w * c3)), c1 + w * (2.0 * c2 + w * 3.0 * c3))
    return np.array([len(rows), *(number for row in rows for number in row), *end])


@leaf
def duty_of(curves, base, wheel, speed):  # type: ignore[no-untyped-def]
    """Duty that a wheel speed [rad/s] takes, at most 1 in size; none for a wheel that shall stand.

    Args:
        curves: vector that holds `pack`'s from `base` on.
        wheel: which.
        speed: signed; NaN gives NaN.
    """
    if speed == 0.0:
        return 0.0
    at = base + int(curves[base + 2 * wheel + (1 if speed < 0.0 else 0)])
    duty = min(curve_at(curves, at, abs(speed)), 1.0)  # in this order NaN stays
    return -duty if speed < 0.0 else duty


@leaf
def speed_of(curves, base, wheel, duty):  # type: ignore[no-untyped-def]
    """Steady wheel speed [rad/s] of a duty: 0 inside the dead zone, the inverse of `duty_of` outside.

    A duty beyond the curve's end, as a full battery gives it, goes on along the end's slope.
    """
    at = base + int(curves[base + 2 * wheel + (1 if duty < 0.0 else 0)])
    speed = inverse_at(curves, at, abs(duty))
    return -speed if duty < 0.0 else speed


@leaf
def curve_at(curves, at, speed):  # type: ignore[no-untyped-def]
    """The curve at `at` for a speed of 0 or more."""
    count = int(curves[at + PIECES])
    end = at + FIRST + PIECE * count
    if speed >= curves[end + END_SPEED]:
        return curves[end + END_DUTY] + (speed - curves[end + END_SPEED]) * curves[end + END_SLOPE]
    piece = at + FIRST
    for k in range(1, count):
        if speed >= curves[at + FIRST + PIECE * k + START]:
            piece = at + FIRST + PIECE * k
    w = speed - curves[piece + START]
    return curves[piece + C0] + w * (curves[piece + C1] + w * (curves[piece + C2] + w * curves[piece + C3]))


@leaf
def inverse_at(curves, at, duty):  # type: ignore[no-untyped-def]
    """The speed [rad/s] at which the curve at `at` has a duty of 0 or more; 0 in the dead zone."""
    count = int(curves[at + PIECES])
    end = at + FIRST + PIECE * count
    if not duty > curves[at + FIRST + C0]:
        return 0.0 * duty  # NaN stays NaN
    if duty >= curves[end + END_DUTY]:
        return curves[end + END_SPEED] + (duty - curves[end + END_DUTY]) / curves[end + END_SLOPE]
    piece = at + FIRST
    for k in range(1, count):
        if duty >= curves[at + FIRST + PIECE * k + C0]:
            piece = at + FIRST + PIECE * k
    low, high = 0.0, curves[piece + PIECE + START] - curves[piece + START]  # after the last piece stands the end's knot
    c0, c1, c2, c3 = curves[piece + C0], curves[piece + C1], curves[piece + C2], curves[piece + C3]
    w, tolerance = 0.5 * high, _CLOSE * curves[end + END_SPEED]
    for _ in range(_STEPS):
        error = c0 + w * (c1 + w * (c2 + w * c3)) - duty
        if error > 0.0:
            high = w
        else:
            low = w
        slope = c1 + w * (2.0 * c2 + w * 3.0 * c3)
        step = w - error / slope if slope > 0.0 else low
        new = step if low < step < high else 0.5 * (low + high)
        if abs(new - w) <= tolerance:
            return curves[piece + START] + new
        w = new
    return curves[piece + START] + w


__all__ = ["curve_at", "duty_of", "inverse_at", "pack", "speed_of"]
