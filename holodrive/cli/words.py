"""Robots, worlds and outcomes in one line each."""

import math
from collections import Counter
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from holodrive.log.run import Run
    from holodrive.robots.spec import Robot
    from holodrive.worlds.spec import World


def robot_line(robot: "Robot") -> str:
    """`hybrid3   1 omni + 2 mecanum, condition 1.9`."""
    from holodrive.kinematics import Chassis

    kinds = Counter(wheel.kind for wheel in robot.wheels)
    wheels = " + ".join(f"{count} {kind}" for kind, count in kinds.items())
    return f"{robot.name}   {wheels}, condition {Chassis.of(robot).condition:.2f}"


def world_line(world: "World | None") -> str:
    """`course   3.00 x 4.50 m, 4 obstacles`."""
    if world is None:
        return "unknown"
    size = f"{world.size[0]:.2f} x {world.size[1]:.2f} m" if world.size else "open floor"
    count = len(world.circles) + len(world.segments) + len(world.boxes) + len(world.movers)
    return f"{world.name}   {size}, {count} obstacle{'s' * (count != 1)}"


ASKED_FIRST = ("path_length_m", "min_clearance_m", "collisions", "final_error_m", "final_heading_error_rad")


def outcome(run: "Run") -> str:
    """How a run ended, with the figures that people ask for first."""
    from holodrive.log.words import with_unit, words

    ended = run.settings.get("ended", "ended")
    parts = [f"{ended} after {with_unit('time_s', run.metrics.get('time_s', float(run.time[-1])))}"]
    for name in ASKED_FIRST:
        if name in run.metrics and math.isfinite(run.metrics[name]):
            parts.append(f"{words(name).label} {with_unit(name, run.metrics[name])}")
    return ", ".join(parts)
