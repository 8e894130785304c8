"""The linter finds what is wrong, exactly, and nothing else."""

import math
from dataclasses import replace

import numpy as np
import pytest

from holodrive.control.fuzzy import Rule, Set, System, Variable, load
from holodrive.control.fuzzy.lint import CODES, Finding, lint
from holodrive.control.fuzzy.lint.finding import numbers
from holodrive.errors import InputError

SENSOR_MM = (120.0, 3000.0)  # what the paper's program sets its lidar to

# Faults of the printed controllers that can be seen in sets and rules alone, with variable or rules.
BOTH_TABLES = {
    ("F-GAP", "DL", ()),  # N ends and M begins at 500 mm: no set holds there
    ("F-RANGE", "", ()),  # universe to 2500 mm, lidar to 3000 mm
    ("F-JUMP", "DL", ()),  # the outputs on both sides of the gap differ
    ("F-MIRROR-IN", "DL", ()),  # "equivalent parameters" DL and DR are not equal
    ("F-MIRROR-OUT", "L", ()),  # nor are the sets of L and R
    ("F-ZERO", "L", ()),  # no set around zero: no rule can stop
    ("F-ZERO", "R", ()),
    ("F-REACH", "L", ()),  # -300 and 300 cannot come out of a centroid
    ("F-REACH", "R", ()),
    ("F-COVER", "DH", ()),  # N and M cross at one third
    ("F-COVER", "DR", ()),
    ("F-SUM", "DH", ()),  # no partition
    ("F-SUM", "DL", ()),
    ("F-SUM", "DR", ()),
}
ONLY_VII = {
    ("F-TOWARD-BACK", "", (2, 3, 4, 7)),  # reverse and yaw toward the near side
    ("F-BACK", "", (5, 6, 8, 9)),  # reverse straight although a side is open
    ("F-STRAIGHT", "", (16,)),  # near right, no turn; its mirror 12 turns
    ("F-MIRROR-RULE", "", (12, 16)),
    ("F-BLIND", "", (1, 2, 3, 4, 5, 6, 7, 8, 9)),
}
ONLY_VIII = {
    ("F-TOWARD", "DR", (25,)),  # turns into the near right side
    ("F-STRAIGHT", "", (11, 13, 20, 21, 22)),  # straight past a near side
    ("F-MIRROR-RULE", "", (6, 8)),  # P N against NZ P
    ("F-MIRROR-RULE", "", (21, 25)),
    ("F-TIE", "", (5,)),  # always spins right: arbitrary, but something has to break the tie
    ("F-TIE", "", (9,)),
    ("F-BLIND", "", (1,)),
}
REPAIRED = {  # what is truly left: see docs/fuzzy.md
    ("F-RANGE", "", ()),
    ("F-MIRROR-RULE", "", (6, 8)),
    ("F-ZERO", "L", ()),
    ("F-ZERO", "R", ()),
    ("F-TIE", "", (5,)),
    ("F-TIE", "", (9,)),
    ("F-REACH", "L", ()),
    ("F-REACH", "R", ()),
    *((code, name, ()) for code in ("F-COVER", "F-SUM") for name in ("DH", "DL", "DR")),
    ("F-BLIND", "", (1,)),
}


def keys(found: tuple[Finding, ...]) -> list[tuple[str, str, tuple[int, ...]]]:
    return sorted((one.code, one.variable, one.rules) for one in found)


def only(found: tuple[Finding, ...], code: str, variable: str = "") -> Finding:
    (one,) = [one for one in found if one.code == code and variable in ("", one.variable)]
    return one


def ruspini(name: str, low: float, high: float, count: int = 3, marks: str = "NMF") -> Variable:
    """Triangles whose neighbours cross at one half."""
    tops = np.linspace(low, high, count).tolist()
    sets = tuple(
        Set(marks[i], "triangle", (tops[max(i - 1, 0)], tops[i], tops[min(i + 1, count - 1)])) for i in range(count)
    )
    return Variable(name, low, high, sets)


