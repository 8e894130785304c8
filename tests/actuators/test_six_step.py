"""Six-step drive: diodes, Hall edges, limits and energy, against a plain integration of the phase equations."""

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from holodrive.actuators import bldc
from holodrive.actuators.six_step import six_step_substep
from holodrive.leaf import leaf
from tests.actuators.test_bldc import MAXON_LIKE

BUS = 24.0
SINUS = replace(MAXON_LIKE, emf="sine")


def driven(motor, duty, omega, steps, dt, state=None, bus=BUS):
    """State and torques of a motor whose rotor is turned at a constant speed."""
    state = np.zeros(bldc.STATE_SIZE) if state is None else state
    packed = bldc.pack_motor(motor)
    torques = [six_step_substep(state, 0, packed, 0, duty, bus, omega, dt) for _ in range(steps)]
    return state, np.array(torques)


@leaf
def _plain(params, duty, bus, omega, i, angle, steps, dt):
    """Explicit Euler with tiny steps and the rule for the open phase's voltage written out."""
    torque = 0.0
    for _ in range(steps):
        sector = bldc.sector_of(angle)
        h, l, f = bldc.HIGH[sector], bldc.LOW[sector], bldc.FLOATING[sector]  # noqa: E741
        if duty < 0.0:
            h, l = l, h  # noqa: E741
        k = 0.5 * params[bldc.BACK_EMF] * omega
        e_h = k * bldc.emf_shape(angle - h * bldc.THIRD, params[bldc.SINE])
        e_l = k * bldc.emf_shape(angle - l * bldc.THIRD, params[bldc.SINE])
        e_f = k * bldc.emf_shape(angle - f * bldc.THIRD, params[bldc.SINE])
        v_h = abs(duty) * bus
        v_open = 0.5 * (v_h - e_h - e_l) + e_f
        v_f = v_open
        if abs(i[f]) > 1e-9:
            v_f = 0.0 if i[f] > 0.0 else bus
        elif v_open < 0.0:
            v_f = 0.0
        elif v_open > bus:
            v_f = bus
        v_a = v_h if h == 0 else (v_f if f == 0 else 0.0)
        v_b = v_h if h == 1 else (v_f if f == 1 else 0.0)
        v_c = v_h if h == 2 else (v_f if f == 2 else 0.0)
        di_a, di_b, _, _ = bldc.phase_derivatives(params, 0, i[0], i[1], omega, angle, v_a, v_b, v_c, 0.0)
        before = i[f]
        i[0] += dt * di_a
        i[1] += dt * di_b
        i[2] = -i[0] - i[1]
        if before * i[f] < 0.0:  # the diode has let its current go to 0
            i[h] += i[f]
            i[f] = 0.0
            i[l] = -i[h]
        torque += (e_h * i[h] + e_l * i[l] + e_f * i[f]) / omega / steps
        angle = bldc.wrapped(angle + dt * params[bldc.PAIRS] * omega)
    return torque


@pytest.mark.parametrize("motor", [MAXON_LIKE, SINUS], ids=["trapezoid", "sine"])
@pytest.mark.parametrize(("duty", "omega"), [(1.0, 600.0), (0.4, 200.0), (0.3, 500.0), (-0.7, 300.0), (-0.8, -500.0)])
def test_sub_steps_equal_a_plain_integration_with_tiny_ones(motor, duty, omega):
    packed, time = bldc.pack_motor(motor), 4e-3
    i = np.zeros(3)
    mean = _plain(packed, duty, BUS, omega, i, 0.3, 400_000, time / 400_000)
    start = np.zeros(bldc.STATE_SIZE)
    start[bldc.ANGLE] = 0.3
    state, torques = driven(motor, duty, omega, 400, time / 400, start)
    assert torques.mean() == pytest.approx(mean, rel=2e-3)
    np.testing.assert_allclose(state[:3], i, atol=2e-2 * np.abs(i).max() + 1e-2)


@settings(max_examples=60)
@given(
    st.floats(-1.0, 1.0), st.floats(-1100.0, 1100.0), st.floats(0.0, 6.28), st.sampled_from(("trapezoid", "sine")),
    st.floats(-8.0, 8.0), st.floats(-8.0, 8.0), st.sampled_from((1e-5, 2e-5, 1e-3)), st.sampled_from((1e-4, 1.0, 10.0)),
)  # fmt: skip
def test_what_the_supply_gives_is_heat_work_and_storing(duty, omega, angle, emf, i_a, i_b, dt, inductance):
    motor = replace(MAXON_LIKE, emf=emf, inductance_h=inductance * 0.572e-3)
    packed = bldc.pack_motor(motor)
    start = np.array([i_a, i_b, -i_a - i_b, angle, 0.0, 0.0, 0.0])
    before = bldc.stored_energy(start, 0, packed, 0)
    state, torques = driven(motor, duty, omega, 50, dt, start)
    assert np.isfinite(state).all()
    assert abs(state[:3].sum()) < 1e-12
    growth = bldc.stored_energy(state, 0, packed, 0) - before
    turned_over = abs(state[bldc.INPUT_J]) + state[bldc.COPPER_J] + before
    missed = state[bldc.INPUT_J] - state[bldc.COPPER_J] - state[bldc.WORK_J] - growth
    assert abs(missed) < 1e-9 * turned_over + 1e-15
    assert state[bldc.WORK_J] == pytest.approx(torques.sum() * omega * dt, rel=1e-9, abs=1e-15)


