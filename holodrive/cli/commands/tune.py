"""`holodrive tune`."""

import shlex
from contextlib import AbstractContextManager
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import click

from holodrive.cli.compiling import compiling
from holodrive.cli.faults import INTERRUPTED
from holodrive.cli.options import (
    checked_ending,
    out_option,
    plant_option,
    pose_of,
    quantity_of,
    robot_argument,
    set_option,
    split_settings,
    verb,
    world_option,
)
from holodrive.cli.output import Output
from holodrive.cli.path_options import path_options, trajectory_of
from holodrive.errors import InputError

if TYPE_CHECKING:
    from holodrive.robots.spec import Robot
    from holodrive.tuning import Job, Problem, Space, Step, Tuned

GENERATED_RUNS, LISTED_RUNS = 32, 8  # of a candidate: random worlds differ more than the noise in one world does


@verb(
    "tune",
    [
        "hybrid3_table_x -c pid --path circle --metric rms_error_m --budget 2000 -o tuned.json",
        "hybrid3_table_x -c fuzzy --worlds course --metric success --budget 20000 -o tuned.json --report tuned.html",
        "mecanum4 -w room --field k_xy=0.3:5:log --field k_theta=0.3:5:log --metric time_s",
    ],
)
@robot_argument
@click.option("-c", "--controller", default="go_to_pose", show_default=True, help="See holodrive list controllers.")
@world_option
@click.option("--worlds", type=click.Choice(["course", "generate"]), help="Random worlds, another for each run.")
@click.option("--crossers", default=0, type=click.IntRange(0), help="Moving obstacles of each course.")
@click.option("--goal", metavar="X,Y[,HEADING]", help="Where to go; the world's goal when not given.")
@path_options
@click.option("--duration", metavar="TIME", help="At most so long for a run; the path's length, 90 s or 60 s.")
@click.option("--metric", help="success, a metric, or a sum such as rms_error_m+0.1*max_error_m.")
@click.option("--fields", metavar="A,B,C", help="Fields to tune; all that the controller names when not given.")
@click.option("--field", "ranges", multiple=True, metavar="A=LOW:HIGH[:log]", help="A field with bounds of your own.")
@click.option("--budget", default=20_000, show_default=True, type=click.IntRange(1), help="Runs to search with.")
@click.option("--runs", type=click.IntRange(1), help="For each candidate; 32 in random worlds, else 8.")
@click.option("--population", type=click.IntRange(4), help="Candidates of a generation.")
@click.option("--sigma", default=0.2, show_default=True, help="First spread, as a share of the ranges.")
@click.option("--validate", default=200, show_default=True, type=click.IntRange(1), help="Runs to choose by.")
@click.option("--held-out", default=500, show_default=True, type=click.IntRange(1), help="Runs to judge by.")
@click.option("--seed", default=0, show_default=True, type=click.IntRange(0), help="Of the search.")
@plant_option
@set_option
@click.option("--workers", type=click.IntRange(1), help="Threads; all cores when not given.")
@click.option("--cluster", metavar="ADDRESS", help="A Dask scheduler instead: tcp://host:8786.")
@click.option("--report", "report_path", type=click.Path(), help="Write a one-file HTML report.")
@out_option("Write the result, for holodrive run --params (JSON).")
def command(out: Output, **options: Any) -> int:
    """Search better parameters for a controller of ROBOT, and judge them in runs that the search has not seen."""
    from holodrive import tuning

    checked_ending(options["path"], "--out", ".json")
    checked_ending(options["report_path"], "--report", ".html", ".htm")
    if options["cluster"] and options["workers"]:
        raise InputError("--workers counts threads here; a cluster has its own: give --workers or --cluster")
    problem = _problem(options)
    with compiling(out) as ready, Told(out) as told:

        def progress(step: "Step") -> None:
            ready()
            told.step(step)

        found = tuning.tune(
            problem,
            budget=options["budget"],
            seed=options["seed"],
            runs=options["runs"] or (GENERATED_RUNS if problem.job.places.generator else LISTED_RUNS),
            validation_seeds=_some(tuning.VALIDATION, options["validate"]),
            heldout_seeds=_some(tuning.HELD_OUT, options["held_out"]),
            population=options["population"],
            sigma=options["sigma"],
            backend=options["cluster"] or options["workers"],
            progress=progress,
        )
    found = replace(found, settings={**found.settings, "goal": "path" if options["shape"] else "goal",
                                     "command": shlex.join(["holodrive", *out.arguments])})  # fmt: skip
    _say(out, found, options)
    return INTERRUPTED if found.ended == "interrupted" else 0


