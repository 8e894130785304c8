"""Claims about the Kalman filter: laws first, then agreement with a dense filter, then whether it knows its error."""

import math
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from holodrive import estimation, geometry, layout, robots
from holodrive.errors import InputError
from holodrive.estimation import consistency, ekf_track
from holodrive.estimation import ekf_rows as rw
from holodrive.estimation import ekf_state as es
from holodrive.estimation.ekf import Ekf
from holodrive.kinematics import Chassis
from holodrive.robots.spec import Encoder, Imu, Mouse, Robot, Steering
from holodrive.types import Array, Pose

START = Pose(1.0, -2.0, 2.5)
DT = 0.01
FAST = Ekf(jump_factor=100.0)  # wheels may turn faster than the robot's can
EXACT = Ekf(
    jump_factor=100.0,
    wheel_noise=0.0,
    side_noise=0.0,
    way_noise=0.0,
    gyro_timing=0.0,
    steer_timing=0.0,
    gyro_bias_rad_s=0.0,
)
WHEELS = (
    Mouse("ahead", Pose(0.0, 0.1, 0.2), 4e-5, 0.005, axes="x"),
    Mouse("across", Pose(-0.1, 0.05, 1.8), 4e-5, 0.005, axes="x"),
)
IMU = Imu("imu", gyro_noise_rad_s=1e-3, gyro_bias_rad_s=3e-3, gyro_bias_walk_rad_s=1e-4)


def equipped(name: str, counts: float = 36864.0) -> Robot:
    """A robot of the catalog with encoders, a gyro and two measuring wheels, and a period of `DT`."""
    robot = robots.load(name)
    wheels = tuple(replace(wheel, encoder=Encoder(counts)) for wheel in robot.wheels)
    return replace(robot, wheels=wheels, imu=IMU, mice=WHEELS, control_period_s=DT, lidar=None)


def silent(robot: Robot) -> Robot:
    """The same with perfect sensors."""
    mice = tuple(replace(mouse, resolution_m=1e-12, noise_relative=0.0) for mouse in robot.mice)
    return replace(robot, mice=mice, imu=Imu("imu"))


def readings(robot: Robot, twists: Array) -> Array:
    """(T + 1, ...) what perfect sensors tell of mean twists (T, 3), modules pointing along each; the first at rest."""
    chassis, t = Chassis.of(robot), len(twists)
    rows = np.zeros((t + 1, layout.OBS_HEADER))
    command = chassis.inverse(twists)
    steer = np.vstack([command.steer[:1], command.steer])
    rows[:, layout.TIME], rows[:, layout.DT] = np.arange(t + 1) * DT, DT
    n, m = len(robot.wheels), len(robot.steered)
    rows[1:, layout.WHEEL_POSITION : layout.WHEEL_POSITION + n] = np.cumsum(command.speeds, axis=0) * DT
    rows[:, layout.STEER : layout.STEER + m] = steer
    rows[1:, layout.GYRO] = twists[:, 2]
    rows[0, layout.GYRO] = twists[0, 2]
    rows[:, layout.N_MICE] = len(robot.mice)
    for k, mouse in enumerate(robot.mice):
        c, s = math.cos(mouse.mount.theta), math.sin(mouse.mount.theta)
        x, y = twists[:, 0] - twists[:, 2] * mouse.mount.y, twists[:, 1] + twists[:, 2] * mouse.mount.x
        rows[1:, layout.MICE + 2 * k] = (c * x + s * y) * DT
        rows[:, layout.MICE + 2 * k + 1] = math.nan if mouse.axes == "x" else 0.0
    return rows


def integrated(twists: Array, start: Pose = START) -> Array:
    poses = [np.array(start)]
    for twist in twists:
        poses.append(geometry.compose(poses[-1], geometry.exp(twist * DT)))
    return np.array(poses)


def steady(count: int, twist: tuple[float, float, float] = (0.4, -0.3, 0.8)) -> Array:
    return np.tile(twist, (count, 1))


