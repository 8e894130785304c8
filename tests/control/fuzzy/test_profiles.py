"""The profiles: what is printed, what is derived, and that nothing else has changed."""

from contextlib import suppress
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from holodrive.control import fuzzy
from holodrive.control.fuzzy import profiles
from holodrive.control.fuzzy.evaluation import strengths
from holodrive.errors import InputError

MILLIMETRES = st.floats(0.0, 3000.0)


def test_the_printed_tables_disagree_in_19_rules():
    seven, eight = fuzzy.load("paper_vii"), fuzzy.load("paper_viii")
    assert sum(a != b for a, b in zip(seven.rules, eight.rules, strict=True)) == 19
    assert (seven.inputs, seven.outputs) == (eight.inputs, eight.outputs)


def test_repaired_takes_six_rules_of_table_vii_and_mends_two_variables():
    """Nothing is invented: each rule is in one of the printed tables, each set in the printed sets."""
    seven, eight, mended = (fuzzy.load(name) for name in ("paper_vii", "paper_viii", "repaired"))
    changed = [k for k, (a, b) in enumerate(zip(mended.rules, eight.rules, strict=True), 1) if a != b]
    assert changed == [11, 13, 20, 21, 22, 25]
    assert all(mended.rules[k - 1] == seven.rules[k - 1] for k in changed)
    assert [one.name for one in mended.inputs] == ["DH", "DL", "DR"]
    assert mended.inputs[1].sets == mended.inputs[2].sets == eight.inputs[2].sets
    assert mended.outputs[1].sets == mended.outputs[0].sets == eight.outputs[0].sets
    assert mended.inputs[0] == eight.inputs[0]


@given(MILLIMETRES, MILLIMETRES, MILLIMETRES)
def test_derived_profiles_have_no_gap(dh, dl, dr):
    """A rule fires wherever the sensor can look; the printed ones are silent at DL = 500 mm."""
    for name in ("repaired", "tuned"):
        assert np.isfinite(fuzzy.load(name).evaluate([dh, dl, dr])).all()
    assert np.isnan(fuzzy.load("paper_viii").evaluate([dh, 500.0, dr])).all()


@given(MILLIMETRES, MILLIMETRES, MILLIMETRES)
def test_repaired_is_mirror_symmetric_where_its_rules_are(dh, dl, dr):
    """Left and right exchanged exchange the outputs, but where rule 5 or 9 breaks the tie in front of a wall."""
    system = fuzzy.load("repaired")
    mirror = {(r.inputs[0], r.inputs[2], r.inputs[1]): r.outputs[::-1] for r in system.rules}
    odd = [k for k, r in enumerate(system.rules) if mirror[r.inputs] != r.outputs]
    symmetric = replace(system, rules=tuple(r for k, r in enumerate(system.rules) if k not in odd))
    assert {4, 8} <= set(odd)
    out = symmetric.evaluate([dh, dl, dr])
    np.testing.assert_allclose(symmetric.evaluate([dh, dr, dl]), out[::-1], atol=1e-9)


def test_with_breaks_puts_the_same_sets_on_all_inputs():
    system = profiles.with_breaks(fuzzy.load("repaired"), 300, 420, 400, 600, 800)
    for variable in system.inputs:
        near, middle, far = variable.sets
        assert near.params == (0, 0, 300, 420)
        assert middle.params == (300, 400, 800)
        assert far.params == (600, 800, 2500, 2500)
    assert system.rules == fuzzy.load("repaired").rules
    assert fuzzy.load("tuned").inputs == profiles.with_breaks(fuzzy.load("repaired"), *profiles.TUNED_BREAKS_MM).inputs


@given(st.lists(st.floats(1.0, 2499.0), min_size=5, max_size=5))
def test_breaks_that_are_taken_leave_no_gap(numbers):
    """In any order that is accepted."""
    with suppress(InputError):
        system = profiles.with_breaks(fuzzy.load("repaired"), *numbers)
        x = np.repeat(np.linspace(0.0, 2500.0, 400)[:, None], 3, axis=1)
        assert (strengths(system, x).max(axis=1) > 0.0).all()


@pytest.mark.parametrize("numbers", [(407, 323, 369, 569, 669), (323, 407, 300, 569, 669), (323, 407, 369, 669, 569)])
def test_breaks_out_of_order_are_refused(numbers):
    with pytest.raises(InputError, match="leave a gap or make no sets"):
        profiles.with_breaks(fuzzy.load("repaired"), *numbers)


def test_breaks_are_for_inputs_with_near_middle_far():
    system = fuzzy.load("repaired")
    other = replace(system, inputs=(replace(system.inputs[0], sets=system.inputs[0].sets[::-1]), *system.inputs[1:]))
    with pytest.raises(InputError, match="'DH' has the sets F, M, N"):
        profiles.with_breaks(other, *profiles.TUNED_BREAKS_MM)
