"""Duty curves: what is measured comes back, in whatever unit; what does not rise from 0 to full duty is refused."""

import json
import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from holodrive import robots
from holodrive.errors import FileFaults
from holodrive.robots.curves import CurveError, check, from_cubic, from_pieces, from_points
from holodrive.robots.spec import DutyCurve

SQRT2 = math.sqrt(2.0)
AS_KEEK = {"speed_unit_m_s": 1e-3, "counts": 255, "speed_scale": SQRT2, "radius_m": 0.03}
PAIRS = ["W1W4_F", "W1W4_B", "W2W3_F", "W2W3_B"]
CUBIC = [43.4929, 2.8629, -0.1603, 0.0056]  # Keek et al., eq. 9


def duty(curve, speed):
    """The curve at wheel speeds [rad/s], by its definition."""
    knots, pieces = np.array(curve.knots), np.array(curve.pieces)
    k = np.clip(np.searchsorted(knots, speed, side="right") - 1, 0, len(pieces) - 1)
    x = speed - knots[k]
    return pieces[k, 0] + x * (pieces[k, 1] + x * (pieces[k, 2] + x * pieces[k, 3]))


@st.composite
def measured(draw):
    """Points that rise by a whole count and some hundredth of a mm/s at least."""
    steps = draw(st.lists(st.tuples(st.integers(1, 40), st.floats(0.01, 30.0)), min_size=1, max_size=6))
    points = [(float(draw(st.integers(0, 10))), 0.0)]
    for pwm, speed in steps:
        points.append((points[-1][0] + pwm, points[-1][1] + speed))
    return np.array(points)


@pytest.mark.parametrize("name", PAIRS)
def test_a_printed_cubic_gives_its_pwm_and_ends_at_full_duty(name, shared_data):
    """Keek et al., eq. 9 to 12; the speed of the base in mm/s is sqrt 2 times that at the rim."""
    vector = json.loads((shared_data / "paper_vectors.json").read_text())["seed002"]["eq9_12"][name]
    curve = from_cubic(vector["coeff"][::-1], **AS_KEEK)
    for speed, pwm in vector["pwm"].items():
        if pwm <= 255:  # eq. 12 needs more than full duty at 37 mm/s
            assert 255 * duty(curve, float(speed) * 1e-3 * SQRT2 / 0.03) == pytest.approx(pwm, rel=1e-12)
    assert curve.knots[-1] * 0.03 / SQRT2 * 1e3 == pytest.approx(vector["v_at_255"], rel=1e-12)


@given(measured())
def test_a_curve_goes_through_its_points_and_rises_between_them(points):
    curve = from_points(points, **AS_KEEK)
    wheel = points[:, 1] * 1e-3 * SQRT2 / 0.03
    np.testing.assert_allclose(duty(curve, wheel), points[:, 0] / 255, rtol=1e-9, atol=1e-12)
    assert np.all(np.diff(duty(curve, np.linspace(0.0, wheel[-1], 2001))) > -1e-13)


@given(measured(), st.floats(1e-3, 1e3), st.floats(1e-2, 2.0))
def test_the_unit_of_the_speed_does_not_matter(points, unit, radius_m):
    """Speeds in any unit, at a wheel of any size: the same duty at the same rim speed."""
    plain = from_points(points, **AS_KEEK)
    scaled = np.column_stack([points[:, 0], points[:, 1] / unit])
    other = from_points(scaled, speed_unit_m_s=1e-3 * unit, counts=255, speed_scale=SQRT2, radius_m=radius_m)
    rim = np.linspace(0.0, plain.knots[-1] * 0.03, 50)
    np.testing.assert_allclose(duty(other, rim / radius_m), duty(plain, rim / 0.03), rtol=1e-6, atol=1e-9)


def test_two_points_are_a_straight_line():
    curve = from_points([[50, 0], [250, 40]], **AS_KEEK)
    speed = np.linspace(0.0, curve.knots[-1], 9)
    np.testing.assert_allclose(255 * duty(curve, speed), np.linspace(50, 250, 9), rtol=1e-12)


def test_a_measured_curve_does_not_end_flat():
    """It goes on straight beyond its last point, and its inverse must have a value there."""
    curve = from_points([[45, 0], [60, 1], [61, 20], [61.001, 30]], **AS_KEEK)
    _, c1, c2, c3 = curve.pieces[-1]
    length = curve.knots[-1] - curve.knots[-2]
    assert c1 + length * (2.0 * c2 + length * 3.0 * c3) > 0.0


