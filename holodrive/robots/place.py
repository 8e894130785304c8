"""Places written as x and y or as distance and bearing."""

import math

from holodrive.robots.form import At, Mount


def xy(place: At | Mount) -> tuple[float, float]:
    """Cartesian coordinates [m]; the origin when nothing is written."""
    if place.distance is not None and place.bearing is not None:
        return place.distance * math.cos(place.bearing), place.distance * math.sin(place.bearing)
    return 0.0 if place.x is None else place.x, 0.0 if place.y is None else place.y
