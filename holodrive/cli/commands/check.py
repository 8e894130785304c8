"""`holodrive check`."""

from pathlib import Path
from typing import Any

import click

from holodrive.cli.faults import report_fault
from holodrive.cli.options import verb
from holodrive.cli.output import Output
from holodrive.errors import FileFaults, HolodriveError


@verb("check", ["my_robot.toml", "robots/*.toml worlds/*.toml --json"])
@click.argument("files", nargs=-1, required=True, type=click.Path())
def command(out: Output, files: tuple[str, ...]) -> int:
    """Look for all faults of robot and world FILES at once. Exit code 2 when there is one."""
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
    world = good is not None and is_world(str(good))
    use = f"holodrive run hybrid3 -w {good}" if world else f"holodrive kinematics {good}"
    out.next(f"mend the lines above, then holodrive check {' '.join(files)}" if worst else use)
    return worst


def _checked(file: str) -> str:
    from holodrive import worlds

    if is_world(file):
        world = worlds.load(Path(file))
        obstacles = len(world.circles) + len(world.segments) + len(world.boxes) + len(world.movers)
        return f"world {world.name}, {obstacles} obstacle{'s' * (obstacles != 1)}"
    from holodrive import robots
    from holodrive.kinematics import Chassis

    robot = robots.load(Path(file))
    chassis = Chassis.of(robot)
    return f"robot {robot.name}, {len(robot.wheels)} wheels, rank {chassis.rank}, condition {chassis.condition:.2f}"


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
