"""Paths on the floor as the paper draws them: x to the right, y ahead."""

from collections.abc import Sequence

import numpy as np

from holodrive.experiments.pictures import paths_over
from holodrive.types import Array
from holodrive.worlds.spec import World

MARGIN_M = 0.02
SIDE_PX = 420.0


def picture(title: str, ways: Sequence[tuple[str, Array]]) -> str:
    """Ways (T, 2 or more) [m] by name as one SVG document; the floor is as large as they need."""
    turned = [(name, as_drawn(way)) for name, way in ways]
    everything = np.concatenate([way for _, way in turned])
    low, high = everything.min(axis=0) - MARGIN_M, everything.max(axis=0) + MARGIN_M
    side = float(max(high - low))
    corner = 0.5 * (low + high) - 0.5 * side
    world = World(title, size=(side, side), corner=(float(corner[0]), float(corner[1])), walls=False)
    return paths_over(world, turned, SIDE_PX, SIDE_PX + 40.0)


def as_drawn(way: Array) -> Array:
    """(T, 2) from x ahead and y left to the paper's x right and y ahead [m]."""
    return np.stack([-way[:, 1], way[:, 0]], axis=-1)


__all__ = ["as_drawn", "picture"]
