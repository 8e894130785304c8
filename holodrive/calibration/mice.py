"""Scale, mounting angle and lever arm of ground mice from a spin and two straight runs, and how well they are told.

The unknowns of mouse i are its angle phi, its scale (metres for a count) and its place (x, y) in `base_link`. They
are found by least squares over all runs at once: what the mice say of the run must agree with what tape, turns or a
track say, and the mice with each other (a rigid body has three freedoms, k mice tell 2k). Covariances follow from the
stated accuracies and from counts. See Sekimori and Miyazaki, "Precise dead-reckoning for mobile robots using multiple
optical mouse sensors", Informatics in Control, Automation and Robotics II, 2007, for the sensor equation.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from holodrive.calibration.mouse_notes import notes
from holodrive.calibration.mouse_runs import MouseRun, check
from holodrive.errors import InputError
from holodrive.geometry import wrap
from holodrive.types import Array, Pose

PARAMETERS = ("yaw", "scale", "x", "y")
PER_AXIS = ("yaw", "scale x", "scale y", "x", "y")
COUNT = 0.5  # standard deviation of a total [counts]: a counter starts and ends anywhere inside a count
_UNKNOWN_RAD, _UNKNOWN_SCALE = 1.0, 0.5  # what is known before any run; a lever arm is within the footprint
_TOLD = 0.05  # a parameter is told when its standard deviation is below this part of what was known before
_TURNED = 0.5  # rad: runs that turn less tell nothing of lever arms
_CONTRADICTION = 0.02  # of the way: mice that disagree more have not rolled on the same floor
_UNLIKELY = 1e-3  # of chance, below which stated accuracies are taken for too small


class Excitation(NamedTuple):
    """What one run adds to one parameter.

    Attributes:
        run: its name.
        share: of the parameter's variance that comes from this run's errors, 0 to 1: how much of it the run tells.
        needed: without this run the parameter would not be told.
    """

    run: str
    share: float
    needed: bool


@dataclass(frozen=True)
class Parameter:
    """One number of one mouse.

    Attributes:
        mouse, name: "yaw" [rad], "scale" [m per count], "x" or "y" [m]; "scale x" and "scale y" when asked for both.
        value: found.
        sigma: standard deviation, in the same unit.
        told: False when the runs do not tell it; the value then means nothing.
        excited_by: runs with the most information first.
    """

    mouse: str
    name: str
    value: float
    sigma: float
    told: bool
    excited_by: tuple[Excitation, ...]


@dataclass(frozen=True)
class MiceCalibration:
    """What the runs say of k mice.

    Attributes:
        mice: names.
        mounts: (k) in `base_link`.
        scales_m: (k, 2) metres for a count along each of the mouse's axes; the same unless asked apart.
        parameters: all numbers, mouse by mouse.
        covariance: (p, p) of the parameters, scales relative (of their logarithm).
        condition: of the whitened problem, lengths in footprints; infinite when something is not told at all.
        chi2, freedom: sum of squared residuals over their accuracies, and how many are free.
        widened: factor that the standard deviations were multiplied with because the runs contradict each other more
            than the accuracies allow; 1 as a rule.
        worst: the run that fits least, and by how much [m].
        notes: what is not told and what would tell it, and other things worth knowing.
    """

    mice: tuple[str, ...]
    mounts: tuple[Pose, ...]
    scales_m: Array
    parameters: tuple[Parameter, ...]
    covariance: Array
    condition: float
    chi2: float
    freedom: int
    widened: float
    worst: tuple[str, float]
    notes: tuple[str, ...]

    def parameter(self, mouse: str, name: str) -> Parameter:
        """One number by the names of mouse and parameter."""
        return next(each for each in self.parameters if (each.mouse, each.name) == (mouse, name))

    @property
    def complete(self) -> bool:
        """Whether all parameters are told."""
        return all(parameter.told for parameter in self.parameters)


@dataclass(frozen=True)
class _Problem:
    """Runs and what is the same for all guesses.

    `blind` means that the mice cannot tell turns (a single one, or runs that do not turn): then each run's turn is an
    unknown beside the parameters. `weight` (k,) is 1 over the noise of a total, relative to the other mice.
    """

    runs: tuple[MouseRun, ...]
    k: int
    width: int  # parameters of a mouse
    blind: bool
    noise: Array  # (R, k) of totals [counts]
    start_scale: Array  # (k,)


def calibrate(
    runs: Sequence[MouseRun],
    mice: Sequence[str],
    footprint_m: float,
    *,
    nominal_m: float | ArrayLike = 1e-5,
    noise_relative: float | ArrayLike = 0.0,
    per_axis: bool = False,
) -> MiceCalibration:
    """Find the mounts and scales of mice.

    Args:
        runs: at best a spin that ends near a half turn, and straight runs ahead and to the left.
        mice: names, in the order of the runs' columns.
        footprint_m: radius of the robot; nothing outside of it can be a lever arm.
        nominal_m: one count by the data sheet [m], where no straight run tells it.
        noise_relative: of the mice, as in `robots.spec.Mouse`.
        per_axis: tell the scales of a mouse's two axes apart.

    Raises:
        InputError: runs that no fit can use, mice that contradict each other, or that come out beyond the footprint.
    """
    from scipy.optimize import least_squares

    check(runs, mice)
    k = len(mice)
    problem = _problem(runs, k, nominal_m, noise_relative, per_axis)
    begin = _start(problem)
    before = _before(problem, footprint_m)

    def residuals(guess: Array) -> Array:
        return np.concatenate([_rows(problem, guess), (guess - begin) / before])

    fit = least_squares(residuals, begin, jac="3-point", x_scale=before, method="trf", xtol=1e-14, ftol=1e-14)
    found = fit.x
    jacobian = fit.jac[: -len(found)]
    result = _result(problem, mice, found, jacobian, before)
    _plausible(result, problem, footprint_m, found)
    return result


def _problem(
    runs: Sequence[MouseRun], k: int, nominal_m: float | ArrayLike, noise_relative: float | ArrayLike, per_axis: bool
) -> _Problem:
    pieces = [abs(run.turn_rad) for run in runs if run.kind == "track"]  # turn little each, but all together
    turned = max([sum(pieces), *(abs(run.turn_rad) for run in runs if run.kind != "track")])
    relative = np.broadcast_to(np.asarray(noise_relative, dtype=np.float64), (k,))
    noise = np.sqrt(COUNT**2 + np.array([relative**2 * run.square for run in runs]))
    scale = np.array(np.broadcast_to(np.asarray(nominal_m, dtype=np.float64), (k,)))
    return _Problem(tuple(runs), k, 5 if per_axis else 4, k == 1 or turned < _TURNED, noise, scale)


def _start(problem: _Problem) -> Array:
    """Linear least squares: s R(phi) c + turn (y, -x) = m is linear in (s cos phi, s sin phi, x, y)."""
    straights = [run for run in problem.runs if run.kind != "spin"]
    begin = []
    for i in range(problem.k):
        rows, right = [], []
        for run in problem.runs:
            mx, my, turn = run.measured[0].value
            cx, cy = run.total[i]
            rows += [[cx, -cy, 0.0, turn], [cy, cx, -turn, 0.0]]
            right += [mx, my]
        matrix = np.array(rows)
        scale, phi = problem.start_scale[i], 0.0
        a, b, x, y = np.linalg.lstsq(matrix, np.array(right), rcond=1e-9)[0] if straights else (0.0, 0.0, 0.0, 0.0)
        if math.hypot(a, b) > 0.0:
            scale, phi = math.hypot(a, b), math.atan2(b, a)
        else:  # a spin alone: the lever arm as the data sheet's scale has it
            rest = np.array(right) - matrix[:, :2] @ [scale, 0.0]
            x, y = np.linalg.lstsq(matrix[:, 2:], rest, rcond=1e-9)[0]
        problem.start_scale[i] = scale
        begin += [phi, *[math.log(scale)] * (problem.width - 3), x, y]
    if problem.blind:
        begin += [run.turn_rad for run in problem.runs]
    return np.array(begin)


def _before(problem: _Problem, footprint_m: float) -> Array:
    one = [_UNKNOWN_RAD, *[_UNKNOWN_SCALE] * (problem.width - 3), footprint_m, footprint_m]
    return np.array(one * problem.k + ([_UNKNOWN_RAD] * len(problem.runs) if problem.blind else []))


def _split(problem: _Problem, guess: Array) -> tuple[Array, Array, Array, Array]:
    """Angles (k,), scales (k, 2) [m], places (k, 2) [m], turns of the runs (R,) or () [rad]."""
    each = guess[: problem.k * problem.width].reshape(problem.k, problem.width)
    scales = np.exp(np.broadcast_to(each[:, 1:-2], (problem.k, 2)))
    return each[:, 0], scales, each[:, -2:], guess[problem.k * problem.width :]


def _rows(problem: _Problem, guess: Array) -> Array:
    """All residuals over their standard deviations, run by run."""
    return np.concatenate([_rows_of(problem, guess, r)[0] for r in range(len(problem.runs))])


def _rows_of(problem: _Problem, guess: Array, r: int) -> tuple[Array, Array]:
    """Residuals of run r over their standard deviations, and those that are lengths, in metres (for people)."""
    run = problem.runs[r]
    phi, scales, places, turns = _split(problem, guess)
    c, s = np.cos(phi), np.sin(phi)
    along, across = run.counts[..., 0] * scales[:, 0], run.counts[..., 1] * scales[:, 1]
    seen = np.stack([c * along - s * across, s * along + c * across], axis=-1)  # (N, k, 2) body axes
    sigma = problem.noise[r] * problem.start_scale
    if problem.blind:
        moved, beside = _translation(seen, places, sigma, _share(run) * turns[r])
    else:
        moved, beside = _rigid(seen, places, sigma)
    whitened, lengths = [(beside / sigma[:, None]).ravel()], [beside.ravel()]
    for known in run.measured:
        off = (moved.sum(axis=0) if known.what == "body" else _end(moved)) - known.value
        there = np.isfinite(known.value)
        whitened.append((off / known.sigma)[there])
        lengths.append(off[:2][there[:2]])
    return np.concatenate(whitened), np.concatenate(lengths)


def _rigid(seen: Array, places: Array, sigma: Array) -> tuple[Array, Array]:
    """(N, 3) body motion that fits best what all mice saw, and (k, 2) what of their totals it does not explain."""
    k = len(places)
    matrix = np.zeros((2 * k, 3))
    matrix[0::2, 0] = matrix[1::2, 1] = 1.0
    matrix[0::2, 2], matrix[1::2, 2] = -places[:, 1], places[:, 0]
    weight = np.repeat(1.0 / sigma, 2)
    inverse = np.linalg.pinv(matrix * weight[:, None]) * weight
    moved = seen.reshape(len(seen), 2 * k) @ inverse.T
    return moved, seen.sum(axis=0) - (matrix @ moved.sum(axis=0)).reshape(k, 2)


def _translation(seen: Array, places: Array, sigma: Array, turns: Array) -> tuple[Array, Array]:
    """The same where the turns (N,) of the samples are given."""
    lever = np.stack([-places[:, 1], places[:, 0]], axis=-1)
    centre = seen - turns[:, None, None] * lever
    share = sigma**-2 / np.sum(sigma**-2)
    moved = np.einsum("k,nkj->nj", share, centre)
    return np.column_stack([moved, turns]), centre.sum(axis=0) - moved.sum(axis=0)


def _share(run: MouseRun) -> Array:
    """(N,) which part of a run's turn fell into each sample, for mice that cannot tell: as the way did."""
    way = np.hypot(run.counts[..., 0], run.counts[..., 1]).sum(axis=1)
    total = way.sum()
    return np.asarray(way / total if total > 0.0 else np.full(len(way), 1.0 / len(way)))


