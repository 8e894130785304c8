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

from holodrive.calibration import mouse_fit
from holodrive.calibration.mouse_fit import Problem
from holodrive.calibration.mouse_notes import notes
from holodrive.calibration.mouse_runs import MouseRun, check
from holodrive.errors import InputError
from holodrive.geometry import wrap
from holodrive.types import Array, Pose

PARAMETERS = ("yaw", "scale", "x", "y")
PER_AXIS = ("yaw", "scale x", "scale y", "x", "y")
_TOLD = 0.05  # a parameter is told when its standard deviation is below this part of what was known before
_CONTRADICTION = 30.0  # times the accuracies: no tape is that bad, some run is not what it is said to be
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
    problem = mouse_fit.problem(runs, nominal_m, noise_relative, per_axis)
    before = problem.before(footprint_m)

    def residuals(guess: Array) -> Array:
        # what is known before, weak as it is, keeps numbers that no run tells where they began
        return np.concatenate([problem.residuals(guess), (guess - problem.begin) / before])

    fit = least_squares(residuals, problem.begin, jac="3-point", x_scale=before, xtol=1e-14, ftol=1e-14)
    found, jacobian = fit.x, fit.jac[: -len(fit.x)]
    result = _result(problem, mice, found, jacobian, before)
    _plausible(result, footprint_m)
    return result


def _result(problem: Problem, mice: Sequence[str], found: Array, jacobian: Array, before: Array) -> MiceCalibration:
    """Estimates with their standard deviations, and which run tells what."""
    from scipy.stats import chi2 as chi_square

    residual = problem.residuals(found)
    freedom = problem.freedom
    chi2 = float(residual @ residual)
    unlikely = freedom > 0 and chi_square.sf(chi2, freedom) < _UNLIKELY
    widened = math.sqrt(chi2 / freedom) if unlikely else 1.0
    blocks = _blocks(problem, found, jacobian)
    total = jacobian.T @ jacobian + np.diag(before**-2.0)
    covariance = np.asarray(np.linalg.inv(total) * widened**2, dtype=np.float64)
    parameters = _parameters(problem, mice, found, blocks, total, covariance, before)
    phi, scales, places, _ = problem.split(found)
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


def _blocks(problem: Problem, found: Array, jacobian: Array) -> dict[str, Array]:
    """Rows of the Jacobian by the name of the run that they are of."""
    sizes = [len(problem.of_run(found, r)[0]) for r in range(len(problem.runs))]
    rows: dict[str, list[Array]] = {}
    for run, block in zip(problem.runs, np.split(jacobian, np.cumsum(sizes)[:-1]), strict=True):
        rows.setdefault(run.name, []).append(block)
    return {name: np.concatenate(each) for name, each in rows.items()}


def _parameters(
    problem: Problem,
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


def _worst(problem: Problem, found: Array) -> tuple[str, float]:
    off = [(run.name, float(np.abs(problem.of_run(found, r)[1]).max())) for r, run in enumerate(problem.runs)]
    return max(off, key=lambda each: each[1])


def _plausible(result: MiceCalibration, footprint_m: float) -> None:
    """Refuse what no robot can be."""
    run, off = result.worst
    if result.widened > _CONTRADICTION:
        raise InputError(
            f"the runs contradict each other {result.widened:.3g} times more than the accuracies allow, run {run!r} by "
            f"{1e3 * off:.3g} mm: a mouse lifted off or dead for a part of one, a wrong length or number of turns? "
            "Nothing is taken over"
        )
    for name, mount in zip(result.mice, result.mounts, strict=True):
        far = math.hypot(mount.x, mount.y)
        sigma = max(result.parameter(name, "x").sigma, result.parameter(name, "y").sigma)
        if far > footprint_m + 3.0 * sigma:
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
