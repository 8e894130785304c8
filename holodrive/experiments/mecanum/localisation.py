"""Equations 1 to 7: dead reckoning with two ball mice as printed, as it must be meant, and as a rigid body moves.

Frames are the paper's: x to the right and y ahead, headings clockwise from +y. Mouse 1 is in the robot's centre, mouse
2 at a distance D ahead of it; D is not printed.
"""

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np

from holodrive.estimation import mouse_odometry, mouse_recursion
from holodrive.experiments.claims import Claim
from holodrive.experiments.experiment import Result, Setting
from holodrive.experiments.mecanum import printed
from holodrive.reports.plots import Chart, Line
from holodrive.reports.sections import ChartSection, TableSection
from holodrive.reports.tables import Table
from holodrive.types import Array, Pose

BASELINE_M = 0.1  # assumed
MOTIONS, DURATION_S = 20, 30.0
SPEED_M_S, YAW_RATE_RAD_S = 0.02, 0.2  # standard deviations of the motions
CORRELATION_S = 0.5  # over which they change
_LEAST_S = 1e-3 * printed.MOUSE_PERIOD_MS
_CASES = ((1e-3 * printed.CONTROL_PERIOD_MS, 0.0), (_LEAST_S, 0.0), (_LEAST_S, 1e-6 * printed.MOUSE_RESOLUTION_UM))


@dataclass(frozen=True)
class Motion:
    """A random motion and what the two mice count in it.

    Attributes:
        increments: (N, 4) x1, y1, x2, y2 of each sample, own axes of the mice [m].
        pose: (N + 1, 3) true x, y and clockwise heading [m, m, rad].
    """

    increments: Array
    pose: Array


def localisation(setting: Setting) -> Result:
    """Claims about equations 1 to 7."""
    motions = [motion(seed, _LEAST_S) for seed in range(MOTIONS)]
    counted = [counts(m.increments, 1e-6 * printed.MOUSE_RESOLUTION_UM) for m in motions]
    ends = {case: _ends(*case) for case in _CASES}
    claims = (
        _heading(),
        *_sign_rule(motions, ends[_CASES[0]]),
        *_zero_case(counted),
        _constraints(motions),
        _short_form(motions),
        _growing(ends[_CASES[0]]),
        _rigid(ends[_CASES[2]]),
    )
    data = {
        f"{1e3 * dt:g} ms, counts of {1e6 * step:g} um": {name: list(value) for name, value in found.items()}
        for (dt, step), found in ends.items()
    }
    return Result(claims, (_table(ends), _charts(motions[0])), data)


