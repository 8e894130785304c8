"""Does a covariance tell the size of the error? NEES of many runs against the band that a right filter keeps.

The normalised estimation error squared e' P^-1 e of a pose is chi-square of three degrees of freedom when P is the
covariance of e (Bar-Shalom, Li and Kirubarajan 2001, section 5.4); its mean over runs lies inside `band`.
"""

import numpy as np
from numpy.typing import ArrayLike

from holodrive.errors import InputError
from holodrive.geometry import wrap
from holodrive.types import Array


def nees(pose: ArrayLike, covariance: ArrayLike, truth: ArrayLike) -> Array:
    """(...) e' P^-1 e of poses (..., 3) with covariances (..., 3, 3), the heading's error wrapped."""
    error = np.asarray(pose, dtype=np.float64) - np.asarray(truth, dtype=np.float64)
    error[..., 2] = wrap(error[..., 2])
    weighed = np.linalg.solve(np.asarray(covariance, dtype=np.float64), error[..., None])[..., 0]
    return np.asarray(np.sum(error * weighed, axis=-1))


def band(dof: float, runs: int, share: float = 0.95) -> tuple[float, float]:
    """Between which the mean over `runs` independent runs of a chi-square of `dof` lies with this probability."""
    if not (dof > 0.0 and runs > 0 and 0.0 < share < 1.0):
        raise InputError(f"a band takes dof > 0, runs > 0 and a share inside 0..1; found {dof}, {runs}, {share}")
    from scipy.stats import chi2

    low, high = chi2.ppf([0.5 - 0.5 * share, 0.5 + 0.5 * share], dof * runs) / runs
    return float(low), float(high)
