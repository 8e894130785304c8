"""Trajectories: a path, a speed profile and a heading policy become a reference table."""

import math
from typing import Any, Literal, get_args

import numpy as np
from numpy.typing import ArrayLike

from holodrive import references
from holodrive.errors import InputError, UnknownName, did_you_mean
from holodrive.planning.paths import PATHS, Path
from holodrive.planning.profile import trapezoid
from holodrive.planning.route import Route, run
from holodrive.types import Array

Heading = Literal["fixed", "tangent"]
_SAMPLES = 4001  # of u: the arc length's error falls with the fourth power


def follow(
    path: Path,
    speed_m_s: float,
    accel_m_s2: float = math.inf,
    *,
    heading: Heading = "fixed",
    heading_rad: float = 0.0,
    laps: int = 1,
    step_s: float = 0.01,
) -> references.Table:
    """Run along a path from rest to rest with a trapezoid of speed.

    Args:
        path: to follow; `laps` times when it is closed.
        speed_m_s: while cruising.
        accel_m_s2: while speeding up and slowing down; infinite takes half a second for it.
        heading: "fixed" keeps `heading_rad`, "tangent" looks along the path, turned by `heading_rad`.
        laps: how often around.
        step_s: between rows of the table.
    """
    if heading not in get_args(Heading):
        words = get_args(Heading)
        raise InputError(f"heading is {heading!r}; allowed: {', '.join(words)}{did_you_mean(str(heading), words)}")
    if laps != int(laps) or laps < 1 or (laps > 1 and not path.closed):
        raise InputError(f"laps is {laps}; an open path takes 1, a closed one a whole number from 1 on")
    if not accel_m_s2 < math.inf:
        accel_m_s2 = 2.0 * speed_m_s
    u, length = _arc_length(path)
    profile = trapezoid(laps * length[-1], speed_m_s, accel_m_s2, step_s)
    lap = np.minimum(np.floor(profile.distance / length[-1]), laps - 1)
    at = _u_of_distance(path, u, length, profile.distance - lap * length[-1])
    position, velocity, accel, turn = _kinematics(path, at, profile.speed, profile.accel)
    rows = np.zeros((len(at), 3, 3))  # (K, derivative, component)
    rows[:, 0, :2], rows[:, 1, :2], rows[:, 2, :2] = position, velocity, accel
    if heading == "tangent":
        direction = path.curve(at)[1]
        rows[:, 0, 2] = np.unwrap(np.arctan2(direction[:, 1], direction[:, 0])) + heading_rad
        rows[:, 1, 2] = turn
        rows[:, 2, 2] = np.gradient(turn, profile.time)
    else:
        rows[:, 0, 2] = heading_rad
    recipe = {
        "kind": "path",
        **path.recipe,
        "speed_m_s": speed_m_s,
        "accel_m_s2": accel_m_s2,
        "heading": heading,
        "heading_rad": heading_rad,
        "laps": laps,
        "step_s": step_s,
    }
    return references.trajectory(profile.time, rows[:, 0], rows[:, 1], rows[:, 2], recipe)


def lap_speed(path: Path, duration_s: float, accel_m_s2: float = math.inf, *, laps: int = 1) -> float:
    """The cruising speed [m/s] with which `follow` takes `duration_s` from rest to rest.

    With length L and acceleration a, T = L / v + v / a; an infinite acceleration stands for half a second of speeding
    up, as in `follow`.

    Raises:
        InputError: a time that is too short for the acceleration.
    """
    length = laps * float(_arc_length(path)[1][-1])
    if not (duration_s > 0.5 if accel_m_s2 == math.inf else duration_s >= 2.0 * math.sqrt(length / accel_m_s2)):
        raise InputError(f"{length:g} m take more than {duration_s:g} s at an acceleration of {accel_m_s2:g} m/s^2")
    if accel_m_s2 == math.inf:
        return length / (duration_s - 0.5)
    half = 0.5 * accel_m_s2 * duration_s
    return length * accel_m_s2 / (half + math.sqrt(max(0.0, half * half - length * accel_m_s2)))


