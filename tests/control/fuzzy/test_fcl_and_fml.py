"""What the languages mean: both spellings of conclusions, precedence, rules written out, methods, XML of others."""

import itertools
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from holodrive.control.fuzzy import Rule, files
from holodrive.control.fuzzy.evaluation import strengths
from holodrive.errors import FileFaults

CORPUS = Path(__file__).parent / "corpus"
GOOD = (CORPUS / "good.fml").read_text()
INPUTS = "abc"


def fcl(rules, accu="MAX", norms="AND : MIN; OR : MAX;", y="(0,0) (1,1) (2,0)", z="(2,0) (3,1) (4,0)", method="COG"):
    """Three inputs with one set each, outputs y and z."""
    declared = " ".join(f"{one} : REAL;" for one in INPUTS)
    terms = "\n".join(
        f"FUZZIFY {one}\n TERM t := (0,0) (10,1);\n TERM s := (2,1) (9,0);\nEND_FUZZIFY" for one in INPUTS
    )
    sets = f"TERM p := {y}; TERM q := {z}; METHOD : {method}; RANGE := (0 .. 5);"
    defuzzified = "\n".join(f"DEFUZZIFY {one} {sets} END_DEFUZZIFY" for one in "yz")
    ruled = "\n".join(f"RULE {k} : {one};" for k, one in enumerate(rules, 1))
    return (
        f"FUNCTION_BLOCK x\nVAR_INPUT {declared} END_VAR\nVAR_OUTPUT y : REAL; z : REAL; END_VAR\n{terms}\n"
        f"{defuzzified}\n"
        f"RULEBLOCK one {norms} ACCU : {accu};\n{ruled}\nEND_RULEBLOCK\nEND_FUNCTION_BLOCK\n"
    )


def system(*rules, **options):
    return files.parse(fcl(rules, **options), "fcl")


def test_both_spellings_of_conclusions():
    comma = system("IF a IS t THEN y IS p, z IS q")
    assert comma == system("IF a IS t THEN y IS p AND z IS q")
    assert comma.rules == (Rule((1, 0, 0), (1, 2)),)


def test_letter_case_and_comments_say_nothing():
    text = fcl(["IF a IS t AND NOT b IS s THEN y IS p WITH 0.5"])
    plain = files.parse(text, "fcl")
    assert plain.rules == (Rule((1, -2, 0), (1, 0), 0.5),)
    assert files.parse(text.lower(), "fcl") == plain
    assert files.parse(text.replace(";", "; (* x; *) /* IF */ // y\n"), "fcl") == plain
    assert files.parse(text.replace("\n", "\r\n"), "fcl") == plain


def test_a_conclusion_drawn_twice_is_two_rules():
    assert system("IF a IS t THEN y IS p, y IS q").rules == (Rule((1, 0, 0), (1, 0)), Rule((1, 0, 0), (2, 0)))


def test_several_rule_blocks_are_one_rule_base():
    text = fcl(["IF a IS t THEN y IS p"])
    block = text[text.index("RULEBLOCK") : text.index("END_FUNCTION_BLOCK")]
    more = text.replace("END_FUNCTION_BLOCK", block.replace("a IS t", "b IS s") + "END_FUNCTION_BLOCK")
    assert files.parse(more, "fcl").rules == (Rule((1, 0, 0), (1, 0)), Rule((0, 2, 0), (1, 0)))


def test_and_implies_its_or():
    """The standard's pairs."""
    for norms, pair in (
        ("AND : PROD;", ("prod", "probor")),
        ("OR : BSUM;", ("bounded", "bounded")),
        ("", ("min", "max")),
    ):
        found = system("IF a IS t THEN y IS p", norms=norms)
        assert (found.conjunction, found.disjunction) == pair


LEAVES = st.sampled_from([f"{name} IS {negated}{term}" for name in INPUTS for negated in ("", "NOT ") for term in "ts"])
CONDITIONS = st.recursive(
    LEAVES,
    lambda inner: st.one_of(
        st.tuples(inner, st.sampled_from(("AND", "OR")), inner).map(" ".join),
        inner.map("({})".format),
        inner.map("NOT ({})".format),
    ),
    max_leaves=6,
)


