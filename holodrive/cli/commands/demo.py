"""`holodrive demo`: three robots in their worlds and a recorded one, in one table and one page."""

import math
import time
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import click

from holodrive.cli.compiling import compiling
from holodrive.cli.options import seed_option, verb
from holodrive.cli.output import Output
from holodrive.cli.words import file_size

if TYPE_CHECKING:
    from holodrive.log.run import Run
    from holodrive.references import Table
    from holodrive.reports.sections import RecordingSection

LEAD = (
    "Three robots of the catalog drive in simulation, and a real robot with three omni wheels is replayed from its "
    "recording: its wheel odometry against motion-capture truth."
)
NEXT = (
    ("holodrive list", "robots, worlds, controllers, motors and sensors that there are"),
    ("holodrive kinematics hybrid3", "Jacobian, condition and top speeds of a base"),
    ("holodrive replay out/demo/hybrid3.mcap --rerun", "compute a run again from its log and compare every number"),
    ("holodrive run mecanum4 --keys", "drive by keyboard"),
    ("holodrive new robot my_base", "a commented start for a base of your own"),
)
FIGURES = ("time_s", "path_length_m", "final_error_m", "final_heading_error_rad", "min_clearance_m", "collisions")


class Stage(NamedTuple):
    """One robot with its job."""

    robot: str
    world: str
    job: str
    start: tuple[float, float, float] | None
    reference: Callable[[], dict[str, Any]]


def _infinity() -> "Table":
    from holodrive import planning

    return planning.follow(planning.lemniscate(0.150), speed_m_s=0.020)


STAGES = (
    Stage(
        "hybrid3",
        "paper_course",
        "way points through the gap",
        None,
        lambda: {"waypoints": [(0.5, 0.5), (1.0, 1.5), (0.5, 4.5)]},
    ),
    Stage("mecanum4", "open", "infinity sign, half width 150 mm", (0.0, 0.0, 0.0), lambda: {"trajectory": _infinity()}),
    Stage(
        "swerve3",
        "open",
        "to (10 m, 10 m, 180°)",
        (0.0, 0.0, 0.0),
        lambda: {"goal": (10.0, 10.0, 3.141592653589793), "duration_s": 120.0},
    ),
)


@verb("demo", ["", "-o tour --seed 3"])
@click.option("-o", "--out", "folder", default="out/demo", show_default=True, type=click.Path(file_okay=False))
@seed_option
def command(out: Output, folder: str, seed: int) -> None:
    """Drive three robots in their worlds, replay a recorded real one; print one table, write one page."""
    began = time.perf_counter()
    place = Path(folder)
    place.mkdir(parents=True, exist_ok=True)
    runs = [_drive(out, stage, place, seed) for stage in STAGES]
    recording, recorded = _recorded(out)
    rows = [_row(stage, run) for stage, run in zip(STAGES, runs, strict=True)] + [recorded]
    page = place / "demo.html"
    for run in runs:
        run.settings["command"] = f"holodrive replay {run.path} --rerun"
    _write_page(page, runs, recording, rows)
    _write_sheet(place / "demo.svg", runs, recording)
    wall = time.perf_counter() - began
    if out.json:
        out.data({"rows": rows, "page": str(page), "logs": [str(run.path) for run in runs], "wall_s": wall})
        return
    from holodrive.reports import tables

    out.text(tables.table(rows).text())
    out.text("")
    out.line("picture", str(place / "demo.svg"))
    out.line("page", f"{page} ({file_size(page.stat().st_size)}, one file, opens without a network)")
    out.line("time", f"{wall:.1f} s for {sum(float(run.time[-1]) for run in runs):.0f} s of driving")
    out.next(f"holodrive replay {runs[0].path} --rerun")


def _drive(out: Output, stage: Stage, place: Path, seed: int) -> "Run":
    import holodrive as hd

    reference = stage.reference()
    total = reference.get("duration_s") or (reference["trajectory"].duration_s if "trajectory" in reference else 60.0)
    log = place / f"{stage.robot}.mcap"
    with compiling(out) as ready, out.progress(stage.robot, total, "s simulated") as update:
        base = hd.simulate(stage.robot, stage.world, plant="slip", seed=seed, start=stage.start)

        def progress(done: float) -> None:
            if done > 0.1:  # by then all kernels are there
                ready()
            update(done)

        run = hd.drive(base, **reference, log=log, progress=progress)
    if run.ended == "interrupted":  # half a run is no result
        raise KeyboardInterrupt
    return run


def _row(stage: Stage, run: "Run") -> dict[str, Any]:
    figures = {name: run.metrics[name] for name in FIGURES if math.isfinite(run.metrics.get(name, math.nan))}
    return {"robot": stage.robot, "job": stage.job, "ended": run.ended, **figures}


def _write_page(page: Path, runs: "list[Run]", recording: "RecordingSection", rows: list[dict[str, Any]]) -> None:
    from holodrive.reports import tables
    from holodrive.reports.page import Report
    from holodrive.reports.sections import RunSection, Section, TableSection, TextSection

    sections: list[Section] = [
        TableSection("Results", tables.table(rows), "Simulated robots, and one recorded robot against its truth."),
        *(RunSection(run, stage.robot, stage.job) for stage, run in zip(STAGES, runs, strict=True)),
        recording,
        TextSection("What to type next", commands=NEXT),
    ]
    Report("holodrive demo", tuple(sections), LEAD).save(page)


def _write_sheet(path: Path, runs: "list[Run]", recording: "RecordingSection") -> None:
    from holodrive.cli.sheet import sheet
    from holodrive.log.drawing import picture

    pictures = [(stage.robot, picture(run, 420, 420)) for stage, run in zip(STAGES, runs, strict=True)]
    pictures.append((f"{recording.facts['robot']}: recorded", recording.picture()))
    path.write_text(sheet(pictures, "Four robots of the demo"), encoding="utf-8")


def _recorded(out: Output) -> "tuple[RecordingSection, dict[str, Any]]":
    from holodrive.cli.recorded import section
    from holodrive.estimation.evaluation import evaluate
    from holodrive.log import recordings

    name = next(name for name in recordings.shipped() if name.startswith("square"))
    with compiling(out):
        recording = recordings.read(name)
        evaluation = evaluate(recording)
    figures = {
        "time_s": float(evaluation.time[-1] - evaluation.time[0]),
        "path_length_m": evaluation.path_length_m,
        "final_error_m": evaluation.end_error_m,
        "final_heading_error_rad": abs(evaluation.heading_error_rad),
    }
    row = {"robot": evaluation.robot, "job": "recorded square: odometry against truth", "ended": "replayed", **figures}
    return section(recording, evaluation), row
