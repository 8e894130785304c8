"""The recursion of Keek et al., eq. 1 to 7, for two mice: as printed, as corrected, and in closed form.

The paper's frame: x to the right, y ahead, heading alpha clockwise from +Y. Mouse 1 is the robot's position, mouse 2
lies a distance D ahead of it; both have the body's axes. Every mouse is moved by its counts (x_m, y_m),

    P_m += +-h (cos(alpha_m - alpha), sin(alpha_m - alpha)),   h = hypot(x_m, y_m),   alpha_m = atan(y_m / x_m)

and the heading is that of the line from mouse 1 to mouse 2. Three faults of it:

- the sign is printed as that of x_1 for both mice. The arctangent of mouse m lies in its own half plane, so the sign
  of its own x_m is right, and then the rule is P_m += Rot(-alpha) (x_m, y_m);
- for x_1 = 0 it prints x_m as unchanged and y_m as (x_m before) + y_m. The rotation needs no such case;
- nothing holds the mice at their distance: every turn moves mouse 2 along a straight line, so that the line between
  them grows, L^2 = D^2 + sum of dx^2, and later turns are read too small.

The corrected recursion is the same as its closed form over the line alone:

    p_1 += Rot(-alpha) (x_1, y_1),   alpha += atan2(dx, L + dy),   L = hypot(dx, L + dy),   (dx, dy) = (x_2 - x_1, ...)

The paper's remark that x_1 + D is always x_2 contradicts its eq. 7: a rigid body has y_1 = y_2 and x_2 - x_1 = D times
the turn. `estimation.mouse_odometry` uses that instead.
"""

import math

import numpy as np
from numba import njit
from numpy.typing import ArrayLike

from holodrive.errors import InputError
from holodrive.leaf import leaf
from holodrive.types import Array

PRINTED, CORRECTED = 0, 1
FIRST, SECOND, ALPHA = 0, 2, 4  # state: where the mice are (2 each) [m], heading [rad]
STATE = 5


def printed(increments: ArrayLike, baseline_m: float) -> Array:
    """Poses by the recursion as printed.

    Args:
        increments: (N, 4) counts x_1, y_1, x_2, y_2 of every sample [m], in the paper's axes.
        baseline_m: distance D of the mice [m].

    Returns:
        (N + 1, 3): x to the right, y ahead [m], heading clockwise in [-pi, pi) [rad]; row 0 is the start at zero.
        NaN from a sample on whose counts are not finite, or from which mouse 2 lies on mouse 1.
    """
    return _run(increments, baseline_m, PRINTED)


def corrected(increments: ArrayLike, baseline_m: float) -> Array:
    """Poses by the recursion with the sign of each mouse's own x; arguments and result as of `printed`."""
    return _run(increments, baseline_m, CORRECTED)


def closed_form(increments: ArrayLike, baseline_m: float) -> Array:
    """Poses by the closed form of the corrected recursion, with its growing line; the heading is wrapped as there."""
    steps = _checked(increments, baseline_m)
    poses, line = np.zeros((len(steps) + 1, 3)), baseline_m
    for k, (x1, y1, x2, y2) in enumerate(steps.tolist()):
        x, y, alpha = poses[k].tolist()
        c, s = math.cos(alpha), math.sin(alpha)
        dx, dy = x2 - x1, y2 - y1
        turned = alpha + math.atan2(dx, line + dy)
        line = math.hypot(dx, line + dy)
        poses[k + 1] = x + c * x1 + s * y1, y - s * x1 + c * y1, wrap(turned)
    return poses


