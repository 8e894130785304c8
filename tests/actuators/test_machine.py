"""One motor on the bench: published speeds, the energy balance, ripple and its own faults."""

import json
import math
from dataclasses import replace

import numpy as np
import pytest

from holodrive.actuators.averaged import coupled_step
from holodrive.actuators.bldc import pack_motor
from holodrive.actuators.machine import FocLoops, ideal_six_step_torque, ripple, simulate
from holodrive.errors import InputError
from tests.actuators.test_averaged import HEKIMOGLU
from tests.actuators.test_bldc import MAXON_LIKE

RPM = 30.0 / math.pi
SINUS = replace(MAXON_LIKE, emf="sine")
TURN = np.linspace(0.0, 2.0 * math.pi, 36_000, endpoint=False)


def steady_rpm(motor, load, dt=2e-5, **options):
    traces = simulate(motor, 1.0, load, 0.6, dt, every=10, **options)
    return traces.speed[traces.time > 0.5].mean() * RPM


def test_six_step_and_averaged_speeds_equal_the_reference(shared_data):
    row = json.loads((shared_data / "paper_vectors.json").read_text())["seed004"]["bldc_six_step_maxon_like"]
    expected = (row["no_load_rpm"], row["rpm_at_0p02Nm"], row["rpm_at_0p05Nm"])
    for load, six_step, averaged in zip((0.0, 0.02, 0.05), expected, row["averaged_model_rpm"], strict=True):
        assert steady_rpm(MAXON_LIKE, load) == pytest.approx(six_step, rel=1e-3)
        assert steady_rpm(MAXON_LIKE, load, drive="averaged") == pytest.approx(averaged, rel=1e-4)


def test_sub_steps_of_20_us_are_right_to_a_thousandth_and_of_50_us_to_four():
    fine = steady_rpm(MAXON_LIKE, 0.05, 2e-6)
    assert steady_rpm(MAXON_LIKE, 0.05, 2e-5) == pytest.approx(fine, rel=1e-3)
    assert steady_rpm(MAXON_LIKE, 0.05, 5e-5) == pytest.approx(fine, rel=2.4e-3)


@pytest.mark.parametrize("drive", ["six_step", "averaged", "foc"])
@pytest.mark.parametrize("emf", ["trapezoid", "sine"])
@pytest.mark.parametrize("load", [0.02, -0.1])
@pytest.mark.parametrize("limit", [math.inf, 6.0])
def test_energy_balances_over_starting_braking_and_reversing(drive, emf, load, limit):
    motor = replace(MAXON_LIKE, emf=emf, current_limit_a=limit, coulomb_friction_n_m=2e-3)
    duty = np.repeat([1.0, 0.2, 0.0, -0.7, 0.5], 3000)
    traces = simulate(motor, duty, load, 0.3, 2e-5, drive=drive, every=5)
    assert abs(traces.energy_residual()) < 1e-3
    assert traces.electrical_w.min() < 0.0  # braking feeds the supply
    assert traces.copper_w.min() >= 0.0
    assert traces.friction_w.min() >= 0.0
    assert np.abs(traces.currents).max() < 1.1 * limit


@pytest.mark.parametrize("drive", ["six_step", "averaged"])
def test_a_motor_that_turns_by_itself_only_loses_energy(drive):
    traces = simulate(MAXON_LIKE, 0.0, 0.0, 0.2, 2e-5, drive=drive, speed_rad_s=900.0)
    stored = np.concatenate([[traces.stored_start_j], traces.stored_j])
    assert np.all(np.diff(stored) <= 1e-12)
    assert stored[-1] < 1e-3 * stored[0]
    assert traces.electrical_w.max() <= 1e-9


def test_a_gear_changes_the_shaft_and_not_the_rotor():
    geared = replace(
        MAXON_LIKE, gear=9.0, back_emf_v_s_rad=9.0 * 0.0335, inertia_kg_m2=81.0 * 1.35e-5,
        viscous_friction_n_m_s_rad=81.0 * 8.9e-6,
    )  # fmt: skip
    rotor = simulate(MAXON_LIKE, 0.8, 0.03, 0.05, 2e-5)
    shaft = simulate(geared, 0.8, 0.27, 0.05, 2e-5)
    np.testing.assert_allclose(9.0 * shaft.speed, rotor.speed, rtol=1e-6, atol=1e-6)
    np.testing.assert_allclose(shaft.torque, 9.0 * rotor.torque, rtol=1e-5, atol=1e-6)
    np.testing.assert_allclose(shaft.currents, rotor.currents, rtol=1e-5, atol=1e-5)
    np.testing.assert_allclose(shaft.mechanical_w, rotor.mechanical_w, rtol=1e-6, atol=1e-9)


def test_forward_and_backward_are_the_same_motor():
    forward, backward = (simulate(MAXON_LIKE, sign, 0.0, 0.3, 2e-5).speed[-1000:].mean() for sign in (1.0, -1.0))
    assert backward == pytest.approx(-forward, rel=1e-5)


def test_the_bench_at_one_millisecond_follows_the_exact_dc_motor():
    motor = replace(HEKIMOGLU, inertia_kg_m2=4e-4, viscous_friction_n_m_s_rad=2.2e-3)
    traces = simulate(motor, 5.12 / 12.0, 0.0, 2.0, 1e-3)
    exact = coupled_step(pack_motor(motor), 0, 0.0, 0.0, 5.12, 0.0, 4e-4, 2.2e-3, 2.0)
    assert (traces.currents[-1, 0], traces.speed[-1]) == pytest.approx(exact, rel=1e-4)
    assert abs(traces.energy_residual()) < 1e-3