@pytest.mark.parametrize("name", ["omni4", "mecanum4", "hybrid3", "swerve3"])
def test_without_noise_it_is_exact(name: str) -> None:
    robot = silent(equipped(name, counts=1e13))
    twist = 0.2 * np.array([0.4, -0.3, 0.8]) if name == "hybrid3" else np.array([0.4, -0.3, 0.8])
    twists = np.tile(twist, (200, 1))
    found = ekf_track.track(robot, readings(robot, twists), EXACT, START)
    np.testing.assert_allclose(found.pose, integrated(twists), atol=1e-8)
    assert found.refused == 0
    assert found.slip.max() < 1e-8


def test_a_trailing_and_coupled_module_is_read_as_the_kinematics_says() -> None:
    """Wheels and steering made by the chassis' own forward map, while the modules turn."""
    base = silent(equipped("swerve3", counts=1e13))
    wheels = tuple(replace(w, steering=Steering(caster_m=0.03, coupling=0.2)) for w in base.wheels)
    robot = replace(base, wheels=wheels, imu=None, mice=())
    chassis, twist = Chassis.of(robot), np.array([0.4, 0.2, 0.3])
    rows, start = readings(robot, steady(1)), np.zeros(3)
    steer, rates = np.array([0.3, -0.4, 0.1]), np.zeros(3)
    # with the axes' velocities v: w = e.v / r, d' = n.v / c - omega; then nothing slips
    for i, wheel in enumerate(robot.wheels):
        v = twist[:2] + twist[2] * np.array([-wheel.y, wheel.x])
        c, s = math.cos(steer[i]), math.sin(steer[i])
        rates[i] = (c * v[1] - s * v[0]) / 0.03 - twist[2]
        drive = (c * v[0] + s * v[1]) / wheel.radius + 0.2 * rates[i]
        rows[1, layout.WHEEL_POSITION + i] = drive * DT
    rows[0, layout.STEER : layout.STEER + 3] = steer - 0.5 * rates * DT
    rows[1, layout.STEER : layout.STEER + 3] = steer + 0.5 * rates * DT
    speeds = rows[1, layout.WHEEL_POSITION : layout.WHEEL_POSITION + 3] / DT - 0.2 * rates
    np.testing.assert_allclose(chassis.forward(speeds, steer, rates), twist, atol=1e-9)
    found = ekf_track.track(robot, rows, EXACT, start)
    np.testing.assert_allclose(found.twist[-1], twist, atol=1e-5)


@pytest.mark.parametrize("name", ["omni4", "swerve3"])
@settings(max_examples=25)
@given(seed=st.integers(0, 10**6), size=st.sampled_from([1e-6, 1e-3, 0.1, 10.0]), lost=st.floats(0.0, 0.5))
def test_the_covariance_stays_symmetric_and_positive_whatever_sensors_say(
    name: str, seed: int, size: float, lost: float
) -> None:
    robot, rng = equipped(name), np.random.default_rng(seed)
    rows = readings(robot, steady(60))
    used = np.r_[
        layout.GYRO, layout.WHEEL_POSITION + np.arange(4), layout.STEER + np.arange(3), layout.MICE + np.arange(4)
    ]
    rows[:, used] += size * rng.normal(size=(61, len(used)))
    rows[:, used] = np.where(rng.uniform(size=(61, len(used))) < lost, math.nan, rows[:, used])
    found = ekf_track.track(robot, rows, start=START)
    np.testing.assert_array_equal(found.covariance, np.swapaxes(found.covariance, 1, 2))
    assert np.isfinite(found.pose).all()
    values = np.linalg.eigvalsh(found.covariance)
    assert np.all(values >= -1e-12 * np.maximum(values[:, -1:], 1e-6))


@given(x=st.floats(-50, 50), y=st.floats(-50, 50), turn=st.floats(-7, 7))
@settings(max_examples=20)
def test_the_world_frame_does_not_matter(x: float, y: float, turn: float) -> None:
    robot, rng = equipped("swerve3"), np.random.default_rng(1)
    rows = readings(robot, steady(50) + 0.1 * rng.normal(size=(50, 3)))
    frame = np.array([x, y, turn])
    here = ekf_track.track(robot, rows, start=START)
    there = ekf_track.track(robot, rows, start=geometry.compose(frame, np.array(START)))
    np.testing.assert_allclose(there.pose, geometry.compose(frame, here.pose), atol=1e-9)
    c, s = math.cos(turn), math.sin(turn)
    r = np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
    np.testing.assert_allclose(there.covariance, r @ here.covariance @ r.T, atol=1e-12)
    np.testing.assert_allclose(there.twist, here.twist, atol=1e-12)


