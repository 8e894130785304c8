"""Claims about odometry by mice while it steers: loop and roll-out are one, and the robot ends where it believes."""

import math

import numpy as np
import pytest

from holodrive import estimation, references, robots
from holodrive.control.go_to_pose import GoToPose
from holodrive.control.kernel import KernelController
from holodrive.kinematics.pipeline import CommandPipeline
from holodrive.sim import SimBase, rollout
from holodrive.types import Array

GOAL = (0.06, 0.04, 0.4)
TICKS = 200


def looped(robot_name: str, name: str) -> Array:
    """(TICKS, 6) true and believed poses of the ordinary loop."""
    robot = robots.load(robot_name)
    base, believer = SimBase(robot, seed=3), estimation.estimator(name, robot)
    controller, pipeline = KernelController(GoToPose(), robot), CommandPipeline(robot)
    follower = references.ReferenceFollower(references.fixed_goal(GOAL))
    believer.reset(base.truth)
    rows = []
    for _ in range(TICKS):
        seen = base.observe()
        belief = believer.step(seen)
        command = controller.step(follower.step(seen.time, belief.pose), belief, seen).command
        rows.append((*base.truth, *belief.pose))
        base.apply(pipeline.step(command, seen.dt))
    return np.array(rows)


@pytest.mark.parametrize(
    ("robot", "name"),
    [("mecanum4_mice", "mouse_odometry"), ("mecanum4_mice", "mouse_corrected"), ("mecanum4", "fused_odometry")],
)
def test_the_ordinary_loop_and_the_roll_out_are_one_trajectory(robot: str, name: str) -> None:
    spec = robots.load(robot)
    rows = looped(robot, name)
    out = rollout(
        spec, None, GoToPose(), estimator=estimation.plug(name), goals=GOAL, seed=3, t=TICKS * 0.015, log_every=1
    )
    # the loop steers by plain floats, the roll-out by kernels: last bits differ there, not in the estimator
    np.testing.assert_allclose(out.log[0, : len(rows), 1:7], rows, atol=1e-12)
    assert math.dist(rows[-1, :2], rows[-1, 3:5]) < 0.05e-3
    assert abs(rows[-1, 2] - rows[-1, 5]) < 2e-3
    assert math.dist(rows[-1, :2], GOAL[:2]) < 0.03
