"""Encoders and mice lose nothing; the gyro's noise and bias are what its file says."""

import math
from dataclasses import replace

import numpy as np
import pytest
from machines import FREE_SPEED, hybrid, swerve, with_motor

from holodrive import geometry
from holodrive.robots.spec import Imu, Mouse
from holodrive.sim import SimBase
from holodrive.sim import state as st
from holodrive.types import DutyCommand, Pose, WheelCommand

MICE = (Mouse("a", Pose(0.05, 0.1, 0.3)), Mouse("b", Pose(-0.2, 0.0, -1.0), resolution_m=1e-4))


def test_encoder_counts_are_the_wheels_angle_to_one_count():
    base = SimBase(hybrid(), None)
    rng = np.random.default_rng(0)
    for _ in range(200):
        base.apply(DutyCommand(rng.uniform(-1.0, 1.0, 3)))
        position = base.observe().wheels.position
        angle = base._state[st.WHEEL_ANGLE : st.WHEEL_ANGLE + 3]
        behind = (angle - position) / (2.0 * math.pi / 1600.0)
        assert np.all((behind > -1e-6) & (behind < 1.0 + 1e-6))
        assert np.allclose(position * 1600.0 / (2.0 * math.pi), np.round(position * 1600.0 / (2.0 * math.pi)))


def test_encoder_speed_comes_to_the_wheels_speed():
    base = SimBase(hybrid(), None)
    told = []
    for k in range(300):
        base.apply(DutyCommand((0.5, 0.5, -0.5)))
        if k > 100:
            told.append(base.observe().wheels.speed)
    assert np.allclose(np.mean(told, axis=0), np.array([0.5, 0.5, -0.5]) * FREE_SPEED, rtol=0.01)


def test_a_wheel_without_encoder_tells_nan_and_still_follows_by_feed_forward():
    robot = hybrid()
    robot = replace(robot, wheels=tuple(replace(w, encoder=None) for w in robot.wheels))
    base = SimBase(robot, None)
    assert np.isnan(base.observe().wheels.speed).all()
    for _ in range(100):
        base.apply(WheelCommand((0.5, 1.0, -1.5)))
    wheels = base.observe().wheels
    assert np.isnan(wheels.position).all()
    assert np.isnan(wheels.speed).all()
    assert np.allclose(base.true_wheel_speeds, (0.5, 1.0, -1.5), rtol=1e-6)


def test_the_speed_loop_brings_loaded_wheels_to_their_command():
    base = SimBase(hybrid(), None, plant="slip")
    speeds = []
    for _ in range(500):
        base.apply(WheelCommand((0.5, 1.2, -0.8)))
        speeds.append(base.true_wheel_speeds)
    assert np.allclose(np.mean(speeds[200:], axis=0), (0.5, 1.2, -0.8), rtol=0.01)


@pytest.mark.parametrize("plant", ["first_order", "slip"])
def test_mouse_counts_add_up_to_the_way_of_the_mouse(plant):
    """In the mouse's axes the way is the integral of the body's twist carried to the mouse: nothing is lost."""
    base = SimBase(hybrid(mice=MICE), None, plant=plant, dt_s=1e-4)
    told, pose, way = np.zeros((2, 2)), np.array(base.truth), np.zeros((2, 2))
    for k in range(150):
        base.apply(DutyCommand((0.2, 0.9 * math.sin(0.05 * k), -0.5)))
        told += base.observe().mice
        new = np.array(base.truth)
        step = geometry.log(geometry.between(pose, new))
        for i, mouse in enumerate(MICE):
            local = np.array([step[0] - step[2] * mouse.mount.y, step[1] + step[2] * mouse.mount.x])
            c, s = math.cos(mouse.mount.theta), math.sin(mouse.mount.theta)
            way[i] += c * local[0] + s * local[1], c * local[1] - s * local[0]
        pose = new
    assert np.all(np.abs(told - way) < [[1.5e-5], [1.1e-4]])
    assert np.allclose(told[1] / 1e-4, np.round(told[1] / 1e-4))


def test_a_measuring_wheel_tells_what_the_x_axis_of_a_mouse_tells_and_nothing_across():
    wheels = tuple(replace(mouse, axes="x") for mouse in MICE)
    bases = [SimBase(hybrid(mice=mice), None) for mice in (MICE, wheels)]
    for _ in range(20):
        both, along = (base.observe().mice for base in bases)
        np.testing.assert_array_equal(along[:, 0], both[:, 0])
        assert np.isnan(along[:, 1]).all()
        for base in bases:
            base.apply(DutyCommand((0.2, 0.9, -0.5)))


def imu(**changes):
    return replace(Imu("imu", rate_hz=100.0), **changes)


def test_gyro_tells_the_yaw_rate_and_accelerometer_the_centripetal_force():
    robot = with_motor(hybrid(imu=imu(mount=Pose(0.1, 0.0, 0.0))), lag_s=0.0)
    base = SimBase(robot, None)
    for _ in range(50):
        base.apply(DutyCommand((0.8, 0.8, 0.8)))
    twist, seen = base.true_twist, base.observe()
    assert seen.gyro == pytest.approx(twist.omega, rel=1e-12)
    ahead, left = -twist.omega * twist.vy - 0.1 * twist.omega**2, twist.omega * twist.vx
    assert np.allclose(seen.accel, (ahead, left), atol=1e-12)


def test_gyro_noise_bias_and_walk_have_the_size_of_the_file():
    robot = hybrid(imu=imu(gyro_noise_rad_s=0.02, gyro_bias_rad_s=0.1, gyro_bias_walk_rad_s=0.0))
    base = SimBase(robot, None, seed=5)
    told = []
    for _ in range(4000):
        base.apply(DutyCommand((0.0, 0.0, 0.0)))
        told.append(base.observe().gyro)
    assert np.mean(told) == pytest.approx(0.1, abs=4 * 0.02 / math.sqrt(4000))
    assert np.std(told) == pytest.approx(0.02, rel=0.05)
    ends = []
    for seed in range(150):
        base = SimBase(hybrid(imu=imu(gyro_bias_walk_rad_s=0.03)), None, seed=seed)
        for _ in range(100):
            base.apply(DutyCommand((0.0, 0.0, 0.0)))
        ends.append(base.observe().gyro)
    assert np.std(ends) == pytest.approx(0.03, rel=0.2)


def test_a_slow_imu_holds_its_sample():
    base = SimBase(hybrid(imu=imu(rate_hz=20.0, gyro_noise_rad_s=0.01)), None)
    told = []
    for _ in range(50):
        base.apply(DutyCommand((0.0, 0.0, 0.0)))
        told.append(base.observe().gyro)
    assert len(set(told)) == 11


def test_what_a_robot_has_no_sensor_for_is_none():
    seen = SimBase(swerve(), None).observe()
    assert (seen.gyro, seen.accel, seen.mice, seen.scan) == (None, None, None, None)
    assert seen.wheels.steer.shape == (3,)
