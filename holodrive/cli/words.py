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


ENDED = {"duration": "not arrived", "fault": "stopped by a fault"}
ARRIVED_WITHIN_M = 0.5
ASKED_FIRST = ("path_length_m", "min_clearance_m", "collisions", "final_error_m", "final_heading_error_rad")


def outcome(run: "Run") -> str:
    """How a run ended, with the figures that people ask for first."""
    from holodrive.log.words import with_unit, words

    by_hand = not can_be_rerun(run)
    ended = ENDED.get(run.ended, run.ended) if not by_hand else "ended"
    if ended == "arrived" and run.metrics.get("final_error_m", 0.0) > ARRIVED_WITHIN_M:
        ended = "believes that it arrived"  # its odometry says so; the truth does not
    parts = [f"{ended} after {with_unit('time_s', run.metrics.get('time_s', float(run.time[-1])))}"]
    asked = ASKED_FIRST[:3] if by_hand else ASKED_FIRST  # a goal is no measure of driving by hand
    for name in asked:
        if name in run.metrics and math.isfinite(run.metrics[name]):
            parts.append(f"{words(name).label} {with_unit(name, run.metrics[name])}")
    return ", ".join(parts)


def can_be_rerun(run: "Run") -> bool:
    """Whether a run was simulated with a controller that has a name."""
    from holodrive import control

    return "plant" in run.settings and run.settings.get("controller") in control.names()


def file_size(count: int) -> str:
    """`3.2 MB`, `410 kB`."""
    return f"{count / 1e6:.1f} MB" if count >= 1e6 else f"{max(1.0, count / 1e3):.0f} kB"
