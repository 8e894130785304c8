"""`holodrive check`."""

from pathlib import Path
from typing import Any

import click

from holodrive.cli.faults import report_fault
from holodrive.cli.options import verb
from holodrive.cli.output import Output
from holodrive.errors import FileFaults, HolodriveError


@verb("check", ["my_robot.toml", "robots/*.toml worlds/*.toml --json", "my_controller.fis"])
@click.argument("files", nargs=-1, required=True, type=click.Path())
def command(out: Output, files: tuple[str, ...]) -> int:
    """Look for all faults of robot, world and fuzzy (.fis, .fcl, .fml) FILES at once. Exit code 2 when there is one."""
    results, worst = [], 0
    for file in files:
        try:
            text = _checked(file)
        except HolodriveError as error:
            worst = max(worst, error.exit_code)
            results.append({"file": file, "ok": False, "faults": _faults(error, file)})
            if not out.json:
                report_fault(error, out)
            continue
        results.append({"file": file, "ok": True, "faults": []})
        if not out.json:
            out.text(f"ok     {file}: {text}")
    if out.json:
        out.data(results)
    good = next((result["file"] for result in results if result["ok"]), None)
    out.next(f"mend the lines above, then holodrive check {' '.join(files)}" if worst else _use(str(good)))
    return worst


def _use(good: str) -> str:
    """What to do with a file that is right."""
    if is_fuzzy(good):
        return f"holodrive explain {good}  (its rules at work, and what a linter finds in them)"
    return f"holodrive run hybrid3 -w {good}" if is_world(good) else f"holodrive kinematics {good}"


def _checked(file: str) -> str:
    from holodrive import worlds

    if is_fuzzy(file):
        return _checked_fuzzy(file)
    if is_world(file):
        world = worlds.load(Path(file))
        obstacles = len(world.circles) + len(world.segments) + len(world.boxes) + len(world.movers)
        return f"world {world.name}, {obstacles} obstacle{'s' * (obstacles != 1)}"
    from holodrive import robots
    from holodrive.kinematics import Chassis

    robot = robots.load(Path(file))
    chassis = Chassis.of(robot)
    return f"robot {robot.name}, {len(robot.wheels)} wheels, rank {chassis.rank}, condition {chassis.condition:.2f}"


def is_fuzzy(file: str) -> bool:
    """Whether the ending says that a file holds a fuzzy system."""
    return Path(file).suffix.lower() in (".fis", ".fcl", ".fml", ".xml")


def _checked_fuzzy(file: str) -> str:
    from holodrive.control.fuzzy.files import read

    system = read(file)
    counts = ((system.inputs, "input"), (system.outputs, "output"), (system.rules, "rule"))
    words = ", ".join(f"{len(them)} {what}{'s' * (len(them) != 1)}" for them, what in counts)
    return f"fuzzy system {system.name}, {words}, {system.kind}"


def is_world(file: str) -> bool:
    """Whether a TOML text says that it is a world; what cannot be read counts as a robot, whose reader says why."""
    from holodrive.files import table_names

    names = table_names(file)
    return "world" in names and "robot" not in names


def _faults(error: HolodriveError, file: str) -> list[dict[str, Any]]:
    if not isinstance(error, FileFaults):
        return [{"file": file, "line": 0, "message": str(error)}]
    names = ("file", "line", "column", "message", "hint")
    return [{name: getattr(fault, name) for name in names} for fault in error.faults]
