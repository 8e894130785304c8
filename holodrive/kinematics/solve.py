"""Least squares from wheels to twist with everything that comes with it: residual, slip, covariance."""

from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from holodrive.errors import ChassisError, InputError
from holodrive.kinematics import least_squares
from holodrive.types import Array

if TYPE_CHECKING:
    from holodrive.kinematics.chassis import Chassis


class Solution(NamedTuple):
    """What wheels say about the motion of the body.

    Attributes:
        twist: (..., 3) least squares.
        residual: (..., rows) measured minus explained, in the units of the Jacobian's rows.
        covariance: (..., 3, 3) of the twist. Without `wheel_sigma` it is estimated from the residual, and NaN where
            there is no redundancy to estimate it from.
        slip: (...) root mean square of the residual over the rows [m/s of rim]; 0 without redundancy.
        redundancy: rows beyond three. 0 means that the wheels cannot contradict each other, so a residual of 0
            proves nothing.
    """

    twist: Array
    residual: Array
    covariance: Array
    slip: Array
    redundancy: int


def solve(
    chassis: "Chassis",
    speeds: ArrayLike,
    steer: ArrayLike | None = None,
    weights: ArrayLike | None = None,
    wheel_sigma: ArrayLike | None = None,
    steer_rates: ArrayLike | None = None,
) -> Solution:
    """Twist from wheel speeds (..., n) [rad/s] and steering angles (..., m) [rad].

    Args:
        chassis: the base.
        speeds: (..., n) [rad/s].
        steer: (..., m) [rad].
        weights: (n,) or (..., n) of each wheel's squared residual, 0 to leave a wheel out; 1 when not given.
        wheel_sigma: (n,) or one standard deviation of the wheel speeds [rad/s]. For a steered wheel it counts along
            and across the wheel alike.
        steer_rates: (..., m) [rad/s]; matters with casters only, 0 when not given.
    """
    rows = chassis.rows_of(speeds, steer, steer_rates)
    matrix = chassis.matrix_at(steer)
    inverse = chassis.inverse_at(matrix) if weights is None else weighted_inverse(chassis, weights, matrix)
    twist = np.einsum("...ij,...j->...i", inverse, rows)
    residual = rows - (np.einsum("...ij,...j->...i", matrix, twist) if chassis.castered else twist @ matrix.T)
    if chassis.redundancy == 0:
        residual = np.zeros_like(residual)
    rim = np.concatenate([[1.0, 1.0] if wheel.steered else [wheel.radius] for wheel in chassis.wheels])
    slip = np.sqrt(np.mean((residual * rim) ** 2, axis=-1))
    covariance = _covariance(chassis, matrix, inverse, residual, weights, wheel_sigma)
    return Solution(twist, residual, covariance, slip, chassis.redundancy)


def weighted_inverse(chassis: "Chassis", weights: ArrayLike, matrix: Array) -> Array:
    """(..., 3, rows) inverse that minimises the weighted squares of the residual: (J'WJ)^-1 J'W by QR."""
    scale = chassis.row_scale
    scaled = _per_row(chassis, weights, "weights")
    try:
        inverse = least_squares.inverse(scale[:, None] * matrix, scaled)
    except InputError as error:
        raise ChassisError(
            "the wheels that the weights leave cannot tell all three motions; give more of them weight"
        ) from error
    return inverse * scale


def _covariance(
    chassis: "Chassis",
    matrix: Array,
    inverse: Array,
    residual: Array,
    weights: ArrayLike | None,
    wheel_sigma: ArrayLike | None,
) -> Array:
    transpose = np.swapaxes(inverse, -1, -2)
    if wheel_sigma is not None:
        # speeds [rad/s] to the units of the rows
        units = np.concatenate([[wheel.radius] * 2 if wheel.steered else [1.0] for wheel in chassis.wheels])
        sigma = _per_row(chassis, wheel_sigma, "wheel_sigma") * units
        return _full((inverse * sigma[..., None, :] ** 2) @ transpose, residual)
    if chassis.redundancy == 0:
        return np.full((*residual.shape[:-1], 3, 3), np.nan)
    weight = np.ones(len(chassis.jacobian)) if weights is None else _per_row(chassis, weights, "weights")
    weight = weight * chassis.row_scale**2
    freedom = np.maximum(np.count_nonzero(weight, axis=-1) - 3, 0)
    square = np.sum(weight * residual**2, axis=-1)
    variance = np.where(freedom > 0, square / np.maximum(freedom, 1), np.nan)
    normal = np.swapaxes(matrix, -1, -2) @ (weight[..., None] * matrix)
    return _full(np.asarray(np.linalg.inv(normal), dtype=np.float64), residual) * variance[..., None, None]


def _full(matrix: Array, residual: Array) -> Array:
    return np.array(np.broadcast_to(matrix, (*residual.shape[:-1], 3, 3)))


def _per_row(chassis: "Chassis", values: ArrayLike, what: str) -> Array:
    """Values of wheels (..., n) or one for all, as values of rows (..., rows)."""
    values = np.asarray(values, dtype=np.float64)
    n = len(chassis.wheels)
    if values.ndim and values.shape[-1] != n:
        raise ChassisError(f"{what} has shape {values.shape}; expected (..., {n}), one for each wheel, or one number")
    if np.any(~np.isfinite(values)) or np.any(values < 0.0):
        raise ChassisError(f"{what} must be finite and at least 0, found {values}")
    counts = [2 if wheel.steered else 1 for wheel in chassis.wheels]
    return np.repeat(np.broadcast_to(values, (*values.shape[:-1], n) if values.ndim else (n,)), counts, axis=-1)
