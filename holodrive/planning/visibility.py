"""The exact shortest path of a round robot among circles, boxes and walls: the visibility graph of tangents.

The robot's centre keeps out of the obstacles inflated by its radius: discs, and between discs the strips along
segments and boxes. A shortest path is a rubber band: straight pieces that touch discs, and arcs on them in between.
So the graph holds all common tangents of two discs (and from start and goal) that are free, and the free arcs
between their ends; Dijkstra finds the shortest (J.-C. Latombe, Robot Motion Planning, 1991, section 4.1, extended to
circles). No grid, no tolerance but rounding.
"""

import heapq
import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from holodrive import geometry
from holodrive import obstacles as ob
from holodrive.planning.free_space import TOUCH_M, leg_gaps, point_gaps
from holodrive.planning.plan import Plan, planned
from holodrive.planning.route import Route
from holodrive.planning.task import Task, task
from holodrive.types import Array
from holodrive.worlds.spec import World

Edge = tuple[int, float, "Array | None"]  # to node, length [m], piece of the route (None: no length)


def visibility(
    world: World,
    footprint_m: float,
    *,
    start: ArrayLike | None = None,
    goal: ArrayLike | None = None,
    margin_m: float = 0.0,
) -> Plan:
    """The shortest way, exact to rounding. Movers are not seen.

    Where the world's goal is not free it ends at the nearest place by way within the goal's tolerance.

    Args:
        world: where.
        footprint_m: radius of the robot.
        start, goal: (x, y) or (x, y, heading); the world's own when None.
        margin_m: kept free around the footprint.

    Raises:
        InputError: no goal, start or goal not free, or no way.
    """
    asked = task(world, footprint_m, start=start, goal=goal, margin_m=margin_m)
    graph = _Graph(asked)
    pieces = graph.shortest()
    if pieces is None:
        raise asked.no_way()
    return planned("visibility", asked, Route(pieces), evaluations=graph.judged)


@dataclass(frozen=True)
class _Discs:
    """Discs that a shortest path may touch: centres (D, 2), radii (D,), and the sides (k, 4) of the strips between."""

    centres: Array
    radii: Array
    sides: Array


def _discs(obstacles: Array, need: float) -> _Discs:
    """Circles grown by `need`, and discs of that radius at the ends of segments and the corners of boxes."""
    at, count = int(obstacles[ob.CIRCLES]), int(obstacles[ob.N_CIRCLES])
    circles = obstacles[at : at + ob.CIRCLE * count].reshape(-1, ob.CIRCLE)
    at, count = int(obstacles[ob.EDGES]), int(obstacles[ob.N_EDGES])
    edges = obstacles[at : at + ob.EDGE * count].reshape(-1, ob.EDGE)
    corners = np.unique(edges.reshape(-1, 2), axis=0)
    along = edges[:, 2:] - edges[:, :2]
    length = np.hypot(along[:, 0], along[:, 1])
    normal = np.stack([-along[:, 1], along[:, 0]], axis=1) / np.where(length > 0.0, length, 1.0)[:, None]
    shift = need * np.concatenate([normal, normal], axis=1)
    return _Discs(
        np.concatenate([circles[:, :2], corners]),
        np.concatenate([circles[:, 2] + need, np.full(len(corners), need)]),
        np.concatenate([edges + shift, edges - shift]),
    )