def clean() -> System:
    """A symmetric avoidance base: partitions, every combination once, lone numbers as outputs, zero among them."""
    wheels = tuple(
        Variable(
            name, -1.0, 1.0, tuple(Set(m, "singleton", (v,)) for m, v in zip("NZP", (-1.0, 0.0, 1.0), strict=True))
        )
        for name in ("L", "R")
    )
    inputs = tuple(ruspini(name, 0.0, 2.0) for name in ("DH", "DL", "DR"))
    rules = []
    for h in (1, 2, 3):
        for left in (1, 2, 3):
            for right in (1, 2, 3):
                slow = 1 if h == 1 else 2  # the inner wheel of a turn: spin where the way ahead is near
                out = (3, slow) if left < right else (slow, 3)
                out = ((2, 2) if h == 1 else (3, 3)) if left == right else out
                rules.append(Rule((h, left, right), out))
    return System("clean", inputs, wheels, tuple(rules))


def test_the_paper_as_printed_has_exactly_the_faults_that_can_be_seen():
    """Every fault once, and none besides; in particular no contradiction between rules about two outputs."""
    assert keys(load("paper_vii").lint(SENSOR_MM)) == sorted(BOTH_TABLES | ONLY_VII)
    assert keys(load("paper_viii").lint(SENSOR_MM)) == sorted(BOTH_TABLES | ONLY_VIII)


def test_the_repaired_profile_has_only_what_is_truly_left():
    """Nothing that makes it collide, jump or fall silent."""
    found = load("repaired").lint(SENSOR_MM)
    assert keys(found) == sorted(REPAIRED)
    assert not [one for one in found if one.severity == "error"]


def test_the_paper_s_numbers():
    """The size of each fault."""
    seven, eight = (load(name).lint(SENSOR_MM) for name in ("paper_vii", "paper_viii"))
    gap = only(eight, "F-GAP")
    assert (gap.at, gap.value, gap.severity) == (500.0, 0.0, "error")
    assert only(seven, "F-JUMP").value == pytest.approx(100.0, abs=1e-6)
    assert only(eight, "F-JUMP").value == pytest.approx(375.0, abs=1e-6)
    assert only(eight, "F-RANGE").value == pytest.approx(1.0 - (2380.0 / 2880.0) ** 3, abs=1e-12)
    assert only(eight, "F-COVER", "DH").value == pytest.approx(1.0 / 3.0)
    assert only(eight, "F-COVER", "DH").at == pytest.approx(1250.0 / 3.0)
    assert "0.5 and 1.25" in only(eight, "F-SUM", "DR").text
    assert "-237.5 to 225" in only(eight, "F-REACH", "L").text


def test_a_jump_is_the_difference_of_both_limits():
    """Agrees with two evaluations a micrometre beside the gap."""
    system = load("paper_viii")
    beside = system.evaluate([(50.0, 500.0 - 1e-6, 50.0), (50.0, 500.0 + 1e-6, 50.0)])
    np.testing.assert_allclose(beside, [(-237.5, -225.0), (-150.0, 150.0)], atol=1e-5)
    assert only(system.lint(), "F-JUMP").value == pytest.approx(np.abs(beside[1] - beside[0]).max(), abs=1e-5)


def test_without_a_sensor_nothing_is_said_about_its_range():
    """And a sensor within the universe is no fault."""
    assert "F-RANGE" not in {one.code for one in load("repaired").lint()}
    assert "F-RANGE" not in {one.code for one in load("repaired").lint((120.0, 2500.0))}


def test_a_clean_system_gives_nothing():
    """Symmetric, a partition, complete."""
    assert lint(clean(), (0.0, 2.0)) == ()


def test_every_code_has_its_words_and_is_documented():
    """In the table of the page."""
    from pathlib import Path

    page = (Path(__file__).parents[3] / "docs" / "fuzzy.md").read_text()
    assert all(f"| `{code}` |" in page for code in CODES)


def with_rules(system: System, *more: Rule, drop: tuple[int, ...] = ()) -> System:
    kept = tuple(rule for i, rule in enumerate(system.rules, 1) if i not in drop)
    return replace(system, rules=(*kept, *more))


