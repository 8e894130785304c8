"""The barrier's projection: inside all half planes, nearest to what was wanted, and never towards what is near."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from holodrive.control.barrier import hold_back_ahead, nearest_allowed, point_limits

RADIUS, GAIN, FASTEST = 0.26, 2.0, 0.4


def limits_of(points, velocities=None):
    """Half planes of points (k, 2) for a robot at the origin."""
    points = np.atleast_2d(np.asarray(points, dtype=np.float64))
    v = np.zeros_like(points) if velocities is None else np.asarray(velocities, dtype=np.float64)
    columns = [np.ascontiguousarray(column) for column in (*points.T, *v.T)]
    out = np.zeros(3 * len(points))
    count = point_limits(*columns, len(points), 0.1, 0.0, 0.0, RADIUS, GAIN, FASTEST, out)
    return out, count


PLACE = st.tuples(st.floats(0.27, 0.6), st.floats(-math.pi, math.pi))
WISH = st.tuples(st.floats(-0.28, 0.28), st.floats(-0.28, 0.28))


@given(st.lists(PLACE, min_size=1, max_size=30), WISH)
def test_the_velocity_keeps_every_barrier(places, wish):
    """v . n <= gain h for each point, h its distance outside the margin: never nearer than the margin."""
    points = np.array([(r * math.cos(a), r * math.sin(a)) for r, a in places])
    limits, count = limits_of(points)
    v = np.array(nearest_allowed(*wish, limits, count))
    distance = np.hypot(*points.T)
    assert np.all(points @ v / distance <= GAIN * (distance - RADIUS) + 1e-6)


@given(st.lists(PLACE, min_size=1, max_size=12), WISH)
def test_no_allowed_velocity_is_nearer_to_the_wanted_one(places, wish):
    limits, count = limits_of([(r * math.cos(a), r * math.sin(a)) for r, a in places])
    v = np.array(nearest_allowed(*wish, limits, count))
    rows = limits[: 3 * count].reshape(-1, 3)
    side = np.linspace(-0.4, 0.4, 41)
    tried = np.stack(np.meshgrid(side, side), axis=-1).reshape(-1, 2)
    allowed = tried[np.all(tried @ rows[:, :2].T <= rows[:, 2], axis=1)] if count else tried
    best = np.min(np.hypot(*(allowed - wish).T), initial=math.inf)
    assert math.hypot(*(v - wish)) <= best + 1e-6


def test_a_wish_that_breaks_nothing_is_left_alone():
    limits, count = limits_of([(0.5, 0.0), (0.0, 0.6)])
    assert nearest_allowed(0.1, 0.1, limits, count) == (0.1, 0.1)


def test_a_robot_slides_along_a_wall():
    limits, count = limits_of([(RADIUS, y) for y in np.linspace(-0.2, 0.2, 9)])
    vx, vy = nearest_allowed(0.2, 0.1, limits, count)
    assert vx == pytest.approx(0.0, abs=0.01)
    assert vy == pytest.approx(0.1, abs=0.05)


def test_a_robot_between_two_points_that_are_too_near_stands():
    limits, count = limits_of([(0.25, 0.0), (-0.25, 0.0), (0.0, 0.25), (0.0, -0.25)])
    assert nearest_allowed(0.1, 0.0, limits, count) == (0.0, 0.0)


def test_what_comes_is_taken_for_as_near_as_it_is_by_now():
    """Seen 0.1 s ago at 0.3 m/s towards the robot: 3 cm nearer; and never farther than it was seen."""
    still, _ = limits_of([(0.4, 0.0)])
    coming, _ = limits_of([(0.4, 0.0)], [(-0.3, 0.0)])
    going, _ = limits_of([(0.4, 0.0)], [(0.3, 0.0)])
    assert coming[2] == pytest.approx(still[2] - GAIN * 0.03)
    assert going[2] == pytest.approx(still[2])


def test_a_robot_that_only_goes_ahead_is_slowed_by_what_is_ahead_only():
    ahead, count = limits_of([(0.3, 0.0)])
    assert hold_back_ahead(0.2, 1.0, 0.0, ahead, count) == pytest.approx(GAIN * (0.3 - RADIUS))
    assert hold_back_ahead(0.2, 0.0, 1.0, ahead, count) == 0.2
    assert hold_back_ahead(-0.2, 1.0, 0.0, ahead, count) == -0.2
