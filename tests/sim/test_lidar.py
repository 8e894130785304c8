"""Ray casting: the interval method against the plain one, both against geometry."""

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from machines import hybrid, ideal_lidar

from holodrive.obstacles import obstacles_of
from holodrive.sim import SimBase
from holodrive.sim.lidar import cast, cast_beam
from holodrive.sim.model import model_of
from holodrive.types import DutyCommand, Pose, WheelCommand
from holodrive.worlds.spec import Box, Circle, KeyFrame, Mover, Segment, World

coordinate = st.floats(-5.0, 5.0)


@st.composite
def worlds(draw):
    some = {"min_size": 0, "max_size": 4}
    return World(
        "random",
        size=(9.0, 8.0),
        corner=(-4.0, -4.5),
        circles=tuple(draw(st.lists(st.builds(Circle, coordinate, coordinate, st.floats(0.05, 1.5)), **some))),
        segments=tuple(draw(st.lists(st.builds(Segment, *[coordinate] * 4), **some))),
        boxes=tuple(
            draw(st.lists(st.builds(Box, coordinate, coordinate, *[st.floats(0.1, 2.0)] * 2, coordinate), **some))
        ),
        movers=(Mover(0.3, (KeyFrame(0.0, -2.0, 1.0), KeyFrame(4.0, draw(coordinate), 2.0))),),
    )


def both(lidar, world, time, pose):
    model, obstacles = model_of(hybrid(lidar=lidar), 1e-3), obstacles_of(world)
    fast = np.empty(lidar.beams)
    cast(fast, model, obstacles, time, *pose)
    return fast, np.array([cast_beam(i, model, obstacles, time, *pose) for i in range(lidar.beams)])


@given(
    worlds(),
    st.integers(1, 400),
    st.floats(0.2, 7.0),
    st.booleans(),
    st.floats(0.0, 5.0),
    coordinate,
    coordinate,
    st.floats(-9.0, 9.0),
)
def test_visiting_only_covered_beams_gives_the_same_scan(world, beams, view, clockwise, time, x, y, theta):
    lidar = ideal_lidar(
        beams=beams, field_of_view_rad=min(view, 2.0 * math.pi), clockwise=clockwise, mount=Pose(0.1, -0.05, 0.7)
    )
    fast, plain = both(lidar, world, time, (x, y, theta))
    # a ray that grazes a circle within rounding may hit or miss; everything else agrees to rounding
    grazing = np.isfinite(fast) != np.isfinite(plain)
    assert grazing.sum() <= 1
    close = np.isfinite(fast) & np.isfinite(plain)
    assert np.allclose(fast[close], plain[close], rtol=1e-9, atol=1e-7)
    assert np.sum(np.abs(fast[close] - plain[close]) > 1e-11) <= 2


def scan_of(world, lidar, start=(0.0, 0.0, 0.0)):
    return SimBase(hybrid(lidar=lidar), world, start=start).observe().scan


def test_distance_to_a_wall_is_distance_over_cosine():
    scan = scan_of(World("wall", segments=(Segment(2.0, -50.0, 2.0, 50.0),)), ideal_lidar(range_max=30.0))
    ahead = np.abs(scan.angles) < 1.3
    wanted = 2.0 / np.cos(scan.angles[ahead])
    assert np.allclose(scan.ranges[ahead], wanted, rtol=1e-13)


def test_distance_to_a_circle_solves_its_quadratic():
    scan = scan_of(World("post", circles=(Circle(3.0, 1.0, 0.5),)), ideal_lidar())
    along = 3.0 * np.cos(scan.angles) + np.sin(scan.angles)
    under = along**2 - (10.0 - 0.25)
    wanted = np.where((under >= 0.0) & (along > 0.0), along - np.sqrt(np.maximum(under, 0.0)), np.inf)
    assert np.allclose(scan.ranges, wanted, rtol=1e-12)


def test_a_box_is_seen_at_its_faces():
    box = Box(3.0, 0.0, 2.0, 1.0, math.pi / 2.0)  # turned: 1 m deep, 2 m wide
    assert scan_of(World("box", boxes=(box,)), ideal_lidar()).ranges[0] == pytest.approx(2.5, rel=1e-12)


@pytest.mark.parametrize("filled", [{"circles": (Circle(0.0, 0.0, 1.0),)}, {"boxes": (Box(0.0, 0.0, 1.0, 1.0),)}])
def test_inside_an_obstacle_everything_is_at_zero(filled):
    model, obstacles = model_of(hybrid(lidar=ideal_lidar()), 1e-3), obstacles_of(World("in", **filled))
    ranges = np.empty(360)
    cast(ranges, model, obstacles, 0.0, 0.1, 0.1, 0.0)
    assert np.all(ranges == 0.0)


