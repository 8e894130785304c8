"""Laws of planners: the exact shortest path, the bee colony, and what both refuse."""

import math
from dataclasses import replace

import numpy as np
import pytest

import holodrive as hd
from holodrive import planning, worlds
from holodrive.errors import InputError
from holodrive.planning.free_space import leg_gaps, point_gaps, standing
from holodrive.types import Pose
from holodrive.worlds.spec import Box, Circle, Goal, KeyFrame, Mover, Segment, World

MIXED = World(
    "mixed",
    size=(4.0, 3.0),
    start=Pose(0.4, 0.5, 0.0),
    goal=Goal(Pose(3.5, 2.4, 0.0)),
    circles=(Circle(1.2, 1.2, 0.3), Circle(2.9, 1.9, 0.25)),
    segments=(Segment(1.9, 0.0, 1.9, 1.6),),
    boxes=(Box(2.6, 1.0, 0.6, 0.3, 0.5), Box(1.1, 2.2, 0.5, 0.4, -0.2)),
)
WORLDS = [hd.world("paper_course"), hd.world("room"), MIXED, *(worlds.course(seed) for seed in (3, 7, 8))]
FOOTPRINT = 0.2


def exact(world, footprint=FOOTPRINT, **options):
    return planning.visibility(world, footprint, **options)


def moved(world, x, y, theta):
    """The same world without its arena, elsewhere and turned; walls as segments."""
    c, s = math.cos(theta), math.sin(theta)

    def at(px, py):
        return x + c * px - s * py, y + s * px + c * py

    walls = (*world.border(), *world.segments)
    return World(
        "moved",
        start=Pose(*at(*world.start[:2]), world.start.theta + theta),
        goal=Goal(Pose(*at(*world.goal.pose[:2]), world.goal.pose.theta + theta)),
        circles=tuple(Circle(*at(one.x, one.y), one.radius) for one in world.circles),
        segments=tuple(Segment(*at(one.x1, one.y1), *at(one.x2, one.y2)) for one in walls),
        boxes=tuple(Box(*at(one.x, one.y), one.length, one.width, one.theta + theta) for one in world.boxes),
    )


@pytest.mark.parametrize(("footprint", "length"), [(0.23, 4.097), (0.28, 4.125)])
def test_the_shortest_path_of_the_papers_course_is_as_long_as_computed_by_hand(footprint, length):
    """Two tangents and an arc around obstacle 1."""
    radius = 0.15 + footprint
    near, far = 1.0, 3.0  # start and goal from obstacle 1, on a line through its centre
    angle = math.pi - math.acos(radius / near) - math.acos(radius / far)
    by_hand = math.sqrt(near**2 - radius**2) + math.sqrt(far**2 - radius**2) + radius * angle
    plan = exact(hd.world("paper_course"), footprint)
    assert plan.length_m == pytest.approx(by_hand, abs=1e-12)
    assert plan.length_m == pytest.approx(length, abs=5e-4)
    assert plan.clearance_m == pytest.approx(0.0, abs=1e-9)


def test_the_shortest_way_around_the_end_of_a_wall_and_the_corners_of_a_box():
    """Arcs of the robot's own radius about the end, and about both corners."""
    wall = World("wall", segments=(Segment(0.0, -5.0, 0.0, 0.0),))
    plan = exact(wall, 0.3, start=(-1.0, -1.0), goal=(1.0, -1.0))
    lean = math.acos(0.3 / math.sqrt(2.0))  # between the ways from the wall's end to the start and to the touch
    assert plan.length_m == pytest.approx(2.0 * math.sqrt(2.0 - 0.09) + 0.3 * (1.5 * math.pi - 2.0 * lean), abs=1e-9)
    box = World("box", boxes=(Box(0.0, 0.0, 2.0, 1.0),))
    around = exact(box, 0.25, start=(-1.25, 0.0), goal=(1.25, 0.0))
    assert around.length_m == pytest.approx(2.0 * 0.5 + 2.0 + 2.0 * 0.25 * math.pi / 2.0, abs=1e-9)


