"""Intervals of rates and means."""

import math

import numpy as np
import pytest

from holodrive.errors import InputError
from holodrive.tuning import interval_of_mean, wilson


def test_wilson_solves_its_equation() -> None:
    """Both ends p are where |k/n - p| = z sqrt(p (1 - p) / n): the score test just does not refuse them."""
    for k, n in ((3, 10), (299, 300), (50, 100), (1, 7)):
        for p in wilson(k, n):
            assert abs(k / n - p) == pytest.approx(1.959963984540054 * math.sqrt(p * (1.0 - p) / n), rel=1e-9)


def test_wilson_at_the_ends() -> None:
    """Nothing seen is not never: the interval is one-sided and stays inside 0..1."""
    low, high = wilson(0, 3000)
    assert low == 0.0
    assert high == pytest.approx(3.8415 / 3003.84, rel=1e-3)
    assert wilson(3000, 3000) == (pytest.approx(1.0 - high), 1.0)


def test_wilson_is_symmetric() -> None:
    """Successes and failures change places."""
    low, high = wilson(13, 40)
    assert wilson(27, 40) == pytest.approx((1.0 - high, 1.0 - low))


@pytest.mark.parametrize(("k", "n"), [(1, 0), (-1, 5), (6, 5)])
def test_a_rate_of_nothing_is_refused(k: int, n: int) -> None:
    with pytest.raises(InputError, match="n >= 1"):
        wilson(k, n)


def test_bootstrap_agrees_with_the_normal_interval() -> None:
    """For many well-behaved numbers both are mean +- 1.96 s / sqrt(n)."""
    values = np.random.default_rng(1).normal(5.0, 2.0, 400)
    half = 1.96 * values.std(ddof=1) / 20.0
    assert interval_of_mean(values) == pytest.approx((values.mean() - half, values.mean() + half), abs=0.05)


def test_bootstrap_of_nothing_is_unknown() -> None:
    """What is not finite does not count."""
    assert all(map(math.isnan, interval_of_mean([math.nan, math.inf])))
    assert interval_of_mean([2.0, math.nan]) == (2.0, 2.0)
