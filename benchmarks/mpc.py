"""The QP solver of the MPC, chosen by measurement on the package's own problems, and the whole step's time.

    pip install 'holodrive[bench]' osqp piqp proxsuite
    python benchmarks/mpc.py [--seconds 20] [--save]

One closed loop (the base of Table X after a circle, with discs in its way) gives a sequence of problems; every solver
meets each of them once, in order and in turn, so that warm starts are fair and other load meets all alike. A time is
the whole step: building the QP, handing it over, solving. All solvers are asked for 1e-6; what they kept is printed
beside. "condensed" has the inputs only, "sparse" inputs and poses. Exit code 1 when the bar is missed: a step of ours
with N = 20 takes at most 2 ms in the median.
"""

import argparse
import math
import platform
import statistics
import sys
import time
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path

import numpy as np

from holodrive import planning, references, robots
from holodrive.control.mpc import Horizon, Mpc, Problem
from holodrive.types import Pose

STEPS, BAR_MS, BAR_AT, TOLERANCE = (10, 20, 40), 2.0, 20, 1e-6
PERIOD, SPEED, RADIUS = 0.05, 0.12, 0.5  # s between problems, m/s, m
DISCS = np.array([(0.0, 0.62, 0.40), (-0.75, -0.1, 0.35), (0.1, -0.8, 0.45)])  # x, y, radius with the robot's [m]


# --- problems --------------------------------------------------------------------------------------


def problems(robot, horizon, seconds):
    """Arguments of `Problem.fill` for each step of one closed loop, driven by our own solver on ideal wheels."""
    mpc, path = Mpc(robot, horizon), planning.follow(planning.circle(RADIUS), SPEED, laps=4)
    follower = references.ReferenceFollower(path)
    ahead = horizon.dt_s * np.arange(1, horizon.steps + 1)
    first = follower.step(0.0, Pose(0, 0, 0)).pose
    pose, last = np.array([first.x + 0.2, first.y - 0.2, 1.0]), np.zeros(3)
    headings, sequence = np.zeros(horizon.steps), []
    for k in range(round(seconds / PERIOD)):
        wanted = [follower.step(k * PERIOD + t, Pose(*pose)) for t in ahead]
        turn = rotation(pose[2])
        poses = np.array([reference.pose for reference in wanted]) - pose
        poses[:, 2] = np.remainder(poses[:, 2] + math.pi, 2 * math.pi) - math.pi
        twists = np.array([reference.twist for reference in wanted])
        case = (poses @ turn, twists @ turn, last @ turn, headings, half_planes(pose, turn, horizon))
        sequence.append(tuple(np.ascontiguousarray(part).copy() for part in case))
        plan = mpc.plan(*sequence[-1])
        if not plan.solved:
            raise SystemExit(f"problem {k} of N = {horizon.steps}: {plan.why}")
        last = turn @ plan.twists[0]
        pose = pose + PERIOD * last
        headings = np.concatenate([[0.0], np.cumsum(plan.twists[:-1, 2]) * horizon.dt_s])
    return sequence


def rotation(theta):
    """From axes of the base to axes of the world, turning kept."""
    c, s = math.cos(theta), math.sin(theta)
    return np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])


def half_planes(pose, turn, horizon):
    """One half-plane for each disc at every step; where the base is too near, it may not come nearer."""
    planes = np.zeros((horizon.steps, horizon.planes, 3))
    planes[:, :, 2] = -math.inf
    for j, (x, y, radius) in enumerate(DISCS):
        away = pose[:2] - (x, y)
        gap = np.hypot(*away)
        planes[:, j, :2] = turn[:2, :2].T @ (away / gap)
        planes[:, j, 2] = min(radius - gap, 0.0)
    return planes


# --- solvers: each makes u (N, 3) of the arguments of one problem ------------------------------------


class Daqp:
    package, name = "daqp", "daqp condensed, warm"

    def __init__(self, robot, horizon):
        self.mpc = Mpc(robot, horizon)

    def step(self, *case):
        return self.mpc.plan(*case).twists


