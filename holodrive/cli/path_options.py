"""`--path`, `--size`, `--speed`: a path to follow from where the robot starts, for every verb that drives one."""

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any

import click

from holodrive.cli.options import quantity_of

if TYPE_CHECKING:
    from holodrive.references import Table

PATHS = ("circle", "infinity", "eight")
Function = Callable[..., Any]


def path_options(function: Function) -> Function:
    """Adds the three options; the path arrives as `shape`."""
    function = click.option("--speed", default="0.1 m/s", show_default=True, help="Along the path.")(function)
    function = click.option("--size", default="0.5 m", show_default=True, help="Radius or half width of the path.")(
        function
    )
    return click.option("--path", "shape", type=click.Choice(PATHS), help="A path to follow from the start.")(function)


def trajectory_of(options: dict[str, Any], start: Sequence[float]) -> "Table":
    """The path that the options ask for, from `start` (x, y, heading) [m, m, rad] on, with that heading all the way."""
    from holodrive import planning

    size = quantity_of(options["size"], "--size", "length")
    x, y, theta = start
    path = (
        planning.circle(size, (x - size, y))
        if options["shape"] == "circle"
        else planning.lemniscate(size, (x, y), upright=options["shape"] == "eight")
    )
    return planning.follow(path, quantity_of(options["speed"], "--speed", "speed"), heading_rad=theta)
