"""Claims about estimators in the loop: both faces are one."""

import numpy as np
import pytest

from holodrive import estimation, robots
from holodrive.errors import UnknownName
from holodrive.estimation import KernelEstimator, Odometry, WheelOdometry, track
from holodrive.types import Observation, Pose, WheelState

START = Pose(0.5, -1.0, 4.0)
MEASURED = [name for name in robots.names() if all(wheel.encoder for wheel in robots.load(name).wheels)]


@pytest.mark.parametrize("name", MEASURED)
def test_loop_single_updates_and_whole_recordings_are_the_same_to_the_last_bit(name: str) -> None:
    robot, rng = robots.load(name), np.random.default_rng(1)
    n, m, count = len(robot.wheels), len(robot.steered), 50
    time = np.cumsum(rng.uniform(0.005, 0.02, count))
    position, steer = np.cumsum(0.02 * rng.normal(size=(count, n)), axis=0), rng.normal(size=(count, m))
    gyro = rng.normal(size=count)
    loop = estimation.estimator("wheel_odometry", robot)
    loop.reset(START)
    single = Odometry(robot, pose=START)
    whole = track(robot, time, position, steer=steer, gyro=gyro, start=START)
    for k in range(count):
        wheels = WheelState(position[k], np.zeros(n), steer[k])
        believed = loop.step(Observation(time[k], 0.01, wheels, gyro=gyro[k]))
        updated = single.update(wheels, stamp=time[k], gyro=gyro[k])
        assert believed.pose == updated.pose == Pose(*whole.pose[k])
        assert believed.twist == updated.twist
        assert believed.slip == updated.slip == whole.slip[k]
        assert np.array_equal(believed.covariance, updated.covariance)
        assert np.array_equal(believed.covariance, whole.covariance[k])


def test_a_reset_forgets_everything() -> None:
    robot = robots.load("hybrid3")
    estimator = KernelEstimator(WheelOdometry(), robot)
    for k in range(3):
        estimator.step(Observation(0.1 * k, 0.1, WheelState(np.full(3, 0.1 * k), np.zeros(3), np.zeros(0))))
    estimator.reset(START)
    estimate = estimator.step(Observation(9.0, 0.1, WheelState(np.full(3, 7.0), np.zeros(3), np.zeros(0))))
    assert estimate.pose == START
    assert not estimate.covariance.any()


def test_an_estimate_is_not_changed_by_later_ticks() -> None:
    robot = robots.load("hybrid3")
    estimator = estimation.estimator("wheel_odometry", robot)
    estimator.reset(START)
    kept = [
        estimator.step(Observation(0.1 * k, 0.1, WheelState(np.full(3, 0.1 * k), np.zeros(3), np.zeros(0))))
        for k in range(3)
    ]
    assert kept[1].covariance[2, 2] < kept[2].covariance[2, 2]


def test_estimators_are_found_by_name() -> None:
    assert estimation.names() == sorted(estimation.ESTIMATORS)
    assert "wheel_odometry" in estimation.names()
    assert estimation.summary("wheel_odometry").startswith("Wheel odometry:")
    with pytest.raises(UnknownName, match="Did you mean 'wheel_odometry'"):
        estimation.plug("wheel_odometri")
