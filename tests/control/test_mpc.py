"""The quadratic program of the MPC: equal to textbook solutions where they exist, inside its limits everywhere."""

import math
from dataclasses import replace

import numpy as np
import pytest
from scipy.optimize import minimize

from holodrive import robots
from holodrive.control.mpc import Horizon, Mpc, Problem, limit_rows
from holodrive.kinematics import Chassis
from holodrive.robots.spec import Limits

ROBOT = robots.load("hybrid3_table_x")
FREE = replace(ROBOT, limits=Limits(), wheels=tuple(replace(w, max_speed_rad_s=1e6) for w in ROBOT.wheels))
SMALL = Horizon(steps=4, planes=2)


def no_planes(horizon):
    planes = np.zeros((horizon.steps, horizon.planes, 3))
    planes[:, :, 2] = -math.inf
    return planes


def random_case(seed, horizon, reach=0.3):
    """A reference that may be out of reach, some motion, and half-planes that the present place keeps."""
    rng, n = np.random.default_rng(seed), horizon.steps
    poses = np.cumsum(rng.normal(size=(n, 3)), axis=0) * reach / math.sqrt(n)
    normal = rng.uniform(-math.pi, math.pi, horizon.planes)
    planes = np.empty((n, horizon.planes, 3))
    planes[:, :, 0], planes[:, :, 1] = np.cos(normal), np.sin(normal)
    planes[:, :, 2] = -rng.uniform(0.02, 0.2, horizon.planes)
    headings = np.concatenate([[0.0], np.cumsum(rng.normal(size=n - 1)) * 0.1])
    return poses, rng.normal(size=(n, 3)) * 0.1, rng.normal(size=3) * 0.03, headings, planes


def cost(horizon, u, poses, twists, last):
    """The sum as it is written in the module's text."""
    h, p = horizon, horizon.dt_s * np.cumsum(u, axis=0)
    weights = [np.array([xy, xy, t]) for xy, t in ((h.q_xy, h.q_theta), (h.r_xy, h.r_theta), (h.s_xy, h.s_theta))]
    change = np.diff(u, axis=0, prepend=last[None])
    return sum(np.sum(w * e**2) for w, e in zip(weights, (p - poses, u - twists, change), strict=True))


@pytest.mark.parametrize("seed", range(5))
def test_without_limits_the_plan_is_the_least_squares_solution(seed):
    """All terms stacked as rows of one overdetermined system, solved by another method."""
    horizon = Horizon(steps=12)
    poses, twists, last, headings, _ = random_case(seed, horizon)
    n, dt = horizon.steps, horizon.dt_s
    to_poses, difference = dt * np.tril(np.ones((n, n))), np.eye(n) - np.eye(n, k=-1)
    expected = np.empty((n, 3))
    for axis in range(3):
        q, r, s = ((horizon.q_xy, horizon.r_xy, horizon.s_xy), (horizon.q_theta, horizon.r_theta, horizon.s_theta))[
            axis == 2
        ]
        rows = np.concatenate([math.sqrt(q) * to_poses, math.sqrt(r) * np.eye(n), math.sqrt(s) * difference])
        wanted = [
            math.sqrt(q) * poses[:, axis],
            math.sqrt(r) * twists[:, axis],
            math.sqrt(s) * last[axis] * np.eye(n)[0],
        ]
        expected[:, axis] = np.linalg.lstsq(rows, np.concatenate(wanted), rcond=None)[0]
    plan = Mpc(FREE, horizon).plan(poses, twists, last, headings, no_planes(horizon))
    np.testing.assert_allclose(plan.twists, expected, atol=1e-9)


def test_without_limits_the_first_move_is_the_lqr_gain():
    """Riccati's recursion of p+ = p + dt u with cost q p+^2 + r u^2 gives the same feedback."""
    horizon = Horizon(steps=15, s_xy=0.0, s_theta=0.0)
    q, r, dt = horizon.q_xy, horizon.r_xy, horizon.dt_s
    value = 0.0
    for _ in range(horizon.steps):
        gain = (q + value) * dt / (r + (q + value) * dt**2)
        value = (q + value) * (1.0 - gain * dt) ** 2 + r * gain**2
    offset = np.array([0.3, -0.2, 0.0])
    n = horizon.steps
    plan = Mpc(FREE, horizon).plan(
        np.tile(offset, (n, 1)), np.zeros((n, 3)), np.zeros(3), np.zeros(n), no_planes(horizon)
    )
    np.testing.assert_allclose(plan.twists[0], gain * offset, atol=1e-10)


@pytest.mark.parametrize("seed", range(8))
def test_a_second_solver_finds_the_same_plan(seed):
    case = random_case(seed, SMALL)
    problem = Problem(ROBOT, SMALL)
    problem.fill(*case)
    rows, low, high = problem.matrix, problem.lower, problem.upper
    both = {"type": "ineq", "fun": lambda u: np.concatenate([rows @ u - low, (high - rows @ u)[np.isfinite(high)]])}
    poses, twists, last = case[:3]
    other = minimize(
        lambda u: cost(SMALL, u.reshape(-1, 3), poses, twists, last), np.zeros(12), constraints=both, method="SLSQP",
        options={"ftol": 1e-14, "maxiter": 500},
    )  # fmt: skip
    plan = Mpc(ROBOT, SMALL).plan(*case)
    assert plan.solved == other.success
    if plan.solved:
        np.testing.assert_allclose(plan.twists.ravel(), other.x, atol=2e-5)