class Told:
    """Progress of the phases, one bar after another."""

    def __init__(self, out: Output) -> None:
        self._out = out
        self._phase = ""
        self._bar: AbstractContextManager[Any] | None = None
        self._update: Any = None

    def step(self, step: "Step") -> None:
        """Runs are done."""
        if step.phase != self._phase:
            self._close()
            self._phase = step.phase
            self._bar = self._out.progress("tune", step.total, f"runs, {step.phase}")
            self._update = self._bar.__enter__()
        self._update(step.done)

    def _close(self) -> None:
        if self._bar is not None:
            self._bar.__exit__(None, None, None)
            self._bar = None

    def __enter__(self) -> "Told":
        return self

    def __exit__(self, *error: object) -> None:
        self._close()


def _problem(options: dict[str, Any]) -> "Problem":
    import holodrive as hd
    from holodrive import tuning

    if options["worlds"] and options["world"]:
        raise InputError("tuning takes place in one world or in random ones: -w or --worlds")
    if options["worlds"] and options["shape"]:
        raise InputError("random worlds start anywhere: --path goes with one world (-w), --worlds with their goals")
    if options["goal"] and options["shape"]:
        raise InputError("a run has one reference: --goal or --path")
    overrides, params = split_settings(options["settings"])
    robot = hd.load(options["robot"], overrides)
    objective = tuning.Objective.parse(options["metric"] or ("rms_error_m" if options["shape"] else "success"))
    space = _space(options)
    return tuning.Problem(_job(robot, params, options), space, objective)


def _space(options: dict[str, Any]) -> "Space":
    from holodrive import tuning

    names = [name.strip() for name in (options["fields"] or "").split(",") if name.strip()]
    return tuning.space(options["controller"], names, [tuning.parse_range(text) for text in options["ranges"]])


def _job(robot: "Robot", params: dict[str, Any], options: dict[str, Any]) -> "Job":
    import holodrive as hd
    from holodrive import tuning

    places = (
        tuning.Places(options["worlds"], options["crossers"])
        if options["worlds"]
        else tuning.Places.of(hd.world(options["world"]))
    )
    if options["crossers"] and not options["worlds"]:
        raise InputError("--crossers go with --worlds course")
    start = (0.0, 0.0, 0.0) if options["worlds"] else tuple(hd.world(options["world"]).start)
    goal = pose_of(options["goal"], "--goal") if options["goal"] else None
    return tuning.job(
        robot,
        places,
        options["controller"],
        params=params,
        goal=None if goal is None else (*goal, start[2])[:3],
        reference=trajectory_of(options, start).recipe if options["shape"] else None,
        t=quantity_of(options["duration"], "--duration", "time") if options["duration"] else None,
        plant=options["plant"],
    )


def _some(numbers: range, count: int) -> range:
    """The first of the numbers that are meant for a purpose; they must not run into those of the next."""
    most = 10_000 if numbers.start < 30_000 else 70_000
    if count > most:
        raise InputError(f"there are {most} numbers for these runs; found {count}")
    return range(numbers.start, numbers.start + count)


def _say(out: Output, found: "Tuned", options: dict[str, Any]) -> None:
    from holodrive.cli import tuning_page as pages

    path, report = options["path"], options["report_path"]
    if path:
        found.save(path)
    if report:
        pages.page(found, found.settings["command"]).save(report)
    if out.json:
        out.text(found.to_json())
    else:
        runs = found.history[-1].runs if found.history else 0
        out.line(
            "tune", f"{found.controller} of {found.robot} for {found.objective}: {runs} runs, ended: {found.ended}"
        )
        for table in (pages.judged_table(found), pages.values_table(found)):
            if table is not None:
                out.text(table.text() + "\n")
        out.line("result", pages.gain_line(found))
        if found.best:
            out.line("use", found.options)
        for label, file in (("file", path), ("report", report)):
            if file:
                out.line(label, file)
    where = f" -w {shlex.quote(options['world'])}" if options["world"] else ""
    where += " -w paper_course" if options["worlds"] else ""
    if options["shape"]:
        where += " " + shlex.join(["--path", options["shape"], "--size", options["size"], "--speed", options["speed"]])
    robot = shlex.quote(options["robot"])
    again = shlex.join(["holodrive", *out.arguments, "-o", "tuned.json"])
    out.next(f"holodrive run {robot}{where} -c {found.controller} --params {path}" if path else again)
