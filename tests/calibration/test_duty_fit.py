"""Curves of whole calibrations: cubics come back, trimmed offsets, what no cubic fits, what the robot's file gets."""

from dataclasses import replace

import numpy as np
import pytest
from made_up_steps import LEVELS, PRINTED, all_steps, speed_of, step

from holodrive import robots
from holodrive.calibration.duty_fit import rises
from holodrive.calibration.step_file import text_with
from holodrive.calibration.steps import (
    DIRECTIONS,
    Calibration,
    analyse,
    calibrate,
    cubic_of,
    curve_values,
    fit,
    groups_of,
)
from holodrive.errors import InputError

ROBOT = robots.load("mecanum4_mice")
KEYS = list(PRINTED)


@pytest.fixture(scope="module")
def clean() -> Calibration:
    """The paper's cubics, stepped without noise."""
    return calibrate(ROBOT, all_steps())


@pytest.fixture(scope="module")
def noisy() -> Calibration:
    """The same with 1 % noise of speed in every period."""
    return calibrate(ROBOT, all_steps(noise=0.01, rng=np.random.default_rng(7)))


def speed_errors(found: Calibration, group: str, direction: str) -> np.ndarray:
    """Speed through the found curve minus the speed that was asked for, from 5 to 100 % of 36.9 mm/s [mm/s]."""
    asked = np.linspace(0.05, 1.0, 60) * 36.9e-3
    of = next(one for one in found.groups if one.name == group)
    pwm = curve_values(ROBOT, found.linearizer(ROBOT), of, direction, 255, asked)
    cubic = PRINTED[group, direction]
    return np.array([speed_of(cubic, value) for value in np.minimum(pwm, 255.0)]) - 1e3 * asked


@pytest.mark.parametrize("key", KEYS)
def test_the_printed_cubics_come_back(clean: Calibration, key: tuple[str, str]) -> None:
    """Dead zone to half a count, speed to 0.3 % of full scale, R2 near 1."""
    one = clean.fit_of(*key)
    assert one.method == "cubic"
    assert one.printed_monotone
    assert one.r2 > 0.9995
    assert one.dead_zone == pytest.approx(PRINTED[key][0], abs=0.5)
    assert one.dead_time_s == pytest.approx(0.05, abs=0.005)
    assert np.abs(speed_errors(clean, *key)).max() < 0.003 * 37.0


@pytest.mark.parametrize("key", KEYS)
def test_noise_does_not_cost_the_bars(noisy: Calibration, key: tuple[str, str]) -> None:
    """Half a per cent of full PWM and two per cent of full scale."""
    assert noisy.fit_of(*key).dead_zone == pytest.approx(PRINTED[key][0], abs=0.005 * 255)
    assert np.abs(speed_errors(noisy, *key)).max() < 0.02 * 37.0


def test_the_offset_is_trimmed_into_the_interval_of_the_dead_zone(noisy: Calibration) -> None:
    """Between the last PWM that stood and the first that moved, wherever the plain least squares puts it."""
    for one in noisy.fits:
        assert one.last_still - 0.1 <= one.dead_zone <= one.first_moving  # 0.1: what moves too slowly to be seen
        assert one.last_still == max(level for level in LEVELS if level < PRINTED[one.group, one.direction][0])


def test_exact_points_give_the_cubic_itself() -> None:
    """Least squares of exact data is interpolation, with and without a known offset."""
    c, v = PRINTED["W2W3", "forward"], np.linspace(0.5, 40.0, 9)
    pwm = c[0] + v * (c[1] + v * (c[2] + v * c[3]))
    assert cubic_of(v, pwm) == pytest.approx(c, rel=1e-9)
    assert cubic_of(v, pwm, weights=1.0 / v, offset=c[0]) == pytest.approx(c, rel=1e-9)


def test_rising_is_judged_between_the_ends_too() -> None:
    """A cubic may rise at both ends and fall between them."""
    assert all(rises(c, 43.0) for c in PRINTED.values())
    assert not rises((40.0, 1.0, -0.2, 0.008), 40.0)
    assert rises((40.0, 1.0, -0.2, 0.008), 2.0)


