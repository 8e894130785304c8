"""`holodrive compare`."""

import shlex
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from holodrive.cli.compiling import compiling
from holodrive.cli.options import (
    checked_ending,
    estimator_option,
    out_option,
    plant_option,
    pose_of,
    seed_option,
    set_option,
    split_settings,
    verb,
)
from holodrive.cli.output import Output
from holodrive.cli.path_options import path_options, trajectory_of
from holodrive.errors import InputError

if TYPE_CHECKING:
    from holodrive.log.run import Run


@verb(
    "compare",
    [
        "hybrid3 -w room -c go_to_pose,pid --runs 5 -o compare.html",
        "mecanum4_mice --plant pwm_map --path eight --size 150mm --speed '20 mm/s' -c la_g,ff_pi,dob,mpc",
        "monday.mcap tuesday.mcap --json",
    ],
)
@click.argument("what", nargs=-1, required=True, metavar="ROBOT | RUN.mcap...")
@click.option("-w", "--world", metavar="WORLD", help="World, by name or file; the open floor when not given.")
@click.option(
    "-c",
    "--controllers",
    multiple=True,
    default=("go_to_pose,pid",),
    show_default=True,
    help="Names with commas between; may be repeated.",
)
@click.option("--runs", default=3, show_default=True, type=click.IntRange(1), help="Seeds for each controller.")
@click.option("--goal", metavar="X,Y[,HEADING]", help="Where to go; the world's goal when not given.")
@path_options
@plant_option
@estimator_option
@seed_option
@set_option
@out_option("Write a one-file HTML report of all runs side by side.")
def command(out: Output, what: tuple[str, ...], path: str | None, **options: Any) -> None:
    """Set controllers side by side in one world with the same seeds, or recorded runs."""
    import holodrive as hd

    checked_ending(path, "--out", ".html", ".htm")
    logs = all(name.endswith(".mcap") for name in what)
    if not logs and len(what) > 1:
        raise InputError(
            f"compare takes one robot, or logs that end in .mcap; found {' '.join(what)}; controllers stand after -c"
        )
    short = len({Path(name).stem for name in what}) == len(set(what))
    groups = (
        {Path(name).stem if short else name: [hd.read(name)] for name in what}
        if logs
        else _drive(out, what[0], options)
    )
    rows = [_row(name, runs) for name, runs in groups.items()]
    if path:
        hd.report([runs[0] for runs in groups.values()]).save(path)
    if out.json:
        out.data({"runs": {name: [run.metrics for run in runs] for name, runs in groups.items()}, "report": path})
    else:
        names = list(dict.fromkeys(key for row in rows for key in row if key != "name"))
        header = ["metric", *(str(row["name"]) for row in rows)]
        out.table(header, [[key, *(row.get(key, "-") for row in rows)] for key in names])
        if path:
            out.line("report", path)
    again = shlex.join(["holodrive", *out.arguments, "-o", "compare.html"])
    out.next(again if not path else f"holodrive compare --help; the page is {path}")


def _drive(out: Output, robot: str, options: dict[str, Any]) -> dict[str, list["Run"]]:
    import holodrive as hd

    overrides, params = split_settings(options["settings"])
    described, world = hd.load(robot, overrides), hd.world(options["world"])
    listed = ",".join(options["controllers"]).split(",")
    controllers = list(dict.fromkeys(name.strip() for name in listed if name.strip()))
    if options["goal"] and options["shape"]:
        raise InputError("a run has one reference: --goal or --path")
    goal = pose_of(options["goal"], "--goal") if options["goal"] else None
    seeds = range(options["seed"], options["seed"] + options["runs"])
    groups: dict[str, list[Run]] = {}
    with compiling(out) as ready, out.progress("compare", len(controllers) * len(seeds), "runs") as update:
        for controller in controllers:
            for seed in seeds:
                base = hd.simulate(described, world, plant=options["plant"], seed=seed)
                wanted = {"trajectory": trajectory_of(options, base.truth)} if options["shape"] else {"goal": goal}
                run = hd.drive(base, controller, estimator=options["estimator"], params=params or None, **wanted)
                ready()
                if run.ended == "interrupted":  # half a run is no result
                    raise KeyboardInterrupt
                groups.setdefault(controller, []).append(run)
                update(sum(map(len, groups.values())))
    return groups


def _row(name: str, runs: Sequence["Run"]) -> dict[str, str]:
    """Median of each metric, with its range when there are several runs."""
    import numpy as np

    row = {"name": name, "runs": str(len(runs))}
    for key in runs[0].metrics:
        values = np.array([run.metrics.get(key, np.nan) for run in runs])
        values = values[np.isfinite(values)]
        if not len(values):
            row[key] = "-"
        elif values.min() == values.max():
            row[key] = f"{values[0]:.4g}"
        else:
            row[key] = f"{np.median(values):.4g} ({values.min():.4g} .. {values.max():.4g})"
    return row
