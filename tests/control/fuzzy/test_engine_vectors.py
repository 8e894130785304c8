"""The engine against vectors from elsewhere: the exact controller, the paper's library, a peer."""

import json
import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from holodrive.control import fuzzy
from holodrive.control.fuzzy.membership import membership

ROUNDED = 1e-9  # the vectors have nine decimals
TABLES = [("paper_vii", "VII"), ("paper_viii", "VIII")]


@pytest.fixture(scope="module")
def vectors(shared_data):
    return json.loads((shared_data / "flc_vectors.json").read_text())


def column(vectors, table, name):
    rows = vectors["tables"][table][name]
    return np.array([[math.nan if v is None else v for v in (row or (None, None))] for row in rows], dtype=float)


@pytest.mark.parametrize(("profile", "table"), TABLES)
def test_rules_and_sets_are_those_of_the_paper(vectors, profile, table):
    system = fuzzy.load(profile)
    assert [[*rule.inputs, *rule.outputs] for rule in system.rules] == vectors["rules"][table]
    for side, variables in (("inputs", system.inputs), ("outputs", system.outputs)):
        for variable in variables:
            told = vectors["membership"][side][variable.name]
            found = {one.name: sorted(set(one.params)) for one in variable.sets}
            assert found == {name: sorted(set(params)) for name, params in told.items()}


@pytest.mark.parametrize(("profile", "table"), TABLES)
@pytest.mark.parametrize(("name", "clamp"), [("exact", False), ("exact_clamped", True)])
def test_outputs_are_exact_and_nan_where_no_rule_fires(vectors, profile, table, name, clamp):
    out = fuzzy.load(profile).evaluate(vectors["inputs"], clamp=clamp)
    np.testing.assert_allclose(out, column(vectors, table, name), rtol=0.0, atol=ROUNDED)


@pytest.mark.parametrize(("profile", "table"), TABLES)
def test_the_compatibility_switch_is_the_paper_s_library(vectors, profile, table):
    """fuzzylab's samples, exchanged outputs, no clamping whatever is asked for, NaN where no rule fires."""
    system = fuzzy.load(profile, fuzzylab_compat=True)
    for clamp in (True, False):
        out = system.evaluate(vectors["inputs"], clamp=clamp)
        np.testing.assert_allclose(out, column(vectors, table, "fuzzylab"), rtol=0.0, atol=ROUNDED)
        unswapped = column(vectors, table, "fuzzylab_unswapped")
        np.testing.assert_allclose(out[:, ::-1], unswapped, rtol=0.0, atol=ROUNDED)


@pytest.mark.parametrize(("profile", "table"), TABLES)
@pytest.mark.parametrize("name", ["scikit-fuzzy", "ferrifuzz", "fuzzytool", "simpful", "pyfuzzylite"])
def test_libraries_agree_as_far_as_they_sample(vectors, profile, table, name):
    """Within 0.4 of 600 units where both say something."""
    theirs = column(vectors, table, name)
    out = fuzzy.load(profile).evaluate(vectors["inputs"], clamp=name == "scikit-fuzzy")
    both = ~np.isnan(theirs) & ~np.isnan(out)
    assert both.any()
    assert np.max(np.abs(out - theirs)[both]) < 0.4


def test_the_paper_s_cases_are_met_with_101_samples(shared_data):
    """Six decimals; the cases clamp and give 0 where no rule fires."""
    told = json.loads((shared_data / "paper_vectors.json").read_text())["seed000"]["flc"]
    for case in told["cases"]:
        x = np.clip([case["DH"], case["DL"], case["DR"]], 0.0, 2500.0)
        for profile, table in TABLES:
            out = fuzzy.load(profile, fuzzylab_compat=True).evaluate(x)[::-1]
            np.testing.assert_allclose(np.nan_to_num(out), case[table], rtol=0.0, atol=1e-6)


# --- ferrifuzz, on what it can express ----------------------------------------------------------

METHODS = {"min": "min", "prod": "product", "bounded": "lukasiewicz"}


def peer(system, resolution):
    """The same system in ferrifuzz."""
    ff = pytest.importorskip("ferrifuzz")
    other = ff.FuzzySystem(
        and_method=METHODS[system.conjunction],
        defuzz_method=system.defuzzification,
        implication="larsen" if system.implication == "prod" else "mamdani",
        resolution=resolution,
    )
    for variables, add in ((system.inputs, other.add_input), (system.outputs, other.add_output)):
        for variable in variables:
            theirs = ff.Variable(variable.name, variable.low, variable.high)
            for one in variable.sets:
                theirs[one.name] = getattr(ff.mf, one.kind)(*one.params)
            add(theirs)
    for rule in system.rules:
        other.add_rule(f"IF {spoken(system.inputs, rule.inputs)} THEN {spoken(system.outputs, rule.outputs)}")
    return other


def spoken(variables, numbers):
    return " AND ".join(f"{v.name} IS {v.sets[k - 1].name}" for v, k in zip(variables, numbers, strict=True))


@settings(max_examples=20)
@given(
    st.sampled_from(fuzzy.names()),
    st.sampled_from(["min", "prod", "bounded"]),
    st.sampled_from(["min", "prod"]),
    st.sampled_from(["centroid", "bisector"]),
    st.integers(0, 1000),
)
def test_ferrifuzz_agrees_under_every_norm_and_implication(name, conjunction, implication, method, seed):
    """In rule strengths to rounding, in outputs as far as it samples."""
    from dataclasses import replace

    from holodrive.control.fuzzy.evaluation import strengths

    how = {"conjunction": conjunction, "implication": implication, "defuzzification": method}
    system = replace(fuzzy.load(name), **how)
    other, x = peer(system, 20_000), np.random.default_rng(seed).uniform(-50.0, 2700.0, 3)
    told = dict(zip(("DH", "DL", "DR"), x, strict=True))
    np.testing.assert_allclose(strengths(system, x), other.rule_strengths(told), rtol=0.0, atol=1e-12)
    out, theirs = system.evaluate(x), np.array(other.evaluate(list(x)))
    np.testing.assert_array_equal(np.isnan(out), np.isnan(theirs))
    assert np.all(np.isnan(out) | (np.abs(out - theirs) < 0.1))


def test_membership_is_that_of_the_peer():
    """Triangles, trapezoids with upright sides, Gaussians, bells."""
    ff = pytest.importorskip("ferrifuzz")
    x = np.linspace(-1.0, 4.0, 501)
    for one, theirs in (
        (fuzzy.Set("a", "triangle", (0, 1, 3)), ff.mf.triangle(0, 1, 3)),
        (fuzzy.Set("a", "triangle", (0, 0, 3)), ff.mf.triangle(0, 0, 3)),
        (fuzzy.Set("a", "trapezoid", (0, 1, 3, 3)), ff.mf.trapezoid(0, 1, 3, 3)),
        (fuzzy.Set("a", "gaussian", (1, 0.5)), ff.mf.gaussian(1, 0.5)),
        (fuzzy.Set("a", "bell", (0.5, 2, 1)), ff.mf.bell(1, 0.5, 2)),
    ):
        np.testing.assert_allclose(membership(one, x), theirs(x), atol=1e-12)
