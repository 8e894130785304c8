"""Random courses: the rules they are drawn by, and that a seed means the same world everywhere."""

import math
from itertools import combinations

import pytest

from holodrive import worlds

SEEDS = range(40)


def gaps(world):
    return [math.dist((a.x, a.y), (b.x, b.y)) - a.radius - b.radius for a, b in combinations(world.circles, 2)]


@pytest.mark.parametrize("seed", SEEDS)
def test_a_gap_of_a_course_can_be_driven_through_or_is_closed(seed):
    world = worlds.course(seed)
    assert all(gap > 0.66 or gap < 0.0 for gap in gaps(world))
    sides = [min(c.x, 3.0 - c.x) - c.radius for c in world.circles]
    assert all(gap > 0.66 or gap < 0.02 for gap in sides)
    assert 0.5 <= world.start.x <= 2.5
    assert world.start.y == 0.5
    assert world.start.theta == pytest.approx(math.pi / 2)
    assert 0.5 <= world.goal.pose.x <= 2.5
    assert world.goal.pose.y == 4.0


def test_a_seed_gives_the_same_course_and_crossers_leave_its_circles_alone():
    assert worlds.course(7) == worlds.course(7)
    assert worlds.course(7).circles == worlds.course(7, crossers=2).circles
    assert worlds.course(7).circles != worlds.course(8).circles


@pytest.mark.parametrize("seed", SEEDS)
def test_crossers_go_from_wall_to_wall_at_an_even_speed_and_come_back_to_where_they_began(seed):
    world = worlds.course(seed, crossers=2)
    assert worlds.parse(world.text) == world
    for mover in world.movers:
        first, last = mover.path[0], mover.path[-1]
        assert (first.x, first.y) == pytest.approx((last.x, last.y))
        speeds = [abs(b.x - a.x) / (b.time - a.time) for a, b in zip(mover.path, mover.path[1:], strict=False)]
        assert max(speeds) == pytest.approx(min(speeds))
        assert 0.1 <= speeds[0] <= 0.3
        assert all(0.15 - 1e-9 <= frame.x <= 2.85 + 1e-9 for frame in mover.path)