@pytest.mark.parametrize("world", WORLDS, ids=lambda world: world.name)
def test_no_free_polyline_is_shorter_than_the_exact_path(world):
    """Nor is what a bee colony finds."""
    best, obstacles = exact(world).length_m, standing(world)
    random = np.random.default_rng(1)
    (x, y), (w, h) = world.corner, world.size
    ends = np.array([world.start[:2], world.goal.pose[:2]])
    found = 0
    for _ in range(4000):
        via = random.uniform((x, y), (x + w, y + h), (random.integers(0, 4), 2))
        points = np.concatenate([ends[:1], via, ends[1:]])
        if np.all(leg_gaps(obstacles, np.concatenate([points[:-1], points[1:]], axis=1)) >= FOOTPRINT):
            found += 1
            assert planning.through(points).length_m >= best - 1e-9
    assert found
    bees = planning.bee_colony(world, FOOTPRINT)
    assert best - 1e-9 <= bees.length_m <= 1.35 * best
    assert bees.clearance_m >= -1e-5


@pytest.mark.parametrize("world", WORLDS, ids=lambda world: world.name)
def test_the_exact_path_is_free_and_hangs_together(world):
    route = exact(world, margin_m=0.02).route
    along = np.linspace(0.0, route.length_m, 2000)
    points, direction, _ = route.at(along)
    assert np.min(point_gaps(standing(world), points)) >= FOOTPRINT + 0.02 - 1e-7
    steps = np.hypot(*np.diff(points, axis=0).T)
    assert np.max(steps) <= along[1] * (1 + 1e-9)
    np.testing.assert_allclose(points[[0, -1]], [world.start[:2], world.goal.pose[:2]], atol=1e-9)
    bends = hd.geometry.wrap(np.diff(direction))
    assert np.max(np.abs(bends)) <= along[1] / FOOTPRINT * (1 + 1e-6)  # smooth: no corner sharper than an arc


@pytest.mark.parametrize("world", WORLDS, ids=lambda world: world.name)
def test_the_exact_length_is_symmetric_and_knows_no_direction_of_the_world(world):
    here = exact(world).length_m
    assert exact(world, start=world.goal.pose, goal=world.start).length_m == pytest.approx(here, abs=1e-9)
    for shift in ((0.3, -2.0, 0.7), (5.0, 1.0, 2.5)):
        assert exact(moved(world, *shift)).length_m == pytest.approx(here, abs=1e-8)


@pytest.mark.parametrize("world", WORLDS, ids=lambda world: world.name)
def test_a_larger_robot_never_has_a_shorter_way(world):
    lengths = [exact(world, radius).length_m for radius in (0.01, 0.05, 0.1, 0.15, 0.2)]
    assert np.all(np.diff(lengths) >= -1e-12)


@pytest.mark.parametrize("name", planning.PLANNERS)
def test_where_nothing_stands_in_the_way_every_plan_is_the_straight_line(name):
    plan = planning.planner(name)(hd.world("open"), 0.2, start=(0, 0), goal=(3, 4))
    assert plan.length_m == pytest.approx(5.0, rel=1e-3)
    assert plan.clearance_m == math.inf
    assert exact(hd.world("open"), start=(0, 0), goal=(3, 4)).length_m == 5.0


GAP = World("gap", segments=(Segment(0, -0.2, 3, -0.2), Segment(0, 0.2, 3, 0.2)))
ROW = World("row", boxes=tuple(Box(float(i), 0.0, 1.0, 1.0) for i in range(5)))


@pytest.mark.parametrize(
    ("world", "footprint", "start", "goal", "length"),
    [
        (GAP, 0.2, (-1, 0), (4, 0), 5.0),  # a corridor as wide as the robot
        (GAP, 0.2001, (-1, 0), (4, 0), 5.158),  # and one that is too narrow
        (ROW, 0.2, (-1.0, 0.7), (5.0, 0.7), 6.0),  # along boxes that touch each other, touching them
        (World("three in one", circles=(Circle(1, 0, 0.3),) * 3), 0.2, (0, 0), (2, 0), 2.2556),
        (World("disc in disc", circles=(Circle(1, 0, 0.3), Circle(1.1, 0, 0.2))), 0.2, (0, 0), (2, 0), 2.2556),
        (World("touching", circles=(Circle(0, 0.5, 0.3),)), 0.2, (0, 0), (0, 1.5), math.pi / 3 + math.sqrt(0.75)),
    ],
)  # fmt: skip
def test_what_just_touches_is_no_trouble(world, footprint, start, goal, length):
    plan = exact(world, footprint, start=start, goal=goal)
    assert plan.length_m == pytest.approx(length, abs=1e-3)
    assert exact(world, footprint, start=goal, goal=start).length_m == pytest.approx(plan.length_m, abs=1e-9)