def move(start: ArrayLike, end: ArrayLike, duration_s: float, step_s: float = 0.01) -> references.Table:
    """From pose to pose (x, y, theta) along a straight line and an even turn, with least jerk.

    s(u) = 10 u^3 - 15 u^4 + 6 u^5: rest at both ends, in velocity and acceleration.
    """
    a, b = np.asarray(start, float), np.asarray(end, float)
    if not (duration_s > 0.0 and math.isfinite(duration_s)):
        raise InputError(f"a move takes a time above 0; found {duration_s} s")
    time = np.linspace(0.0, duration_s, max(2, math.ceil(duration_s / step_s) + 1))
    u = time / duration_s
    s = u**3 * (10.0 - 15.0 * u + 6.0 * u * u)
    ds = 30.0 * u * u * (1.0 - u) ** 2 / duration_s
    dds = 60.0 * u * (1.0 - u) * (1.0 - 2.0 * u) / duration_s**2
    recipe = {"kind": "move", "start": a.tolist(), "end": b.tolist(), "duration_s": duration_s, "step_s": step_s}
    d = b - a
    return references.trajectory(time, a + s[:, None] * d, ds[:, None] * d, dds[:, None] * d, recipe)


def from_recipe(recipe: dict[str, Any]) -> references.Table:
    """The table that a recipe describes: of this module, or of `references`."""
    values = {key: value for key, value in recipe.items() if key != "kind"}
    match recipe.get("kind"):
        case "path":
            name = values.pop("path")
            if name not in PATHS:
                raise UnknownName("path", str(name), PATHS)
            policy = ("speed_m_s", "accel_m_s2", "heading", "heading_rad", "laps", "step_s")
            options = {key: values.pop(key) for key in policy if key in values}
            return follow(PATHS[name](**values), **options)
        case "move":
            return move(**values)
        case "route":
            return run(Route(np.asarray(values.pop("pieces"), dtype=np.float64)), **values)
    return references.from_recipe(recipe)


def _arc_length(path: Path) -> tuple[Array, Array]:
    """u (K,) and the length from the start to it (K,) [m], by Simpson's rule on each interval."""
    u = np.linspace(0.0, 1.0, _SAMPLES)
    middle = 0.5 * (u[1:] + u[:-1])
    ends, centre = _pace(path, u), _pace(path, middle)
    steps = np.diff(u) * (ends[:-1] + 4.0 * centre + ends[1:]) / 6.0
    return u, np.concatenate([[0.0], np.cumsum(steps)])


def _u_of_distance(path: Path, u: Array, length: Array, distance: Array) -> Array:
    """Invert the arc length: the cubic through the samples with the right slopes."""
    from scipy.interpolate import CubicHermiteSpline

    inverse = CubicHermiteSpline(length, u, 1.0 / _pace(path, u))
    return np.clip(np.asarray(inverse(distance), dtype=np.float64), 0.0, 1.0)


def _kinematics(path: Path, u: Array, speed: Array, accel: Array) -> tuple[Array, Array, Array, Array]:
    """Position, velocity, acceleration (K, 2) and turning rate of the tangent (K,)."""
    p, d, dd = path.curve(u)
    pace = np.linalg.norm(d, axis=1)
    tangent = d / pace[:, None]
    normal = np.stack([-tangent[:, 1], tangent[:, 0]], axis=-1)
    curvature = (d[:, 0] * dd[:, 1] - d[:, 1] * dd[:, 0]) / pace**3
    return (
        p,
        speed[:, None] * tangent,
        accel[:, None] * tangent + (curvature * speed**2)[:, None] * normal,
        curvature * speed,
    )


def _pace(path: Path, u: Array) -> Array:
    return np.asarray(np.linalg.norm(path.curve(u)[1], axis=1))