def dense(robot: Robot, params: Ekf, rows: Array, start: Pose) -> tuple[Array, Array]:
    """A textbook filter with whole matrices: pose, twist, bias, then u or n of each row, now and before."""
    table, dt = params.rows(robot), DT
    k, t = len(table), params.pack(robot)
    size = 7 + 2 * k
    x, p = np.zeros(size), np.zeros((size, size))
    x[:3] = start
    p[[3, 4, 5], [3, 4, 5]] = np.square([t[es.STRAY], t[es.STRAY], t[es.YAW_STRAY]])
    p[6, 6] = t[es.BIAS] ** 2
    own = np.where(table[:, rw.KIND] == rw.GYRO, 1.0, 1.0 / 12.0) * table[:, rw.QUANTUM] ** 2
    p[range(7, 7 + k), range(7, 7 + k)] = own
    wander = np.diag([0, 0, 0, t[es.SURGE] * dt, t[es.SURGE] * dt, t[es.YAW_SURGE] * dt, t[es.BIAS_WALK] * dt])
    for before, now in pairwise(rows):
        p[:7, :7] += wander
        z, h, ways = model(table, before, now)
        first, spread = solved(x, p, z, h, np.abs(ways) + table[:, rw.QUANTUM], table, own, 7, k)
        way = np.sqrt([way_square(row, first, spread) for row in table]) * dt
        x, p = solved(x, p, z, h, way, table, own, 7, k)
        # the pose moves; derivatives by differences, not by the filter's formulas
        f = np.eye(size)
        for j in range(6):
            d = np.zeros(size)
            d[j] = 1e-6
            f[:3, j] = (moved(x + d) - moved(x - d)) / 2e-6
        x[:3], p = moved(x), f @ p @ f.T
    return x, p


def moved(x: Array) -> Array:
    return geometry.compose(x[:3], geometry.exp(x[3:6] * DT))


def way_square(row: Array, x: Array, p: Array) -> float:
    sides = [row[rw.H : rw.H + 3]] + ([row[rw.H_SIDE : rw.H_SIDE + 3]] if row[rw.KIND] >= rw.ALONG else [])
    return float(sum((h @ x[3:6]) ** 2 + h @ p[3:6, 3:6] @ h for h in sides))


def model(table: Array, before: Array, now: Array) -> tuple[Array, Array, Array]:
    """z (k,), rows over the mean twist (k, 3), and what each tells of its way (k,)."""
    z, h, way = np.zeros(len(table)), np.zeros((len(table), 3)), np.zeros(len(table))
    for i, row in enumerate(table):
        at = int(row[rw.INDEX])
        if row[rw.KIND] == rw.GYRO:
            z[i], h[i] = 0.5 * (before[layout.GYRO] + now[layout.GYRO]), [0, 0, 1]
        elif row[rw.KIND] == rw.MOUSE:
            z[i], h[i] = now[layout.MICE + at], row[rw.H : rw.H + 3] * DT
            way[i] = z[i]
        else:
            way[i] = row[rw.UNIT] * (now - before)[layout.WHEEL_POSITION + at]
            z[i], h[i] = way[i], row[rw.H : rw.H + 3] * DT
            if row[rw.KIND] >= rw.ALONG:
                j = layout.STEER + int(row[rw.STEER])
                angle = 0.5 * (before[j] + now[j]) + (0.5 * math.pi if row[rw.KIND] == rw.ACROSS else 0.0)
                h[i] = math.cos(angle) * h[i] + math.sin(angle) * row[rw.H_SIDE : rw.H_SIDE + 3] * DT
                z[i] = z[i] if row[rw.KIND] == rw.ALONG else 0.0
    return z, h, way