def test_movers_are_not_seen():
    """They will be elsewhere when the robot comes."""
    mover = Mover(0.4, (KeyFrame(0.0, 1.0, 0.0),))
    assert exact(World("m", movers=(mover,)), start=(0, 0), goal=(2, 0)).length_m == 2.0


def test_a_goal_that_is_not_free_is_neared_by_the_shortest_way_to_its_tolerance():
    """The goal inside a disc: any end on the circle is allowed, none gives a shorter way."""
    world = hd.world("paper_course_printed")
    plan = exact(world, 0.23)
    goal = np.array(world.goal.pose[:2])
    assert math.dist(plan.points[-1], goal) == pytest.approx(world.goal.tolerance_m, abs=1e-9)
    angles = np.linspace(-math.pi, math.pi, 361)
    ends = goal + world.goal.tolerance_m * np.stack([np.cos(angles), np.sin(angles)], axis=1)
    free = ends[(point_gaps(standing(world), ends) >= 0.23) & (ends[:, 1] < 4.5) & (ends[:, 0] > 0.0)]
    lengths = [exact(world, 0.23, goal=end).length_m for end in free]
    assert plan.length_m <= min(lengths) + 1e-9
    assert plan.length_m == pytest.approx(min(lengths), abs=1e-3)
    bees = planning.bee_colony(world, 0.23)
    assert math.dist(bees.points[-1], goal) == pytest.approx(world.goal.tolerance_m, abs=1e-9)
    assert plan.length_m - 1e-9 <= bees.length_m <= 1.01 * plan.length_m


def test_the_same_seed_gives_the_same_bees_and_another_seed_others():
    one, same, other = (planning.bee_colony(hd.world("paper_course"), 0.23, seed=seed) for seed in (4, 4, 5))
    np.testing.assert_array_equal(one.points, same.points)
    np.testing.assert_array_equal(one.cost_history, same.cost_history)
    assert not np.array_equal(one.points, other.points)


@pytest.mark.parametrize("guided", [0.0, 1.5])
def test_bees_do_better_the_longer_they_search(guided):
    """Best cost never rises, and the same seed goes the same way further; half a percent from the exact path."""
    world = hd.world("paper_course")
    short, long = (planning.bee_colony(world, 0.23, cycles=cycles, guided=guided) for cycles in (50, 300))
    np.testing.assert_array_equal(short.cost_history, long.cost_history[:50])
    assert np.all(np.diff(long.cost_history) <= 0.0)
    assert long.length_m <= short.length_m
    lengths = [planning.bee_colony(world, 0.23, seed=seed, guided=guided).length_m for seed in range(10)]
    assert np.median(lengths) <= 1.005 * exact(world, 0.23).length_m


def test_a_price_of_turning_makes_bees_turn_less():
    """Over some seeds, of ways with more via points than it takes."""
    world, price = worlds.course(7), 1.0

    def both(price):
        plans = [planning.bee_colony(world, 0.23, seed=seed, turn_m_rad=price, via=3, cycles=1000) for seed in range(5)]
        return sum(np.sum(np.abs(plan.route.changes_rad)) for plan in plans), sum(plan.length_m for plan in plans)

    (plain_turning, plain_length), (turning, length) = both(0.0), both(price)
    assert turning < plain_turning
    assert length + price * turning < plain_length + price * plain_turning


def test_bees_that_find_no_way_begin_anew_with_more_via_points():
    """Two walls, open at the bottom and at the top: one via point cannot do it."""
    walls = (Segment(1.3, 0.8, 1.3, 3.0), Segment(2.7, 0.0, 2.7, 2.2))
    world = World("slalom", size=(4.0, 3.0), start=Pose(0.5, 2.5, 0), goal=Goal(Pose(3.5, 0.5, 0)), segments=walls)
    with pytest.raises(InputError, match="after 1 tries with up to 1 via"):
        planning.bee_colony(world, 0.2, via=1, restarts=0)
    plan = planning.bee_colony(world, 0.2, via=1)
    assert len(plan.via) > 1
    assert len(plan.cost_history) > 300
    assert exact(world).length_m <= plan.length_m <= 1.2 * exact(world).length_m


