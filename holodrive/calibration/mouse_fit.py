"""The least squares behind a calibration of mice: unknowns, starting values and residuals.

What k mice saw of a run, turned into body axes by a guess of their mounts, is fitted by one rigid motion a sample. Its
integral, or the pose it ends at, must be what was measured; what of the mice's totals it leaves over must be nothing.
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
        noise: (R, k) standard deviation of totals [counts].
        scale: (k,) about what a count is [m].
        begin: guess by linear least squares.
        spread: (R, 3) variance of a run's motion that comes of the mice's noise [m^2, m^2, rad^2].
    """

    runs: tuple[MouseRun, ...]
    k: int
    width: int
    blind: bool
    noise: Array
    scale: Array
    begin: Array
    spread: Array

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
        run = self.runs[r]
        moved, beside = self._motion(guess, r)
        sigma = self.noise[r] * self.scale
        whitened, lengths = [(beside / sigma[:, None]).ravel()], [beside.ravel()]
        for known in run.measured:
            off = (moved.sum(axis=0) if known.what == "body" else end_of(moved)) - known.value
            whitened.append(off / np.sqrt(known.sigma**2 + self.spread[r]))
            lengths.append(off[:2])
        return np.concatenate(whitened), np.concatenate(lengths)

    @property
    def freedom(self) -> int:
        """Residuals that are free of each other, less the unknowns: the motion of a run is fitted too."""
        rows = sum(2 * self.k + 3 * len(run.measured) - (2 if self.blind else 3) for run in self.runs)
        return max(rows - len(self.begin), 0)

    def _motion(self, guess: Array, r: int) -> tuple[Array, Array]:
        """(N, 3) body motion of run r, and (k, 2) what of the mice's totals it leaves over [m]."""
        run = self.runs[r]
        phi, scales, places, turns = self.split(guess)
        c, s = np.cos(phi), np.sin(phi)
        along, across = run.counts[..., 0] * scales[:, 0], run.counts[..., 1] * scales[:, 1]
        seen = np.stack([c * along - s * across, s * along + c * across], axis=-1)  # (N, k, 2) body axes
        sigma = self.noise[r] * self.scale
        if self.blind:
            return _translation(seen, places, sigma, _share(run) * turns[r])
        return _rigid(seen, places, sigma)


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
    noise = np.sqrt(COUNT**2 + np.array([relative**2 * run.square for run in runs]))
    nominal = np.broadcast_to(np.asarray(nominal_m, dtype=np.float64), (k,))
    begin, scale = _start(runs, nominal, 5 if per_axis else 4)
    if blind:
        begin = np.concatenate([begin, [run.turn_rad for run in runs]])
    bare = Problem(tuple(runs), k, 5 if per_axis else 4, blind, noise, scale, begin, np.zeros((len(runs), 3)))
    places = bare.split(begin)[2]
    return replace(bare, spread=np.array([_spread(places, each * scale, blind) for each in noise]))


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


def _matrix(places: Array) -> Array:
    """(2k, 3) from a body motion to what mice see of it, in body axes."""
    matrix = np.zeros((2 * len(places), 3))
    matrix[0::2, 0] = matrix[1::2, 1] = 1.0
    matrix[0::2, 2], matrix[1::2, 2] = -places[:, 1], places[:, 0]
    return matrix


def _rigid(seen: Array, places: Array, sigma: Array) -> tuple[Array, Array]:
    """(N, 3) body motion that fits best what all mice saw, and (k, 2) what of their totals it leaves over."""
    k = len(places)
    matrix, weight = _matrix(places), np.repeat(1.0 / sigma, 2)
    inverse = np.linalg.pinv(matrix * weight[:, None]) * weight
    moved = seen.reshape(len(seen), 2 * k) @ inverse.T
    return moved, seen.sum(axis=0) - (matrix @ moved.sum(axis=0)).reshape(k, 2)


def _translation(seen: Array, places: Array, sigma: Array, turns: Array) -> tuple[Array, Array]:
    """The same where the turns (N,) of the samples are given."""
    lever = np.stack([-places[:, 1], places[:, 0]], axis=-1)
    centre = seen - turns[:, None, None] * lever
    moved = np.einsum("k,nkj->nj", sigma**-2 / np.sum(sigma**-2), centre)
    return np.column_stack([moved, turns]), centre.sum(axis=0) - moved.sum(axis=0)


def _spread(places: Array, sigma: Array, blind: bool) -> Array:
    """(3,) variance of the motion that comes of the mice; x and y alike, since a run may turn one into the other."""
    if blind:
        return np.array([*[1.0 / np.sum(sigma**-2)] * 2, 0.0])
    weighted = _matrix(places) / np.repeat(sigma, 2)[:, None]
    x, y, turn = np.diag(np.linalg.pinv(weighted.T @ weighted))
    return np.array([0.5 * (x + y), 0.5 * (x + y), turn])


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
