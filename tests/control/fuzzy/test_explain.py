"""What an explanation says is what the system does."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from holodrive.control.fuzzy import Rule, Set, System, Variable, load, profiles
from holodrive.control.fuzzy.explain import explain
from holodrive.control.fuzzy.shares import shares
from holodrive.errors import InputError

MILLIMETRES = st.floats(0.0, 3000.0)
PROFILES = st.sampled_from(profiles.names())


def two_rules(**how) -> System:
    """One input, one output, two conclusions that overlap."""
    ramp = Variable("x", 0.0, 1.0, (Set("low", "triangle", (0, 0, 1)), Set("high", "triangle", (0, 1, 1))))
    out = Variable("y", 0.0, 3.0, (Set("a", "triangle", (0, 1, 2)), Set("b", "triangle", (1, 2, 3))))
    return System("two", (ramp,), (out,), (Rule((1,), (1,)), Rule((2,), (2,))), **how)


def without_really(system: System, number: int) -> System:
    return replace(system, rules=tuple(r for i, r in enumerate(system.rules, 1) if i != number))


@given(PROFILES, st.tuples(MILLIMETRES, MILLIMETRES, MILLIMETRES), st.booleans(), st.booleans())
def test_shares_of_each_output_sum_to_one(name, x, prod, add):
    """Under every way of implication and aggregation, wherever anything fires."""
    system = replace(load(name), implication="prod" if prod else "min", aggregation="sum" if add else "max")
    told = explain(system, x)
    for k in range(2):
        total = sum(rule.shares[k] for rule in told.rules)
        assert total == pytest.approx(1.0 if told.rules else 0.0, abs=1e-12)
        assert all(0.0 <= rule.shares[k] <= 1.0 for rule in told.rules)


@given(PROFILES, st.tuples(MILLIMETRES, MILLIMETRES, MILLIMETRES), st.booleans())
def test_leaving_a_rule_out_gives_what_the_counterfactual_says(name, x, clamp):
    """Bit for bit, for every rule that fired; and leaving out a rule that did not fire changes nothing."""
    system = load(name)
    told = explain(system, x, clamp)
    for rule in told.rules:
        np.testing.assert_array_equal(without_really(system, rule.number).evaluate(x, clamp), rule.without)
    silent = next(n for n in range(1, 28) if n not in {rule.number for rule in told.rules})
    np.testing.assert_array_equal(without_really(system, silent).evaluate(x, clamp), told.outputs)


@given(PROFILES, st.tuples(MILLIMETRES, MILLIMETRES, MILLIMETRES))
def test_outputs_are_those_of_evaluate_and_memberships_those_of_the_sets(name, x):
    """With the clamped value that was used."""
    system = load(name)
    told = explain(system, x)
    np.testing.assert_array_equal(told.outputs, system.evaluate(x))
    for reading, variable, value in zip(told.inputs, system.inputs, x, strict=True):
        assert reading.used == min(value, variable.high)
        assert [one for one, _ in reading.memberships] == [one.name for one in variable.sets]


@given(PROFILES, st.tuples(MILLIMETRES, MILLIMETRES, MILLIMETRES))
def test_area_won_agrees_with_fine_sampling(name, x):
    """A second method: who is highest at 60 001 places; of equals the strongest, and equals of those halve."""
    system = load(name)
    strengths = np.zeros(27)
    for rule in (told := explain(system, x)).rules:
        strengths[rule.number - 1] = rule.strength
    if not told.rules:
        return
    found = shares(system, strengths)
    u = np.linspace(-300.0, 300.0, 60_001)
    for k, variable in enumerate(system.outputs):
        cut = np.zeros((27, len(u)))
        for i, rule in enumerate(system.rules):
            a, b, c = variable.sets[rule.outputs[k] - 1].params
            cut[i] = np.minimum(strengths[i], np.interp(u, [a, b, c], [0, 1, 0]))
        top = cut.max(axis=0)
        wins = (cut >= top - 1e-12) & (top > 0.0)
        wins &= strengths[:, None] >= np.where(wins, strengths[:, None], 0.0).max(axis=0)
        won = (np.where(wins, cut, 0.0) / np.maximum(wins.sum(axis=0), 1)).sum(axis=1)
        np.testing.assert_allclose(found[:, k], won / won.sum(), atol=3e-4)


def test_a_rule_that_is_wholly_hidden_has_no_share_and_changes_nothing():
    """Two rules with one conclusion: the weaker one wins no area under max."""
    system = replace(two_rules(), rules=(Rule((1,), (1,)), Rule((2,), (1,))))
    strong, weak = explain(system, (0.3,)).rules
    assert (strong.number, weak.number) == (1, 2)
    assert (strong.shares, weak.shares) == ((1.0,), (0.0,))
    assert weak.without == explain(system, (0.3,)).outputs


def test_rules_that_are_equally_strong_halve_their_common_area():
    """A tie is split, not given to the first."""
    system = replace(two_rules(), rules=(Rule((1,), (1,)), Rule((2,), (1,))))
    assert [rule.shares for rule in explain(system, (0.5,)).rules] == [(0.5,), (0.5,)]


def test_sums_give_each_rule_its_own_area():
    """By hand: cut at h, a triangle of base 2 keeps h (2 - h)."""
    first, second = explain(two_rules(aggregation="sum"), (0.25,)).rules
    area = [h * (2 - h) for h in (0.75, 0.25)]
    assert first.shares[0] == pytest.approx(area[0] / sum(area), abs=1e-12)
    assert second.shares[0] == pytest.approx(area[1] / sum(area), abs=1e-12)


def test_sugeno_shares_are_the_weights_of_the_mean():
    """So the output is the mean of the conclusions weighted with the shares."""
    out = Variable("y", 0.0, 3.0, (Set("a", "constant", (1.0,)), Set("b", "constant", (3.0,))))
    system = replace(two_rules(), kind="sugeno", defuzzification="wtaver", outputs=(out,))
    told = explain(system, (0.25,))
    assert [rule.shares[0] for rule in told.rules] == pytest.approx([0.75, 0.25])
    assert told.outputs[0] == pytest.approx(0.75 * 1.0 + 0.25 * 3.0)


def test_the_paper_at_the_gap_says_why_nothing_came_out():
    """DL = 500 mm belongs to no set in either printed table."""
    told = load("paper_viii").explain((700, 500, 2500))
    assert not told.rules
    assert np.isnan(told.outputs).all()
    assert "DL = 500 mm belongs to no set" in told.note
    assert told.note in told.text()


@pytest.mark.parametrize(
    ("x", "clamp", "why"),
    [
        ((np.nan, 1, 1), True, "DH is not a number"),
        ((700, 300, 2800), False, "DR = 2800 mm lies outside 0..2500"),
    ],
)
def test_silence_is_explained(x, clamp, why):
    """Unknown inputs and inputs beyond the universe."""
    assert why in load("repaired").explain(x, clamp).note


def test_a_combination_without_a_rule_and_a_default_are_told():
    """The engine leaves it to the caller whether to use the default."""
    system = replace(two_rules(), rules=(Rule((2,), (2,)),))
    system = replace(system, outputs=(replace(system.outputs[0], default=1.5),))
    told = explain(system, (0.0,))
    assert np.isnan(told.outputs[0])
    assert "no rule has this combination" in told.note
    assert "y = 1.5" in told.note


def test_the_text_has_rules_strengths_and_what_changes():
    """As people read it: two rules of the repaired table at a corner of a near left side."""
    told = load("repaired").explain((700, 300, 2800))
    text = told.text()
    assert "2800 mm taken as 2500" in text
    assert "IF DH is M AND DL is N AND DR is F THEN L is P AND R is PZ" in text
    assert [rule.number for rule in told.rules][:1] == [12]
    assert max(len(line) for line in text.splitlines()) <= 120


def test_fuzzylab_compatible_systems_are_explained_with_their_exchanged_outputs():
    """The shares follow the exchange: with one rule left, its conclusion for R makes what is told as L."""
    told = load("paper_viii", fuzzylab_compat=True).explain((300, 400, 2400))
    plain = load("paper_viii").explain((300, 400, 2400))
    assert [rule.number for rule in told.rules] == [rule.number for rule in plain.rules]
    for a, b in zip(told.rules, plain.rules, strict=True):
        assert a.shares == b.shares[::-1]


def test_html_is_well_formed_and_escaped():
    """Names come from files, so they may hold anything."""
    from xml.etree import ElementTree

    system = replace(two_rules(), name="<b>&")
    ElementTree.fromstring(explain(system, (0.4,))._repr_html_())


def test_a_wrong_input_is_one_clear_line():
    """Two numbers for three inputs."""
    with pytest.raises(InputError, match="DH, DL, DR"):
        load("repaired").explain((1.0, 2.0))