def test_beams_turn_the_way_the_sensor_turns():
    post = World("post", circles=(Circle(0.0, 3.0, 0.5),))  # on the left, at +90 degrees
    for clockwise, beam in ((True, 270), (False, 90)):
        scan = scan_of(post, ideal_lidar(clockwise=clockwise))
        assert np.argmin(scan.ranges) == beam
        assert math.remainder(scan.angles[beam] - math.pi / 2.0, 2.0 * math.pi) == pytest.approx(0.0, abs=1e-12)


def test_a_narrow_view_is_symmetric_about_the_sensor():
    scan = scan_of(World("void"), ideal_lidar(beams=11, field_of_view_rad=1.0, clockwise=False))
    assert scan.angles[0] == pytest.approx(-0.5)
    assert scan.angles[-1] == pytest.approx(0.5)


def test_limits_of_range_and_dropouts_are_told_apart():
    world = World("wall", segments=(Segment(2.0, -50.0, 2.0, 50.0),))
    assert np.isnan(scan_of(world, ideal_lidar(range_min=2.5)).ranges[0])
    assert np.isinf(scan_of(world, ideal_lidar(range_max=1.5)).ranges[0])
    assert np.isinf(scan_of(world, ideal_lidar(dropout=1.0)).ranges).all()


def test_noise_has_the_larger_of_the_two_spreads_and_no_bias():
    arena = World("arena", circles=(), size=(2.0, 2.0), corner=(-1.0, -1.0))
    lidar = ideal_lidar(noise_m=0.002, noise_relative=0.01, beams=720, dropout=0.05)
    base = SimBase(hybrid(lidar=lidar, footprint_radius_m=0.1), arena, start=(0.3, -0.2, 0.4), seed=3)
    clean = SimBase(hybrid(lidar=replace(lidar, noise_m=0.0, noise_relative=0.0, dropout=0.0)), None)
    true = np.empty(720)
    cast(true, clean._model, obstacles_of(arena), 0.0, 0.3, -0.2, 0.4)
    scans = []
    for _ in range(600):
        observation = base.observe()
        if observation.scan_is_new:
            scans.append(observation.scan.ranges)
        base.apply(WheelCommand((0.0, 0.0, 0.0)))
    scans = np.array(scans)
    lost = np.isinf(scans)
    assert abs(lost.mean() - 0.05) < 5.0 * math.sqrt(0.05 * 0.95 / lost.size)
    z = (scans - true) / np.maximum(0.002, 0.01 * true)
    z = z[~lost]
    assert abs(z.mean()) < 4.0 / math.sqrt(z.size)
    assert abs(z.std() - 1.0) < 4.0 / math.sqrt(2.0 * z.size)


def drive(base, speeds, ticks):
    scans = []
    for _ in range(ticks):
        observation = base.observe()
        if observation.scan_is_new:
            scans.append((observation.scan, base.truth))
        base.apply(DutyCommand(speeds))
    return scans


def test_a_standing_sensor_sees_the_same_distorted_or_not():
    world = World("room", size=(6.0, 4.0), corner=(-3.0, -2.0), circles=(Circle(1.0, 0.5, 0.3),))
    (still, _), *_ = drive(SimBase(hybrid(lidar=ideal_lidar()), world), (0.0, 0.0, 0.0), 11)
    (moving, _), *_ = drive(SimBase(hybrid(lidar=ideal_lidar(motion_distortion=True)), world), (0.0, 0.0, 0.0), 12)
    assert np.allclose(still.ranges, moving.ranges, rtol=1e-10)
    assert moving.stamp == pytest.approx(0.1)
    assert moving.offsets[-1] == 0.0
    assert moving.offsets[0] == pytest.approx(-0.1 * 359 / 360)


def test_each_beam_of_a_distorted_scan_is_taken_from_where_the_robot_was():
    """Driving ahead at v, a beam straight ahead taken dt before the stamp measures v dt more than at the stamp."""
    wall = World("wall", segments=(Segment(5.0, -50.0, 5.0, 50.0),))
    robot = hybrid(lidar=ideal_lidar(motion_distortion=True, rate_hz=2.0, clockwise=False))
    base = SimBase(robot, wall)
    *_, (scan, pose) = drive(base, (0.0, 0.8, -0.8), 301)  # straight ahead
    speed = base.true_twist.vx
    assert speed > 0.05
    for beam in (1, 30, 300, 350):
        where = pose.x + scan.offsets[beam] * speed
        wanted = (5.0 - where) / math.cos(scan.angles[beam])
        assert scan.ranges[beam] == pytest.approx(wanted, abs=1e-9)
