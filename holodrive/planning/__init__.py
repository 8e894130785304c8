"""Where to go becomes a reference: paths, speed profiles, trajectories."""

from holodrive.planning.paths import PATHS, Path, circle, lemniscate, line
from holodrive.planning.profile import Profile, trapezoid
from holodrive.planning.trajectories import follow, from_recipe, move

__all__ = ["PATHS", "Path", "Profile", "circle", "follow", "from_recipe", "lemniscate", "line", "move", "trapezoid"]
