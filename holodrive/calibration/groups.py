"""Which wheels a step calibration drives together: a Mecanum base's two diagonals, any other base's wheels one by one.

One diagonal of a four-Mecanum base drives it straight at 45 degrees (Keek et al., Figure 3), so that ground sensors or
odometry can measure it. A single wheel of another base turns the robot on the spot or drags it; it is measured by its
own encoder.
"""

import math
from dataclasses import dataclass

from holodrive.errors import InputError
from holodrive.robots.spec import Robot, WheelSpec

FORWARD, BACKWARD = "forward", "backward"
DIRECTIONS = (FORWARD, BACKWARD)
_ALMOST = 1e-6  # rad


@dataclass(frozen=True)
class Group:
    """Wheels that take the same PWM.

    Attributes:
        name: of the tables in a robot's file; "W1W4" and "W2W3" for the diagonals, else the wheel's name.
        wheels: indices into the robot's wheels.
        diagonal: measured as a motion at 45 degrees instead of by its encoder.
        speed_scale: rim speed of its wheels over the speed that is measured.
        resolution_m: of what measures it.
    """

    name: str
    wheels: tuple[int, ...]
    diagonal: bool
    speed_scale: float
    resolution_m: float


def groups_of(robot: Robot, *, measured_elsewhere: bool = False) -> tuple[Group, ...]:
    """The groups of a robot, in the order in which they are calibrated.

    Args:
        robot: to calibrate.
        measured_elsewhere: steps come from a file, so that the robot need not be able to measure them itself.

    Raises:
        InputError: a single wheel without an encoder, or a diagonal that nothing on the robot measures.
    """
    pairs = diagonals(robot)
    if pairs:
        resolution = _resolution(robot, measured_elsewhere)
        return tuple(Group(name, wheels, True, math.sqrt(2.0), resolution) for name, wheels in pairs.items())
    blind = [wheel.name for wheel in robot.wheels if wheel.encoder is None]
    if blind and not measured_elsewhere:
        raise InputError(
            f"{robot.name} is calibrated wheel by wheel, and {', '.join(blind)} has no encoder to measure by; "
            "add one, or give steps measured elsewhere as a CSV file"
        )
    return tuple(Group(wheel.name, (i,), False, 1.0, _count_m(wheel)) for i, wheel in enumerate(robot.wheels))


def diagonals(robot: Robot) -> dict[str, tuple[int, int]]:
    """The paper's pairs of a four-Mecanum base with 45 degree rollers that all face ahead; empty for other bases."""
    wheels = robot.wheels
    if len(wheels) != 4 or any(not _usual(wheel) for wheel in wheels):
        return {}
    # W1W4 drives to the left ahead: its rollers lie at +45 degrees (Keek et al., Figure 3)
    pairs = {
        "W1W4": tuple(i for i, wheel in enumerate(wheels) if wheel.roller > 0.0),
        "W2W3": tuple(i for i, wheel in enumerate(wheels) if wheel.roller < 0.0),
    }
    if any(len(pair) != 2 or not _opposite(wheels[pair[0]], wheels[pair[1]]) for pair in pairs.values()):
        return {}
    return {name: (pair[0], pair[1]) for name, pair in pairs.items()}


def _usual(wheel: WheelSpec) -> bool:
    turned = abs(abs(wheel.roller) - math.pi / 4.0) > _ALMOST or abs(math.remainder(wheel.yaw, math.tau)) > _ALMOST
    return wheel.kind == "mecanum" and not turned


def _opposite(one: WheelSpec, other: WheelSpec) -> bool:
    return (one.x > other.x) == (one.y > other.y) or (one.x > other.x) == (one.y < other.y)


def _resolution(robot: Robot, measured_elsewhere: bool) -> float:
    """What one count of the sensor that measures a diagonal means [m]."""
    if len(robot.mice) >= 2:
        return max(mouse.resolution_m for mouse in robot.mice)
    counts = [_count_m(wheel) for wheel in robot.wheels if wheel.encoder is not None]
    if len(counts) == len(robot.wheels):
        return max(counts)
    if measured_elsewhere:
        return 1e-5
    raise InputError(
        f"{robot.name} cannot measure how it moves: it has neither two mice nor encoders on all wheels; "
        "add [sensor.mouse.NAME], or give steps measured elsewhere as a CSV file"
    )


def _count_m(wheel: WheelSpec) -> float:
    """Rim travel of one encoder count [m]; 0.01 mm for a wheel that is measured elsewhere."""
    return math.tau * wheel.radius / wheel.encoder.counts_per_turn if wheel.encoder else 1e-5
