"""Conclusions that are no areas: Sugeno functions of order 0 and 1, and singletons."""

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from holodrive.control.fuzzy import Rule, Set, System, Variable
from holodrive.control.fuzzy.evaluation import aggregated

UNIT = st.floats(0.0, 1.0)
INPUTS = tuple(
    Variable(name, 0.0, 1.0, (Set("low", "triangle", (0, 0, 1)), Set("high", "triangle", (0, 1, 1)))) for name in "ab"
)
GRID = [(1, 1), (1, 2), (2, 1), (2, 2)]


def sugeno(sets, outputs=(1, 2, 3, 4), **how):
    variable = Variable("z", -10.0, 10.0, tuple(sets))
    rules = tuple(Rule(pair, (number,)) for pair, number in zip(GRID, outputs, strict=True))
    how = {"conjunction": "prod", "defuzzification": "wtaver"} | how
    return System("s", INPUTS, (variable,), rules, kind="sugeno", **how)


def constants(*values):
    return [Set(f"c{k}", "constant", (value,)) for k, value in enumerate(values)]


@given(UNIT, UNIT, st.sampled_from(["wtaver", "wtsum"]))
def test_one_linear_conclusion_gives_the_linear_function(a, b, method):
    """Order 1, all rules alike: 2 a - 3 b + 4, whatever fires; the strengths of a Ruspini grid sum to 1."""
    system = sugeno([Set("f", "linear", (2.0, -3.0, 4.0))], (1, 1, 1, 1), defuzzification=method)
    assert system.evaluate([a, b])[0] == pytest.approx(2.0 * a - 3.0 * b + 4.0, abs=1e-12)


@given(UNIT, UNIT)
def test_order_0_on_a_product_grid_interpolates_bilinearly(a, b):
    """The corner values are met exactly."""
    out = sugeno(constants(1.0, 5.0, -2.0, 8.0)).evaluate([a, b])[0]
    expected = (1 - a) * ((1 - b) * 1.0 + b * 5.0) + a * ((1 - b) * -2.0 + b * 8.0)
    assert out == pytest.approx(expected, abs=1e-12)


@given(UNIT, UNIT)
def test_the_mean_lies_between_the_conclusions_and_the_sum_is_mean_times_strength(a, b):
    system = sugeno(constants(1.0, 5.0, -2.0, 8.0), conjunction="min")
    mean = system.evaluate([a, b])[0]
    total = replace(system, defuzzification="wtsum").evaluate([a, b])[0]
    places, weights = aggregated(system, [a, b], 0)
    assert places.min() - 1e-12 <= mean <= places.max() + 1e-12
    assert total == pytest.approx(mean * weights.sum(), abs=1e-12)


def test_no_rule_gives_nan_even_for_the_sum():
    """Where MATLAB says 0, which is a command like any other."""
    system = sugeno(constants(1.0, 2.0, 3.0, 4.0), defuzzification="wtsum")
    assert math.isnan(system.evaluate([2.0, 0.5], clamp=False)[0])


def singletons(*places, method="centroid", aggregation="max"):
    variable = Variable("z", -10.0, 10.0, tuple(Set(f"s{k}", "singleton", (place,)) for k, place in enumerate(places)))
    rules = tuple(Rule(pair, (number,)) for pair, number in zip(GRID, (1, 2, 3, 3), strict=True))
    return System("s", INPUTS, (variable,), rules, defuzzification=method, aggregation=aggregation)


def test_singletons_are_weighed_by_their_heights():
    """At (0.2, 0.3) the rules fire with 0.7, 0.3, 0.2, 0.2; the last two name the same set."""
    x = [0.2, 0.3]
    assert singletons(-4.0, 1.0, 6.0).evaluate(x)[0] == pytest.approx((0.7 * -4 + 0.3 * 1 + 0.2 * 6) / 1.2)
    added = singletons(-4.0, 1.0, 6.0, aggregation="sum").evaluate(x)[0]
    assert added == pytest.approx((0.7 * -4 + 0.3 * 1 + 0.4 * 6) / 1.4)
    assert singletons(-4.0, 1.0, 6.0, method="bisector").evaluate(x)[0] == -4.0
    for method, expected in (("mom", 3.5), ("som", 1.0), ("lom", 6.0)):
        # at (0.5, 0.5) all fire alike; the first at 1, the second at 6, the third between
        assert singletons(1.0, 6.0, 3.5, method=method).evaluate([0.5, 0.5])[0] == expected
    u, mu = aggregated(singletons(6.0, 1.0, -4.0), x, 0)
    np.testing.assert_allclose(u, [-4.0, 1.0, 6.0])
    np.testing.assert_allclose(mu, [0.2, 0.3, 0.7])


@pytest.mark.parametrize(("method", "expected"), [("mom", 2.5), ("som", 1.0), ("lom", 4.0)])
def test_singletons_that_differ_by_rounding_only_are_equally_high(method, expected):
    system = singletons(1.0, 4.0, 9.0, method=method)
    weights = (0.3, 0.1 + 0.2, 0.0, 0.0)  # the second is the next number above 0.3
    rules = tuple(replace(rule, weight=weight) for rule, weight in zip(system.rules, weights, strict=True))
    assert replace(system, rules=rules).evaluate([0.5, 0.5])[0] == expected