def solved(
    x: Array, p: Array, z: Array, h: Array, way: Array, table: Array, own: Array, at: int, k: int
) -> tuple[Array, Array]:
    """One batch update: u and n of now are made from those of before, all rows at once."""
    gyro, across = table[:, rw.KIND] == rw.GYRO, table[:, rw.KIND] == rw.ACROSS
    keep = np.where(gyro | across, 0.0, np.exp(-6.0 * way / np.maximum(table[:, rw.QUANTUM], 1e-30)))
    f = np.eye(len(x))
    f[at + k :, at + k :] = 0.0
    f[at + k :, at : at + k] = np.diag(keep)
    x, p = f @ x, f @ p @ f.T
    p[range(at + k, at + 2 * k), range(at + k, at + 2 * k)] += own * (1.0 - keep**2)
    big = np.zeros((k, len(x)))
    big[:, 3:6], big[:, 6] = h, gyro
    now, before = np.where(gyro, 0.5, 1.0) * ~across, np.where(gyro, 0.5, -1.0) * ~across
    big[range(k), range(at + k, at + 2 * k)], big[range(k), range(at, at + k)] = now, before
    noise = 1e-16 + ~gyro * (table[:, rw.RELATIVE] * way**2 + table[:, rw.WALK] * way)
    s = big @ p @ big.T + np.diag(noise)
    gain = np.linalg.solve(s, big @ p).T
    x, left = x + gain @ (z - big @ x), np.eye(len(x)) - gain @ big
    p = left @ p @ left.T + gain @ np.diag(noise) @ gain.T
    # what is untold now is what was untold before at the next tick
    swap = np.eye(len(x))
    swap[at : at + k, at : at + k], swap[at : at + k, at + k :] = 0.0, np.eye(k)
    swap[at + k :, at + k :] = 0.0
    return swap @ x, swap @ p @ swap.T


@pytest.mark.parametrize("name", ["omni4", "swerve3"])
def test_it_agrees_with_a_dense_filter_of_the_textbook(name: str) -> None:
    robot, rng = equipped(name), np.random.default_rng(3)
    params = Ekf(steer_timing=0.0, gyro_timing=0.0, gate=1e6, jump_factor=1e6, wheel_noise=0.03, side_noise=0.03)
    twists = steady(40) + 0.05 * rng.normal(size=(40, 3))
    rows = readings(robot, twists)
    rows[:, layout.GYRO] += 1e-3 * rng.normal(size=41)
    rows[:, layout.WHEEL_POSITION : layout.WHEEL_POSITION + 4] += 1e-4 * rng.normal(size=(41, 4))
    rows[:, layout.STEER : layout.STEER + 3] = rows[0, layout.STEER : layout.STEER + 3]
    found = ekf_track.track(robot, rows, params, START)
    x, p = dense(robot, params, rows, START)
    np.testing.assert_allclose(found.pose[-1], x[:3], atol=1e-8)
    np.testing.assert_allclose(found.twist[-1], x[3:6], atol=1e-6)
    np.testing.assert_allclose(found.bias[-1], x[6], atol=1e-8)
    size = np.sqrt(np.diag(p)[:3])
    np.testing.assert_allclose(found.covariance[-1] / np.outer(size, size), p[:3, :3] / np.outer(size, size), atol=1e-4)


def test_a_robot_that_stands_finds_the_bias_of_its_gyro() -> None:
    robot, rng = replace(equipped("omni4"), mice=()), np.random.default_rng(2)
    rows = readings(robot, steady(500, (0.0, 0.0, 0.0)))
    rows[:, layout.GYRO] = 0.004 + 1e-3 * rng.normal(size=501)
    found = ekf_track.track(robot, rows)
    assert found.bias[-1] == pytest.approx(0.004, abs=4 * found.bias_deviation[-1])
    assert found.bias_deviation[-1] < 3e-4
    assert np.abs(found.pose[-1]).max() < 1e-4


def test_one_wrong_reading_is_refused_and_told() -> None:
    robot, twists = equipped("omni4"), steady(100)
    rows = readings(robot, twists)
    clean = ekf_track.track(robot, rows, FAST, START)
    rows[60, layout.MICE] += 0.02  # a measuring wheel that jumps by 2 cm
    found = ekf_track.track(robot, rows, FAST, START)
    assert (clean.refused, found.refused) == (0, 1)
    assert [int(bits) for bits in found.suspect[[59, 60, 61]]] == [0, 1, 0]
    assert np.abs(found.pose[-1] - clean.pose[-1]).max() < 1e-4


def test_one_module_that_is_wrong_while_none_turns_is_refused() -> None:
    robot = equipped("swerve3")
    rows = readings(robot, steady(100))
    clean = ekf_track.track(robot, rows, start=START)
    rows[60:, layout.WHEEL_POSITION] += 0.5
    found = ekf_track.track(robot, rows, start=START)
    assert (clean.refused, found.refused) == (0, 1)
    assert np.abs(found.pose[-1] - clean.pose[-1]).max() < 1e-4


