"""Model predictive control of a holonomic base: the quadratic program of the pose tracker, condensed to its inputs.

    min   sum_k |p_(k+1) - r_(k+1)|^2_Q + |u_k - f_k|^2_R + |u_k - u_(k-1)|^2_S,   k = 0 .. N-1
    with  p_(k+1) = p_k + dt u_k
    s.t.  |J R(h_k)^T u_k| <= w_max          (2 n rows: every wheel, both ways)
          |u_k - u_(k-1)| <= a dt            (each axis; a times the period of the solutions for k = 0)
          n_kj . p_(k+1) >= d_kj             (half-planes that keep obstacles out)

u is the twist in axes that do not turn during the horizon, those that `base_link` has now, and p is measured from
where it is now. With v = R(h)^T u this is the usual p_(k+1) = p_k + dt blkdiag(R(h_k), 1) v_k, linearised about the
headings h_k; but the model is constant, so that only the wheels' rows depend on h, and the acceleration limits mean
what they mean in the command pipeline: a base that spins along a straight line does not accelerate. Nothing depends
on where the world has its origin or its axes.

f = 0 is the plain cost of speed; with the reference's own twist as f there is no cost of keeping up with it.
"""

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numba import njit

from holodrive.kinematics import Chassis
from holodrive.robots.spec import Robot
from holodrive.types import Array

_OCTAGON = np.pi / 4.0 * np.arange(4)
_SOLVED = 1  # daqp's exit flag of an optimal solution; 2 is one with soft constraints, which are not used here


@dataclass(frozen=True)
class Horizon:
    """What does not change from step to step.

    Attributes:
        steps: N.
        dt_s: length of a step.
        q_xy, q_theta: weights of the pose error [1/m^2, 1/rad^2].
        r_xy, r_theta: of the twist [s^2/m^2, s^2/rad^2].
        s_xy, s_theta: of its change from step to step, same units.
        planes: how many half-planes a step has at most.
        period_s: how often a problem is solved and its first move replaced; the first change of the twist has no more
            time than that.
        accel_share: of the robot's acceleration limits that is planned with.
    """

    steps: int = 20
    dt_s: float = 0.1
    q_xy: float = 1.0
    q_theta: float = 0.25
    r_xy: float = 0.02
    r_theta: float = 0.005
    s_xy: float = 0.2
    s_theta: float = 0.02
    planes: int = 4
    period_s: float = 0.1
    accel_share: float = 1.0


@dataclass(frozen=True)
class Plan:
    """What a solver made of one problem.

    Attributes:
        twists: (N, 3) u_k [m/s, m/s, rad/s] in the axes that `base_link` has now; NaN when `solved` is False.
        solved: whether all constraints hold and the cost is least.
        why: "" or what the solver said instead.
        iterations: of the solver.
    """

    twists: Array
    solved: bool
    why: str
    iterations: int


