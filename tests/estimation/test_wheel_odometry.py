"""Claims about wheel odometry: laws first."""

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from holodrive import geometry, robots
from holodrive.errors import InputError
from holodrive.estimation import Odometry, WheelOdometry, track
from holodrive.estimation.odometry import Counts
from holodrive.kinematics import Chassis, Wheel
from holodrive.robots.spec import Imu
from holodrive.types import Array, Pose, WheelState

START = Pose(1.0, -2.0, 2.5)
FAST = WheelOdometry(jump_factor=1e9)  # wheels may turn faster than the robot's can


def mixed() -> Chassis:
    """An omni wheel, a Mecanum wheel of 60 degrees and two modules."""
    return Chassis(
        {
            "omni": Wheel.omni(0.2, 0.05, 1.5, 0.05),
            "mecanum": Wheel.mecanum(-0.1, 0.2, 0.1, 0.06, math.radians(60)),
            "left": Wheel.swerve(0.0, 0.25, 0.04),
            "right": Wheel.swerve(0.05, -0.22, 0.05),
        }
    )


def chassis_of(name: str) -> Chassis:
    return mixed() if name == "mixed" else Chassis.of(robots.load(name))


def wheels_for(chassis: Chassis, twist: Array, dt: float) -> tuple[Array, Array]:
    """Angle increments (n,) and steering angles (m,) of a twist held for `dt`."""
    command = chassis.inverse(twist)
    return np.asarray(command.speeds) * dt, np.asarray(command.steer)


NAMES = [*robots.names(), "mixed"]
TWISTS = st.tuples(st.floats(-1, 1), st.floats(-1, 1), st.floats(-3, 3)).map(np.array)


@pytest.mark.parametrize("name", NAMES)
@given(twist=TWISTS, dt=st.floats(1e-3, 1.0))
def test_a_constant_twist_moves_the_pose_by_its_exponential(name: str, twist: Array, dt: float) -> None:
    """Even when the robot turns half way round in one step."""
    chassis = chassis_of(name)
    turns, steer = wheels_for(chassis, twist, dt)
    odometry = Odometry(chassis, FAST, START)
    odometry.update(0.0 * turns, steer=steer, stamp=0.0)
    estimate = odometry.update(turns, steer=steer, stamp=dt)
    np.testing.assert_allclose(estimate.pose, geometry.compose(START, geometry.exp(twist * dt)), atol=1e-11)
    np.testing.assert_allclose(estimate.twist, twist, atol=1e-10 / dt)
    assert estimate.slip < 1e-9 / dt


@pytest.mark.parametrize("name", NAMES)
def test_one_step_and_a_hundred_agree_in_pose_and_covariance(name: str) -> None:
    """Noise grows with the way, not with the number of samples."""
    chassis = chassis_of(name)
    turns, steer = wheels_for(chassis, np.array([0.4, -0.3, 1.2]), 1.0)
    params = FAST
    results = []
    for steps in (1000, 2000):
        share = np.linspace(0.0, 1.0, steps + 1)
        results.append(
            track(
                chassis,
                share,
                share[:, None] * turns,
                steer=np.tile(steer, (steps + 1, 1)),
                start=START,
                params=params,
            )
        )
    np.testing.assert_allclose(results[0].pose[-1], results[1].pose[-1], atol=1e-12)
    np.testing.assert_allclose(results[0].covariance[-1], results[1].covariance[-1], rtol=3e-3, atol=1e-9)


