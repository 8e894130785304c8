"""`holodrive list`."""

from collections.abc import Callable
from importlib import import_module

import click

from holodrive.cli.options import verb
from holodrive.cli.output import Output

Rows = list[tuple[str, str]]  # name, what it is


def _described(library: str) -> Rows:
    module = import_module(f"holodrive.{library}")
    return [(name, module.load(name).title) for name in module.names()]


def _registered(package: str) -> Rows:
    module = import_module(f"holodrive.{package}")
    return [(name, module.summary(name)) for name in module.names()]


def _parts(library: str) -> Rows:
    module = import_module(f"holodrive.robots.{library}")
    return [(name, module.summary(name)) for name in module.names()]


KINDS: dict[str, Callable[[], Rows]] = {
    "robots": lambda: _described("robots"),
    "worlds": lambda: _described("worlds"),
    "controllers": lambda: _registered("control"),
    "estimators": lambda: _registered("estimation"),
    "motors": lambda: _parts("motors"),
    "sensors": lambda: _parts("sensors"),
}


@verb("list", ["", "robots --json"])
@click.argument("kinds", nargs=-1, type=click.Choice(list(KINDS)), metavar="[robots|worlds|controllers|...]...")
def command(out: Output, kinds: tuple[str, ...]) -> None:
    """List what is there by name: robots, worlds, controllers, estimators, motors, sensors (all when none is named)."""
    found = {kind: KINDS[kind]() for kind in kinds or KINDS}
    if out.json:
        out.data({kind: [{"name": name, "title": title} for name, title in rows] for kind, rows in found.items()})
        return
    width = max((len(name) for rows in found.values() for name, _ in rows), default=0)
    for number, (kind, rows) in enumerate(found.items()):
        out.text(("\n" if number else "") + click.style(kind, bold=True))
        for name, title in rows:
            out.text(f"  {name:<{width}}  {title}".rstrip())
    out.next("holodrive kinematics hybrid3")