class Problem:
    """The matrices of one robot's quadratic programs: min 1/2 u.H u + f.u  s.t.  lower <= A u <= upper.

    `fill` writes a new problem into the same arrays. u is (3N,): x, y, turn of step 0, then of step 1 ...

    Attributes:
        hessian: (3N, 3N), the same for every problem.
        linear: (3N,) f.
        matrix: (rows, 3N) A; lower, upper: (rows,). Rows: limits of the twist, its change, half-planes.
    """

    def __init__(self, robot: Robot, horizon: Horizon) -> None:
        n, self.horizon = horizon.steps, horizon
        self._rows = limit_rows(robot)
        change = np.array([robot.limits.accel_m_s2, robot.limits.accel_m_s2, robot.limits.yaw_accel_rad_s2])
        change[:2] *= math.sqrt(0.5)  # the square inside the circle of the limit
        self._change = horizon.accel_share * np.outer([min(horizon.period_s, horizon.dt_s), horizon.dt_s], change)
        self._axes = np.flatnonzero(np.isfinite(change))
        blocks = _axis(horizon, horizon.q_xy, horizon.r_xy, horizon.s_xy)
        turn = _axis(horizon, horizon.q_theta, horizon.r_theta, horizon.s_theta)
        # (3, N, N) each: Hessian, and what reference poses, reference twists and the last twist add to f
        hessian, *self._to_linear = (
            np.stack([a, a, b])  # x and y alike
            for a, b in zip(blocks, turn, strict=True)
        )
        self.hessian = np.zeros((3 * n, 3 * n))
        for axis in range(3):
            self.hessian[axis::3, axis::3] = hessian[axis]
        count = n * (len(self._rows) + len(self._axes) + horizon.planes)
        self.linear, self.matrix = np.zeros(3 * n), np.zeros((count, 3 * n))
        self.lower, self.upper = np.full(count, -np.inf), np.full(count, np.inf)
        _fixed_rows(self._axes, n, len(self._rows), self.matrix)

    def fill(self, poses: Array, twists: Array, last: Array, headings: Array, planes: Array) -> None:
        """Write one problem; everything is in the axes that `base_link` has now, and from where it is now.

        Args:
            poses: (N, 3) wanted r_1 .. r_N [m, m, rad], headings as the way to turn from now, not wrapped.
            twists: (N, 3) wanted f_0 .. f_(N-1) [m/s, m/s, rad/s].
            last: (3,) the twist u_(-1) that is applied now.
            headings: (N,) h_0 .. h_(N-1) [rad] about which the wheels' limits are taken; h_0 is 0.
            planes: (N, planes, 3) normal and distance (n_x, n_y, d) of each step's half-planes [-, -, m];
                a distance of minus infinity is no half-plane.
        """
        by_pose, by_twist, by_last = self._to_linear
        linear = np.einsum("aij,ja->ia", by_pose, poses) + np.einsum("aij,ja->ia", by_twist, twists)
        self.linear[:] = -(linear + by_last[:, :, 0].T * last).ravel()
        _fill(
            self._rows, self._change, self._axes, self.horizon.dt_s, last, headings, planes,
            self.matrix, self.lower, self.upper,
        )  # fmt: skip

    def poses(self, twists: Array) -> Array:
        """(..., N, 3) predicted p_1 .. p_N of inputs (..., N, 3), from where the base is now."""
        return np.asarray(self.horizon.dt_s * np.cumsum(twists, axis=-2))


class Mpc:
    """`Problem` with a solver (daqp: dual active set) that starts from the constraints that held last time."""

    def __init__(self, robot: Robot, horizon: Horizon, max_iterations: int = 500) -> None:
        self.problem = Problem(robot, horizon)
        self._max_iterations = max_iterations  # a bound on the time that, unlike a clock, gives equal runs
        self.reset()

    def reset(self) -> None:
        """Forget the last solution."""
        self._model: Any = None

    def plan(self, poses: Array, twists: Array, last: Array, headings: Array, planes: Array) -> Plan:
        """Solve one problem, given as to `Problem.fill`. Numbers that are not finite give a plan that is not solved."""
        problem = self.problem
        problem.fill(poses, twists, last, headings, planes)
        numbers = np.sum(problem.linear) + np.sum(problem.matrix)
        if not math.isfinite(numbers) or math.isnan(np.sum(problem.lower)):
            return self._failed("the problem holds numbers that are not finite", 0)
        if self._model is None:
            flag = self._set_up()
        else:
            flag = self._model.update(f=problem.linear, A=problem.matrix, bupper=problem.upper, blower=problem.lower)
        if flag < 0:
            return self._failed(f"the solver refused the problem (flag {flag})", 0)
        solution, _, flag, told = self._model.solve()
        if flag != _SOLVED:
            return self._failed(_REASONS.get(flag, f"the solver gave up (flag {flag})"), told["iterations"])
        return Plan(np.asarray(solution).reshape(-1, 3), True, "", told["iterations"])

    def _set_up(self) -> int:
        from daqp import Model  # some milliseconds that only runs with MPC pay

        self._model, problem = Model(), self.problem
        flag, _ = self._model.setup(problem.hessian, problem.linear, problem.matrix, problem.upper, problem.lower)
        self._model.settings = {"iter_limit": self._max_iterations}
        return int(flag)

    def _failed(self, why: str, iterations: int) -> Plan:
        self.reset()  # the active set of a failure is no good start
        return Plan(np.full((self.problem.horizon.steps, 3), math.nan), False, why, iterations)


