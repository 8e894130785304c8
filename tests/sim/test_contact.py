"""Collisions: events with time, place and who moved; nobody gets into anything."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from machines import hybrid, with_motor

import holodrive as hd
from holodrive.kinematics import Chassis
from holodrive.obstacles import clearance
from holodrive.sim import SimBase
from holodrive.types import DutyCommand
from holodrive.worlds.spec import Box, Circle, KeyFrame, Mover, Segment, World

QUICK = with_motor(hybrid(), lag_s=0.0)
PLANTS = pytest.mark.parametrize("plant", ["first_order", "slip"])


def duty_for(robot, twist):
    speeds = Chassis.of(robot).inverse(twist).speeds
    return speeds / max(w.motor.no_load_speed_rad_s for w in robot.wheels)


def test_a_collision_is_told_with_its_time_place_and_who_moved():
    base = SimBase(QUICK, World("post", circles=(Circle(1.0, 0.0, 0.2, "post"),)), start=(0.3, 0.0, 0.0))
    speed = 0.08
    for _ in range(500):
        base.apply(DutyCommand(duty_for(QUICK, (speed, 0.0, 0.0))))
    (event,) = base.take_events()
    gap = 1.0 - 0.2 - 0.28 - 0.3
    assert event.kind == "collision"
    assert event.time == pytest.approx(gap / speed, abs=1.1e-3)
    assert np.allclose(event.data["place"], (0.8, 0.0), atol=1e-4)
    assert event.data["obstacle"] == "post"
    assert event.data["moved"] == "robot"
    assert event.data["robot_speed_m_s"] == pytest.approx(speed)
    assert base.take_events() == []
    assert base.true_twist.vx == pytest.approx(0.0, abs=1e-12)


@PLANTS
def test_a_mover_that_runs_into_a_standing_robot_pushes_it_and_is_named(plant):
    cart = Mover(0.2, (KeyFrame(0.0, 2.0, 0.0), KeyFrame(10.0, 0.0, 0.0)), name="cart")
    base = SimBase(QUICK, World("cart", movers=(cart,)), plant=plant)
    for _ in range(1000):
        base.apply(DutyCommand((0.0, 0.0, 0.0)))
    (event,) = base.take_events()
    assert event.data["moved"] == "obstacle"
    assert event.data["mover_speed_m_s"] == pytest.approx(0.2)
    assert event.time == pytest.approx((2.0 - 0.48) / 0.2, abs=2e-3)
    assert base.truth.x == pytest.approx(-0.48, abs=1e-3)


def test_a_robot_slides_along_a_wall_that_it_drives_into_slantwise():
    base = SimBase(QUICK, World("room", size=(4.0, 4.0), corner=(-2.0, -2.0)), start=(1.7, 0.0, 0.0))
    for _ in range(300):
        base.apply(DutyCommand(duty_for(QUICK, (0.05, 0.05, 0.0))))
    assert base.truth.x == pytest.approx(2.0 - 0.28, abs=1e-6)
    assert base.truth.y == pytest.approx(0.15, rel=1e-6)
    assert len(base.take_events()) == 1


def test_leaving_and_coming_back_is_a_second_collision_and_trembling_is_not():
    base = SimBase(QUICK, World("room", size=(4.0, 4.0), corner=(-2.0, -2.0)), start=(1.7, 0.0, 0.0))
    for k in range(900):
        ahead = 0.08 if k < 300 or k >= 500 else -0.05
        if 200 <= k < 300:
            ahead *= (-1.0) ** k
        base.apply(DutyCommand(duty_for(QUICK, (ahead, 0.0, 0.0))))
    assert len(base.take_events()) == 2


@PLANTS
@settings(max_examples=25)
@given(st.floats(-math.pi, math.pi), st.integers(0, 2**31))
def test_nobody_ever_gets_into_anything(plant, heading, seed):
    world = World(
        "crowd",
        size=(3.0, 3.0),
        corner=(-1.5, -1.5),
        circles=(Circle(0.9, 0.2, 0.2),),
        boxes=(Box(-0.8, -0.6, 0.5, 0.3, 0.4),),
    )
    base = SimBase(QUICK, world, plant=plant)
    rng = np.random.default_rng(seed)
    vx, vy = 0.1 * math.cos(heading), 0.1 * math.sin(heading)
    times, poses = [], []
    for _ in range(40):
        twist = (vx, vy, rng.uniform(-0.3, 0.3))
        for _ in range(50):
            base.apply(DutyCommand(np.clip(duty_for(QUICK, twist), -1.0, 1.0)))
            times.append(base.time)
            poses.append(base.truth)
    assert clearance(world, times, np.array(poses), QUICK.footprint_radius_m).min() > -1e-7


def test_clearance_counts_what_is_filled_as_below_zero():
    world = World("w", circles=(Circle(0.0, 0.0, 1.0),), boxes=(Box(5.0, 0.0, 2.0, 1.0),))
    points = np.array([(0.5, 0.0), (2.0, 0.0), (5.0, 0.0), (5.0, 2.0)])
    assert np.allclose(clearance(world, np.zeros(4), points, 0.0), (-0.5, 1.0, -0.5, 1.5))
    assert np.all(np.isinf(clearance(World("open"), [0.0], [(0.0, 0.0)], 0.3)))


def test_movers_wait_at_the_ends_of_their_path_or_start_again():
    path = (KeyFrame(1.0, 0.0, 0.0), KeyFrame(3.0, 2.0, 0.0), KeyFrame(4.0, 2.0, 1.0))
    for loop, time, wanted in (
        (False, 0.0, (0.0, 0.0)),
        (False, 2.0, (1.0, 0.0)),
        (False, 3.5, (2.0, 0.5)),
        (False, 9.0, (2.0, 1.0)),
        (True, 5.0, (1.0, 0.0)),
        (True, 6.5, (2.0, 0.5)),
    ):
        world = World("m", movers=(Mover(0.25, path, loop),))
        assert clearance(world, [time], [wanted], 0.0)[0] == pytest.approx(-0.25)


@pytest.mark.parametrize("plant", ["first_order", "slip"])
def test_mice_see_the_ground_pass_even_while_a_wall_holds_the_robot(plant):
    """Wheels turn on against the wall; what the mice count is where the robot went."""
    import holodrive as hd

    world = World("wall", size=(4.0, 4.0), corner=(-2.0, -2.0), segments=(Segment(0.5, -2.0, 0.5, 2.0),))
    base = hd.simulate("mecanum4", world, plant=plant)
    way = np.zeros(2)
    for _ in range(1500):
        base.apply(hd.WheelCommand((2.0,) * 4))
        way += base.observe().mice[0]
    assert base.truth.x < 0.45
    np.testing.assert_allclose(way, base.truth[:2], atol=2e-3)


def test_a_loop_that_jumps_cannot_jump_through_a_robot_unseen():
    """The path ends elsewhere than it begins, so the mover is back at its start at once, where the robot stands."""
    import holodrive as hd

    path = (KeyFrame(0.0, 0.2, 0.0), KeyFrame(5.0, 8.0, 0.0))
    world = World("loop", movers=(Mover(0.2, path, loop=True),))
    base = hd.simulate("omni4", world, start=(-3.0, 0.0, 0.0))
    run = hd.drive(base, goal=(0.0, 0.0), duration_s=40.0, stop_on_arrival=False)
    assert run.metrics["collisions"] > 0
    assert run.metrics["min_clearance_m"] > -1e-6


def test_a_loop_waits_at_its_first_key_frame_until_it_begins():
    path = (KeyFrame(2.0, 1.0, 0.0), KeyFrame(4.0, 3.0, 0.0), KeyFrame(6.0, 1.0, 0.0))
    world = World("late", movers=(Mover(0.2, path, loop=True),))
    gaps = clearance(world, np.array([0.0, 1.0, 2.0, 4.0, 6.0, 8.0]), np.zeros((6, 2)), 0.0)
    np.testing.assert_allclose(gaps, [0.8, 0.8, 0.8, 2.8, 0.8, 2.8], atol=1e-9)


def test_a_standing_robot_that_is_pushed_against_a_wall_did_not_run_into_it():
    """What a mover's push gives it is not the robot's own motion, not even in the tick of the push."""
    mover = Mover(0.2, (KeyFrame(0.0, -1.5, 0.0), KeyFrame(3.0, 1.5, 0.0)), name="pusher")
    robot = hd.load("hybrid3_table_x")
    world = World("push", circles=(Circle(robot.footprint_radius_m + 0.21, 0.0, 0.2, "post"),), movers=(mover,))
    base = hd.simulate(robot, world)
    events = []
    for _ in range(180):
        base.apply(hd.WheelCommand(np.zeros(3)))
        events += base.take_events()
    touched = {event.data["obstacle"]: event.data["moved"] for event in events if event.kind == "collision"}
    assert touched["pusher"] == "obstacle"
    assert touched.get("post") not in ("robot", "both")
