"""Laws that hold for every fuzzy system, whatever its numbers are."""

import math
import pickle
import subprocess
import sys
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from random_systems import mamdani, with_input

from holodrive.control import fuzzy
from holodrive.control.fuzzy import Rule, Set, System, Variable, kernel, packing
from holodrive.control.fuzzy.evaluation import aggregated, evaluate, strengths

MILLIMETRES = st.floats(-100.0, 3000.0)
TRIPLES = st.tuples(MILLIMETRES, MILLIMETRES, MILLIMETRES)
PROFILES = st.sampled_from(fuzzy.names())


def equal(a, b, atol=1e-9):
    np.testing.assert_allclose(a, b, rtol=0.0, atol=atol)


def scaled_set(one, factor, shift):
    """The set with its places multiplied and moved."""
    if one.kind == "polyline":
        params = tuple(v if k % 2 else factor * v + shift for k, v in enumerate(one.params))
    elif one.kind == "gaussian":
        params = (factor * one.params[0] + shift, factor * one.params[1])
    elif one.kind == "bell":
        params = (factor * one.params[0], one.params[1], factor * one.params[2] + shift)
    else:
        params = tuple(factor * v + shift for v in one.params)
    return replace(one, params=params)


def scaled(variable, factor, shift):
    sets = tuple(scaled_set(one, factor, shift) for one in variable.sets)
    return replace(variable, low=factor * variable.low + shift, high=factor * variable.high + shift, sets=sets)


@given(with_input(mamdani()), st.randoms(use_true_random=False))
def test_the_order_of_rules_does_not_matter(case, random):
    system, x = case
    rules = list(system.rules)
    random.shuffle(rules)
    out = evaluate(system, x)
    equal(evaluate(replace(system, rules=tuple(rules)), x), out, atol=1e-7)


@pytest.mark.parametrize("method", ["centroid", "bisector", "mom", "som", "lom"])
def test_how_faintly_rules_fire_changes_nothing_where_they_scale(method):
    """Down to where numbers end: squares of such heights are 0."""
    system = replace(fuzzy.load("repaired"), implication="prod", defuzzification=method)
    faint = replace(system, rules=tuple(replace(rule, weight=1e-250) for rule in system.rules))
    x = np.random.default_rng(5).uniform(0.0, 2500.0, (200, 3))
    equal(evaluate(faint, x), evaluate(system, x))


@given(with_input(mamdani()))
def test_other_units_give_the_same_behaviour(case):
    """Inputs times 0.5 and moved, outputs times 4: outputs come out four times as large."""
    system, x = case
    other = replace(
        system,
        inputs=tuple(scaled(one, 0.5, 8.0) for one in system.inputs),
        outputs=tuple(scaled(one, 4.0, 0.0) for one in system.outputs),
    )
    equal(evaluate(other, 0.5 * np.array(x) + 8.0), 4.0 * evaluate(system, x), atol=1e-6)


@given(with_input(mamdani()))
def test_clamping_is_the_same_as_clamped_inputs(case):
    """And clamping twice changes nothing."""
    system, x = case
    inside = np.clip(x, [one.low for one in system.inputs], [one.high for one in system.inputs])
    np.testing.assert_array_equal(evaluate(system, x), evaluate(system, inside, clamp=False))
    np.testing.assert_array_equal(evaluate(system, x), evaluate(system, inside))
    np.testing.assert_array_equal(strengths(system, x), strengths(system, inside, clamp=False))


@given(with_input(mamdani()))
def test_outputs_lie_within_the_sets_that_speak(case):
    """In the hull of what the aggregate covers, and so in the universe."""
    system, x = case
    out = evaluate(system, x)
    for k, variable in enumerate(system.outputs):
        u, mu = aggregated(system, x, k)
        if math.isnan(out[k]):
            assert not np.any(mu > 0.0)
        else:
            covered = np.flatnonzero(mu > 0.0)
            slack = 1e-9 * (variable.high - variable.low)
            assert u[max(covered[0] - 1, 0)] - slack <= out[k] <= u[min(covered[-1] + 1, len(u) - 1)] + slack


@given(PROFILES, TRIPLES)
def test_the_paper_s_outputs_lie_between_the_centroids_of_outermost_sets(name, x):
    """Section 3 of the study of the paper: +-300 cannot be reached; a cut set's centroid may pass a full one's."""
    out = fuzzy.load(name).evaluate(x)
    assert np.all(np.isnan(out) | (np.abs(out) <= 237.6))


@given(with_input(mamdani()))
def test_a_silent_rule_changes_nothing(case):
    """Of weight 0."""
    system, x = case
    more = Rule(system.rules[0].inputs, tuple(1 for _ in system.outputs), weight=0.0)
    np.testing.assert_array_equal(evaluate(replace(system, rules=(*system.rules, more)), x), evaluate(system, x))


@given(with_input(mamdani()))
def test_a_rule_said_twice_changes_nothing_under_the_maximum(case):
    system, x = case
    system = replace(system, aggregation="max")
    twice = replace(system, rules=(*system.rules, system.rules[0]))
    np.testing.assert_array_equal(evaluate(twice, x), evaluate(system, x))


