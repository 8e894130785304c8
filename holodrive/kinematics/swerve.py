"""Logic of one steered module, on arrays: shortest turn, cosine scaling.

The command pipeline does the same, unrolled, and knows more: it holds the angle at rest, limits the steering rate,
and lets modules that stand square to their goal decide together.
"""

import numpy as np
from numpy.typing import ArrayLike

from holodrive.geometry import wrap
from holodrive.kinematics.settings import FLIP_SLACK, HOLD_SPEED
from holodrive.types import Array


def optimise(
    speed: ArrayLike, angle: ArrayLike, current: ArrayLike, *, hysteresis: float = 0.0, sign: ArrayLike = 0.0
) -> tuple[Array, Array]:
    """The same motion with less steering: turn at most 90 degrees and drive backwards instead.

    Args:
        speed: (...) wanted drive speed, any unit and sign.
        angle: (...) wanted direction of it [rad].
        current: (...) where the module points [rad].
        hysteresis: how far beyond 90 degrees the error goes before a module changes between forwards and
            backwards [rad]; 0 flips above 90 degrees (and 1e-9 rad for rounding).
        sign: (...) +1 where the module goes forwards now, -1 backwards, 0 at rest; matters with hysteresis only.

    Returns:
        speed (...) and angle (...) in (-pi, pi].
    """
    speed, angle, current, sign = np.broadcast_arrays(
        *(np.asarray(value, dtype=np.float64) for value in (speed, angle, current, sign))
    )
    error = np.abs(wrap(angle - current)) - np.pi / 2
    band = hysteresis * sign
    # who stands on the edge but for rounding keeps driving as it does
    flip = error > band + np.where(band < 0.0, -FLIP_SLACK, FLIP_SLACK)
    return np.where(flip, -speed, speed), wrap(np.where(flip, angle + np.pi, angle))


def cosine_scale(speed: ArrayLike, angle: ArrayLike, current: ArrayLike) -> Array:
    """Drive speed (...) while the module still points elsewhere: the part of the wanted motion along the wheel."""
    return np.asarray(np.asarray(speed) * np.cos(np.asarray(angle, dtype=np.float64) - np.asarray(current)))


def hold_angle(speed: ArrayLike, angle: ArrayLike, last: ArrayLike, hold_speed: float = HOLD_SPEED) -> Array:
    """Steering angles (...) [rad] where modules slower than `hold_speed` [m/s of rim] keep their `last` angle."""
    return np.where(np.abs(speed) < hold_speed, last, angle)
