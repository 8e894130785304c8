"""Robots as pictures: well-formed SVG, every wheel with its name, rollers at their angle."""

import math
import re
from dataclasses import replace
from xml.etree import ElementTree

import numpy as np
import pytest

from holodrive import robots
from holodrive.robots.drawing import HATCHES, hatches, robot_shapes, robot_svg
from holodrive.types import Pose


@pytest.mark.parametrize("name", robots.names())
def test_a_catalog_robot_draws_itself_with_all_its_wheels(name):
    robot = robots.load(name)
    text = robot._repr_html_()
    root = ElementTree.fromstring(text)
    assert root.tag.endswith("svg")
    written = {node.text for node in root.iter() if node.tag.endswith("text")}
    assert {wheel.name for wheel in robot.wheels} <= written
    assert robot.title in text


def test_hatches_lie_along_the_rollers_and_inside_the_wheel():
    for wheel in robots.load("hybrid3").wheels:
        found = hatches(wheel)
        assert len(found) == HATCHES
        for (ax, ay), (bx, by) in found:
            assert math.sin(math.atan2(by - ay, bx - ax) - wheel.roller) == pytest.approx(0.0, abs=1e-9)
            for x, y in ((ax, ay), (bx, by)):
                assert abs(x) <= wheel.radius + 1e-12
                assert abs(y) <= 0.5 * wheel.width + 1e-12


def test_a_robot_is_drawn_where_it_stands():
    """x to the right, y up: the circle of the footprint moves by 2 m x 100 pixels, downwards for negative y."""
    shapes = ElementTree.fromstring(robot_shapes(robots.load("omni3"), pose=Pose(2.0, -1.0, 0.5), names=False))
    circle = next(node for node in shapes if node.tag == "circle")
    assert (float(circle.get("cx")), float(circle.get("cy"))) == (200.0, 100.0)


def test_a_caster_is_drawn_behind_its_axis_at_any_steering_angle():
    robot = robots.load("swerve3")
    trailing = replace(
        robot, wheels=tuple(replace(w, steering=replace(w.steering, caster_m=0.04)) for w in robot.wheels)
    )

    def tyres(base, steer):
        found = re.findall(r'<polygon points="([^"]+)" fill="#dde6ee"', robot_shapes(base, scale=1000.0, steer=steer))
        return np.array([np.mean([[float(v) for v in p.split(",")] for p in t.split()], axis=0) for t in found])

    steer = (0.0, 1.0, -2.0)
    moved = tyres(trailing, steer) - tyres(robot, steer)
    np.testing.assert_allclose(moved, [[-40.0 * math.cos(a), 40.0 * math.sin(a)] for a in steer], atol=0.1)


def test_names_cannot_break_the_picture():
    robot = robots.parse(robots.template('<b>&"'))
    assert "&lt;b&gt;&amp;" in robot_svg(robot)
    ElementTree.fromstring(robot_svg(robot))
