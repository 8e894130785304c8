"""Figure 9 and equations 13 to 16: gains over the angle as printed, as triangle waves and as cosines."""

import numpy as np

from holodrive.control import la_g
from holodrive.experiments.claims import Claim, Verdict
from holodrive.experiments.experiment import Result, Setting
from holodrive.experiments.mecanum import mapping
from holodrive.reports.plots import Chart, Line
from holodrive.reports.sections import ChartSection
from holodrive.types import Array

VARIANTS: tuple[la_g.Variant, ...] = ("printed", "clean", "cosine")
FIGURE_8 = ((45.0, (0.0, -1.0)), (90.0, (-0.5, -0.5)), (135.0, (-1.0, 0.0)))  # positions A, B and C
_STEP_DEG = 0.05
_DASHES = {"printed": None, "clean": "7 3", "cosine": "2 3"}


def figure_9(setting: Setting) -> Result:
    """Claims about the gains, and their charts."""
    angle = _grid()
    claims = (
        *_figure_8(),
        _signs(),
        _interval(),
        _as_equation_13(angle),
        _jumps(angle),
        *(_direction(angle, variant) for variant in VARIANTS),
        _speed(angle),
    )
    sections = (
        ChartSection(
            "Figure 9: gains over the angle",
            (*_gain_charts(angle), _error_chart(angle), _difference_chart(angle)),
            "θ is the direction from the target to the robot, so the robot shall drive to θ + 180°. At a gain of 1 a "
            "pair alone drives the robot at the speed of the controller's output.",
        ),
    )
    worst = {str(variant): float(np.max(np.abs(direction_error(angle, variant)))) for variant in VARIANTS}
    return Result(claims, sections, {"largest_direction_error_deg": worst})


def direction_error(angle_deg: Array, variant: la_g.Variant) -> Array:
    """Driven minus wanted direction (n,) [degrees] at angles theta [degrees]."""
    first, second = la_g.gains(np.radians(angle_deg), variant)
    driven = np.degrees(np.arctan2(first + second, second - first))  # W1W4 ahead goes to 135 degrees, W2W3 to 45
    return np.asarray((driven - angle_deg - 180.0 + 180.0) % 360.0 - 180.0)


def speed_factor(angle_deg: Array, variant: la_g.Variant) -> Array:
    """Speed of the robot over the controller's output (n,)."""
    first, second = la_g.gains(np.radians(angle_deg), variant)
    return np.hypot(first, second)


def _grid() -> Array:
    return np.arange(0.0, 360.0, _STEP_DEG)


def _figure_8() -> list[Claim]:
    claims = []
    for name, (angle, said) in zip("ABC", FIGURE_8, strict=True):
        found = mapping.printed_gains(angle)
        good = max(abs(a - b) for a, b in zip(said, found, strict=True)) < 5e-4
        claims.append(
            Claim("Fig. 8, Eq. 14, 15", f"gains at position {name}, θ = {angle:g}°", _two(said, 1), _two(found, 4),
                  "agrees" if good else "contradicts itself",
                  note="" if good else "the figure's value is that of a straight line from 45° to 135°; the equations "
                  "take 0.99 over 89.9° for 1 over 90°")
        )  # fmt: skip
    return claims


def _signs() -> Claim:
    back, ahead = mapping.printed_gains(90.0), mapping.printed_gains(270.0)
    good = max(back) < 0.0 < min(ahead)
    return Claim(
        "text, Section V.B", "all wheels back at 90°, ahead at 270°", "yes", "yes" if good else "no",
        "agrees" if good else "contradicts itself",
    )  # fmt: skip


def _interval() -> Claim:
    return Claim(
        "text, Section IV.A", "sub-quadrant (a) of Quadrant IV", "−315° ≤ θ < 360°", "315° ≤ θ < 360°",
        "contradicts itself", note="Eq. 14 and 15 have 315°, and the same sentence before it",
    )  # fmt: skip


