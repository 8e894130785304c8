"""Field-oriented control: the designed response, limits, energy, and torque without ripple."""

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from holodrive.actuators import bldc, foc
from holodrive.actuators.averaged import averaged_substep
from holodrive.actuators.space_vector import clarke, inverse_clarke, leg_duties, park
from holodrive.leaf import leaf
from tests.actuators.test_bldc import MAXON_LIKE

BUS, DT = 24.0, 2e-5
SINUS = replace(MAXON_LIKE, emf="sine")
BANDWIDTH = bldc.CURRENT_BANDWIDTH
K = MAXON_LIKE.back_emf_v_s_rad
SHAPES = pytest.mark.parametrize("motor", [SINUS, MAXON_LIKE], ids=["sine", "trapezoid"])


def packed_of(motor, shaped=False, limit=math.inf):
    packed = bldc.pack_motor(replace(motor, current_limit_a=limit))
    packed[bldc.SHAPED] = shaped
    return packed


def started(angle=0.3, i_a=0.0, i_b=0.0):
    state = np.zeros(bldc.STATE_SIZE)
    state[:4] = i_a, i_b, -i_a - i_b, angle
    return state


def driven(packed, demand, omega, steps, dt=DT, bus=BUS, state=None):
    """State, torques (n,) and currents (n, 2) along d and q of a motor whose rotor is turned at a constant speed."""
    state = started() if state is None else state
    torques, currents = np.empty(steps), np.empty((steps, 2))
    for n in range(steps):
        torques[n] = foc.foc_substep(state, 0, packed, 0, demand, bus, omega, dt)
        currents[n] = seen(state)
    return state, torques, currents


def seen(state):
    return park(*clarke(*state[:3]), state[bldc.ANGLE] + foc.FLUX)


def ripple(torque):
    return np.ptp(torque) / torque.mean()


@given(st.floats(-20.0, 20.0))
def test_a_sinusoidal_emf_lies_along_q_alone(angle):
    phases = [bldc.emf_shape(angle - k * bldc.THIRD, 1.0) for k in range(3)]
    assert park(*clarke(*phases), angle + foc.FLUX) == pytest.approx((0.0, bldc.SINE_PEAK), abs=1e-9)
    assert foc.shape_vector(angle, 1.0) == pytest.approx(clarke(*phases), abs=1e-9)


def test_the_mean_of_a_trapezoidal_emf_along_q_is_its_fundamental():
    turn = np.linspace(0.0, 2.0 * math.pi, 3600, endpoint=False) + 1e-4
    seen_by_rotor = [park(*foc.shape_vector(angle, 0.0), angle + foc.FLUX) for angle in turn]
    assert np.mean(seen_by_rotor, axis=0) == pytest.approx((0.0, foc.TRAPEZOID_PEAK), abs=1e-6)


@settings(max_examples=40)
@given(st.sampled_from((1e-5, 1e-4, 5e-4, 1e-3)), st.floats(-1000.0, 1000.0), st.floats(-1.0, 1.0))
def test_the_current_of_a_step_is_first_order_at_any_speed_and_sampling(dt, omega, demand):
    """The zero has cancelled the pole, the cross terms are gone: i_q alone moves, with the designed time constant."""
    _, _, currents = driven(packed_of(SINUS), demand, omega, 20, dt, bus=1e4)
    wanted = demand / (0.75 * K * bldc.SINE_PEAK)
    designed = wanted * -np.expm1(-BANDWIDTH * dt * np.arange(1, 21))
    np.testing.assert_allclose(currents[:, 1], designed, atol=1e-9 * abs(wanted) + 1e-9)
    assert np.abs(currents[:, 0]).max() < 1e-9 + 1e-9 * abs(wanted)


@leaf
def _in_rotor_frame(r, inductance, flux, omega, bandwidth, i_q, dt, steps, trace):
    """The continuous design in d and q alone: PI with kp = bandwidth L, ki = bandwidth R, explicit tiny steps."""
    now_d = now_q = held_d = held_q = 0.0
    for n in range(steps):
        wrong_d, wrong_q = -now_d, i_q - now_q
        v_d = bandwidth * inductance * wrong_d + held_d - omega * inductance * now_q
        v_q = bandwidth * inductance * wrong_q + held_q + omega * inductance * now_d + omega * flux
        held_d, held_q = held_d + dt * bandwidth * r * wrong_d, held_q + dt * bandwidth * r * wrong_q
        next_d = now_d + dt * (v_d - r * now_d + omega * inductance * now_q) / inductance
        now_q += dt * (v_q - r * now_q - omega * inductance * now_d - omega * flux) / inductance
        now_d = next_d
        trace[n] = now_q