@pytest.mark.parametrize("seed", range(20))
def test_all_limits_hold_along_the_prediction(seed):
    """Checked by the definitions, not by the solver's rows: the chassis, the change of the twist, each half-plane."""
    horizon = Horizon(steps=20, planes=2)
    poses, twists, last, headings, planes = random_case(seed, horizon, reach=1.0)
    mpc = Mpc(ROBOT, horizon)
    plan = mpc.plan(poses, twists, last, headings, planes)
    assert plan.solved
    c, s = np.cos(headings), np.sin(headings)
    x, y, turn = plan.twists.T
    wheels = Chassis.of(ROBOT).inverse(np.stack([c * x + s * y, c * y - s * x, turn], axis=-1)).speeds
    assert np.all(np.abs(wheels) <= Chassis.of(ROBOT).max_speeds * (1.0 + 1e-5))
    change = np.diff(plan.twists, axis=0, prepend=last[None])
    assert np.all(np.hypot(change[:, 0], change[:, 1]) <= ROBOT.limits.accel_m_s2 * horizon.dt_s + 1e-5)
    assert np.all(np.abs(change[:, 2]) <= ROBOT.limits.yaw_accel_rad_s2 * horizon.dt_s + 1e-5)
    reached = mpc.problem.poses(plan.twists)
    gap = np.einsum("kji,ki->kj", planes[:, :, :2], reached[:, :2]) - planes[:, :, 2]
    assert np.all(gap >= -1e-5)


@pytest.mark.parametrize("name", robots.names())
def test_limit_rows_are_what_the_chassis_can_do(name):
    """Exactly with fixed wheels; never more than it with steered ones."""
    robot = replace(robots.load(name), limits=Limits())
    polytope, rows = Chassis.of(robot).polytope, limit_rows(robot)
    most = np.array([2.0, 2.0, 2.0]) / np.max(np.abs(rows), axis=0)
    twists = np.random.default_rng(1).uniform(-most, most, size=(4000, 3))
    inside = np.all(np.abs(twists @ rows.T) <= 1.0, axis=-1)
    allowed = polytope.contains(twists)
    assert np.all(allowed[inside])
    assert 0 < inside.sum() < len(twists)
    if polytope.exact:
        assert np.array_equal(inside, allowed)


def test_the_robots_own_speed_limits_count_as_well():
    slow = replace(ROBOT, limits=Limits(speed_m_s=0.05, yaw_rate_rad_s=0.1))
    horizon = Horizon(steps=5)
    far = np.tile([3.0, 2.0, 1.0], (5, 1))
    plan = Mpc(slow, horizon).plan(far, np.zeros((5, 3)), np.zeros(3), np.zeros(5), no_planes(horizon))
    speed = np.hypot(plan.twists[:, 0], plan.twists[:, 1])
    assert np.all(speed <= 0.05 + 1e-6)
    assert np.all(speed >= 0.05 * math.cos(math.pi / 8) - 1e-6)
    np.testing.assert_allclose(plan.twists[:, 2], 0.1, atol=1e-6)


def test_what_was_solved_before_changes_nothing_but_the_time():
    horizon = Horizon(planes=2)
    used = Mpc(ROBOT, horizon)
    for seed in range(10):
        used.plan(*random_case(seed, horizon))
    case = random_case(99, horizon)
    np.testing.assert_allclose(used.plan(*case).twists, Mpc(ROBOT, horizon).plan(*case).twists, atol=1e-9)


def test_an_impossible_problem_is_told_and_spoils_no_later_one():
    case, mpc = random_case(0, SMALL), Mpc(ROBOT, SMALL)
    between = case[4].copy()
    between[:, 0], between[:, 1] = (1.0, 0.0, 0.5), (-1.0, 0.0, 0.5)
    wrong = mpc.plan(*case[:4], between)
    assert not wrong.solved
    assert "limits and half-planes" in wrong.why
    assert np.all(np.isnan(wrong.twists))
    np.testing.assert_array_equal(mpc.plan(*case).twists, Mpc(ROBOT, SMALL).plan(*case).twists)


@pytest.mark.parametrize(("part", "at"), [(0, 0), (1, 5), (2, 2), (3, 1), (4, 0), (4, 2)])
def test_a_number_that_is_not_finite_gives_no_plan(part, at):
    case = [array.copy() for array in random_case(3, SMALL)]
    case[part].flat[at] = math.nan
    plan = Mpc(ROBOT, SMALL).plan(*case)
    assert not plan.solved
    assert plan.why


def test_an_iteration_limit_ends_the_search():
    plan = Mpc(ROBOT, SMALL, max_iterations=1).plan(*random_case(0, SMALL, reach=3.0))
    assert not plan.solved
    assert "iteration limit" in plan.why