def truth(condition, x):
    """The condition by Python's own parser: its precedence of not, and, or is the standard's."""

    class Degree(float):
        def __and__(self, other):
            return Degree(min(self, other))

        def __or__(self, other):
            return Degree(max(self, other))

        def __invert__(self):
            return Degree(1.0 - self)

    words = condition
    for name, value in zip(INPUTS, x, strict=True):
        degrees = {"t": min(max(value / 10.0, 0.0), 1.0), "s": min(max((9.0 - value) / 7.0, 0.0), 1.0)}
        for term, degree in degrees.items():
            words = words.replace(f"{name} IS NOT {term}", f"D({1.0 - degree!r})")
            words = words.replace(f"{name} IS {term}", f"D({degree!r})")
    words = words.replace("NOT", "~").replace("AND", "&").replace("OR", "|")
    return float(eval(words, {"D": Degree}))


@given(CONDITIONS)
def test_rules_written_out_fire_as_strongly_as_the_condition(condition):
    try:
        found = system(f"IF {condition} THEN y IS p")
    except FileFaults as error:
        refused = str(error)
    else:
        refused = ""
        grid = np.array(list(itertools.product((0.0, 3.0, 6.5, 10.0), repeat=3)))
        strongest = strengths(found, grid).max(axis=1)
        expected = [truth(condition, x) for x in grid.tolist()]
        assert np.allclose(strongest, expected, atol=1e-12)
    assert not refused or "joined by AND; a rule names an input once" in refused


def test_or_over_one_input_needs_the_maximum():
    assert len(system("IF a IS t OR a IS s THEN y IS p").rules) == 2
    for options in ({"accu": "NSUM"}, {"norms": "AND : PROD; OR : ASUM;"}):
        with pytest.raises(FileFaults, match="several rules could only say"):
            system("IF a IS t OR a IS s THEN y IS p", **options)


def test_summed_singletons_are_a_sugeno_system():
    rules = ("IF a IS t THEN y IS p, z IS p", "IF b IS t THEN y IS p, z IS q")
    summed = system(*rules, accu="NSUM", y="1", z="4", method="COGS")
    assert summed.kind == "sugeno"
    a, b = 0.5, 0.2
    found = summed.evaluate([5.0, 2.0, 0.0])
    assert found == pytest.approx([1.0, (a * 1.0 + b * 4.0) / (a + b)])
    highest = system(*rules, y="1", z="4", method="COGS")
    assert highest.kind == "mamdani"
    assert highest.evaluate([5.0, 2.0, 0.0]) == pytest.approx(found)


@pytest.mark.parametrize(("method", "expected"), [("LM", 1.5), ("RM", 2.5), ("MM", 2.0), ("COA", 2.0), ("COG", 2.0)])
def test_methods(method, expected):
    """A triangle from 1 to 3, cut at one half."""
    found = system("IF a IS t THEN y IS p", y="(1,0) (2,1) (3,0)", method=method)
    assert found.evaluate([5.0, 0.0, 0.0])[0] == pytest.approx(expected)


def test_ranges_may_stand_where_others_write_them():
    text = fcl(["IF a IS t THEN y IS p"])
    before = files.parse(text, "fcl")
    assert (before.inputs[0].low, before.inputs[0].high) == (0.0, 10.0)
    for other in (
        text.replace("a : REAL;", "a : REAL; RANGE := (-5 .. 20);"),
        text.replace("FUZZIFY a\n", "FUZZIFY a\nRANGE := (-5 .. 20);\n"),
    ):
        after = files.parse(other, "fcl")
        assert (after.inputs[0].low, after.inputs[0].high) == (-5.0, 20.0)


def test_prefixes_and_the_older_root_of_fml_are_read():
    system = files.parse(GOOD, "fml")
    prefixed = GOOD.replace("<", "<f:").replace("<f:/", "</f:").replace("<f:?", "<?").replace("xmlns=", "xmlns:f=")
    assert files.parse(prefixed, "fml") == system
    assert files.parse(GOOD.replace("fuzzySystem", "fuzzyController"), "fml") == system
    assert files.parse(GOOD.replace("<rule ", '<rule networkAddress="127.0.0.1" '), "fml") == system


def test_clauses_joined_by_or_over_one_input_are_written_out():
    twice = "<clause><variable>DH</variable><term>F</term></clause>"
    once = "<clause><variable>DL</variable><term>N</term></clause>"
    found = files.parse(GOOD.replace('connector="and"', 'connector="or"').replace(once, twice), "fml")
    assert found.rules[:2] == (Rule((1, 0), (1,)), Rule((2, 0), (1,)))