def _as_equation_13(angle: Array) -> Claim:
    """The controller's printed gains against equation 13 worked out quadrant by quadrant."""
    ours = np.column_stack(la_g.gains(np.radians(angle), "printed"))
    said = np.array([mapping.printed_gains(float(a)) for a in angle])
    off = np.max(np.abs(ours - said), axis=1) > 1e-9
    # at a quadrant's first angle rounding decides which side of the jump one is on
    verdict: Verdict = "agrees" if off.sum() <= len(FIGURE_8) else "differs"
    return Claim("Eq. 13 to 15", "gains of la_g, variant printed", f"{len(angle)} angles",
                 f"{int((~off).sum())} the same", verdict)  # fmt: skip


def _jumps(angle: Array) -> Claim:
    first = [la_g.gains(np.radians(angle), variant)[0] for variant in ("printed", "clean")]
    apart = float(np.max(np.abs(first[0] - first[1])))
    before = mapping.printed_gains(135.0 - 1e-9)[0]
    jump = mapping.printed_gains(135.0)[0] - before
    return Claim(
        "Eq. 14, 15", "largest difference from two triangle waves", None, apart, "not printed",
        note="|wrap(θ − 135°)| / 90° − 1 and the same of θ − 45°; as printed the gains jump by "
        f"{abs(jump):.4f} where quadrants meet",
    )  # fmt: skip


def _direction(angle: Array, variant: la_g.Variant) -> Claim:
    error = np.abs(direction_error(angle, variant))
    worst = float(error.max())
    to_diagonal = abs((angle[error.argmax()] - 45.0 + 45.0) % 90.0 - 45.0)
    note = {
        "printed": f"{to_diagonal:.1f}° from a diagonal, with a heading of 0 and wheels that follow exactly",
        "clean": "0 at all multiples of 45°",
        "cosine": "g = −cos(θ − 135°) and −cos(θ − 45°): not in the paper",
    }
    return Claim("Fig. 9", f"largest error of direction, {variant} gains", None, f"{worst:.2f}°", "not printed",
                 note=note[variant])  # fmt: skip


def _speed(angle: Array) -> Claim:
    clean, cosine = (speed_factor(angle, variant) for variant in ("clean", "cosine"))
    return Claim(
        "Fig. 9", "speed over the controller's output, least and most", None,
        f"{clean.min():.3f}, {clean.max():.3f}", "not printed",
        note=f"{100 * (1 - clean.min() / clean.max()):.0f} % slower ahead than along a diagonal at the same distance; "
        f"cosine gains: {cosine.min():.3f}, {cosine.max():.3f}",
    )  # fmt: skip


def _gain_charts(angle: Array) -> list[Chart]:
    return [
        Chart(
            f"Gain of {pair}", "",
            tuple(
                Line(variant, angle, la_g.gains(np.radians(angle), variant)[j], i, dash=_DASHES[variant])
                for i, variant in enumerate(VARIANTS)
            ),
            x_name="θ", x_unit="°", low=-1.0, high=1.0,
        )
        for j, pair in enumerate(mapping.PAIRS)
    ]  # fmt: skip


def _error_chart(angle: Array) -> Chart:
    lines = tuple(
        Line(variant, angle, direction_error(angle, variant), i, dash=_DASHES[variant])
        for i, variant in enumerate(VARIANTS)
    )
    return Chart("Error of direction", "°", lines, x_name="θ", x_unit="°")


def _difference_chart(angle: Array) -> Chart:
    printed, clean = (la_g.gains(np.radians(angle), variant) for variant in ("printed", "clean"))
    lines = tuple(Line(pair, angle, printed[j] - clean[j], j) for j, pair in enumerate(mapping.PAIRS))
    return Chart("Printed minus clean gain", "", lines, x_name="θ", x_unit="°")


def _two(values: tuple[float, float], digits: int) -> str:
    return ", ".join(f"{value + 0.0:.{digits}f}" for value in values).replace("-", "−")
