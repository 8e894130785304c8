"""Paths, profiles and trajectories: derivatives, lengths, round trips."""

import math

import numpy as np
import pytest

from holodrive import planning, references
from holodrive.errors import HolodriveError, InputError
from holodrive.types import Pose

ORIGIN = Pose(0.0, 0.0, 0.0)
PATHS = [
    planning.line((0.0, 1.0), (2.0, -1.0)),
    planning.circle(0.5, (1.0, 2.0), 0.3),
    planning.lemniscate(0.15),
    planning.lemniscate(0.4, (1.0, 1.0), upright=True),
]


@pytest.mark.parametrize("path", PATHS)
def test_derivatives_of_a_path_agree_with_finite_differences(path):
    u, h = np.linspace(0.05, 0.95, 50), 1e-5
    _, d, dd = path.curve(u)
    first = (path.curve(u + h)[0] - path.curve(u - h)[0]) / (2 * h)
    second = (path.curve(u + h)[1] - path.curve(u - h)[1]) / (2 * h)
    np.testing.assert_allclose(d, first, atol=1e-7)
    np.testing.assert_allclose(dd, second, atol=1e-6)


def test_a_circle_is_as_long_as_it_is():
    table = planning.follow(planning.circle(0.5), 0.1, 0.2)
    assert math.isclose(table.duration_s, 2 * math.pi * 0.5 / 0.1 + 0.1 / 0.2, rel_tol=1e-9)


@pytest.mark.parametrize("path", PATHS)
@pytest.mark.parametrize("heading", ["fixed", "tangent"])
def test_the_twist_of_a_trajectory_is_the_derivative_of_its_pose(path, heading):
    table = planning.follow(path, 0.1, 0.1, heading=heading)
    follower, h = references.ReferenceFollower(table), 1e-4
    for time in np.linspace(0.05, 0.95, 7) * table.duration_s:
        low, high = (np.array(follower.step(time + step, ORIGIN).pose) for step in (-h, h))
        np.testing.assert_allclose((high - low) / (2 * h), follower.step(time, ORIGIN).twist, atol=5e-6)


@pytest.mark.parametrize("path", PATHS)
def test_a_trajectory_starts_and_ends_at_rest_and_keeps_its_speed_between(path):
    table = planning.follow(path, 0.1, 0.2)
    speed = np.hypot(table.rows[:, 4], table.rows[:, 5])
    assert speed[0] == pytest.approx(0.0, abs=1e-9)
    assert speed[-1] == pytest.approx(0.0, abs=1e-9)
    assert speed.max() <= 0.1 * (1 + 1e-9)
    np.testing.assert_allclose(table.rows[0, 1:3], path.curve(np.zeros(1))[0][0], atol=1e-12)
    np.testing.assert_allclose(table.rows[-1, 1:3], path.curve(np.ones(1))[0][0], atol=1e-9)


def test_laps_go_around_as_often_as_asked():
    once, twice = (planning.follow(planning.circle(0.5), 0.1, 0.2, laps=laps) for laps in (1, 2))
    assert math.isclose(twice.duration_s - once.duration_s, math.pi * 10.0, rel_tol=1e-9)


@pytest.mark.parametrize(("length", "speed", "accel"), [(1.0, 0.5, 1.0), (0.01, 1.0, 1.0), (100.0, 3.0, 0.2)])
def test_a_speed_profile_covers_its_length_within_its_limits(length, speed, accel):
    p = planning.trapezoid(length, speed, accel)
    assert p.distance[0] == 0.0
    assert p.distance[-1] == pytest.approx(length, rel=1e-12)
    assert np.all(np.diff(p.distance) >= 0.0)
    assert p.speed.max() <= speed * (1 + 1e-12)
    assert np.abs(np.diff(p.speed) / np.diff(p.time)).max() <= accel * (1 + 1e-6)


def test_a_move_has_least_jerk_shape_and_rests_at_both_ends():
    table = planning.move((0, 0, 0), (1, -2, 3), 4.0)
    np.testing.assert_allclose(table.rows[[0, -1], 4:], 0.0, atol=1e-12)
    middle = references.ReferenceFollower(table).step(2.0, ORIGIN)
    np.testing.assert_allclose(middle.pose, (0.5, -1.0, 1.5), atol=1e-12)
    np.testing.assert_allclose(middle.twist, np.array((1, -2, 3)) * 1.875 / 4.0, atol=1e-9)


@pytest.mark.parametrize(
    "table",
    [
        planning.follow(planning.lemniscate(0.15), 0.02, heading="tangent"),
        planning.follow(planning.circle(0.5), 0.1, 0.2, laps=2),
        planning.move((0, 0, 0), (1, 2, 3), 4.0),
        references.fixed_goal((1, 2, 3)),
        references.waypoints([(0, 0, 0), (1, 1, 1)], 0.2),
    ],
)
def test_a_recipe_makes_the_same_table_again(table):
    again = planning.from_recipe(table.recipe)
    assert again.kind == table.kind
    np.testing.assert_array_equal(again.rows, table.rows)


@pytest.mark.parametrize(
    ("make", "word"),
    [
        (lambda: planning.line((1, 1), (1, 1)), "different"),
        (lambda: planning.circle(-1.0), "above 0"),
        (lambda: planning.lemniscate(math.nan), "above 0"),
        (lambda: planning.follow(planning.line((0, 0), (1, 0)), 0.1, laps=2), "laps"),
        (lambda: planning.follow(planning.circle(1), 0.1, laps=1.5), "whole number"),
        (lambda: planning.follow(planning.circle(1), 0.1, heading="tangnt"), "Did you mean 'tangent'"),
        (lambda: planning.trapezoid(1.0, 0.0, 1.0), "speed"),
        (lambda: planning.move((0, 0, 0), (1, 0, 0), 0.0), "time above 0"),
        (lambda: planning.from_recipe({"kind": "pth"}), "not known"),
        (lambda: planning.from_recipe({"kind": "path", "path": "cirle"}), "Did you mean 'circle'"),
        (lambda: references.fixed_goal((1, 2)), "shape"),
        (lambda: references.fixed_goal((1, 2, math.nan)), "finite"),
        (lambda: references.waypoints([(0, 0, 0)], 0.0), "tolerance"),
        (lambda: references.trajectory([0, 0], np.zeros((2, 3)), np.zeros((2, 3)), np.zeros((2, 3))), "increase"),
    ],
)
def test_what_cannot_be_planned_gets_one_clear_line(make, word):
    with pytest.raises(HolodriveError, match=word) as caught:
        make()
    assert isinstance(caught.value, InputError)
    assert "\n" not in str(caught.value)
