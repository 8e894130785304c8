"""The nominal wheels that trackers compare theirs with, and what is measured beside them."""

import math
from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose

import holodrive as hd
from holodrive import geometry, layout, references
from holodrive.control import standstill, wheel_model
from holodrive.kinematics import kernel as kinematics
from holodrive.observation_array import empty_observation

ROBOT = hd.load("mecanum4_mice")
KIN, DT, N = kinematics.arrays(ROBOT), ROBOT.control_period_s, 4
RNG = np.random.default_rng(5)


def run(commands, lag_s=0.05, delay_s=0.0):
    """Speeds and means (T, n) of the nominal wheels after each tick of `commands` (T, n), and its memory."""
    model = wheel_model.packed(ROBOT, lag_s, delay_s)
    memory = np.zeros(wheel_model.memory_size(ROBOT, delay_s))
    speeds, means = [], []
    for row in commands:
        wheel_model.remember(KIN, model, row, memory)
        wheel_model.model_step(KIN, model, DT, memory)
        wheels = memory[: wheel_model.PER_WHEEL * N].reshape(N, wheel_model.PER_WHEEL)
        speeds.append(wheels[:, wheel_model.SPEED].copy())
        means.append(wheels[:, wheel_model.MEAN].copy())
    return np.array(speeds), np.array(means), model, memory


def test_without_delay_the_nominal_wheels_are_those_of_the_first_order_plant():
    commands = {"first": 0}

    def drive(reference, estimate, observation):
        k = commands["first"]
        commands["first"] += 1
        return hd.WheelCommand(tuple(table[k]))

    table = RNG.uniform(-1.5, 1.5, size=(40, N))
    base = hd.simulate(ROBOT, plant="first_order", seed=1)
    speeds, truth = run(table, lag_s=ROBOT.wheels[0].motor.lag_s)[0], []
    for row in table:
        base.apply(hd.WheelCommand(tuple(row)))
        base.observe()
        truth.append(kinematics_of(base.true_twist))
    projected = speeds @ projector().T
    assert_allclose(projected, truth, atol=1e-9)


def projector():
    """(n, n) what of wheel speeds a body can do."""
    jacobian = jacobian_of()
    return jacobian @ np.linalg.pinv(jacobian)


def jacobian_of():
    from holodrive.kinematics import Chassis

    return Chassis.of(ROBOT).jacobian


def kinematics_of(twist):
    return jacobian_of() @ np.array(twist)


@pytest.mark.parametrize("ticks", [1, 2, 5])
def test_a_delay_of_whole_ticks_shifts_everything(ticks):
    commands = RNG.uniform(-1.0, 1.0, size=(30, N))
    now, later = run(commands)[1], run(commands, delay_s=ticks * DT)[1]
    assert_allclose(later[ticks:], now[:-ticks], atol=1e-12)
    assert_allclose(later[:ticks], 0.0)


def test_a_delay_of_part_of_a_tick_lies_between():
    commands = np.ones((30, N))
    half = np.sum(run(commands, delay_s=0.5 * DT)[1], axis=0)
    none, one = (np.sum(run(commands, delay_s=delay)[1], axis=0) for delay in (0.0, DT))
    assert_allclose(half, 0.5 * (none + one), rtol=1e-12)


@pytest.mark.parametrize("delay_s", [0.0, 0.4 * DT, DT, 3.7 * DT])
def test_what_is_still_to_come_is_what_comes_when_nothing_more_is_commanded(delay_s):
    commands = RNG.uniform(-1.0, 1.0, size=(20, N))
    _, _, model, memory = run(commands, delay_s=delay_s)
    told = np.zeros(N)
    wheel_model.still_to_come(KIN, model, DT, memory, told)
    means = run(np.concatenate([commands, np.zeros((400, N))]), delay_s=delay_s)[1]
    assert_allclose(told, DT * np.sum(means[20:], axis=0), atol=1e-9)


def test_wheels_without_lag_do_at_once_what_they_are_told():
    commands = RNG.uniform(-1.0, 1.0, size=(10, N))
    assert_allclose(run(commands, lag_s=0.0)[0], commands)


def test_the_measured_twist_is_that_of_the_arc_between_the_poses():
    obs, twist = empty_observation(), np.zeros(3)
    obs[layout.DT] = 0.02
    for _ in range(50):
        start, true = RNG.uniform(-2.0, 2.0, 3), RNG.uniform(-3.0, 3.0, 3)
        obs[layout.POSE : layout.POSE + 3] = geometry.compose(start, geometry.exp(0.02 * true))
        obs[layout.POSE + 2] = start[2] + 0.02 * true[2]  # an estimate's heading does not wrap
        last = start.copy()
        wheel_model.measured_twist(obs, last, twist)
        assert_allclose(twist, true, atol=1e-9)
        assert_allclose(last, obs[layout.POSE : layout.POSE + 3])


def test_a_robots_lag_is_what_was_measured_else_the_slower_of_motor_and_mass():
    assert wheel_model.lag_of(ROBOT) == ROBOT.pwm_map.lag_s
    swerve = hd.load("swerve3")
    heavy = replace(swerve, mass_kg=2.0 * swerve.mass_kg)
    assert swerve.wheels[0].motor.lag_s < wheel_model.lag_of(swerve) < wheel_model.lag_of(heavy)
    light = hd.load("omni3")
    assert_allclose(wheel_model.lag_of(light), light.wheels[0].motor.lag_s / (1.0 + light.speed_loop.kp))


def test_a_wheel_that_stands_needs_more_to_start_than_one_that_turns_to_go_on():
    still, ways = 0.001, np.zeros(N)
    rim = ROBOT.wheels[0].radius

    def sent(*rims_m_s):
        speeds = np.array(rims_m_s) / rim
        standstill.hold_still(KIN, still, ways, speeds)
        return speeds * rim

    assert_allclose(sent(0.0009, 0.0011, -0.0011, 0.0), [0.0, 0.0011, -0.0011, 0.0])
    assert_allclose(sent(0.0009, 0.0006, -0.0006, 0.0), [0.0, 0.0006, -0.0006, 0.0])
    assert_allclose(sent(0.0009, -0.0006, 0.0006, 0.0), 0.0)  # against its way it first stands
    assert_allclose(sent(0.0009, 0.0004, -0.0004, 0.0), 0.0)
    assert math.isnan(sent(math.nan, 0.0, 0.0, 0.0)[0])


def test_dither_about_zero_moves_no_wheel():
    """A robot that stands a hair beside its moving reference's end leaves its wheels alone."""
    goal = references.fixed_goal((0.0, 0.0, 0.0))
    for name in ("ff_pi", "dob"):
        run = hd.rollout(ROBOT, None, name, t=1.0, reference=goal, starts=(5e-5, 0.0, 0.0), log_every=1)
        assert not np.any(run.column("command:fl"))