@pytest.mark.parametrize("name", ["hybrid3", "mecanum4", "mixed"])
def test_the_covariance_is_that_of_many_noisy_runs(name: str) -> None:
    """Against simulation: 4000 noisy copies of one way."""
    chassis, rng, runs, steps = chassis_of(name), np.random.default_rng(5), 4000, 40
    noise = 0.02
    increments, steers = [], []
    for k in range(steps):
        turns, steer = wheels_for(chassis, np.array([0.3, 0.1 * math.sin(k / 5), 0.8]), 0.1)
        increments.append(turns)
        steers.append(steer)
    clean = np.cumsum([np.zeros(len(increments[0])), *increments], axis=0)
    steer_samples = np.array([steers[0], *steers])
    time = 0.1 * np.arange(steps + 1)
    params = WheelOdometry(wheel_noise=noise, side_noise=0.0, jump_factor=1e9, steer_at=1.0)
    reference = track(chassis, time, clean, steer=steer_samples, start=START, params=params)
    ends = np.empty((runs, 3))
    for r in range(runs):
        errors = rng.normal(size=(steps, clean.shape[1])) * noise * np.sqrt(np.abs(increments))
        noisy = clean + np.cumsum(np.vstack([np.zeros(clean.shape[1]), errors]), axis=0)
        ends[r] = track(chassis, time, noisy, steer=steer_samples, start=START, params=params).pose[-1]
    expected, found = reference.covariance[-1], np.cov(ends.T)
    scale = np.sqrt(np.outer(np.diag(expected), np.diag(expected)))
    np.testing.assert_allclose(found / scale, expected / scale, atol=0.08)


def test_the_covariance_growth_uses_the_exact_derivatives_of_the_step() -> None:
    """One big turning step, against finite differences of exp and compose."""
    chassis = chassis_of("hybrid3")
    twist = np.array([0.5, -0.4, 1.9])
    turns, _ = wheels_for(chassis, twist, 1.0)
    params = WheelOdometry(wheel_noise=0.03, jump_factor=1e9)
    odometry = Odometry(chassis, params, START)
    odometry.update(0 * turns, stamp=0.0)
    found = odometry.update(turns, stamp=1.0).covariance
    h, columns = 1e-6, []
    for i in range(len(turns)):
        step = np.zeros(len(turns))
        step[i] = h
        ends = [geometry.compose(START, geometry.exp(chassis.forward(turns + s * step))) for s in (-1.0, 1.0)]
        columns.append((ends[1] - ends[0]) / (2 * h) * 0.03 * math.sqrt(abs(turns[i])))
    np.testing.assert_allclose(found, np.array(columns).T @ np.array(columns), rtol=1e-7, atol=1e-12)
    # and the second step carries the first one's covariance along
    before = found.copy()
    after = odometry.update(turns, stamp=2.0).covariance
    assert np.array_equal(before, after)  # nothing moved
    moved = odometry.update(turns + wheels_for(chassis, np.array([1.0, 0.0, 0.0]), 1.0)[0], stamp=3.0)
    x, y = moved.pose.x - odometry_pose(turns, chassis)[0], moved.pose.y - odometry_pose(turns, chassis)[1]
    carry = np.array([[1.0, 0.0, -y], [0.0, 1.0, x], [0.0, 0.0, 1.0]])
    grown = moved.covariance - carry @ before @ carry.T
    assert np.linalg.eigvalsh(grown).min() > -1e-12


def odometry_pose(turns: Array, chassis: Chassis) -> Array:
    return geometry.compose(START, geometry.exp(chassis.forward(turns)))


@given(x=st.floats(-5, 5), y=st.floats(-5, 5), theta=st.floats(-4, 4))
def test_another_frame_moves_pose_and_covariance_with_it(x: float, y: float, theta: float) -> None:
    chassis, rng = chassis_of("omni4"), np.random.default_rng(2)
    time, position = 0.1 * np.arange(20), np.cumsum(rng.normal(size=(20, 4)), axis=0)
    params = FAST
    here = track(chassis, time, position, params=params)
    there = track(chassis, time, position, params=params, start=Pose(x, y, theta))
    np.testing.assert_allclose(there.pose, geometry.compose([x, y, theta], here.pose), atol=1e-9)
    c, s = math.cos(theta), math.sin(theta)
    turn = np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
    np.testing.assert_allclose(there.covariance, turn @ here.covariance @ turn.T, atol=1e-9)


