"""How far a robot was from the path that it followed, whatever the time at which it should have been where."""

import numpy as np
from numpy.typing import ArrayLike

from holodrive.errors import InputError
from holodrive.references import Table
from holodrive.types import Array

_FINEST_M = 1e-9  # shorter pieces of a path have no direction


def distance_to_path(reference: Table, points: ArrayLike) -> Array:
    """(..., ) distance of points (..., 2 or more) [m] to the nearest place of a trajectory's path [m].

    The path is the chain of the table's rows; each point is measured against the two pieces at its nearest row, so a
    path must be finer than it bends, as those of `follow` are. Points that are NaN give NaN.

    Raises:
        InputError: the table has fewer than two places.
    """
    from scipy.spatial import cKDTree

    places = reference.rows[:, 1:3]
    places = places[np.concatenate([[True], np.hypot(*np.diff(places, axis=0).T) > _FINEST_M])]
    if len(places) < 2:
        raise InputError("a distance to a path needs a path; this reference stays at one place")
    wanted = np.asarray(points, dtype=np.float64)[..., :2]
    flat = wanted.reshape(-1, 2)
    known = np.isfinite(flat).all(axis=1)
    nearest = cKDTree(places).query(flat[known])[1]
    found = np.full(len(flat), np.nan)
    found[known] = np.minimum(
        _to_piece(flat[known], places, np.maximum(nearest - 1, 0)),
        _to_piece(flat[known], places, np.minimum(nearest, len(places) - 2)),
    )
    return found.reshape(wanted.shape[:-1])


def _to_piece(points: Array, places: Array, first: Array) -> Array:
    """Distance (N,) of points (N, 2) to the pieces from `places[first]` to the place after it [m]."""
    start = places[first]
    along = places[first + 1] - start
    away = points - start
    share = np.clip(np.sum(away * along, axis=1) / np.sum(along * along, axis=1), 0.0, 1.0)
    return np.asarray(np.hypot(*(away - share[:, None] * along).T))


__all__ = ["distance_to_path"]
