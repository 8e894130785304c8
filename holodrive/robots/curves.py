"""Duty curves of a wheel from what was measured: a printed cubic, or points of a step calibration.

Both give PWM counts over a speed; a `DutyCurve` is duty 0..1 over the wheel's speed in rad/s. Between the two lie the
counts of full duty, the unit of the speed, and `speed_scale`, the rim speed of the wheel over the speed that was
measured (sqrt 2 where the speed is that of a Mecanum base on one of its diagonal pairs).
"""

import math
from collections.abc import Callable, Sequence
from itertools import pairwise

import numpy as np
from numpy.typing import ArrayLike

from holodrive.errors import InputError
from holodrive.robots.spec import DutyCurve
from holodrive.types import Array

FASTEST_RAD_S = 1e5  # as fast as a wheel's speed may be in a file
SLOWEST_RAD_S = 1e-9  # no motor is that slow at its best: the sign of a wrong unit
ROUND_OFF = 1e-9  # of full duty: what a curve may miss of its ends without being wrong
LEAST_END_SLOPE = 0.1  # of the outermost two points' slope: a curve that ended flat could not go on straight


class CurveError(InputError):
    """A curve that is none; `point` is the index of the measured point that is wrong, if it is one of them."""

    def __init__(self, message: str, point: int | None = None) -> None:
        self.point = point
        super().__init__(message)


def from_cubic(
    coefficients: Sequence[float],
    *,
    speed_unit_m_s: float,
    counts: float,
    speed_scale: float,
    radius_m: float,
    top: float | None = None,
) -> DutyCurve:
    """The curve of PWM(v) = c0 + c1 v + c2 v^2 + c3 v^3 (Keek et al., eq. 9 to 12).

    Args:
        coefficients: (4) c0, c1, c2, c3, the constant first, in counts over v in the unit of its source.
        speed_unit_m_s: that unit [m/s]; 0.001 for mm/s.
        counts: PWM counts of full duty.
        speed_scale: rim speed of the wheel over v.
        radius_m: of the wheel.
        top: v where the curve ends; without it where full duty is reached.

    Raises:
        CurveError: when the cubic starts below 0 or above full duty, stops rising before its end, or passes full duty.
    """
    c = [float(value) for value in coefficients]
    if len(c) != 4 or not all(math.isfinite(value) for value in c):
        raise CurveError(f"a cubic has four finite numbers c0, c1, c2, c3, found {len(c)}: {c}")
    rad_s = _wheel_speed(speed_unit_m_s, counts, speed_scale, radius_m)
    _start(c[0], counts)
    end = _top(c, counts, FASTEST_RAD_S / rad_s, top)
    piece = (c[0] / counts, c[1] / counts / rad_s, c[2] / counts / rad_s / rad_s, c[3] / counts / rad_s / rad_s / rad_s)
    return _checked(DutyCurve((0.0, end * rad_s), (piece,)))


def from_points(
    points: ArrayLike,
    *,
    speed_unit_m_s: float,
    counts: float,
    speed_scale: float,
    radius_m: float,
) -> DutyCurve:
    """The curve through measured points, a cubic between each two that never falls (Fritsch and Carlson's PCHIP).

    Args:
        points: (P, 2) of PWM counts and speed, both rising; the first is the end of the dead zone, at speed 0.
        speed_unit_m_s, counts, speed_scale, radius_m: as in `from_cubic`.

    Raises:
        CurveError: when there are fewer than two points, they do not rise, or they leave 0 to full duty.
    """
    pwm, speed = _columns(points)
    if speed[0] != 0.0:
        raise CurveError(f"the first point is the end of the dead zone, at speed 0; its speed is {speed[0]:g}", 0)
    for name, values in (("PWM", pwm), ("speed", speed)):
        falls = np.flatnonzero(~(np.diff(values) > ROUND_OFF * abs(values[-1])))
        if falls.size:
            k = int(falls[0]) + 1
            what = f"the {name} goes from {values[k - 1]:g} to {values[k]:g} at point {k + 1}"
            raise CurveError(f"points must rise; {what}", k)
    rad_s = _wheel_speed(speed_unit_m_s, counts, speed_scale, radius_m)
    _start(float(pwm[0]), counts)
    if pwm[-1] > counts:
        raise CurveError(f"the last point has a PWM of {pwm[-1]:g}, above full duty, {counts:g} counts", len(pwm) - 1)
    knots = speed * rad_s
    if not SLOWEST_RAD_S <= knots[-1] <= FASTEST_RAD_S:
        raise CurveError(f"the last point has a speed of {knots[-1]:g} rad/s, which no wheel has", len(pwm) - 1)
    return _checked(DutyCurve(tuple(map(float, knots)), _monotone_pieces(knots, pwm / counts)))


def from_pieces(knots: Sequence[float], pieces: Sequence[Sequence[float]]) -> DutyCurve:
    """The curve of knots [rad/s] and (K, 4) pieces of duty 0..1, as `DutyCurve` describes them.

    Raises:
        CurveError: see `check`.
    """
    if any(len(piece) != 4 for piece in pieces):
        raise CurveError("a piece has four numbers, the constant first")
    return _checked(DutyCurve(tuple(map(float, knots)), tuple((a, b, c, d) for a, b, c, d in pieces)))


