"""The calibrated linearizer in the robot's own file: comments, order and everything else stay."""

from typing import Any

from holodrive import robots
from holodrive.calibration.duty_fit import CurveFit
from holodrive.calibration.groups import DIRECTIONS
from holodrive.calibration.linearizer import Calibration
from holodrive.errors import InputError
from holodrive.files.edit import Noted, edited
from holodrive.robots.spec import Robot


def text_with(robot: Robot, found: Calibration, file: str) -> str:
    """The robot's file with [linearizer] as it was found; a comment behind each curve says where it comes from.

    Args:
        robot: with the `text` of its file.
        found: of its wheels.
        file: name for messages.

    Raises:
        InputError: the robot has no text, or its file cannot be changed by machine.
        FileFaults: the file would have faults; it has not been written.
    """
    if not robot.text:
        raise InputError(f"{robot.name} was made in code and has no file to write a linearizer into")
    text = edited(robot.text, {"linearizer": _noted(robot, found)})
    again = robots.parse(text, file)
    if again.linearizer != found.linearizer(robot):
        raise InputError(f"{file} would not say what was found; write [linearizer] by hand, --json has its numbers")
    return text


def _noted(robot: Robot, found: Calibration) -> dict[str, Any]:
    table = found.toml_tables(robot)
    noted: dict[str, Any] = {
        "counts": Noted(table.pop("counts"), "PWM counts of full duty"),
        "speed_unit": table.pop("speed_unit"),
        "speed_scale": Noted(table.pop("speed_scale"), _scale(found)),
    }
    for group, entry in zip(found.groups, table.items(), strict=True):
        name, values = entry
        noted[name] = {
            key: Noted(value, _source(found.fit_of(group.name, key))) if key in DIRECTIONS else value
            for key, value in values.items()
        }
    return noted


def _scale(found: Calibration) -> str:
    return "rim speed over speed of the base along the pair's diagonal" if found.groups[0].diagonal else "rim speed"


def _source(one: CurveFit) -> str:
    kind = "cubic" if one.method == "cubic" else "interpolant"
    return (
        f"holodrive calibrate steps: {kind} of {len(one.pwm)} steps, dead zone {one.dead_zone:.2f}, "
        f"off by {1e3 * one.max_error_m_s:.2g} mm/s at most"
    )
