"""Fuzzy avoidance with PIDs and with MPC: what they share, and what each promises."""

import math
from dataclasses import replace

import numpy as np
import pytest

import holodrive as hd
from holodrive import control, planning, worlds
from holodrive.control import avoidance
from holodrive.control.fuzzy_mpc import FuzzyMpc, extrapolated
from holodrive.control.fuzzy_pid import FuzzyPid
from holodrive.errors import HolodriveError
from holodrive.kinematics import Chassis
from holodrive.perception.scan_points import ROW
from holodrive.types import Estimate, Observation, Pose, Reference, Scan, Twist, WheelState

ROBOT = hd.load("hybrid3_table_x")
CASCADES = ("fuzzy_pid", "fuzzy_mpc")
BEAMS = 360


def believed(pose=(0.0, 0.0, 0.0), twist=(0.0, 0.0, 0.0)):
    return Estimate(Pose(*pose), Twist(*twist), np.zeros((3, 3)))


def scan(ranges, time=0.0):
    angles = 2.0 * math.pi * np.arange(BEAMS) / BEAMS
    return Scan(time, angles, np.full(BEAMS, ranges, dtype=float), np.zeros(BEAMS), range_min=0.15, range_max=12.0)


def seen(time=0.0, ranges=math.inf, speeds=(0.0, 0.0, 0.0)):
    wheels = WheelState(np.zeros(3), np.array(speeds, dtype=float), np.zeros(0))
    return Observation(time, 0.01, wheels, scan=scan(ranges, time), scan_is_new=True)


def tracked(name, track, plant, params=None):
    """RMS [m] and IAE [m s] of one run beside a moving reference."""
    start = track.rows[0, 1:4] + (0.2, -0.2, 1.0)
    base = hd.simulate(ROBOT, plant=plant, start=start)
    run = hd.drive(base, name, trajectory=track, params=params, duration_s=track.duration_s, stop_on_arrival=False)
    return run.metrics["rms_error_m"], run.metrics["iae_m_s"]


@pytest.mark.parametrize("plant", ["first_order", "slip"])
@pytest.mark.parametrize("path", [planning.circle(0.5), planning.lemniscate(0.4)], ids=["circle", "lemniscate"])
def test_each_cascade_follows_a_moving_reference_better_than_the_fuzzy_avoidance_alone(path, plant):
    track = planning.follow(path, 0.1)
    alone = tracked("fuzzy", track, plant)
    for name in CASCADES:
        assert np.all(np.less(tracked(name, track, plant), alone)), name


@pytest.mark.parametrize("name", CASCADES)
def test_each_cascade_passes_the_papers_course_without_a_collision(name):
    run = hd.drive(hd.simulate(ROBOT, world="paper_course", seed=1), name)
    assert run.ended == "arrived"
    assert run.metrics["collisions"] == 0.0
    assert run.metrics["min_clearance_m"] > 0.02


@pytest.mark.parametrize("seed", [101, 102, 103])
@pytest.mark.parametrize("name", CASCADES)
def test_each_cascade_passes_random_courses_without_a_collision(name, seed):
    run = hd.drive(hd.simulate(ROBOT, world=worlds.course(seed), seed=seed), name, duration_s=90.0)
    assert run.ended == "arrived"
    assert run.metrics["collisions"] == 0.0


def test_the_compiled_cascade_drives_in_roll_outs_as_in_the_loop():
    run = hd.drive(hd.simulate(ROBOT, world="paper_course", seed=3), "fuzzy_pid", duration_s=6.0)
    rolled = hd.rollout(ROBOT, "paper_course", "fuzzy_pid", t=6.0, seed=3, log_every=1)
    np.testing.assert_allclose(rolled.log[0, : len(run.time), 1:4], run.pose, atol=1e-9)


def test_wheel_speeds_of_the_cascade_stay_inside_the_wheels_limits():
    driver = control.controller("fuzzy_pid", ROBOT)
    limits = Chassis.of(ROBOT).max_speeds
    for k in range(100):
        decision = driver.step(Reference(Pose(3.0, -2.0, 2.0)), believed(), seen(0.01 * k))
        assert np.all(np.abs(decision.command.speeds) <= limits * (1.0 + 1e-9))


