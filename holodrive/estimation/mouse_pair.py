"""The recursion of Keek et al. for two mice as an estimator: what both rules, as printed and corrected, share.

Pose and heading are the recursion's own (`estimation.mouse_recursion`), from the start pose on; twist, covariance,
slip and suspects are those of the rigid form, for the paper gives none. So the covariance is that of the counts, not
of the recursion's mistakes, and a mouse in doubt is told but goes on being used.
"""

import math
from typing import TYPE_CHECKING

import numpy as np
from numba import njit

from holodrive import layout
from holodrive.errors import InputError
from holodrive.estimation import body_motion
from holodrive.estimation import mouse_recursion as recursion
from holodrive.estimation import sensor_state as st
from holodrive.estimation import sensor_table as tb
from holodrive.estimation.mice import mice_of
from holodrive.estimation.mouse_odometry import MouseOdometry
from holodrive.types import Array

if TYPE_CHECKING:
    from holodrive.robots.spec import Robot

# --- params and memory, behind those of the rigid form for two mice -----------------------------------
RULE = st.TABLE + 2 * tb.BLOCK
BASELINE = RULE + 1  # m
STATE = st.STATES + 2 * st.STATE  # of the recursion
START = STATE + recursion.STATE  # 3: pose
HEADING = START + 3  # rad, not wrapped
BEGUN = HEADING + 1
MEMORY = BEGUN + 1

_OFF_LINE = 0.02  # part of the distance that a mount may be off
_OFF_YAW = math.radians(2.0)


def pack(robot: "Robot", who: str, rule: int, twist_s: float) -> Array:
    """Packed parameters of an estimator of that name.

    Raises:
        InputError: the mice are not two on one forward axis, the first in the robot's centre.
    """
    mice = mice_of(robot, who, at_least=2)
    first, second = mice[0].mount, mice[1].mount
    line = second.x
    slack = _OFF_LINE * abs(line)
    good = (
        len(mice) == 2
        and all(mouse.axes == "xy" for mouse in mice)
        and line > 0.0
        and max(abs(first.x), abs(first.y), abs(second.y)) <= slack
        and max(abs(math.remainder(mouse.mount.theta, math.tau)) for mouse in mice) <= _OFF_YAW
    )
    if not good:
        found = ", ".join(
            f"{mouse.name} at ({mouse.mount.x:.4g} m, {mouse.mount.y:.4g} m, {math.degrees(mouse.mount.theta):.4g} deg)"
            for mouse in mice
        )
        raise InputError(
            f"{who} needs two mice on one forward axis, the first in the robot's centre, the second ahead of it, both "
            f"at yaw 0; {robot.name} has {found}; mouse_odometry takes any mounting"
        )
    return np.concatenate([MouseOdometry(twist_s=twist_s).pack(robot), [rule, line]])


@njit(cache=True, error_model="numpy")
def tick(obs: Array, memory: Array, params: Array, estimate: Array) -> None:
    """One tick over the arrays of `holodrive.layout`."""
    state, start = memory[STATE : STATE + recursion.STATE], memory[START : START + 3]
    begun = memory[BEGUN] != 0.0
    if not begun:
        memory[BEGUN] = 1.0
        memory[HEADING] = memory[2]
        for i in range(3):
            start[i] = memory[i]
        recursion.start(state, params[BASELINE])
    body_motion.tick(obs, memory, params, estimate)
    z = obs[layout.MICE : layout.MICE + 4]
    if begun and math.isfinite(z[0] + z[1] + z[2] + z[3]):
        before = state[recursion.ALPHA]
        # the paper's x is to the right, y ahead
        recursion.step(state, int(params[RULE]), -z[1], z[0], -z[3], z[2])
        memory[HEADING] -= recursion.wrap(state[recursion.ALPHA] - before)
    ahead, left = state[recursion.FIRST + 1], -state[recursion.FIRST]
    c, s = math.cos(start[2]), math.sin(start[2])
    estimate[layout.EST_POSE] = start[0] + c * ahead - s * left
    estimate[layout.EST_POSE + 1] = start[1] + s * ahead + c * left
    estimate[layout.EST_POSE + 2] = memory[HEADING]
