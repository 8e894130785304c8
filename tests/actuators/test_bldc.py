"""The phase model: reference vectors, symmetries of three phases, and what a packed motor means."""

import json
import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from holodrive.actuators import bldc
from holodrive.robots.spec import Motor

angles = st.floats(-20.0, 20.0)
MAXON_LIKE = Motor(
    "flat", "bldc", 24.0, 711.0, 0.0335, 1.03, 0.572e-3,
    viscous_friction_n_m_s_rad=8.9e-6, inertia_kg_m2=1.35e-5, poles=16, drive="six_step",
)  # fmt: skip


@pytest.fixture(scope="module")
def vectors(shared_data):
    return json.loads((shared_data / "paper_vectors.json").read_text())["seed004"]


def test_the_trapezoid_equals_the_reference_vectors(vectors):
    for row in vectors["trapezoid_F"]:
        assert bldc.trapezoid(math.radians(row["theta_e_deg"])) == pytest.approx(row["F"], abs=1e-9)


def test_commutation_equals_the_reference_table(vectors):
    for row in vectors["commutation"]:
        sector = bldc.sector_of(math.radians(sum(row["sector_deg"]) / 2.0))
        found = (bldc.HIGH[sector], bldc.LOW[sector], bldc.FLOATING[sector])
        assert found == tuple("abc".index(row[name]) for name in ("high", "low", "floating"))


def test_phase_derivatives_equal_the_reference_vectors(vectors):
    row = vectors["bldc_derivative"]
    motor = replace(MAXON_LIKE, resistance_ohm=2.0 * row["R"], inductance_h=2.0 * row["L"])
    rates = bldc.phase_derivatives(
        bldc.pack_motor(motor), 0, row["ia"], row["ib"], row["omega"], math.radians(row["theta_e_deg"]),
        row["Va"], row["Vb"], row["Vc"], row["TL"],
    )  # fmt: skip
    assert rates[:3] == pytest.approx((row["dia"], row["dib"], row["domega"]), rel=1e-9)
    assert rates[3] == 8 * row["omega"]


@given(angles, st.sampled_from((0.0, 1.0)))
def test_half_an_electrical_turn_reverses_the_emf(angle, sine):
    here, there = bldc.emf_shape(angle, sine), bldc.emf_shape(angle + math.pi, sine)
    assert here == pytest.approx(-there, abs=1e-9)


@given(angles)
def test_sinusoidal_phases_sum_to_nothing(angle):
    assert sum(bldc.emf_shape(angle - k * bldc.THIRD, 1.0) for k in range(3)) == pytest.approx(0.0, abs=1e-12)


@pytest.mark.parametrize("sine", [0.0, 1.0])
def test_both_shapes_have_the_constant_k_between_two_terminals(sine):
    turn = np.linspace(0.0, 2.0 * math.pi, 3601)
    between = [0.5 * (bldc.emf_shape(a, sine) - bldc.emf_shape(a - bldc.THIRD, sine)) for a in turn]
    assert max(between) == pytest.approx(1.0, abs=1e-6)


@given(angles, st.sampled_from((0.0, 1.0)), st.floats(-5.0, 5.0), st.floats(-5.0, 5.0))
def test_a_common_voltage_at_all_terminals_changes_nothing(angle, sine, i_a, common):
    packed = bldc.pack_motor(replace(MAXON_LIKE, emf="sine" if sine else "trapezoid"))
    there = bldc.phase_derivatives(packed, 0, i_a, 1.0, 100.0, angle, 5.0 + common, common, 2.0 + common, 0.0)
    here = bldc.phase_derivatives(packed, 0, i_a, 1.0, 100.0, angle, 5.0, 0.0, 2.0, 0.0)
    assert there == pytest.approx(here, rel=1e-9, abs=1e-6)


@given(angles, st.sampled_from(("sine", "trapezoid")), st.floats(-5.0, 5.0), st.floats(-5.0, 5.0))
def test_power_at_the_terminals_is_heat_plus_work_plus_storing(angle, emf, i_a, i_b):
    packed, omega, volts = bldc.pack_motor(replace(MAXON_LIKE, emf=emf)), 300.0, (9.0, 2.0, -4.0)
    di_a, di_b, domega, _ = bldc.phase_derivatives(packed, 0, i_a, i_b, omega, angle, *volts, 0.0)
    currents, rates = np.array([i_a, i_b, -i_a - i_b]), np.array([di_a, di_b, -di_a - di_b])
    torque = packed[bldc.INERTIA] * domega + packed[bldc.VISCOUS] * omega
    spent = 0.5 * 1.03 * currents @ currents + torque * omega + 0.5 * 0.572e-3 * currents @ rates
    assert spent == pytest.approx(np.array(volts) @ currents, rel=1e-9, abs=1e-9)


def test_a_packed_motor_is_the_rotor_before_its_gear():
    geared = replace(
        MAXON_LIKE, gear=9.0, back_emf_v_s_rad=9.0 * 0.0335, inertia_kg_m2=81.0 * 1.35e-5,
        viscous_friction_n_m_s_rad=81.0 * 8.9e-6, coulomb_friction_n_m=0.09,
    )  # fmt: skip
    packed = bldc.pack_motor(geared)
    bare = bldc.pack_motor(replace(MAXON_LIKE, gear=1.0, coulomb_friction_n_m=0.01))
    bare[bldc.GEAR] = 9.0
    np.testing.assert_allclose(packed, bare, rtol=1e-12)


@given(st.floats(-1e3, 1e3))
def test_wrapping_keeps_the_direction(angle):
    turned = bldc.wrapped(angle)
    assert 0.0 <= turned < 2.0 * math.pi
    assert math.cos(turned) == pytest.approx(math.cos(angle), abs=1e-9)