def test_the_heading_counts_turns() -> None:
    chassis = chassis_of("mecanum4")
    turns, _ = wheels_for(chassis, np.array([0.0, 0.0, 1.0]), 1.0)
    result = track(chassis, np.arange(31.0), np.outer(np.arange(31.0), turns), params=FAST)
    assert result.pose[-1, 2] == pytest.approx(30.0)


def test_wheels_that_contradict_each_other_show_as_slip() -> None:
    """A Mecanum base lifted at one corner; three omni wheels cannot contradict each other."""
    chassis = chassis_of("mecanum4")
    one = track(chassis, [0.0, 0.1], [[0, 0, 0, 0], [0.1, 0, 0, 0]])
    # of one unit of rim on one of four wheels a quarter is the contradiction, evenly spread
    radius = chassis.wheels[0].radius
    assert one.slip[-1] == pytest.approx(0.25 * 0.1 * radius / 0.1)
    rng = np.random.default_rng(0)
    omni = track(chassis_of("omni3"), 0.1 * np.arange(9), 0.3 * rng.normal(size=(9, 3)))
    assert (omni.slip == 0.0).all()


def test_turning_modules_use_the_angle_in_the_middle_of_the_interval() -> None:
    """A quarter circle by steering in two samples: the middle angle gives the chord's direction, the last does not."""
    chassis = chassis_of("swerve4")
    steer = np.stack([np.zeros(4), np.full(4, math.pi / 2)])
    position = np.stack([np.zeros(4), np.full(4, 0.5)])
    way = 0.5 * chassis.wheels[0].radius
    middle = track(chassis, [0.0, 1.0], position, steer=steer)
    newest = track(chassis, [0.0, 1.0], position, steer=steer, params=WheelOdometry(steer_at=1.0))
    np.testing.assert_allclose(middle.pose[-1], [way * math.sqrt(0.5), way * math.sqrt(0.5), 0.0], atol=1e-12)
    np.testing.assert_allclose(newest.pose[-1], [0.0, way, 0.0], atol=1e-12)
    # a module that turns through the wrap of its angle turns the short way
    wrapping = track(chassis, [0.0, 1.0], position, steer=np.stack([np.full(4, 3.0), np.full(4, -3.0)]))
    assert wrapping.pose[-1, 0] == pytest.approx(-way)


# --- gyro -----------------------------------------------------------------------------------------


def test_a_trusted_gyro_replaces_the_turn_before_the_step() -> None:
    chassis = chassis_of("mecanum4")
    turns, _ = wheels_for(chassis, np.array([1.0, 0.5, 0.2]), 0.1)
    odometry = Odometry(chassis, WheelOdometry(gyro_weight=1.0, jump_factor=1e9), START)
    odometry.update(0 * turns, heading=3.0, stamp=0.0)
    pose = odometry.update(turns, heading=-3.0, stamp=0.1).pose  # the heading passed pi
    turn = 2 * math.pi - 6.0
    np.testing.assert_allclose(pose, geometry.compose(START, geometry.exp([0.1, 0.05, turn])), atol=1e-12)


def test_a_rate_gyro_is_integrated_by_its_mean_over_the_interval() -> None:
    chassis = chassis_of("mecanum4")
    odometry = Odometry(chassis, WheelOdometry(gyro_weight=1.0))
    odometry.update(np.zeros(4), gyro=1.0, stamp=0.0)
    assert odometry.update(np.zeros(4), gyro=2.0, stamp=0.1).pose.theta == pytest.approx(0.15)
    assert odometry.update(np.zeros(4), stamp=0.2).pose.theta == pytest.approx(0.15)  # no gyro: by the wheels


def test_a_robot_at_rest_does_not_turn_with_the_bias_of_its_gyro() -> None:
    chassis = chassis_of("hybrid3")
    still = track(chassis, np.arange(100.0), np.zeros((100, 3)), gyro=np.full(100, 0.01))
    assert (still.pose == 0.0).all()


