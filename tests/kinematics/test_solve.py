"""Least squares with residual, slip, weights and covariance."""

import math

import numpy as np
import pytest

from holodrive.errors import ChassisError
from holodrive.kinematics import Chassis, Wheel


def test_three_wheels_say_that_they_cannot_contradict_each_other(bases):
    solution = bases["hybrid3"].solve([1.0, -2.0, 3.0])
    assert solution.redundancy == 0
    assert not np.any(solution.residual)
    assert float(solution.slip) == 0.0
    assert np.all(np.isnan(solution.covariance))


def test_the_slip_of_four_mecanum_wheels_is_their_one_contradiction(bases):
    chassis = bases["mecanum4"]
    pattern = np.array([1.0, 1.0, -1.0, -1.0])
    command = chassis.inverse([0.1, -0.2, 0.3])
    solution = chassis.solve(command.speeds + 0.5 * pattern)
    np.testing.assert_allclose(solution.twist, [0.1, -0.2, 0.3], atol=1e-14)
    np.testing.assert_allclose(solution.residual, 0.5 * pattern, atol=1e-12)
    assert float(solution.slip) == pytest.approx(0.5 * 0.03)
    assert solution.redundancy == 1


def test_covariance_from_wheel_noise_is_what_noise_does(base):
    """Against 20 000 drawn noises; a steered wheel's noise counts along and across."""
    rng, n = np.random.default_rng(8), len(base.wheels)
    sigma = rng.uniform(0.05, 0.1, n)
    command = base.inverse([0.3, 0.2, 0.5])
    solution = base.solve(command.speeds, command.steer, wheel_sigma=sigma)
    rows = base.rows_of(command.speeds, command.steer)
    per_row = np.concatenate(
        [[s * w.radius] * 2 if w.steered else [s] for s, w in zip(sigma, base.wheels, strict=True)]
    )
    drawn = (rows + per_row * rng.normal(size=(20000, len(rows)))) @ base.least_squares.T
    scale = np.sqrt(np.outer(np.diag(solution.covariance), np.diag(solution.covariance)))
    np.testing.assert_allclose(np.cov(drawn.T) / scale, solution.covariance / scale, atol=0.04)


def test_covariance_without_known_noise_comes_from_the_residual(bases):
    chassis, rng = bases["mecanum4"], np.random.default_rng(9)
    speeds = chassis.inverse([0.1, 0.0, 0.0]).speeds + 0.2 * rng.normal(size=(4000, 4))
    estimated = np.mean(chassis.solve(speeds).covariance, axis=0)
    np.testing.assert_allclose(estimated, chassis.solve(speeds[0], wheel_sigma=0.2).covariance, rtol=0.1, atol=1e-9)


def test_a_wheel_without_weight_is_not_heard(bases):
    chassis = bases["mecanum4"]
    speeds = chassis.inverse([0.1, -0.2, 0.3]).speeds
    speeds[1] = 99.0
    solution = chassis.solve(speeds, weights=[1.0, 0.0, 1.0, 1.0])
    np.testing.assert_allclose(solution.twist, [0.1, -0.2, 0.3], atol=1e-12)
    assert abs(solution.residual[1]) > 50.0
    with pytest.raises(ChassisError, match="cannot tell all three motions"):
        chassis.solve(speeds, weights=[1.0, 0.0, 0.0, 1.0])
    with pytest.raises(ChassisError, match="at least 0"):
        chassis.solve(speeds, weights=[1.0, -1.0, 1.0, 1.0])
    with pytest.raises(ChassisError, match=r"wheel_sigma has shape \(2,\)"):
        chassis.solve(speeds, wheel_sigma=[1.0, 1.0])


def test_weighted_least_squares_minimises_the_weighted_squares(base):
    rng = np.random.default_rng(10)
    speeds, steer = rng.normal(size=(5, len(base.wheels))), rng.uniform(-3, 3, (5, len(base.steered)))
    weights = rng.uniform(0.2, 3.0, len(base.wheels))
    solution = base.solve(speeds, steer, weights=weights)
    counts = [2 if wheel.steered else 1 for wheel in base.wheels]
    w = np.repeat(weights, counts) * base.row_scale**2
    gradient = (solution.residual * w) @ base.jacobian
    np.testing.assert_allclose(gradient, 0.0, atol=1e-10)
    np.testing.assert_allclose(
        base.solve(speeds, steer, weights=np.full(len(base.wheels), 7.0)).twist, base.forward(speeds, steer), atol=1e-12
    )


def test_one_weight_set_for_each_sample(bases):
    chassis, rng = bases["omni4"], np.random.default_rng(11)
    speeds, weights = rng.normal(size=(6, 4)), rng.uniform(0.1, 1.0, (6, 4))
    batch = chassis.solve(speeds, weights=weights)
    for i in range(6):
        single = chassis.solve(speeds[i], weights=weights[i])
        np.testing.assert_allclose(batch.twist[i], single.twist, atol=1e-12)
        np.testing.assert_allclose(batch.covariance[i], single.covariance, atol=1e-12)


def test_equal_noise_on_a_symmetric_base_is_isotropic():
    angles = [2.0 * math.pi * i / 5 for i in range(5)]
    chassis = Chassis([Wheel.omni(math.cos(a), math.sin(a), a + math.pi / 2, 0.1) for a in angles])
    covariance = chassis.solve(np.zeros(5), wheel_sigma=1.0).covariance
    np.testing.assert_allclose(covariance, np.diag([0.01 * 2 / 5, 0.01 * 2 / 5, 0.01 / 5]), atol=1e-15)
