"""Scans to points: what is no return is left out, and motion while scanning is taken out."""

import math
from dataclasses import replace

import numpy as np
import pytest
from scans import scan_of

import holodrive as hd
from holodrive import geometry, perception
from holodrive.sim import SimBase
from holodrive.worlds.spec import Circle, World

CIRCLES = ((1.0, 0.3, 0.15), (-0.8, -0.9, 0.15), (0.2, -1.4, 0.2))


def off_surface(points, circles):
    """(k,) distance of each point from the nearest circle's rim."""
    gaps = [np.abs(np.hypot(points[:, 0] - x, points[:, 1] - y) - r) for x, y, r in circles]
    return np.min(gaps, axis=0)


@pytest.mark.parametrize("clockwise", [True, False])
@pytest.mark.parametrize("mount", [(0.0, 0.0, 0.0), (0.1, -0.05, 0.7)])
def test_points_lie_on_the_surfaces_wherever_the_sensor_is_mounted(mount, clockwise):
    points = perception.points(scan_of(CIRCLES, mount=mount, clockwise=clockwise), median=False)
    assert len(points) > 20
    np.testing.assert_allclose(off_surface(points, CIRCLES), 0.0, atol=1e-12)


def test_nan_no_return_and_too_near_are_no_points():
    scan = scan_of(CIRCLES)
    seen = np.flatnonzero(np.isfinite(scan.ranges))
    scan.ranges[seen[2]], scan.ranges[seen[5]], scan.ranges[seen[8]] = math.nan, 0.05, 20.0
    assert len(perception.points(scan, median=False)) == len(seen) - 3


def test_an_empty_scan_has_no_points():
    scan = scan_of(())
    assert perception.points(scan).shape == (0, 2)
    assert perception.points(replace(scan, angles=np.zeros(0), ranges=np.zeros(0), offsets=np.zeros(0))).shape == (0, 2)


def test_a_single_outlier_is_removed_and_an_edge_stays():
    """The median of three: one beam that sees a ghost is gone, a post of two beams is not."""
    clean = scan_of(CIRCLES)
    nothing = np.flatnonzero(np.isinf(clean.ranges))
    ghost = clean.ranges.copy()
    ghost[nothing[10]] = 0.5
    assert len(perception.points(replace(clean, ranges=ghost))) == len(perception.points(clean))
    post = clean.ranges.copy()
    post[nothing[10] : nothing[10] + 2] = 0.5
    assert len(perception.points(replace(clean, ranges=post))) == len(perception.points(clean)) + 2


def test_turning_the_robot_turns_the_points():
    turn = 0.6
    seen = perception.points(scan_of(CIRCLES), median=False)
    c, s = math.cos(turn), math.sin(turn)
    turned = [(c * x + s * y, c * y - s * x, r) for x, y, r in CIRCLES]
    again = perception.points(scan_of(turned), median=False)
    np.testing.assert_allclose(off_surface(again, turned), 0.0, atol=1e-12)
    assert abs(len(again) - len(seen)) <= len(CIRCLES)


def test_the_robots_motion_is_taken_out_of_a_scan():
    """In 182 ms a robot at 0.2 m/s and 0.5 rad/s goes 36 mm and 5 degrees; what is left is below a millimetre."""
    robot = hd.load("hybrid3_table_x", {"sensor.lidar.noise": "0 mm", "sensor.lidar.noise_relative": 0.0})
    world = World("posts", circles=tuple(Circle(*circle) for circle in CIRCLES))
    base, twist = SimBase(robot, world, seed=0, dt_s=1e-3), (0.15, 0.1, 0.5)
    chassis = hd.Chassis.of(robot)
    observation = base.observe()
    while observation.time < 1.0 or not observation.scan_is_new:
        base.apply(chassis.inverse(twist))
        observation = base.observe()
    scan, past = observation.scan, observation.time
    moving = np.array(base.true_twist)
    here = geometry.compose(np.array(base.truth), geometry.exp(moving * (scan.stamp - past)))
    errors = {}
    for name, taken in (("still", (0.0, 0.0, 0.0)), ("moving", moving)):
        points = perception.points(scan, taken, median=False)
        c, s = math.cos(here[2]), math.sin(here[2])
        there = here[:2] + np.stack([c * points[:, 0] - s * points[:, 1], s * points[:, 0] + c * points[:, 1]], axis=1)
        errors[name] = np.sqrt(np.mean(off_surface(there, CIRCLES) ** 2))
    assert errors["still"] > 0.01
    assert errors["moving"] < 0.001