def test_weighing_by_variances_makes_the_turn_surer_than_either_alone() -> None:
    chassis = chassis_of("hybrid3")
    turns, _ = wheels_for(chassis, np.array([0.0, 0.0, 1.0]), 0.1)
    time, position = 0.1 * np.arange(50), np.outer(np.arange(50.0), turns)
    variances = {}
    for weight in (0.0, None, 1.0):
        params = WheelOdometry(wheel_noise=0.01, gyro_noise=0.01, gyro_weight=weight, jump_factor=1e9)
        result = track(chassis, time, position, gyro=np.ones(50), params=params)
        variances[weight] = result.covariance[-1, 2, 2]
    assert variances[None] < min(variances[0.0], variances[1.0])
    assert variances[1.0] == pytest.approx(0.01**2 * 4.9)


@pytest.mark.parametrize("imu_hz", [20.0, 100.0, 400.0, 1000.0])
def test_the_gyros_noise_is_that_of_the_samples_that_control_sees(imu_hz: float) -> None:
    """The variance it claims is the one of integrated samples, for an IMU slower and faster than control (100 Hz)."""
    robot = replace(
        robots.load("hybrid3"), imu=Imu("imu", rate_hz=imu_hz, gyro_noise_rad_s=0.02), control_period_s=0.01
    )
    rng = np.random.default_rng(8)
    # control sees the newest sample; a slow IMU's stays for several ticks
    ticks = np.arange(101)
    newest = np.floor(ticks * 0.01 * imu_hz + 1e-9).astype(int)
    params = WheelOdometry(gyro_weight=1.0)
    headings = []
    for _ in range(400):
        gyro = rng.normal(0.0, 0.02, newest[-1] + 1)[newest]
        result = track(robot, 0.01 * ticks, np.zeros((101, 3)), gyro=gyro, params=params)
        headings.append(result.pose[-1, 2])
    claimed = math.sqrt(result.covariance[-1, 2, 2])
    assert np.std(headings) == pytest.approx(claimed, rel=0.12)


# --- bad samples ------------------------------------------------------------------------------------


def line(count: int = 6) -> tuple[Array, Array]:
    """`hybrid3` moving evenly: times and wheel angles."""
    chassis = chassis_of("hybrid3")
    turns, _ = wheels_for(chassis, np.array([0.1, 0.05, 0.1]), 0.1)
    return 0.1 * np.arange(count), np.outer(np.arange(count), turns)


def end(time: Array, position: Array) -> tuple[Array, Counts]:
    result = track(chassis_of("hybrid3"), time, position)
    return result.pose[-1], result.counts


def test_a_duplicate_changes_nothing_and_is_counted() -> None:
    time, position = line()
    clean, counts = end(time, position)
    assert counts == Counts(used=5)
    again, counts = end(np.insert(time, 3, time[3] + 1e-7), np.insert(position, 3, position[3], axis=0))
    np.testing.assert_allclose(again, clean, atol=1e-15)
    assert counts == Counts(used=5, duplicates=1)


def test_equal_stamps_do_not_lose_motion() -> None:
    """Five samples in bursts of one stamp: the way of the burst counts with the next stamp."""
    time, position = line(11)
    clean, _ = end(time, position)
    bursts, counts = end(np.array([0.0, 0.1, 0.1, 0.1, 0.4, 0.4, 0.4, 0.7, 0.7, 0.9, 1.0]), position)
    np.testing.assert_allclose(bursts, clean, atol=1e-12)
    assert counts == Counts(used=5, duplicates=5)


@pytest.mark.parametrize("stamp", [-0.05, math.nan, math.inf])
def test_a_bad_stamp_changes_nothing_and_is_counted(stamp: float) -> None:
    time, position = line()
    clean, _ = end(time, position)
    late, counts = end(np.insert(time, 3, stamp), np.insert(position, 3, position[1], axis=0))
    np.testing.assert_allclose(late, clean, atol=1e-15)
    assert counts == Counts(used=5, bad_stamps=1)


