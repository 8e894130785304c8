"""The generated plain-float functions and the kernels equal the NumPy maps."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from holodrive.kinematics import kernel

seeds = st.integers(0, 2**32 - 1)
twists = st.tuples(st.floats(-3, 3), st.floats(-3, 3), st.floats(-6, 6))


def close(a, b, size=None):
    """To 1e-12 of the largest number involved."""
    size = np.abs(b).max() if size is None else size
    np.testing.assert_allclose(a, b, rtol=0.0, atol=1e-12 * max(size, 1e-3))


@given(seeds, twists)
def test_scalar_inverse_is_the_batch_inverse(chassis_of_seed, seed, twist):
    chassis = chassis_of_seed(seed)
    n, command = len(chassis.wheels), chassis.inverse(twist)
    scalar = chassis.scalar.inverse(*twist)
    assert len(scalar) == n + len(chassis.steered)
    close(scalar[:n], command.speeds, np.abs(chassis.jacobian).max() * 10)
    moving = command.speeds[list(chassis.steered)] > 1e-3
    turn = np.subtract(scalar[n:], command.steer)[moving]
    np.testing.assert_allclose(np.sin(0.5 * turn), 0.0, atol=1e-10)


@given(seeds)
def test_scalar_and_compiled_forward_are_the_batch_forward(chassis_of_seed, seed):
    chassis = chassis_of_seed(seed)
    rng = np.random.default_rng(seed)
    speeds, steer = rng.normal(size=len(chassis.wheels)), rng.uniform(-4, 4, len(chassis.steered))
    solution = chassis.solve(speeds, steer)
    size = np.abs(chassis.least_squares).max() * 10
    close(chassis.forward(speeds, steer), solution.twist, size)
    close(chassis.scalar.forward(*speeds, *steer), solution.twist, size)
    twist = np.zeros(3)
    slip = kernel.forward_step(kernel.arrays(chassis), speeds, steer, twist)
    close(twist, solution.twist, size)
    assert slip == pytest.approx(float(solution.slip), rel=1e-9, abs=1e-12 * np.abs(chassis.jacobian).max() * size)


def test_the_generated_text_leaves_zeros_out_and_shares_products(bases):
    source = bases["mecanum4"].scalar.source
    assert source.count("*") == 6  # three products each way
    assert "0.0 *" not in bases["hybrid3"].scalar.source


def test_plain_floats_in_plain_floats_out(base):
    assert all(type(value) is float for value in base.scalar.inverse(0.1, 0.2, 0.3))
    assert all(type(value) is float for value in base.scalar.forward(*base.scalar.inverse(0.1, 0.2, 0.3)))


def test_scalar_command_step_is_the_pipeline_without_base_limits(base):
    memory = [0.0] * (3 + 2 * len(base.steered))
    speeds, steer, *_ = base.scalar.command_step(0.01, 0.02, 0.03, 0.01, memory)
    twist = base.forward(speeds, steer)
    np.testing.assert_allclose(twist, [0.01, 0.02, 0.03], atol=1e-5)
