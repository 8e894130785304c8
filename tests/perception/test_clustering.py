"""Clusters: a scan of known circles gives the circles back."""

import math

import numpy as np
import pytest
from scans import scan_of

from holodrive import perception

CIRCLES = ((1.0, 0.3, 0.15), (-0.8, -0.9, 0.15), (0.2, -1.4, 0.2), (0.9, -0.4, 0.15))
ROOM = (-1.5, 1.5, -2.0, 2.0)


def round_ones(points, **options):
    return [cluster for cluster in perception.clusters(points, **options) if cluster.is_round]


def test_the_circles_of_a_known_world_come_back():
    found = round_ones(perception.points(scan_of(CIRCLES), median=False), noise_m=0.0)
    assert len(found) == len(CIRCLES)
    for x, y, r in CIRCLES:
        nearest = min(found, key=lambda cluster: math.hypot(cluster.x - x, cluster.y - y))
        assert (nearest.x, nearest.y, nearest.radius) == pytest.approx((x, y, r), abs=1e-6)
        assert nearest.residual_m < 1e-9


def test_with_the_sensors_noise_they_come_back_within_centimetres():
    found = round_ones(perception.points(scan_of(CIRCLES, ROOM, noise=0.01, seed=4)))
    for x, y, r in CIRCLES:
        nearest = min(found, key=lambda cluster: math.hypot(cluster.x - x, cluster.y - y))
        assert math.hypot(nearest.x - x, nearest.y - y) < 0.05
        assert nearest.radius == pytest.approx(r, abs=0.05)


def test_a_circle_straight_ahead_where_the_scan_begins_and_ends_is_one():
    found = perception.clusters(perception.points(scan_of([(1.0, 0.0, 0.15)]), median=False))
    assert len(found) == 1


def test_walls_are_not_round():
    assert not round_ones(perception.points(scan_of((), ROOM), median=False))


def test_no_point_belongs_to_two_clusters():
    points = perception.points(scan_of(CIRCLES, ROOM, noise=0.01))
    parts = np.concatenate([cluster.points for cluster in perception.clusters(points, fewest=3)])
    assert len(np.unique(parts, axis=0)) == len(parts) <= len(points)


@pytest.mark.parametrize("points", [np.zeros((0, 2)), np.zeros((2, 2)), np.array([[1.0, 0.0], [1.0, 0.01]])])
def test_too_few_points_are_no_obstacle(points):
    assert perception.clusters(points) == ()
