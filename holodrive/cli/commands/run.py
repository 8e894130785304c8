"""`holodrive run`."""

import math
import shlex
import time
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from holodrive.cli.compiling import compiling
from holodrive.cli.faults import INTERRUPTED
from holodrive.cli.options import (
    checked_ending,
    estimator_option,
    out_option,
    plant_option,
    pose_of,
    quantity_of,
    robot_argument,
    seed_option,
    set_option,
    split_settings,
    verb,
    world_option,
)
from holodrive.cli.output import Output
from holodrive.cli.params_file import params_option, with_file
from holodrive.cli.path_options import path_options, trajectory_of
from holodrive.cli.words import can_be_rerun, file_size, outcome, robot_line, world_line
from holodrive.errors import InputError

if TYPE_CHECKING:
    from holodrive.log.run import Run
    from holodrive.references import Table
    from holodrive.sim import SimBase

KEYS_DURATION_S = 3600.0


@verb(
    "run",
    [
        "hybrid3 -w paper_course --via 0.5,0.5 --via 1,1.5 --via 0.5,4.5 -o run.mcap",
        "mecanum4_mice -c la_g --plant pwm_map --path infinity --size 150mm --speed '20 mm/s' --report run.html",
        "hybrid3_table_x -w paper_course --plan bee_colony -c pid",
    ],
)
@robot_argument
@world_option
@click.option("-c", "--controller", default="go_to_pose", show_default=True, help="See holodrive list controllers.")
@click.option("--goal", metavar="X,Y[,HEADING]", help="Where to go; the world's goal when not given.")
@click.option(
    "--via", multiple=True, metavar="X,Y[,HEADING]", help="A way point; may be repeated, the last is the goal."
)
@path_options
@click.option(
    "--plan", "planner", metavar="PLANNER", help="Plan a way past what stands and follow it: bee_colony, visibility."
)
@click.option("--margin", default="5 cm", show_default=True, help="What a plan keeps free around the robot.")
@click.option("--keys", is_flag=True, help="Drive by keyboard in this terminal.")
@click.option("--start", metavar="X,Y[,HEADING]", help="Where to start; the world's start when not given.")
@click.option("--duration", metavar="TIME", help="At most so long on the robot's clock: 30 or '2 min'.")
@click.option("--real-time", is_flag=True, help="Keep to the wall clock.")
@plant_option
@estimator_option
@seed_option
@set_option
@params_option
@click.option("--report", "report_path", type=click.Path(), help="Write a one-file HTML report.")
@out_option("Write a log (MCAP).")
def command(out: Output, **options: Any) -> int:
    """Drive ROBOT (a name or a file) in a world and say how it went."""
    import holodrive as hd

    checked_ending(options["path"], "--out", ".mcap")
    checked_ending(options["report_path"], "--report", ".html", ".htm")
    overrides, params = split_settings(options["settings"])
    options["controller"], params = with_file(options["params_path"], options["controller"], params)
    robot = hd.load(options["robot"], overrides)
    start = pose_of(options["start"], "--start") if options["start"] else None
    if start is not None and len(start) == 2:
        start = (*start, 0.0)
    base = hd.simulate(robot, options["world"], plant=options["plant"], seed=options["seed"], start=start)
    if not out.json:
        out.line("robot", robot_line(robot))
        out.line("world", world_line(base.world))
    clock = Clock()
    run = _by_keys(out, base, options) if options["keys"] else _by_controller(out, base, params, options, clock)
    factor = clock.factor(float(run.time[-1]))
    if run.damage:
        out.warn(run.damage)
    run.settings["command"] = shlex.join(["holodrive", *out.arguments])
    if options["report_path"]:
        hd.report(run).save(options["report_path"])
    _say(out, run, factor, options)
    return INTERRUPTED if run.ended == "interrupted" else 0


class Clock:
    """How fast the simulation runs against the wall clock, without the first ticks, in which kernels are compiled."""

    FIRST = 3  # ticks that do not count

    def __init__(self) -> None:
        self.ticks, self.began, self.since = 0, math.nan, math.nan

    def tick(self, simulated_s: float) -> None:
        """A tick of the loop has come."""
        self.ticks += 1
        if self.ticks == self.FIRST:
            self.began, self.since = time.perf_counter(), simulated_s

    def factor(self, simulated_s: float) -> float:
        """Simulated time over wall time; NaN after too few ticks."""
        return (simulated_s - self.since) / (time.perf_counter() - self.began)


