"""Field-oriented motors on the plant "motors": the board's duties reach them as torques."""

import math
from dataclasses import replace

import numpy as np
import pytest

from holodrive import robots
from holodrive.sim import state as st
from holodrive.sim.base import SimBase
from holodrive.types import WheelCommand


def swerve(drive, emf="sine", limit=25.0):
    """The three-wheel swerve base with motors in the modules, all of them fed alike."""
    robot = robots.load("swerve3")
    motor = replace(robot.wheels[0].motor, poles=16, drive=drive, emf=emf, current_limit_a=limit)
    steering = replace(robot.wheels[0].steering, motor=motor, inertia_kg_m2=2e-3)
    return replace(robot, wheels=tuple(replace(wheel, motor=motor, steering=steering) for wheel in robot.wheels))


def driven(robot, seconds=1.0):
    """Drive along a curve: 10 rad/s at the wheels, all modules turning at 0.3 rad/s."""
    base = SimBase(robot, plant="motors")
    speeds = (10.0, 10.0, 10.0)
    for k in range(round(seconds / robot.control_period_s)):
        base.apply(WheelCommand(speeds, (0.3 * k * robot.control_period_s,) * 3))
    return base


@pytest.mark.parametrize("emf", ["sine", "trapezoid"])
def test_a_field_oriented_robot_goes_where_the_averaged_one_goes(emf):
    averaged, foc = driven(swerve("averaged")), driven(swerve("foc", emf))
    assert math.hypot(averaged.truth.x - foc.truth.x, averaged.truth.y - foc.truth.y) < 2e-3
    np.testing.assert_allclose(foc.true_wheel_speeds, averaged.true_wheel_speeds, rtol=2e-3)
    assert foc.energy_j == pytest.approx(averaged.energy_j, rel=0.1)


def test_phase_currents_stay_within_the_drivers_limit():
    state = driven(swerve("foc", limit=3.0), 0.1)._state
    for k in range(6):
        currents = state[st.MOTOR + k * st.MOTOR_ROW : st.MOTOR + k * st.MOTOR_ROW + 3]
        assert np.abs(currents).max() < 1.02 * 3.0
        assert currents.sum() == pytest.approx(0.0, abs=1e-9)


def test_a_command_that_is_not_finite_stops_a_field_oriented_robot():
    base = driven(swerve("foc"), 0.5)
    base.apply(WheelCommand((math.nan, 10.0, 10.0), (0.0, 0.0, 0.0)))
    for _ in range(200):
        base.apply(WheelCommand((10.0, 10.0, 10.0), (0.0, 0.0, 0.0)))
    assert base.fault == "a command was not finite"
    assert np.abs(base.true_wheel_speeds).max() < 0.2
