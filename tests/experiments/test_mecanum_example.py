"""The worked example of the second paper: which of its numbers are misprints, and why."""

import json

import numpy as np
import pytest

from holodrive.control import la_g
from holodrive.experiments import Setting
from holodrive.experiments.mecanum import example, gains, mapping, printed


@pytest.fixture(scope="module")
def vectors(shared_data):
    return json.loads((shared_data / "paper_vectors.json").read_text())["seed002"]


def test_three_of_24_numbers_are_misprints_and_all_others_agree():
    wrong = {(n.where, n.printed): n for n in example.numbers() if not n.agrees}
    assert len(example.numbers()) == 24
    assert set(wrong) == {("Eq. 25", -10.95), ("text", 26.7), ("Eq. 30", 5.01)}
    assert wrong["Eq. 25", -10.95].stepwise == pytest.approx(-6.2592)
    assert wrong["Eq. 30", 5.01].stepwise == pytest.approx(5.0996)
    assert "26.08 × (−0.42): digits of the gain swapped" in wrong["Eq. 25", -10.95].note


def test_exact_values_are_those_of_the_vectors(vectors):
    exact = {(n.what, n.where): n.exact for n in example.numbers()}
    by_what = {what: value for (what, _), value in exact.items()}
    for step in vectors["example_eq17_30"]:
        k = step["k"]
        assert by_what[f"error at k = {k}"] == pytest.approx(step["e"], abs=1e-10)
        assert by_what[f"α at k = {k}"] == pytest.approx(step.get("alpha_exact", step.get("alpha")), abs=1e-10)
    for moment, step in zip(printed.EXAMPLE, vectors["example_eq17_30"], strict=True):
        assert moment.position == tuple(step["p"])
        assert moment.heading_deg == step["heading"]
        assert moment.inputs[1] == step.get("M23", step.get("M23_printed"))


def test_the_first_command_is_above_the_papers_own_limit():
    claim = next(c for c in example.example(Setting()).claims if c.verdict == "cannot be")
    assert (claim.printed, claim.ours) == (39.6, 37.0)


def test_equation_13_with_the_printed_boundaries_gives_the_vectors_and_the_controllers_gains(vectors):
    for row in vectors["lag"]:
        found = mapping.printed_gains(row["theta"])
        assert found == pytest.approx((row["g14_printed"], row["g23_printed"]), abs=1e-10)
    angles = np.random.default_rng(0).uniform(-720.0, 720.0, 500)
    ours = np.column_stack(la_g.gains(np.radians(angles), "printed"))
    np.testing.assert_allclose(ours, [mapping.printed_gains(a) for a in angles], atol=1e-9)


def test_cosine_gains_drive_to_the_target_and_linear_ones_beside_it_but_on_eight_directions():
    angles = np.arange(0.0, 360.0, 0.1)
    assert np.max(np.abs(gains.direction_error(angles, "cosine"))) < 1e-9
    assert np.max(np.abs(gains.direction_error(angles, "clean"))) == pytest.approx(4.07, abs=0.005)
    assert np.max(np.abs(gains.direction_error(np.arange(0.0, 360.0, 45.0), "clean"))) < 1e-9


def test_figure_9_says_where_figure_8_and_the_equations_part():
    claims = gains.figure_9(Setting()).claims
    assert [c.verdict for c in claims[:3]] == ["agrees", "contradicts itself", "agrees"]
    assert next(c for c in claims if "−315" in str(c.printed)).verdict == "contradicts itself"
