"""Routes of lines and arcs, their speed, and references that follow plans without touching anything."""

import math

import numpy as np
import pytest

import holodrive as hd
from holodrive import planning, references
from holodrive.errors import InputError
from holodrive.planning.route import Route, polyline, rounded, run
from holodrive.types import Pose

ZIGZAG = polyline([(0, 0), (1, 0), (1, 1), (3, 1.5)])
SMOOTH = rounded(ZIGZAG, lambda points: True)
ROUTES = {"zigzag": ZIGZAG, "smooth": SMOOTH, "line": polyline([(0, 0), (-2, 1)])}


@pytest.mark.parametrize("route", ROUTES.values(), ids=ROUTES)
def test_each_piece_begins_where_the_one_before_ends(route):
    for before, after in zip(route.pieces[:-1], route.pieces[1:], strict=True):
        np.testing.assert_allclose(Route(before[None]).at(before[3])[0], after[:2], atol=1e-12)
    assert route.length_m == pytest.approx(np.sum(np.hypot(*np.diff(route.points(1e-4), axis=0).T)), rel=1e-7)


def test_a_polyline_is_as_long_as_its_legs_and_turns_in_its_corners():
    assert ZIGZAG.length_m == pytest.approx(2.0 + math.hypot(2.0, 0.5), abs=1e-15)
    np.testing.assert_allclose(ZIGZAG.changes_rad, [math.pi / 2, math.atan2(0.5, 2.0) - math.pi / 2], atol=1e-15)
    assert ZIGZAG.turns == 2
    assert polyline([(0, 0), (1, 0), (2, 0.1)]).turns == 0


def test_rounding_keeps_the_ends_and_every_direction_and_shortens_the_way():
    assert SMOOTH.length_m < ZIGZAG.length_m
    np.testing.assert_allclose(SMOOTH.points()[[0, -1]], ZIGZAG.points()[[0, -1]], atol=1e-12)
    np.testing.assert_allclose(SMOOTH.changes_rad, ZIGZAG.changes_rad, atol=1e-12)
    assert np.count_nonzero(SMOOTH.pieces[:, 4]) == 2


def test_rounding_goes_no_further_than_is_free():
    """A disc that both legs touch: the largest free arc is its rim."""
    radius, corner = 0.4, polyline([(-3, 0), (0, 0), (0, 3)])
    centre = np.array((-radius, radius))

    def free(points):
        return bool(np.min(np.hypot(*(points - centre).T)) >= radius - 1e-9)

    arc = rounded(corner, free).pieces[1]
    assert 1.0 / arc[4] == pytest.approx(radius, abs=1e-4)
    sharp = rounded(corner, lambda points: False)
    np.testing.assert_allclose(sharp.pieces, corner.pieces)


@pytest.mark.parametrize("route", ROUTES.values(), ids=ROUTES)
@pytest.mark.parametrize(("speed", "accel"), [(0.3, 0.5), (2.0, 0.3), (0.05, 5.0)])
def test_a_run_keeps_its_speed_and_its_acceleration_and_rests_at_both_ends_and_in_corners(route, speed, accel):
    profile = route.profile(speed, accel)
    assert profile.distance[0] == profile.speed[0] == profile.speed[-1] == 0.0
    assert profile.distance[-1] == pytest.approx(route.length_m, rel=1e-9)
    assert profile.speed.max() <= speed * (1 + 1e-9)
    across = profile.speed**2 * np.abs(route.at(profile.distance)[2])
    assert np.max(np.hypot(profile.accel, across)) <= accel * (1 + 1e-9)
    assert np.abs(np.diff(profile.speed) / np.diff(profile.time)).max() <= accel * (1 + 1e-6)
    if route is ZIGZAG:
        at_corners = np.interp(route.ends[1:-1], profile.distance, profile.speed)
        assert np.max(at_corners) < 0.02 * speed


def test_a_straight_run_is_the_trapezoid():
    """With the acceleration that a route leaves for the direction along it."""
    ours = polyline([(0, 0), (2, 0)]).profile(0.3, 0.5)
    theirs = planning.trapezoid(2.0, 0.3, 0.5 * math.sqrt(0.5))
    assert ours.time[-1] == pytest.approx(theirs.time[-1], abs=1e-12)


@pytest.mark.parametrize("route", [ROUTES["smooth"], ROUTES["zigzag"]], ids=["smooth", "zigzag"])
def test_the_twist_of_a_run_is_the_derivative_of_its_pose(route):
    table = run(route, 0.2, 0.3, heading_rad=0.5, turn_rad=-1.0)
    follower, h = references.ReferenceFollower(table), 1e-5
    for time in np.linspace(0.03, 0.97, 41) * table.duration_s:
        low, high = (np.array(follower.step(time + step, Pose(0, 0, 0)).pose) for step in (-h, h))
        np.testing.assert_allclose((high - low) / (2 * h), follower.step(time, Pose(0, 0, 0)).twist, atol=1e-5)
    np.testing.assert_allclose(table.rows[[0, -1], 3], [0.5, -0.5], atol=1e-12)


