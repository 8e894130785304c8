"""Weighted least squares for the motion of a body, from rows of any sensors: wheels and ground mice alike.

A row says a . xi = z with variance 1 / w, where xi is a twist (vx, vy, omega) or a displacement (dx, dy, dtheta).
`kinematics.normal_equations` does the same inside compiled estimators.
"""

import numpy as np
from numpy.typing import ArrayLike

from holodrive.errors import InputError
from holodrive.types import Array


def inverse(rows: ArrayLike, weights: ArrayLike, length_m: float = 1.0) -> Array:
    """(..., 3, m) matrix that takes m measurements to the motion with the least weighted squares, by QR.

    Args:
        rows: (..., m, 3).
        weights: (..., m) of the squared residuals, 0 to leave a row out.
        length_m: how many metres a radian counts.

    Raises:
        InputError: the rows with weight do not tell all three motions.
    """
    root = np.sqrt(np.asarray(weights, dtype=np.float64))
    column = np.array([1.0, 1.0, 1.0 / length_m])
    q, r = np.linalg.qr(root[..., None] * np.asarray(rows, dtype=np.float64) * column)
    diagonal = np.abs(np.diagonal(r, axis1=-2, axis2=-1))
    enough = diagonal.shape[-1] == 3 and np.all(np.isfinite(diagonal))
    if not enough or np.any(diagonal.min(axis=-1) <= 1e-12 * diagonal.max(axis=-1)):
        raise InputError("the rows that the weights leave cannot tell all three motions; give more of them weight")
    back = np.linalg.solve(r, np.swapaxes(q, -1, -2)) * root[..., None, :]
    return np.asarray(column[:, None] * back)