@pytest.mark.parametrize("omega", [50.0, 500.0])
def test_three_phases_agree_with_a_continuous_model_in_the_rotor_frame(omega):
    inductance, steps, fine = 0.5 * MAXON_LIKE.inductance_h, 50, 200
    trace, demand = np.empty(steps * fine), 0.05
    wanted = demand / (0.75 * K * bldc.SINE_PEAK)
    flux = 0.5 * K * bldc.SINE_PEAK / 8.0
    _in_rotor_frame(0.515, inductance, flux, 8.0 * omega, BANDWIDTH, wanted, DT / fine, steps * fine, trace)
    _, _, currents = driven(packed_of(SINUS), demand, omega, steps)
    assert np.abs(currents[:, 1] - trace[fine - 1 :: fine]).max() < 0.01 * wanted


@SHAPES
@pytest.mark.parametrize("shaped", [False, True])
def test_the_drive_equals_a_plain_integration_of_the_phase_equations_under_its_legs(motor, shaped):
    """The controller every 20 us; its legs' voltages at the three terminals, phases integrated in steps of 50 ns."""
    packed, omega, demand = packed_of(motor, shaped), 300.0, 0.05
    state, torques, _ = driven(packed, demand, omega, 100)
    plain = started()
    means = []
    for _ in range(100):
        legs = leg_duties(*foc.foc_voltage(plain, 0, packed, 0, demand, BUS, omega, DT), BUS)
        means.append(_plain(packed, plain, np.array(legs) * BUS, omega, DT, 400))
    np.testing.assert_allclose(state[:3], plain[:3], atol=0.01 * np.abs(plain[:3]).max())
    np.testing.assert_allclose(torques, means, atol=0.005 * demand)


@leaf
def _plain(packed, state, volts, omega, time, steps):
    dt, torque, k = time / steps, 0.0, 0.5 * packed[bldc.BACK_EMF]
    for _ in range(steps):
        angle = state[bldc.ANGLE]
        for phase in range(3):
            shape = bldc.emf_shape(angle - phase * bldc.THIRD, packed[bldc.SINE])
            torque += k * shape * state[phase] / steps
        di_a, di_b, _, turning = bldc.phase_derivatives(
            packed, 0, state[0], state[1], omega, angle, volts[0], volts[1], volts[2], 0.0
        )
        state[0] += dt * di_a
        state[1] += dt * di_b
        state[2] = -state[0] - state[1]
        state[bldc.ANGLE] = bldc.wrapped(angle + dt * turning)
    return torque


@SHAPES
@pytest.mark.parametrize("shaped", [False, True])
def test_the_integral_makes_up_for_wrong_resistance_inductance_and_constant(motor, shaped):
    true = packed_of(motor, shaped)
    believed = true.copy()
    believed[[bldc.RESISTANCE, bldc.INDUCTANCE, bldc.BACK_EMF]] *= 1.4, 0.7, 0.9
    state, demand, currents = started(), 0.05, []
    for _ in range(6000):
        v = foc.foc_voltage(state, 0, believed, 0, demand, BUS, 150.0, DT)
        foc.conduct(state, 0, true, 0, *v, 150.0, DT)
        currents.append(seen(state)[1])
    peak = bldc.SINE_PEAK if motor is SINUS else foc.TRAPEZOID_PEAK
    assert np.mean(currents[3000:]) == pytest.approx(demand / (0.75 * 0.9 * K * peak), rel=0.01)


@settings(max_examples=80)
@given(
    st.floats(allow_nan=True, allow_infinity=True), st.floats(-1100.0, 1100.0), st.floats(0.0, 6.28),
    st.sampled_from((SINUS, MAXON_LIKE)), st.booleans(), st.floats(0.0, 48.0), st.floats(-8.0, 8.0),
    st.sampled_from((1e-5, 2e-5, 1e-3)), st.sampled_from((5.0, math.inf)),
)  # fmt: skip
def test_voltage_stays_in_the_circle_and_everything_finite(demand, omega, angle, motor, shaped, bus, i, dt, limit):
    packed, state = packed_of(motor, shaped, limit), started(angle, i, -0.3 * i)
    before = bldc.stored_energy(state, 0, packed, 0)
    torques = []
    for _ in range(20):
        v = foc.foc_voltage(state, 0, packed, 0, demand, bus, omega, dt)
        assert math.hypot(*v) <= bus / math.sqrt(3.0) * (1.0 + 1e-9) + 1e-12
        torques.append(foc.conduct(state, 0, packed, 0, *v, omega, dt))
    assert np.isfinite(state).all()
    assert abs(state[:3].sum()) < 1e-9 * (1.0 + np.abs(state[:3]).max())
    # what the supply gives is heat, work and storing
    growth = bldc.stored_energy(state, 0, packed, 0) - before
    turned_over = abs(state[bldc.INPUT_J]) + state[bldc.COPPER_J] + before
    missed = state[bldc.INPUT_J] - state[bldc.COPPER_J] - state[bldc.WORK_J] - growth
    assert abs(missed) < 1e-9 * turned_over + 1e-15
    assert state[bldc.WORK_J] == pytest.approx(np.sum(torques) * omega * dt, rel=1e-9, abs=1e-12)