def test_missing_rules_are_named_with_the_share_of_the_universe_that_falls_silent():
    """Without one corner rule only that corner's point is silent; its neighbours cover the rest of its sets."""
    found = lint(with_rules(clean(), drop=(27,)), mirror=())
    one = only(found, "F-MISSING")
    assert "DH=F, DL=F, DR=F" in one.text
    assert one.severity == "warning"
    three = lint(with_rules(clean(), drop=tuple(range(19, 28))), mirror=())  # nothing for DH = F
    assert only(three, "F-MISSING").text.startswith("9 of 27 combinations")


def test_missing_rules_that_silence_a_piece_of_the_universe_are_errors():
    """A trapezoid's top is a whole stretch with one set only."""
    system = load("repaired")
    one = only(lint(with_rules(system, drop=(27,))), "F-MISSING")
    assert one.severity == "error"
    assert one.value == pytest.approx((1000.0 / 2500.0) ** 3)  # only F holds from 1500 to 2500


def test_an_output_that_nobody_speaks_about_somewhere_is_told():
    """Rules 19 to 27 fire where the head is far, but say nothing of R."""
    rules = tuple(replace(r, outputs=(r.outputs[0], 0)) if r.inputs[0] == 3 else r for r in load("repaired").rules)
    system = replace(load("repaired"), rules=rules)
    one = only(lint(system, mirror=()), "F-MISSING")
    assert (one.variable, one.severity) == ("R", "error")
    assert one.value == pytest.approx(1000.0 / 2500.0)  # only F holds from 1500 to 2500
    assert np.isnan(system.evaluate([2000.0, 1000.0, 1000.0])[1])


def test_don_t_care_and_or_cover_many_combinations():
    """Two rules may cover all nine."""
    x, y = ruspini("x", 0, 1), ruspini("y", 0, 1)
    out = Variable("z", 0.0, 1.0, (Set("a", "singleton", (0.0,)), Set("b", "singleton", (1.0,))))
    rules = (Rule((1, 3), (1,), 1.0, "or"), Rule((-1, -3), (2,)))
    assert lint(System("few", (x, y), (out,), rules)) == (
        Finding("F-UNUSED", "info", "no rule names the sets M, F of x", "x"),
        Finding("F-UNUSED", "info", "no rule names the sets N, M of y", "y"),
    )


def test_duplicates_and_contradictions_are_told_apart():
    """The same condition twice: with the same conclusion, with another, and about another output."""
    system = clean()
    first = system.rules[0]
    twice = lint(with_rules(system, first), mirror=())
    assert only(twice, "F-DUPLICATE").rules == (1, 28)
    against = lint(with_rules(system, replace(first, outputs=(3, 2))), mirror=())
    assert only(against, "F-CONTRADICT").rules == (1, 28)
    assert only(against, "F-CONTRADICT").variable == "L"


def test_one_rule_for_each_output_is_no_contradiction():
    """Twice 27 rules with the same conditions, one half about L, the other about R."""
    system = clean()
    halves = [
        replace(rule, outputs=out) for rule in system.rules for out in ((rule.outputs[0], 0), (0, rule.outputs[1]))
    ]
    assert lint(replace(system, rules=tuple(halves)), mirror=()) == ()


def test_dead_rules_are_those_that_cannot_fire():
    """A weight of zero, or a set beyond the universe."""
    system = clean()
    zero = lint(with_rules(system, replace(system.rules[0], weight=0.0)), mirror=())
    assert only(zero, "F-DEAD").rules == (28,)
    far = replace(system.inputs[0], sets=(*system.inputs[0].sets, Set("X", "triangle", (3.0, 4.0, 5.0))))
    beyond = replace(system, inputs=(far, *system.inputs[1:]), rules=(*system.rules, Rule((4, 0, 0), (1, 1))))
    assert only(lint(beyond, mirror=()), "F-DEAD").rules == (28,)