@settings(max_examples=60)
@given(st.floats(-1100.0, 1100.0), st.floats(0.0, 6.28), st.floats(-8.0, 8.0), st.floats(-8.0, 8.0))
def test_a_passive_motor_takes_no_energy_from_its_supply(omega, angle, i_a, i_b):
    start = np.array([i_a, i_b, -i_a - i_b, angle, 0.0, 0.0, 0.0])
    state, _ = driven(MAXON_LIKE, 0.0, omega, 200, 2e-5, start)
    assert state[bldc.INPUT_J] <= 1e-15
    assert state[bldc.COPPER_J] >= -1e-15


def test_the_open_phase_feeds_its_current_back_into_the_supply():
    start = np.array([0.0, 3.0, -3.0, 0.1, 0.0, 0.0, 0.0])  # a, b driven; c carries current out
    state, _ = driven(MAXON_LIKE, 0.0, 0.0, 1, 1e-5, start)
    assert state[bldc.INPUT_J] < -0.9 * BUS * 2.5 * 1e-5
    state, _ = driven(MAXON_LIKE, 0.0, 0.0, 50, 1e-5, state)
    assert state[bldc.CURRENT_C] == 0.0
    assert state[bldc.CURRENT_A] == -state[bldc.CURRENT_B]


@pytest.mark.parametrize("duty", [1.0, 0.3])
def test_a_locked_rotor_settles_at_ohms_law_between_two_terminals(duty):
    start = np.zeros(bldc.STATE_SIZE)
    start[bldc.ANGLE] = 0.5
    state, torques = driven(MAXON_LIKE, duty, 0.0, 1000, 2e-5, start)
    assert state[:3] == pytest.approx([duty * BUS / 1.03, -duty * BUS / 1.03, 0.0])  # 23.3 A at full duty
    assert torques[-1] == pytest.approx(0.0335 * duty * BUS / 1.03)


@given(st.floats(-1.0, 1.0), st.floats(-1000.0, 1000.0), st.floats(0.05, 6.2))
def test_a_mirrored_motor_has_the_mirrored_torque(duty, omega, angle):
    """Turning back with b and c exchanged and every EMF as before is the same motor."""
    one, other = np.zeros(bldc.STATE_SIZE), np.zeros(bldc.STATE_SIZE)
    one[bldc.ANGLE], other[bldc.ANGLE] = angle, bldc.wrapped(5.0 * bldc.SECTOR - angle)
    _, torques = driven(MAXON_LIKE, duty, omega, 40, 2e-5, one)
    _, mirrored = driven(MAXON_LIKE, -duty, -omega, 40, 2e-5, other)
    np.testing.assert_allclose(mirrored, -torques, rtol=1e-6, atol=1e-7)


@given(st.floats(-1.0, 1.0), st.floats(-500.0, 500.0), st.sampled_from(("trapezoid", "sine")))
def test_the_driven_phases_stay_within_the_drivers_limit(duty, omega, emf):
    motor = replace(MAXON_LIKE, emf=emf, current_limit_a=6.0)
    state = np.zeros(bldc.STATE_SIZE)
    packed = bldc.pack_motor(motor)
    worst = 0.0
    for _ in range(300):
        six_step_substep(state, 0, packed, 0, duty, BUS, omega, 2e-5)
        worst = max(worst, np.abs(state[:3]).max())
    assert worst < 1.1 * 6.0


def test_ten_thousand_rpm_and_a_tenth_of_a_millisecond_are_stable():
    fast = replace(MAXON_LIKE, inductance_h=1.03e-4)  # L / R = 0.1 ms
    omega = 10_000 * math.pi / 30.0
    _, coarse = driven(fast, 1.0, omega, 2000, 2e-5, bus=48.0)
    _, fine = driven(fast, 1.0, omega, 40_000, 1e-6, bus=48.0)
    assert coarse[1000:].mean() == pytest.approx(fine[20_000:].mean(), rel=5e-3)
    assert np.abs(coarse).max() < 0.0335 * 1.2 * 2.0 * 48.0 / 1.03


def test_two_half_sub_steps_are_nearly_one():
    one, _ = driven(MAXON_LIKE, 0.8, 400.0, 500, 2e-5)
    two, _ = driven(MAXON_LIKE, 0.8, 400.0, 1000, 1e-5)
    np.testing.assert_allclose(two[:3], one[:3], atol=0.01 * np.abs(one[:3]).max())
    assert two[bldc.INPUT_J] == pytest.approx(one[bldc.INPUT_J], rel=1e-3)
