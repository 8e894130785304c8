"""A plan: the way that a planner found, what it is worth, and the reference that follows it."""

import math
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike

from holodrive import geometry, references
from holodrive.errors import InputError
from holodrive.kinematics import Chassis
from holodrive.planning import route as routes
from holodrive.planning.free_space import TOUCH_M, leg_gaps, point_gaps, standing
from holodrive.planning.route import Route
from holodrive.planning.task import Task
from holodrive.robots.spec import Robot
from holodrive.types import Array
from holodrive.worlds.spec import World

SPEED_SHARE = 0.8  # of what the wheels can do in every direction: the rest is for the tracker's corrections
ACCEL_SHARE = 0.3  # of the robot's acceleration limit: with 0.6 a swerve base in simulated slip strays by decimetres


@dataclass(frozen=True)
class Plan:
    """A way for the centre of a round robot.

    Attributes:
        planner: name of the planner.
        route: as planned, corners and all.
        drive: what the reference follows: the same with its corners rounded inside the room that there is.
        footprint_m: radius of the robot. margin_m: what was kept free around it.
        clearance_m: least distance from the footprint to what stands, along `drive` (to a tenth of a millimetre);
            infinite on open floor.
        via: (n, 2) via points that were searched for, none where the planner knows no such thing.
        cost_history: (c,) best cost after each cycle of a search [m].
        heading_rad, turn_rad: heading at the start, and what it turns on the way.
        evaluations: how many candidates were judged.
    """

    planner: str
    route: Route
    drive: Route
    footprint_m: float
    margin_m: float = 0.0
    clearance_m: float = math.inf
    via: Array = field(default_factory=lambda: np.zeros((0, 2)))
    cost_history: Array = field(default_factory=lambda: np.zeros(0))
    heading_rad: float = 0.0
    turn_rad: float = 0.0
    evaluations: int = 0

    @property
    def length_m(self) -> float:
        """Of the planned route."""
        return self.route.length_m

    @property
    def points(self) -> Array:
        """(K, 2) corners and ends of the planned route [m], arcs as points at most 1 cm apart."""
        return self.route.points()

    @property
    def turns(self) -> int:
        """Changes of direction above 10 deg on the planned route."""
        return self.route.turns

    def reference(
        self,
        robot: Robot | float,
        accel_m_s2: float | None = None,
        *,
        heading_rad: float | None = None,
        turn_rad: float | None = None,
        step_s: float = 0.01,
    ) -> references.Table:
        """A trajectory along the plan: from rest to rest, slower in bends, inside what the robot can do.

        Args:
            robot: whose speed and acceleration to use, four fifths and three tenths of them; or a speed [m/s].
            accel_m_s2: instead of the robot's; two times the speed per second where nobody says.
            heading_rad: at the start; the plan's own when None.
            turn_rad: evenly on the way; the plan's own when None.
            step_s: between rows of the table.
        """
        speed, accel = pace(robot, accel_m_s2)
        return routes.run(
            self.drive,
            speed,
            accel,
            heading_rad=self.heading_rad if heading_rad is None else heading_rad,
            turn_rad=self.turn_rad if turn_rad is None else turn_rad,
            step_s=step_s,
        )

    def time_s(self, robot: Robot | float, accel_m_s2: float | None = None) -> float:
        """How long the reference takes."""
        return self.reference(robot, accel_m_s2).duration_s


def pace(robot: Robot | float, accel_m_s2: float | None = None) -> tuple[float, float]:
    """Speed [m/s] and acceleration [m/s^2] with which a reference leads a robot.

    Raises:
        InputError: a robot or number that gives no speed above 0.
    """
    if isinstance(robot, Robot):
        speed = SPEED_SHARE * min(robot.limits.speed_m_s, Chassis.of(robot).polytope.slowest[0])
        limit = ACCEL_SHARE * robot.limits.accel_m_s2
    else:
        speed, limit = float(robot), math.inf
    if not (speed > 0.0 and math.isfinite(speed)):
        raise InputError(f"a plan is followed with a speed above 0; found {speed} m/s")
    if accel_m_s2 is not None:
        return speed, accel_m_s2
    return speed, limit if math.isfinite(limit) else 2.0 * speed


def planned(
    planner: str,
    task: Task,
    route: Route,
    *,
    via: Array | None = None,
    cost_history: Array | None = None,
    evaluations: int = 0,
) -> Plan:
    """A planner's route as a plan: corners rounded inside the room that the task leaves."""

    def free(points: Array) -> bool:
        return bool(np.min(point_gaps(task.obstacles, points)) >= task.need_m - TOUCH_M)

    drive = route if np.any(route.pieces[:, routes.CURVATURE]) else routes.rounded(route, free)
    return Plan(
        planner,
        route,
        drive,
        task.footprint_m,
        task.margin_m,
        _gap(task.obstacles, drive) - task.footprint_m,
        np.zeros((0, 2)) if via is None else via,
        np.zeros(0) if cost_history is None else cost_history,
        task.start_heading_rad,
        float(geometry.wrap(task.goal_heading_rad - task.start_heading_rad)),
        evaluations,
    )


def through(points: ArrayLike, world: World | None = None, footprint_m: float = 0.0, heading_rad: float = 0.0) -> Plan:
    """A given polyline judged as a plan, whether it is free or not: its clearance is negative where it is not.

    Nothing is rounded; a robot stops in its corners.

    Args:
        points: (K, 2) from start to end [m], such as the via points that a paper prints.
        world: for the clearance; None has no obstacles.
        footprint_m: radius of the robot.
        heading_rad: of the robot, all the way.
    """
    route = routes.polyline(points)
    gap = _gap(standing(world), route) - footprint_m if world is not None else math.inf
    via = np.asarray(points, dtype=np.float64)[1:-1]
    return Plan("given", route, route, footprint_m, 0.0, gap, via, heading_rad=heading_rad)


def _gap(obstacles: Array, route: Route) -> float:
    """Least distance [m] to what stands: exact on straight pieces, at points 5 mm apart on arcs."""
    ends = np.concatenate([route.pieces[1:, :2], route.at(route.length_m)[0][None]])
    straight = route.pieces[:, routes.CURVATURE] == 0.0
    legs = np.concatenate([route.pieces[:, :2], ends], axis=1)[straight]
    gaps = np.concatenate([leg_gaps(obstacles, legs), point_gaps(obstacles, route.points(0.005))])
    return float(np.min(gaps))
