"""The sections of a report page: one run, several runs, a recording, a table, words. Each gives its HTML."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from html import escape
from typing import Protocol

import numpy as np

from holodrive.log import view as views
from holodrive.log.drawing import Trace, drawn, framed, picture
from holodrive.log.run import Run
from holodrive.log.shapes import BLUE, ORANGE
from holodrive.log.view import View
from holodrive.reports import parts, replay, scene
from holodrive.reports.charts import ChartGroup, chart_groups, compared, heading_error, position_error
from holodrive.reports.lidar import lidar_html
from holodrive.reports.plots import Chart, Line
from holodrive.reports.tables import Table, metric_table
from holodrive.types import Array

BELOW_FROM = 4  # that many runs' metrics leave no room for the map beside them


class Section(Protocol):
    """A part of a page with a heading."""

    @property
    def title(self) -> str:
        """The heading; also its name in the list of contents."""
        ...

    def html(self) -> str:
        """What stands under the heading."""
        ...


@dataclass(frozen=True)
class RunSection:
    """One run: what ran, metrics, replay over the world, charts, events, settings."""

    run: Run
    name: str = ""
    note: str = ""

    @property
    def title(self) -> str:
        """Robot, world and controller, unless a name was given."""
        return self.name or run_name(self.run)

    def html(self) -> str:
        """What stands under the heading."""
        run = self.run
        picture_, view = scene.run_scene(run)
        data = replay.data([run], [self.title], view, run.world)
        return "".join(
            [
                parts.note(self.note),
                parts.facts(run),
                parts.damage(run),
                parts.tiles(run.metrics),
                parts.player(picture_, parts.side_panel(run), data, lidar=bool(run.scans)),
                *(parts.chart_group(group) for group in chart_groups(run)),
                parts.heading("Lidar") + lidar_html(run) if run.scans else "",
                parts.event_table(run.events),
                parts.settings_of(run),
            ]
        )


@dataclass(frozen=True)
class ComparisonSection:
    """Several runs: laid over each other in one world, side by side in several; metrics with the best marked."""

    runs: tuple[Run, ...]
    names: tuple[str, ...] = ()
    title: str = "Comparison"
    note: str = ""

    def html(self) -> str:
        """What stands under the heading."""
        names = self.names or run_names(self.runs)
        explain = (
            "▲ marks the best value of a row among the runs that arrived and ran into nothing, where there are such; "
            "percentages are differences from the first run."
        )
        table = metric_table(self.runs, names).html() + parts.note(explain)
        charts = ChartGroup("Side by side", "One line a run.", compared(self.runs, names))
        return parts.note(self.note) + self._pictures(names, table) + parts.chart_group(charts)

    def _pictures(self, names: Sequence[str], table: str) -> str:
        if scene.together(self.runs):
            overlay, view = scene.comparison_scene(self.runs, names)
            data = replay.data(self.runs, names, view, self.runs[0].world)
            width = "wide" if len(self.runs) < BELOW_FROM else "wide below"
            return parts.player(overlay, table, data, lidar=False, width=width)
        figures = "".join(
            f"<figure><figcaption>{escape(name)}</figcaption>{picture(run, 420, 420)}</figure>"
            for name, run in zip(names, self.runs, strict=True)
        )
        return f'<div class="worlds">{figures}</div>' + parts.heading("Metrics") + table


@dataclass(frozen=True)
class RecordingSection:
    """A recorded robot: its wheel odometry against the truth.

    Attributes:
        title: heading.
        time: (T,) [s]; odometry, truth: (T, 3) poses [m, m, rad]. Plain arrays.
        metrics: name -> number, named as in `holodrive.log.words`.
        note: where the recording comes from and what was computed.
        facts: what was recorded, as pairs of words.
    """

    title: str
    time: Array
    odometry: Array
    truth: Array
    metrics: Mapping[str, float] = field(default_factory=dict)
    note: str = ""
    facts: Mapping[str, str] = field(default_factory=dict)

    def html(self) -> str:
        """What stands under the heading."""
        picture_ = f'<div class="map">{self.picture()}</div>'
        charts = "".join(f"<figure>{chart.svg()}</figure>" for chart in self.charts())
        return (
            parts.note(self.note)
            + parts.fact_list(self.facts)
            + parts.tiles(self.metrics)
            + f'<div class="pair">{picture_}<div class="charts">{charts}</div></div>'
        )

    def picture(self) -> str:
        """Truth and odometry on the floor."""
        span = views.union(views.around([self.truth, self.odometry], 0.0))
        air = 0.08 * max(span[2] - span[0], span[3] - span[1], 0.1)
        bounds = (span[0] - air, span[1] - air, span[2] + air, span[3] + air)
        view = View.fit(bounds, scene.WIDTH, 460.0, header=26.0)
        lines = [
            Trace("truth", self.truth, "truth", BLUE, None, 2.2),
            Trace("wheel odometry", self.odometry, "estimate", ORANGE, "6 4", 1.8),
        ]
        known = [line for line in lines if np.isfinite(line.poses).all(axis=1).any()]
        return framed(
            view, known, f"{self.title}: truth and wheel odometry on the floor.", *(drawn(line, view) for line in known)
        )

    def charts(self) -> tuple[Chart, ...]:
        """Position and heading error over time."""
        error = position_error(self.odometry, self.truth)
        factor, unit = (1.0, "m") if np.isfinite(error).any() and np.nanmax(error) >= 1.0 else (1e3, "mm")
        return (
            Chart("Position error of odometry", unit, (Line("", self.time, factor * error, 3),), low=0.0, height=200.0),
            Chart(
                "Heading error of odometry",
                "°",
                (Line("", self.time, heading_error(self.odometry, self.truth), 4),),
                least=0.2,
                height=200.0,
            ),
        )


@dataclass(frozen=True)
class ChartSection:
    """Charts under a heading."""

    title: str
    charts: tuple[Chart, ...]
    note: str = ""

    def html(self) -> str:
        """What stands under the heading."""
        figures = "".join(f"<figure>{chart.svg()}</figure>" for chart in self.charts if chart.known())
        return parts.note(self.note) + f'<div class="charts two">{figures}</div>'


@dataclass(frozen=True)
class TableSection:
    """A table under a heading."""

    title: str
    table: Table
    note: str = ""

    def html(self) -> str:
        """What stands under the heading."""
        return parts.note(self.note) + self.table.html()


@dataclass(frozen=True)
class TextSection:
    """Words, and commands to type, each with what it does."""

    title: str
    text: str = ""
    commands: tuple[tuple[str, str], ...] = ()

    def html(self) -> str:
        """What stands under the heading."""
        text = "".join(f"<p>{escape(part)}</p>" for part in self.text.split("\n\n") if part)
        rows = "".join(
            f"<tr><td><code>{escape(c)}</code></td><td class='wrap'>{escape(w)}</td></tr>" for c, w in self.commands
        )
        return text + (f'<div class="scroll"><table><tbody>{rows}</tbody></table></div>' if rows else "")


def run_name(run: Run) -> str:
    """Robot, world and controller of a run."""
    parts = (run.robot.name, run.world.name if run.world else "", str(run.settings.get("controller", "")))
    return " · ".join(part for part in parts if part)


def run_names(runs: Sequence[Run]) -> tuple[str, ...]:
    """Short names that tell runs apart: by what differs among them, numbered where nothing does."""
    keys = [
        (
            r.robot.name,
            r.world.name if r.world else "",
            str(r.settings.get("controller", "")),
            str(r.settings.get("seed", "")),
        )
        for r in runs
    ]
    differ = [len({key[i] for key in keys}) > 1 for i in range(4)]
    names = []
    for key in keys:
        parts = [("seed " if i == 3 else "") + part for i, part in enumerate(key) if differ[i] and part]
        # seeds alone tell runs apart only when nothing else does
        names.append(" · ".join(parts[:-1] if differ[3] and len(parts) > 1 else parts) or key[2] or key[0])
    if len(set(names)) < len(names):
        names = [f"{i + 1}: {name}" for i, name in enumerate(names)]
    return tuple(names)
