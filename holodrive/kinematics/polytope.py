"""The set of twists that no wheel speed limit forbids, as corners and as slices of constant yaw rate.

With fixed wheels it is a polytope and every number here is exact. A steered wheel's limit is a cone, whose slices
are discs: corners where limits meet are exact, the arcs between them are sampled.
"""

from functools import cached_property
from itertools import combinations
from typing import TYPE_CHECKING

import numpy as np

from holodrive.errors import ChassisError
from holodrive.kinematics.shapes import read_only
from holodrive.types import Array

if TYPE_CHECKING:
    from holodrive.kinematics.chassis import Chassis

_INSIDE = 1.0 + 1e-9
_SLICES = 33
_ARC_POINTS = 72


class Polytope:
    """What the wheels of one chassis can do. All wheels need a `max_speed`.

    Attributes:
        exact: whether it is a polytope: no steered wheels.
    """

    def __init__(self, chassis: "Chassis") -> None:
        free = [wheel.name for wheel in chassis.wheels if not np.isfinite(wheel.max_speed)]
        if free:
            raise ChassisError(f"wheel {free[0]!r} has no max_speed, so its base has no bounded set of speeds; set it")
        self.exact = not chassis.steered
        fixed = [i for i in range(len(chassis.wheels)) if i not in chassis.steered]
        # |A v| <= 1 for fixed wheels (f, 3); |B v| <= 1 with B (2, 3) for each steered wheel
        self._planes = read_only(chassis.jacobian[chassis.fixed_rows] / chassis.max_speeds[fixed, None])
        self._cones = [
            chassis.jacobian[row : row + 2] / chassis.wheels[i].max_rim_speed
            for i, row in zip(chassis.steered, chassis.steered_rows, strict=True)
        ]

    def contains(self, twist: Array) -> Array:
        """Whether twists (..., 3) are possible (to 1e-9)."""
        inside = np.all(np.abs(twist @ self._planes.T) <= _INSIDE, axis=-1)
        for cone in self._cones:
            inside &= np.hypot(*np.moveaxis(twist @ cone.T, -1, 0)) <= _INSIDE
        return np.asarray(inside)

    @cached_property
    def vertices(self) -> Array:
        """(k, 3) corners; with steered wheels points on the boundary, slice by slice."""
        if not self.exact:
            slices = np.linspace(-self.max_omega, self.max_omega, _SLICES)
            return read_only(np.concatenate([_with_omega(self.section(omega), omega) for omega in slices]))
        corners = []
        for triple in combinations(range(len(self._planes)), 3):
            matrix = self._planes[list(triple)]
            if np.linalg.cond(matrix) > 1e12:
                continue
            for signs in np.array(np.meshgrid([-1.0, 1.0], [-1.0, 1.0], [-1.0, 1.0])).reshape(3, 8).T:
                corners.append(np.linalg.solve(matrix, signs))
        return read_only(_distinct(np.array([corner for corner in corners if self.contains(corner)])))

    @cached_property
    def max_omega(self) -> float:
        """Largest yaw rate [rad/s], with whatever translation allows it."""
        if self.exact:
            return float(self.vertices[:, 2].max())
        low, high = 0.0, self.turn_in_place
        while len(self.section(high)):
            low, high = high, 2.0 * high
        for _ in range(60):
            middle = 0.5 * (low + high)
            low, high = (middle, high) if len(self.section(middle)) else (low, middle)
        return low

    @cached_property
    def turn_in_place(self) -> float:
        """Largest yaw rate about `base_link` without translation [rad/s]."""
        loads = [*np.abs(self._planes[:, 2]), *(float(np.hypot(*cone[:, 2])) for cone in self._cones)]
        return float(1.0 / max(loads))

    @cached_property
    def volume(self) -> float:
        """Of the set [m^2/s^2 rad/s]."""
        from scipy.spatial import ConvexHull

        return float(ConvexHull(self.vertices).volume)

    def section(self, omega: float = 0.0) -> Array:
        """Polygon (k, 2) of (vx, vy) [m/s] at one yaw rate [rad/s], counter-clockwise; empty where none is possible."""
        lines = [(plane[:2], sign - plane[2] * omega) for plane in self._planes for sign in (-1.0, 1.0)]
        discs = [_disc(cone, omega) for cone in self._cones]
        candidates = [point for a, b in combinations(lines, 2) for point in _line_line(a, b)]
        for disc in discs:
            candidates += [point for line in lines for point in _line_disc(line, disc)]
            candidates += list(_circle(disc))
        candidates += [point for a, b in combinations(discs, 2) for point in _disc_disc(a, b)]
        points = np.array(candidates).reshape(-1, 2)
        points = _distinct(points[self.contains(_with_omega(points, omega))])
        if len(points) == 0:
            return points
        around = points - points.mean(axis=0)
        return np.asarray(points[np.argsort(np.arctan2(around[:, 1], around[:, 0]))])

    @cached_property
    def slowest(self) -> tuple[float, float]:
        """(speed [m/s], direction [rad]) of the worst direction without turning; the opposite one is as bad."""
        options = [(1.0 / float(np.hypot(*plane[:2])), plane[:2]) for plane in self._planes if np.any(plane[:2])]
        options += [(1.0 / float(np.hypot(*cone[:, 0])), np.array([1.0, 0.0])) for cone in self._cones]
        speed, direction = min(options, key=lambda option: option[0])
        return speed, _half_turn(direction)

    @cached_property
    def fastest(self) -> tuple[float, float]:
        """(speed [m/s], direction [rad]) of the best direction without turning; the opposite one is as good."""
        points = self.section(0.0)
        speeds = np.hypot(points[:, 0], points[:, 1])
        best = points[speeds >= speeds.max() * (1.0 - 1e-9)]
        return float(speeds.max()), min((_half_turn(point) for point in best), key=abs)


