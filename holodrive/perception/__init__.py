"""Scan to sectors, de-skewed points, clusters: what a lidar says about the room, in the robot's own frame.

The plain functions here and the controllers' kernels share their code: each step is a leaf kernel with a plain face.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from holodrive.perception.clustering import Cluster, clusters
    from holodrive.perception.scan_points import points
    from holodrive.perception.sector_ranges import Sectors, sectors

# Numba and all that needs it is imported when it is first asked for
_WHERE = {
    "Cluster": "holodrive.perception.clustering",
    "Sectors": "holodrive.perception.sector_ranges",
    "clusters": "holodrive.perception.clustering",
    "points": "holodrive.perception.scan_points",
    "sectors": "holodrive.perception.sector_ranges",
}


def __getattr__(name: str) -> Any:
    if name not in _WHERE:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    value = getattr(import_module(_WHERE[name]), name)
    globals()[name] = value
    return value


__all__ = ["Cluster", "Sectors", "clusters", "points", "sectors"]
