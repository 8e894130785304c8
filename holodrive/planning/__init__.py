"""Where to go becomes a reference: paths, speed profiles, trajectories; and ways past what stands, by planners."""

from collections.abc import Callable

from holodrive.errors import UnknownName
from holodrive.planning.bee_colony import bee_colony
from holodrive.planning.deviation import distance_to_path
from holodrive.planning.paths import PATHS, Path, circle, lemniscate, line
from holodrive.planning.plan import Plan, through
from holodrive.planning.profile import Profile, trapezoid
from holodrive.planning.route import Route
from holodrive.planning.trajectories import follow, from_recipe, lap_speed, move
from holodrive.planning.visibility import visibility

# name -> function of (world, footprint_m, *, start, goal, margin_m, ...)
PLANNERS: dict[str, Callable[..., Plan]] = {"bee_colony": bee_colony, "visibility": visibility}


def planner(name: str) -> Callable[..., Plan]:
    """The planner of that name.

    Raises:
        UnknownName: no such planner.
    """
    if name not in PLANNERS:
        raise UnknownName("planner", name, PLANNERS)
    return PLANNERS[name]


__all__ = [
    "PATHS",
    "PLANNERS",
    "Path",
    "Plan",
    "Profile",
    "Route",
    "bee_colony",
    "circle",
    "distance_to_path",
    "follow",
    "from_recipe",
    "lap_speed",
    "lemniscate",
    "line",
    "move",
    "planner",
    "through",
    "trapezoid",
    "visibility",
]