def _by_controller(
    out: Output, base: "SimBase", params: dict[str, Any], options: dict[str, Any], clock: Clock
) -> "Run":
    import holodrive as hd

    goals = _goals(out, base, options)
    duration = quantity_of(options["duration"], "--duration", "time") if options["duration"] else None
    trajectory = goals.get("trajectory")
    length = duration or (trajectory.duration_s + 2.0 if trajectory else 60.0)
    with compiling(out) as ready, out.progress("run", length, "s simulated") as update:

        def progress(done: float) -> None:
            clock.tick(done)
            if clock.ticks >= Clock.FIRST:
                ready()
            update(done)

        return hd.drive(
            base,
            options["controller"],
            **goals,
            estimator=options["estimator"],
            params=params or None,
            duration_s=duration,
            log=options["path"],
            real_time=options["real_time"],
            progress=progress,
        )


def _goals(out: Output, base: "SimBase", options: dict[str, Any]) -> dict[str, Any]:
    from holodrive import control

    control.plug_class(options["controller"])
    asked = [name for name in ("goal", "via", "shape") if options[name]]
    if len(asked) > 1:
        raise InputError("a run has one reference: --goal, --via or --path")
    if not asked and (base.world is None or base.world.goal is None):
        name = base.world.name if base.world else "open"
        raise InputError(f"world {name!r} has no goal; say where to: --goal X,Y, --via X,Y, --path, or another --world")
    if options["planner"]:
        if options["via"] or options["shape"]:
            raise InputError("--plan finds the way to --goal or to the world's goal by itself: no --via, no --path")
        return {"trajectory": _planned(out, base, options)}
    if options["goal"]:
        return {"goal": pose_of(options["goal"], "--goal")}
    if options["via"]:
        points = [pose_of(text, "--via") for text in options["via"]]
        if len({len(point) for point in points}) > 1:
            raise InputError("--via: give all way points a heading or none")
        return {"waypoints": points}
    return {"trajectory": trajectory_of(options, base.truth)} if options["shape"] else {}


def _planned(out: Output, base: "SimBase", options: dict[str, Any]) -> "Table":
    import holodrive as hd

    goal = pose_of(options["goal"], "--goal") if options["goal"] else None
    margin, place = quantity_of(options["margin"], "--margin", "length"), base.world if base.world else hd.world(None)
    plan = hd.plan(
        base.robot, place, options["planner"], start=base.truth, goal=goal, margin_m=margin, seed=options["seed"]
    )
    if not out.json:
        turns = f"{plan.turns} turn{'' if plan.turns == 1 else 's'}"
        room = f"{100.0 * plan.clearance_m:.1f} cm clear" if plan.clearance_m < math.inf else "nothing in the way"
        out.line("plan", f"{plan.planner}: {plan.length_m:.3f} m, {turns}, {room}")
    return plan.reference(base.robot)


def _by_keys(out: Output, base: "SimBase", options: dict[str, Any]) -> "Run":
    import holodrive as hd
    from holodrive.runtime import KeyTeleop, TerminalKeys
    from holodrive.runtime.teleop import HELP

    with TerminalKeys() as keys:
        out.note(HELP)
        duration = quantity_of(options["duration"], "--duration", "time") if options["duration"] else KEYS_DURATION_S
        return hd.drive(
            base,
            KeyTeleop(keys),
            goal=tuple(base.truth),
            estimator=options["estimator"],
            duration_s=duration,
            log=options["path"],
            real_time=True,
        )


def _say(out: Output, run: "Run", factor: float, options: dict[str, Any]) -> None:
    simulated = float(run.time[-1]) if len(run.time) else 0.0
    path, report = options["path"], options["report_path"]
    if out.json:
        answer = {"settings": run.settings, "metrics": run.metrics, "real_time_factor": factor}
        out.data(answer | {"log": path, "report": report})
    else:
        kind = f"{run.settings['controller']}, {options['plant']}, seed {options['seed']}"
        speed = f", {factor:.0f}x real time" if factor > 0.0 and not options["keys"] else ""
        out.line("run", f"{kind}: {simulated:.2f} s simulated{speed}")
        out.line("result", outcome(run))
        if path:
            out.line("log", f"{path} ({file_size(Path(path).stat().st_size)}, id {run.settings['id']})")
        if report:
            out.line("report", report)
    again = shlex.join(["holodrive", *out.arguments, "-o", "run.mcap"])
    look = f"holodrive replay {path}{' --rerun' if can_be_rerun(run) else ''}"
    out.next(look if path else again)