def test_modules_that_contradict_each_other_as_they_turn_are_believed_together() -> None:
    """Three modules lag unequally, for many ticks the same way: none is refused, and the doubt grows as it must."""
    robot = replace(equipped("swerve3"), imu=None, mice=())
    way = 4.0 * np.sin(np.arange(400) * DT * 2.0)
    twists = np.stack([0.5 * np.cos(way), 0.5 * np.sin(way), np.zeros(400)], axis=1)
    rows, rate = readings(robot, twists), np.gradient(way, DT)
    rows[1:, layout.STEER : layout.STEER + 3] -= rate[:, None] * [0.0, 0.1, 0.2]
    found, truth = ekf_track.track(robot, rows, start=START), integrated(twists)
    assert (found.refused, found.hits) == (0, 0)
    assert np.abs(found.pose[-1] - truth[-1]).max() < 0.1
    assert consistency.nees(found.pose[100::100], found.covariance[100::100], truth[100::100]).max() < 7.8


def test_a_robot_that_is_stopped_by_a_wall_is_followed() -> None:
    """All sensors contradict the motion expected, so it is the motion that was wrong."""
    robot = equipped("swerve3")
    twists = np.vstack([steady(50, (1.5, 0.0, 0.0)), steady(50, (0.0, 0.0, 0.0))])
    found = ekf_track.track(robot, readings(robot, twists), start=START)
    assert found.hits == 1
    np.testing.assert_allclose(found.pose[-1], integrated(twists)[-1], atol=2e-4)
    assert np.abs(found.twist[-1]).max() < 0.01


@pytest.mark.parametrize("lost", ["wheels", "everything"])
def test_readings_that_are_missing_for_a_while_cost_little(lost: str) -> None:
    robot, twists = equipped("swerve3"), steady(100)
    rows = readings(robot, twists)
    rows[40:45, layout.WHEEL_POSITION : layout.WHEEL_POSITION + 3] = math.nan
    if lost == "everything":
        rows[40:45, layout.GYRO] = math.nan
        rows[40:45, layout.N_MICE] = 0.0
    found = ekf_track.track(robot, rows, start=START)
    np.testing.assert_allclose(found.pose[-1], integrated(twists)[-1], atol=2e-3)
    grown = found.covariance[:, 0, 0]
    assert grown[44] > grown[39]


def test_every_choice_of_sensors_works_and_more_of_them_know_more() -> None:
    robot, twists = equipped("swerve3"), steady(200)
    blind = tuple(replace(wheel, encoder=None) for wheel in robot.wheels)
    one = (replace(robot.wheels[0], encoder=None), *robot.wheels[1:])
    choices = {
        "all": robot,
        "wheels": replace(robot, imu=None, mice=()),
        "two wheels": replace(robot, wheels=one, imu=None, mice=()),
        "gyro and measuring wheels": replace(robot, wheels=blind),
    }
    rows, size = readings(robot, twists), {}
    for name, seen in choices.items():
        found = ekf_track.track(seen, rows, start=START)
        np.testing.assert_allclose(found.pose[-1], integrated(twists)[-1], atol=2e-3, err_msg=name)
        size[name] = np.trace(found.covariance[-1])
    assert size["all"] < size["wheels"] < size["two wheels"]
    assert size["all"] < size["gyro and measuring wheels"]


def test_a_robot_without_any_is_refused_in_one_line() -> None:
    robot = equipped("omni4")
    blind = replace(robot, wheels=tuple(replace(wheel, encoder=None) for wheel in robot.wheels), mice=())
    with pytest.raises(InputError, match="omni4 has no encoder, mouse or measuring wheel") as caught:
        estimation.plug("ekf").pack(blind)
    assert "\n" not in str(caught.value)


def test_numbers_that_cannot_be_are_refused_by_name() -> None:
    with pytest.raises(InputError, match=r"wheel_noise = -1.0 is not 0 or more"):
        Ekf(wheel_noise=-1.0)
    with pytest.raises(InputError, match=r"gate = nan is not above 0"):
        Ekf(gate=math.nan)