class _Graph:
    """Tangents and arcs; nodes are the start, ends on or at the goal, and points of touch on discs."""

    def __init__(self, asked: Task) -> None:
        self.task, self.discs = asked, _discs(asked.obstacles, asked.need_m)
        self.judged = 0
        self.goals: set[int] = set()
        self._places: list[Array] = [asked.start]
        self._touch: list[list[tuple[float, int]]] = [[] for _ in self.discs.radii]  # of each disc: angle, node
        self._edges: list[list[Edge]] = [[]]
        self._from_points()
        self._between_discs()
        for disc in range(len(self.discs.radii)):
            self._arcs(disc)

    def shortest(self) -> Array | None:
        """Pieces (P, 5) of the shortest route, as `route.Route` has them; None when there is none."""
        best: dict[int, float] = {0: 0.0}
        came: dict[int, tuple[int, Array | None]] = {}
        queue: list[tuple[float, int]] = [(0.0, 0)]
        while queue:
            length, node = heapq.heappop(queue)
            if length > best[node]:
                continue
            if node in self.goals:
                return _joined(self._way(came, node))
            for to, step, piece in self._edges[node]:
                if length + step < best.get(to, math.inf):
                    best[to], came[to] = length + step, (node, piece)
                    heapq.heappush(queue, (length + step, to))
        return None

    def _way(self, came: dict[int, tuple[int, "Array | None"]], node: int) -> list[Array]:
        pieces = []
        while node:
            node, piece = came[node]
            if piece is not None:
                pieces.append(piece)
        return pieces[::-1]

    def _node(self, place: Array, disc: int = -1, angle: float = 0.0) -> int:
        self._places.append(place)
        self._edges.append([])
        if disc >= 0:
            self._touch[disc].append((angle % (2.0 * math.pi), len(self._places) - 1))
        return len(self._places) - 1

    def _free(self, legs: Array) -> Array:
        self.judged += len(legs)
        return np.asarray(leg_gaps(self.task.obstacles, legs) >= self.task.need_m - TOUCH_M)

    def _line(self, a: int, b: int) -> None:
        step = self._places[b] - self._places[a]
        length, heading = float(np.hypot(*step)), math.atan2(step[1], step[0])
        if length <= 0.0:
            self._join(a, b, 0.0, None, None)
            return
        there = np.array([*self._places[a], heading, length, 0.0])
        back = np.array([*self._places[b], heading + math.pi, length, 0.0])
        self._join(a, b, length, there, back)

    def _join(self, a: int, b: int, length: float, there: Array | None, back: Array | None) -> None:
        self._edges[a].append((b, length, there))
        self._edges[b].append((a, length, back))

    # --- start and goal --------------------------------------------------------------------------------------

    def _from_points(self) -> None:
        """Lines from the start, to the goal, and to the ends of its circle where only that can be reached."""
        task = self.task
        places = [task.goal] if task.reach_m == 0.0 else list(self._rim())
        nodes = [self._node(place) for place in places]
        self.goals.update(nodes)
        self._point_tangents(0, task.start)
        for node, place in zip(nodes, places, strict=True):
            self._point_tangents(node, place)
            if self._free(np.concatenate([task.start, place])[None])[0]:
                self._line(0, node)
        if task.reach_m > 0.0:
            self._short_of_goal()

    def _point_tangents(self, node: int, place: Array) -> None:
        angles = _tangent_angles(place, self.discs)  # (D, 2)
        touch = _on(self.discs, angles)
        legs = np.concatenate([np.broadcast_to(place, touch.shape), touch], axis=-1)
        free = self._free(legs.reshape(-1, 4)).reshape(angles.shape) & np.isfinite(angles)
        for disc, side in np.argwhere(free):
            self._line(node, self._node(touch[disc, side], disc, float(angles[disc, side])))

    def _short_of_goal(self) -> None:
        """Lines that head for the goal's centre and end at its circle, the nearest point of it."""
        task = self.task
        angles = _tangent_angles(task.goal, self.discs)
        touch = _on(self.discs, angles)
        starts: list[tuple[Array, int, float]] = [(task.start, -1, 0.0)]
        starts += [(touch[i, k], int(i), float(angles[i, k])) for i, k in np.argwhere(np.isfinite(angles))]
        for place, disc, angle in starts:
            way = task.goal - place
            far = float(np.hypot(*way))
            if far <= task.reach_m:
                continue  # reached on the way there
            end = task.goal - way * (task.reach_m / far)
            if self._free(np.concatenate([place, end])[None])[0]:
                last = self._node(end)
                self.goals.add(last)
                self._line(0 if disc < 0 else self._node(place, disc, angle), last)

    def _rim(self) -> Array:
        """Where the goal's circle meets the border of what is free: (k, 2)."""
        task, discs = self.task, self.discs
        rim = _Discs(task.goal[None], np.array([task.reach_m]), discs.sides)
        angles = np.concatenate([_meet_discs(rim, 0, discs), _meet_sides(rim, 0)])
        places = task.goal + task.reach_m * np.stack([np.cos(angles), np.sin(angles)], axis=-1)
        free = point_gaps(task.obstacles, places) >= task.need_m - TOUCH_M
        for disc, (centre, radius) in enumerate(zip(discs.centres, discs.radii, strict=True)):
            for place in places[free]:
                if abs(math.dist(place, centre) - radius) <= TOUCH_M:  # reached along the disc, too
                    self.goals.add(self._node(place, disc, math.atan2(*(place - centre)[::-1])))
        return np.asarray(places[free])

    # --- between discs ---------------------------------------------------------------------------------------

    def _between_discs(self) -> None:
        """The four common tangents of every two discs."""
        centres, radii = self.discs.centres, self.discs.radii
        first, second = np.triu_indices(len(radii), 1)
        way = centres[second] - centres[first]
        far = np.hypot(way[:, 0], way[:, 1])
        direction = np.arctan2(way[:, 1], way[:, 0])
        for sign in (1.0, -1.0):  # outer, inner tangents
            cosine = (radii[first] - sign * radii[second]) / np.where(far > 0.0, far, 1.0)
            there = (far > 0.0) & (np.abs(cosine) <= 1.0)
            lean = np.arccos(np.clip(cosine, -1.0, 1.0))
            for side in (1.0, -1.0):
                angle = direction + side * lean
                other = angle if sign > 0.0 else angle + math.pi
                a = centres[first] + radii[first, None] * np.stack([np.cos(angle), np.sin(angle)], axis=1)
                b = centres[second] + radii[second, None] * np.stack([np.cos(other), np.sin(other)], axis=1)
                free = self._free(np.concatenate([a, b], axis=1)) & np.asarray(there)
                for k in np.flatnonzero(free):
                    start = self._node(a[k], int(first[k]), float(angle[k]))
                    self._line(start, self._node(b[k], int(second[k]), float(other[k])))

    def _arcs(self, disc: int) -> None:
        """The free arcs between the points of touch of one disc, cut where its rim goes into another obstacle."""
        if not self._touch[disc]:
            return
        cuts = np.concatenate([_meet_discs(self.discs, disc, self.discs), _meet_sides(self.discs, disc)])
        stops = sorted(self._touch[disc] + [(float(angle) % (2.0 * math.pi), -1) for angle in cuts])
        angles = np.array([angle for angle, _ in stops])
        sweep = np.diff(angles, append=angles[0] + 2.0 * math.pi)
        centre, radius = self.discs.centres[disc], self.discs.radii[disc]
        middle = angles + 0.5 * sweep
        places = centre + radius * np.stack([np.cos(middle), np.sin(middle)], axis=1)
        free = point_gaps(self.task.obstacles, places) >= self.task.need_m - TOUCH_M
        self.judged += len(free)
        nodes = [
            node if node >= 0 else self._node(centre + radius * np.array((math.cos(angle), math.sin(angle))))
            for angle, node in stops
        ]
        for k in range(len(stops)):
            a, b = nodes[k], nodes[(k + 1) % len(stops)]
            if sweep[k] <= 0.0:
                self._join(a, b, 0.0, None, None)
            elif free[k]:
                length, end = radius * float(sweep[k]), angles[k] + sweep[k]
                there = np.array([*self._places[a], angles[k] + 0.5 * math.pi, length, 1.0 / radius])
                back = np.array([*self._places[b], end - 0.5 * math.pi, length, -1.0 / radius])
                self._join(a, b, length, there, back)


