"""Lag, speed loop, DC motor and battery: each against its closed form."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import holodrive as hd
from holodrive.actuators.dc_motor import bus_voltage, conductance, dry_friction
from holodrive.actuators.lag import lag_factors
from holodrive.actuators.speed_loop import speed_loop_step

FREE = 10.0  # rad/s


def test_a_lag_leaves_an_exponential_and_its_mean():
    decay, mean = lag_factors(0.2, 0.1)
    assert decay == pytest.approx(math.exp(-0.5))
    assert mean == pytest.approx((1.0 - math.exp(-0.5)) / 0.5)
    assert lag_factors(0.0, 0.1) == (0.0, 0.0)


@given(st.floats(1e-3, 10.0), st.floats(1e-6, 1.0))
def test_two_half_steps_of_a_lag_are_one_step(lag, dt):
    (whole, mean), (half, part) = lag_factors(lag, dt), lag_factors(lag, dt / 2.0)
    assert half * half == pytest.approx(whole, rel=1e-9, abs=1e-300)
    assert 0.5 * part * (1.0 + half) == pytest.approx(mean, rel=1e-9)


def test_a_motor_at_its_command_gets_the_feed_forward():
    duty, integral = speed_loop_step(4.0, 4.0, 0.0, 1.0 / FREE, 0.5, 4.0, 0.01)
    assert (duty, integral) == (pytest.approx(0.4), 0.0)


def test_the_integral_takes_the_standing_error_of_a_loaded_motor():
    speed = integral = 0.0
    for _ in range(2000):
        duty, integral = speed_loop_step(4.0, speed, integral, 1.0 / FREE, 0.5, 4.0, 0.01)
        speed += 0.2 * (0.7 * duty * FREE - speed)  # 30 % weaker than its data sheet
    assert speed == pytest.approx(4.0, rel=1e-6)


def test_the_integral_does_not_wind_up_while_the_duty_is_full():
    integral = 0.0
    for _ in range(1000):
        duty, integral = speed_loop_step(9.0, 0.0, integral, 1.0 / FREE, 0.5, 4.0, 0.01)
    assert duty == 1.0
    assert integral < 0.5 * FREE
    duty, _ = speed_loop_step(1.0, 9.0, integral, 1.0 / FREE, 0.5, 4.0, 0.01)
    assert duty < 0.1


def test_a_wheel_that_is_told_to_stand_and_stands_draws_nothing():
    assert speed_loop_step(0.0, 0.0, 3.0, 1.0 / FREE, 0.5, 4.0, 0.01) == (0.0, 0.0)


@given(st.floats(-20.0, 20.0), st.floats(-20.0, 20.0), st.floats(-5.0, 5.0))
def test_duty_is_always_within_one(command, measured, integral):
    duty, _ = speed_loop_step(command, measured, integral, 1.0 / FREE, 0.5, 4.0, 0.01)
    assert -1.0 <= duty <= 1.0


@given(st.floats(-12.0, 12.0), st.floats(-5.0, 5.0), st.floats(0.1, 10.0))
def test_no_current_passes_its_limit(voltage, speed, limit):
    g = conductance(voltage, speed, 0.0, 5.0, 2.0, 0.0, limit)
    current = g * (voltage - 5.0 * speed)
    free = (voltage - 5.0 * speed) / 2.0
    assert abs(current) <= limit * (1.0 + 1e-12)
    assert current == pytest.approx(np.clip(free, -limit, limit), rel=1e-12)


def test_a_battery_sags_by_its_current_times_its_resistance():
    voltage = bus_voltage(12.0, 0.1, 2.0, 0.5)
    assert voltage == pytest.approx(12.0 - 0.1 * (2.0 + 0.5 * voltage))


@given(st.floats(-100.0, 100.0))
def test_dry_friction_brakes_with_at_most_its_torque(speed):
    torque = dry_friction(0.05, speed) * speed
    assert abs(torque) <= 0.05
    assert torque * speed >= 0.0


def test_a_wheel_that_is_told_to_stand_stands_within_a_third_of_a_second():
    """No integral left from braking makes it creep on: a robot that meets something shall be standing."""
    base = hd.simulate("hybrid3_table_x", seed=1)
    ahead, stand = (hd.Chassis.of(base.robot).inverse(twist) for twist in ((0.2, 0.0, 0.0), (0.0, 0.0, 0.0)))
    for command, ticks in ((ahead, 150), (stand, 33)):
        for _ in range(ticks):
            base.observe()
            base.apply(command)
    assert math.hypot(*base.true_twist[:2]) < 0.005