@SHAPES
@pytest.mark.parametrize("demand", [math.nan, math.inf, -math.inf])
def test_a_demand_that_is_not_finite_stops_the_current(motor, demand):
    packed = packed_of(motor)
    flowing, _, _ = driven(packed, 0.05, 100.0, 200)
    stopped, torques, _ = driven(packed, demand, 100.0, 200, state=flowing.copy())
    zero, expected, _ = driven(packed, 0.0, 100.0, 200, state=flowing.copy())
    np.testing.assert_array_equal(stopped, zero)
    np.testing.assert_array_equal(torques, expected)
    assert abs(torques[-1]) < 1e-3


@pytest.mark.parametrize("duty", [math.nan, math.inf])
def test_a_duty_that_is_not_finite_is_a_brake(duty):
    packed = packed_of(SINUS)
    assert foc.torque_of_duty(packed, 0, duty, BUS, 100.0) == foc.torque_of_duty(packed, 0, 0.0, BUS, 100.0) < 0.0
    assert foc.speed_step(duty, 50.0, 0.0, 1e-5, 0.0, 100.0) == foc.speed_step(0.0, 50.0, 0.0, 1e-5, 0.0, 100.0) < 0.0


@pytest.mark.parametrize("omega", [0.0, 300.0])
def test_loops_do_not_wind_up_while_the_supply_is_too_weak(omega):
    packed = packed_of(SINUS)
    weak, _, _ = driven(packed, 2.0, omega, 2000)
    assert weak[bldc.LIMITED] == 1.0
    assert np.hypot(*weak[[bldc.HELD_D, bldc.HELD_Q]]) < 2.0 * BUS
    state, _, currents = driven(packed, 0.02, omega, 400, state=weak)
    wanted = 0.02 / (0.75 * K * bldc.SINE_PEAK)
    assert state[bldc.LIMITED] == 0.0
    reached = np.argmax(np.abs(currents[:, 1] - wanted) < 0.05 * wanted)
    assert reached * DT < 2e-3  # about 1 ms for want of voltage, 3 / bandwidth = 0.5 ms by design
    assert currents[:, 1].min() > 0.99 * wanted  # and no swing to the other side


def test_with_too_few_volts_torque_yields_and_no_flux_current_flows():
    """12 V turn this motor at 358 rad/s without load."""
    state, torques, currents = driven(packed_of(SINUS), 0.3, 300.0, 1500, bus=12.0)
    assert state[bldc.LIMITED] == 1.0
    assert currents[-1, 0] == pytest.approx(0.0, abs=1e-3)
    assert 0.01 < torques[-1] < 0.1


@SHAPES
@pytest.mark.parametrize("demand", [0.0, -0.05])
def test_a_rotor_beyond_the_supply_is_held_by_weakening_its_field(motor, demand):
    """Half as fast again as 12 V turn it; a short circuit would brake it with 8 A."""
    state, torques, currents = driven(packed_of(motor), demand, 537.0, 3000, bus=12.0)
    assert state[bldc.LIMITED] == 1.0
    assert currents[2000:, 0].mean() < -0.5
    assert np.hypot(*currents[2000:].T).max() < 6.0
    assert torques[2000:].mean() == pytest.approx(demand, abs=0.03)


@SHAPES
def test_the_drivers_limit_bounds_the_amplitude_of_the_phase_currents(motor):
    packed = packed_of(motor, limit=4.0)
    state, _, currents = driven(packed, 10.0, 50.0, 1000)
    assert state[bldc.LIMITED] == 1.0
    assert currents[500:, 1].mean() == pytest.approx(4.0, rel=1e-3)


@given(st.floats(-0.1, 0.1), st.floats(-600.0, 600.0), st.floats(0.05, 6.2), st.booleans())
@settings(max_examples=40)
def test_a_mirrored_motor_has_the_mirrored_torque(demand, omega, angle, shaped):
    packed = packed_of(MAXON_LIKE, shaped)
    mirror = bldc.wrapped(5.0 * bldc.SECTOR - angle)
    _, torques, _ = driven(packed, demand, omega, 40, state=started(angle))
    _, mirrored, _ = driven(packed, -demand, -omega, 40, state=started(mirror))
    np.testing.assert_allclose(mirrored, -torques, rtol=1e-6, atol=1e-9)


