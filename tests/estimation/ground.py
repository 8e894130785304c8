"""Motions and what mice count on them."""

import numpy as np

from holodrive import geometry
from holodrive.estimation.mice import rows_of
from holodrive.types import Array, Pose

PAIR = (Pose(0.0, 0.0, 0.0), Pose(0.1, 0.0, 0.0))
CORNERS = (Pose(0.1, 0.08, 0.0), Pose(0.1, -0.08, 0.5), Pose(-0.1, 0.08, -2.0), Pose(-0.1, -0.08, 0.0))
SQUARE = tuple(Pose(x, y, 0.0) for x, y, _ in CORNERS)


def motion(rng: np.random.Generator, duration_s: float, dt_s: float) -> Array:
    """(N, 3) displacements of the body of every sample: sums of slow waves, some 40 mm/s and 0.3 rad/s."""
    t = np.arange(round(duration_s / dt_s)) * dt_s

    def wave(size: float) -> Array:
        frequency, phase, share = rng.uniform(0.05, 0.5, 4), rng.uniform(0, 2 * np.pi, 4), rng.normal(size=4)
        waves = share[:, None] * np.sin(2 * np.pi * frequency[:, None] * t + phase[:, None])
        return np.asarray(0.5 * size * waves.sum(axis=0))

    return np.stack([wave(0.037), wave(0.037), wave(0.3)], axis=-1) * dt_s


def path(displacements: Array) -> Array:
    """(N + 1, 3) poses from the origin on, by the exact exponential."""
    poses = [np.zeros(3)]
    for displacement in displacements:
        poses.append(geometry.compose(poses[-1], geometry.exp(displacement)))
    return np.array(poses)


def ways(displacements: Array, mounts: tuple[Pose, ...]) -> Array:
    """(N, k, 2) what perfect mice tell."""
    return np.stack([displacements @ rows_of(mount).T for mount in mounts], axis=1)


def counts(exact: Array, rng: np.random.Generator, resolution_m: float = 1e-5) -> Array:
    """The same in whole counts, carried on, from any part of a count on."""
    start = rng.random(exact.shape[1:])
    total = np.floor(np.cumsum(exact, axis=0) / resolution_m + start)
    return np.asarray(np.diff(total, axis=0, prepend=np.zeros((1, *exact.shape[1:]))) * resolution_m)