Line = tuple[Array, float]  # n . v = c
Disc = tuple[Array, float]  # centre, radius


def _disc(cone: Array, omega: float) -> Disc:
    """Slice of |B (v, omega)| <= 1; B's planar part is a rotation divided by the rim speed."""
    radius = 1.0 / float(np.hypot(*cone[:, 0]))
    return -(cone[:, :2].T @ cone[:, 2]) * omega * radius**2, radius


def _circle(disc: Disc) -> Array:
    angle = np.linspace(0.0, 2.0 * np.pi, _ARC_POINTS, endpoint=False)
    return np.asarray(disc[0] + disc[1] * np.stack([np.cos(angle), np.sin(angle)], axis=-1))


def _line_line(a: Line, b: Line) -> list[Array]:
    matrix = np.array([a[0], b[0]])
    size = np.hypot(*a[0]) * np.hypot(*b[0])
    if abs(np.linalg.det(matrix)) <= 1e-12 * size:
        return []
    return [np.linalg.solve(matrix, [a[1], b[1]])]


def _line_disc(line: Line, disc: Disc) -> list[Array]:
    normal, offset = line
    size = float(np.hypot(*normal))
    if size == 0.0:
        return []
    unit = normal / size
    gap = offset / size - float(unit @ disc[0])
    if abs(gap) > disc[1]:
        return []
    reach = np.sqrt(disc[1] ** 2 - gap**2) * np.array([-unit[1], unit[0]])
    foot = disc[0] + gap * unit
    return [foot - reach, foot + reach]


def _disc_disc(a: Disc, b: Disc) -> list[Array]:
    apart = b[0] - a[0]
    square = float(apart @ apart)
    if square == 0.0:
        return []
    # the points where both circles meet lie on the line of equal power
    return _line_disc((apart, float(apart @ a[0]) + 0.5 * (square + a[1] ** 2 - b[1] ** 2)), a)


def _with_omega(points: Array, omega: float) -> Array:
    return np.concatenate([points, np.full((len(points), 1), omega)], axis=1)


def _distinct(points: Array) -> Array:
    """Points without repetitions (to 1e-9 of their size)."""
    if len(points) == 0:
        return points
    grid = np.round(points / (1e-9 * np.abs(points).max()))
    return np.asarray(points[np.sort(np.unique(grid, axis=0, return_index=True)[1])])


def _half_turn(vector: Array) -> float:
    """Direction [rad] in (-90, 90] degrees of a vector or its opposite."""
    angle = float(np.arctan2(vector[1], vector[0]))
    if angle > np.pi / 2 + 1e-12:
        return angle - np.pi
    return angle + np.pi if angle <= -np.pi / 2 + 1e-12 else angle