@pytest.mark.parametrize("name", fuzzy.names())
def test_a_batch_gives_what_single_calls_give(name):
    """Bit for bit, for any shape, more rows than one thread takes, lists and strided arrays."""
    system = fuzzy.load(name)
    x = np.random.default_rng(0).uniform(-100.0, 3000.0, (4500, 3))
    out = system.evaluate(x)
    np.testing.assert_array_equal(out[::100], [system.evaluate(row) for row in x[::100]])
    np.testing.assert_array_equal(out[:8].reshape(2, 4, 2), system.evaluate(x[:8].reshape(2, 4, 3)))
    np.testing.assert_array_equal(out[0], system.evaluate(x[0].tolist()))
    np.testing.assert_array_equal(out[:5], system.evaluate(np.asfortranarray(x[:5])))
    np.testing.assert_array_equal(out[0], system.evaluate(np.stack([x[0], x[0]], axis=1)[:, 0]))
    assert system.evaluate(np.empty((0, 3))).shape == (0, 2)
    np.testing.assert_array_equal(strengths(system, x[:5])[3], strengths(system, x[3]))


@given(PROFILES, TRIPLES, st.integers(0, 2))
def test_nan_in_gives_nan_out(name, x, place):
    """In all outputs and all strengths, even when another input alone would decide."""
    system, x = fuzzy.load(name), list(x)
    x[place] = math.nan
    assert np.isnan(system.evaluate(x)).all()
    assert np.isnan(strengths(system, x)).all()


def test_infinite_inputs_are_the_ends_of_the_universe():
    """A lidar that sees nothing may say infinity; unclamped, nothing is heard that far away."""
    system = fuzzy.load("repaired")
    np.testing.assert_array_equal(system.evaluate([math.inf, -math.inf, 900.0]), system.evaluate([2500, 0, 900]))
    assert np.isnan(system.evaluate([math.inf, 900.0, 900.0], clamp=False)).all()


@given(TRIPLES, st.sampled_from(fuzzy.names()))
def test_the_kernel_writes_only_its_outputs_and_scratch(x, name):
    """As `packing.work_size` says, and whatever the scratch holds before."""
    system = fuzzy.load(name)
    spec, x = system.packed, np.array(x)
    work = np.full(packing.work_size(spec) + 1, math.nan)
    out = np.full(3, 7.0)
    kernel.evaluate_into(spec, x, 1.0, out, work[:-1])
    np.testing.assert_array_equal(out[:2], system.evaluate(x))
    assert out[2] == 7.0
    assert math.isnan(work[-1])


@given(mamdani())
def test_scratch_is_never_too_small(system):
    """Everything fires everywhere: the most parts and points that a cell can have."""
    always = tuple(replace(one, inputs=(-1, *one.inputs[1:]), connective="or", weight=1.0) for one in system.rules)
    system = replace(system, rules=always)
    size = packing.work_size(system.packed)
    work, out = np.zeros(size + 50), np.zeros(len(system.outputs))
    work[size:] = 7.0
    kernel.evaluate_into(system.packed, np.array([one.low for one in system.inputs]), 0.0, out, work)
    assert (work[size:] == 7.0).all()


def test_systems_are_values():
    """Copies that differ in one field keep nothing of the old one, packed or not; they go through pickle."""
    system = fuzzy.load("repaired")
    before = system.evaluate([300, 2000, 400])
    assert not np.allclose(replace(system, defuzzification="mom").evaluate([300, 2000, 400]), before)
    assert pickle.loads(pickle.dumps(system)) == system
    np.testing.assert_array_equal(pickle.loads(pickle.dumps(system)).evaluate([300, 2000, 400]), before)
    with pytest.raises(ValueError, match="read-only"):
        system.packed[0] = 1.0


def test_describing_a_system_needs_no_numba():
    """Files can be read and checked without waiting for a compiler."""
    code = "import sys; from holodrive.control import fuzzy; fuzzy.load('tuned'); assert 'numba' not in sys.modules"
    subprocess.run([sys.executable, "-c", code], check=True, timeout=60)


@pytest.mark.parametrize(("method", "expected"), [("som", 1.5), ("mom", 2.25), ("lom", 3.0)])
def test_maxima_are_the_edges_and_the_middle_of_the_level_top(method, expected):
    """A triangle 0, 3, 4 cut at one half is level from 1.5 to 3.5; the universe ends at 3."""
    one = Variable("x", 0.0, 1.0, (Set("half", "polyline", (0, 0.5, 1, 0.5)),))
    out = Variable("y", 0.0, 3.0, (Set("s", "triangle", (0, 3, 4)),))
    system = System("s", (one,), (out,), (Rule((1,), (1,)),), defuzzification=method)
    assert system.evaluate([0.3])[0] == pytest.approx(expected, abs=1e-12)


def test_a_set_outside_the_universe_says_nothing():
    """Its rule fires and still there is nothing to take the centroid of."""
    one = Variable("x", 0.0, 1.0, (Set("all", "trapezoid", (0, 0, 1, 1)),))
    out = Variable("y", 0.0, 1.0, (Set("far", "triangle", (1, 2, 3)),))
    assert math.isnan(System("s", (one,), (out,), (Rule((1,), (1,)),)).evaluate([0.3])[0])


@pytest.mark.parametrize("aggregation", ["max", "sum"])
@pytest.mark.parametrize("height", [1e-3, 1e-9, 1e-14, 1e-100])
def test_a_set_cut_very_low_is_a_thin_slab_between_its_feet(height, aggregation):
    """Its centroid is half-way between them; nothing is lost to rounding next to the right foot."""
    one = Variable("x", 0.0, 1.0, (Set("all", "trapezoid", (0, 0, 1, 1)),))
    out = Variable("y", 0.0, 8.0, (Set("s", "triangle", (1, 5, 7)),))
    system = System("s", (one,), (out,), (Rule((1,), (1,), weight=height),), aggregation=aggregation)
    assert system.evaluate([0.5])[0] == pytest.approx(4.0, abs=2.0 * height + 1e-12)
