"""What the linter says of any system is true: checked by evaluating it where the finding says, and at random."""

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from holodrive.control.fuzzy import Rule, Set, System, Variable
from holodrive.control.fuzzy.lint import CODES, lint
from holodrive.control.fuzzy.shape import Shape, breaks

PLACES = st.integers(0, 20).map(lambda n: n / 2.0)


@st.composite
def straight_sets(draw, name: str) -> Set:
    """Triangles, trapezoids, singletons and polylines, upright sides and all."""
    kind = draw(st.sampled_from(["triangle", "trapezoid", "polyline"]))
    count = {"triangle": 3, "trapezoid": 4, "polyline": 3}[kind]
    params = sorted(draw(st.lists(PLACES, min_size=count, max_size=count)))
    if kind != "polyline" and params[0] == params[-1]:
        params[-1] += 1.0
    if kind == "polyline":
        heights = draw(st.lists(st.sampled_from([0.0, 0.25, 0.5, 1.0]), min_size=3, max_size=3))
        params = [number for pair in zip(params, heights, strict=True) for number in pair]
    return Set(name, kind, tuple(params))


@st.composite
def systems(draw) -> System:
    """Two inputs of two sets, one output of two lone numbers, two to five rules."""
    inputs = tuple(Variable(n, 0.0, 10.0, tuple(draw(straight_sets(s)) for s in "ab")) for n in ("x", "y"))
    out = Variable("z", 0.0, 1.0, (Set("p", "singleton", (0.0,)), Set("q", "singleton", (1.0,))))
    rules = draw(st.lists(
        st.builds(
            Rule,
            st.tuples(st.integers(-2, 2), st.integers(-2, 2)).filter(any),
            st.tuples(st.integers(1, 2)),
            st.sampled_from([1.0, 0.5, 0.0]),
            st.sampled_from(["and", "or"]),
        ),
        min_size=2, max_size=5,
    ))  # fmt: skip
    return System("any", inputs, (out,), tuple(rules))


@given(systems(), st.integers(0, 2**32 - 1))
@settings(max_examples=30)
def test_findings_are_true(system, seed):
    """Silence where it is said and nowhere else; dead and masked rules change nothing; no jump goes untold."""
    rng = np.random.default_rng(seed)
    x = np.vstack([rng.uniform(0.0, 10.0, (300, 2)), rng.integers(0, 21, (300, 2)) / 2.0])
    y = system.evaluate(x)
    found = lint(system)
    assert {one.code for one in found} <= set(CODES)
    silent = [one for one in found if one.code in ("F-GAP", "F-MISSING")]
    if not silent:
        assert not np.isnan(y).any()
    for one in found:
        if one.code == "F-GAP" and one.severity == "error":
            at = x.copy()
            at[:, [v.name for v in system.inputs].index(one.variable)] = one.at
            assert np.isnan(system.evaluate(at)).all()
        if one.code in ("F-DEAD", "F-MASKED"):
            rest = tuple(replace(r, weight=0.0) if i == one.rules[0] else r for i, r in enumerate(system.rules, 1))
            np.testing.assert_array_equal(replace(system, rules=rest).evaluate(x), y)
        if one.code == "F-JUMP":
            assert 0.0 < one.value <= 1.0
    if not any(one.code in ("F-JUMP", "F-GAP", "F-MISSING") for one in found):
        for place in np.arange(0.5, 10.0, 0.5):
            for index in range(2):
                beside = np.repeat(x[:300, None], 2, axis=1)
                beside[..., index] = place + np.array([-1e-9, 1e-9])
                np.testing.assert_allclose(np.ptp(system.evaluate(beside)[..., 0], axis=1), 0.0, atol=1e-5)


@given(straight_sets("s"), st.lists(PLACES, min_size=1, max_size=8))
def test_shapes_are_the_sets(one, places):
    """At a place, and beside it: the kernel's membership is the greater of both limits or a top between them."""
    system = System(
        "one", (Variable("x", -1.0, 12.0, (one,)),),
        (Variable("z", 0.0, 1.0, (Set("p", "singleton", (0.0,)),)),), (Rule((1,), (1,)),),
    )  # fmt: skip
    from holodrive.control.fuzzy.evaluation import strengths

    shape, x = Shape.of(one, -1.0, 12.0), np.array(places)
    np.testing.assert_allclose(shape.at(x), strengths(system, x[:, None])[:, 0], atol=1e-12)
    for side, limit in ((-1e-9, shape.before), (1e-9, shape.after)):
        np.testing.assert_allclose(limit(x), strengths(system, (x + side)[:, None])[:, 0], atol=1e-7)


@given(straight_sets("s"), straight_sets("t"))
def test_between_break_points_sets_are_straight_and_keep_their_order(a, b):
    """The middle is the mean of the limits, and no two curves cross inside."""
    curves = [Shape.of(one, 0.0, 10.0) for one in (a, b)]
    places = breaks(curves, 0.0, 10.0)
    left, right = places[:-1], places[1:]
    for curve in curves:
        mean = 0.5 * (curve.after(left) + curve.before(right))
        np.testing.assert_allclose(curve.at(0.5 * (left + right)), mean, atol=1e-9)
    gap = [
        f - g
        for f, g in ((curves[0].after(left), curves[1].after(left)), (curves[0].before(right), curves[1].before(right)))
    ]
    assert np.all(gap[0] * gap[1] >= -1e-9)


def test_an_input_without_sets_and_a_large_system_are_linted():
    """A Sugeno system whose conclusions read an input that no rule names; nine inputs of five sets."""
    x = Variable("x", 0.0, 1.0, (Set("low", "triangle", (0, 0, 1)), Set("high", "triangle", (0, 1, 1))))
    z = Variable("z", 0.0, 3.0, (Set("a", "linear", (1.0, 2.0, 0.0)), Set("b", "constant", (3.0,))))
    rules = (Rule((1, 0), (1,)), Rule((2, 0), (2,)))
    assert lint(System("line", (x, Variable("y", 0.0, 1.0)), (z,), rules, "sugeno", defuzzification="wtaver")) == ()
    tops = (0.0, 0.25, 0.5, 0.75, 1.0)
    sets = tuple(Set(f"s{i}", "triangle", (max(c - 0.25, 0), c, min(c + 0.25, 1))) for i, c in enumerate(tops))
    inputs = tuple(Variable(f"x{i}", 0.0, 1.0, sets) for i in range(9))
    out = Variable("o", 0.0, 1.0, (Set("p", "singleton", (0.0,)), Set("q", "singleton", (1.0,))))
    rules = tuple(Rule(tuple(1 + (i + k) % 5 for i in range(9)), (1 + k % 2,)) for k in range(5))
    found = lint(System("large", inputs, (out,), rules))
    assert {one.code for one in found} == {"F-LARGE"}


def test_a_gap_that_only_a_grid_of_the_right_step_would_meet_is_found():
    """At an irrational place, of no width."""
    place = math.sqrt(2.0)
    sets = (Set("a", "triangle", (0.0, 0.5, place)), Set("b", "triangle", (place, 2.0, 3.0)))
    x = Variable("x", 0.1, 2.9, sets)
    out = Variable("z", 0.0, 1.0, (Set("p", "singleton", (0.0,)), Set("q", "singleton", (1.0,))))
    found = lint(System("thin", (x,), (out,), (Rule((1,), (1,)), Rule((2,), (2,)))))
    (gap,) = [one for one in found if one.code == "F-GAP"]
    (jump,) = [one for one in found if one.code == "F-JUMP"]
    assert gap.at == jump.at == place
    assert jump.value == pytest.approx(1.0)
