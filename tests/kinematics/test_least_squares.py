"""Claims about weighted least squares over rows of any sensors: kernels and arrays are one, and both are lstsq."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from holodrive.errors import InputError
from holodrive.kinematics import least_squares
from holodrive.kinematics import normal_equations as eq
from holodrive.types import Array


def by_kernels(rows: Array, z: Array, weights: Array, length: float) -> tuple[bool, Array, Array]:
    """Whether it is told, the motion, and (3, m) how errors of z move it."""
    normal, out = np.zeros(eq.SIZE), np.full(3, np.nan)
    eq.clear(normal)
    flat = rows.ravel()
    for i, (value, weight) in enumerate(zip(z, weights, strict=True)):
        eq.take(normal, flat, 3 * i, length, value, weight)
    told = bool(eq.solve(normal, length, out))
    back = [eq.back(normal, flat, 3 * i, length, weight) for i, weight in enumerate(weights)] if told else []
    return told, out, np.array(back).T


@given(seed=st.integers(0, 10**6), m=st.integers(3, 12), length=st.sampled_from([0.05, 0.3, 2.0]))
def test_kernels_arrays_and_lstsq_agree(seed: int, m: int, length: float) -> None:
    rng = np.random.default_rng(seed)
    rows, z, weights = rng.normal(size=(m, 3)) * [1.0, 1.0, length], rng.normal(size=m), rng.uniform(0.1, 10.0, m)
    root = np.sqrt(weights)
    wanted = np.linalg.lstsq(root[:, None] * rows, root * z, rcond=None)[0]
    if np.linalg.cond(root[:, None] * rows / [1.0, 1.0, length]) > 1e3:
        return
    told, motion, back = by_kernels(rows, z, weights, length)
    inverse = least_squares.inverse(rows, weights, length)
    assert told
    scale = np.array([1.0, 1.0, length])
    np.testing.assert_allclose(scale * (inverse @ z), scale * wanted, atol=1e-9)
    np.testing.assert_allclose(scale * motion, scale * wanted, atol=1e-8)
    np.testing.assert_allclose(scale[:, None] * back, scale[:, None] * inverse, atol=1e-7)


def test_many_are_solved_at_once() -> None:
    rng = np.random.default_rng(1)
    rows, weights = rng.normal(size=(5, 7, 3)), rng.uniform(0.5, 2.0, (5, 7))
    whole = least_squares.inverse(rows, weights)
    for k in range(5):
        np.testing.assert_allclose(whole[k], least_squares.inverse(rows[k], weights[k]), atol=1e-12)


@pytest.mark.parametrize(
    "rows",
    [
        np.array([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]),  # one mouse in the centre
        np.array([[1.0, 0.0, -0.1], [0.0, 1.0, 0.2]]),  # one mouse anywhere
        np.array([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [1.0, 1.0, 0.0]]),  # nobody tells the turn
        np.array([[0.0, 0.0, 0.1], [0.0, 1.0, 0.2], [0.0, -1.0, 0.2]]),  # nobody tells the way ahead
    ],
)
def test_rows_that_leave_a_motion_open_are_told(rows: Array) -> None:
    told, motion, _ = by_kernels(rows, np.ones(len(rows)), np.ones(len(rows)), 0.1)
    assert not told
    assert np.isnan(motion).all()
    with pytest.raises(InputError, match="cannot tell all three motions"):
        least_squares.inverse(rows, np.ones(len(rows)), 0.1)