def _end(moved: Array) -> Array:
    """(3,) pose reached by (N, 3) body motions, each with an even twist: exact, the turn not wrapped."""
    heading = np.cumsum(moved[:, 2]) - 0.5 * moved[:, 2]
    chord = np.sinc(0.5 * moved[:, 2] / np.pi) * np.exp(1j * heading)
    place = np.sum(chord * (moved[:, 0] + 1j * moved[:, 1]))
    return np.array([place.real, place.imag, moved[:, 2].sum()])


def _result(problem: _Problem, mice: Sequence[str], found: Array, jacobian: Array, before: Array) -> MiceCalibration:
    """Estimates with their standard deviations, and which run tells what."""
    from scipy.stats import chi2 as chi_square

    residual = _rows(problem, found)
    freedom = _freedom(problem, len(residual), len(found))
    chi2 = float(residual @ residual)
    unlikely = freedom > 0 and chi_square.sf(chi2, freedom) < _UNLIKELY
    widened = math.sqrt(chi2 / freedom) if unlikely else 1.0
    blocks = _blocks(problem, found, jacobian)
    total = jacobian.T @ jacobian + np.diag(before**-2.0)
    covariance = np.asarray(np.linalg.inv(total) * widened**2, dtype=np.float64)
    parameters = _parameters(problem, mice, found, blocks, total, covariance, before)
    phi, scales, places, _ = _split(problem, found)
    singular = np.linalg.svd(jacobian * before, compute_uv=False)
    lost = len(singular) < len(found) or singular[-1] < 1e-10 * singular[0]
    count = problem.k * problem.width
    return MiceCalibration(
        mice=tuple(mice),
        mounts=tuple(Pose(float(x), float(y), float(wrap(a))) for a, (x, y) in zip(phi, places, strict=True)),
        scales_m=scales.copy(),
        parameters=parameters,
        covariance=covariance[:count, :count],
        condition=math.inf if lost else float(singular[0] / singular[-1]),
        chi2=chi2,
        freedom=freedom,
        widened=widened,
        worst=_worst(problem, found),
        notes=notes(parameters, problem.runs, freedom, widened),
    )


