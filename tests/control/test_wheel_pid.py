"""The inner loop of the cascade, one law at a time."""

import math

import numpy as np
import pytest

from holodrive import robots
from holodrive.control.wheel_pid import Gains, memory_size, wheel_pid_step
from holodrive.kinematics import kernel

ROBOT = robots.load("hybrid3_table_x")
KIN = kernel.arrays(ROBOT)
LIMIT = ROBOT.wheels[0].max_speed_rad_s
PLAIN = Gains(kp=0.0, ki=0.0, kd=0.0, feed_forward=1.0, slew_m_s2=math.inf, share=0.5)
DT = 0.01


class Wheels:
    """The kernel with its memory."""

    def __init__(self, **gains):
        self.gains, self.memory = np.array(PLAIN._replace(**gains)), np.zeros(memory_size(3))

    def step(self, wanted, measured):
        speeds = np.array(wanted, dtype=float)
        wheel_pid_step(KIN, self.gains, np.array(measured, dtype=float), DT, self.memory, speeds)
        return speeds


def test_without_gains_the_wanted_speeds_are_commanded():
    np.testing.assert_array_equal(Wheels().step((1.0, -2.0, 3.0), (0.0, 0.0, 9.0)), (1.0, -2.0, 3.0))


def test_a_wheel_without_encoder_gets_the_feed_forward_alone():
    wheels = Wheels(kp=0.5, ki=2.0, kd=0.01)
    for _ in range(5):
        out = wheels.step((1.0, -2.0, 3.0), (math.nan, -1.5, math.nan))
    assert (out[0], out[2]) == (1.0, 3.0)
    assert out[1] < -2.0


def test_the_three_terms_are_what_they_say():
    wheels = Wheels(kp=0.5, ki=2.0, kd=0.01)
    first, second = wheels.step((1.0, 1.0, 1.0), (0.8, 1.0, 1.2)), wheels.step((1.0, 1.0, 1.0), (0.9, 1.0, 1.1))
    error, before = np.array([0.1, 0.0, -0.1]), np.array([0.2, 0.0, -0.2])
    np.testing.assert_allclose(first, 1.0 + 0.5 * before + 0.01 * before / DT)
    np.testing.assert_allclose(second, 1.0 + 0.5 * error + 2.0 * before * DT + 0.01 * (error - before) / DT)


def test_a_steady_error_is_integrated_away():
    """A wheel that keeps 20 % behind its command, as a motor under load without a loop of its own."""
    wheels, speed = Wheels(ki=5.0), np.zeros(3)
    for _ in range(600):
        speed = 0.8 * wheels.step((2.0, -1.0, 0.5), speed)
    np.testing.assert_allclose(speed, (2.0, -1.0, 0.5), rtol=1e-3)


def test_the_trim_is_bounded_and_does_not_wind_up():
    """Blocked wheels for ten seconds; once free, the integral is gone within the time that its bound took to fill."""
    wheels = Wheels(ki=1.0, share=0.1)
    for _ in range(1000):
        blocked = wheels.step((1.0, 1.0, 1.0), (0.0, 0.0, 0.0))
    np.testing.assert_allclose(blocked, 1.0 + 0.1 * LIMIT, rtol=0.02)
    for _ in range(100):
        free = wheels.step((1.0, 1.0, 1.0), (2.0, 2.0, 2.0))
    assert np.all(free < 1.0)


def test_a_saturated_command_keeps_its_direction_and_the_integral_waits():
    wheels = Wheels(ki=1.0, kp=0.5)
    wanted = np.array([0.5, -0.9, 0.9]) * LIMIT
    for _ in range(50):
        out = wheels.step(wanted, 0.5 * wanted)
    assert np.isclose(np.max(np.abs(out)), LIMIT)
    np.testing.assert_allclose(out / out[0], wanted / wanted[0])
    np.testing.assert_array_equal(wheels.memory[::4], 0.0)


def test_commands_change_no_faster_than_the_slew_limit_and_in_one_proportion():
    wheels, last = Wheels(slew_m_s2=0.6), np.zeros(3)
    wanted = np.array([1.0, -3.0, 2.0])
    for _ in range(60):
        out = wheels.step(wanted, last)
        assert np.max(np.abs(out - last)) * ROBOT.wheels[0].radius <= 0.6 * DT * (1.0 + 1e-9)
        np.testing.assert_allclose(out * wanted[0], wanted * out[0], atol=1e-12)
        last = out
    np.testing.assert_allclose(out, wanted)


def test_wheels_that_are_told_to_stand_and_stand_get_nothing():
    wheels = Wheels(kp=0.5, ki=5.0)
    for _ in range(50):
        wheels.step((1.0, 1.0, 1.0), (0.7, 0.7, 0.7))
    np.testing.assert_array_equal(wheels.step((0.0, 0.0, 0.0), (0.0, 0.001, -0.001)), 0.0)
    np.testing.assert_array_equal(wheels.memory[::4], 0.0)


@pytest.mark.parametrize("slew", [0.6, math.inf])
def test_nan_stays_nan_and_spoils_no_later_tick(slew):
    wheels, fresh = Wheels(kp=0.5, ki=1.0, slew_m_s2=slew), Wheels(kp=0.5, ki=1.0, slew_m_s2=slew)
    assert np.all(np.isnan(wheels.step((math.nan,) * 3, (0.0, 0.0, 0.0))))
    np.testing.assert_array_equal(wheels.step((1.0, 1.0, 1.0), (0, 0, 0)), fresh.step((1.0, 1.0, 1.0), (0, 0, 0)))
