"""Laws of the trackers that know their wheels' lag: ff_pi, dob, mpc."""

import math
from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose

import holodrive as hd
from holodrive import control, geometry, planning, references, tuning
from holodrive.control import ltv_mpc
from holodrive.control.ltv_mpc import LtvMpc, course
from holodrive.errors import HolodriveError
from holodrive.kinematics import Chassis
from holodrive.types import Estimate, Observation, Pose, Reference, Twist, WheelState

NAMES = ("ff_pi", "dob", "mpc")
ROBOT = hd.load("mecanum4_mice")
DT, JACOBIAN = ROBOT.control_period_s, Chassis.of(ROBOT).jacobian
BACK = np.linalg.pinv(JACOBIAN)
EXACT = {"still_m_s": 0.0, "rest_m": 0.0, "rest_rad": 0.0}
# without what takes disturbances away: the P on the pose alone
ONLY_P = {"ff_pi": {"ki": 0.0, "ki_theta": 0.0, "wheel_kp": 0.0, "wheel_ki": 0.0}, "dob": {"trust": 0.0},
          "mpc": {"trust": 0.0}}  # fmt: skip


def sent(driver, reference, pose, k=0, dt=DT, n=4):
    """Wheel speeds (n,) of one tick."""
    wheels = WheelState(np.full(n, math.nan), np.full(n, math.nan), np.zeros(0))
    estimate = Estimate(Pose(*pose), Twist(0.0, 0.0, 0.0), np.zeros((3, 3)))
    return np.array(driver.step(reference, estimate, Observation(k * dt, dt, wheels)).command.speeds)


def follow(name, table, params, *, lag_s=0.0, disturbance=(0.0, 0.0, 0.0), time=None):
    """Errors (T, 3) of a tracker on wheels with an exact lag and a constant disturbance of the body's twist."""
    driver = control.controller(name, ROBOT, {"lag_s": lag_s, **EXACT, **params})
    follower, pose, speeds = references.ReferenceFollower(table), table.rows[0, 1:4].copy(), np.zeros(4)
    decay = math.exp(-DT / lag_s) if lag_s else 0.0
    mean = (1.0 - decay) * lag_s / DT
    errors = []
    for k in range(round((time or table.duration_s) / DT)):
        reference = follower.step(k * DT, Pose(*pose))
        errors.append(pose - np.array(reference.pose))
        told = sent(driver, reference, pose, k)
        twist = BACK @ (told + (speeds - told) * mean) + np.array(disturbance)
        turned = pose[2] + DT * twist[2]
        pose = geometry.compose(pose, geometry.exp(DT * twist))
        pose[2] = turned
        speeds = told + (speeds - told) * decay
    return np.array(errors)


def steady(velocity, time=6.0):
    """A reference that moves with constant velocity (3,) from the first moment on."""
    times = np.linspace(0.0, time, 400)
    rows = np.outer(times, velocity)
    return references.trajectory(times, rows, np.tile(velocity, (400, 1)), np.zeros((400, 3)))


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("velocity", [(0.01, -0.007, 0.0), (0.01, 0.0, 0.05)])
def test_there_is_no_error_without_disturbance_and_lag(name, velocity):
    params = {"s_xy": 0.0, "s_theta": 0.0} if name == "mpc" else {}  # it starts with a jump of the speed
    assert_allclose(follow(name, steady(velocity), params), 0.0, atol=1e-8)


@pytest.mark.parametrize("name", NAMES)
def test_a_lag_that_is_known_leaves_no_error_behind_acceleration(name):
    """From rest along a circle: the speeds ramp up, the direction turns."""
    errors = follow(name, planning.follow(planning.circle(0.1), 0.02), {}, lag_s=0.05)
    plain = follow("ff_pi", planning.follow(planning.circle(0.1), 0.02), {**ONLY_P["ff_pi"], "lag_s": 0.0}, lag_s=0.05)
    assert np.abs(errors[:, :2]).max() < 3e-5
    assert np.abs(plain[:, :2]).max() > 10.0 * np.abs(errors[:, :2]).max()


