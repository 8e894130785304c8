"""References as tables: where the robot shall be, for the ordinary loop and for compiled roll-outs alike.

A table is (K, 10) float64: time [s], pose (x, y, theta) in the world [m, m, rad, theta not wrapped],
its time derivative (3) and second derivative (3), world axes. One kernel, `reference_step`, reads all kinds.
"""

from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numba import njit
from numpy.typing import ArrayLike

from holodrive.errors import InputError
from holodrive.types import Array, Pose, Reference, Twist

FIXED, WAYPOINTS, TRAJECTORY = 0, 1, 2  # kinds
MEMORY_SIZE = 2  # [current row, unused]
OUT_SIZE = 10  # pose (3), twist (3), accel (3), last: as layout.REF_POSE .. layout.REF_LAST


@dataclass(frozen=True)
class Table:
    """A reference as the kernel reads it. `recipe` is what it takes to make it again (JSON-able)."""

    kind: int
    rows: Array
    recipe: dict[str, Any] = field(default_factory=dict)

    @property
    def duration_s(self) -> float:
        """Time of the last row; 0 for a goal or waypoints, which have no clock."""
        return float(self.rows[-1, 0]) if self.kind == TRAJECTORY else 0.0


def fixed_goal(pose: ArrayLike) -> Table:
    """One pose (x, y, theta) to go to and stay at."""
    rows = np.zeros((1, 10))
    rows[0, 1:4] = _poses(pose, "a goal")[0]
    return Table(FIXED, rows, {"kind": "goal", "pose": rows[0, 1:4].tolist()})


def waypoints(poses: ArrayLike, tolerance_m: float = 0.05) -> Table:
    """Poses (K, 3) to pass one after another; the next becomes the reference within `tolerance_m` of the present.

    The last one is a goal to stop at. Column 0 of the table holds the tolerance instead of a time.
    """
    array = _poses(poses, "a way point")
    if not tolerance_m > 0.0:
        raise InputError(f"the way points' tolerance is {tolerance_m} m; it must be above 0")
    rows = np.zeros((len(array), 10))
    rows[:, 0], rows[:, 1:4] = tolerance_m, array
    return Table(WAYPOINTS, rows, {"kind": "waypoints", "poses": array.tolist(), "tolerance_m": tolerance_m})


def trajectory(
    time: ArrayLike, poses: ArrayLike, twists: ArrayLike, accels: ArrayLike, recipe: dict[str, Any] | None = None
) -> Table:
    """Poses (K, 3) at times (K,) [s] with first and second time derivatives (K, 3), world axes.

    Between rows the pose follows the cubic that fits pose and derivative at both ends.
    """
    rows = np.column_stack(
        [np.asarray(time, float), _poses(poses, "a trajectory"), _poses(twists, "a twist"), _poses(accels, "an accel")]
    )
    steps = np.diff(rows[:, 0])
    if not np.all(steps > 0.0):
        k = int(np.argmin(steps > 0.0))
        raise InputError(f"trajectory times must increase; row {k + 1} is at {rows[k + 1, 0]} s after {rows[k, 0]} s")
    return Table(TRAJECTORY, rows, recipe or {"kind": "table", "rows": rows.tolist()})


def from_recipe(recipe: dict[str, Any]) -> Table:
    """The table that a recipe of this module describes (planning has more kinds)."""
    match recipe.get("kind"):
        case "goal":
            return fixed_goal(recipe["pose"])
        case "waypoints":
            return waypoints(recipe["poses"], recipe["tolerance_m"])
        case "table":
            rows = np.asarray(recipe["rows"], dtype=np.float64)
            return trajectory(rows[:, 0], rows[:, 1:4], rows[:, 4:7], rows[:, 7:10])
    raise InputError(f"reference kind {recipe.get('kind')!r} is not known; allowed: goal, waypoints, table")


class ReferenceFollower:
    """A table as an `interfaces.ReferenceSource`."""

    def __init__(self, table: Table) -> None:
        self.table = table
        self._memory = np.zeros(MEMORY_SIZE)
        self._out = np.zeros(OUT_SIZE)

    def reset(self) -> None:
        """Start from the first row."""
        self._memory[:] = 0.0

    def step(self, time: float, pose: Pose) -> Reference:
        """The reference at `time` [s] since start for a robot at `pose`."""
        reference_step(self.table.rows, self.table.kind, self._memory, time, pose[0], pose[1], self._out)
        values = self._out.tolist()
        return Reference(Pose(*values[:3]), Twist(*values[3:6]), Twist(*values[6:9]), values[9] != 0.0)


@njit(cache=True)
def reference_step(rows, kind, memory, time, x, y, out):  # type: ignore[no-untyped-def]
    """Write the reference at `time` [s] for a robot at (x, y) [m] into `out` (10,)."""
    count = rows.shape[0]
    row = int(memory[0])
    if kind == TRAJECTORY:
        if time >= rows[count - 1, 0] or count == 1:
            _rest(rows, count - 1, out)
            out[9] = 1.0
            return
        while row > 0 and rows[row, 0] > time:
            row -= 1
        while row < count - 2 and rows[row + 1, 0] <= time:
            row += 1
        memory[0] = row
        _between(rows, row, max(time, rows[0, 0]), out)
        out[9] = 0.0
        return
    if kind == WAYPOINTS:
        while row < count - 1 and (rows[row, 1] - x) ** 2 + (rows[row, 2] - y) ** 2 <= rows[row, 0] ** 2:
            row += 1
        memory[0] = row
    _rest(rows, row, out)
    out[9] = 1.0 if row == count - 1 else 0.0


@njit(cache=True)
def _rest(rows, row, out):  # type: ignore[no-untyped-def]
    for i in range(3):
        out[i] = rows[row, 1 + i]
        out[3 + i] = 0.0
        out[6 + i] = 0.0


@njit(cache=True)
def _between(rows, row, time, out):  # type: ignore[no-untyped-def]
    h = rows[row + 1, 0] - rows[row, 0]
    u = (time - rows[row, 0]) / h
    # cubic Hermite: value and slope fit at both ends, error O(h^4); its own derivative is the twist
    w, dw = u * u * (3.0 - 2.0 * u), 6.0 * u * (1.0 - u) / h
    a, b = h * u * (1.0 - u) ** 2, h * u * u * (u - 1.0)
    da, db = (1.0 - u) * (1.0 - 3.0 * u), u * (3.0 * u - 2.0)
    for i in range(3):
        step = rows[row + 1, 1 + i] - rows[row, 1 + i]
        v0, v1 = rows[row, 4 + i], rows[row + 1, 4 + i]
        out[i] = rows[row, 1 + i] + w * step + a * v0 + b * v1
        out[3 + i] = dw * step + da * v0 + db * v1
        out[6 + i] = (1.0 - u) * rows[row, 7 + i] + u * rows[row + 1, 7 + i]


def _poses(value: ArrayLike, what: str) -> Array:
    array = np.atleast_2d(np.asarray(value, dtype=np.float64))
    if array.ndim != 2 or array.shape[1] != 3 or not len(array):
        raise InputError(f"{what} is (x, y, theta); found an array of shape {np.shape(value)}")
    if not np.all(np.isfinite(array)):
        raise InputError(f"{what} must be finite; found {array[~np.all(np.isfinite(array), axis=1)][0].tolist()}")
    return array
