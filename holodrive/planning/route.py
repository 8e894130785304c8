"""A route: straight lines and arcs one after another, and how a robot runs along them.

A holonomic robot takes an arc at v^2 / r of sideways acceleration and a corner by stopping in it, so the speed along
a route has an exact answer: on each piece a trapezoid between the speeds that its ends allow.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike

from holodrive import geometry, references
from holodrive.errors import InputError
from holodrive.planning.profile import MOST_ROWS, Profile
from holodrive.types import Array

X, Y, HEADING, LENGTH, CURVATURE = range(5)  # columns of the pieces
CORNER_RAD = 1e-6  # a smaller change of direction between two pieces is none
TURN_RAD = math.radians(10.0)  # a larger one counts as a turn
_SHARE = math.sqrt(0.5)  # of the acceleration for each of along and across: together they make the whole
_LEAST_FILLET_M = 1e-4  # of the leg on each side; a smaller rounding is a corner
_FILLET_TRIES = 64
_FILLET_STEPS = 24  # halvings after them
_FILLET_POINTS = 257


@dataclass(frozen=True)
class Route:
    """Lines and arcs in the plane.

    Attributes:
        pieces: (P, 5) where each begins x, y [m], in which direction [rad], its length [m], its curvature [1/m]
            (0 straight, above 0 to the left). Each begins where the one before ends.
    """

    pieces: Array

    @cached_property
    def ends(self) -> Array:
        """(P + 1,) distance from the start at which the pieces begin and the last one ends [m]."""
        return np.concatenate([[0.0], np.cumsum(self.pieces[:, LENGTH])])

    @property
    def length_m(self) -> float:
        """From start to end."""
        return float(self.ends[-1])

    def at(self, distance: ArrayLike) -> tuple[Array, Array, Array]:
        """Position (..., 2) [m], direction (...) [rad] and curvature (...) [1/m] at distances (...) [m]."""
        distance = np.asarray(distance, dtype=np.float64)
        k = np.clip(np.searchsorted(self.ends, distance, side="right") - 1, 0, len(self.pieces) - 1)
        rows, s = self.pieces[k], distance - self.ends[k]
        half = 0.5 * rows[..., CURVATURE] * s
        chord = s * np.sinc(half / math.pi)  # np.sinc(x) = sin(pi x) / (pi x)
        middle = rows[..., HEADING] + half
        step = chord[..., None] * np.stack([np.cos(middle), np.sin(middle)], axis=-1)
        return rows[..., :2] + step, middle + half, rows[..., CURVATURE]

    def points(self, step_m: float = 0.01) -> Array:
        """(K, 2) ends of all pieces and points on the arcs, at most `step_m` apart."""
        stops = [np.zeros(1)]
        for row, begin in zip(self.pieces, self.ends, strict=False):
            count = math.ceil(row[LENGTH] / step_m) if row[CURVATURE] != 0.0 else 1
            stops.append(begin + row[LENGTH] * np.arange(1, count + 1) / count)
        return self.at(np.concatenate(stops))[0]

    @cached_property
    def changes_rad(self) -> Array:
        """Every change of direction on the way [rad], left above 0: corners and arcs in their order."""
        sweep = self.pieces[:, LENGTH] * self.pieces[:, CURVATURE]
        corners = geometry.wrap(self.pieces[1:, HEADING] - self.pieces[:-1, HEADING] - sweep[:-1])
        both = np.zeros(2 * len(sweep) - 1)
        both[::2], both[1::2] = sweep, corners
        return both[np.abs(both) > CORNER_RAD]

    @property
    def turns(self) -> int:
        """Changes of direction above 10 deg."""
        return int(np.sum(np.abs(self.changes_rad) > TURN_RAD))

    def profile(self, speed_m_s: float, accel_m_s2: float, step_s: float = 0.01) -> Profile:
        """From rest to rest in the least time: at most `speed_m_s`, slower in arcs, stopping in corners.

        Along and across the route the acceleration is at most accel / sqrt(2) each, so at most `accel_m_s2` in all.
        """
        for name, value in (("speed", speed_m_s), ("acceleration", accel_m_s2), ("step", step_s)):
            if not (value > 0.0 and math.isfinite(value)):
                raise InputError(f"a run along a route needs a {name} above 0; found {value}")
        accel = _SHARE * accel_m_s2
        top = np.minimum(speed_m_s, np.sqrt(accel / np.maximum(np.abs(self.pieces[:, CURVATURE]), 1e-12)))
        duration, begin, change = _phases(self.pieces[:, LENGTH], top, self._node_speeds(top, accel), accel)
        return _sampled(duration, begin, change, self.length_m, step_s)

    def _node_speeds(self, top: Array, accel: float) -> Array:
        """Speed at each of `ends`: 0 at both ends and in corners, else what braking and speeding up allow."""
        sweep = self.pieces[:, LENGTH] * self.pieces[:, CURVATURE]
        corner = np.abs(geometry.wrap(self.pieces[1:, HEADING] - self.pieces[:-1, HEADING] - sweep[:-1])) > CORNER_RAD
        speed = np.concatenate([[0.0], np.where(corner, 0.0, np.minimum(top[:-1], top[1:])), [0.0]])
        reach = 2.0 * accel * self.pieces[:, LENGTH]
        for k in range(len(reach)):
            speed[k + 1] = min(speed[k + 1], math.sqrt(speed[k] ** 2 + reach[k]))
        for k in range(len(reach) - 1, -1, -1):
            speed[k] = min(speed[k], math.sqrt(speed[k + 1] ** 2 + reach[k]))
        return speed


def polyline(points: ArrayLike) -> Route:
    """Straight legs through points (K, 2) [m], with corners; points that repeat the one before are left out.

    Raises:
        InputError: fewer than two different points, or one that is not finite.
    """
    array = np.asarray(points, dtype=np.float64)
    if array.ndim != 2 or array.shape[1] != 2 or not np.all(np.isfinite(array)):
        raise InputError(f"a route goes through finite points (x, y); found {array.tolist()}")
    steps = np.diff(array, axis=0)
    length = np.hypot(steps[:, 0], steps[:, 1])
    moves = length > 1e-12
    if not np.any(moves):
        raise InputError(f"a route needs two different points; found {array.tolist()}")
    heading = np.arctan2(steps[:, 1], steps[:, 0])
    return Route(np.column_stack([array[:-1], heading, length, np.zeros(len(length))])[moves])


def rounded(route: Route, free: Callable[[Array], bool]) -> Route:
    """A polyline with its corners rounded by the largest arcs that `free` allows, each at most half a leg long.

    Args:
        route: straight pieces only.
        free: whether a robot may be at all of the points (k, 2) of an arc.
    """
    pieces = route.pieces
    change = geometry.wrap(np.diff(pieces[:, HEADING]))
    most = 0.5 * pieces[:, LENGTH]
    most[[0, -1]] = pieces[[0, -1], LENGTH]  # no other corner wants a share of these
    cut = np.zeros(len(pieces) + 1)  # of both legs, at each corner
    arcs: list[Array | None] = [None] * (len(pieces) + 1)
    for k, turn in enumerate(change, 1):
        if abs(turn) > CORNER_RAD and abs(turn) < math.pi - 1e-3:
            cut[k], arcs[k] = _fillet(pieces[k], turn, min(most[k - 1], most[k]), pieces[k - 1, HEADING], free)
    out = []
    for k, row in enumerate(pieces):
        if arcs[k] is not None:
            out.append(arcs[k])
        length = row[LENGTH] - cut[k] - cut[k + 1]
        if length > 1e-12:
            direction = np.array((math.cos(row[HEADING]), math.sin(row[HEADING])))
            out.append(np.array([*(row[:2] + cut[k] * direction), row[HEADING], length, 0.0]))
    return Route(np.array(out))


def run(
    route: Route,
    speed_m_s: float,
    accel_m_s2: float,
    *,
    heading_rad: float = 0.0,
    turn_rad: float = 0.0,
    step_s: float = 0.01,
) -> references.Table:
    """A route as a trajectory that a tracker can follow; its recipe makes it again (`planning.from_recipe`).

    Args:
        route: to run along.
        speed_m_s, accel_m_s2: as `Route.profile`.
        heading_rad: of the robot at the start. turn_rad: what it turns evenly on the way.
        step_s: between rows of the table.
    """
    profile = route.profile(speed_m_s, accel_m_s2, step_s)
    position, direction, curvature = route.at(profile.distance)
    tangent = np.stack([np.cos(direction), np.sin(direction)], axis=-1)
    normal = np.stack([-tangent[:, 1], tangent[:, 0]], axis=-1)
    rows = np.zeros((len(direction), 3, 3))  # (K, derivative, component)
    rows[:, 0, :2], rows[:, 1, :2] = position, profile.speed[:, None] * tangent
    rows[:, 2, :2] = profile.accel[:, None] * tangent + (curvature * profile.speed**2)[:, None] * normal
    share = turn_rad / route.length_m
    rows[:, 0, 2] = heading_rad + share * profile.distance
    rows[:, 1, 2], rows[:, 2, 2] = share * profile.speed, share * profile.accel
    recipe = {
        "kind": "route",
        "pieces": route.pieces.tolist(),
        "speed_m_s": float(speed_m_s),
        "accel_m_s2": float(accel_m_s2),
        "heading_rad": float(heading_rad),
        "turn_rad": float(turn_rad),
        "step_s": float(step_s),
    }
    return references.trajectory(profile.time, rows[:, 0], rows[:, 1], rows[:, 2], recipe)


def _fillet(
    leg: Array, turn: float, most_m: float, before: float, free: Callable[[Array], bool]
) -> tuple[float, Array | None]:
    """The largest free arc around the corner at which `leg` begins: what it cuts of both legs [m], and its piece."""

    def piece(cut: float) -> Array:
        start = leg[:2] - cut * np.array((math.cos(before), math.sin(before)))
        radius = cut / math.tan(0.5 * abs(turn))
        return np.array([*start, before, radius * abs(turn), math.copysign(1.0 / radius, turn)])

    def allowed(cut: float) -> bool:
        arc = Route(piece(cut)[None])
        return free(arc.at(np.linspace(0.0, arc.length_m, _FILLET_POINTS))[0])

    if most_m < _LEAST_FILLET_M:
        return 0.0, None
    # outwards from the corner, so that no obstacle between it and the arc is jumped over
    low, high = 0.0, most_m
    for cut in np.linspace(0.0, most_m, _FILLET_TRIES + 1)[1:].tolist():
        if not allowed(cut):
            high = cut
            break
        low = cut
    for _ in range(_FILLET_STEPS if low < high else 0):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if allowed(middle) else (low, middle)
    return (low, piece(low)) if low >= _LEAST_FILLET_M else (0.0, None)


def _phases(length: Array, top: Array, node: Array, accel: float) -> tuple[Array, Array, Array]:
    """Speeding up, cruising and braking of every piece: duration [s], speed at its begin [m/s], change [m/s^2]."""
    first, last = node[:-1], node[1:]
    peak = np.maximum(np.minimum(top, np.sqrt(0.5 * (2.0 * accel * length + first**2 + last**2))), 1e-12)
    up, down = np.maximum(peak - first, 0.0) / accel, np.maximum(peak - last, 0.0) / accel
    rest = length - 0.5 * (first + peak) * up - 0.5 * (last + peak) * down
    duration = np.stack([up, np.maximum(rest, 0.0) / peak, down], axis=1)
    begin = np.stack([first, peak, peak], axis=1)
    change = np.broadcast_to([accel, 0.0, -accel], duration.shape)
    used = duration > 1e-12
    return duration[used], begin[used], change[used]


def _sampled(duration: Array, begin: Array, change: Array, length_m: float, step_s: float) -> Profile:
    """Phases as rows at most `step_s` apart; every end of a phase is a row, so that no step hides a jump."""
    ends = np.concatenate([[0.0], np.cumsum(duration)])
    total = float(ends[-1])
    if not total / step_s <= MOST_ROWS:
        raise InputError(f"a run of {length_m:g} m takes {total:g} s; at most {MOST_ROWS * step_s:g} s are planned")
    time = np.unique(np.concatenate([np.linspace(0.0, total, max(2, math.ceil(total / step_s) + 1)), ends]))
    time = time[np.concatenate([[True], np.diff(time) > 1e-9])]
    time[-1] = total
    k = np.clip(np.searchsorted(ends, time, side="right") - 1, 0, len(duration) - 1)
    travelled = np.concatenate([[0.0], np.cumsum(begin * duration + 0.5 * change * duration**2)])
    t = time - ends[k]
    speed = np.maximum(begin[k] + change[k] * t, 0.0)
    speed[-1] = 0.0
    return Profile(time, np.minimum(travelled[k] + begin[k] * t + 0.5 * change[k] * t * t, length_m), speed, change[k])
