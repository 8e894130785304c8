"""The plant without slip against its closed forms."""

import math
from dataclasses import replace

import numpy as np
import pytest
from machines import FREE_SPEED, hybrid, mecanum, swerve, with_motor

from holodrive import geometry
from holodrive.kinematics import Chassis
from holodrive.sim import SimBase
from holodrive.types import DutyCommand


def pose_after(robot, duty, ticks, dt, steer=()):
    base = SimBase(robot, None, dt_s=dt)
    for _ in range(ticks):
        base.apply(DutyCommand(duty, steer))
    return np.array(base.truth), base


def test_wheels_follow_an_exponential_without_step_error():
    _, base = pose_after(hybrid(), (0.3, 0.9, -0.5), 7, 1e-3)
    gone = 1.0 - math.exp(-0.07 / 0.05)
    assert np.allclose(base.true_wheel_speeds, np.array([0.3, 0.9, -0.5]) * FREE_SPEED * gone, rtol=1e-13)


def test_a_straight_line_has_the_closed_form_at_any_step():
    duty, t = np.array([0.0, 0.6, -0.6]), 0.2
    way = FREE_SPEED * (t - 0.05 * (1.0 - math.exp(-t / 0.05)))
    wanted = Chassis.of(hybrid()).forward(duty * way)
    for dt in (1e-2, 1e-3):
        pose, _ = pose_after(hybrid(), duty, 20, dt)
        assert np.allclose(pose, wanted, atol=1e-14)


def test_a_steady_circle_is_the_exact_exponential():
    robot = with_motor(hybrid(), lag_s=0.0)
    duty = np.array([0.4, 0.8, -0.1])
    twist = Chassis.of(robot).forward(duty * FREE_SPEED)
    pose, base = pose_after(robot, duty, 500, 1e-3)
    assert np.allclose(pose, geometry.exp(5.0 * twist), atol=1e-12)
    assert np.allclose(base.true_twist, twist, atol=1e-14)


@pytest.mark.parametrize("robot", [hybrid(), mecanum()], ids=["hybrid", "mecanum"])
def test_halving_the_step_divides_the_error_of_fixed_wheels_by_four(robot):
    robot = replace(with_motor(robot, lag_s=0.3), control_period_s=0.08)
    n = len(robot.wheels)

    def turned_round(dt):
        # from rest the twist only grows; from one motion into another it changes direction within a step
        _, base = pose_after(robot, np.linspace(-0.9, 0.8, n), 6, dt)
        for _ in range(6):
            base.apply(DutyCommand(np.linspace(1.0, 0.2, n)))
        return np.array(base.truth)

    exact = turned_round(0.08 / 512)
    errors = [np.abs(turned_round(0.08 / k) - exact)[:2].max() for k in (2, 4, 8, 16)]
    orders = np.log2(np.array(errors[:-1]) / errors[1:])
    assert np.all(np.abs(orders - 2.0) < 0.15)


def test_halving_the_step_halves_the_error_of_steered_wheels():
    robot = replace(swerve(), control_period_s=0.08)
    steer = (0.9, -0.5, 0.3)
    exact, _ = pose_after(robot, (0.8, 0.7, 0.6), 10, 0.08 / 4096, steer)
    errors = [np.abs(pose_after(robot, (0.8, 0.7, 0.6), 10, 0.08 / k, steer)[0] - exact).max() for k in (16, 32, 64)]
    assert np.all(np.abs(np.log2(np.array(errors[:-1]) / errors[1:]) - 1.0) < 0.15)


def test_different_lags_give_what_one_lag_gives_when_they_are_nearly_alike():
    alike = hybrid()
    wheels = list(alike.wheels)
    wheels[0] = replace(wheels[0], motor=replace(wheels[0].motor, lag_s=0.05 + 1e-12))
    other = replace(alike, wheels=tuple(wheels))
    a, _ = pose_after(alike, (0.3, 0.9, -0.5), 50, 1e-3)
    b, base = pose_after(other, (0.3, 0.9, -0.5), 50, 1e-3)
    assert np.allclose(a, b, atol=1e-11)
    assert np.allclose(base.true_twist, Chassis.of(other).forward(base.true_wheel_speeds), atol=1e-13)


def test_steering_obeys_lag_and_rate():
    robot = swerve()
    base = SimBase(robot, None)
    base.apply(DutyCommand((0.0,) * 3, (3.0, 0.001, -3.0)))
    steer = base.observe().wheels.steer
    assert steer[0] == pytest.approx(6.0 * 0.01)
    assert steer[2] == pytest.approx(-6.0 * 0.01)
    assert steer[1] == pytest.approx(0.001 * (1.0 - math.exp(-0.01 / 0.05)))


def test_a_swerve_base_drives_where_its_wheels_point():
    robot = with_motor(swerve(), lag_s=0.0)
    angle = 0.7
    _, base = pose_after(robot, (0.0,) * 3, 100, 1e-3, (angle,) * 3)  # steer first
    for _ in range(100):
        base.apply(DutyCommand((0.5,) * 3, (angle,) * 3))
    speed = 0.5 * FREE_SPEED * 0.05
    assert np.allclose(base.truth, (speed * math.cos(angle), speed * math.sin(angle), 0.0), atol=1e-6)