@pytest.mark.parametrize(
    ("name", "params"),
    [
        ("ff_pi", {"ki": 0.0, "ki_theta": 0.0}),  # the wheels' integrals
        ("ff_pi", {"wheel_kp": 0.0, "wheel_ki": 0.0, "ki": 4.0, "ki_theta": 4.0}),  # that of the pose
        ("dob", {}),
        ("mpc", {}),
    ],
)
def test_a_constant_disturbance_is_rejected_where_a_proportional_loop_leaves_an_error(name, params):
    disturbance, table = (0.002, -0.001, 0.01), steady((0.015, 0.004, 0.0), 9.0)
    for lag_s in (0.0, 0.05):
        kept = follow(name, table, params, lag_s=lag_s, disturbance=disturbance)
        left = follow(name, table, ONLY_P[name], lag_s=lag_s, disturbance=disturbance)
        assert_allclose(kept[-1], 0.0, atol=2e-6)
        assert np.hypot(*left[-1, :2]) > 1e-4
        assert abs(left[-1, 2]) > 1e-4


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("direction", [0.0, 0.4, 2.0, -1.2])
def test_limits_are_kept_and_the_direction_with_them(name, direction):
    """A goal out of reach: the wheels go as fast as they may, straight towards it."""
    limit, pose = ROBOT.wheels[0].max_speed_rad_s, np.zeros(3)
    away = np.array([math.cos(direction), math.sin(direction)])
    driver = control.controller(name, ROBOT, {"lag_s": 0.0})
    for k in range(30):
        speeds = sent(driver, Reference(Pose(*(10.0 * away), 0.0)), pose, k)
        assert np.abs(speeds).max() <= limit * (1.0 + 1e-9)
        pose = geometry.compose(pose, geometry.exp(DT * BACK @ speeds))
    assert np.abs(speeds).max() > 0.9 * limit
    assert_allclose(pose[:2] / np.hypot(*pose[:2]), away, atol=2e-3)


@pytest.mark.parametrize("name", NAMES)
def test_saturation_winds_nothing_up(name):
    """After 3 s against a limit with the base held, a reached goal stops it within a second without turning back."""
    driver = control.controller(name, ROBOT, {"trust": 0.5} if name != "ff_pi" else None)
    for k in range(200):
        sent(driver, Reference(Pose(10.0, 0.0, 0.0)), (0.0, 0.0, 0.0), k)
    late = [sent(driver, Reference(Pose(0.0, 0.0, 0.0)), (0.0, 0.0, 0.0), k) for k in range(200, 270)]
    assert_allclose(late[-1], 0.0, atol=1e-3)


@pytest.mark.parametrize("name", NAMES)
def test_nan_means_stop(name):
    reference = Reference(Pose(1.0, 0.0, 0.0))
    for bad in ((math.nan, 0.0, 0.0), (0.0, 0.0, math.nan)):
        assert not np.all(np.isfinite(sent(control.controller(name, ROBOT), reference, bad)))
    broken = Reference(Pose(math.nan, 0.0, 0.0))
    assert not np.all(np.isfinite(sent(control.controller(name, ROBOT), broken, (0.0, 0.0, 0.0))))


@pytest.mark.parametrize("name", ["ff_pi", "dob"])
def test_loop_and_roll_out_drive_the_same_run_on_measured_actuators_by_mice(name):
    table = planning.follow(planning.circle(0.05), 0.02)
    base = hd.simulate(ROBOT, plant="pwm_map", seed=4, start=table.rows[0, 1:4])
    loop = hd.drive(base, name, trajectory=table, duration_s=3.0)
    rolled = hd.rollout(
        ROBOT, None, name, reference=table, starts=table.rows[0, 1:4], t=3.0, plant="pwm_map", seed=4, log_every=1
    )
    assert_allclose(rolled.log[0, : len(loop.time), 1:4], loop.pose, atol=1e-12)


@pytest.mark.parametrize("name", ["ff_pi", "dob"])
def test_a_lag_that_is_told_wrong_by_half_still_leaves_a_fifth_of_the_error_of_la_g(name):
    """By default they take the lag that the simulated actuators have; the gain must not hang on that."""
    slow = replace(ROBOT, pwm_map=replace(ROBOT.pwm_map, lag_s=0.1, dead_time_s=0.08))
    path = planning.follow(planning.lemniscate(0.1), 0.02)

    def distances(controller, **params):
        out = hd.rollout(slow, None, controller, params=params, n=2, seed=1, reference=path, t=path.duration_s,
                         plant="pwm_map", estimator="mouse_odometry", log_every=1)  # fmt: skip
        way = np.stack([out.column("x"), out.column("y")], axis=-1)
        return planning.distance_to_path(path, way).sum()

    assert 5.0 * distances(name, lag_s=0.05) < distances("la_g", variant="printed")


@pytest.mark.parametrize("name", NAMES)
def test_moving_and_turning_the_world_moves_and_turns_the_whole_run(name):
    table, shift = planning.follow(planning.circle(0.05), 0.02), np.array([1.0, -2.0, 0.8])
    moved = table.rows.copy()
    moved[:, 1:4] = geometry.compose(shift, moved[:, 1:4])
    c, s = math.cos(shift[2]), math.sin(shift[2])
    for column in (4, 7):
        x, y = table.rows[:, column], table.rows[:, column + 1]
        moved[:, column], moved[:, column + 1] = c * x - s * y, s * x + c * y
    there = references.Table(references.TRAJECTORY, moved)
    here = follow(name, table, {}, lag_s=0.05, time=2.0)[:, :2]
    turned = follow(name, there, {}, lag_s=0.05, time=2.0)[:, :2]
    assert_allclose(turned, here @ np.array([[c, s], [-s, c]]), atol=1e-9)


