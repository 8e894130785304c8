"""What a planner is asked: from where to where, past what, how far from it."""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from holodrive.errors import InputError
from holodrive.planning.free_space import TOUCH_M, point_gaps, standing
from holodrive.types import Array
from holodrive.worlds.spec import World


@dataclass(frozen=True)
class Task:
    """A round robot from a place to a place in a world; what moves in it is not seen.

    Attributes:
        world: where; `obstacles` is what stands in it (`holodrive.obstacles`).
        start, goal: (2,) [m].
        footprint_m: radius of the robot. margin_m: kept free around it.
        reach_m: how near the goal is there: 0, or the goal's tolerance where the goal itself cannot be reached.
        start_heading_rad, goal_heading_rad: of the robot; the goal's is the start's where it does not matter.
    """

    world: World
    obstacles: Array
    start: Array
    goal: Array
    footprint_m: float
    margin_m: float
    reach_m: float
    start_heading_rad: float
    goal_heading_rad: float

    @property
    def need_m(self) -> float:
        """How far the robot's centre keeps from every obstacle [m]."""
        return self.footprint_m + self.margin_m

    @property
    def bounds(self) -> tuple[Array, Array]:
        """Lower left and upper right corner (2,) [m] of where the robot's centre may be: the arena, or room around all.

        On open floor no shortest path leaves the hull of start, goal and inflated obstacles.
        """
        world = self.world
        if world.size is not None and world.walls:
            low = np.asarray(world.corner) + self.need_m
            return low, np.asarray(world.corner) + np.asarray(world.size) - self.need_m
        corners = [self.start, self.goal]
        corners += [np.array((c.x, c.y)) + side * c.radius for c in world.circles for side in (-1.0, 1.0)]
        corners += [np.array(end) for s in world.segments for end in ((s.x1, s.y1), (s.x2, s.y2))]
        for box in world.boxes:
            half = 0.5 * math.hypot(box.length, box.width)
            corners += [np.array((box.x, box.y)) + side * half for side in (-1.0, 1.0)]
        room = 2.0 * self.need_m
        return np.min(corners, axis=0) - room, np.max(corners, axis=0) + room

    def no_way(self) -> InputError:
        """The error of a planner that found none."""
        margin = f" and a margin of {self.margin_m:g} m; give a smaller one, or another goal" if self.margin_m else ""
        return InputError(
            f"{_where(self.world)} has no way from {_text(self.start)} to {_text(self.goal)} m "
            f"for a footprint radius of {self.footprint_m:g} m{margin}"
        )


def task(
    world: World,
    footprint_m: float,
    *,
    start: ArrayLike | None = None,
    goal: ArrayLike | None = None,
    margin_m: float = 0.0,
) -> Task:
    """Check what is asked.

    Args:
        world: where; its movers are not seen.
        footprint_m: radius of the robot.
        start, goal: (x, y) or (x, y, heading); the world's own when None.
        margin_m: kept free around the footprint.

    Raises:
        InputError: no goal, numbers that cannot be, or a start or goal inside an obstacle.
    """
    if not (footprint_m > 0.0 and math.isfinite(footprint_m)):
        raise InputError(f"the footprint radius of a plan is {footprint_m} m; it must be above 0")
    if not (margin_m >= 0.0 and math.isfinite(margin_m)):
        raise InputError(f"the margin of a plan is {margin_m} m; it must be 0 or more")
    if goal is None and world.goal is None:
        raise InputError(f"{_where(world)} has no goal; give one: goal=(x, y) or (x, y, heading)")
    first = _pose(world.start if start is None else start, "start", world.start.theta)
    if goal is not None:
        last, tolerance = _pose(goal, "goal", first[2]), 0.0
    else:
        assert world.goal is not None
        pose = world.goal.pose
        last = np.array((pose.x, pose.y, pose.theta if world.goal.heading_matters else first[2]))
        tolerance = world.goal.tolerance_m
    obstacles = standing(world)
    need = footprint_m + margin_m - TOUCH_M
    at_start, at_goal = point_gaps(obstacles, np.stack([first[:2], last[:2]])).tolist()
    if at_start < need:
        raise InputError(_too_near("start", first, at_start, footprint_m, margin_m))
    if at_goal < need and tolerance == 0.0:
        raise InputError(_too_near("goal", last, at_goal, footprint_m, margin_m))
    reach = tolerance if at_goal < need else 0.0
    if math.dist(first[:2], last[:2]) <= max(reach, TOUCH_M):
        raise InputError(f"a plan from {_text(first)} to {_text(last)} m has nowhere to go: its start is at its goal")
    heading = (float(first[2]), float(last[2]))
    return Task(world, obstacles, first[:2], last[:2], float(footprint_m), float(margin_m), reach, *heading)


def _pose(value: ArrayLike, what: str, heading: float) -> Array:
    array = np.asarray(value, dtype=np.float64)
    if array.shape not in ((2,), (3,)) or not np.all(np.isfinite(array)):
        raise InputError(f"the {what} of a plan is (x, y) or (x, y, heading), finite; found {array.tolist()}")
    return np.array([*array[:2], array[2] if len(array) == 3 else heading])


def _too_near(what: str, at: Array, gap: float, footprint_m: float, margin_m: float) -> str:
    inside = gap < footprint_m
    place = f"is inside an obstacle by {-gap:.3g} m" if gap < 0.0 else f"is {gap:.3g} m from an obstacle or wall"
    advice = f"give another {what}" if inside else "give a smaller margin"
    margin = f" and margin {margin_m:g} m" if margin_m else ""
    return f"the {what} {_text(at)} m {place}, too near for footprint radius {footprint_m:g} m{margin}; {advice}"


def _where(world: World) -> str:
    return f"world {world.name!r}"


def _text(at: Array) -> str:
    return f"({at[0]:g}, {at[1]:g})"
