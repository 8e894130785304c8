"""The pieces that sections are made of, as HTML: facts, tiles, the replay with its controls, events, settings."""

import math
import shlex
from collections.abc import Mapping, Sequence
from html import escape
from typing import Any

import numpy as np

from holodrive.log.run import Run
from holodrive.log.words import ordered, told, words
from holodrive.reports import replay
from holodrive.reports.charts import ChartGroup, position_error
from holodrive.svg import number
from holodrive.types import Event


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
    return note(run.robot.title) + fact_list(pairs) + repeat


def fact_list(pairs: Mapping[str, str]) -> str:
    """Pairs of words in one line."""
    items = "".join(f"<div><dt>{escape(k)}</dt><dd>{escape(str(v))}</dd></div>" for k, v in pairs.items())
    return f'<dl class="facts">{items}</dl>' if items else ""


def tiles(metrics: Mapping[str, float]) -> str:
    """Metrics as tiles: value with unit, and its name; what went wrong stands out."""
    items = []
    for name in ordered(metrics):
        value = float(metrics[name])
        if name == "no_rule" and value == 0.0:  # most controllers have no rules
            continue
        unit, (text,) = told(name, [value])
        how = words(name)
        wrong = ("collisions", "moved_collisions", "no_rule")
        bad = (name == "arrived" and value == 0.0) or (name in wrong and value > 0.0)
        space = "" if unit == "°" else " "
        told_unit = f"<small>{space}{escape(unit)}</small>" if unit and text[-1].isdigit() else ""
        shown = escape(text) + told_unit
        class_ = ' class="bad"' if bad else ""
        items.append(f'<div{class_} title="{escape(how.help)}"><dt>{escape(how.label)}</dt><dd>{shown}</dd></div>')
    return f'<dl class="tiles">{"".join(items)}</dl>' if items else ""


def player(picture_: str, side: str, data: str, *, lidar: bool, width: str = "") -> str:
    """The path picture with its replay controls; without scripts the picture stays.

    `width` of the side: "" for readings, "wide" for a table, "below" for one that leaves no room beside it.
    """
    speeds = "".join(
        f'<option value="{v:g}"{" selected" if v == 1 else ""}>{v:g} ×</option>' for v in (0.25, 0.5, 1, 2, 4, 8, 16)
    )
    beams = '<label><input type="checkbox" class="lidar" checked> lidar</label>' if lidar else ""
    aside = f'<div class="{f"side {width}".rstrip()}">{side}</div>' if side else ""
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
        '<span class="state" role="status" aria-live="polite">'
        "The replay needs JavaScript; everything else does not.</span>"
        f'</div><script type="application/json">{data}</script></div>'
    )


def side_panel(run: Run) -> str:
    """The robot large, with its readings: what the script fills in while it replays."""
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
        '<span><svg width="22" height="8" aria-hidden="true">'
        f'<path class="arrow {kind}" d="M4 4H18"/></svg>{label}</span>'
        for kind, label in (("commanded", "commanded"), ("measured", "measured"), ("velocity", "body velocity"))
    )
    return (
        f'{replay.close_up(run.robot)}<p class="key">{key}</p><dl>{readings}</dl>'
        '<table><thead><tr><th scope="col">wheel, rad/s</th><th scope="col" class="number">commanded</th>'
        f'<th scope="col" class="number">measured</th></tr></thead><tbody>{rows}</tbody></table>'
    )


def chart_group(group: ChartGroup) -> str:
    """Charts under a heading."""
    figures = "".join(f"<figure>{chart.svg()}</figure>" for chart in group.charts)
    two = " two" if all(chart.width > 400.0 for chart in group.charts) else ""
    return heading(group.title, group.note) + f'<div class="charts{two}">{figures}</div>' if figures else ""


def event_table(events: Sequence[Event]) -> str:
    """What happened, each with a button that goes there."""
    if not events:
        return ""
    heads = (("time, s", "number"), ("kind", ""), ("what", ""), ("robot at, m", "number"))
    head = "".join(f'<th scope="col" class="{class_}">{name}</th>' for name, class_ in heads)
    rows = "".join(f"<tr>{_event(event)}</tr>" for event in events)
    table = f"<table><thead><tr>{head}</tr></thead><tbody>{rows}</tbody></table>"
    return heading("Events") + f'<div class="scroll">{table}</div>'


def _event(event: Event) -> str:
    known = math.isfinite(event.pose.x + event.pose.y)
    where = f"({number(event.pose.x, 2)}, {number(event.pose.y, 2)})" if known else "—"
    seek = f'<button type="button" class="link" data-seek="{event.time:.4f}">{event.time:.2f}</button>'
    return (
        f'<td class="number">{seek}</td><td>{escape(event.kind)}</td>'
        f'<td class="wrap">{escape(event.text)}</td><td class="number">{where}</td>'
    )


def settings_of(run: Run) -> str:
    """Settings and files, folded away."""
    rows = "".join(
        f'<tr><th scope="row">{escape(key)}</th><td class="wrap">{escape(value)}</td></tr>'
        for key, value in flat(run.settings)
    )
    folds = []
    if rows:
        table = f'<div class="scroll"><table><tbody>{rows}</tbody></table></div>'
        folds.append(f"<details><summary>Settings</summary>{table}</details>")
    if run.robot.text:
        folds.append(f"<details><summary>Robot file</summary><pre>{escape(run.robot.text)}</pre></details>")
    if run.world is not None and run.world.text:
        folds.append(f"<details><summary>World file</summary><pre>{escape(run.world.text)}</pre></details>")
    return "".join(folds)


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


def damage(run: Run) -> str:
    """A line about a log that could not be read whole."""
    return f'<p class="note">The log was damaged: {escape(run.damage)}</p>' if run.damage else ""


def heading(title: str, explanation: str = "") -> str:
    """A heading inside a section with a line under it."""
    return f"<h3>{escape(title)}</h3>" + note(explanation)


def note(text: str) -> str:
    """A line of explanation."""
    return f'<p class="note">{escape(text)}</p>' if text else ""
