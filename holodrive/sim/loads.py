"""How much of the robot's weight each wheel carries."""

from collections.abc import Sequence

import numpy as np

from holodrive.errors import InputError
from holodrive.types import Array

GRAVITY = 9.80665  # m/s^2


def wheel_loads(
    places: Sequence[tuple[float, float]], centre: tuple[float, float], weight_n: float, name: str = "the robot"
) -> Array:
    """Normal force (n,) [N] at each wheel in static equilibrium on a flat floor.

    More than three wheels share the weight in the least-norm way (equal springs); a wheel that would be pulled
    down lifts off and carries nothing. Wheels in one line cannot hold a robot up alone: they carry the least-norm
    share and a frictionless caster the rest.

    Args:
        places: contact points (x, y) [m].
        centre: of mass (x, y) [m].
        weight_n: m g [N].
        name: for the error.

    Raises:
        InputError: the centre of mass is outside the wheels, so that the robot falls over.
    """
    points = np.asarray(places, dtype=np.float64) - np.asarray(centre)
    balance = np.vstack([np.ones(len(points)), points.T])  # (3, n): force and both moments about the centre
    wanted = np.array([weight_n, 0.0, 0.0])
    standing = np.ones(len(points), dtype=bool)
    flat = np.linalg.matrix_rank(balance, tol=1e-9) == 3
    while standing.any():
        loads = np.zeros(len(points))
        loads[standing] = np.linalg.pinv(balance[:, standing]) @ wanted
        missing = np.abs(balance @ loads - wanted).max()
        if flat and missing > 1e-6 * weight_n:
            break
        if loads.min() >= -1e-9 * weight_n:
            return np.maximum(loads, 0.0)
        standing &= loads > 0.0
    raise InputError(
        f"the centre of mass of {name}, ({centre[0]:g}, {centre[1]:g}) m, is outside its wheels' contact points: "
        "it would fall over; check centre_of_mass and the wheels' places"
    )