def test_a_cubic_ends_where_it_is_told_to():
    curve = from_cubic(CUBIC, **AS_KEEK, top=20.0)
    assert curve.knots[-1] == pytest.approx(20e-3 * SQRT2 / 0.03, rel=1e-14)
    assert curve.pieces == from_cubic(CUBIC, **AS_KEEK).pieces


@given(measured())
def test_what_is_made_here_passes_the_check_and_comes_back_from_its_pieces(points):
    curve = from_points(points, **AS_KEEK)
    check(curve)
    assert from_pieces(curve.knots, curve.pieces) == curve


@pytest.mark.parametrize(
    ("curve", "message"),
    [
        (DutyCurve((0.0, 1.0), ((0.1, -0.1, 0.0, 0.0),)), "stops rising at 0 rad/s"),
        (DutyCurve((0.0, 1.0), ((0.1, 0.3, -0.2, 0.0),)), "stops rising at 0.75 rad/s"),
        (DutyCurve((0.0, 1.0), ((-0.1, 0.3, 0.0, 0.0),)), "starts at a duty of 0 or more, found -0.1"),
        (DutyCurve((0.0, 1.0), ((0.1, 1.3, 0.0, 0.0),)), "ends at a duty of 1.4, above full duty"),
        (DutyCurve((0.0, 1.0, 2.0), ((0.1, 0.3, 0.0, 0.0), (0.5, 0.1, 0.0, 0.0))), "jumps from a duty of 0.4 to 0.5"),
        (DutyCurve((0.1, 1.0), ((0.1, 0.3, 0.0, 0.0),)), "begin at 0"),
        (DutyCurve((0.0,), ()), "0 pieces and 1 knots"),
        (DutyCurve((0.0, 1.0), ((0.1, math.nan, 0.0, 0.0),)), "finite numbers only"),
    ],
)
def test_a_curve_that_is_none_is_refused(curve, message):
    with pytest.raises(CurveError, match=message):
        check(curve)


@pytest.mark.parametrize("name", ["speed_unit_m_s", "counts", "speed_scale", "radius_m"])
@pytest.mark.parametrize("value", [0.0, -1.0, math.nan, math.inf])
def test_a_scale_that_is_none_is_refused(name, value):
    for make, what in ((from_cubic, CUBIC), (from_points, [[45, 0], [255, 40]])):
        with pytest.raises(CurveError, match=name):
            make(what, **{**AS_KEEK, name: value})


def test_the_same_curve_by_wheel_speed_and_by_rim_speed():
    """A file in rad/s of the wheel and one in mm/s of its rim mean the same."""
    text = robots.load("omni3").text
    names = [wheel.name for wheel in robots.load("omni3").wheels]
    radius_mm = robots.load("omni3").wheels[0].radius * 1e3

    def described(unit, fastest):
        curve = f"{{ points = [[30, 0], [255, {fastest!r}]] }}"
        group = f"[linearizer.all]\nwheels = {json.dumps(names)}\nforward = {curve}\nbackward = {curve}\n"
        return robots.parse(f'{text}\n[linearizer]\nspeed_unit = "{unit}"\n{group}').linearizer.wheels[0].forward

    assert described("rad/s", 2.0).knots[1] == pytest.approx(2.0)
    assert described("mm/s", 2.0 * radius_mm).knots[1] == pytest.approx(2.0)


def test_the_voltage_of_a_pwm_map_is_that_of_the_battery_unless_it_says_otherwise():
    text = robots.load("mecanum4").text
    without = "\n".join(line for line in text.split("\n") if "batteries' 12.2" not in line)
    assert without != text
    changed = robots.parse(without, overrides={"battery.voltage": "11 V"})
    assert changed.pwm_map.voltage_v == 11.0
    assert robots.parse(text, overrides={"battery.voltage": "11 V"}).pwm_map.voltage_v == 12.2


def test_numbers_of_the_actuators_can_be_set_and_are_judged():
    robot = robots.load("mecanum4", {"pwm_map.dead_time": "80 ms", "pwm_map.w1w4.forward.top": 30})
    assert robot.pwm_map.dead_time_s == 0.08
    assert robot.pwm_map.wheels[1].forward.knots[-1] == pytest.approx(SQRT2)  # 30 mm/s x sqrt 2 / 30 mm
    with pytest.raises(FileFaults, match=r"there is no pwm_map 'w1w5'.*did you mean 'w1w4'"):
        robots.load("mecanum4", {"pwm_map.w1w5.forward.top": 30})
