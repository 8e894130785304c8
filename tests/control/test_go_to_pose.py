"""The go-to-pose laws of Rosyidin et al. as laws: what path they draw, how they saturate, where they turn."""

import math

import numpy as np
import pytest

import holodrive as hd
from holodrive import control, geometry
from holodrive.control.go_to_pose import GoToPose
from holodrive.kinematics import Chassis
from holodrive.kinematics.discretise import discretise
from holodrive.kinematics.pipeline import CommandPipeline
from holodrive.robots.spec import Limits
from holodrive.types import Estimate, Observation, Pose, Reference, Twist, WheelState

PAPER = {"k_xy": 0.6, "k_theta": 0.6}
GOALS = [(5.0, 10.0, math.pi), (10.0, 10.0, math.pi), (-3.0, 1.0, -2.0), (0.5, -0.2, 0.3)]
LAWS = ("world", "screw")


@pytest.fixture(scope="module")
def robot():
    """The set-up of the paper: r = 0.1 m, L = 0.3 m, 700 rpm, no acceleration limit, 1 ms."""
    return hd.load("swerve3_motors")


def twist_to(goal, pose, robot, **params):
    driver = control.controller("go_to_pose", robot, params)
    sight = Observation(0.0, 1e-3, WheelState(np.zeros(3), np.zeros(3), np.zeros(3)))
    belief = Estimate(Pose(*pose), Twist(0.0, 0.0, 0.0), np.zeros((3, 3)))
    return driver.step(Reference(Pose(*goal)), belief, sight)


def command(goal, pose, robot):
    return twist_to(goal, pose, robot, law="screw", **PAPER).command


def driven(goal, robot, seconds, dt=0.01, **params):
    """Poses (K, 3) and wanted twists (K, 3) of a base whose actuators have no lag: law, pipeline, exact motion."""
    pipeline, pose, poses, twists = CommandPipeline(robot), np.zeros(3), [], []
    for _ in range(round(seconds / dt)):
        wanted = twist_to(goal, pose, robot, **params).command
        pipeline.step(wanted, dt)
        poses.append(pose)
        twists.append(wanted)
        applied = pipeline.applied.twist
        pose = geometry.compose(pose, geometry.exp(dt * discretise(applied, dt)))
    return np.array(poses), np.array(twists)


@pytest.mark.parametrize("goal", GOALS)
def test_the_world_law_draws_a_straight_line_even_while_it_turns_and_saturates(goal, robot):
    poses, _ = driven(goal, robot, 6.0, k_xy=1.5, k_theta=1.5)
    direction = np.array(goal[:2]) / math.hypot(*goal[:2])
    across = poses[:, 1] * direction[0] - poses[:, 0] * direction[1]
    assert np.abs(across).max() < 1e-9 * math.hypot(*goal[:2])


@pytest.mark.parametrize("goal", GOALS)
def test_the_world_law_turns_in_step_with_the_way(goal, robot):
    """Equal gains and one factor for all three: the share of the turn that is done is that of the way."""
    poses, _ = driven(goal, robot, 6.0, **PAPER)
    way = np.hypot(*poses[:, :2].T) / math.hypot(*goal[:2])
    np.testing.assert_allclose(poses[:, 2] / goal[2], way, atol=2e-3)


@pytest.mark.parametrize("goal", GOALS)
def test_the_screw_law_keeps_the_direction_of_its_body_twist(goal, robot):
    """The geodesic of SE(2) is the motion of constant twist; only its pace falls."""
    pose, dt, twists = np.zeros(3), 0.01, []
    for _ in range(300):
        twists.append(np.array(twist_to(goal, pose, robot, law="screw", **PAPER).command))
        pose = geometry.compose(pose, geometry.exp(dt * twists[-1]))
    twists = np.array(twists)
    size = np.linalg.norm(twists, axis=1)
    np.testing.assert_allclose(twists / size[:, None], np.tile(twists[0] / size[0], (300, 1)), atol=1e-9)
    np.testing.assert_allclose(size[1:] / size[:-1], 1.0 - PAPER["k_xy"] * dt, rtol=1e-9)


