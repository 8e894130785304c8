"""Three sectors: they part the circle without holes, mirror each other, and tell least distances."""

import math

import numpy as np
import pytest
from scans import scan_of

from holodrive import perception
from holodrive.errors import InputError
from holodrive.perception import Sectors


def at(bearing_deg, distance=1.0, radius=0.02):
    """A thin post at a bearing, counter-clockwise from ahead."""
    a = math.radians(bearing_deg)
    return (distance * math.cos(a), distance * math.sin(a), radius)


def seen(bearing_deg, **options):
    return perception.sectors(scan_of([at(bearing_deg)], beams=3600), **options)


@pytest.mark.parametrize(
    ("bearing", "sector"), [(0, 0), (20, 0), (-20, 0), (30, 1), (60, 1), (-30, 2), (-60, 2), (80, None), (180, None)]
)
def test_a_post_is_seen_by_the_sector_that_it_stands_in_and_by_no_other(bearing, sector):
    """DL is on the left, which the lidar counts as 292.5 to 337.5 degrees."""
    distances = seen(bearing)
    for number, distance in enumerate(distances):
        assert distance == pytest.approx(0.98 if number == sector else 3.0, abs=1e-3)


def test_no_direction_falls_between_two_sectors():
    """Limits belong to exactly one of the sectors on their two sides."""
    edges = Sectors().edges.reshape(3, 2, 2)
    for bearing in (22.5, -22.5):
        direction = np.array([math.cos(math.radians(bearing)), math.sin(math.radians(bearing))])
        inside = [
            begin[1] * direction[0] - begin[0] * direction[1] >= 0.0
            and end[0] * direction[1] - end[1] * direction[0] > 0.0
            for begin, end in edges
        ]
        assert sum(inside[:3]) <= 1
    hits = [sum(d < 3.0 for d in seen(bearing)) for bearing in np.arange(-67.4, 67.4, 1.7)]
    assert min(hits) == 1


def test_a_mirrored_world_exchanges_left_and_right():
    circles = [(0.9, 0.2, 0.15), (0.5, 0.6, 0.1), (0.7, -0.9, 0.15)]
    dh, dl, dr = perception.sectors(scan_of(circles))
    mirrored = perception.sectors(scan_of([(x, -y, r) for x, y, r in circles], clockwise=False))
    assert mirrored == pytest.approx((dh, dr, dl), abs=1e-12)


def test_distances_may_be_measured_from_the_hull_and_never_are_negative():
    assert seen(0, offset_m=0.23)[0] == pytest.approx(0.75, abs=1e-3)
    assert seen(0, offset_m=2.0)[0] == 0.0


@pytest.mark.parametrize(
    "limits", [(67.5, 22.5, 292.5, 337.5), (22.5, 67.5, 292.5, 400.0), (22.5, 250.0, 292.5, 337.5)]
)
def test_limits_that_make_no_sectors_are_refused(limits):
    with pytest.raises(InputError, match="sector limits"):
        Sectors(*limits)
