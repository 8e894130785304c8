"""The sections of a report page: one run, several runs, a recording, a table, words. Each gives its HTML."""

import math
import shlex
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from html import escape
from typing import Any, Protocol

import numpy as np

from holodrive.log import view as views
from holodrive.log.drawing import BLUE, ORANGE, Trace, drawn, framed, picture
from holodrive.log.run import Run
from holodrive.log.view import View
from holodrive.log.words import ordered, told, words
from holodrive.reports import replay, scene
from holodrive.reports.charts import ChartGroup, chart_groups, compared, heading_error, position_error
from holodrive.reports.plots import Chart, Line
from holodrive.reports.tables import Table, metric_table
from holodrive.types import Array, Event


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
                _note(self.note),
                facts(run),
                _damage(run),
                tiles(run.metrics),
                player(picture_, _side(run), data, lidar=bool(run.scans)),
                *(_chart_group(group) for group in chart_groups(run)),
                _events(run.events),
                _settings(run),
            ]
        )


@dataclass(frozen=True)
class ComparisonSection:
    """Several runs: laid over each other when they share a world, side by side otherwise; metrics with the best marked."""

    runs: tuple[Run, ...]
    names: tuple[str, ...] = ()
    title: str = "Comparison"
    note: str = ""

    def html(self) -> str:
        """What stands under the heading."""
        names = self.names or run_names(self.runs)
        table = metric_table(self.runs, names).html()
        explain = "▲ marks the best value of a row; percentages are differences from the first run."
        charts = ChartGroup("Side by side", "One line a run.", compared(self.runs, names))
        return _note(self.note) + self._pictures(names) + _heading("Metrics", explain) + table + _chart_group(charts)

    def _pictures(self, names: Sequence[str]) -> str:
        if scene.together(self.runs):
            overlay, view = scene.comparison_scene(self.runs, names)
            data = replay.data(self.runs, names, view, self.runs[0].world)
            return player(overlay, "", data, lidar=False)
        pictures = zip(names, self.runs, strict=True)
        return (
            '<div class="worlds">'
            + "".join(
                f"<figure><figcaption>{escape(n)}</figcaption>{picture(r, 420, 420)}</figure>" for n, r in pictures
            )
            + "</div>"
        )


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
            _note(self.note)
            + fact_list(self.facts)
            + tiles(self.metrics)
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
                height=200.0,
            ),
        )


@dataclass(frozen=True)
class TableSection:
    """A table under a heading."""

    title: str
    table: Table
    note: str = ""

    def html(self) -> str:
        """What stands under the heading."""
        return _note(self.note) + self.table.html()


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


def repeat_command(run: Run) -> str:
    """What to type to run the same again: the recorded command, or the check of the log."""
    command = run.settings.get("command")
    if isinstance(command, str) and command:
        return command
    if isinstance(command, list | tuple) and command:
        return shlex.join(str(part) for part in command)
    return f"holodrive replay {shlex.quote(run.path.name)} --rerun" if run.path else ""


def facts(run: Run) -> str:
    """What ran, and how to repeat it."""
    settings = run.settings
    pairs = {
        "robot": run.robot.name,
        "world": run.world.name if run.world else "open floor",
        **{
            key: str(settings[key])
            for key in ("controller", "plant", "seed", "id")
            if settings.get(key) not in (None, "")
        },
    }
    if settings.get("version"):
        pairs["made by"] = f"holodrive {settings['version']}"
    command = repeat_command(run)
    repeat = f'<p class="repeat">Repeat with <code>{escape(command)}</code></p>' if command else ""
    return _note(run.robot.title) + fact_list(pairs) + repeat


def fact_list(pairs: Mapping[str, str]) -> str:
    """Pairs of words in one line."""
    items = "".join(f"<div><dt>{escape(k)}</dt><dd>{escape(str(v))}</dd></div>" for k, v in pairs.items())
    return f'<dl class="facts">{items}</dl>' if items else ""


def tiles(metrics: Mapping[str, float]) -> str:
    """Metrics as tiles: value with unit, and its name; what went wrong stands out."""
    items = []
    for name in ordered(metrics):
        value = float(metrics[name])
        unit, (text,) = told(name, [value])
        how = words(name)
        bad = (name == "arrived" and value == 0.0) or (name in ("collisions", "moved_collisions") and value > 0.0)
        shown = (
            f"{escape(text)}<small>{'' if unit == '°' else ' '}{escape(unit)}</small>"
            if unit and text != "—"
            else escape(text)
        )
        items.append(
            f'<div{" class=bad" if bad else ""} title="{escape(how.help)}"><dt>{escape(how.label)}</dt><dd>{shown}</dd></div>'
        )
    return f'<dl class="tiles">{"".join(items)}</dl>' if items else ""