@pytest.mark.parametrize("law", LAWS)
@pytest.mark.parametrize("goal", GOALS)
def test_saturation_scales_position_and_heading_by_one_factor_to_the_limit_of_a_wheel(law, goal, robot):
    pipeline, wanted = CommandPipeline(robot), twist_to(goal, (0, 0, 0), robot, law=law, k_xy=20.0, k_theta=20.0)
    steer = robot_angles(robot, wanted.command)
    pipeline.reset(steer)  # modules that point the right way already, so that none is slowed down by its steering
    speeds = np.array(pipeline.step(wanted.command, 1e-3).speeds)
    applied = pipeline.applied
    assert applied.scale < 1.0
    np.testing.assert_allclose(applied.twist, applied.scale * np.array(wanted.command), rtol=1e-9)
    assert np.abs(speeds).max() == pytest.approx(700.0 * 2.0 * math.pi / 60.0, rel=1e-3)


def robot_angles(robot, twist):
    return Chassis.of(robot).inverse(discretise(twist, 1e-3)).steer


@pytest.mark.parametrize("law", LAWS)
def test_a_base_without_acceleration_limits_gets_the_whole_gain_at_once(law, robot):
    assert robot.limits == Limits()
    twist = np.array(twist_to((10.0, 10.0, 0.0), (0, 0, 0), robot, law=law, **PAPER).command)
    np.testing.assert_allclose(twist, (6.0, 6.0, 0.0), rtol=1e-12)


@pytest.mark.parametrize("law", LAWS)
@pytest.mark.parametrize("heading", [math.pi, -math.pi, 3.0 * math.pi])
def test_exactly_behind_both_laws_turn_counter_clockwise(law, heading, robot):
    assert twist_to((5.0, 10.0, heading), (0, 0, 0), robot, law=law, **PAPER).command.omega > 0.0


def test_at_half_a_turn_the_screw_is_half_a_circle_and_nothing_is_singular(robot):
    """log has no single value at 180 deg: of the two half circles the law takes the one with the turn of +pi."""
    goal = (5.0, 10.0, math.pi)
    twist = np.array(twist_to(goal, (0, 0, 0), robot, law="screw", **PAPER).command)
    np.testing.assert_allclose(twist, 0.6 * math.pi * np.array([10.0 / 2, -5.0 / 2, 1.0]), rtol=1e-12)
    pose, middle = np.zeros(3), np.array(goal[:2]) / 2
    for _ in range(800):
        pose = geometry.compose(pose, geometry.exp(0.01 * np.array(command(goal, pose, robot))))
        assert np.hypot(*(pose[:2] - middle)) == pytest.approx(np.hypot(*middle), rel=1e-9)
    assert pose[2] > 3.0


@pytest.mark.parametrize("off", [1e-3, 1e-6, 1e-9, 1e-12, 0.0])
@pytest.mark.parametrize("side", [-1.0, 1.0])
def test_near_half_a_turn_the_screw_stays_finite_and_only_its_side_jumps(off, side, robot):
    twist = np.array(twist_to((5.0, 10.0, side * (math.pi - off)), (0, 0, 0), robot, law="screw", **PAPER).command)
    way = 1.0 if off == 0.0 else side
    np.testing.assert_allclose(twist, way * 0.6 * math.pi * np.array([5.0, -2.5, 1.0]), rtol=2e-3, atol=1e-2)


@pytest.mark.parametrize("law", LAWS)
def test_the_mirror_image_of_a_task_gets_the_mirror_image_of_the_twist(law, robot):
    for x, y, turn in np.random.default_rng(5).uniform(-3.0, 3.0, size=(20, 3)):
        here = twist_to((x, y, turn), (0, 0, 0), robot, law=law).command
        there = twist_to((x, -y, -turn), (0, 0, 0), robot, law=law).command
        np.testing.assert_allclose(there, (here.vx, -here.vy, -here.omega), atol=1e-12)


@pytest.mark.parametrize("law", LAWS)
@pytest.mark.parametrize("goal", GOALS[:2])
def test_the_robot_of_the_paper_arrives_at_both_goals(law, goal, robot):
    out = hd.rollout(
        robot, None, GoToPose(law=law, **PAPER), n=1, goals=goal, t=20.0, plant="first_order", log_every=10, seed=1
    )
    assert out.metrics["arrived"][0] == 1.0
    left = np.hypot(out.column("x")[0] - goal[0], out.column("y")[0] - goal[1]) / math.hypot(*goal[:2])
    near = out.column("time")[0][np.argmax(left < 0.02)]
    assert 6.0 < near < 8.0  # ln(50) / 0.6 = 6.5 s
