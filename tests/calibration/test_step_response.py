"""One step: equation 8, start of motion, dead time, and why the slope of the tail is what counts."""

import json
import math
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from made_up_steps import WAY, step

from holodrive.calibration.steps import StepRecord, analyse, speed_eq8


@given(x=st.floats(-1.0, 1.0), y=st.floats(-1.0, 1.0), dt=st.floats(0.1, 10.0))
def test_equation_8_is_its_closed_form(x: float, y: float, dt: float) -> None:
    """sqrt(x^2 + y^2) / dt cos(45 deg - atan|y / x|) = (|x| + |y|) / (sqrt 2 dt), where the printed one exists."""
    if abs(x) < 1e-9:
        return
    printed = math.hypot(x, y) / dt * math.cos(math.radians(45.0) - math.atan(abs(y / x)))
    assert speed_eq8(x, y, dt) == pytest.approx(printed, rel=1e-12)


def test_equation_8_agrees_with_the_reference_vectors(shared_data: Path) -> None:
    """Which are in mm."""
    for one in json.loads((shared_data / "paper_vectors.json").read_text())["seed002"]["eq8"]:
        assert speed_eq8(one["x"], one["y"], one["dt"]) == pytest.approx(one["v"], rel=1e-12)


@pytest.mark.parametrize("way", WAY)
def test_a_step_is_the_same_in_all_four_actuations(way: tuple[str, str]) -> None:
    """Signs of x and y do not matter."""
    one, first = analyse(step(*way, 80.0, 0.02)), analyse(step("W1W4", "forward", 80.0, 0.02))
    assert one.speed_tail_m_s == pytest.approx(first.speed_tail_m_s, rel=1e-9)
    assert one.dead_time_s == pytest.approx(first.dead_time_s, abs=1e-9)


@pytest.mark.parametrize("lag_s", [0.02, 0.05, 0.1])
@pytest.mark.parametrize("dead_s", [0.02, 0.047, 0.08])
@pytest.mark.parametrize("speed", [0.002, 0.01, 0.037])
def test_tail_dead_time_and_lag_come_back(speed: float, dead_s: float, lag_s: float) -> None:
    """From whole counts at 15 ms; the speed to a few parts in a thousand, the dead time finer than a sample."""
    one = analyse(step("W1W4", "forward", 80.0, speed, dead_s=dead_s, lag_s=lag_s))
    assert one.moved
    assert one.settled
    assert one.speed_tail_m_s == pytest.approx(speed, rel=3e-3)
    assert one.dead_time_s == pytest.approx(dead_s, abs=0.008 if speed >= 0.01 else 0.012)
    assert one.lag_s == pytest.approx(lag_s, abs=0.012)
    assert one.start_s >= dead_s - 0.015
    if speed >= 0.01:
        assert one.start_s <= dead_s + 0.04


def test_equation_8_takes_the_lag_for_slowness_and_the_tail_does_not() -> None:
    """The mean since the start of motion misses v lag / T."""
    one = analyse(step("W2W3", "forward", 80.0, 0.03, dead_s=0.045, lag_s=0.1))
    assert one.speed_eq8_m_s < 0.95 * 0.03
    assert one.speed_eq8_m_s == pytest.approx(0.03 * (1.0 - 0.1 / 1.44), rel=0.02)
    assert one.speed_tail_m_s == pytest.approx(0.03, rel=2e-3)


def test_without_lag_both_speeds_agree() -> None:
    """Equation 8 is right about wheels that follow at once."""
    one = analyse(step("W2W3", "forward", 80.0, 0.03, dead_s=0.045, lag_s=1e-4))
    assert one.speed_eq8_m_s == pytest.approx(one.speed_tail_m_s, rel=5e-3)


def test_a_step_in_the_dead_zone_has_not_moved() -> None:
    """Nor has one that flickers by two counts."""
    still = step("W1W4", "forward", 40.0, 0.0)
    assert not analyse(still).moved
    flicker = StepRecord("W1W4", "forward", 40.0, still.time, 1e-5 * (np.arange(101) % 3), still.y)
    assert not analyse(flicker).moved


def test_a_step_that_ends_while_it_gains_speed_says_so() -> None:
    """0.3 s are too short for a lag of 0.3 s."""
    assert not analyse(step("W1W4", "forward", 200.0, 0.03, lag_s=0.3, ticks=20)).settled


def test_what_is_found_does_not_depend_on_the_clock() -> None:
    """The command may come at any time."""
    one, late = (analyse(step("W1W4", "forward", 80.0, 0.02, command_s=at)) for at in (0.0, 1000.0))
    assert late.dead_time_s == pytest.approx(one.dead_time_s, abs=1e-9)
    assert late.speed_tail_m_s == pytest.approx(one.speed_tail_m_s, rel=1e-9)
    assert late.start_s - 1000.0 == pytest.approx(one.start_s, abs=1e-9)