def drawn(robot: Robot, params: Ekf, seed: int, count: int) -> tuple[Array, Array]:
    """Readings and poses of a robot that is just as the filter believes: a twist that strays, noise and counts."""
    rng, packed = np.random.default_rng(seed), params.pack(robot)
    surge = np.sqrt(DT * np.array([packed[es.SURGE], packed[es.SURGE], packed[es.YAW_SURGE]]))
    twists = np.cumsum(surge * rng.normal(size=(count, 3)), axis=0)
    rows, table = readings(robot, twists), params.rows(robot)
    for row in table[table[:, rw.KIND] != rw.GYRO]:
        at = int(row[rw.INDEX]) + (layout.MICE if row[rw.KIND] == rw.MOUSE else layout.WHEEL_POSITION)
        way = DT * twists @ row[rw.H : rw.H + 3]
        way += np.sqrt(row[rw.RELATIVE] * way**2 + row[rw.WALK] * np.abs(way)) * rng.normal(size=count)
        told = np.floor(np.append(0.0, np.cumsum(way)) / row[rw.QUANTUM] + rng.uniform()) * row[rw.QUANTUM]
        if row[rw.KIND] == rw.MOUSE:
            rows[1:, at] = np.diff(told)
        else:
            rows[:, at] = told / row[rw.UNIT]
    imu = robot.imu or IMU
    bias = imu.gyro_bias_rad_s * rng.normal() + imu.gyro_bias_walk_rad_s * math.sqrt(DT) * np.cumsum(
        np.append(0.0, rng.normal(size=count))
    )
    noise = imu.gyro_noise_rad_s * rng.normal(size=count + 1)
    # samples whose means are the mean rates: n and n' enter half each, bias and rate whole
    rows[:, layout.GYRO] = bias + noise + alternating(twists[:, 2])
    return rows, integrated(twists)


def alternating(rates: Array) -> Array:
    """(T + 1,) samples of which each two neighbours have the mean (T,)."""
    samples = np.zeros(len(rates) + 1)
    for k, rate in enumerate(rates):
        samples[k + 1] = 2.0 * rate - samples[k]
    return samples


def test_the_error_is_as_large_as_the_covariance_says_and_innovations_too() -> None:
    """NEES of the pose over 100 runs inside its 95 % band, and innovations of unit variance to 2 %."""
    robot, runs = equipped("omni4", counts=4096.0), 100
    robot = replace(robot, mice=tuple(replace(mouse, resolution_m=1e-4) for mouse in robot.mice))
    params = Ekf(gyro_timing=0.0, accel_m_s2=1.0, yaw_accel_rad_s2=2.0, jump_factor=1e3)
    times, squares, innovations, rows_used = [50, 100, 150, 200], [], 0.0, 0.0
    for seed in range(runs):
        rows, truth = drawn(robot, params, seed, 200)
        found = ekf_track.track(robot, rows, params, truth[0])
        squares.append(consistency.nees(found.pose[times], found.covariance[times], truth[times]))
        innovations, rows_used = innovations + found.nis[5:].sum(), rows_used + found.nis_rows[5:].sum()
    low, high = consistency.band(3.0, runs)
    means = np.mean(squares, axis=0)
    assert low <= means.mean() <= high
    assert np.sum((low <= means) & (means <= high)) >= 3
    # counts are not Gaussian, so not within the band of as many Gaussian numbers
    assert innovations / rows_used == pytest.approx(1.0, abs=0.02)


def test_the_band_is_that_of_the_chi_square() -> None:
    low, high = consistency.band(3.0, 50)
    assert (round(low, 2), round(high, 2)) == (2.36, 3.72)  # Bar-Shalom et al., 5.4: 150 degrees of freedom over 50
    rng = np.random.default_rng(0)
    root = rng.normal(size=(3, 3))
    errors = rng.normal(size=(4000, 3)) @ root.T
    assert consistency.nees(errors, root @ root.T, np.zeros(3)).mean() == pytest.approx(3.0, abs=0.12)
    with pytest.raises(InputError, match="runs > 0"):
        consistency.band(3.0, 0)


def test_a_heading_error_counts_no_turns() -> None:
    assert consistency.nees([0.0, 0.0, 2.0 * math.pi], np.eye(3), [0.0, 0.0, 0.0]) == pytest.approx(0.0, abs=1e-20)
