"""Equations 8 to 12 of the second paper: one speed formula, four cubics, and what the text says of them."""

import json

import numpy as np
import pytest

from holodrive.experiments import Setting
from holodrive.experiments.mecanum import actuators, printed


@pytest.fixture(scope="module")
def vectors(shared_data):
    return json.loads((shared_data / "paper_vectors.json").read_text())["seed002"]


def test_equation_8_and_its_short_form_are_the_same_and_give_the_vectors(vectors):
    rng = np.random.default_rng(2)
    x, y, t = *rng.uniform(-100.0, 100.0, (2, 200)), rng.uniform(0.5, 5.0, 200)
    np.testing.assert_allclose(actuators.speed_as_printed(x, y, t), actuators.speed(x, y, t), rtol=1e-12)
    for row in vectors["eq8"]:
        assert actuators.speed(row["x"], row["y"], row["dt"]) == pytest.approx(row["v"], abs=1e-9)


def test_the_cubics_are_those_of_the_vectors(vectors):
    for name, row in vectors["eq9_12"].items():
        assert list(reversed(printed.CUBICS[name])) == row["coeff"]
        for at, pwm in row["pwm"].items():
            assert actuators.pwm_at(name, float(at)) == pytest.approx(pwm, abs=1e-9)
        assert actuators.speed_at(name, 255.0) == pytest.approx(row["v_at_255"], abs=1e-9)


@pytest.mark.parametrize("name", list(printed.CUBICS))
def test_a_cubic_read_backwards_is_its_inverse_and_zero_inside_the_dead_zone(name):
    for speed in np.linspace(0.0, 36.0, 50):
        assert actuators.speed_at(name, float(actuators.pwm_at(name, speed))) == pytest.approx(speed, abs=1e-7)
    assert actuators.speed_at(name, printed.CUBICS[name][0] - 1.0) == 0.0


@pytest.mark.parametrize("name", list(printed.CUBICS))
def test_the_least_slope_is_least_and_above_zero(name):
    slope, at = actuators.least_slope(name)
    speeds = np.linspace(0.0, 37.0, 3701)
    slopes = np.gradient(actuators.pwm_at(name, speeds), speeds)
    assert 0.0 < slope <= slopes.min() + 1e-9
    assert speeds[slopes.argmin()] == pytest.approx(at, abs=0.02)


def test_what_the_text_says_of_the_cubics_is_judged():
    claims = {c.what: c for c in actuators.linearization(Setting()).claims}
    assert claims["speed of W2W3 backward at full PWM"].verdict == "contradicts itself"
    assert claims["speed of W2W3 backward at full PWM"].ours == pytest.approx(36.966, abs=1e-3)
    assert claims["PWM of W2W3 backward at 37 mm/s, 8 bits"].verdict == "cannot be"
    assert claims["PWM of W2W3 backward at 37 mm/s, 8 bits"].ours == 255.57
    assert claims["W2W3 at a PWM of 55"].verdict == "contradicts itself"
    assert claims["speed of one PWM count, at most"].ours == pytest.approx(2.246, abs=1e-3)
    assert all(c.verdict == "agrees" for what, c in claims.items() if "rises" in what or "dead zone" in what)