class DaqpCold(Daqp):
    name = "daqp condensed, cold"

    def step(self, *case):
        self.mpc.reset()
        return self.mpc.plan(*case).twists


class OsqpCondensed:
    package, name = "osqp", "osqp condensed, warm"

    def __init__(self, robot, horizon):
        import osqp

        self.problem, self.solver, self.osqp = Condensed(robot, horizon), None, osqp

    def step(self, *case):
        problem = self.problem
        problem.fill(*case)
        if self.solver is None:
            self.solver = self.osqp.OSQP()
            self.solver.setup(
                problem.p, problem.q, problem.a, problem.low, problem.high, verbose=False, eps_abs=TOLERANCE,
                eps_rel=0.0, max_iter=20000,
            )  # fmt: skip
        else:
            self.solver.update(q=problem.q, l=problem.low, u=problem.high, Ax=problem.a.data)
        return problem.inputs(self.solver.solve(raise_error=False).x)


class OsqpSparse(OsqpCondensed):
    name = "osqp sparse, warm"

    def __init__(self, robot, horizon):
        super().__init__(robot, horizon)
        self.problem = Sparse(robot, horizon)


class PiqpDense:
    package, name = "piqp", "piqp condensed"

    def __init__(self, robot, horizon):
        import piqp

        self.problem, self.solver = Problem(robot, horizon), piqp.DenseSolver()
        tight(self.solver.settings)
        self.ready = False

    def step(self, *case):
        problem = self.problem
        problem.fill(*case)
        if self.ready:
            self.solver.update(c=problem.linear, G=problem.matrix, h_l=problem.lower, h_u=problem.upper)
        else:
            self.solver.setup(problem.hessian, problem.linear, G=problem.matrix, h_l=problem.lower, h_u=problem.upper)
            self.ready = True
        self.solver.solve()
        return self.solver.result.x.reshape(-1, 3)


class PiqpSparse:
    package, name, kkt = "piqp", "piqp sparse", "sparse_ldlt"

    def __init__(self, robot, horizon):
        import piqp

        self.problem, self.solver = Sparse(robot, horizon, stacked=False), piqp.SparseSolver()
        tight(self.solver.settings)
        self.solver.settings.kkt_solver = getattr(piqp.KKTSolver, self.kkt)
        self.ready = False

    def step(self, *case):
        problem = self.problem
        problem.fill(*case)
        equal = problem.equal
        limits = {"G": problem.rows, "h_l": problem.low[equal:], "h_u": problem.high[equal:]}
        if self.ready:
            self.solver.update(c=problem.q, b=problem.low[:equal], **limits)
        else:
            self.solver.setup(problem.p, problem.q, problem.model, problem.low[:equal], **limits)
            self.ready = True
        self.solver.solve()
        return problem.inputs(self.solver.result.x)


class PiqpMultistage(PiqpSparse):
    name, kkt = "piqp multistage", "sparse_multistage"


class ProxqpDense:
    package, name = "proxsuite", "proxqp condensed, warm"

    def __init__(self, robot, horizon):
        from proxsuite import proxqp

        self.problem = Problem(robot, horizon)
        self.qp = proxqp.dense.QP(len(self.problem.linear), 0, len(self.problem.lower))
        self.qp.settings.eps_abs, self.qp.settings.eps_rel = TOLERANCE, 0.0
        self.warm, self.ready = proxqp.InitialGuess.WARM_START_WITH_PREVIOUS_RESULT, False

    def step(self, *case):
        problem = self.problem
        problem.fill(*case)
        if self.ready:
            self.qp.update(g=problem.linear, C=problem.matrix, l=problem.lower, u=problem.upper)
        else:
            self.qp.init(problem.hessian, problem.linear, None, None, problem.matrix, problem.lower, problem.upper)
            self.ready = True
        self.qp.solve()
        self.qp.settings.initial_guess = self.warm
        return self.qp.results.x.reshape(-1, 3)


SOLVERS = (Daqp, DaqpCold, ProxqpDense, PiqpDense, PiqpSparse, PiqpMultistage, OsqpCondensed, OsqpSparse)


