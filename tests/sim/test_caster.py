"""Wheels that trail behind their steering axes, and wheels that the steering turns, in the plants."""

import math
from dataclasses import replace

import numpy as np
import pytest
from machines import swerve

from holodrive import robots
from holodrive.errors import InputError
from holodrive.estimation.odometry import Odometry
from holodrive.geometry import compose, exp, wrap
from holodrive.kinematics import Chassis
from holodrive.robots.spec import Encoder, Robot
from holodrive.sim import SimBase
from holodrive.types import DutyCommand, WheelCommand

EASY = {"rate_rad_s": 3.0, "lag_s": 0.05}


def trailing(caster=0.04, coupling=0.0, counts=1e6, **steering) -> Robot:
    robot = swerve()
    wheels = tuple(
        replace(
            w,
            steering=replace(w.steering, **{**EASY, "caster_m": caster, "coupling": coupling, **steering}),
            encoder=Encoder(counts),
            motor=replace(w.motor, coulomb_friction_n_m=0.0),
        )
        for w in robot.wheels
    )
    return replace(robot, wheels=wheels)


@pytest.mark.parametrize("plant", ["first_order", "slip"])
def test_modules_that_turn_over_standing_wheels_carry_the_body_round_their_contacts(plant):
    """All contacts stay; the body moves by c (e(d1) - e(d0)), whatever the steering does in between."""
    base = SimBase(trailing(), plant=plant, dt_s=1e-3)
    base.apply(WheelCommand((0.0,) * 3, (1.2,) * 3))
    for _ in range(150):
        base.apply(WheelCommand((0.0,) * 3, (1.2,) * 3))
    expected = 0.04 * np.array([math.cos(1.2) - 1.0, math.sin(1.2), 0.0])
    np.testing.assert_allclose(base.truth, expected, atol=1e-6 if plant == "first_order" else 2e-3)
    assert np.abs(base.true_wheel_speeds).max() < (1e-6 if plant == "first_order" else 1e-2)


@pytest.mark.parametrize("plant", ["first_order", "slip"])
def test_the_body_moves_as_wheels_and_steering_rates_say(plant):
    robot, rng = trailing(0.03), np.random.default_rng(4)
    base, chassis, pose = SimBase(robot, plant=plant, dt_s=1e-3), Chassis.of(robot), np.zeros(3)
    for tick in range(200):
        if tick % 40 == 0:
            command = WheelCommand(rng.uniform(0.2, 0.6) * np.ones(3), rng.uniform(-1, 1) * np.ones(3))
        before, angle = base.observe().wheels.steer, base.true_wheel_speeds
        base.apply(command)
        now, speeds = base.observe().wheels.steer, 0.5 * (angle + base.true_wheel_speeds)
        twist = chassis.forward(speeds, 0.5 * (before + now), (now - before) / robot.control_period_s)
        pose = compose(pose, exp(twist * robot.control_period_s))
    np.testing.assert_allclose(base.truth, pose, atol=2e-4 if plant == "first_order" else 3e-3)


def test_a_drive_that_stands_lets_the_steering_turn_its_wheel_and_the_encoder_does_not_see_it():
    base = SimBase(trailing(0.0, 0.5), dt_s=1e-3)
    for _ in range(150):
        base.apply(DutyCommand((0.0,) * 3, (1.0,) * 3))
    wheels = base.observe().wheels
    np.testing.assert_allclose(wheels.steer, 1.0, atol=1e-6)
    np.testing.assert_allclose(wheels.position, 0.0, atol=1e-5)
    # all wheels rolled back by half a radian, along a direction that turned with them
    r, k = 0.05, 0.5
    np.testing.assert_allclose(base.truth, [-r * k * math.sin(1.0), -r * k * (1.0 - math.cos(1.0)), 0.0], atol=1e-4)


@pytest.mark.parametrize("plant", ["first_order", "slip"])
def test_the_board_makes_up_for_the_coupling(plant):
    """Told to stand, a wheel hardly moves while its module turns; its encoder counts what the drive made up."""
    free, base = SimBase(trailing(0.0, 0.5), plant=plant), SimBase(trailing(0.0, 0.5), plant=plant)
    for _ in range(200):
        free.apply(DutyCommand((0.0,) * 3, (1.0,) * 3))
        base.apply(WheelCommand((0.0,) * 3, (1.0,) * 3))
    np.testing.assert_allclose(base.observe().wheels.position, 0.5, atol=0.1)
    assert np.hypot(*base.truth[:2]) < 0.2 * np.hypot(*free.truth[:2])


@pytest.mark.parametrize(("caster", "coupling"), [(0.04, 0.0), (-0.03, 0.0), (0.0, 0.7), (0.04, -0.6)])
def test_odometry_counts_casters_in_and_coupling_out(caster, coupling):
    robot, rng = trailing(caster, coupling), np.random.default_rng(7)
    base, odometry = SimBase(robot, dt_s=1e-3), Odometry(robot)
    blind = Odometry(trailing(0.0, 0.0))
    for tick in range(400):
        if tick % 30 == 0:
            speeds, steer = rng.uniform(-1.5, 1.5) * np.ones(3), rng.uniform(-1.5, 1.5) * np.ones(3)
        observation = base.observe()
        odometry.update(observation.wheels, stamp=observation.time)
        blind.update(observation.wheels, stamp=observation.time)
        truth = np.array(base.truth)
        base.apply(WheelCommand(speeds, steer))
    error = np.array(odometry.estimate.pose) - truth
    assert np.hypot(*error[:2]) < 1e-3
    assert abs(wrap(error[2])) < 1e-3
    assert np.hypot(*(np.array(blind.estimate.pose) - truth)[:2]) > 5e-3


def test_pwm_maps_do_not_know_casters():
    pwm_map = robots.load("mecanum4").pwm_map
    with pytest.raises(InputError, match="caster or coupling"):
        SimBase(replace(trailing(), pwm_map=pwm_map), plant="pwm_map")