@pytest.mark.parametrize("value", [math.nan, math.inf])
def test_a_wheel_without_a_number_is_counted_and_its_way_is_not_lost(value: float) -> None:
    time, position = line()
    clean, _ = end(time, position)
    position[2, 1] = value
    holed, counts = end(time, position)
    np.testing.assert_allclose(holed, clean, atol=1e-12)
    assert counts == Counts(used=4, bad_values=1)


def test_one_wild_reading_is_left_out_and_its_way_is_not_lost() -> None:
    time, position = line()
    clean, _ = end(time, position)
    position[2, 0] += 1e4
    holed, counts = end(time, position)
    np.testing.assert_allclose(holed, clean, atol=1e-12)
    assert counts == Counts(used=4, jumps=1)


def test_counters_that_start_anew_cost_one_interval() -> None:
    time, position = line(20)
    position[10:] -= 500.0
    restarted, counts = end(time, position)
    assert counts == Counts(used=18, jumps=1)
    shorter, _ = end(*line(19))
    np.testing.assert_allclose(restarted, shorter, atol=1e-12)


def test_a_clock_that_starts_anew_is_followed() -> None:
    time, position = line(20)
    time = time + 100.0
    time[10:] -= 90.0
    _, counts = end(time, position)
    assert counts == Counts(used=18, bad_stamps=1)


def test_no_sample_ever_makes_the_pose_nan() -> None:
    """5000 random samples of all kinds of nonsense."""
    rng = np.random.default_rng(8)
    odometry = Odometry(mixed())
    odd = np.array([0.0, -0.0, 1e-300, 1e300, -1e308, math.inf, -math.inf, math.nan, 1.0, math.pi])
    for _ in range(5000):
        values = np.where(rng.random(8) < 0.2, rng.choice(odd, 8), rng.normal(size=8))
        heading = float(rng.choice(odd)) if rng.random() < 0.2 else None
        estimate = odometry.update(values[:4], heading, stamp=float(values[4]), steer=values[5:7], gyro=values[7])
        assert np.isfinite(estimate.pose).all()
        assert np.isfinite(estimate.covariance).all()
    counts = odometry.counts
    assert counts.used > 0
    assert counts.refused > 0


# --- parameters -------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("name", "value"),
    [("wheel_noise", -1.0), ("side_noise", math.nan), ("gyro_weight", 1.5), ("steer_at", 2.0), ("jump_factor", 0.0)],
)
def test_a_parameter_that_cannot_be_is_refused_by_name(name: str, value: float) -> None:
    with pytest.raises(InputError, match=name):
        WheelOdometry(**{name: value})


def test_noise_is_one_for_all_or_one_for_each_wheel() -> None:
    chassis = chassis_of("hybrid3")
    with pytest.raises(InputError, match="2 values, the robot 3 wheels"):
        Odometry(chassis, WheelOdometry(wheel_noise=(0.1, 0.1)))
    params = WheelOdometry(wheel_noise=(0.1, 0.0, 0.0))
    moved = track(chassis, [0.0, 1.0], [[0, 0, 0], [0, 1.0, 1.0]], params=params)
    assert (moved.covariance == 0.0).all()


def test_another_number_of_wheels_is_refused_in_one_line() -> None:
    with pytest.raises(InputError, match="odometry of 3 wheels, 0 steered"):
        Odometry(chassis_of("hybrid3")).update(np.zeros(4), stamp=0.0)
    with pytest.raises(InputError, match="expected"):
        track(chassis_of("hybrid3"), [0.0, 1.0], np.zeros((2, 4)))


def test_a_wheel_state_says_all_at_once() -> None:
    odometry = Odometry(chassis_of("swerve3"))
    state = WheelState(np.zeros(3), np.zeros(3), np.zeros(3))
    assert odometry.update(state, stamp=0.0).pose == Pose(0.0, 0.0, 0.0)
