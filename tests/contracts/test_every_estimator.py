"""What every estimator of the registry keeps, on every robot of the catalog."""

import math
from dataclasses import replace

import numpy as np
import pytest

from holodrive import estimation, layout, robots
from holodrive.errors import InputError
from holodrive.observation_array import empty_observation, fill_observation
from holodrive.types import Estimate, Observation, Pose, WheelState

START = Pose(1.0, -2.0, 3.5)


def suits(name: str, robot: str) -> bool:
    """Whether the robot has the sensors that the estimator needs."""
    try:
        estimation.plug(name).pack(robots.load(robot))
    except InputError:
        return False
    return True


CASES = [(name, robot) for name in estimation.names() for robot in robots.names() if suits(name, robot)]


def observations(robot_name: str) -> list[Observation]:
    """Half a second of wheels that turn slowly and mice that pass slowly over the ground."""
    robot, rng = robots.load(robot_name), np.random.default_rng(4)
    n, m, dt = len(robot.wheels), len(robot.steered), robot.control_period_s
    position = np.cumsum(1e-3 * rng.normal(size=(30, n)), axis=0)
    steer = 0.1 * rng.normal(size=(30, m))
    mice = 1e-5 * rng.integers(-5, 6, size=(30, len(robot.mice), 2))
    return [
        Observation(k * dt, dt, WheelState(position[k], np.zeros(n), steer[k]), gyro=0.01, mice=mice[k])
        for k in range(30)
    ]


def numbers(estimate: Estimate) -> list[float]:
    return [*estimate.pose, *estimate.twist, *estimate.covariance.ravel().tolist(), estimate.slip, estimate.suspect]


@pytest.mark.parametrize(("name", "robot"), CASES)
def test_both_faces_believe_the_same_to_the_last_bit(name: str, robot: str) -> None:
    spec = robots.load(robot)
    loop = estimation.estimator(name, spec)
    loop.reset(START)
    plug = estimation.plug(name)
    memory, params = np.zeros(plug.memory_size(spec)), plug.pack(spec)
    memory[layout.START_POSE : layout.START_POSE + 3] = START
    flat, out = empty_observation(), np.zeros(layout.ESTIMATE_SIZE)
    for observation in observations(robot):
        fill_observation(flat, observation)
        plug.kernel(flat, memory, params, out)
        assert numbers(loop.step(observation)) == out.tolist()


@pytest.mark.parametrize(("name", "robot"), CASES)
def test_the_first_belief_is_the_start_and_a_reset_repeats_everything(name: str, robot: str) -> None:
    estimator = estimation.estimator(name, robots.load(robot))
    runs = []
    for _ in range(2):
        estimator.reset(START)
        runs.append([numbers(estimator.step(observation)) for observation in observations(robot)])
    assert runs[0] == runs[1]
    assert runs[0][0][:3] == list(START)
    assert np.isfinite(runs[0]).all()


@pytest.mark.parametrize(("name", "robot"), CASES)
def test_the_covariance_is_symmetric_and_never_negative(name: str, robot: str) -> None:
    estimator = estimation.estimator(name, robots.load(robot))
    estimator.reset(START)
    for observation in observations(robot):
        covariance = estimator.step(observation).covariance
        np.testing.assert_array_equal(covariance, covariance.T)
        assert np.linalg.eigvalsh(covariance).min() >= -1e-15


def blinded(seen: Observation) -> Observation:
    """The same tick with no number in it that a sensor told."""
    wheels = WheelState(
        *(np.full(len(values), np.nan) for values in (seen.wheels.position, seen.wheels.speed, seen.wheels.steer))
    )
    assert seen.mice is not None
    return replace(seen, wheels=wheels, gyro=math.nan, mice=np.full_like(seen.mice, np.nan))


@pytest.mark.parametrize(("name", "robot"), CASES)
def test_readings_that_are_no_numbers_neither_move_nor_poison_it(name: str, robot: str) -> None:
    """NaN for two ticks: the belief stays finite, stays near, and goes on afterwards."""
    estimator = estimation.estimator(name, robots.load(robot))
    estimator.reset(START)
    seen = observations(robot)
    for k in (12, 13):
        seen[k] = blinded(seen[k])
    rows = [numbers(estimator.step(observation)) for observation in seen]
    assert np.isfinite(rows).all()
    assert np.abs(np.diff(rows, axis=0)[11:14, :2]).max() < 1e-3
    assert rows[-1][:3] != rows[13][:3]


@pytest.mark.parametrize("name", estimation.names())
def test_a_robot_without_the_sensors_is_refused_in_one_clear_line(name: str) -> None:
    """Neither encoders nor mice: no estimator can say anything."""
    whole = robots.load("omni3")
    blind = replace(whole, wheels=tuple(replace(wheel, encoder=None) for wheel in whole.wheels), mice=())
    with pytest.raises(InputError, match=r"(mouse|mice|encoder)") as refused:
        estimation.plug(name).pack(blind)
    assert "\n" not in str(refused.value)


@pytest.mark.parametrize("name", estimation.names())
def test_some_robot_of_the_catalog_suits_it(name: str) -> None:
    assert any(case[0] == name for case in CASES)


@pytest.mark.parametrize("name", estimation.names())
def test_it_says_in_one_line_what_it_is(name: str) -> None:
    assert 10 < len(estimation.summary(name)) < 120
