"""The robots of these experiments."""

from functools import cache

from holodrive import build
from holodrive.robots.spec import Robot

FOOTPRINT = {"robot.footprint_radius": "23 cm", "robot.accept": ["wheels-outside-footprint"]}


@cache
def table_x() -> Robot:
    """The base with motors that Table X needs (0.211 m/s), and the footprint that its planner reckons with."""
    return build.load("hybrid3_table_x")


@cache
def printed() -> Robot:
    """The base with the motors that Table II prints (22 rpm), the same footprint."""
    return build.load("hybrid3", FOOTPRINT)
