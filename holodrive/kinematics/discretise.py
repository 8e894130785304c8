"""The twist to hold for a tick so that a straight line stays one while the base turns."""

import numpy as np
from numpy.typing import ArrayLike

from holodrive.errors import CommandError
from holodrive.kinematics.shapes import twists
from holodrive.types import Array


def discretise(twist: ArrayLike, dt_s: float) -> Array:
    """Body twist (..., 3) that, held for `dt_s`, reaches the pose (vx dt, vy dt, omega dt) exactly.

    A base that holds (vx, vy, omega) drives an arc; who wants it to keep the direction that it had at the start of
    the tick, and turn besides, holds log((vx, vy, omega) dt) / dt instead. With h = omega dt / 2:
    vx' = h cot(h) vx + h vy, vy' = h cot(h) vy - h vx. A tick may turn by less than a full turn.
    """
    twist = twists(twist)
    half = 0.5 * twist[..., 2] * dt_s
    if not 0.0 < dt_s < np.inf:
        raise CommandError(f"a tick of {dt_s} s; its length must be finite and greater than 0")
    if np.any(np.abs(half) >= np.pi):
        raise CommandError("the base would turn by a full turn or more in one tick; shorten the tick or turn slower")
    k = half_cotangent(half)
    vx, vy = twist[..., 0], twist[..., 1]
    return np.stack([k * vx + half * vy, k * vy - half * vx, twist[..., 2]], axis=-1)


def half_cotangent(half: ArrayLike) -> Array:
    """h cot(h), 1 at 0."""
    half = np.asarray(half, dtype=np.float64)
    safe = np.where(half == 0.0, 1.0, half)
    # as exact as a series for small angles: tan(h) has all its digits there
    return np.asarray(np.where(half == 0.0, 1.0, safe / np.tan(safe)))
