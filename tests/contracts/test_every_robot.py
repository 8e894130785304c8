"""What every robot of the catalog keeps, on either plant: a newcomer gets these tests for free."""

import math
from dataclasses import replace

import numpy as np
import pytest

import holodrive as hd
from holodrive import geometry, robots
from holodrive.worlds.spec import World

OPEN = World("open floor")
PLANTS = ("first_order", "slip")


def reach(robot):
    """A distance [m] that this robot covers in a few seconds without spinning its wheels."""
    return min(0.5, 2.0 * min(wheel.max_speed_rad_s * wheel.radius for wheel in robot.wheels))


@pytest.mark.parametrize("name", robots.names())
def test_a_catalog_robot_can_move_in_all_three_ways(name):
    chassis = hd.Chassis.of(hd.load(name))
    assert chassis.rank == 3
    assert chassis.condition < 10.0


@pytest.mark.parametrize("plant", PLANTS)
@pytest.mark.parametrize("name", robots.names())
def test_a_catalog_robot_drives_to_a_goal_sideways_and_turned_and_stays_within_its_limits(name, plant):
    robot = hd.load(name)
    goal = np.array([0.5 * reach(robot), -reach(robot), 0.6])
    run = hd.drive(hd.simulate(robot, OPEN, plant=plant, seed=1), goal=goal, duration_s=60.0)
    assert run.ended == "arrived"
    assert math.hypot(*(run.estimate[-1, :2] - goal[:2])) < 0.03
    assert math.hypot(*(run.pose[-1, :2] - goal[:2])) < 0.06
    limits = np.array([wheel.max_speed_rad_s for wheel in robot.wheels])
    assert np.all(np.abs(run.wheel_commands) <= limits * (1 + 1e-9))
    assert np.all(np.abs(run.duty) <= 1.0)


@pytest.mark.parametrize("name", robots.names())
def test_a_robot_that_is_told_nothing_stays_where_it_is(name):
    base = hd.simulate(name, OPEN, plant="slip")
    for _ in range(50):
        base.apply(hd.WheelCommand(np.zeros(len(base.robot.wheels)), np.zeros(len(base.robot.steered))))
    np.testing.assert_allclose(base.truth, (0.0, 0.0, 0.0), atol=1e-9)


@pytest.mark.parametrize("name", robots.names())
def test_the_world_frame_does_not_matter_to_a_run(name):
    """Start and goal moved and turned together give the same run in the moved frame (no noise in the sensors)."""
    robot = replace(hd.load(name), lidar=None, imu=None)
    if all(wheel.encoder is not None for wheel in robot.wheels):  # else the mice are all that it has
        robot = replace(robot, mice=())
    shift, goal = np.array([1.0, -2.0, 0.8]), np.array([reach(robot), 0.2 * reach(robot), 0.3])
    here = hd.drive(hd.simulate(robot, OPEN), goal=goal, duration_s=3.0)
    there = hd.drive(hd.simulate(robot, OPEN, start=shift), goal=geometry.compose(shift, goal), duration_s=3.0)
    count = min(len(here.time), len(there.time))
    np.testing.assert_allclose(there.pose[:count], geometry.compose(shift, here.pose[:count]), atol=1e-6)


@pytest.mark.parametrize("name", robots.names())
def test_the_same_seed_gives_the_same_run_and_another_seed_other_noise(name):
    def run(seed):
        return hd.drive(hd.simulate(name, OPEN, plant="slip", seed=seed), goal=(0.3, 0.1, 0.2), duration_s=1.0)

    first, again = run(3), run(3)
    for channel in ("pose", "estimate", "wheel_speeds", "duty"):
        np.testing.assert_array_equal(getattr(first, channel), getattr(again, channel))