def test_a_conclusion_outside_its_range_is_told():
    """Its rule fires and says nothing."""
    system = load("repaired")
    left = replace(system.outputs[0], sets=(*system.outputs[0].sets, Set("far", "triangle", (400.0, 500.0, 600.0))))
    beyond = with_rules(replace(system, outputs=(left, system.outputs[1])), Rule((3, 0, 0), (5, 4)))
    one = only(lint(beyond, mirror=()), "F-DEAD")
    assert (one.variable, one.rules) == ("L", (28,))


def test_a_masked_rule_changes_nothing_anywhere():
    """It asks for more than another rule that says the same; evaluation agrees at random places."""
    system = clean()
    general = Rule((0, 1, 3), system.rules[2].outputs)
    masked = with_rules(system, general)
    found = [one for one in lint(masked, mirror=()) if one.code == "F-MASKED"]
    hidden = {one.rules[0] for one in found}
    assert hidden
    assert all(one.rules[1] == 28 for one in found)
    places = np.random.default_rng(1).uniform(0.0, 2.0, (500, 3))
    without = with_rules(masked, drop=tuple(hidden))
    np.testing.assert_array_equal(masked.evaluate(places), without.evaluate(places))


def test_sums_hide_no_rule():
    """Every rule adds its area."""
    system = replace(with_rules(clean(), Rule((0, 1, 3), (3, 2))), aggregation="sum")
    assert "F-MASKED" not in {one.code for one in lint(system, mirror=())}


def test_a_gap_of_some_width_is_told_from_end_to_end():
    """And that a rule which does not ask for the input still fires there."""
    holes = Variable("x", 0.0, 10.0, (Set("a", "triangle", (0, 0, 4)), Set("b", "triangle", (6, 10, 10))))
    out = Variable("y", 0.0, 1.0, (Set("p", "singleton", (0.0,)), Set("q", "singleton", (1.0,))))
    gap = only(lint(System("holes", (holes,), (out,), (Rule((1,), (1,)), Rule((2,), (2,))))), "F-GAP")
    assert (gap.at, gap.value, gap.severity) == (5.0, 2.0, "error")
    rules = (Rule((1,), (1,)), Rule((2,), (2,)), Rule((-1,), (1,)))
    gap = only(lint(System("holes", (holes,), (out,), rules)), "F-GAP")
    assert gap.severity == "warning"


def test_gaps_at_both_ends_of_the_universe_are_found():
    """The ends are break points too."""
    middle = Variable("x", 0.0, 10.0, (Set("a", "triangle", (2, 5, 9)),))
    out = Variable("y", 0.0, 1.0, (Set("p", "singleton", (0.5,)),))
    gaps = [one for one in lint(System("ends", (middle,), (out,), (Rule((1,), (1,)),))) if one.code == "F-GAP"]
    assert [(one.at, one.value) for one in gaps] == [(1.0, 2.0), (9.5, 1.0)]


def test_an_upright_side_makes_a_jump_without_a_gap():
    """Crisp sets: the output steps by its whole range."""
    x = Variable("x", 0.0, 2.0, (Set("a", "trapezoid", (0, 0, 1, 1)), Set("b", "trapezoid", (1, 1, 2, 2))))
    out = Variable("y", 0.0, 1.0, (Set("p", "singleton", (0.0,)), Set("q", "singleton", (1.0,))))
    found = lint(System("crisp", (x,), (out,), (Rule((1,), (1,)), Rule((2,), (2,)))))
    jump = only(found, "F-JUMP")
    assert (jump.at, jump.value) == (1.0, pytest.approx(1.0))
    assert "F-GAP" not in {one.code for one in found}


def test_defuzzification_by_maxima_is_said_to_jump_by_nature():
    """Not each of its jumps."""
    system = replace(load("repaired"), defuzzification="mom")
    codes = {one.code for one in lint(system)}
    assert "F-STEPS" in codes
    assert "F-JUMP" not in codes


