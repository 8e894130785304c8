"""Ground sensors as rows of least squares: what a displacement of the body is in the axes of a mouse.

    z = R(phi)^T [[1, 0, -y], [0, 1, x]] (dx, dy, dtheta)

for a mouse at (x, y) whose x axis points to phi. It is exact for any displacement at constant twist: the counters
integrate the velocity in their own axes, which turn with the body.
"""

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from holodrive.errors import InputError
from holodrive.types import Array, Pose

if TYPE_CHECKING:
    from holodrive.robots.spec import Mouse, Robot

_NEAR = 1e-3  # mice nearer to each other than this many metres do not tell a turn


def rows_of(mount: Pose) -> Array:
    """(2, 3) the rows of a mouse mounted there: its x, its y over a displacement of the body."""
    c, s = math.cos(mount.theta), math.sin(mount.theta)
    return np.array([[c, s, c * -mount.y + s * mount.x], [-s, c, s * mount.y + c * mount.x]])


def baseline(mice: "Sequence[Mouse]") -> float:
    """Largest distance between two of the mice [m]."""
    return max((math.dist(a.mount[:2], b.mount[:2]) for a in mice for b in mice), default=0.0)


def mice_of(robot: "Robot", who: str, at_least: int = 2) -> "tuple[Mouse, ...]":
    """The mice of a robot, once it is clear that they can be right.

    Args:
        robot: any.
        who: the estimator that asks, for the message.
        at_least: how many it needs.

    Raises:
        InputError: too few mice; one outside the footprint; all of them in one place.
    """
    both = sum(mouse.axes == "xy" for mouse in robot.mice)
    if both < at_least:
        wheels = len(robot.mice) - both
        raise InputError(
            f"{who} needs {at_least} {'mouse' if at_least == 1 else 'mice'}, {robot.name} has {both}"
            + (f" and {wheels} measuring {'wheel' if wheels == 1 else 'wheels'}, which ekf takes" if wheels else "")
            + "; add [sensor.mouse.NAME] with its mount to the robot's file"
        )
    for mouse in robot.mice:
        far = math.hypot(mouse.mount.x, mouse.mount.y)
        if far > robot.footprint_radius_m:
            raise InputError(
                f"{who}: mouse {mouse.name} of {robot.name} lies {far:.4g} m from the robot's centre, outside its "
                f"footprint of {robot.footprint_radius_m:.4g} m; correct 'mount' of [sensor.mouse.{mouse.name}]"
            )
    if at_least > 1 and baseline(robot.mice) < _NEAR:
        raise InputError(
            f"{who}: all mice of {robot.name} lie in one place and cannot tell a turn; mount them further apart"
        )
    return robot.mice