def tight(settings):
    settings.eps_abs, settings.eps_rel = TOLERANCE, 0.0
    settings.eps_duality_gap_abs, settings.eps_duality_gap_rel = TOLERANCE, 0.0


class Condensed:
    """Our matrices as scipy's, with one pattern for all problems."""

    def __init__(self, robot, horizon):
        from scipy import sparse

        self.own = Problem(robot, horizon)
        self.p = sparse.csc_matrix(np.triu(self.own.hessian))
        self.places = np.nonzero(pattern(self.own))
        self.a, self.order = csc(self.places, self.own.matrix.shape)
        self.q, self.low, self.high = self.own.linear, self.own.lower, self.own.upper

    def fill(self, *case):
        self.own.fill(*case)
        self.a.data[:] = self.own.matrix[self.places][self.order]

    def inputs(self, x):
        return np.asarray(x).reshape(-1, 3)


class Sparse:
    """The same problem with poses as variables: z = (u_0, p_1, u_1, p_2, ...), p_(k+1) = p_k + dt u_k."""

    def __init__(self, robot, horizon, stacked=True):
        from scipy import sparse

        self.own, n, dt = Problem(robot, horizon), horizon.steps, horizon.dt_s
        self.n = n
        q = np.array([horizon.q_xy, horizon.q_xy, horizon.q_theta])
        r = np.array([horizon.r_xy, horizon.r_xy, horizon.r_theta])
        s = np.array([horizon.s_xy, horizon.s_xy, horizon.s_theta])
        self.weights = q, r, s
        cost, blocks = np.zeros((6 * n, 6 * n)), np.zeros((3 * n, 6 * n))
        for k in range(n):
            for i in range(3):
                u, p = 6 * k + i, 6 * k + 3 + i
                cost[u, u], cost[p, p] = 2 * (r[i] + s[i] * (2 if k < n - 1 else 1)), 2 * q[i]
                blocks[3 * k + i, [u, p]] = -dt, 1.0
                if k:
                    cost[u - 6, u], blocks[3 * k + i, p - 6] = -2 * s[i], -1.0
        self.p, self.equal = sparse.csc_matrix(cost), 3 * n
        kept = pattern(self.own)  # rows of half-planes move from the inputs to the pose they speak of
        self.half_planes = slice(len(kept) - n * horizon.planes, len(kept))
        wide = np.zeros((len(kept), 6 * n))
        for k in range(n):
            wide[:, 6 * k : 6 * k + 3] = kept[:, 3 * k : 3 * k + 3]
        wide[self.half_planes] = 0.0
        for row in range(n * horizon.planes):
            p = 6 * (row // horizon.planes) + 3
            wide[self.half_planes.start + row, [p, p + 1]] = 1.0
        # osqp takes one matrix; piqp takes the model apart from the rest, which spares it the constant part
        self.model, first = sparse.csc_matrix(blocks), self.equal if stacked else 0
        whole = np.concatenate([blocks, wide]) if stacked else wide
        places = np.nonzero(whole)
        self.a, self.order = csc(places, whole.shape)
        self.rows, self.values = self.a, whole[places]
        row, column = places[0] - first, places[1]
        self.from_inputs = np.flatnonzero((row >= 0) & (row < self.half_planes.start))
        at = column[self.from_inputs]
        self.at_inputs = row[self.from_inputs], at // 6 * 3 + at % 6
        self.from_planes = np.flatnonzero(row >= self.half_planes.start)
        at = row[self.from_planes] - self.half_planes.start
        self.at_planes = at // horizon.planes, at % horizon.planes, column[self.from_planes] % 3
        self.q = np.zeros(6 * n)
        self.low, self.high = (np.zeros(self.equal + len(wide)) for _ in range(2))

    def fill(self, poses, twists, last, headings, planes):
        self.own.fill(poses, twists, last, headings, planes)
        q, r, s = self.weights
        z = self.q.reshape(self.n, 2, 3)
        z[:, 0], z[:, 1] = -2 * r * twists, -2 * q * poses
        z[0, 0] -= 2 * s * last
        self.low[self.equal :], self.high[self.equal :] = self.own.lower, self.own.upper
        self.values[self.from_inputs] = self.own.matrix[self.at_inputs]
        self.values[self.from_planes] = planes[self.at_planes]
        self.a.data[:] = self.values[self.order]

    def inputs(self, x):
        return np.asarray(x).reshape(self.n, 2, 3)[:, 0]


def pattern(problem):
    """Where a problem's matrix may be other than 0."""
    n, planes = problem.horizon.steps, problem.horizon.planes
    full = np.full((n, planes, 3), 1.0)
    problem.fill(np.zeros((n, 3)), np.zeros((n, 3)), np.zeros(3), np.full(n, 0.3), full)
    return (problem.matrix != 0.0).astype(float)


def csc(places, shape):
    """A sparse matrix with ones at `places`, and the order in which its data stand."""
    from scipy import sparse

    matrix = sparse.csc_matrix((np.arange(1.0, len(places[0]) + 1.0), places), shape=shape)
    order = matrix.data.astype(int) - 1
    matrix.data[:] = 1.0
    return matrix, order


# --- measuring ---------------------------------------------------------------------------------------


def measure(robot, steps, seconds):
    """Rows of (name, median ms, p99 ms, largest difference of u, largest violation)."""
    horizon = Horizon(steps=steps, planes=len(DISCS))
    sequence = problems(robot, horizon, seconds)
    judge, made, times, worst, broken = Problem(robot, horizon), [], {}, {}, {}
    for kind in SOLVERS:
        try:
            made.append(kind(robot, horizon))
        except ImportError:
            print(f"  {kind.name}: {kind.package} is not installed")
    for k, case in enumerate(sequence):
        answers = {}
        for i in range(len(made)):
            solver = made[(i + k) % len(made)]
            begin = time.perf_counter()
            answers[solver.name] = solver.step(*case)
            times.setdefault(solver.name, []).append(1e3 * (time.perf_counter() - begin))
        judge.fill(*case)
        for name, u in answers.items():
            reached = judge.matrix @ u.ravel()
            over = max(np.max(judge.lower - reached), np.max(reached - judge.upper), 0.0)
            broken[name] = max(broken.get(name, 0.0), over)
            worst[name] = max(worst.get(name, 0.0), np.max(np.abs(u - answers[Daqp.name])))
    skip = 5  # first steps set up
    return [
        (s.name, statistics.median(times[s.name][skip:]), np.quantile(times[s.name][skip:], 0.99), worst[s.name],
         broken[s.name]) for s in made
    ]  # fmt: skip


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--seconds", type=float, default=20.0, help="length of the closed loop")
    parser.add_argument("--save", action="store_true", help="write the table into results/")
    arguments = parser.parse_args()
    robot, lines, missed = robots.load("hybrid3_table_x"), [], False
    packages = ", ".join(f"{package} {found(package)}" for package in ("daqp", "osqp", "piqp", "proxsuite"))
    lines.append(f"{platform.machine()}, Python {platform.python_version()}, numpy {np.__version__}, {packages}")
    for steps in STEPS:
        table = measure(robot, steps, arguments.seconds)
        ours = table[0][1]
        rows = len(Problem(robot, Horizon(steps=steps, planes=len(DISCS))).lower)
        lines.append(f"\nN = {steps}: {3 * steps} inputs, {rows} rows")
        lines.append(
            f"{'solver':26s} {'median ms':>10s} {'p99 ms':>8s} {'ratio':>6s} {'diff. of u':>11s} {'violation':>10s}"
        )
        lines += [
            f"{name:26s} {median:10.3f} {p99:8.3f} {median / ours:6.2f} {worst:11.1e} {broken:10.1e}"
            for name, median, p99, worst, broken in table
        ]
        if steps == BAR_AT:
            missed = ours > BAR_MS
            lines.append(f"bar: {Daqp.name} at most {BAR_MS} ms: {'MISSED' if missed else 'kept'}")
    print(text := "\n".join(lines))
    if arguments.save:
        (Path(__file__).parent / "results" / "mpc.txt").write_text(text + "\n")
    sys.exit(int(missed))


def found(package):
    try:
        return version(package)
    except PackageNotFoundError:
        return "-"


if __name__ == "__main__":
    main()