_REASONS = {
    -1: "no twists keep all limits and half-planes",
    -2: "the solver went round in circles",
    -4: "the solver reached its iteration limit",
}


def limit_rows(robot: Robot) -> Array:
    """(k, 3) rows a with |a . v| <= 1 for every body twist v that the robot may have.

    A fixed wheel gives its row of the Jacobian over its limit: with fixed wheels these are the exact polytope
    (`Chassis.polytope`). A steered wheel's disc, and the base's own speed limit, become the octagon inside.
    """
    chassis = Chassis.of(robot)
    rows = []
    for i, row in enumerate(chassis.row):
        if i in chassis.steered:
            rows.append(_octagon(chassis.jacobian[row : row + 2], chassis.wheels[i].max_rim_speed))
        else:
            rows.append(chassis.jacobian[row : row + 1] / chassis.max_speeds[i])
    if robot.limits.speed_m_s < math.inf:
        rows.append(_octagon(np.eye(2, 3), robot.limits.speed_m_s))
    if robot.limits.yaw_rate_rad_s < math.inf:
        rows.append(np.array([[0.0, 0.0, 1.0 / robot.limits.yaw_rate_rad_s]]))
    return np.concatenate(rows)


def _octagon(rows: Array, radius: float) -> Array:
    """Rows of the octagon inside |rows . v| <= radius."""
    normals = np.stack([np.cos(_OCTAGON), np.sin(_OCTAGON)], axis=-1)
    return np.asarray(normals @ rows / (radius * math.cos(math.pi / 8.0)))


def _axis(horizon: Horizon, q: float, r: float, s: float) -> tuple[Array, Array, Array, Array]:
    """Hessian (N, N) of one axis, and the matrices of reference poses, reference twists and last twist in -f."""
    n, dt = horizon.steps, horizon.dt_s
    to_poses = dt * np.tril(np.ones((n, n)))
    difference = np.eye(n) - np.eye(n, k=-1)
    hessian = 2.0 * (q * to_poses.T @ to_poses + r * np.eye(n) + s * difference.T @ difference)
    return hessian, 2.0 * q * to_poses.T, 2.0 * r * np.eye(n), 2.0 * s * difference.T


def _fixed_rows(axes: Any, steps: int, limits: int, matrix: Array) -> None:
    """The rows of the twist's change, which no problem alters."""
    first = steps * limits
    for k in range(steps):
        for i, axis in enumerate(axes):
            row = first + k * len(axes) + i
            matrix[row, 3 * k + axis] = 1.0
            if k:
                matrix[row, 3 * k - 3 + axis] = -1.0


@njit(cache=True, error_model="numpy")
def _fill(rows, change, axes, dt, last, headings, planes, matrix, lower, upper):  # type: ignore[no-untyped-def]
    """Write what depends on headings, last twist and half-planes; zeros stay where no problem writes."""
    steps = headings.shape[0]
    at = 0
    for k in range(steps):
        c, s = math.cos(headings[k]), math.sin(headings[k])
        for i in range(rows.shape[0]):
            a, b = rows[i, 0], rows[i, 1]
            matrix[at, 3 * k], matrix[at, 3 * k + 1] = a * c - b * s, a * s + b * c
            matrix[at, 3 * k + 2] = rows[i, 2]
            lower[at], upper[at] = -1.0, 1.0
            at += 1
    for k in range(steps):
        for axis in axes:
            before, reach = (last[axis], change[0, axis]) if k == 0 else (0.0, change[1, axis])
            lower[at], upper[at] = before - reach, before + reach
            at += 1
    for k in range(steps):
        for j in range(planes.shape[1]):
            there = planes[k, j, 2] > -math.inf
            x, y = (dt * planes[k, j, 0], dt * planes[k, j, 1]) if there else (0.0, 0.0)
            for i in range(k + 1):
                matrix[at, 3 * i], matrix[at, 3 * i + 1] = x, y
            lower[at] = planes[k, j, 2]
            at += 1


__all__ = ["Horizon", "Mpc", "Plan", "Problem", "limit_rows"]
