"""SE(2) on arrays (..., 3): poses (x, y, theta) and twists (vx, vy, omega) [m, m, rad].

Exact closed forms, stable near zero and at pi. Leading axes batch and broadcast.
`exp` and `log` are inverse to each other for |omega| < pi; headings out of `compose`, `inverse` and `exp`
are not wrapped, so that a heading can count turns (use `wrap`).
"""

import numpy as np
from numpy.typing import ArrayLike

from holodrive.types import Array

_SERIES = 1e-2  # rad: below this, series of four terms are exact to the last bit


def wrap(angle: ArrayLike) -> Array:
    """Angle(s) [rad] in (-pi, pi]; both +pi and -pi give +pi, an angle in range stays as it is to the last bit."""
    # all three steps are exact in floating point, so nothing leaves the range by rounding
    rest = np.fmod(np.asarray(angle, dtype=np.float64), 2.0 * np.pi)
    turns = np.where(rest > np.pi, -2.0 * np.pi, np.where(rest <= -np.pi, 2.0 * np.pi, -0.0))
    return np.asarray(rest + turns)


def compose(a: ArrayLike, b: ArrayLike) -> Array:
    """Pose `b`, given in the frame of `a`, in the frame that `a` is given in: T_world_a @ T_a_b."""
    a, b = _pair(a, b)
    c, s = np.cos(a[..., 2]), np.sin(a[..., 2])
    x = a[..., 0] + c * b[..., 0] - s * b[..., 1]
    y = a[..., 1] + s * b[..., 0] + c * b[..., 1]
    return np.stack([x, y, a[..., 2] + b[..., 2]], axis=-1)


def inverse(a: ArrayLike) -> Array:
    """T_a_world from T_world_a."""
    a = _vector(a)
    c, s = np.cos(a[..., 2]), np.sin(a[..., 2])
    return np.stack([-c * a[..., 0] - s * a[..., 1], s * a[..., 0] - c * a[..., 1], -a[..., 2]], axis=-1)


def between(a: ArrayLike, b: ArrayLike) -> Array:
    """Pose of `b` seen from `a`: inverse(a) composed with b."""
    return compose(inverse(a), b)


def exp(twist: ArrayLike) -> Array:
    """Pose reached from the origin by holding a body twist for one second (or a displacement twist)."""
    twist = _vector(twist)
    sine, versine = _sinc(twist[..., 2])
    vx, vy = twist[..., 0], twist[..., 1]
    return np.stack([sine * vx - versine * vy, versine * vx + sine * vy, twist[..., 2]], axis=-1)


def log(pose: ArrayLike) -> Array:
    """Body twist whose `exp` is the pose; the heading is wrapped first, pi stays +pi."""
    pose = _vector(pose)
    theta = wrap(pose[..., 2])
    half = _half_cotangent(theta)
    x, y, k = pose[..., 0], pose[..., 1], 0.5 * theta
    return np.stack([half * x + k * y, half * y - k * x, theta], axis=-1)


def rotate(angle: ArrayLike, vector: ArrayLike) -> Array:
    """Planar part of `vector` (..., 2 or 3) turned by `angle` [rad]; a third component stays."""
    angle, vector = np.asarray(angle, dtype=np.float64), np.asarray(vector, dtype=np.float64)
    c, s = np.cos(angle), np.sin(angle)
    x, y = c * vector[..., 0] - s * vector[..., 1], s * vector[..., 0] + c * vector[..., 1]
    rest = [np.broadcast_to(vector[..., i], x.shape) for i in range(2, vector.shape[-1])]
    return np.stack([x, y, *rest], axis=-1)


def adjoint(pose: ArrayLike) -> Array:
    """(..., 3, 3) matrix that turns a twist at the pose's frame into the twist of the outer frame."""
    pose = _vector(pose)
    c, s = np.cos(pose[..., 2]), np.sin(pose[..., 2])
    zero, one = np.zeros_like(c), np.ones_like(c)
    rows = [[c, -s, pose[..., 1]], [s, c, -pose[..., 0]], [zero, zero, one]]
    return np.stack([np.stack(row, axis=-1) for row in rows], axis=-2)


def _sinc(omega: Array) -> tuple[Array, Array]:
    """sin(w)/w and (1 - cos(w))/w."""
    small = np.abs(omega) < _SERIES
    w = np.where(small, 1.0, omega)
    q = omega * omega
    sine = np.where(small, 1.0 - q / 6.0 * (1.0 - q / 20.0 * (1.0 - q / 42.0)), np.sin(w) / w)
    # 1 - cos(w) = 2 sin(w/2)^2 keeps all digits where the difference would lose them
    versine = np.where(
        small, 0.5 * omega * (1.0 - q / 12.0 * (1.0 - q / 30.0 * (1.0 - q / 56.0))), 2.0 * np.sin(0.5 * w) ** 2 / w
    )
    return sine, versine


def _half_cotangent(theta: Array) -> Array:
    """(theta/2) cot(theta/2), 1 at zero and 0 at pi."""
    small = np.abs(theta) < _SERIES
    h = 0.5 * np.where(small, 1.0, theta)
    q = theta * theta
    series = 1.0 - q / 12.0 * (1.0 + q / 60.0 * (1.0 + q / 42.0))
    return np.where(small, series, h * np.cos(h) / np.sin(h))


def _vector(value: ArrayLike) -> Array:
    array = np.asarray(value, dtype=np.float64)
    if array.ndim == 0 or array.shape[-1] != 3:
        raise ValueError(f"an SE(2) array has shape (..., 3), found {array.shape}")
    return array


def _pair(a: ArrayLike, b: ArrayLike) -> tuple[Array, Array]:
    first, second = np.broadcast_arrays(_vector(a), _vector(b))
    return first, second
