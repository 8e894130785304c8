"""The curve of one group in one direction: PWM over speed, from the steps that moved.

First the paper's: a cubic by least squares, PWM(v) = c0 + c1 v + c2 v^2 + c3 v^3 (Keek et al., eq. 9 to 12). What is
used is the same cubic with two changes. Its residuals count as speed, not as PWM, because a speed is what somebody
will command; and its offset c0 lies where the dead zone was seen to end, so that small speeds come out right (the
paper tunes it by hand). Where no cubic rises or none fits, the curve is a monotone interpolant of the measured points.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np

from holodrive.calibration.step_response import Step
from holodrive.errors import InputError
from holodrive.types import Array

Method = Literal["cubic", "points"]
Cubic = tuple[float, float, float, float]  # constant first
FEWEST = 4  # different PWM values that a cubic takes
MISFIT = 0.01  # of the top speed: a cubic that misses a measured speed by more fits no better than the points do
_NOISE = 4.0  # standard errors that a measured speed may be off before the cubic is blamed
_MM = 1e-3  # m in the unit of the file's speeds
_ROUNDS = 8
_SLOPE_FLOOR = 0.05  # counts per mm/s: a curve that runs flat must not get infinite weight


@dataclass(frozen=True)
class CurveFit:
    """One group in one direction.

    Attributes:
        group, direction: whose curve.
        pwm, speed_m_s: (P,) the moving steps, by PWM, and the slope of their tails.
        speed_eq8_m_s: (P,) the same steps by eq. 8.
        last_still, first_moving: PWM values between which the dead zone ends; `last_still` is 0 when none was still.
        printed: (4,) c0 to c3 of the plain least squares, in counts over mm/s.
        r2: share of the variance of PWM that it explains.
        printed_monotone: it rises from 0 to the top speed.
        method: what `curve` is: "cubic" or "points".
        cubic: (4,) the trimmed cubic, in counts over mm/s; used where `method` says so.
        points: (K, 2) PWM and speed in mm/s of the monotone interpolant, the end of the dead zone first.
        dead_zone: PWM at which motion begins, by the curve that is used.
        top_m_s: speed at the largest PWM that was measured, by the curve that is used.
        max_error_m_s: largest distance of a measured speed from the curve that is used.
        dead_time_s: median over the steps faster than a fifth of the top speed; NaN when not seen.
        lag_s: the same for the time constant.
        unsettled: PWM values whose steps were too short to reach a steady speed.
    """

    group: str
    direction: str
    pwm: Array
    speed_m_s: Array
    speed_eq8_m_s: Array
    last_still: float
    first_moving: float
    printed: Cubic
    r2: float
    printed_monotone: bool
    method: Method
    cubic: Cubic
    points: Array
    dead_zone: float
    top_m_s: float
    max_error_m_s: float
    dead_time_s: float
    lag_s: float
    unsettled: tuple[float, ...]


def fit(steps: Sequence[Step], counts: float = 255.0) -> CurveFit:
    """The curve of all steps of one group and direction.

    Args:
        steps: of `analyse`; those that did not move tell where the dead zone is.
        counts: of full duty.

    Raises:
        InputError: fewer than four PWM values that moved.
    """
    group, direction = steps[0].record.group, steps[0].record.direction
    moving = [s for s in steps if s.moved and math.isfinite(s.speed_tail_m_s) and s.speed_tail_m_s > 0.0]
    moving.sort(key=lambda s: s.record.pwm)
    pwm = np.array([s.record.pwm for s in moving])
    if len(np.unique(pwm)) < FEWEST:
        raise InputError(
            f"{group} {direction} has {len(np.unique(pwm))} PWM values that move the robot for long enough; "
            f"a cubic takes at least {FEWEST}, better 10: add steps between the dead zone and full PWM"
        )
    speed = np.array([s.speed_tail_m_s for s in moving])
    v, noise = speed / _MM, np.array([s.spread_m_s for s in moving]) / _MM
    first = min(s.record.pwm for s in steps if s.moved)
    # a step that stood although a weaker one moved tells nothing of the dead zone
    still = [s for s in steps if not s.moved and s.record.pwm < first]
    last = max((s.record.pwm for s in still), default=0.0)
    unseen = max((s.unseen_m_s for s in still if s.record.pwm == last), default=0.0) / _MM
    printed = cubic_of(v, pwm)
    top = float(v.max())
    cubic = trimmed(v, pwm, noise, printed, last, first, unseen)
    points = monotone_points(pwm, v, last, first, counts)
    method: Method = "cubic" if _fits(cubic, pwm, v, noise, top) else "points"
    found = _speeds(cubic, pwm, 1.2 * top) if method == "cubic" else np.interp(pwm, points[:, 0], points[:, 1])
    fast = [s for s in moving if s.speed_tail_m_s >= 0.2 * _MM * top]
    return CurveFit(
        group,
        direction,
        pwm,
        speed,
        np.array([s.speed_eq8_m_s for s in moving]),
        last,
        first,
        printed,
        _r2(printed, v, pwm),
        rises(printed, top),
        method,
        cubic,
        points,
        cubic[0] if method == "cubic" else float(points[0, 0]),
        _MM * (float(_speeds(cubic, pwm[-1:], 1.2 * top)[0]) if method == "cubic" else float(points[-1, 1])),
        _MM * float(np.max(np.abs(found - v))),
        float(np.median([s.dead_time_s for s in fast])),
        float(np.median([s.lag_s for s in fast])),
        tuple(s.record.pwm for s in moving if not s.settled),
    )


def cubic_of(v: Array, pwm: Array, weights: Array | None = None, offset: float | None = None) -> Cubic:
    """(4,) c0 to c3 by least squares of PWM over v.

    Args:
        v: (P,) speeds; pwm: (P,) counts.
        weights: (P,) of the residuals; all alike when None.
        offset: c0, where it is known.
    """
    w = np.ones_like(v) if weights is None else weights
    scale = float(v.max())  # powers of a number near 1 keep the equations well conditioned
    powers = np.vander(v / scale, 4, increasing=True)
    if offset is None:
        c = np.linalg.lstsq(w[:, None] * powers, w * pwm, rcond=None)[0]
    else:
        rest = np.linalg.lstsq(w[:, None] * powers[:, 1:], w * (pwm - offset), rcond=None)[0]
        c = np.array([offset, *rest])
    c0, c1, c2, c3 = (float(value) / scale**j for j, value in enumerate(c))
    return c0, c1, c2, c3


def trimmed(
    v: Array, pwm: Array, noise: Array, start: Cubic, last_still: float, first_moving: float, unseen: float = 0.0
) -> Cubic:
    """(4,) the cubic whose residuals count as speed, with its offset between the last still and the first moving PWM.

    Args:
        v: (P,) speeds [mm/s]; pwm: (P,) counts; noise: (P,) standard error of each speed [mm/s].
        start: the plain least squares, to begin with.
        last_still, first_moving: PWM values.
        unseen: speed that the last still step may have had without being seen [mm/s].
    """
    top = float(v.max())
    # never surer of one speed than of a thousandth of the range: noise is itself only estimated
    sigma = np.hypot(noise, 1e-3 * top)
    c = start
    for _ in range(_ROUNDS):
        slope = np.maximum(c[1] + v * (2.0 * c[2] + v * 3.0 * c[3]), _SLOPE_FLOOR)
        weights = 1.0 / (slope * sigma)
        free = cubic_of(v, pwm, weights)
        least = max(0.0, last_still - max(free[1], 0.0) * unseen)
        offset = min(max(free[0], least), first_moving)
        c = free if offset == free[0] else cubic_of(v, pwm, weights, offset)
    return c


def monotone_points(pwm: Array, v: Array, last_still: float, first_moving: float, counts: float) -> Array:
    """(K, 2) PWM and speed that rise strictly, the end of the dead zone at speed 0 first.

    Where a speed falls with PWM, neighbours are pooled to their mean (isotonic regression).

    Args:
        pwm, v: (P,) by PWM.
        last_still, first_moving: between which the dead zone ends.
        counts: of full duty.
    """
    level, first = np.unique(pwm, return_index=True)
    share = np.diff([*first, len(pwm)])
    mean = np.add.reduceat(v, first) / share
    pooled = _pooled(level, mean, share.astype(np.float64))
    keep = [pooled[0]]
    for row in pooled[1:]:
        if row[1] > keep[-1][1] + 1e-6 * mean.max():
            keep.append(row)
    slope = (keep[1][0] - keep[0][0]) / (keep[1][1] - keep[0][1]) if len(keep) > 1 else 0.0
    dead = min(max(keep[0][0] - slope * keep[0][1], last_still, 0.0), np.nextafter(keep[0][0], 0.0))
    dead = dead if dead < first_moving else 0.5 * (last_still + first_moving)
    rows = [(float(dead), 0.0), *keep]
    return np.array([row for row in rows if row[0] <= counts])


def rises(c: Cubic, top: float) -> bool:
    """Whether a cubic rises everywhere from 0 to `top`."""
    a, b, d = 3.0 * c[3], 2.0 * c[2], c[1]
    places = [0.0, top]
    if a != 0.0 and 0.0 < -b / (2.0 * a) < top:
        places.append(-b / (2.0 * a))
    return all(d + x * (b + x * a) > 0.0 for x in places)


def _fits(c: Cubic, pwm: Array, v: Array, noise: Array, top: float) -> bool:
    if not rises(c, top) or c[0] < 0.0:
        return False
    allowed = np.maximum(MISFIT * top, _NOISE * noise)
    return bool(np.all(np.abs(_speeds(c, pwm, 1.2 * top) - v) <= allowed))


def _speeds(c: Cubic, pwm: Array, top: float) -> Array:
    """(P,) speeds in mm/s at which a cubic that rises up to `top` has these PWM values."""
    low, high = np.zeros_like(pwm), np.full_like(pwm, top)
    for _ in range(60):
        middle = 0.5 * (low + high)
        above = c[0] + middle * (c[1] + middle * (c[2] + middle * c[3])) > pwm
        low, high = np.where(above, low, middle), np.where(above, middle, high)
    return np.asarray(0.5 * (low + high))


def _r2(c: Cubic, v: Array, pwm: Array) -> float:
    left = pwm - (c[0] + v * (c[1] + v * (c[2] + v * c[3])))
    return float(1.0 - left @ left / np.sum((pwm - pwm.mean()) ** 2))


def _pooled(level: Array, mean: Array, weight: Array) -> list[tuple[float, float]]:
    """Pool adjacent violators: blocks of (weight, sum of PWM, sum of speed) until the means rise."""
    blocks: list[list[float]] = []
    for x, y, w in zip(level.tolist(), mean.tolist(), weight.tolist(), strict=True):
        blocks.append([w, w * x, w * y])
        while len(blocks) > 1 and blocks[-2][2] / blocks[-2][0] >= blocks[-1][2] / blocks[-1][0]:
            last = blocks.pop()
            blocks[-1] = [a + b for a, b in zip(blocks[-1], last, strict=True)]
    return [(x / w, y / w) for w, x, y in blocks]


__all__ = ["CurveFit", "Method", "cubic_of", "fit", "monotone_points", "rises", "trimmed"]