def test_ideal_six_step_currents_ripple_on_a_sine_and_not_on_a_trapezoid():
    sine = ideal_six_step_torque(replace(MAXON_LIKE, emf="sine"), 2.0, TURN)
    theory = (1.0 - math.cos(math.pi / 6.0)) / (3.0 / math.pi)  # 14 %
    assert ripple(sine) == pytest.approx(theory, rel=1e-3)
    trapezoid = ideal_six_step_torque(MAXON_LIKE, 2.0, TURN)
    assert ripple(trapezoid) < 1e-12
    assert trapezoid.mean() == pytest.approx(2.0 * 0.0335)


def test_real_commutation_ripples_on_the_trapezoid_too():
    traces = simulate(MAXON_LIKE, 1.0, 0.05, 0.6, 1e-5, inertia_kg_m2=1e-4)
    assert ripple(traces.torque[-5000:]) > 0.2


@pytest.mark.parametrize("emf", ["sine", "trapezoid"])
def test_field_oriented_torque_ripples_by_less_than_2_percent_on_a_sine(emf):
    motor = replace(MAXON_LIKE, emf=emf)
    steady = simulate(motor, 300.0, 0.05, 0.4, 2e-5, drive="foc", mode="speed", inertia_kg_m2=1e-4, speed_rad_s=300.0)
    worst = ripple(steady.torque[-5000:])
    assert worst < 0.02 if emf == "sine" else worst > 0.02
    shaped = FocLoops(shaped=True)
    steady = simulate(motor, 300.0, 0.05, 0.4, 2e-5, drive="foc", mode="speed", loops=shaped, inertia_kg_m2=1e-4)
    assert ripple(steady.torque[-5000:]) < 0.02


def test_torque_and_speed_are_commanded_at_the_output_shaft():
    geared = replace(MAXON_LIKE, emf="sine", gear=9.0, back_emf_v_s_rad=9.0 * 0.0335, inertia_kg_m2=81.0 * 1.35e-5)
    held = simulate(geared, 0.5, 0.0, 0.02, 2e-5, drive="foc", mode="torque", inertia_kg_m2=100.0)
    assert held.torque[-1] == pytest.approx(0.5, rel=1e-3)
    turning = simulate(geared, -20.0, 0.3, 0.3, 2e-5, drive="foc", mode="speed")
    assert turning.speed[-1] == pytest.approx(-20.0, rel=1e-4)
    assert turning.mechanical_w[-1] == pytest.approx(-20.0 * 0.3, rel=1e-3)


def test_a_speed_step_within_the_limits_is_first_order():
    loops = FocLoops(speed_hz=20.0)
    traces = simulate(SINUS, 30.0, 0.0, 0.05, 2e-5, drive="foc", mode="speed", loops=loops, inertia_kg_m2=5e-5)
    designed = -30.0 * np.expm1(-2.0 * math.pi * 20.0 * traces.time)
    assert np.abs(traces.speed - designed).max() < 0.02 * 30.0  # the current loop below it is 50 times as fast
    assert traces.speed.max() < 30.0 * 1.001


def test_a_duty_gives_field_oriented_and_averaged_drives_the_same_speed():
    for load in (0.0, 0.05):
        averaged, foc = (simulate(SINUS, 0.5, load, 0.6, 2e-5, drive=drive).speed[-1] for drive in ("averaged", "foc"))
        assert foc == pytest.approx(averaged, rel=1e-3)


@pytest.mark.parametrize("mode", ["duty", "torque", "speed"])
def test_a_command_that_is_not_finite_counts_as_zero(mode):
    broken, zero = (
        simulate(SINUS, np.r_[np.full(500, 0.02), np.full(500, bad)], 0.0, 0.02, 2e-5, drive="foc", mode=mode)
        for bad in (math.nan, 0.0)
    )
    np.testing.assert_array_equal(broken.speed, zero.speed)


def test_a_bench_names_what_it_cannot_run():
    with pytest.raises(InputError, match="averaged, six_step, foc, not 'vector'"):
        simulate(MAXON_LIKE, 1.0, drive="vector")
    with pytest.raises(InputError, match="one of duty, torque, speed, not 'position'"):
        simulate(MAXON_LIKE, 1.0, drive="foc", mode="position")
    with pytest.raises(InputError, match="'six_step' takes a duty, no speed; give drive='foc'"):
        simulate(MAXON_LIKE, 1.0, mode="speed")
    with pytest.raises(InputError, match="a brushed motor has no other drive"):
        simulate(HEKIMOGLU, 1.0, mode="torque")
    with pytest.raises(InputError, match="no inertia"):
        simulate(replace(MAXON_LIKE, inertia_kg_m2=0.0), 1.0)
    with pytest.raises(InputError, match=r"command has the shape \(3,\).*100 steps"):
        simulate(MAXON_LIKE, np.ones(3), 0.0, 1e-3)
    with pytest.raises(InputError, match="shorter than one row"):
        simulate(MAXON_LIKE, 1.0, 0.0, 1e-6)
