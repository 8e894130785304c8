"""Path pictures of reports: one run with what its replay moves, or several runs in one world."""

from collections.abc import Sequence

from holodrive.log.drawing import Trace, best_pose, bounds_of, changes, drawn, framed, last_robot, scene
from holodrive.log.run import Run
from holodrive.log.shapes import collision_shapes, goal_shape, world_shapes
from holodrive.log.view import View
from holodrive.reports.plots import COLOURS, DASHES
from holodrive.reports.replay import live_layer

WIDTH, HEIGHT = 620.0, 600.0  # px


def run_scene(run: Run) -> tuple[str, View]:
    """One run over its world, with the layer that the page's script moves; and the view it was drawn in."""
    view = View.fit(bounds_of([run]), WIDTH, HEIGHT, header=26.0)
    return scene(run, view, live_layer([run], run.world, view)), view


def together(runs: Sequence[Run]) -> bool:
    """Whether runs can be laid over each other: all in the same world."""
    return all(run.world == runs[0].world for run in runs)


def run_traces(runs: Sequence[Run], names: Sequence[str]) -> list[Trace]:
    """One line a run, told apart by colour and by dashes."""
    return [
        Trace(name, best_pose(run), f"c{i % len(COLOURS)}", COLOURS[i % len(COLOURS)], DASHES[i % len(DASHES)], 2.2)
        for i, (run, name) in enumerate(zip(runs, names, strict=True))
    ]


def comparison_scene(runs: Sequence[Run], names: Sequence[str], *, live: bool = True) -> tuple[str, View]:
    """Several runs laid over each other in the world of the first."""
    view = View.fit(bounds_of(runs), WIDTH, HEIGHT, header=26.0)
    lines = run_traces(runs, names)
    world = runs[0].world
    end = max((float(run.time[-1]) for run in runs if len(run.time)), default=0.0)
    reference = Trace("", changes(runs[0].reference), "reference", "#5b6675", "1 5", 2.0)
    where = world.name if world else "an open floor"
    title = f"Paths of {len(runs)} runs on {where}: {', '.join(names)}."
    children = [
        goal_shape(world, view) if world else "",
        world_shapes(world, view, end) if world else "",
        drawn(reference, view),
        *(last_robot(run, view, "last") for run in runs),
        *(drawn(line, view) for line in lines),
        *(collision_shapes(run.events, view) for run in runs),
        live_layer(runs, world, view) if live else "",
    ]
    return framed(view, lines, title, *children), view