def motion(seed: int, dt_s: float, baseline_m: float = BASELINE_M) -> Motion:
    """A random motion with a twist that is constant within each sample."""
    n = round(DURATION_S / dt_s)
    noise = np.random.default_rng(seed).normal(size=(round(DURATION_S / _LEAST_S), 3))
    keep = math.exp(-_LEAST_S / CORRELATION_S)
    twist = np.empty_like(noise)
    state = np.zeros(3)
    for k, draw in enumerate(noise):  # the same course at every sampling time
        state = keep * state + math.sqrt(1.0 - keep * keep) * draw
        twist[k] = state
    every = twist[:: len(twist) // n][:n] * (SPEED_M_S, SPEED_M_S, YAW_RATE_RAD_S) * dt_s
    x, y, turn = every.T
    return Motion(np.column_stack([x, y, x + baseline_m * turn, y]), _exact(every))


def counts(increments: Array, resolution_m: float) -> Array:
    """What counters of that resolution tell of increments (N, 4); the rest is carried on."""
    if resolution_m == 0.0:
        return increments
    whole = np.floor(np.cumsum(increments, axis=0) / resolution_m + 0.5)
    return np.diff(whole, axis=0, prepend=0.0) * resolution_m


def rigid(increments: Array, baseline_m: float) -> Array:
    """Poses (N + 1, 3) of the rigid body, by this software's odometry, in the paper's frame."""
    mounts = (Pose(0.0, 0.0, -0.5 * math.pi), Pose(baseline_m, 0.0, -0.5 * math.pi))  # mouse axes: right and ahead
    found = mouse_odometry.track(mounts, increments.reshape(-1, 2, 2), Pose(0.0, 0.0, 0.5 * math.pi)).pose
    return np.column_stack([found[:, 0], found[:, 1], 0.5 * math.pi - found[:, 2]])


FORMS: Mapping[str, Callable[[Array, float], Array]] = {
    "as printed": mouse_recursion.printed,
    "corrected": mouse_recursion.corrected,
    "rigid body": rigid,
}


def _exact(ways: Array) -> Array:
    """Poses (N + 1, 3) of a body that goes (x, y, clockwise turn) (N, 3) in its own frame, sample by sample."""
    x, y, turn = ways.T
    heading = np.concatenate([[0.0], np.cumsum(turn)])
    middle = heading[:-1] + 0.5 * turn
    chord = np.sinc(0.5 * turn / math.pi)  # arc to chord
    steps = chord[:, None] * np.column_stack(
        [np.cos(middle) * x + np.sin(middle) * y, -np.sin(middle) * x + np.cos(middle) * y]
    )
    return np.column_stack([np.vstack([np.zeros(2), np.cumsum(steps, axis=0)]), heading])


def _ends(dt_s: float, resolution_m: float) -> dict[str, tuple[float, float]]:
    """Median end error of each form over all motions [m, rad]."""
    errors: dict[str, list[tuple[float, float]]] = {name: [] for name in FORMS}
    for seed in range(MOTIONS):
        one = motion(seed, dt_s)
        ways = counts(one.increments, resolution_m)
        for name, form in FORMS.items():
            last, true = form(ways, BASELINE_M)[-1], one.pose[-1]
            good = bool(np.isfinite(last).all())  # one that is undefined counts among the worst
            error = (math.hypot(*(last - true)[:2]), abs(_wrapped(last[2] - true[2])))
            errors[name].append(error if good else (math.inf, math.inf))
    return {name: tuple(np.median(found, axis=0).tolist()) for name, found in errors.items()}


def _heading() -> Claim:
    angles = np.radians(np.arange(-180.0, 180.0, 0.5))
    pairs = [(float(x), float(y)) for x, y in zip(np.sin(angles), np.cos(angles), strict=True)]
    pairs += [(0.0, 1.0), (0.0, -1.0)]
    off = [mouse_recursion.heading(x, y) - math.atan2(x, y) for x, y in pairs]
    worst = max(abs(_wrapped(value)) for value in off)
    return Claim("Eq. 7", "heading", "four cases", "atan2(x_diff, y_diff)", "agrees" if worst < 1e-12 else "differs",
                 note="clockwise from +y, in [−180°, 180°)")  # fmt: skip


def _sign_rule(motions: list[Motion], ends: dict[str, tuple[float, float]]) -> list[Claim]:
    """The sign in equation 3: of the mouse's own way, or of mouse 1's."""
    ways = np.vstack([m.increments for m in motions])
    differ = float(np.mean(ways[:, 0] * ways[:, 2] < 0.0))
    said, right = ends["as printed"], ends["corrected"]
    return [
        Claim("Eq. 2, 3", "sign ± for mouse m", "+ if x₁ > 0", "+ if x_m > 0", "contradicts itself",
              note=f"Eq. 2 is for x_m > 0; the two mice have different signs in {100 * differ:.0f} % of the samples of "
              f"{MOTIONS} random motions"),
        Claim("Eq. 3", f"heading after {DURATION_S:g} s with the sign of x₁", None,
              f"{math.degrees(said[1]):.1f}° off", "not printed",
              note=f"with the sign of each mouse's own x {math.degrees(right[1]):.2f}°; medians, D = "
              f"{1e3 * BASELINE_M:g} mm, {printed.CONTROL_PERIOD_MS:g} ms"),
    ]  # fmt: skip


def _zero_case(counted: list[Array]) -> list[Claim]:
    """'Else, if x_1 = 0 ... y is equal to (x of the step before + y_m)'."""
    aside, ahead = 0.1, 0.001
    ways = np.array([[aside, 0.0, aside, 0.0], [0.0, ahead, 0.0, ahead]])
    said, right = (form(ways, BASELINE_M)[-1, 1] for form in (mouse_recursion.printed, mouse_recursion.corrected))
    share = float(np.mean(np.vstack(counted)[:, 0] == 0.0))
    first = mouse_recursion.printed(np.array([[0.0, ahead, 0.0, ahead]]), BASELINE_M)[-1, 2]
    undefined = sum(not np.isfinite(mouse_recursion.printed(ways, BASELINE_M)).all() for ways in counted)
    return [
        Claim("text on Eq. 3", "y after 100 mm to the right and 1 mm ahead", 1e3 * float(said), 1e3 * float(right),
              "cannot be", "mm",
              "the case x₁ = 0 has x of the step before where y must be, and forgets the heading; "
              f"x₁ = 0 in {100 * share:.0f} % of the samples in counts of {printed.MOUSE_RESOLUTION_UM:g} µm at "
              f"{printed.MOUSE_PERIOD_MS:g} ms"),
        Claim("text on Eq. 3, 7", "heading after the first sample, straight ahead", None,
              _shown(float(first), 0, "0/0"), "cannot be",
              note="in the case x₁ = 0 as printed both points, which have the same x, come to lie on one another; "
              f"{undefined} of {len(counted)} motions end so, in counts"),
    ]  # fmt: skip


def _constraints(motions: list[Motion]) -> Claim:
    """'x_1 + D is always equal to x_2': then equation 7 begins at 90 degrees."""
    ways = np.vstack([m.increments for m in motions])
    slack = float(np.max(np.abs(ways[:, 1] - ways[:, 3])))
    return Claim(
        "text on Fig. 2, Eq. 7", "heading at the start, mice at x₁ + D = x₂", "0°",
        f"{math.degrees(mouse_recursion.heading(BASELINE_M, 0.0)):g}°", "contradicts itself",
        note="the line through the mice must point ahead: then y₂ = y₁ and x₂ − x₁ = D times the turn (difference of y "
        f"at most {1e3 * slack:g} mm in the motions), and y₂ ≠ y₁ tells that a ball has slipped",
    )  # fmt: skip


def _short_form(motions: list[Motion]) -> Claim:
    rng = np.random.default_rng(0)
    cases = [m.increments for m in motions] + [1e-3 * rng.normal(size=(300, 4))]
    worst = 0.0
    for ways in cases:
        long, short = (form(ways, BASELINE_M) for form in (mouse_recursion.corrected, mouse_recursion.closed_form))
        worst = max(worst, float(np.max(np.abs(_apart(long, short)))))
    return Claim(
        "Eq. 1 to 7", "as one step", "seven equations", "three lines", "agrees" if worst < 1e-10 else "differs",
        note="p += Rot(−α)(x₁, y₁), α += atan2(Δx, L + Δy), L = √(Δx² + (L + Δy)²), L = D at the start; equal to the "
        f"corrected equations within {worst:.0e} m and rad",
    )  # fmt: skip


def _growing(ends: dict[str, tuple[float, float]]) -> Claim:
    """The distance between the two points that equation 3 carries grows; nothing holds it at D."""
    ways = [motion(seed, _CASES[0][0]).increments for seed in range(MOTIONS)]
    lengths = [math.sqrt(BASELINE_M**2 + float(np.sum((w[:, 2] - w[:, 0]) ** 2))) for w in ways]
    error, turn = ends["corrected"]
    return Claim(
        "Eq. 3, 5 to 7", f"distance of the two points after {DURATION_S:g} s", 1e3 * BASELINE_M,
        1e3 * float(np.median(lengths)), "contradicts itself", "mm",
        "the mice are fixed to one body; L² = D² + ΣΔx², so turns are told too small, by "
        f"{math.degrees(turn):.2f}° and {1e3 * error:.2f} mm at the end",
    )  # fmt: skip


def _rigid(ends: dict[str, tuple[float, float]]) -> Claim:
    error, turn = ends["rigid body"]
    return Claim(
        "Section II", f"end error of the rigid form after {DURATION_S:g} s", None,
        f"{1e3 * error:.3f} mm, {math.degrees(turn):.4f}°", "not printed",
        note=f"counts of {printed.MOUSE_RESOLUTION_UM:g} µm at {printed.MOUSE_PERIOD_MS:g} ms, mice that neither slip "
        "nor turn in their mounts: in practice scale, mounting and grip are what is left",
    )  # fmt: skip


def _table(ends: Mapping[tuple[float, float], dict[str, tuple[float, float]]]) -> TableSection:
    headers = ("samples", *(f"{name}, {unit}" for name in FORMS for unit in ("mm", "°")))
    cells, data = [], []
    for (dt, step), found in ends.items():
        label = f"{1e3 * dt:g} ms" + (f", counts of {1e6 * step:g} µm" if step else ", exact")
        cells.append((label, *(t for e, a in found.values() for t in (_shown(1e3 * e, 3), _shown(math.degrees(a), 4)))))
        data.append({"dt_s": dt, "resolution_m": step} | {n: {"m": e, "rad": a} for n, (e, a) in found.items()})
    numeric = (False, *(True for _ in headers[1:]))
    note = (
        f"Median over {MOTIONS} random motions of {DURATION_S:g} s: speeds with standard deviations of "
        f"{1e3 * SPEED_M_S:g} mm/s each way and {YAW_RATE_RAD_S:g} rad/s, D = {1e3 * BASELINE_M:g} mm. What becomes "
        "undefined counts as the largest error."
    )
    return TableSection("End errors of dead reckoning", Table("", headers, tuple(cells), tuple(data), numeric), note)


def _charts(one: Motion) -> ChartSection:
    time = np.arange(len(one.pose), dtype=np.float64) * _LEAST_S
    ways = counts(one.increments, 1e-6 * printed.MOUSE_RESOLUTION_UM)
    first = _apart(mouse_recursion.printed(one.increments, BASELINE_M), one.pose)
    position, heading = [], []
    for colour, name in ((0, "corrected"), (2, "rigid body")):
        off = _apart(FORMS[name](ways, BASELINE_M), one.pose)
        position.append(Line(name, time, 1e3 * np.hypot(off[:, 0], off[:, 1]), colour))
        heading.append(Line(name, time, np.degrees(off[:, 2]), colour))
    charts = (
        Chart("Heading error, with the sign of x₁, no counts", "°", (Line("", time, np.degrees(first[:, 2]), 3),)),
        Chart("Heading error", "°", tuple(heading)),
        Chart("Position error", "mm", tuple(position), low=0.0),
    )
    note = (
        f"The first motion, {printed.MOUSE_PERIOD_MS:g} ms, D = {1e3 * BASELINE_M:g} mm, counts of "
        f"{printed.MOUSE_RESOLUTION_UM:g} µm but where it says otherwise."
    )
    return ChartSection("Dead reckoning in one motion", charts, note)


def _shown(value: float, digits: int, undefined: str = "undefined") -> str:
    return f"{value:.{digits}f}" if math.isfinite(value) else undefined


def _apart(poses: Array, others: Array) -> Array:
    """Differences (N, 3) of poses, headings wrapped."""
    found = poses - others
    found[:, 2] = (found[:, 2] + math.pi) % (2.0 * math.pi) - math.pi
    return np.asarray(found)


def _wrapped(angle: float) -> float:
    return (angle + math.pi) % (2.0 * math.pi) - math.pi
