"""Places written as x and y or as distance and bearing."""

import math

from holodrive.robots.form import At, Mount


def xy(place: At | Mount) -> tuple[float, float]:
    """Cartesian coordinates [m]; the origin when nothing is written."""
    if place.distance is not None and place.bearing is not None:
        return place.distance * math.cos(place.bearing), place.distance * math.sin(place.bearing)
    return place.x or 0.0, place.y or 0.0
