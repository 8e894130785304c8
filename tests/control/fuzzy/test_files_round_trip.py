"""What is written reads back as the same system, in every format and from one format to the next."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from random_systems import STRAIGHT, mamdani, rule, variable, with_input

from holodrive.control import fuzzy
from holodrive.control.fuzzy import Set, System, Variable, files
from holodrive.control.fuzzy.files.words import straightened
from holodrive.errors import InputError

FORMATS = ("fis", "fcl", "fml")
ANY = mamdani((*STRAIGHT, "gaussian", "bell"))


@st.composite
def sugeno(draw):
    """A Sugeno system of order 0, or of 0 and 1."""
    inputs = tuple(draw(variable(f"x{k}", (*STRAIGHT, "gaussian", "bell"))) for k in range(draw(st.integers(1, 2))))
    numbers = st.integers(-40, 40).map(lambda k: k / 8.0)
    linear = st.lists(numbers, min_size=len(inputs) + 1, max_size=len(inputs) + 1).map(
        lambda p: Set("b", "linear", (*p,))
    )
    constant = numbers.map(lambda c: Set("a", "constant", (c,)))
    sets = (draw(constant), draw(linear)) if draw(st.booleans()) else (draw(constant),)
    outputs = (Variable("y", -50.0, 50.0, sets, draw(st.sampled_from((float("nan"), 0.0)))),)
    return System(
        "drawn",
        inputs,
        outputs,
        tuple(draw(st.lists(rule(inputs, outputs), min_size=1, max_size=6))),
        kind="sugeno",
        conjunction=draw(st.sampled_from(("min", "prod"))),
        defuzzification=draw(st.sampled_from(("wtaver", "wtsum"))),
    )


@st.composite
def singletons(draw):
    """A Mamdani system whose outputs are singletons."""
    return draw(mamdani(("singleton",)))


SYSTEMS = st.one_of(ANY, sugeno(), singletons())


def said(system, format):
    """The text, or None where the format refuses in one line to say it."""
    try:
        return files.text(system, format)
    except InputError as error:
        if "cannot say" not in str(error) or "\n" in str(error):
            raise
        return None


def same(left, right, x, clamp):
    """Equal values, NaN where the other has NaN."""
    a, b = left.evaluate(x, clamp), right.evaluate(x, clamp)
    return np.allclose(a, b, rtol=1e-9, atol=1e-9, equal_nan=True)


@pytest.mark.parametrize("format", FORMATS)
@given(with_input(SYSTEMS), st.booleans())
def test_what_is_written_reads_back_as_a_system_that_does_the_same(format, drawn, clamp):
    system, x = drawn
    text = said(system, format)
    if text is None:
        return
    again = files.parse(text, format)
    assert same(system, again, x, clamp)
    assert files.parse(files.text(again, format), format) == again


@pytest.mark.parametrize("format", FORMATS)
@given(mamdani(("triangle", "trapezoid")))
def test_what_a_format_can_say_reads_back_equal(format, system):
    """Triangles, trapezoids and curves come back number for number; only polylines may come back under other names."""
    if any(one.kind == "polyline" for variable in system.inputs for one in variable.sets):
        return
    text = said(system, format)
    if text is None:
        return
    again = files.parse(text, format)
    if format == "fcl":  # a single condition has no connective there
        flat = [replace(one, connective="and") if sum(map(bool, one.inputs)) == 1 else one for one in system.rules]
        system = replace(system, rules=tuple(flat))
    assert again == system


@given(with_input(SYSTEMS), st.permutations(FORMATS))
@settings(max_examples=60)
def test_a_chain_of_formats_keeps_the_behaviour(drawn, order):
    system, x = drawn
    passed = system
    for format in (*order, order[0]):
        text = said(passed, format)
        if text is None:
            return
        passed = files.parse(text, format)
    assert same(system, passed, x, True)
    assert same(system, passed, x, False)


@pytest.mark.parametrize("name", fuzzy.names())
@pytest.mark.parametrize("format", FORMATS)
def test_every_profile_goes_through_every_format(name, format, tmp_path):
    system = fuzzy.load(name)
    again = files.parse(files.text(system, format), format)
    x = np.random.default_rng(1).uniform(-100.0, 2700.0, (300, len(system.inputs)))
    assert same(system, again, x, True)
    assert same(system, again, x, False)
    files.write(system, tmp_path / f"x.{format}")
    assert files.read(tmp_path / f"x.{format}") == again


@pytest.mark.parametrize("table", ["vii", "viii"])
def test_the_papers_tables_in_files_are_the_profiles(shared_data, table):
    """Values of the .fis file everywhere; the .fcl file differs above 2500 mm, where its shoulder stays 1."""
    profile = fuzzy.load(f"paper_{table}")
    fis, fcl = (files.read(shared_data / f"flc_table_{table}.{ending}") for ending in ("fis", "fcl"))
    x = np.random.default_rng(2).uniform(0.0, 3000.0, (2000, 3))
    for system in (fis, fcl):
        assert same(profile, system, x, True)
        assert system.rules == profile.rules
        assert [one.name for one in system.inputs] == ["DH", "DL", "DR"]
    assert same(profile, fis, x, False)
    inside = x[(x <= 2500.0).all(axis=1)]
    assert same(profile, fcl, inside, False)
    beyond = np.array([2600.0, 2600.0, 2600.0])
    assert np.isnan(fis.evaluate(beyond, clamp=False)).all()
    assert np.isfinite(fcl.evaluate(beyond, clamp=False)).all()


@pytest.mark.parametrize("table", ["vii", "viii"])
def test_from_fis_to_fcl_to_fml_to_fis(shared_data, table):
    text = (shared_data / f"flc_table_{table}.fis").read_text()
    fis = files.parse(text, "fis")
    fcl = files.parse(files.text(fis, "fcl"), "fcl")
    fml = files.parse(files.text(fcl, "fml"), "fml")
    assert fml == fis
    assert files.text(fml, "fis") == text


def test_units_and_defaults_survive_in_every_format():
    system = fuzzy.load("paper_viii")
    inputs = tuple(replace(one, unit="mm") for one in system.inputs)
    outputs = tuple(replace(one, default=0.5, unit="deg/s") for one in system.outputs)
    system = replace(system, inputs=inputs, outputs=outputs)
    for format in FORMATS:
        again = files.parse(files.text(system, format), format)
        assert [one.unit for one in (*again.inputs, *again.outputs)] == ["mm"] * 3 + ["deg/s"] * 2
        assert [one.default for one in again.outputs] == [0.5, 0.5]


def test_what_a_format_cannot_say_is_refused_in_one_line():
    system = fuzzy.load("paper_viii")
    odd = replace(system.outputs[0], name="left 'wheel'\n")
    cases = [
        ("fis", replace(system, conjunction="bounded"), "AndMethod 'bounded'"),
        ("fis", replace(system, outputs=(odd, system.outputs[1])), "the name"),
        ("fcl", replace(system, outputs=(odd, system.outputs[1])), "rename it"),
        ("fml", replace(system, outputs=(odd, system.outputs[1])), "the name"),
        ("fcl", replace(system, rules=(replace(system.rules[0], outputs=(0, 0)),)), "rule 1 concludes nothing"),
        ("fml", replace(system, rules=(replace(system.rules[0], outputs=(0, 0)),)), "rule 1 concludes nothing"),
    ]
    for format in FORMATS:
        cases.append((format, replace(system, fuzzylab=True), "fuzzylab"))
    for format, wrong, words in cases:
        with pytest.raises(InputError, match="cannot say") as error:
            files.text(wrong, format)
        assert words in str(error.value)
        assert "\n" not in str(error.value)


def test_a_polyline_gets_its_simplest_name():
    assert straightened((0.0, 1.0, 250.0, 1.0, 500.0, 0.0)) == ("falling", (250.0, 500.0))
    assert straightened((1.0, 0.0, 2.0, 1.0, 9.0, 1.0)) == ("rising", (1.0, 2.0))
    assert straightened((0.0, 0.0, 1.0, 1.0, 2.0, 0.0)) == ("triangle", (0.0, 1.0, 2.0))
    assert straightened((0.0, 0.5, 1.0, 1.0))[0] == "polyline"
