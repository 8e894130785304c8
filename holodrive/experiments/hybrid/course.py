"""Table IX: the course, and why its goal cannot be reached."""

import numpy as np

from holodrive import worlds
from holodrive.experiments.claims import Claim
from holodrive.experiments.experiment import Result, Setting
from holodrive.experiments.hybrid import printed, robots
from holodrive.reports.sections import TextSection


def table_ix(setting: Setting) -> Result:
    """Claims about the course."""
    world, repaired = worlds.load("paper_course_printed"), worlds.load("paper_course")
    claims = [
        Claim(
            "Table IX",
            f"obstacle {number}: x, y, radius",
            f"{x:g}, {y:g}, {r:g} cm",
            f"{100.0 * found.x:g}, {100.0 * found.y:g}, {100.0 * found.radius:g} cm",
            "agrees" if np.allclose((x, y, r), np.multiply(100.0, (found.x, found.y, found.radius))) else "differs",
        )
        for number, ((x, y, r), found) in enumerate(zip(printed.OBSTACLES_CM, world.circles, strict=True), 1)
    ]
    goal, blocked = printed.END_CM, printed.OBSTACLES_CM[3]
    radius = 100.0 * robots.table_x().footprint_radius_m
    claims += [
        Claim("Table IX", "distance from end point to obstacle 4", f"{goal[0]:g}, {goal[1]:g} cm",
              f"{((goal[0] - blocked[0]) ** 2 + (goal[1] - blocked[1]) ** 2) ** 0.5:g} cm", "contradicts itself",
              note="the end point is the centre of obstacle 4; it can be neared to "
              f"{blocked[2] + radius:g} cm at best"),
        Claim("text", "arena", "3 x 4 m; 3 x 4.5 m", f"{world.size[0]:g} x {world.size[1]:g} m" if world.size else "—",
              "contradicts itself",
              note="abstract and text; with 4.5 m the end point lies on the wall, with 4 m outside"),
        Claim("Table IX", "room between the west wall and obstacle 1", None,
              printed.OBSTACLES_CM[0][0] - printed.OBSTACLES_CM[0][2], "not printed", "cm",
              f"the robot is {2.0 * radius:g} cm wide: it must pass between obstacles 1 and 2"),
    ]  # fmt: skip
    note = TextSection(
        "Courses used here",
        f"{repaired.name}: {repaired.title}. {world.name}: {world.title}.\n\n"
        "The first leaves obstacle 4 out and has half a metre behind the goal (benchmark A1); the second keeps "
        "obstacle 4, and arriving means 48 cm from its centre (benchmark A2).",
    )
    return Result(tuple(claims), (note,))