@pytest.mark.parametrize("omega", [30.0, 200.0, 500.0])
def test_a_sinusoidal_motor_has_no_ripple_and_the_losses_of_ideal_currents(omega):
    packed = packed_of(SINUS)
    state, torques, _ = driven(packed, 0.05, omega, 1500)
    assert torques[-1] == pytest.approx(0.05, rel=2e-3)
    assert ripple(torques[750:]) < 1e-6
    state[bldc.COPPER_J] = 0.0
    driven(packed, 0.05, omega, 1000, state=state)
    assert state[bldc.COPPER_J] / (1000 * DT) == pytest.approx(1.03 * (0.05 / K) ** 2, rel=2e-3)  # R T^2 / K^2


def test_currents_shaped_by_a_trapezoidal_emf_take_most_of_its_ripple():
    sinusoidal, shaped = (driven(packed_of(MAXON_LIKE, way), 0.05, 200.0, 3000)[1][1000:] for way in (False, True))
    assert ripple(sinusoidal) > 0.05
    assert ripple(shaped) < 0.01
    assert shaped.mean() == pytest.approx(0.05, rel=1e-3)


@pytest.mark.parametrize("shaped", [False, True])
def test_copper_loss_of_a_trapezoidal_motor_is_as_theory_says(shaped):
    """Of R T^2 / K^2: 0.9019 with sinusoidal currents of the fundamental, 0.9069 with shaped ones."""
    packed = packed_of(MAXON_LIKE, shaped)
    share = math.pi * math.sqrt(3.0) / 6.0 if shaped else 4.0 / (3.0 * foc.TRAPEZOID_PEAK**2)
    state, _, _ = driven(packed, 0.05, 20.0, 1000)
    state[bldc.COPPER_J] = 0.0
    turn = round(2.0 * math.pi / (8.0 * 20.0 * DT))
    driven(packed, 0.05, 20.0, turn, state=state)
    assert state[bldc.COPPER_J] / (turn * DT) == pytest.approx(share * 1.03 * (0.05 / K) ** 2, rel=3e-3)


@given(st.floats(0.0, 6.28), st.floats(-5.0, 5.0))
def test_no_currents_of_sum_zero_give_a_torque_with_less_heat_than_the_shaped_ones(angle, other):
    state, _, _ = driven(packed_of(MAXON_LIKE, True), 0.05, 0.0, 400, state=started(angle))
    f = np.array(foc.shape_vector(angle, 0.0))
    across = np.array([-f[1], f[0]])  # gives no torque
    currents = np.array(clarke(*state[:3]))
    assert 0.75 * K * f @ currents == pytest.approx(0.05, rel=1e-6)
    alike = inverse_clarke(*(currents + other * across))
    assert np.dot(alike, alike) >= np.dot(state[:3], state[:3]) - 1e-9


@given(st.floats(-1.0, 1.0), st.floats(-600.0, 600.0))
def test_a_duty_asks_for_the_torque_of_a_dc_motor_at_that_duty(duty, omega):
    packed, state = packed_of(SINUS), np.zeros(bldc.STATE_SIZE)
    for _ in range(3):
        torque = averaged_substep(state, 0, packed, 0, duty, BUS, omega, 0.1)
    assert foc.torque_of_duty(packed, 0, duty, BUS, omega) == pytest.approx(torque, abs=1e-9)


@given(st.floats(1e-6, 1e-2), st.floats(0.0, 1e-3), st.floats(5.0, 300.0), st.floats(-500.0, 500.0))
def test_a_speed_step_is_first_order(inertia, viscous, bandwidth, wanted):
    dt, omega, held, steps = 1e-3 / bandwidth, 0.0, 0.0, 2000
    for _ in range(steps):
        torque = foc.speed_step(wanted, omega, held, inertia, viscous, bandwidth)
        held = foc.speed_hold(torque, omega, held, inertia, viscous, bandwidth, dt)
        omega += dt * (torque - viscous * omega) / inertia
    assert omega == pytest.approx(-wanted * math.expm1(-bandwidth * dt * steps), rel=5e-3, abs=1e-9)


def test_the_speed_loop_makes_up_for_a_load_and_forgets_a_torque_it_did_not_get():
    inertia, viscous, bandwidth, dt = 1e-4, 1e-5, 100.0, 1e-4

    def run(most, load, steps):
        omega = held = fastest = 0.0
        for _ in range(steps):
            asked = foc.speed_step(300.0, omega, held, inertia, viscous, bandwidth)
            torque = min(most, max(-most, asked))
            held = foc.speed_hold(torque, omega, held, inertia, viscous, bandwidth, dt)
            omega += dt * (torque - load - viscous * omega) / inertia
            fastest = max(fastest, omega)
        return omega, fastest

    assert run(math.inf, 0.03, 5000)[0] == pytest.approx(300.0, rel=1e-6)
    assert run(0.05, 0.03, 30_000) == pytest.approx((300.0, 300.0), rel=1e-3)  # 1.5 s at its limit, no overshoot