def test_without_encoders_the_wheels_get_the_feed_forward():
    """Encoder speeds are NaN on such a robot: commands are those of a cascade without inner loop."""
    free = {"wheel_slew_m_s2": math.inf}
    blind, alone = (control.controller("fuzzy_pid", ROBOT, free | p) for p in ({}, {"wheel_share": 0.0}))
    goal = Reference(Pose(0.3, 0.1, 0.2))
    for k in range(20):
        at = believed((0.001 * k, 0.0, 0.0))
        a = blind.step(goal, at, seen(0.01 * k, speeds=(math.nan,) * 3)).command.speeds
        b = alone.step(goal, at, seen(0.01 * k, speeds=(0.3, 0.2, 0.1))).command.speeds
        np.testing.assert_array_equal(a, b)


# --- MPC -----------------------------------------------------------------------------------------


def test_a_circle_and_a_line_are_extrapolated_exactly():
    times = np.linspace(0.0, 3.0, 16)
    w, r = 0.4, 0.5
    circle = Reference(Pose(r, 0.0, 0.3), Twist(0.0, r * w, 0.1), Twist(-r * w * w, 0.0, 0.0), last=False)
    expected = np.stack([r * np.cos(w * times), r * np.sin(w * times), 0.3 + 0.1 * times], axis=-1)
    np.testing.assert_allclose(extrapolated(circle, times), expected, atol=1e-12)
    line = Reference(Pose(1.0, 2.0, 0.0), Twist(0.1, -0.2, 0.0), last=False)
    np.testing.assert_allclose(extrapolated(line, times)[:, :2], (1.0, 2.0) + times[:, None] * (0.1, -0.2))
    still = Reference(Pose(1.0, 2.0, 0.5))
    np.testing.assert_array_equal(extrapolated(still, times), np.tile((1.0, 2.0, 0.5), (16, 1)))


def test_a_start_of_the_reference_is_not_carried_on():
    """A reference that speeds up along its path goes on at the speed that it has: starts are short, horizons long."""
    times = np.array([0.0, 2.0])
    starting = Reference(Pose(0.0, 0.0, 0.0), Twist(0.1, 0.0, 0.0), Twist(0.2, 0.0, 0.0), last=False)
    np.testing.assert_allclose(extrapolated(starting, times)[1], (0.2, 0.0, 0.0))


def test_the_mpc_leaves_what_the_fuzzy_avoidance_remembers_alone():
    """Between scans nothing that the fuzzy avoidance keeps of earlier ones changes."""
    driver, goal, kept = FuzzyMpc().controller(ROBOT), Reference(Pose(2.0, 0.0, 0.0)), []
    ranges = np.where(np.arange(BEAMS) % 90 < 20, 0.8, 3.0)
    for k in range(60):
        driver.step(goal, believed(), replace(seen(0.01 * k, ranges), scan_is_new=k % 18 == 0))
        memory, params = driver._memory, driver._fuzzy
        first = avoidance.VARIABLE + ROW * int(params[avoidance.HISTORY])
        kept.append(memory[first : len(memory) - 3 * BEAMS].copy())
    assert driver.solutions > 5
    for k in range(1, 60):
        if k % 18:
            np.testing.assert_array_equal(kept[k], kept[k - 1])


@pytest.mark.parametrize("name", ["fuzzy", *CASCADES])
def test_a_lidar_that_falls_silent_stops_the_robot_and_says_why(name):
    driver, goal, faults = control.controller(name, ROBOT), Reference(Pose(2.0, 0.0, 0.0)), []
    for k in range(80):
        observation = (
            seen(0.01 * k) if k == 0 else replace(seen(), time=0.01 * k, scan=scan(math.inf), scan_is_new=False)
        )
        decision = driver.step(goal, believed(), observation)
        faults.append(decision.fault)
    np.testing.assert_allclose(
        [*decision.command[0], *decision.command[1]] if name == "fuzzy_pid" else decision.command, 0.0
    )
    assert sum(bool(fault) for fault in faults) == 1
    assert "too old" in max(faults, key=len)


