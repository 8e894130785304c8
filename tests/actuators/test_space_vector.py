"""Three phases as a vector: inverses, lengths, power, and what three legs can make."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from holodrive.actuators.space_vector import clarke, inverse_clarke, inverse_park, leg_duties, park, within_circle

values, angles = st.floats(-50.0, 50.0), st.floats(-20.0, 20.0)
BUS = 24.0
CIRCLE = BUS / math.sqrt(3.0)


@given(values, values)
def test_clarke_of_its_inverse_is_the_identity_and_phases_sum_to_nothing(alpha, beta):
    phases = inverse_clarke(alpha, beta)
    assert clarke(*phases) == pytest.approx((alpha, beta), abs=1e-12)
    assert sum(phases) == pytest.approx(0.0, abs=1e-12)


@given(values, values, values)
def test_the_inverse_of_clarke_is_the_phases_without_their_mean(a, b, c):
    mean = (a + b + c) / 3.0
    assert inverse_clarke(*clarke(a, b, c)) == pytest.approx((a - mean, b - mean, c - mean), abs=1e-11)


@given(values, values, angles)
def test_park_of_its_inverse_is_the_identity_and_keeps_lengths(d, q, angle):
    alpha, beta = inverse_park(d, q, angle)
    assert park(alpha, beta, angle) == pytest.approx((d, q), abs=1e-12)
    assert math.hypot(alpha, beta) == pytest.approx(math.hypot(d, q), abs=1e-12)


@given(st.floats(0.0, 50.0), angles, angles)
def test_balanced_phases_stand_still_in_a_frame_that_turns_with_them(amplitude, phase, angle):
    a, b, c = (amplitude * math.cos(angle + phase - k * 2.0 * math.pi / 3.0) for k in range(3))
    d, q = park(*clarke(a, b, c), angle)
    assert (d, q) == pytest.approx((amplitude * math.cos(phase), amplitude * math.sin(phase)), abs=1e-11)


@given(values, values, values, values)
def test_power_is_three_halves_of_the_product_of_vectors(v_alpha, v_beta, i_alpha, i_beta):
    power = np.dot(inverse_clarke(v_alpha, v_beta), inverse_clarke(i_alpha, i_beta))
    assert power == pytest.approx(1.5 * (v_alpha * i_alpha + v_beta * i_beta), abs=1e-9)


@given(values, values, st.floats(0.0, 30.0))
def test_a_circle_keeps_what_fits_and_the_first_before_the_second(d, q, radius):
    kept = within_circle(d, q, radius)
    if math.hypot(d, q) <= radius:
        assert kept == (d, q)
        return
    assert math.hypot(*kept) == pytest.approx(radius, abs=1e-9)
    assert kept[0] == pytest.approx(math.copysign(min(abs(d), radius), d))
    assert kept[1] * q >= 0.0


@given(st.floats(0.0, CIRCLE), angles)
def test_legs_make_every_vector_inside_the_circle(length, angle):
    v = (length * math.cos(angle), length * math.sin(angle))
    duties = leg_duties(*v, BUS)
    assert min(duties) >= 0.0
    assert max(duties) <= 1.0
    assert clarke(*(BUS * duty for duty in duties)) == pytest.approx(v, abs=1e-12)
    assert max(duties) + min(duties) == pytest.approx(1.0)  # both rails have the same room


def test_the_circle_is_the_widest_one_and_15_percent_wider_than_with_sinusoidal_legs():
    turn = np.linspace(0.0, 2.0 * math.pi, 721)
    for share, exact in ((1.0, True), (1.01, False)):
        made = [clarke(*leg_duties(*inverse_park(share * CIRCLE, 0.0, a), BUS)) for a in turn]
        short = share * CIRCLE - BUS * np.linalg.norm(made, axis=1)
        assert (short.max() < 1e-9) == exact
    assert math.isclose(2.0 * CIRCLE / BUS, 1.1547, rel_tol=1e-4)


def test_legs_without_a_supply_do_nothing():
    assert leg_duties(0.0, 0.0, 0.0) == (0.5, 0.5, 0.5)