def _tangent_angles(place: Array, discs: _Discs) -> Array:
    """(D, 2) where on each disc the two tangents from a place touch [rad]; NaN from inside."""
    way = place - discs.centres
    far = np.hypot(way[:, 0], way[:, 1])
    outside = far >= discs.radii - TOUCH_M
    lean = np.arccos(np.clip(discs.radii / np.where(outside, np.maximum(far, 1e-300), 1.0), -1.0, 1.0))
    direction = np.arctan2(way[:, 1], way[:, 0])
    both = np.stack([direction + lean, direction - lean], axis=1)
    return np.where(outside[:, None], both, np.nan)


def _on(discs: _Discs, angles: Array) -> Array:
    """(D, 2, 2) points of the discs at angles (D, 2); their centres where an angle is NaN."""
    unit = np.nan_to_num(np.stack([np.cos(angles), np.sin(angles)], axis=-1))
    return np.asarray(discs.centres[:, None] + discs.radii[:, None, None] * unit)


def _meet_discs(of: _Discs, number: int, others: _Discs) -> Array:
    """Angles [rad] at which the rim of disc `number` meets other rims; where they only touch, that one angle."""
    way = others.centres - of.centres[number]
    far = np.hypot(way[:, 0], way[:, 1])
    radius, radii = of.radii[number], others.radii
    meets = (far > 0.0) & (far <= radius + radii + TOUCH_M) & (far >= np.abs(radius - radii) - TOUCH_M)
    way, far, radii = way[meets], far[meets], radii[meets]
    cosine = (far**2 + radius**2 - radii**2) / (2.0 * far * radius)
    lean, direction = np.arccos(np.clip(cosine, -1.0, 1.0)), np.arctan2(way[:, 1], way[:, 0])
    return np.concatenate([direction + lean, direction - lean])


