"""Duty and speed of measured actuators: inverse of one another, in each direction by its own curve."""

import json
import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from holodrive.actuators.duty_curve import curve_at, duty_of, inverse_at, pack, speed_of
from holodrive.robots.curves import from_cubic, from_points
from holodrive.robots.spec import DutyMap

SQRT2 = math.sqrt(2.0)
AS_KEEK = {"speed_unit_m_s": 1e-3, "counts": 255, "speed_scale": SQRT2, "radius_m": 0.03}
RAD_S = 1e-3 * SQRT2 / 0.03  # wheel speed for 1 mm/s of the pair
PAIRS = ["W1W4_F", "W1W4_B", "W2W3_F", "W2W3_B"]


@pytest.fixture(scope="module")
def printed(shared_data):
    """Keek et al., eq. 9 to 12: coefficients (highest first), PWM at some speeds, speed at full duty."""
    return json.loads((shared_data / "paper_vectors.json").read_text())["seed002"]["eq9_12"]


def keek(printed):
    """Two wheels: one of each pair."""
    curve = {name: from_cubic(printed[name]["coeff"][::-1], **AS_KEEK) for name in PAIRS}
    return [DutyMap(curve["W1W4_F"], curve["W1W4_B"]), DutyMap(curve["W2W3_F"], curve["W2W3_B"])]


@st.composite
def measured(draw):
    """Points from a dead zone up to full duty, at up to 60 mm/s."""
    start = draw(st.integers(1, 80))
    steps = draw(st.lists(st.tuples(st.floats(1.0, 20.0), st.floats(0.05, 10.0)), min_size=1, max_size=6))
    points = [(float(start), 0.0)]
    for pwm, speed in steps:
        points.append((points[-1][0] + pwm, points[-1][1] + speed))
    return from_points(points, **AS_KEEK)


@pytest.mark.parametrize("name", PAIRS)
def test_a_printed_cubic_is_duty_over_speed_and_its_inverse_speed_over_duty(name, printed):
    curves = pack(keek(printed))
    wheel, sign = PAIRS.index(name) // 2, 1.0 if name.endswith("F") else -1.0
    for mm_s, pwm in printed[name]["pwm"].items():
        speed, duty = sign * float(mm_s) * RAD_S, sign * pwm / 255
        if speed == 0.0:
            assert speed_of(curves, 0, wheel, duty) == 0.0  # where the dead zone ends
        elif pwm <= 255:
            assert duty_of(curves, 0, wheel, speed) == pytest.approx(duty, rel=1e-12)
            assert speed_of(curves, 0, wheel, duty) == pytest.approx(speed, rel=1e-9)
        else:  # eq. 12 at 37 mm/s
            assert duty_of(curves, 0, wheel, speed) == sign
    fastest = printed[name]["v_at_255"] * RAD_S
    assert speed_of(curves, 0, wheel, sign) == pytest.approx(sign * fastest, rel=1e-12)


@pytest.mark.parametrize("name", PAIRS)
def test_the_inverse_is_the_one_real_root_of_the_cubic(name, printed):
    """Agreement with a second method: eigenvalues of the companion matrix."""
    curves = pack(keek(printed))
    wheel, sign = PAIRS.index(name) // 2, 1.0 if name.endswith("F") else -1.0
    high, *rest = printed[name]["coeff"]
    for pwm in range(math.ceil(rest[-1]), 256):
        roots = np.roots([high, *rest[:-1], rest[-1] - pwm])
        (root,) = roots[np.abs(roots.imag) < 1e-9].real
        assert speed_of(curves, 0, wheel, sign * pwm / 255) == pytest.approx(sign * root * RAD_S, rel=1e-9)


@given(measured(), measured(), st.floats(-1.0, 1.0), st.floats(-1.0, 1.0))
def test_curve_and_inverse_are_inverse_of_one_another(forward, backward, part, duty):
    curves = pack([DutyMap(forward, backward)])
    known = forward if part > 0.0 else backward
    speed = part * known.knots[-1]
    back = speed_of(curves, 0, 0, duty_of(curves, 0, 0, speed))
    assert back == pytest.approx(speed, rel=1e-7, abs=1e-9 * known.knots[-1])
    known = forward if duty > 0.0 else backward
    if abs(duty) > known.pieces[0][0]:
        assert duty_of(curves, 0, 0, speed_of(curves, 0, 0, duty)) == pytest.approx(duty, rel=1e-9)
    else:
        assert speed_of(curves, 0, 0, duty) == 0.0


@given(measured())
def test_more_duty_never_gives_less_speed(curve):
    curves = pack([DutyMap(curve, curve)])
    speeds = [speed_of(curves, 0, 0, duty) for duty in np.linspace(-1.5, 1.5, 301)]
    assert np.all(np.diff(speeds) >= 0.0)


@given(measured(), st.floats(-2.0, 2.0))
def test_the_same_curve_both_ways_is_odd(curve, value):
    curves = pack([DutyMap(curve, curve)])
    assert speed_of(curves, 0, 0, -value) == -speed_of(curves, 0, 0, value)
    assert duty_of(curves, 0, 0, -value) == -duty_of(curves, 0, 0, value)


def test_a_wheel_that_shall_stand_gets_no_duty_and_any_motion_at_least_the_dead_zone(printed):
    curves = pack(keek(printed))
    assert duty_of(curves, 0, 0, 0.0) == 0.0
    assert duty_of(curves, 0, 0, 1e-12) == pytest.approx(43.4929 / 255)
    assert duty_of(curves, 0, 1, -1e-12) == pytest.approx(-54.96069 / 255)


def test_a_full_battery_goes_on_along_the_end_of_the_curve(printed):
    """Beyond full duty of the measured voltage the speed goes on straight, with the slope of the end."""
    curves = pack(keek(printed))
    end, step = speed_of(curves, 0, 0, 1.0), 1e-6
    before = end - speed_of(curves, 0, 0, 1.0 - step)
    assert speed_of(curves, 0, 0, 1.0 + step) - end == pytest.approx(before, rel=1e-4)
    assert speed_of(curves, 0, 0, 1.2) - end == pytest.approx(0.2 / step * before, rel=1e-4)


def test_no_command_asks_for_more_than_full_duty(printed):
    curves = pack(keek(printed))
    assert [duty_of(curves, 0, wheel, speed) for wheel in (0, 1) for speed in (-1e3, 1e3)] == [-1.0, 1.0, -1.0, 1.0]


def test_a_duty_that_is_no_number_gives_no_speed(printed):
    assert math.isnan(speed_of(pack(keek(printed)), 0, 0, math.nan))
    assert math.isnan(duty_of(pack(keek(printed)), 0, 0, math.nan))


def test_curves_are_found_wherever_they_are_packed(printed):
    maps = keek(printed)
    curves = pack(maps)
    moved = np.concatenate([np.full(7, math.nan), curves])
    for wheel in (0, 1):
        for value in (-0.9, 0.3, 1.2):
            assert duty_of(moved, 7, wheel, value) == duty_of(curves, 0, wheel, value)
            assert speed_of(moved, 7, wheel, value) == speed_of(curves, 0, wheel, value)
    for wheel, known in enumerate(maps):
        for way, curve in enumerate((known.forward, known.backward)):
            at = int(curves[2 * wheel + way])
            assert curve_at(curves, at, 0.5) == pytest.approx(np.polyval(curve.pieces[0][::-1], 0.5))
            assert inverse_at(curves, at, curve_at(curves, at, 0.5)) == pytest.approx(0.5)
