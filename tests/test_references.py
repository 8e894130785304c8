"""Reference tables and the one kernel that reads them."""

import numpy as np

from holodrive import references
from holodrive.types import Pose


def test_a_fixed_goal_is_the_reference_at_all_times():
    follower = references.ReferenceFollower(references.fixed_goal((1.0, 2.0, 3.0)))
    for time in (0.0, 5.0, 1e6):
        reference = follower.step(time, Pose(0.0, 0.0, 0.0))
        assert reference.pose == (1.0, 2.0, 3.0)
        assert reference.twist == (0.0, 0.0, 0.0)
        assert reference.last


def test_way_points_come_one_after_another_and_do_not_come_back():
    follower = references.ReferenceFollower(references.waypoints([(0, 0, 0), (1, 0, 0), (1, 1, 0)], 0.1))
    assert follower.step(0.0, Pose(0.5, 0.5, 0.0)).pose[:2] == (0.0, 0.0)
    assert follower.step(0.0, Pose(0.05, 0.0, 0.0)).pose[:2] == (1.0, 0.0)
    assert follower.step(0.0, Pose(0.0, 0.0, 0.0)).pose[:2] == (1.0, 0.0)
    last = follower.step(0.0, Pose(0.95, 0.0, 0.0))
    assert last.pose[:2] == (1.0, 1.0)
    assert last.last
    follower.reset()
    assert follower.step(0.0, Pose(0.5, 0.5, 0.0)).pose[:2] == (0.0, 0.0)


def test_a_trajectory_passes_its_rows_exactly_and_rests_after_the_last():
    rng = np.random.default_rng(1)
    time = np.cumsum(rng.uniform(0.1, 1.0, 20))
    poses, twists, accels = rng.normal(size=(3, 20, 3))
    follower = references.ReferenceFollower(references.trajectory(time, poses, twists, accels))
    for k in (0, 7, 18, 3):  # time may go back: a reset run, a replay
        reference = follower.step(time[k], Pose(0, 0, 0))
        np.testing.assert_allclose(reference.pose, poses[k], atol=1e-12)
        np.testing.assert_allclose(reference.twist, twists[k], atol=1e-12)
        np.testing.assert_allclose(reference.accel, accels[k], atol=1e-12)
    end = follower.step(time[-1] + 1.0, Pose(0, 0, 0))
    np.testing.assert_array_equal(end.pose, poses[-1])
    assert end.twist == (0.0, 0.0, 0.0)
    assert end.last


def test_the_error_of_interpolation_falls_with_the_fourth_power_of_the_step():
    errors = []
    for count in (50, 100):
        t = np.linspace(0.0, 6.0, count + 1)
        p = np.stack([np.sin(t), np.cos(t), t], -1)
        v = np.stack([np.cos(t), -np.sin(t), 1 + 0 * t], -1)
        follower = references.ReferenceFollower(references.trajectory(t, p, v, -p))
        query = np.linspace(0.0, 5.99, 997)
        found = np.array([follower.step(q, Pose(0, 0, 0)).pose[:2] for q in query])
        errors.append(np.abs(found - np.stack([np.sin(query), np.cos(query)], -1)).max())
    assert 12.0 < errors[0] / errors[1] < 20.0
