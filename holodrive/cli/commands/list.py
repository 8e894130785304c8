"""`holodrive list`."""

import math
from collections.abc import Callable
from importlib import import_module
from typing import Any

import click

from holodrive.cli.options import verb
from holodrive.cli.output import Output

Rows = list[tuple[str, str]]  # name, what it is


def _described(library: str) -> Rows:
    module = import_module(f"holodrive.{library}")
    return [(name, module.load(name).title) for name in module.names()]


def _controllers() -> Rows:
    from holodrive import control

    return [(name, _first_line(control.plug_class(name))) for name in control.names()]


def _estimators() -> Rows:
    from holodrive import estimation

    return [(name, estimation.summary(name).rstrip(".")) for name in estimation.names()]


def _motors() -> Rows:
    from holodrive.robots import motors

    rows = []
    for name in motors.names():
        motor = motors.load(name)
        rpm = motor.no_load_speed_rad_s * 30.0 / math.pi
        rows.append((name, f"{motor.kind}, {motor.voltage_v:g} V, {rpm:.0f} rpm behind the gear"))
    return rows


def _sensors() -> Rows:
    from holodrive.robots import sensors

    return [(name, _sensor_line(sensors.load(name))) for name in sensors.names()]


def _sensor_line(sensor: Any) -> str:
    kind = type(sensor).__name__.lower()
    source = str(sensor.source).partition("; ")[0]
    return f"{kind}, {source}" if source else kind


def _planners() -> Rows:
    from holodrive import planning

    return [(name, _first_line(planner)) for name, planner in planning.PLANNERS.items()]


def _fuzzy() -> Rows:
    from holodrive.control import fuzzy

    return [(name, fuzzy.load(name).source) for name in fuzzy.names()]


def _first_line(thing: Any) -> str:
    return (thing.__doc__ or "").strip().partition("\n")[0].rstrip(".")


KINDS: dict[str, Callable[[], Rows]] = {
    "robots": lambda: _described("robots"),
    "worlds": lambda: _described("worlds"),
    "controllers": _controllers,
    "fuzzy": _fuzzy,
    "planners": _planners,
    "estimators": _estimators,
    "motors": _motors,
    "sensors": _sensors,
}


@verb("list", ["", "robots --json"])
@click.argument("kinds", nargs=-1, type=click.Choice(list(KINDS)), metavar="[robots|worlds|controllers|...]...")
def command(out: Output, kinds: tuple[str, ...]) -> None:
    """List what is there by name: robots, worlds, controllers, fuzzy profiles, planners, estimators, parts."""
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
