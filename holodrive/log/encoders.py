"""Encoder counts to wheel angles, by what the robot's file says of its encoders."""

from collections.abc import Sequence

import numpy as np

from holodrive import robots
from holodrive.errors import LogError
from holodrive.types import Array


def counts_per_turn(robot: str, wheels: Sequence[str], what: str) -> Array:
    """(n,) counts of a turn of each wheel.

    Raises:
        LogError: the robot lacks a wheel, or the wheel an encoder; `what` says whose counts they are.
    """
    by_name = {wheel.name: wheel for wheel in robots.load(robot).wheels}
    counts = []
    for name in wheels:
        encoder = by_name[name].encoder if name in by_name else None
        if encoder is None:
            raise LogError(f"robot {robot!r} has no wheel {name!r} with an encoder, which {what} needs")
        counts.append(encoder.counts_per_turn)
    return np.array(counts)
