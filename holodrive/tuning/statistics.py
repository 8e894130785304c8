"""How sure one can be of a rate, or of a mean, from so many runs."""

import math
from statistics import NormalDist

import numpy as np
from numpy.typing import ArrayLike

from holodrive.errors import InputError

RESAMPLES = 2000


def wilson(successes: int, n: int, confidence: float = 0.95) -> tuple[float, float]:
    """Interval of a rate that was seen `successes` times in `n` (Wilson 1927): never outside 0..1, right at 0 and n.

    Raises:
        InputError: no runs, or more successes than runs.
    """
    if not 0 <= successes <= n or n < 1:
        raise InputError(f"a rate takes n >= 1 runs with 0 to n successes; found {successes} of {n}")
    z = NormalDist().inv_cdf(0.5 + 0.5 * confidence)
    p = successes / n
    middle = p + 0.5 * z * z / n
    half = z * math.sqrt(p * (1.0 - p) / n + 0.25 * (z / n) ** 2)
    low, high = ((middle + sign * half) / (1.0 + z * z / n) for sign in (-1.0, 1.0))
    # what rounding takes at the ends
    return (0.0 if successes == 0 else max(0.0, low)), (1.0 if successes == n else min(1.0, high))


def interval_of_mean(values: ArrayLike, confidence: float = 0.95, seed: int = 0) -> tuple[float, float]:
    """Interval of a mean by the percentile bootstrap (Efron 1979): no assumption about the distribution.

    Args:
        values: (n,), those that are not finite are left out; (NaN, NaN) when none is.
        confidence: share of the resampled means inside.
        seed: of the resampling.
    """
    found = np.asarray(values, dtype=np.float64)
    found = found[np.isfinite(found)]
    if not len(found):
        return math.nan, math.nan
    random = np.random.default_rng(seed)
    means = found[random.integers(0, len(found), (RESAMPLES, len(found)))].mean(axis=1)
    low, high = np.quantile(means, (0.5 - 0.5 * confidence, 0.5 + 0.5 * confidence))
    return float(low), float(high)