def test_the_bisector_is_not_taken_for_smooth():
    """It leaps over the gap between the sets below and above zero where one side comes to outweigh the other."""
    system = replace(load("repaired"), defuzzification="bisector")
    assert "F-STEPS" in {one.code for one in lint(system)}
    head = np.linspace(250.0, 500.0, 100_001)
    steps = np.abs(np.diff(system.evaluate(np.stack([head, 0.0 * head + 2500.0, 0.0 * head + 2500.0], axis=1)), axis=0))
    assert steps.max() > 300.0


def test_mirrors_of_different_weight_are_told():
    system = clean()
    lighter = tuple(replace(r, weight=0.5) if n == 2 else r for n, r in enumerate(system.rules, 1))
    found = lint(replace(system, rules=lighter))
    assert only(found, "F-MIRROR-RULE").rules == (2, 4)


def test_smooth_sets_have_neither_gaps_nor_jumps():
    """Gaussians reach everywhere; they do not sum to one, though."""
    sets = tuple(Set(m, "gaussian", (c, 0.4)) for m, c in zip("NMF", (0.0, 1.0, 2.0), strict=True))
    system = replace(clean(), inputs=tuple(Variable(n, 0.0, 2.0, sets) for n in ("DH", "DL", "DR")))
    found = lint(system, (0.0, 2.0))
    assert {one.code for one in found} <= {"F-COVER", "F-SUM"}
    cover = only(found, "F-COVER", "DL")
    assert cover.value == pytest.approx(math.exp(-0.5 * (0.5 / 0.4) ** 2), abs=1e-4)


def test_turning_the_wheels_round_turns_every_rule_toward_the_near_side():
    """Exchanged outputs, as the paper's library gives them, are seen at once."""
    system = clean()
    swapped = replace(system, rules=tuple(replace(r, outputs=r.outputs[::-1]) for r in system.rules))
    toward = {one.rules for one in lint(swapped) if one.code == "F-TOWARD"}
    assert toward == {(i,) for i, r in enumerate(system.rules, 1) if r.inputs[1] != r.inputs[2]}


def test_mirror_pairs_can_be_declared_or_turned_off():
    """By names of the user's own."""
    system = load("paper_viii")
    renamed = replace(
        system,
        inputs=tuple(replace(v, name=n) for v, n in zip(system.inputs, ("a", "b", "c"), strict=True)),
        outputs=tuple(replace(v, name=n) for v, n in zip(system.outputs, ("p", "q"), strict=True)),
    )
    off = {one.code for one in lint(renamed)}
    assert not off & {"F-MIRROR-IN", "F-TOWARD", "F-BLIND"}
    assert {one.code for one in lint(system, mirror=())} == off
    assert {one.code for one in system.lint(mirror=())} == off
    declared = lint(renamed, mirror=(("b", "c"), ("p", "q")))
    assert [one.rules for one in declared if one.code == "F-TOWARD"] == [(25,)]


def test_an_input_that_looks_behind_ends_the_doubt_about_blind_reverse():
    """Told by its name."""
    system = load("repaired")
    rear = replace(system.inputs[0], name="rear")
    more = replace(
        system,
        inputs=(*system.inputs, rear),
        rules=tuple(replace(rule, inputs=(*rule.inputs, 0)) for rule in system.rules),
    )
    assert "F-BLIND" not in {one.code for one in lint(more)}


@pytest.mark.parametrize(
    ("kwargs", "why"),
    [
        ({"mirror": (("DL", "DX"),)}, "'DX' names no two inputs"),
        ({"sensor_range": (3000.0, 120.0)}, "must be two finite numbers that rise"),
    ],
)
def test_wrong_arguments_are_one_clear_line(kwargs, why):
    """With what there is."""
    with pytest.raises(InputError, match=why):
        lint(load("repaired"), **kwargs)


def test_numbers_of_rules_read_well():
    """Runs are told from end to end."""
    assert [numbers(r) for r in ((4,), (4, 7), (1, 2, 3, 5), (1, 2, 4))] == [
        "rule 4",
        "rules 4 and 7",
        "rules 1 to 3 and 5",
        "rules 1, 2 and 4",
    ]
