"""Half-planes about obstacle points: who keeps them keeps off every point, and standing still always does."""

import math

import numpy as np
import pytest

from holodrive.control.half_planes import half_planes

RADIUS, REACH = 0.26, 1.0


def room(points, places, here=(0.0, 0.0), planes=8, radius=RADIUS, reach=REACH):
    out = np.full((len(places), planes, 3), math.nan)
    xs, ys = np.ascontiguousarray(np.transpose(points).reshape(2, -1))
    half_planes(xs, ys, len(xs), np.array(places, float), *here, radius, reach, np.empty(len(xs)), out)
    return out


@pytest.mark.parametrize("seed", range(10))
def test_who_keeps_the_half_planes_keeps_off_every_point(seed):
    rng = np.random.default_rng(seed)
    points = rng.uniform(-1.0, 1.0, size=(200, 2))
    points = points[np.hypot(*points.T) > RADIUS]
    planes = room(points, [(0.0, 0.0)], planes=40, reach=3.0)[0]
    tries = rng.uniform(-0.5, 0.5, size=(4000, 2))
    kept = np.all((tries @ planes[:, :2].T >= planes[:, 2]) | (planes[:, 2] == -math.inf), axis=-1)
    gap = np.min(np.linalg.norm(tries[:, None] - points[None], axis=-1), axis=-1)
    assert 0 < kept.sum() < len(tries)
    assert np.all(gap[kept] >= RADIUS - 1e-12)


@pytest.mark.parametrize("seed", range(10))
def test_standing_still_keeps_all_even_where_the_robot_is_too_near(seed):
    rng = np.random.default_rng(seed)
    planes = room(rng.normal(size=(50, 2)) * 0.3, rng.normal(size=(6, 2)) * 0.3)
    assert np.all(planes[..., 2] <= 0.0)


def test_the_first_half_plane_is_square_to_the_nearest_point():
    planes = room([(0.0, 0.9), (0.5, 0.0)], [(0.0, 0.0)])[0]
    np.testing.assert_allclose(planes[0], (-1.0, 0.0, RADIUS - 0.5))
    np.testing.assert_allclose(planes[1], (0.0, -1.0, RADIUS - 0.9))


def test_what_lies_behind_a_half_plane_needs_no_other():
    wall = [(0.5, y) for y in np.linspace(-2.0, 2.0, 81)]
    planes = room(wall, [(0.0, 0.0)])[0]
    assert np.isfinite(planes[:, 2]).sum() == 1


def test_far_points_and_no_points_give_no_half_plane():
    assert np.all(room([(3.0, 0.0)], [(0.0, 0.0)])[..., 2] == -math.inf)
    assert np.all(room(np.zeros((0, 2)), [(0.0, 0.0)])[..., 2] == -math.inf)


def test_each_place_has_its_own_half_planes():
    planes = room([(1.0, 0.5)], [(0.5, 0.5), (1.0, 0.0)])
    np.testing.assert_allclose(planes[0, 0, :2], (-1.0, 0.0))
    np.testing.assert_allclose(planes[1, 0, :2], (0.0, -1.0))


def test_a_place_on_a_point_is_kept_out_the_way_the_robot_came():
    planes = room([(1.0, 0.0)], [(1.0, 0.0)])[0]
    np.testing.assert_allclose(planes[0], (-1.0, 0.0, RADIUS - 1.0))