def test_a_wheel_that_reverses_begins_with_the_mirror_of_what_it_has_learnt():
    """Actuators that are weak by the same speed both ways: the way back needs nothing to be learnt."""
    driver = control.controller("ff_pi", ROBOT, {**EXACT, "lag_s": 0.0, "ki": 0.0, "wheel_filter_s": 0.0})
    pose, weak, way = np.zeros(3), 0.1, 0.0
    errors = []
    for k in range(400):
        v = 0.01 if k < 200 else -0.01
        told = sent(driver, Reference(Pose(way, 0.0, 0.0), Twist(v, 0.0, 0.0), Twist(0, 0, 0), False), pose, k)
        pose = geometry.compose(pose, geometry.exp(DT * BACK @ (told - weak * np.sign(told))))
        way += DT * v
        errors.append(abs(way - pose[0]))
    assert max(errors[:30]) > 1e-4
    assert max(errors[205:]) < 0.3 * max(errors[:30])


def test_course_carries_a_reference_on_along_its_arc():
    circle = references.ReferenceFollower(planning.follow(planning.circle(0.2), 0.02))
    now, times = circle.step(10.0, Pose(0, 0, 0)), np.linspace(0.0, 1.0, 11)
    poses, velocities = course(now, times, 0.1)
    true = [circle.step(10.0 + t, Pose(0, 0, 0)) for t in times]
    assert_allclose(poses, [r.pose for r in true], atol=1e-6)
    assert_allclose(velocities, [r.twist for r in true], atol=1e-5)


def test_course_starts_from_rest_the_way_the_reference_accelerates():
    now = Reference(Pose(0, 0, 0), Twist(0, 0, 0), Twist(0.03, 0.04, 0.0), False)
    poses, velocities = course(now, np.array([0.1]), 1.0)
    assert_allclose(poses[0, :2], [0.5 * 0.03 * 0.01, 0.5 * 0.04 * 0.01])
    assert_allclose(velocities[0, :2], [0.003, 0.004])


def test_without_a_plan_the_pose_loop_drives_and_it_is_told_once():
    robot_controller = control.controller("mpc", ROBOT, {"max_iterations": 1})
    reference, told = Reference(Pose(1.0, 0.7, 2.0)), []
    for k in range(4):
        wheels = WheelState(np.full(4, math.nan), np.full(4, math.nan), np.zeros(0))
        believed = Estimate(Pose(0.0, 0.0, 0.0), Twist(0.0, 0.0, 0.0), np.zeros((3, 3)))
        decision = robot_controller.step(reference, believed, Observation(k * DT, DT, wheels))
        told.append(decision.fault)
        assert np.all(np.isfinite(decision.command.speeds))
    assert robot_controller.fallbacks == robot_controller.solutions == 4
    assert "pose loop" in told[0]
    assert told[1:] == ["", "", ""]


@pytest.mark.parametrize("name", ["ff_pi", "dob"])
@pytest.mark.parametrize("robot", ["omni4", "swerve3", "optiodom_omni3"])
@pytest.mark.parametrize("plant", ["first_order", "slip"])
def test_they_follow_on_any_base(name, robot, plant):
    table = planning.follow(planning.circle(0.3), 0.05)
    run = hd.rollout(robot, None, name, reference=table, starts=table.rows[0, 1:4], t=8.0, plant=plant, estimator=None)
    assert run.metrics["max_error_m"][0] < 0.03
    assert not run.fault.any()


@pytest.mark.parametrize("name", NAMES)
def test_the_bounds_for_tuning_are_fields_around_their_defaults(name):
    plug, space = control.plug(name), tuning.space(name)
    for one in space.ranges:
        assert one.low <= getattr(plug, one.field) <= one.high
        assert control.plug(name, {one.field: one.low}) != control.plug(name, {one.field: one.high})


@pytest.mark.parametrize(
    ("name", "params", "word"),
    [
        ("ff_pi", {"wheel_ki": -1.0}, "0 or more"),
        ("dob", {"q_s": 0.0}, "above 0"),
        ("dob", {"lag_s": -0.1}, "0 or more"),
        ("mpc", {"steps": 2.5}, "whole number"),
        ("mpc", {"r_xy": 0.0}, "above 0"),
        ("mpc", {"rest_m": -1.0}, "0 or more"),
        ("dob", {"qs": 0.1}, "Did you mean 'q_s'"),
    ],
)
def test_parameters_that_cannot_be_are_refused(name, params, word):
    with pytest.raises(HolodriveError, match=word):
        control.plug(name, params)


def test_the_mpc_keeps_acceleration_limits_of_the_robot():
    limited = replace(ROBOT, limits=replace(ROBOT.limits, accel_m_s2=0.05))
    driver = LtvMpc(still_m_s=0.0).controller(limited)
    first = BACK @ sent(driver, Reference(Pose(1.0, 0.0, 0.0)), (0.0, 0.0, 0.0))
    assert 0.0 < math.hypot(first[0], first[1]) <= 0.05 * DT * (1.0 + 1e-6)
    assert isinstance(driver, ltv_mpc.LtvMpcController)