def test_the_printed_via_points_of_the_paper_measure_what_they_measure():
    """Table X: 574.7 and 536.5 cm are printed; the polylines through its via points are longer, and not free."""
    course = hd.world("paper_course")
    ends = (0.5, 0.5), (0.5, 4.5)
    bees = planning.through([ends[0], (0.88, 1.48), (1.75, 0.21), ends[1]], course, 0.23)
    fuzzy = planning.through([ends[0], (0.88, 1.48), (2.75, 0.27), ends[1]], course, 0.23)
    assert bees.length_m == pytest.approx(7.059, abs=1e-3)
    assert bees.clearance_m < 0.0
    assert bees.turns == 2
    assert fuzzy.length_m > 7.0


BOXED_IN = World("boxed", segments=tuple(World("w", size=(1.0, 1.0)).border()), start=Pose(0.5, 0.5, 0.0))


@pytest.mark.parametrize("name", planning.PLANNERS)
@pytest.mark.parametrize(
    ("world", "options", "word"),
    [
        (hd.world("open"), {}, "has no goal"),
        (hd.world("paper_course"), {"goal": (0.5, 1.5)}, "inside an obstacle"),
        (hd.world("paper_course"), {"start": (0.1, 0.1)}, "start .* is 0.1 m from"),
        (hd.world("paper_course"), {"margin_m": 0.4}, "smaller margin"),
        (hd.world("paper_course"), {"margin_m": math.nan}, "margin of a plan is nan"),
        (hd.world("paper_course"), {"goal": (1, 2, 3, 4)}, "finite; found"),
        (hd.world("paper_course"), {"goal": (math.nan, 2)}, "finite; found"),
        (hd.world("paper_course"), {"goal": (0.5, 0.5)}, "nowhere to go"),
        (BOXED_IN, {"goal": (3.0, 0.5)}, "no way from"),
    ],
)
def test_what_cannot_be_planned_gets_one_clear_line(name, world, options, word):
    with pytest.raises(InputError, match=word) as caught:
        planning.planner(name)(world, 0.2, **options)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    ("options", "word"),
    [
        ({"via": 0}, "via of a bee colony is 0; it must be a whole number from 1"),
        ({"via": 1.5}, "whole number"),
        ({"food_sources": "many"}, "'many'"),
        ({"guided": math.nan}, "a number from 0"),
        ({"cycles": 10**9}, "too much work"),
    ],
)
def test_settings_that_no_colony_can_have_are_refused(options, word):
    with pytest.raises(InputError, match=word):
        planning.bee_colony(hd.world("paper_course"), 0.2, **options)


def test_unknown_planners_and_options_are_told_with_what_there_is():
    with pytest.raises(InputError, match="Did you mean 'bee_colony'"):
        hd.plan("hybrid3", "paper_course", "bee_colny")
    with pytest.raises(InputError, match="Did you mean 'cycles'"):
        hd.plan("hybrid3", "paper_course", "bee_colony", cycels=3)
    with pytest.raises(InputError, match="planner visibility has no option 'via'"):
        hd.plan("hybrid3", "paper_course", via=3)


def test_the_distance_of_a_leg_is_the_least_over_its_points():
    """Exact signed distances against many points, in a world with all kinds of obstacles."""
    obstacles = standing(replace(MIXED, walls=False))
    random = np.random.default_rng(2)
    legs = random.uniform((0, 0, 0, 0), (4, 3, 4, 3), (300, 4))
    t = np.linspace(0.0, 1.0, 4001)[None, :, None]
    points = legs[:, None, :2] + t * (legs[:, None, 2:] - legs[:, None, :2])
    sampled = np.min(point_gaps(obstacles, points), axis=1)
    gaps = leg_gaps(obstacles, legs)
    assert np.all(gaps <= sampled + 1e-12)
    assert np.all(gaps >= sampled - 1e-3)
    assert np.any(gaps < -0.1)
