"""Both faces of every controller: one tick at a time in the ordinary loop, and compiled in the roll-out."""

import numpy as np
import pytest

import holodrive as hd
from holodrive import control, references

ROBOTS = ("hybrid3", "mecanum4", "swerve3")
GOAL = (0.4, -0.2, 0.5)
LIDAR = {"sensor.lidar.model": "rplidar-a1"}  # for robots without one, where a controller needs it
COMPILED = [name for name in control.names() if hasattr(control.plug_class(name), "kernel")]
DRIVEN = [
    (name, robot)
    for name in COMPILED
    for robot in ROBOTS
    if robot == "mecanum4" or not getattr(control.plug_class(name), "needs_diagonals", False)
]


def _robot_for(name, robot):
    needed = getattr(control.plug_class(name), "needs_lidar", False) and hd.load(robot).lidar is None
    return hd.load(robot, LIDAR if needed else None)


@pytest.mark.parametrize("plant", ["first_order", "slip"])
@pytest.mark.parametrize(("name", "robot"), DRIVEN)
def test_the_roll_out_and_the_ordinary_loop_drive_the_same_run(name, robot, plant):
    """The same seed, the same noise, the same kernels: the same poses at every tick."""
    time, robot = 3.0, _robot_for(name, robot)
    loop = hd.drive(
        hd.simulate(robot, "open", plant=plant, seed=5), name, goal=GOAL, duration_s=time, stop_on_arrival=False
    )
    rolled = hd.rollout(
        robot,
        "open",
        name,
        n=1,
        seed=5,
        t=time,
        plant=plant,
        reference=references.fixed_goal(GOAL),
        log_every=1,
        stop_on_arrival=False,
    )
    log = rolled.log[0]
    count = len(loop.time)
    np.testing.assert_allclose(log[:count, 0], loop.time, atol=1e-12)
    np.testing.assert_allclose(log[:count, 1:4], loop.pose, atol=1e-9)
    np.testing.assert_allclose(log[:count, 4:7], loop.estimate, atol=1e-9)
    np.testing.assert_allclose(log[:count, 7:10], loop.reference, atol=1e-12)


@pytest.mark.parametrize("world", ["paper_course", "crossing"])
def test_a_worlds_goal_and_tolerance_mean_the_same_to_the_roll_out_and_the_loop(world):
    """Where no heading is asked for, the robot keeps its own; how near is there is the world's word."""
    loop = hd.drive(hd.simulate("omni4", world, seed=2), duration_s=20.0)
    rolled = hd.rollout("omni4", world, n=1, seed=2, t=20.0, stop_on_arrival=True)
    for name in ("arrived", "time_s", "final_error_m", "final_heading_error_rad", "collisions", "min_clearance_m"):
        assert rolled.metrics[name][0] == pytest.approx(loop.metrics[name], abs=1e-9), name


def test_parameters_of_the_wrong_width_are_refused_before_anything_runs():
    with pytest.raises(hd.HolodriveError, match="params has shape"):
        hd.rollout("hybrid3", "room", params=[1.0, 1.0], t=1.0)