def test_a_recipe_of_a_run_makes_the_same_table_again():
    table = run(SMOOTH, 0.2, 0.3, heading_rad=0.5, turn_rad=-1.0)
    again = planning.from_recipe(table.recipe)
    np.testing.assert_array_equal(again.rows, table.rows)


@pytest.mark.parametrize("name", planning.PLANNERS)
@pytest.mark.parametrize("tracker", ["pid", "go_to_pose", "fuzzy_pd"])
@pytest.mark.parametrize("plant", ["first_order", "slip"])
def test_a_plan_of_the_papers_course_is_driven_without_touching_anything(name, tracker, plant):
    """With the margin that a plan has by default, to the goal, on the planned way."""
    robot = hd.load("hybrid3_table_x")
    plan = hd.plan(robot, "paper_course", name)
    table = plan.reference(robot)
    rolled = hd.rollout(robot, "paper_course", tracker, n=2, seed=1, t=table.duration_s + 2.0, plant=plant,
                        reference=table, workers=1)  # fmt: skip
    metrics = rolled.metrics
    assert np.all(metrics["arrived"] == 1.0)
    assert np.all(metrics["collisions"] == 0.0)
    assert np.all(metrics["min_clearance_m"] > 0.04)
    assert np.all(metrics["final_error_m"] < 0.05)
    np.testing.assert_allclose(metrics["path_length_m"], plan.length_m, rtol=0.01)


def test_a_run_by_plan_is_computed_again_from_its_log(tmp_path):
    robot = hd.load("hybrid3_table_x")
    table = hd.plan(robot, "paper_course", "bee_colony", seed=3).reference(robot)
    hd.drive(hd.simulate(robot, "paper_course"), "pid", trajectory=table, duration_s=1.0, log=tmp_path / "run.mcap")
    assert not hd.rerun(tmp_path / "run.mcap").differences


def test_a_plan_is_in_no_hurry_where_nobody_says_how_fast():
    """Speed and acceleration from the robot, or as given."""
    plan = hd.plan("hybrid3_table_x", "paper_course")
    assert plan.time_s(0.1) > plan.time_s(0.2) > plan.length_m / 0.2
    assert plan.time_s(0.2, 10.0) == pytest.approx(plan.length_m / 0.2, rel=0.01)
    with pytest.raises(InputError, match="speed above 0; found 0"):
        plan.reference(0.0)
    with pytest.raises(InputError, match="acceleration above 0"):
        plan.reference(0.1, -1.0)


def test_a_goal_with_a_heading_is_turned_to_on_the_way():
    """By the shorter turn; without one the robot keeps its own."""
    kept, turned = (hd.plan("hybrid3", "paper_course", goal=goal).reference(0.1).rows for goal in ((1, 4), (1, 4, 3.0)))
    np.testing.assert_allclose(kept[:, 3], math.pi / 2)
    assert np.all(np.diff(turned[:, 3]) >= 0.0)
    assert turned[-1, 3] == pytest.approx(3.0)


@pytest.mark.parametrize(("accel", "laps"), [(math.inf, 1), (0.05, 2)])
def test_a_lap_takes_the_time_that_was_asked_for(accel, laps):
    path = planning.circle(0.5)
    speed = planning.lap_speed(path, 60.0, accel, laps=laps)
    assert planning.follow(path, speed, accel, laps=laps).duration_s == pytest.approx(60.0, abs=1e-9)


@pytest.mark.parametrize(
    ("make", "word"),
    [
        (lambda: polyline([(0, 0)]), "two different points"),
        (lambda: polyline([(0, 0), (0, 0)]), "two different points"),
        (lambda: polyline([(0, 0), (math.nan, 1)]), "finite"),
        (lambda: ZIGZAG.profile(math.nan, 1.0), "speed above 0"),
        (lambda: ZIGZAG.profile(1e-9, 1.0), "are planned"),
        (lambda: planning.lap_speed(planning.circle(0.5), 1.0, 0.1), "more than 1 s"),
        (lambda: planning.lap_speed(planning.circle(0.5), math.nan), "more than nan s"),
    ],
)
def test_what_is_no_route_gets_one_clear_line(make, word):
    with pytest.raises(InputError, match=word) as caught:
        make()
    assert "\n" not in str(caught.value)