def test_without_a_plan_the_fuzzy_avoidance_drives_and_people_are_told_once():
    driver, fuzzy = FuzzyMpc(max_iterations=1).controller(ROBOT), control.controller("fuzzy", ROBOT)
    goal, faults = Reference(Pose(2.0, 1.0, 0.0)), []
    for k in range(30):
        decision = driver.step(goal, believed(), seen(0.01 * k))
        faults.append(decision.fault)
        assert np.all(np.isfinite(decision.command))
        assert math.hypot(*decision.command[:2]) > 0.05
    assert "iteration limit" in faults[0]
    assert "fuzzy avoidance drives" in faults[0]
    assert not any(faults[1:])
    assert driver.fallbacks == driver.solutions == 6
    assert fuzzy.step(goal, believed(), seen()).command.vx > 0.0


def test_a_course_is_passed_on_the_fallback_alone():
    driver = FuzzyMpc(max_iterations=1)
    run = hd.drive(hd.simulate(ROBOT, world="paper_course", seed=1), driver, goal=(0.5, 4.5), duration_s=90.0)
    assert run.metrics["collisions"] == 0.0
    assert run.metrics["final_error_m"] < 0.05
    assert sum(event.kind == "fault" for event in run.events) == 1


def test_the_plan_keeps_out_of_an_obstacle_where_the_wish_goes_into_it():
    """A pillar between robot and goal, half a metre ahead: whatever is commanded, the hull does not come to it."""
    pose, driver = np.zeros(3), FuzzyMpc().controller(ROBOT)
    centre, radius = np.array([0.6, 0.03]), 0.15
    angles = 2.0 * math.pi * np.arange(BEAMS) / BEAMS
    for k in range(900):
        away = centre - pose[:2]
        along = np.cos(angles + pose[2]) * away[0] + np.sin(angles + pose[2]) * away[1]
        root = along**2 - away @ away + radius**2
        ranges = np.where((root > 0.0) & (along > 0.0), along - np.sqrt(np.maximum(root, 0.0)), math.inf)
        decision = driver.step(Reference(Pose(2.0, 0.0, 0.0)), believed(pose), seen(0.01 * k, ranges))
        vx, vy, omega = decision.command
        c, s = math.cos(pose[2]), math.sin(pose[2])
        pose += 0.01 * np.array([c * vx - s * vy, s * vx + c * vy, omega])
        assert np.hypot(*(centre - pose[:2])) > radius + ROBOT.footprint_radius_m
    assert pose[0] > 1.0


def test_accelerations_limits_that_are_infinite_need_no_rows():
    from holodrive.robots.spec import Limits

    free = replace(ROBOT, limits=Limits())
    decision = FuzzyMpc().controller(free).step(Reference(Pose(0.5, 0.0, 0.0)), believed(), seen())
    assert decision.command.vx > 0.1


@pytest.mark.parametrize(
    ("make", "word"),
    [
        (lambda: FuzzyPid(wheel_kp=-1.0), "0 or more"),
        (lambda: FuzzyPid(kp=0.0), "above 0"),
        (lambda: FuzzyPid(profile="repared").pack(ROBOT), "Did you mean 'repaired'"),
        (lambda: FuzzyMpc(steps=0), "above 0"),
        (lambda: FuzzyMpc(steps=2.5), "whole number"),  # type: ignore[arg-type]
        (lambda: FuzzyMpc(profile="repared").controller(ROBOT), "Did you mean 'repaired'"),
        (lambda: control.plug("fuzzy_mpc", {"step": 3}), "Did you mean 'steps'"),
    ],
)
def test_a_bad_parameter_gets_one_clear_line(make, word):
    with pytest.raises(HolodriveError, match=word) as caught:
        make()
    assert "\n" not in str(caught.value)
