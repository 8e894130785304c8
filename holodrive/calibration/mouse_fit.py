"""The least squares behind a calibration of mice: unknowns, starting values and residuals.

What k mice saw of a run is fitted by one rigid motion a sample, given a guess of their mounts. Its integral, or the
pose it ends at, must be what was measured; what of the mice's totals it leaves over must be nothing.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike

from holodrive.calibration.mouse_runs import MouseRun
from holodrive.types import Array

COUNT = 0.5  # standard deviation of a total [counts]: a counter starts and ends anywhere inside a count
UNKNOWN_RAD, UNKNOWN_SCALE = 1.0, 0.5  # what is known before any run; a lever arm is within the footprint
TURNED = 0.5  # rad: runs that turn less tell nothing of lever arms


@dataclass(frozen=True)
class Problem:
    """Runs, and what is the same for all guesses.

    A guess is (yaw, log scale or scales, x, y) of each mouse, and the turns of the runs where the problem is blind.

    Attributes:
        runs: R of them.
        k: mice.
        width: numbers of a mouse, 4 or, with a scale for each axis, 5.
        blind: the mice cannot tell turns: a single one, or runs that hardly turn.
        sigma: (R, 2k) standard deviations of totals, mouse by mouse along its axes [m].
        begin: guess by linear least squares.
        whiten: of each run, for everything measured of it: (3, 3) that makes errors of one size and free of each other.
    """

    runs: tuple[MouseRun, ...]
    k: int
    width: int
    blind: bool
    sigma: Array
    begin: Array
    whiten: tuple[tuple[Array, ...], ...]

    def before(self, footprint_m: float) -> Array:
        """Standard deviations of a guess before any run."""
        one = [UNKNOWN_RAD, *[UNKNOWN_SCALE] * (self.width - 3), footprint_m, footprint_m]
        return np.array(one * self.k + ([UNKNOWN_RAD] * len(self.runs) if self.blind else []))

    def split(self, guess: Array) -> tuple[Array, Array, Array, Array]:
        """Angles (k,), scales (k, 2) [m], places (k, 2) [m], turns of the runs (R,) or () [rad]."""
        each = guess[: self.k * self.width].reshape(self.k, self.width)
        scales = np.exp(np.broadcast_to(each[:, 1:-2], (self.k, 2)))
        return each[:, 0], scales, each[:, -2:], guess[self.k * self.width :]

    def residuals(self, guess: Array) -> Array:
        """All residuals over their standard deviations, run by run."""
        return np.concatenate([self.of_run(guess, r)[0] for r in range(len(self.runs))])

    def of_run(self, guess: Array, r: int) -> tuple[Array, Array]:
        """Residuals of run r over their standard deviations, and those that are lengths, in metres (for people)."""
        moved, beside, _ = self.motion(guess, r)
        whitened, lengths = [beside / self.sigma[r]], [beside]
        for known, whiten in zip(self.runs[r].measured, self.whiten[r], strict=True):
            off = (moved.sum(axis=0) if known.what == "body" else end_of(moved)) - known.value
            whitened.append(whiten @ off)
            lengths.append(off[:2])
        return np.concatenate(whitened), np.concatenate(lengths)

    @property
    def freedom(self) -> int:
        """Residuals that are free of each other, less the unknowns: the motion of a run is fitted too."""
        rows = sum(2 * self.k + 3 * len(run.measured) - (2 if self.blind else 3) for run in self.runs)
        return max(rows - len(self.begin), 0)

    def motion(self, guess: Array, r: int) -> tuple[Array, Array, Array]:
        """Body motion (N, 3) of run r, what of the mice's totals it leaves over (2k,) [m], and (3, 2k) from ways to it.

        Fitted to what all mice saw, each by its noise; where the turns are unknowns, to them and the mice's mean way.
        """
        run = self.runs[r]
        phi, scales, places, turns = self.split(guess)
        ways = (run.counts * scales).reshape(len(run.counts), 2 * self.k)
        matrix, weight = _matrix(phi, places), 1.0 / self.sigma[r]
        if not self.blind:
            inverse = np.linalg.pinv(matrix * weight[:, None]) * weight
            moved = ways @ inverse.T
            return moved, ways.sum(axis=0) - matrix @ moved.sum(axis=0), inverse
        turn = _share(run) * turns[r]
        inverse = np.vstack([np.linalg.pinv(matrix[:, :2] * weight[:, None]) * weight, np.zeros(2 * self.k)])
        moved = (ways - np.outer(turn, matrix[:, 2])) @ inverse.T
        moved[:, 2] = turn
        return moved, ways.sum(axis=0) - matrix @ moved.sum(axis=0), inverse


def problem(
    runs: Sequence[MouseRun], nominal_m: float | ArrayLike, noise_relative: float | ArrayLike, per_axis: bool
) -> Problem:
    """The problem of some runs.

    Args:
        runs: that `mouse_runs.check` has passed.
        nominal_m: (k,) or one count by the data sheet [m], used where no straight run tells it.
        noise_relative: (k,) or one for all, as in `robots.spec.Mouse`.
        per_axis: a scale for each axis.
    """
    k = runs[0].counts.shape[1]
    pieces = sum(abs(run.turn_rad) for run in runs if run.kind == "track")  # turn little each, but all together
    turned = max([pieces, *(abs(run.turn_rad) for run in runs if run.kind != "track")])
    blind = k == 1 or turned < TURNED
    relative = np.broadcast_to(np.asarray(noise_relative, dtype=np.float64), (k,))
    nominal = np.broadcast_to(np.asarray(nominal_m, dtype=np.float64), (k,))
    begin, scale = _start(runs, nominal, 5 if per_axis else 4)
    if blind:
        begin = np.concatenate([begin, [run.turn_rad for run in runs]])
    noise = np.array([COUNT**2 + relative[:, None] ** 2 * run.squares.sum(axis=0) for run in runs])
    sigma = (np.sqrt(noise) * scale[:, None]).reshape(len(runs), 2 * k)
    bare = Problem(tuple(runs), k, 5 if per_axis else 4, blind, sigma, begin, ())
    return replace(bare, whiten=tuple(_whiten(bare, r, relative * scale, scale) for r in range(len(runs))))


def _whiten(bare: Problem, r: int, relative: Array, count_m: Array) -> tuple[Array, ...]:
    """For everything measured of run r: the errors of the measuring, and those that the mice's own noise adds.

    A mouse's noise turns the motion a little in every sample, and what follows with it: the end of a run carries all
    of that (A below), its integral in body axes does not.
    """
    run = bare.runs[r]
    moved, _, inverse = bare.motion(bare.begin, r)
    ways = (run.squares * relative[:, None] ** 2).reshape(len(run.squares), -1)  # (N, 2k) variances [m^2]
    counted = (inverse * np.repeat((COUNT * count_m) ** 2, 2)) @ inverse.T
    counted[:2, :2] = 0.5 * np.trace(counted[:2, :2]) * np.eye(2)  # a run may turn x into y
    counted[:2, 2] = counted[2, :2] = 0.0
    out = []
    for known in run.measured:
        carry = _carry(moved) if known.what == "end" else np.broadcast_to(np.eye(3), (len(moved), 3, 3))
        gain = carry @ inverse
        covariance = np.diag(known.sigma**2) + counted + np.einsum("nij,nj,nkj->ik", gain, ways, gain)
        out.append(np.asarray(np.linalg.inv(np.linalg.cholesky(covariance)), dtype=np.float64))
    return tuple(out)


def _carry(moved: Array) -> Array:
    """(N, 3, 3) from a change of each body motion to the change of the end pose."""
    heading = np.cumsum(moved[:, 2]) - 0.5 * moved[:, 2]
    c, s = np.cos(heading), np.sin(heading)
    place = np.cumsum(np.stack([c * moved[:, 0] - s * moved[:, 1], s * moved[:, 0] + c * moved[:, 1]], axis=-1), axis=0)
    ahead = place[-1] - place
    out = np.zeros((len(moved), 3, 3))
    out[:, 0, 0], out[:, 0, 1], out[:, 1, 0], out[:, 1, 1] = c, -s, s, c
    out[:, 0, 2], out[:, 1, 2], out[:, 2, 2] = -ahead[:, 1], ahead[:, 0], 1.0
    return out


def _start(runs: Sequence[MouseRun], nominal: Array, width: int) -> tuple[Array, Array]:
    """Linear least squares: s R(phi) c + turn (y, -x) = m is linear in (s cos phi, s sin phi, x, y)."""
    begin, scales = [], []
    for i, given in enumerate(nominal.tolist()):
        rows, right, phi, scale = [], [], 0.0, given
        for run in runs:
            mx, my, turn = run.measured[0].value
            cx, cy = run.total[i]
            rows += [[cx, -cy, 0.0, turn], [cy, cx, -turn, 0.0]]
            right += [mx, my]
        matrix = np.array(rows)
        if any(run.kind != "spin" for run in runs):
            a, b, x, y = np.linalg.lstsq(matrix, np.array(right), rcond=1e-9)[0]
            scale, phi = math.hypot(a, b), math.atan2(b, a)
        else:  # a spin alone: the lever arm as the data sheet's scale has it
            rest = np.array(right) - matrix[:, 0] * scale
            x, y = np.linalg.lstsq(matrix[:, 2:], rest, rcond=1e-9)[0]
        begin += [phi, *[math.log(scale)] * (width - 3), x, y]
        scales.append(scale)
    return np.array(begin), np.array(scales)


def _matrix(phi: Array, places: Array) -> Array:
    """(2k, 3) from a body motion to what the mice see of it, each in its own axes [m]."""
    c, s = np.cos(phi), np.sin(phi)
    matrix = np.empty((2 * len(phi), 3))
    matrix[0::2] = np.stack([c, s, s * places[:, 0] - c * places[:, 1]], axis=-1)
    matrix[1::2] = np.stack([-s, c, c * places[:, 0] + s * places[:, 1]], axis=-1)
    return matrix


def _share(run: MouseRun) -> Array:
    """(N,) which part of a run's turn fell into each sample, for mice that cannot tell: as the way did."""
    way = np.hypot(run.counts[..., 0], run.counts[..., 1]).sum(axis=1)
    total = way.sum()
    return np.asarray(way / total if total > 0.0 else np.full(len(way), 1.0 / len(way)))


def end_of(moved: Array) -> Array:
    """(3,) pose reached by (N, 3) body motions, each with an even twist: exact, the turn not wrapped."""
    heading = np.cumsum(moved[:, 2]) - 0.5 * moved[:, 2]
    chord = np.sinc(0.5 * moved[:, 2] / np.pi) * np.exp(1j * heading)
    place = np.sum(chord * (moved[:, 0] + 1j * moved[:, 1]))
    return np.array([place.real, place.imag, moved[:, 2].sum()])
