"""`holodrive replay`: logs of this package, and recordings of real robots."""

from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from holodrive.cli.compiling import compiling
from holodrive.cli.options import checked_ending, out_option, verb
from holodrive.cli.output import Output
from holodrive.cli.recorded import FIGURES, evaluation_row, section
from holodrive.cli.words import can_be_rerun, outcome, robot_line, world_line
from holodrive.errors import InputError

if TYPE_CHECKING:
    from holodrive.estimation import Evaluation
    from holodrive.log.recording import Recording
    from holodrive.log.run import Run

SHOWN_EVENTS = 5


@verb("replay", ["run.mcap --rerun", "recording.csv --robot my_base.toml -o odometry.html"])
@click.argument("recording", required=False)
@click.option("--rerun", is_flag=True, help="Compute a simulated run again and compare every number.")
@click.option("--run", "which", metavar="NAME", help="Which run of a file that holds several; all when not given.")
@click.option("--robot", metavar="ROBOT", help="Whose geometry to use; the recording's own when not given.")
@click.option("--odometry", is_flag=True, help="Judge the wheel odometry of a log as that of a recording.")
@out_option("Write a page (.html) or a picture (.svg).")
def command(
    out: Output,
    recording: str | None,
    rerun: bool,
    which: str | None,
    robot: str | None,
    odometry: bool,
    path: str | None,
) -> int:
    """Look again at RECORDING: a log of holodrive, or what a real robot recorded (formats: docs/recordings.md).

    A log tells how it went. A recording's wheel odometry is integrated and judged by the truth in it.
    Without RECORDING, those that come with the package are replayed.
    """
    checked_ending(path, "--out", ".html", ".svg", ".png", ".gif")
    if recording and recording.endswith(".mcap") and not (odometry or robot or which):
        return _log(out, recording, rerun, path)
    if rerun:
        raise InputError(f"--rerun computes a simulated run from its log (.mcap); {recording or 'this'} is a recording")
    _recordings(out, recording, which, robot, path)
    return 0


def _log(out: Output, name: str, rerun: bool, path: str | None) -> int:
    import holodrive as hd

    run = hd.read(name)
    if run.damage:
        out.warn(run.damage)
    differences = _again(out, run) if rerun else []
    if path:
        hd.report(run).save(path) if path.endswith(".html") else hd.render(run, path)
    if out.json:
        answer = {"settings": run.settings, "metrics": run.metrics, "ticks": len(run.time), "scans": len(run.scans)}
        events = [asdict(event) for event in run.events]
        out.data(
            answer | {"events": events} | ({"identical": not differences, "differences": differences} if rerun else {})
        )
    else:
        _say_log(out, run, path)
        if rerun and not differences:
            out.line("rerun", f"identical: {len(run.time)} ticks, {len(run.scans)} scans, {len(run.events)} events")
        for difference in differences:
            out.line("rerun", f"differs: {difference['text']}")
    render = f"holodrive render {name} -o {Path(name).stem}.gif"
    out.next(render if rerun or not can_be_rerun(run) else f"holodrive replay {name} --rerun")
    return 1 if differences else 0


def _say_log(out: Output, run: "Run", path: str | None) -> None:
    out.line("robot", robot_line(run.robot))
    out.line("world", world_line(run.world))
    settings = run.settings
    known = [f"{key} {settings[key]}" for key in ("controller", "plant", "seed", "id") if key in settings]
    out.line("run", f"{', '.join(known)}: {len(run.time)} ticks, {len(run.scans)} scans")
    out.line("result", outcome(run))
    for event in run.events if out.verbose else run.events[:SHOWN_EVENTS]:
        out.line("event", f"{event.time:8.2f} s  {event.kind}: {event.text}")
    if len(run.events) > SHOWN_EVENTS and not out.verbose:
        out.line("event", f"... and {len(run.events) - SHOWN_EVENTS} more (-v shows them)")
    if path:
        out.line("wrote", path)


def _again(out: Output, run: "Run") -> list[dict[str, Any]]:
    import holodrive as hd

    with compiling(out) as ready, out.progress("rerun", float(run.time[-1]) or 1.0, "s simulated") as update:

        def progress(done: float) -> None:
            if done > 0.1:  # by then all kernels are there
                ready()
            update(done)

        return [asdict(difference) for difference in hd.rerun(run, progress=progress).differences]


def _recordings(out: Output, name: str | None, which: str | None, robot: str | None, path: str | None) -> None:
    import holodrive as hd
    from holodrive.estimation.evaluation import evaluate, medians

    geometry = hd.load(robot) if robot else None
    recordings = _read(name, which, robot)
    with compiling(out):
        pairs = [(recording, evaluate(recording, geometry)) for recording in recordings]
    evaluations = [evaluation for _, evaluation in pairs]
    if path:
        _write(path, pairs)
    middle = medians(evaluations)
    if out.json:
        runs = [evaluation_row(evaluation) | {"counts": asdict(evaluation.counts)} for evaluation in evaluations]
        out.data({"runs": runs, "medians": [asdict(row) for row in middle], "wrote": path})
    else:
        _say_evaluations(out, evaluations, [asdict(row) for row in middle])
        if path:
            out.line("wrote", path)
    what = f"holodrive replay {name or ''}".strip()
    out.next(f"{what} -o odometry.html" if not path else "holodrive list robots")


def _read(name: str | None, which: str | None, robot: str | None) -> "list[Recording]":
    from holodrive.log import recordings

    if name is None:
        return [recordings.read(shipped) for shipped in recordings.shipped()]
    if which is not None:
        return [recordings.read(name, which, robot=robot)]
    return recordings.read_all(name, robot=robot)


def _say_evaluations(out: Output, evaluations: "list[Evaluation]", middle: list[dict[str, Any]]) -> None:
    from holodrive.reports.tables import table

    rows = [evaluation_row(evaluation) for evaluation in evaluations]
    if len(rows) <= 5 or out.verbose:
        out.text(table(rows, ["name", *FIGURES, "refused"]).text())
    if len(rows) > 1:
        out.text(("\n" if len(rows) <= 5 or out.verbose else "") + "medians")
        out.text(table(middle, ["family", "runs", *FIGURES, "refused"]).text())


def _write(path: str, pairs: "list[tuple[Recording, Evaluation]]") -> None:
    from holodrive.reports.page import Report

    sections = [section(recording, evaluation) for recording, evaluation in pairs]
    if path.endswith(".html"):
        Report("Wheel odometry against the truth", tuple(sections)).save(path)
    elif path.endswith(".svg") and len(sections) == 1:
        Path(path).write_text(sections[0].picture(), encoding="utf-8")
    else:
        raise InputError(f"-o {path}: write a page (.html), or with one run a picture (.svg)")
