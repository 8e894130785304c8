"""Charts of open-loop PWM steps: displacement over time, speed over PWM, PWM over speed with the curves through it.

These are Figures 4, 5 and 7 of Keek et al., from plain arrays.
"""

from collections.abc import Sequence

import numpy as np

from holodrive.reports.plots import COLOURS, DASHES, Chart, Line
from holodrive.types import Array

NAMED = 6  # of the steps on one chart; more names would leave no room for the lines
_CROSS = 0.008  # half width of a cross, of the range of an axis
_MM = 1e3  # per m


def response_chart(name: str, pwm: Sequence[float], times: Sequence[Array], travels: Sequence[Array]) -> Chart:
    """Displacement of one group in one direction, a line for each step (Figure 4).

    Args:
        name: of group and direction.
        pwm: (S,) counts of the steps.
        times: S times (N,) since the command [s].
        travels: S displacements (N,) [m].
    """
    order = np.argsort(pwm, kind="stable")
    named = set(order[np.unique(np.linspace(0, len(order) - 1, min(NAMED, len(order))).astype(int))].tolist())
    lines = tuple(
        Line(
            f"PWM {pwm[i]:g}" if i in named else "",
            times[i],
            _MM * travels[i],
            k % len(COLOURS),
            dash=DASHES[k // len(COLOURS) % len(DASHES)],
        )
        for k, i in enumerate(order.tolist())
    )
    return Chart(f"Displacement, {name}", "mm", lines, x_name="time since the command", low=0.0, height=260.0)


def speed_chart(curves: Sequence[tuple[str, Array, Array]], title: str = "Speed over PWM") -> Chart:
    """Speed over PWM, a line for each group and direction (Figure 5).

    Args:
        curves: name, PWM (P,) counts, speed (P,) [m/s].
        title: of the chart.
    """
    lines = tuple(
        Line(name, pwm, _MM * speed, k, dash=DASHES[k // len(COLOURS) % len(DASHES)])
        for k, (name, pwm, speed) in enumerate(curves)
    )
    return Chart(title, "mm/s", lines, x_name="PWM", x_unit="counts", low=0.0, height=280.0)


def fit_chart(name: str, pwm: Array, speed: Array, curves: Sequence[tuple[str, Array, Array]]) -> Chart:
    """PWM over speed: what was measured as crosses, curves through it as lines (Figure 7).

    Args:
        name: of group and direction.
        pwm, speed: (P,) measured [counts, m/s].
        curves: name, PWM (Q,) counts, speed (Q,) [m/s].
    """
    x, y = crosses(_MM * speed, pwm)
    lines = [
        Line(label, _MM * v, values, 1 + k, dash=DASHES[k % len(DASHES)]) for k, (label, values, v) in enumerate(curves)
    ]
    chart = (*lines, Line("measured", x, y, 0))
    return Chart(f"PWM over speed, {name}", "counts", chart, x_name="speed", x_unit="mm/s", low=0.0, height=260.0)


def crosses(x: Array, y: Array) -> tuple[Array, Array]:
    """A small cross at each point (P,), as one line with gaps, in the units of the axes."""
    dx, dy = (2.0 * _CROSS * max(float(np.ptp(each)), 1e-9) for each in (x, y))
    shape = np.array([(-1, -1), (1, 1), (np.nan, np.nan), (-1, 1), (1, -1), (np.nan, np.nan)])
    # an axis is about half as high as it is wide
    px = x[:, None] + 0.5 * dx * shape[:, 0]
    py = y[:, None] + dy * shape[:, 1]
    return px.ravel(), py.ravel()


__all__ = ["crosses", "fit_chart", "response_chart", "speed_chart"]