def _blocks(problem: _Problem, found: Array, jacobian: Array) -> dict[str, Array]:
    """Rows of the Jacobian by the name of the run that they are of."""
    sizes = [len(_rows_of(problem, found, r)[0]) for r in range(len(problem.runs))]
    rows: dict[str, list[Array]] = {}
    for run, block in zip(problem.runs, np.split(jacobian, np.cumsum(sizes)[:-1]), strict=True):
        rows.setdefault(run.name, []).append(block)
    return {name: np.concatenate(each) for name, each in rows.items()}


def _parameters(
    problem: _Problem,
    mice: Sequence[str],
    found: Array,
    blocks: dict[str, Array],
    total: Array,
    covariance: Array,
    before: Array,
) -> tuple[Parameter, ...]:
    """The numbers one by one, each with the runs that tell it."""
    # the estimate is covariance J' times the runs' errors: their parts of its variance say whence it comes
    parts = {run: np.sum((covariance @ rows.T) ** 2, axis=1) for run, rows in blocks.items()}
    whole = sum(parts.values())
    without = {run: np.diag(np.linalg.inv(total - rows.T @ rows)) for run, rows in blocks.items()}
    names = PER_AXIS if problem.width == 5 else PARAMETERS
    out = []
    for j in range(problem.k * problem.width):
        name, value, sigma = names[j % problem.width], float(found[j]), math.sqrt(covariance[j, j])
        told = bool(sigma <= _TOLD * before[j])
        excited = [
            Excitation(run, float(part[j] / whole[j]), told and bool(without[run][j] > (_TOLD * before[j]) ** 2))
            for run, part in parts.items()
            if part[j] > 0.0
        ]
        if name == "yaw":
            value = float(wrap(value))
        elif name.startswith("scale"):
            value = math.exp(value)
            sigma *= value
        order = sorted(excited, key=lambda each: -each.share)
        out.append(Parameter(mice[j // problem.width], name, value, sigma, told, tuple(order)))
    return tuple(out)


def _freedom(problem: _Problem, rows: int, unknowns: int) -> int:
    """Rows that are free of each other, less the unknowns; what mice agree about in the fit of a run is no test."""
    fitted = 2 if problem.blind else 3
    return max(rows - fitted * len(problem.runs) - unknowns, 0)


def _worst(problem: _Problem, found: Array) -> tuple[str, float]:
    off = [(run.name, float(np.abs(_rows_of(problem, found, r)[1]).max())) for r, run in enumerate(problem.runs)]
    return max(off, key=lambda each: each[1])


def _plausible(result: MiceCalibration, problem: _Problem, footprint_m: float, found: Array) -> None:
    """Refuse what no robot can be."""
    for r, run in enumerate(problem.runs):
        lengths = _rows_of(problem, found, r)[1]
        way = float(np.max(run.way * problem.start_scale))
        off = float(np.abs(lengths).max())
        if run.kind != "track" and off > max(_CONTRADICTION * way, 10.0 * float(np.max(run.measured[0].sigma[:2]))):
            raise InputError(
                f"run {run.name!r} contradicts the others by {1e3 * off:.3g} mm on {1e3 * way:.4g} mm: a mouse lifted "
                "off or dead for a part of it, a wrong length, or a wrong number of turns? Nothing is taken over"
            )
    for name, mount in zip(result.mice, result.mounts, strict=True):
        told = result.parameter(name, "x").told and result.parameter(name, "y").told
        far = math.hypot(mount.x, mount.y)
        if told and far > footprint_m:
            raise InputError(
                f"mouse {name} comes out {far:.3g} m from the robot's centre, outside its footprint of "
                f"{footprint_m:g} m: a wrong number of turns, a wrong length, or counts of another robot? "
                "Nothing is taken over"
            )


def as_dict(result: MiceCalibration) -> dict[str, Any]:
    """For machines: SI and radians."""
    return {
        "mice": {
            name: {
                "mount": {"x_m": mount.x, "y_m": mount.y, "yaw_rad": mount.theta},
                "resolution_m": resolution(scales),
                "scales_m": scales,
            }
            for name, mount, scales in zip(result.mice, result.mounts, result.scales_m, strict=True)
        },
        "parameters": [
            {
                "mouse": each.mouse,
                "parameter": each.name,
                "value": each.value,
                "sigma": each.sigma,
                "told": each.told,
                "excited_by": [excitation._asdict() for excitation in each.excited_by],
            }
            for each in result.parameters
        ],
        "condition": result.condition,
        "chi2": result.chi2,
        "freedom": result.freedom,
        "widened": result.widened,
        "worst": {"run": result.worst[0], "off_m": result.worst[1]},
        "notes": list(result.notes),
    }


def resolution(scales: ArrayLike) -> float:
    """One count [m] of a mouse whose axes may differ: their geometric mean."""
    x, y = np.asarray(scales, dtype=np.float64)
    return float(math.sqrt(x * y))
