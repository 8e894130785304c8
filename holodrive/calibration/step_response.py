"""What one step tells: whether it moved, when it began to, and how fast it went in the end.

Two speeds are given. Equation 8 of Keek et al. is the mean speed from the start of motion to the end of the step; it
takes the wheels' lag for slowness. The slope of the tail, a straight line through the second half of the motion, does
not; the linearizer is fitted to the tail.
"""

import math
from dataclasses import dataclass

import numpy as np

from holodrive.calibration.step_record import StepRecord
from holodrive.types import Array

STARTED_COUNTS, MOVED_COUNTS = 1.5, 3.0  # of the sensor: motion has begun; the step has moved at all
TAIL_FROM = 0.5  # of the time in motion
TAIL_SAMPLES, SETTLED = 4, 0.05  # least samples of a tail; largest change of slope within one that has settled
_LAGS = 49  # time constants that are tried


@dataclass(frozen=True)
class Step:
    """A step, analysed.

    Attributes:
        record: what it was.
        moved: it left its place by more than three counts of the sensor.
        start_s: last sample that had not moved, on the record's clock [s]; NaN for a step that did not move.
        dead_time_s: from the command to the start of motion [s], between samples, by the response of a first-order
            lag that ends in the tail.
        lag_s: time constant of that response [s].
        speed_eq8_m_s: (|x_f| + |y_f|) / (sqrt 2 (t_f - t_s)), eq. 8 in closed form [m/s].
        speed_tail_m_s: slope of the tail [m/s]; NaN where motion was too short for one.
        spread_m_s: standard error of the tail's slope [m/s].
        settled: the slope does not change within the tail, beyond noise.
        unseen_m_s: how fast a step that has not moved may have been [m/s]: three counts over its length.
    """

    record: StepRecord
    moved: bool
    start_s: float = math.nan
    dead_time_s: float = math.nan
    lag_s: float = math.nan
    speed_eq8_m_s: float = 0.0
    speed_tail_m_s: float = 0.0
    spread_m_s: float = 0.0
    settled: bool = True
    unseen_m_s: float = 0.0


def speed_eq8(x_f: float, y_f: float, duration_s: float) -> float:
    """Equation 8 in closed form, (|x_f| + |y_f|) / (sqrt 2 duration) [m/s]; equal to the printed one, without its 0/0.

    Args:
        x_f, y_f: final displacement [m].
        duration_s: t_f - t_s.
    """
    return (abs(x_f) + abs(y_f)) / (math.sqrt(2.0) * duration_s)


def analyse(record: StepRecord, resolution_m: float = 1e-5) -> Step:
    """What a step tells.

    Args:
        record: of at least two samples.
        resolution_m: one count of the sensor that measured it.
    """
    travel, time = record.travel(), record.time
    if not travel[-1] > MOVED_COUNTS * resolution_m:
        return Step(record, False, unseen_m_s=MOVED_COUNTS * resolution_m / float(time[-1] - time[0]))
    still = np.flatnonzero(travel <= STARTED_COUNTS * resolution_m)
    last_still = int(still[-1]) if len(still) else 0
    last_still = min(last_still, len(time) - 2)
    start, end = float(time[last_still]), float(time[-1])
    mean = float(travel[-1]) / (end - start)  # travel ends in the path of eq. 8, see `StepRecord.travel`
    tail = time >= start + TAIL_FROM * (end - start)
    if np.count_nonzero(tail) < TAIL_SAMPLES:
        return Step(record, True, start, start - record.command_time, math.nan, mean, math.nan, math.nan, False)
    speed, reach, spread = _line(time[tail], travel[tail], resolution_m)
    # whole counts are told, so the one under way is not seen: the travel is half a count short on average
    reach -= record.command_time + 0.5 * resolution_m / max(speed, resolution_m)
    lag, began = _response(time - record.command_time, travel, speed, reach, resolution_m)
    first, last = (_line(t, d, resolution_m)[0] for t, d in _halves(time[tail], travel[tail]))
    slack = SETTLED * speed + 6.0 * resolution_m / (end - start) + 6.0 * spread
    return Step(record, True, start, began, lag, mean, speed, spread, abs(last - first) <= slack)


def _line(time: Array, travel: Array, resolution_m: float) -> tuple[float, float, float]:
    """Slope [m/s] of a straight line, the time at which it starts from 0 [s], standard error of the slope [m/s].

    The error is that of noise in the speed, which adds up in the travel as a random walk, and of whole counts, which
    does not; a speed that changes steadily is no noise.
    """
    t, d = time - time.mean(), travel - travel.mean()
    slope = float(t @ d / (t @ t))
    if not slope > 0.0:
        return slope, float(time[0]), 0.0
    period = np.diff(time)
    speeds, middle = np.diff(travel) / period, 0.5 * (t[1:] + t[:-1])
    speeds = speeds - slope - middle * float(middle @ (speeds - slope) / max(middle @ middle, 1e-12))
    walk = max(0.0, float(np.mean(speeds**2)) - float(np.mean(resolution_m**2 / (6.0 * period**2))))
    counting = resolution_m**2 / (float(np.ptp(time)) ** 2 * len(time))
    return slope, float(time.mean() - travel.mean() / slope), math.sqrt(walk / len(speeds) + counting)


def _halves(time: Array, travel: Array) -> tuple[tuple[Array, Array], tuple[Array, Array]]:
    half = len(time) // 2
    return (time[: half + 1], travel[: half + 1]), (time[half:], travel[half:])


def _response(time: Array, travel: Array, speed: float, reach: float, resolution_m: float) -> tuple[float, float]:
    """Lag and start [s] of travel = v ((t - t_0) - lag (1 - exp(-(t - t_0) / lag))), t > t_0, that ends in the tail.

    The tail is v (t - t_0 - lag), so that t_0 + lag = `reach` is known and one number is left to find.

    Args:
        time: (N,) since the command.
        travel: (N,) [m].
        speed: v [m/s].
        reach: where the tail starts from 0, since the command.
        resolution_m: of the sensor; it tells whole counts.
    """
    low, high = 0.0, min(max(reach, 0.0), 0.5 * float(time[-1]))
    for _ in range(3):
        lags = np.linspace(low, high, _LAGS)
        errors = _misfit(time, travel, speed, reach, lags, resolution_m)
        best = int(np.argmin(errors))
        low, high = float(lags[max(best - 1, 0)]), float(lags[min(best + 1, _LAGS - 1)])
    lag = float(lags[best])
    return lag, max(0.0, reach - lag)


def _misfit(time: Array, travel: Array, speed: float, reach: float, lags: Array, resolution_m: float) -> Array:
    """(L,) sum of squares of what is measured minus the responses of all `lags`."""
    since = np.maximum(time[None, :] - (reach - lags)[:, None], 0.0)  # (L, N)
    share = np.exp(-since / np.maximum(lags, 1e-9)[:, None])
    model = speed * (since - lags[:, None] * (1.0 - share))
    model = np.maximum(model - 0.5 * resolution_m, 0.0)
    return np.asarray(np.sum((travel[None, :] - model) ** 2, axis=1))


__all__ = ["Step", "analyse", "speed_eq8"]
