"""What cannot be is refused with one clear line."""

from dataclasses import replace

import numpy as np
import pytest

from holodrive.control import fuzzy
from holodrive.control.fuzzy import Rule, Set, System, Variable
from holodrive.control.fuzzy.evaluation import aggregated, membership
from holodrive.errors import InputError, UnknownName

WIDE = Variable("x", 0.0, 1.0, (Set("all", "trapezoid", (0, 0, 1, 1)),))


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda: Set("a", "triangle", (0, 1)), "takes 3"),
        (lambda: Set("a", "triangle", (0, 2, 1)), "must not fall"),
        (lambda: Set("a", "trapezoid", (0, 1, 2, float("nan"))), "finite"),
        (lambda: Set("a", "trapezoid", (1, 1, 1, 1)), "singleton"),
        (lambda: Set("a", "gaussian", (0, 0)), "above 0"),
        (lambda: Set("a", "polyline", (0, 0, 1)), "pairs"),
        (lambda: Set("a", "polyline", (0, 0, 1, 2)), "0..1"),
        (lambda: Set("a", "cosine", (1,)), "no kind of fuzzy set"),
        (lambda: Variable("x", 1.0, float("nan")), "finite and rise"),
        (lambda: Variable("x", 0.0, 1.0, (*WIDE.sets, *WIDE.sets)), "twice"),
        (lambda: System("s", (WIDE,), (WIDE,), (Rule((2,), (1,)),)), "rule 1 names set 2"),
        (lambda: System("s", (WIDE,), (WIDE,), (Rule((1, 1), (1,)),)), "names 2 inputs"),
        (lambda: System("s", (WIDE,), (WIDE,), (Rule((1,), (-1,)),)), "rule 1 names set -1"),
        (lambda: System("s", (WIDE,), (WIDE,), (Rule((0,), (1,)),)), "no condition"),
        (lambda: System("s", (WIDE,), (WIDE,), (Rule((1,), (1,), weight=2.0),)), "weight 2"),
        (lambda: System("s", (WIDE,), (WIDE,), (Rule((1,), (1,)),), conjunction="mean"), "no conjunction"),
        (lambda: System("s", (WIDE,), (WIDE,), (Rule((1,), (1,)),), defuzzification="wtaver"), "cannot defuzzify"),
        (lambda: System("s", (WIDE,), (WIDE,), ()), "needs inputs, outputs and rules"),
        (lambda: System("s", (WIDE, WIDE), (WIDE,), (Rule((1, 1), (1,)),)), "two inputs called 'x'"),
        (
            lambda: System("s", (WIDE,), (replace(WIDE, sets=(Set("c", "constant", (1,)),)),), (Rule((1,), (1,)),)),
            "'c'",
        ),
        (
            lambda: replace(
                fuzzy.load("repaired"),
                outputs=(replace(WIDE, sets=(*WIDE.sets, Set("one", "singleton", (1,)))), replace(WIDE, name="y")),
            ),
            "singletons and sets with an area",
        ),
        (lambda: replace(fuzzy.load("repaired"), aggregation="sum", fuzzylab=True), "as fuzzylab"),
        (lambda: fuzzy.load("repaird"), "Did you mean 'repaired'"),
        (lambda: fuzzy.load("repaired").evaluate([1.0, 2.0]), "takes 3 inputs"),
        (lambda: fuzzy.load("repaired").evaluate(1.0), "takes 3 inputs"),
        (lambda: fuzzy.load("repaired").evaluate(["near", 1, 2]), "must be numbers"),
        (lambda: aggregated(fuzzy.load("repaired"), np.zeros((2, 3)), 0), "one input"),
        (lambda: aggregated(fuzzy.load("repaired"), np.zeros(3), 2), "outputs 0 to 1"),
        (lambda: membership(Set("c", "constant", (1,)), 0.0), "no membership"),
    ],
)
def test_a_mistake_gets_one_line(make, words):
    with pytest.raises((InputError, UnknownName), match=words) as raised:
        make()
    assert "\n" not in str(raised.value)


def test_an_input_that_equals_an_output_is_still_an_input():
    """Sets of Sugeno outputs are told by place, not by value."""
    same = Variable("x", 0.0, 1.0)
    with pytest.raises(InputError, match="which has 0 sets"):
        System("s", (same,), (same,), (Rule((1,), (0,)),), kind="sugeno", defuzzification="wtaver")
