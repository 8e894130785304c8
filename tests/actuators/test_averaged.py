"""The DC motor with inductance: Hekimoglu's transfer function, exact steps, energy."""

import json
import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from holodrive.actuators import bldc
from holodrive.actuators.averaged import averaged_substep, coupled_step
from holodrive.robots.spec import Motor
from tests.actuators.test_bldc import MAXON_LIKE

HEKIMOGLU = Motor("hekimoglu", "dc", 12.0, 46.0, 0.05, 0.4, 2.7, efficiency=0.3)  # K = 0.015, K_b = 0.05
J, D = 4e-4, 2.2e-3


def step_matrix(motor, inertia, viscous, dt):
    packed = bldc.pack_motor(motor)
    return np.array([coupled_step(packed, 0, *unit, 0.0, 0.0, inertia, viscous, dt) for unit in np.eye(2)]).T


def test_the_dc_motor_has_the_published_poles_and_gain(shared_data):
    row = json.loads((shared_data / "paper_vectors.json").read_text())["seed004"]["dc_hekimoglu"]
    poles = np.log(np.linalg.eigvals(step_matrix(HEKIMOGLU, J, D, 0.1))) / 0.1
    np.testing.assert_allclose(np.sort(poles), np.sort(row["poles"]), rtol=1e-8)
    _, omega = coupled_step(bldc.pack_motor(HEKIMOGLU), 0, 0.0, 0.0, 1.0, 0.0, J, D, 1e3)
    assert omega == pytest.approx(row["gain_rad_s_V"], rel=1e-9)
    assert row["tf_num"] / row["tf_den"][2] == pytest.approx(omega, rel=1e-9)


def test_its_position_loop_loses_stability_at_the_published_gain(shared_data):
    limit = json.loads((shared_data / "paper_vectors.json").read_text())["seed004"]["dc_hekimoglu"]
    motor = np.array([[-0.4 / 2.7, -0.05 / 2.7], [0.015 / J, -D / J]])
    dt = 1e-4
    phi = step_matrix(HEKIMOGLU, J, D, dt)
    np.testing.assert_allclose(phi, np.eye(2) + dt * motor + 0.5 * dt**2 * motor @ motor, atol=1e-8)
    for share, grows in ((0.97, False), (1.03, True)):
        gain = share * limit["P_position_gain_limit"]
        loop = np.block([[motor, np.array([[-gain / 2.7], [0.0]])], [np.array([[0.0, 1.0, 0.0]])]])
        assert (np.linalg.eigvals(loop).real.max() > 0.0) == grows


@settings(max_examples=80)
@given(
    st.floats(1e-2, 10.0), st.floats(1e-6, 3.0), st.floats(1e-3, 1.0), st.floats(1e-6, 1e-1), st.floats(0.0, 1e-2),
    st.floats(1e-5, 1.0),
)  # fmt: skip
def test_a_coupled_step_is_two_half_steps(r, inductance, k, inertia, viscous, dt):
    packed = bldc.pack_motor(replace(HEKIMOGLU, resistance_ohm=r, inductance_h=inductance, back_emf_v_s_rad=k))
    args = (6.0, 0.01, inertia, viscous)
    whole = coupled_step(packed, 0, 1.0, 2.0, *args, dt)
    half = coupled_step(packed, 0, *coupled_step(packed, 0, 1.0, 2.0, *args, dt / 2.0), *args, dt / 2.0)
    scale = 1.0 + np.abs(whole).max()
    np.testing.assert_allclose(whole, half, atol=1e-6 * scale)


def test_sub_steps_come_to_the_coupled_step():
    packed, state = bldc.pack_motor(MAXON_LIKE), np.zeros(bldc.STATE_SIZE)
    omega, dt = 0.0, 1e-6
    for _ in range(5000):
        torque = averaged_substep(state, 0, packed, 0, 0.5, 24.0, omega, dt)
        omega += dt * (torque - 0.01 - 8.9e-6 * omega) / 1.35e-5
    current, speed = coupled_step(packed, 0, 0.0, 0.0, 12.0, 0.01, 1.35e-5, 8.9e-6, 5e-3)
    assert omega == pytest.approx(speed, rel=1e-3)
    assert state[bldc.CURRENT_A] == pytest.approx(current, rel=1e-3)
    assert state[bldc.CURRENT_B] == -state[bldc.CURRENT_A]


@given(st.floats(-1.0, 1.0), st.floats(-800.0, 800.0), st.floats(-20.0, 20.0), st.floats(1e-6, 1e-1), st.floats(0, 3.0))
def test_what_the_supply_gives_is_heat_work_and_storing(duty, omega, current, dt, inductance):
    packed = bldc.pack_motor(replace(MAXON_LIKE, inductance_h=inductance))
    state = np.array([current, -current, 0.0, 0.0, 0.0, 0.0, 0.0])
    before = bldc.stored_energy(state, 0, packed, 0)
    assert before == pytest.approx(0.5 * inductance * current**2)
    torque = averaged_substep(state, 0, packed, 0, duty, 24.0, omega, dt)
    gained = bldc.stored_energy(state, 0, packed, 0) - before
    missed = state[bldc.INPUT_J] - state[bldc.COPPER_J] - state[bldc.WORK_J] - gained
    assert abs(missed) < 1e-9 * (abs(state[bldc.INPUT_J]) + state[bldc.COPPER_J] + before + abs(gained)) + 1e-12
    assert state[bldc.WORK_J] == pytest.approx(torque * omega * dt, rel=1e-9, abs=1e-15)


@pytest.mark.parametrize("dt", [1e-5, 1e-3, 0.1])
def test_a_locked_motor_settles_at_ohms_law_at_any_step(dt):
    state = np.zeros(bldc.STATE_SIZE)
    for _ in range(max(3, round(0.02 / dt))):
        averaged_substep(state, 0, bldc.pack_motor(MAXON_LIKE), 0, 1.0, 24.0, 0.0, dt)
    assert state[bldc.CURRENT_A] == pytest.approx(24.0 / 1.03)


@given(st.floats(-1.0, 1.0), st.floats(-600.0, 600.0), st.floats(-6.0, 6.0))
def test_the_drivers_limit_holds(duty, omega, current):
    packed = bldc.pack_motor(replace(MAXON_LIKE, current_limit_a=6.0))
    state = np.array([current, -current, 0.0, 0.0, 0.0, 0.0, 0.0])
    averaged_substep(state, 0, packed, 0, duty, 24.0, omega, 1e-3)
    assert abs(state[bldc.CURRENT_A]) <= 6.0 * (1.0 + 1e-12)
    assert math.isfinite(state[bldc.INPUT_J])