def rigid(increments: ArrayLike, baseline_m: float) -> Array:
    """Poses of a rigid body with those mice: turns by (x_2 - x_1) / D on exact arcs; the heading is not wrapped."""
    steps = _checked(increments, baseline_m)
    turn = (steps[:, 2] - steps[:, 0]) / baseline_m
    alpha = np.concatenate([[0.0], np.cumsum(turn)])
    chord, middle = np.sinc(turn / (2.0 * np.pi)), alpha[:-1] + 0.5 * turn
    x, y = chord * steps[:, 0], chord * 0.5 * (steps[:, 1] + steps[:, 3])
    c, s = np.cos(middle), np.sin(middle)
    way = np.stack([c * x + s * y, c * y - s * x], axis=-1)
    return np.column_stack([np.concatenate([np.zeros((1, 2)), np.cumsum(way, axis=0)]), alpha])


@leaf
def wrap(angle):  # type: ignore[no-untyped-def]
    """Angle [rad] in [-pi, pi), as the paper measures headings (figure 11)."""
    rest = angle - 2.0 * math.pi * math.floor((angle + math.pi) / (2.0 * math.pi))
    return -math.pi if rest >= math.pi else rest


@leaf
def heading(x_difference, y_difference):  # type: ignore[no-untyped-def]
    """Eq. 7 in its four branches: clockwise from +Y [rad], NaN for a line without length."""
    if x_difference > 0.0:
        return 0.5 * math.pi - math.atan(y_difference / x_difference)
    if x_difference < 0.0:
        return -0.5 * math.pi - math.atan(y_difference / x_difference)
    if y_difference > 0.0:
        return 0.0
    return -math.pi if y_difference < 0.0 else math.nan


@leaf
def start(state, baseline_m):  # type: ignore[no-untyped-def]
    """Both mice on the y axis, mouse 1 in the origin."""
    for i in range(STATE):
        state[i] = 0.0
    state[SECOND + 1] = baseline_m


@leaf
def step(state, rule, x1, y1, x2, y2):  # type: ignore[no-untyped-def]
    """One sample of counts [m] by rule PRINTED or CORRECTED."""
    alpha = state[ALPHA]
    for m in range(2):
        x, y = (x1, y1) if m == 0 else (x2, y2)
        at = FIRST if m == 0 else SECOND
        if rule == PRINTED and x1 == 0.0:
            # printed: x stays, y is the x of before and y_m
            state[at + 1] = state[at] + y
            continue
        side = x1 if rule == PRINTED else x
        h = math.sqrt(x * x + y * y)
        # the printed rule does not say what y / 0 is for mouse 2 alone: 90 degrees, whatever the sign of y
        slope = 0.5 * math.pi if y > 0.0 or rule == PRINTED else -0.5 * math.pi
        if x != 0.0:
            slope = math.atan(y / x)
        sign = -1.0 if side < 0.0 else 1.0
        state[at] += sign * h * math.cos(slope - alpha)
        state[at + 1] += sign * h * math.sin(slope - alpha)
    state[ALPHA] = heading(state[SECOND] - state[FIRST], state[SECOND + 1] - state[FIRST + 1])


def _run(increments: ArrayLike, baseline_m: float, rule: int) -> Array:
    steps = _checked(increments, baseline_m)
    poses = np.zeros((len(steps) + 1, 3))
    _integrate(steps, baseline_m, rule, poses)
    return poses


@njit(cache=True, error_model="numpy")
def _integrate(steps: Array, baseline_m: float, rule: int, poses: Array) -> None:
    state = np.empty(STATE)
    start(state, baseline_m)
    for k in range(len(steps)):
        step(state, rule, steps[k, 0], steps[k, 1], steps[k, 2], steps[k, 3])
        poses[k + 1, 0], poses[k + 1, 1], poses[k + 1, 2] = state[FIRST], state[FIRST + 1], state[ALPHA]


def _checked(increments: ArrayLike, baseline_m: float) -> Array:
    steps = np.ascontiguousarray(increments, dtype=np.float64)
    if steps.ndim != 2 or steps.shape[1] != 4:
        raise InputError(f"increments of two mice have the shape {steps.shape}, expected (N, 4): x_1, y_1, x_2, y_2")
    if not (math.isfinite(baseline_m) and baseline_m > 0.0):
        raise InputError(f"the distance of the mice is {baseline_m} m, it must be above 0")
    return steps
