"""What a step calibration found, as a table for the terminal, as JSON, and as a page with the paper's figures."""

import math
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from holodrive.calibration.steps import DIRECTIONS, Calibration, CurveFit, Group, curve_values
from holodrive.reports import ChartSection, Report, Section, TableSection, TextSection
from holodrive.reports.steps import fit_chart, response_chart, speed_chart
from holodrive.reports.tables import Table

if TYPE_CHECKING:
    from holodrive.robots.spec import Linearizer, Robot

_POINTS = 200  # of a drawn curve
_READING = (
    "Dead zone: PWM at which motion begins by the curve, between the last PWM that stood and the first that moved. "
    "Dead time: from the command to the start of motion. R2 and monotone: of the plain cubic as the paper fits it. "
    "The curve is fitted to the slope of each step's tail; eq. 8, the mean speed since the start of motion, counts the "
    "wheels' lag as slowness and stands beside it."
)


def rows_of(found: Calibration, robot: "Robot") -> list[dict[str, Any]]:
    """One record for each group and direction, in the units that people read (counts, ms, mm/s)."""
    rows = []
    for group in found.groups:
        for direction in DIRECTIONS:
            one = found.fit_of(group.name, direction)
            rows.append(_row(one) | _before(found, robot, group, direction))
    return rows


def _row(one: CurveFit) -> dict[str, Any]:
    return {
        "group": one.group,
        "direction": one.direction,
        "dead_zone_pwm": one.dead_zone,
        "last_still_pwm": one.last_still,
        "first_moving_pwm": one.first_moving,
        "dead_time_ms": 1e3 * one.dead_time_s,
        "lag_ms": 1e3 * one.lag_s,
        "r2": one.r2,
        "monotone": one.printed_monotone,
        "curve": one.method,
        "steps": len(one.pwm),
        "top_pwm": float(one.pwm[-1]),
        "top_mm_s": 1e3 * one.top_m_s,
        "top_eq8_mm_s": 1e3 * float(one.speed_eq8_m_s[-1]),
        "max_error_mm_s": 1e3 * one.max_error_m_s,
        "plain_cubic": list(one.printed),
        "unsettled_pwm": list(one.unsettled),
    }


def _before(found: Calibration, robot: "Robot", group: Group, direction: str) -> dict[str, Any]:
    """What the linearizer that the robot's file had says of the same."""
    if robot.linearizer is None:
        return {"before_dead_zone_pwm": math.nan, "before_top_mm_s": math.nan, "before_max_error_mm_s": math.nan}
    one = found.fit_of(group.name, direction)
    dead = curve_values(robot, robot.linearizer, group, direction, found.counts, np.zeros(1))[0]
    speeds = speeds_of(robot, robot.linearizer, group, direction, found.counts, one.pwm)
    return {
        "before_dead_zone_pwm": float(dead),
        "before_top_mm_s": 1e3 * float(speeds[-1]),
        "before_max_error_mm_s": 1e3 * float(np.max(np.abs(speeds - one.speed_m_s))),
    }


def speeds_of(
    robot: "Robot", linearizer: "Linearizer", group: Group, direction: str, counts: float, pwm: np.ndarray
) -> np.ndarray:
    """(P,) speeds [m/s] at which a linearizer gives these PWM values; 0 in its dead zone."""
    low, high = np.zeros_like(pwm), np.full_like(pwm, 1e3)
    for _ in range(80):
        middle = 0.5 * (low + high)
        above = curve_values(robot, linearizer, group, direction, counts, middle) > pwm
        low, high = np.where(above, low, middle), np.where(above, middle, high)
    return np.asarray(0.5 * (low + high))


