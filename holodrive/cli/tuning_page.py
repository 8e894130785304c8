"""What tuning found, as tables for the terminal and as a page."""

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from holodrive.log.words import told, words
from holodrive.reports import ChartSection, Report, Section, TableSection, TextSection
from holodrive.reports.plots import Chart, Line
from holodrive.reports.tables import Table

if TYPE_CHECKING:
    from holodrive.tuning import Judgement, Tuned
    from holodrive.tuning.judgement import Rate, Spread

TO_A_GOAL = ("time_s", "path_length_m", "min_clearance_m", "turns")
ALONG_A_PATH = ("rms_error_m", "max_error_m", "iae_m_s", "final_error_m")
_READING = (
    "Runs that tuning has not seen. Rates with their 95 % Wilson interval, the cost with a 95 % bootstrap interval of "
    "its mean, the others as median (5 % .. 95 % of the runs); times, lengths and distances are those of the runs "
    "that succeeded."
)


def values_table(tuned: "Tuned") -> Table:
    """Every field: its range, its value before and after."""
    rows = [
        (
            one.field,
            f"{one.low:g} .. {one.high:g}{' log' if one.log else ''}",
            f"{tuned.start[one.field]:.5g}",
            f"{tuned.best.get(one.field, tuned.start[one.field]):.5g}",
        )
        for one in tuned.ranges
    ]
    header = ("field", "range", "before", "after")
    data = tuple(dict(zip(header, row, strict=True)) for row in rows)
    return Table("", header, tuple(rows), data, (False, True, True, True))


def judged_table(tuned: "Tuned") -> Table | None:
    """Before and after over the held-out runs; None when tuning was interrupted before."""
    if tuned.before is None or tuned.after is None:
        return None
    both = (tuned.before, tuned.after)
    rows = [("cost", *(_cost(one.cost) for one in both))]
    names: Sequence[str] = ALONG_A_PATH
    if any(one.succeeded.count for one in both):
        rows.append(("success", *(_rate(one.succeeded) for one in both)))
        names = TO_A_GOAL if tuned.settings.get("goal") != "path" else ALONG_A_PATH
    rows.append(("ran into something", *(_rate(one.collided) for one in both)))
    rows += [row for row in (_metric(name, both) for name in names) if row]
    header = ("", "before", "after")
    data = tuple({"metric": row[0], "before": row[1], "after": row[2]} for row in rows)
    return Table("", header, tuple(rows), data, (False, True, True))


def gain_line(tuned: "Tuned") -> str:
    """The change of the cost over the held-out runs, in words."""
    if tuned.gain is None:
        return "interrupted: not judged on held-out runs"
    if not tuned.best:
        return "no better values found; the parameters stay as they are"
    change, low, high = tuned.gain
    sure = "better" if high < 0.0 else "worse" if low > 0.0 else "not surely better"
    return f"{sure}: cost {change:+.4g} ({low:+.4g} .. {high:+.4g}) on the same held-out runs"


def page(tuned: "Tuned", command: str) -> Report:
    """The page of a result."""
    judged = judged_table(tuned)
    sections: list[Section] = [
        TextSection(
            "Result",
            f"{gain_line(tuned)}.\n\nThe search ended: {tuned.ended}, after {_runs(tuned)} simulated runs in "
            f"{len(tuned.history)} generations of {tuned.settings['population']} candidates."
            f"\n\nTune again, with the same result: {command}"
            + (f"\n\nUse what was found: holodrive run {tuned.robot} -c {tuned.controller} {tuned.options}"
               if tuned.best else ""),
        ),
        *([TableSection("Before and after", judged, _READING)] if judged else []),
        TableSection("Values", values_table(tuned)),
        *([ChartSection("Search", charts(tuned), "Each generation meets other runs, so its cost is a sample.")]
          if len(tuned.history) > 1 else []),
    ]  # fmt: skip
    return Report(f"Tuning {tuned.controller} of {tuned.robot} for {tuned.objective}", tuple(sections))


def charts(tuned: "Tuned") -> tuple[Chart, ...]:
    """How the search went: cost, spread of the candidates, and where the values went in their ranges."""
    runs = np.array([float(one.runs) for one in tuned.history])
    cost = [np.array([getattr(one, name) for one in tuned.history]) for name in ("best", "median")]
    lines = (Line("best of a generation", runs, cost[0], 0), Line("median", runs, cost[1], 1, dash="7 3"))
    places = tuple(
        Line(one.field, runs, np.array([100.0 * one.unit(step.values[one.field]) for step in tuned.history]), i)
        for i, one in enumerate(tuned.ranges)
    )
    spread = (Line("", runs, np.array([100.0 * one.spread for one in tuned.history]), 3),)
    axis = {"x_name": "simulated runs", "x_unit": ""}
    return (
        Chart("Cost", "", lines, **axis),  # type: ignore[arg-type]
        Chart("Spread of the candidates", "% of the ranges", spread, low=0.0, **axis),  # type: ignore[arg-type]
        *(
            Chart("Best values in their ranges", "%", places[k : k + 4], low=0.0, high=100.0, **axis)  # type: ignore[arg-type]
            for k in range(0, len(places), 4)
        ),
    )


def _runs(tuned: "Tuned") -> int:
    return tuned.history[-1].runs if tuned.history else 0


def _rate(rate: "Rate") -> str:
    return f"{100.0 * rate.share:.1f} % ({100.0 * rate.low:.1f} .. {100.0 * rate.high:.1f}), {rate.count} of {rate.n}"


def _cost(cost: "Spread") -> str:
    return f"{cost.mean:.4g} ({cost.low:.4g} .. {cost.high:.4g})"


def _metric(name: str, both: Sequence["Judgement"]) -> tuple[str, str, str] | None:
    spreads = [one.metrics[name] for one in both]
    if not all(np.isfinite(one.median) for one in spreads):
        return None
    unit, texts = told(name, [value for one in spreads for value in (one.median, one.p5, one.p95)])
    label = words(name).label + (f", {unit}" if unit else "")
    before, after = (f"{texts[k]} ({texts[k + 1]} .. {texts[k + 2]})" for k in (0, 3))
    return label, before, after
