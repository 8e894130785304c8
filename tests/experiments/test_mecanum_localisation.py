"""Equations 1 to 7 of the second paper on random motions: what is wrong as printed, what corrections are worth."""

import json
import math

import numpy as np
import pytest

from holodrive.estimation import mouse_recursion
from holodrive.experiments import Setting
from holodrive.experiments.mecanum import localisation


@pytest.fixture(scope="module")
def result():
    return localisation.localisation(Setting())


def claim(result, part):
    return next(c for c in result.claims if part in c.what)


def test_counts_lose_nothing_and_are_whole():
    ways = np.random.default_rng(0).normal(0.0, 3e-5, (500, 4))
    told = localisation.counts(ways, 1e-5)
    np.testing.assert_allclose(told / 1e-5, np.round(told / 1e-5), atol=1e-6)
    assert np.max(np.abs(np.cumsum(told - ways, axis=0))) <= 0.5e-5 * (1.0 + 1e-9)
    assert localisation.counts(ways, 0.0) is ways


def test_a_motion_is_that_of_a_rigid_body_and_its_pose_the_exact_one(shared_data):
    rows = json.loads((shared_data / "paper_vectors.json").read_text())["seed002"]["localisation_rigid_motion"]
    found = localisation.motion(3, 0.015)
    x1, y1, x2, y2 = found.increments.T
    np.testing.assert_allclose(y1, y2)
    turn = (x2 - x1) / localisation.BASELINE_M
    np.testing.assert_allclose(np.cumsum(turn), found.pose[1:, 2], atol=1e-12)
    exact = np.array(rows["exact"])
    ours = localisation.rigid(np.array(rows["increments"]), rows["D"])[1:]
    np.testing.assert_allclose(ours[:, :2], exact[:, :2], atol=1e-9)
    np.testing.assert_allclose(np.degrees(ours[:, 2]), exact[:, 2], atol=1e-9)


def test_the_same_seed_is_the_same_course_at_any_sampling_time():
    fine, coarse = (localisation.motion(1, dt).pose[-1] for dt in (0.005, 0.015))
    assert math.hypot(*(fine - coarse)[:2]) < 0.05
    assert localisation.motion(1, 0.005).pose[-1] == pytest.approx(fine)


def test_the_printed_sign_rule_costs_tens_of_degrees_and_the_corrected_one_tenths(result):
    assert float(claim(result, "heading after 30 s").ours.split("°")[0]) > 10.0
    ends = result.data["15 ms, counts of 0 um"]
    assert math.degrees(ends["corrected"][1]) < 0.5
    assert ends["rigid body"][0] < 1e-9


def test_the_rigid_form_ends_within_a_twentieth_of_a_millimetre_in_counts(result):
    error_m, error_rad = result.data["5 ms, counts of 10 um"]["rigid body"]
    assert error_m < 5e-5
    assert math.degrees(error_rad) < 0.02


def test_the_case_x_0_as_printed_loses_place_and_heading(result):
    first = claim(result, "1 mm ahead")
    assert (first.printed, first.ours) == (pytest.approx(101.0), pytest.approx(1.0))
    assert claim(result, "first sample").ours == "0/0"


def test_the_mice_cannot_lie_as_the_text_says_and_the_line_between_them_must_not_grow(result):
    assert claim(result, "x₁ + D = x₂").ours == "90°"
    grown = claim(result, "distance of the two points")
    assert grown.ours > grown.printed
    one = localisation.motion(0, 0.015)
    turned = np.unwrap(mouse_recursion.corrected(one.increments, localisation.BASELINE_M)[:, 2])
    shares = np.abs(np.diff(turned)) / np.abs(np.diff(one.pose[:, 2]))
    assert np.all(shares < 1.0 + 1e-6)  # a longer line turns less for the same way of its end
    assert np.median(shares[-200:]) < np.median(shares[:200]) < 1.0


def test_corrected_equations_and_three_lines_are_the_same(result):
    assert claim(result, "as one step").verdict == "agrees"
    assert claim(result, "heading").verdict == "agrees"