def table_of(rows: list[dict[str, Any]]) -> Table:
    """The records as a table."""
    had = any(math.isfinite(row["before_top_mm_s"]) for row in rows)
    headers = ["group", "direction", "dead zone PWM", "between", "dead time ms", "lag ms", "R2", "monotone", "curve",
               "top mm/s", "by eq. 8 mm/s", "max error mm/s"]  # fmt: skip
    headers += ["before: dead zone PWM", "top mm/s ", "max error mm/s "] if had else []
    cells = []
    for row in rows:
        cell = [
            row["group"], row["direction"], f"{row['dead_zone_pwm']:.2f}",
            f"{row['last_still_pwm']:g}..{row['first_moving_pwm']:g}", _number(row["dead_time_ms"], 0),
            _number(row["lag_ms"], 0), f"{row['r2']:.6f}", "yes" if row["monotone"] else "no", row["curve"],
            f"{row['top_mm_s']:.2f}", f"{row['top_eq8_mm_s']:.2f}", f"{row['max_error_mm_s']:.2f}",
        ]  # fmt: skip
        if had:
            cell += [_number(row[f"before_{name}"], 2) for name in ("dead_zone_pwm", "top_mm_s", "max_error_mm_s")]
        cells.append(tuple(cell))
    numeric = tuple(i not in (0, 1, 7, 8) for i in range(len(headers)))
    return Table("", tuple(headers), tuple(cells), tuple(rows), numeric)


def page(found: Calibration, robot: "Robot", command: str) -> Report:
    """The page: the table, then Figures 4, 5 and 7 of the paper for this robot."""
    names = [(group, direction) for group in found.groups for direction in DIRECTIONS]
    fits = [found.fit_of(group.name, direction) for group, direction in names]
    both = (
        speed_chart([(_name(one), one.pwm, one.speed_m_s) for one in fits], "Speed over PWM, by the tail"),
        speed_chart([(_name(one), one.pwm, one.speed_eq8_m_s) for one in fits], "Speed over PWM, by equation 8"),
    )
    sections: list[Section] = [
        TableSection("Result", table_of(rows_of(found, robot)), _READING),
        ChartSection(
            "Step responses",
            tuple(_responses(found, group, direction) for group, direction in names),
            "Figure 4 of Keek et al. for this robot: displacement after each PWM was commanded out of standstill.",
        ),
        ChartSection("Speed over PWM", both, "Figure 5: the same PWM gives other speeds in other directions."),
        ChartSection(
            "PWM over speed",
            tuple(_fitted(found, robot, group, direction) for group, direction in names),
            "Figure 7: crosses are measured; the curve is the one that was found, the plain cubic is fitted as the "
            "paper does, and before is the linearizer that the robot's file had.",
        ),
        TextSection("Again", "", ((command, "the same calibration once more"),)),
    ]
    return Report(f"Step calibration of {found.robot}", tuple(sections))


def _name(one: CurveFit) -> str:
    return f"{one.group} {one.direction}"


def _responses(found: Calibration, group: Group, direction: str) -> Any:
    records = [step.record for step in found.steps_of(group.name, direction)]
    return response_chart(
        f"{group.name} {direction}",
        [record.pwm for record in records],
        [record.time - record.command_time for record in records],
        [record.travel() for record in records],
    )


def _fitted(found: Calibration, robot: "Robot", group: Group, direction: str) -> Any:
    one, v = found.fit_of(group.name, direction), np.empty(0)
    v = np.linspace(0.0, float(one.speed_m_s.max()), _POINTS)
    shown: Mapping[str, Linearizer | None] = {"found": found.linearizer(robot), "before": robot.linearizer}
    curves = [
        (name, curve_values(robot, linearizer, group, direction, found.counts, v), v)
        for name, linearizer in shown.items()
        if linearizer is not None
    ]
    plain = np.polyval(one.printed[::-1], 1e3 * v)
    return fit_chart(f"{group.name} {direction}", one.pwm, one.speed_m_s, [*curves, ("plain cubic", plain, v)])


def _number(value: float, decimals: int) -> str:
    return f"{value:.{decimals}f}" if math.isfinite(value) else "-"
