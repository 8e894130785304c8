"""What is wrong in the equations and motor data of the third paper, found by computing."""

import json
import math

import numpy as np
import pytest

from holodrive.experiments import Setting
from holodrive.experiments.swerve import equations, motors, printed

SETTING = Setting()


@pytest.fixture
def vectors(shared_data):
    return json.loads((shared_data / "paper_vectors.json").read_text())["seed004"]


def test_the_chord_of_equation_6_makes_a_speed_that_vanishes_with_the_time_step():
    speeds = [equations.chord_speed(0.3, 2.0, dt) for dt in (0.1, 0.01, 0.001)]
    assert speeds == pytest.approx([0.12, 0.012, 0.0012], rel=2e-3)
    moving = equations.velocity((0.3, 0.0), np.array([1.0, -2.0, 0.7]), np.array([0.0, 0.0, 2.0]))
    assert np.hypot(*moving) == pytest.approx(0.6)


def test_corrected_rows_are_the_velocities_of_the_wheels_and_printed_ones_are_not(vectors):
    right = equations.rows(equations.PLACES)
    np.testing.assert_allclose(right, vectors["eq19_corrected_L1"], atol=1e-9)
    assert equations.largest_miss(right, equations.PLACES) < 1e-8
    assert equations.largest_miss(equations.rows(printed.EQ_19_PLACES), equations.PLACES) > 1.0


def test_the_printed_places_of_equation_19_are_badly_conditioned():
    assert equations.condition(equations.rows(printed.EQ_19_PLACES)) == pytest.approx(math.sqrt(2.0))
    assert equations.condition(equations.rows(equations.PLACES)) == pytest.approx(1.0)


def test_arctan_drives_half_of_all_directions_backwards():
    assert equations.driven_back() == 0.5


def test_only_the_corrected_motor_equations_follow_from_the_circuit(vectors):
    reference = vectors["bldc_derivative"]
    circuit = equations.by_circuit()
    np.testing.assert_allclose(circuit, [reference["dia"], reference["dib"]], rtol=1e-9)
    np.testing.assert_allclose(equations.by_model()[:3], [*circuit, reference["domega"]], rtol=1e-9)
    r, inductance = equations.constants()
    off = [equations.by_equation(printed.EQ_30, equations.CURRENTS[0]) - circuit[0],
           equations.by_equation(printed.EQ_31, equations.CURRENTS[1]) - circuit[1]]  # fmt: skip
    # the whole error of eq. 30 and 31 is 2 R i / L
    np.testing.assert_allclose(off, [-2.0 * r * i / inductance for i in equations.CURRENTS[:2]], rtol=1e-9)
    assert not np.allclose(equations.by_state_space(), circuit, rtol=0.5)


def test_a_locked_motor_draws_three_times_the_current_of_equation_30():
    as_printed, simulated = equations.locked_current()
    assert as_printed == pytest.approx(7.77, abs=0.01)
    assert simulated == pytest.approx(23.30, abs=0.01)


def test_the_three_names_of_friction_can_be_one_constant():
    a, b, c = equations.friction_readings()
    assert a == pytest.approx(b, rel=1e-12) == pytest.approx(c, rel=1e-12)


def test_every_error_of_the_equations_has_a_claim():
    wrong = [c.where for c in equations.equations(SETTING).claims if c.verdict in ("contradicts itself", "differs")]
    for number in (6, 18, 19, 20, 30, 31, 34):
        assert f"Eq. {number}" in wrong


def test_only_an_inductance_of_2_7_henry_gives_the_published_transfer_function(vectors):
    reference = vectors["dc_hekimoglu"]
    henry, milli = (motors.coefficients(value) for value in printed.DC_INDUCTANCE_H)
    np.testing.assert_allclose(henry, [reference["tf_num"], *reference["tf_den"]], rtol=1e-9)
    assert not np.allclose(milli, henry, rtol=0.5)
    np.testing.assert_allclose(sorted(np.roots(henry[1:])), sorted(reference["poles"]), rtol=1e-6)
    assert motors.largest_position_gain(2.7) == pytest.approx(reference["P_position_gain_limit"])


@pytest.mark.parametrize("inductance_h", printed.DC_INDUCTANCE_H)
def test_the_largest_position_gain_is_where_the_poles_cross(inductance_h):
    gain = motors.largest_position_gain(inductance_h)
    assert motors.slowest_decay(inductance_h, 0.999 * gain) < 0.0 < motors.slowest_decay(inductance_h, 1.001 * gain)


def test_unequal_constants_let_30_percent_of_the_power_reach_the_shaft():
    assert motors.power_to_shaft() == pytest.approx(printed.DC_MOTOR["K"] / printed.DC_MOTOR["Kb"], rel=1e-3)


@pytest.mark.parametrize(("load_n_m", "at"), [(0.0, 0), (0.05, 2)])
def test_the_averaged_motor_is_too_fast_by_what_commutation_costs(load_n_m, at, vectors):
    reference = vectors["bldc_six_step_maxon_like"]
    stepped = (reference["no_load_rpm"], reference["rpm_at_0p02Nm"], reference["rpm_at_0p05Nm"])[at]
    assert motors.rotor_rpm("six_step", load_n_m) == pytest.approx(stepped, rel=1e-2)
    assert motors.rotor_rpm("averaged", load_n_m) == pytest.approx(reference["averaged_model_rpm"][at], rel=1e-3)