def from_law(law, **options: object) -> Calibration:
    """All four curves after one law: speed in mm/s of PWM."""
    records, clock = [], 0.0
    for group, direction in KEYS:
        for pwm in (40, 48, 50, 52, 55, 60, 66, 72, 80, 90, 110, 130, 150, 180, 200, 220, 255):
            records.append(step(group, direction, float(pwm), 1e-3 * law(pwm), command_s=clock, **options))  # type: ignore[arg-type]
            clock += 2.0
    return calibrate(ROBOT, records)


LAWS = {
    "saturating": lambda pwm: 38.0 * (1.0 - np.exp(-(pwm - 47.0) / 30.0)) if pwm > 47 else 0.0,
    "kinked": lambda pwm: float(np.interp(pwm, (49.0, 100.0, 130.0, 255.0), (0.0, 4.0, 30.0, 38.0))),
    "jumping": lambda pwm: 8.0 + 30.0 * (pwm - 49.0) / 206.0 if pwm > 49 else 0.0,
}


@pytest.mark.parametrize("name", LAWS)
def test_what_no_cubic_fits_falls_back_to_a_monotone_interpolant(name: str) -> None:
    """Which rises, goes through what was measured, and can be written into a robot's file."""
    found = from_law(LAWS[name])
    for one in found.fits:
        assert one.method == "points"
        assert one.max_error_m_s < 0.01 * one.top_m_s
        assert np.all(np.diff(one.points, axis=0) > 0.0)
    text = text_with(ROBOT, found, "mine.toml")
    assert robots.parse(text).linearizer == found.linearizer(ROBOT)
    of = found.groups[0]
    v = np.linspace(0.0, 0.037, 400)
    assert np.all(np.diff(curve_values(ROBOT, found.linearizer(ROBOT), of, "forward", 255, v)) > 0.0)


def test_speeds_that_fall_with_pwm_are_pooled() -> None:
    """A noisy plateau makes no curve that falls."""
    wobble = from_law(lambda pwm: LAWS["saturating"](pwm) + (0.6 if pwm in (150, 200) else 0.0))
    assert all(np.all(np.diff(one.points, axis=0) > 0.0) for one in wobble.fits)
    wobble.linearizer(ROBOT)


def test_too_few_moving_steps_are_refused() -> None:
    """A cubic takes four."""
    steps = [
        analyse(step("W1W4", "forward", pwm, speed)) for pwm, speed in ((40, 0), (60, 0.01), (90, 0.02), (255, 0.04))
    ]
    with pytest.raises(InputError, match="W1W4 forward has 3 PWM values that move"):
        fit(steps)


def test_the_file_says_what_was_found_and_keeps_the_rest(clean: Calibration) -> None:
    """Comments stay, curves are the same numbers, and a comment tells where they come from."""
    text = text_with(ROBOT, clean, "mine.toml")
    again = robots.parse(text)
    assert again.linearizer == clean.linearizer(ROBOT)
    assert replace(again, linearizer=None, text="") == replace(ROBOT, linearizer=None, text="")
    kept = [line for line in ROBOT.text.splitlines() if "#" in line and "Keek, eq." not in line and "255" not in line]
    assert [line for line in kept if line not in text.splitlines() and "speed_scale" not in line] == []
    assert text.count("holodrive calibrate steps: cubic of") == 4


def test_groups_are_the_diagonals_of_the_paper() -> None:
    """W1W4 drives to the left ahead: front right and rear left; any other base goes wheel by wheel."""
    names = [[wheel.name for wheel in ROBOT.wheels][i] for group in groups_of(ROBOT) for i in group.wheels]
    assert [group.name for group in groups_of(ROBOT)] == ["W1W4", "W2W3"]
    assert set(names[:2]) == {"fr", "rl"}
    omni = robots.load("omni3")
    assert [group.name for group in groups_of(omni)] == [wheel.name for wheel in omni.wheels]
    assert all(not group.diagonal and group.speed_scale == 1.0 for group in groups_of(omni))
    assert DIRECTIONS == ("forward", "backward")


def test_wheels_without_encoders_are_refused_by_name() -> None:
    """Unless their steps were measured elsewhere."""
    omni = robots.load("omni3")
    blind = replace(omni, wheels=tuple(replace(wheel, encoder=None) for wheel in omni.wheels))
    with pytest.raises(InputError, match="has no encoder to measure by"):
        groups_of(blind)
    assert len(groups_of(blind, measured_elsewhere=True)) == 3
    mute = replace(ROBOT, mice=())
    with pytest.raises(InputError, match="neither two mice nor encoders"):
        groups_of(mute)