def _meet_sides(of: _Discs, number: int) -> Array:
    """Angles [rad] at which the rim of disc `number` meets the sides of strips."""
    centre, radius = of.centres[number], of.radii[number]
    along = of.sides[:, 2:] - of.sides[:, :2]
    length = np.hypot(along[:, 0], along[:, 1])
    unit = along / np.where(length > 0.0, length, 1.0)[:, None]
    way = centre - of.sides[:, :2]
    foot, off = np.sum(way * unit, axis=1), unit[:, 0] * way[:, 1] - unit[:, 1] * way[:, 0]
    near = (length > 0.0) & (np.abs(off) <= radius + TOUCH_M)
    reach = np.sqrt(np.maximum(0.0, radius**2 - off**2))
    angles = []
    for sign in (1.0, -1.0):
        t = foot + sign * reach
        on = near & (t >= -TOUCH_M) & (t <= length + TOUCH_M)
        places = of.sides[on, :2] + t[on, None] * unit[on] - centre
        angles.append(np.arctan2(places[:, 1], places[:, 0]))
    return np.concatenate(angles)


def _joined(pieces: list[Array]) -> Array:
    """Pieces of an arc that was cut become one; those without length go."""
    out: list[Array] = []
    for piece in pieces:
        if piece[3] <= TOUCH_M:
            continue
        if out and _continues(out[-1], piece):
            out[-1] = np.array([*out[-1][:3], out[-1][3] + piece[3], out[-1][4]])
        else:
            out.append(piece)
    return np.array(out).reshape(-1, 5)


def _continues(before: Array, piece: Array) -> bool:
    """Whether one piece goes on with the same curvature in the same direction."""
    turned = float(geometry.wrap(before[2] + before[3] * before[4] - piece[2]))
    return bool(abs(before[4] - piece[4]) <= TOUCH_M and abs(turned) <= 1e-7)