def check(curve: DutyCurve) -> None:
    """Refuse a curve that does not rise everywhere, starts below 0, ends above full duty or has gaps.

    Raises:
        CurveError: with the wheel speed [rad/s] at which it is wrong.
    """
    knots, pieces = curve.knots, curve.pieces
    if len(knots) < 2 or len(pieces) != len(knots) - 1:
        raise CurveError(f"a curve of n pieces has n + 1 knots, found {len(pieces)} pieces and {len(knots)} knots")
    if not all(math.isfinite(value) for row in (knots, *pieces) for value in row):
        raise CurveError("a curve holds finite numbers only")
    if knots[0] != 0.0 or any(b <= a for a, b in pairwise(knots)):
        raise CurveError("the knots of a curve begin at 0 and rise")
    if pieces[0][0] < 0.0:
        raise CurveError(f"a curve starts at a duty of 0 or more, found {pieces[0][0]:g}")
    before = pieces[0][0]
    for (at, after), piece in zip(pairwise(knots), pieces, strict=True):
        if not abs(piece[0] - before) <= ROUND_OFF:
            raise CurveError(f"the curve jumps from a duty of {before:g} to {piece[0]:g} at {at:g} rad/s")
        falls = _falls(piece, after - at)
        if falls is not None:
            raise CurveError(f"the curve stops rising at {at + falls:g} rad/s")
        before = _value(piece, after - at)
    if not before <= 1.0 + ROUND_OFF:
        raise CurveError(f"the curve ends at a duty of {before:g}, above full duty")


def _checked(curve: DutyCurve) -> DutyCurve:
    check(curve)
    return curve


def _columns(points: ArrayLike) -> tuple[Array, Array]:
    try:
        found = np.asarray(points, dtype=np.float64)
    except ValueError:  # numpy's word for rows of different lengths
        found = np.zeros(0)
    if found.ndim != 2 or found.shape[1] != 2 or len(found) < 2 or not np.isfinite(found).all():
        raise CurveError("a curve needs two or more points [pwm, speed] of finite numbers")
    return found[:, 0], found[:, 1]


def _wheel_speed(speed_unit_m_s: float, counts: float, speed_scale: float, radius_m: float) -> float:
    """Wheel speed [rad/s] at speed 1 in the unit of the source."""
    given = {"speed_unit_m_s": speed_unit_m_s, "counts": counts, "speed_scale": speed_scale, "radius_m": radius_m}
    for name, value in given.items():
        if not (math.isfinite(value) and value > 0.0):
            raise CurveError(f"{name} must be above 0, found {value:g}")
    return speed_unit_m_s * speed_scale / radius_m


def _start(pwm: float, counts: float) -> None:
    if pwm < 0.0:
        raise CurveError(f"a curve starts at a PWM of 0 or more, found {pwm:g}")
    if pwm >= counts:
        raise CurveError(f"the dead zone ends at a PWM of {pwm:g}, not below full duty, {counts:g} counts")


def _top(c: Sequence[float], counts: float, fastest: float, top: float | None) -> float:
    """Where the cubic ends, in the unit of its source."""
    falls = _falls(c, math.inf)
    last = fastest if falls is None else min(falls, fastest)
    full = _crossing(lambda v: _value(c, v) - counts, last) if _value(c, last) > counts else None
    if top is None:
        if full is not None:
            return full
        if falls == 0.0:
            raise CurveError("the cubic does not rise at speed 0")
        if falls is None:
            raise CurveError(f"the cubic does not reach full duty, {counts:g} counts, at any speed a wheel may have")
        raise CurveError(
            f"the cubic stops rising at a speed of {falls:.4g} (PWM {_value(c, falls):.4g}), "
            f"before full duty, {counts:g} counts; end it earlier with 'top', or give points"
        )
    if not (math.isfinite(top) and 0.0 < top <= fastest):
        raise CurveError(f"the top speed of a curve must be above 0 and at most {fastest:.4g}, found {top:g}")
    if full is not None and top > full and _value(c, top) > counts * (1.0 + ROUND_OFF):
        raise CurveError(f"the cubic reaches full duty, {counts:g} counts, at a speed of {full:.4g}, below top {top:g}")
    if falls is not None and top >= falls:
        raise CurveError(f"the cubic stops rising at a speed of {falls:.4g}, below top {top:g}")
    return top


def _value(c: Sequence[float], x: float) -> float:
    return c[0] + x * (c[1] + x * (c[2] + x * c[3]))


def _falls(c: Sequence[float], length: float) -> float | None:
    """The first x in [0, length) from which the cubic falls or stays; a slope that only touches 0 does not count."""
    a, b, d = 3.0 * c[3], 2.0 * c[2], c[1]  # slope = d + b x + a x^2
    if d < 0.0 or (d == 0.0 and (b < 0.0 or (b == 0.0 and a <= 0.0))):
        return 0.0
    root = b * b - 4.0 * a * d
    if a == 0.0:
        first = -d / b if b < 0.0 else math.inf
    elif root <= ROUND_OFF * b * b or (a > 0.0 and b >= 0.0):
        return None
    else:
        first = 2.0 * d / (-b + math.sqrt(root)) if b <= 0.0 or a < 0.0 else math.inf
    return first if first < length * (1.0 - ROUND_OFF) else None


def _crossing(excess: Callable[[float], float], high: float) -> float:
    """Where a rising function crosses 0 in (0, high), from below."""
    low = 0.0
    for _ in range(200):
        middle = 0.5 * (low + high)
        if middle in (low, high):
            break
        if excess(middle) > 0.0:
            high = middle
        else:
            low = middle
    return low


def _monotone_pieces(x: Array, y: Array) -> tuple[tuple[float, float, float, float], ...]:
    from scipy.interpolate import CubicHermiteSpline, PchipInterpolator

    slopes = PchipInterpolator(x, y).derivative()(x)
    for end, inner in ((0, 1), (-1, -2)):
        slopes[end] = max(slopes[end], LEAST_END_SLOPE * (y[end] - y[inner]) / (x[end] - x[inner]))
    rows = CubicHermiteSpline(x, y, slopes).c[::-1].T  # (K, 4), the constant first
    return tuple((float(a), float(b), float(c), float(d)) for a, b, c, d in rows)