def player(picture_: str, side: str, data: str, *, lidar: bool) -> str:
    """The path picture with its replay controls; without scripts the picture stays."""
    speeds = "".join(
        f'<option value="{v:g}"{" selected" if v == 1 else ""}>{v:g} ×</option>' for v in (0.25, 0.5, 1, 2, 4, 8, 16)
    )
    beams = '<label><input type="checkbox" class="lidar" checked> lidar</label>' if lidar else ""
    aside = f'<div class="side">{side}</div>' if side else ""
    return (
        '<div class="replay" role="group" aria-label="Replay of the run">'
        f'<div class="stage"><div class="map">{picture_}</div>{aside}</div>'
        '<div class="bar"><button type="button" class="play" aria-pressed="false">Play</button>'
        '<div class="slot"><div class="event-marks"></div>'
        '<input type="range" class="timeline" min="0" max="1000" value="0" aria-label="time"></div>'
        '<output class="clock"></output>'
        f'<label><span class="hidden">speed</span><select class="speed" title="speed">{speeds}</select></label>{beams}'
        '<p class="keys">Space plays and pauses, ← → move by 1 s, with Shift by 0.1 s, Home and End jump. '
        "A click on a chart goes to that time.</p>"
        '<span class="state" role="status" aria-live="polite">The replay needs JavaScript; everything else does not.</span>'
        f'</div><script type="application/json">{data}</script></div>'
    )


def _side(run: Run) -> str:
    rows = "".join(
        f'<tr><th scope="row">{escape(w.name)}</th><td class="number commanded" data-wheel="{i}">—</td>'
        f'<td class="number measured" data-wheel="{i}">—</td></tr>'
        for i, w in enumerate(run.robot.wheels)
    )
    values = [("position", "pose"), ("heading", "heading"), ("speed", "speed"), ("from reference", "error")]
    if np.isfinite(position_error(run.estimate, run.pose)).any():
        values.append(("estimate off by", "drift"))
    readings = "".join(f'<dt>{label}</dt><dd data-value="{name}">—</dd>' for label, name in values)
    key = "".join(
        f'<span><svg width="22" height="8" aria-hidden="true"><path class="arrow {kind}" d="M4 4H18"/></svg>{label}</span>'
        for kind, label in (("commanded", "commanded"), ("measured", "measured"), ("velocity", "body velocity"))
    )
    return (
        f'{replay.close_up(run.robot)}<p class="key">{key}</p><dl>{readings}</dl>'
        '<table><thead><tr><th scope="col">wheel, rad/s</th><th scope="col" class="number">commanded</th>'
        f'<th scope="col" class="number">measured</th></tr></thead><tbody>{rows}</tbody></table>'
    )


def _chart_group(group: ChartGroup) -> str:
    figures = "".join(f"<figure>{chart.svg()}</figure>" for chart in group.charts)
    return _heading(group.title, group.note) + f'<div class="charts">{figures}</div>' if figures else ""


def _events(events: Sequence[Event]) -> str:
    if not events:
        return ""
    rows = []
    for event in events:
        where = f"({event.pose.x:.2f}, {event.pose.y:.2f})" if math.isfinite(event.pose.x + event.pose.y) else "—"
        rows.append(
            f'<tr><td class="number"><button type="button" class="link" data-seek="{event.time:.4f}">{event.time:.2f}</button></td>'
            f'<td>{escape(event.kind)}</td><td class="wrap">{escape(event.text)}</td><td class="number">{where}</td></tr>'
        )
    head = '<tr><th scope="col" class="number">time, s</th><th scope="col">kind</th><th scope="col">what</th><th scope="col" class="number">robot at, m</th></tr>'
    return (
        _heading("Events", "")
        + f'<div class="scroll"><table><thead>{head}</thead><tbody>{"".join(rows)}</tbody></table></div>'
    )


def _settings(run: Run) -> str:
    rows = "".join(
        f'<tr><th scope="row">{escape(key)}</th><td class="wrap">{escape(value)}</td></tr>'
        for key, value in flat(run.settings)
    )
    parts = []
    if rows:
        parts.append(
            f'<details><summary>Settings</summary><div class="scroll"><table><tbody>{rows}</tbody></table></div></details>'
        )
    if run.robot.text:
        parts.append(f"<details><summary>Robot file</summary><pre>{escape(run.robot.text)}</pre></details>")
    if run.world is not None and run.world.text:
        parts.append(f"<details><summary>World file</summary><pre>{escape(run.world.text)}</pre></details>")
    return "".join(parts)


def flat(settings: Mapping[str, Any], prefix: str = "") -> list[tuple[str, str]]:
    """Nested settings as dotted names and texts."""
    rows: list[tuple[str, str]] = []
    for key, value in settings.items():
        name = f"{prefix}{key}"
        if isinstance(value, Mapping):
            rows += flat(value, f"{name}.")
        elif isinstance(value, float):
            rows.append((name, f"{value:.6g}"))
        elif isinstance(value, list | tuple):
            text = ", ".join(f"{v:.6g}" if isinstance(v, float) else str(v) for v in value[:60])
            rows.append((name, text + (f", … ({len(value)} values)" if len(value) > 60 else "")))
        else:
            rows.append((name, str(value)))
    return rows


def _damage(run: Run) -> str:
    return f'<p class="note">The log was damaged: {escape(run.damage)}</p>' if run.damage else ""


def _heading(title: str, note: str) -> str:
    return f"<h3>{escape(title)}</h3>" + _note(note)


def _note(text: str) -> str:
    return f'<p class="note">{escape(text)}</p>' if text else ""
