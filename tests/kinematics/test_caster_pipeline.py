"""The command step of bases with casters and couplings: exact, inside its limits, the same in Python and compiled."""

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from holodrive import geometry
from holodrive.kinematics import Chassis, Wheel, caster, kernel
from holodrive.kinematics.caster_motion import follow, time_of_turn
from holodrive.kinematics.discretise import discretise
from holodrive.kinematics.pipeline import CommandPipeline
from holodrive.robots.spec import Limits

speeds = st.floats(-3, 3)


def swerve3(trail=0.04, coupling=0.0, steer_rate=math.inf, max_speed=70.0):
    third = 2.0 * math.pi / 3.0
    return Chassis(
        [
            Wheel.swerve(0.3 * math.cos(a), 0.3 * math.sin(a), 0.05, caster=trail, coupling=coupling,
                         steer_rate=steer_rate, max_speed=max_speed, yaw=0.2)
            for a in (0.0, third, -third)
        ]
    )  # fmt: skip


def integrated(along, across, omega, trail, dt, steps=4000):
    """Turn and way of c d' = n . v - c omega by the classical Runge-Kutta method."""
    h, state = dt / steps, np.zeros(2)

    def rate(d):
        e, n = math.cos(d) * along + math.sin(d) * across, math.cos(d) * across - math.sin(d) * along
        return np.array([n / trail - omega, e])

    for _ in range(steps):
        k1 = rate(state[0])
        k2, k3 = rate(state[0] + 0.5 * h * k1[0]), None
        k3 = rate(state[0] + 0.5 * h * k2[0])
        k4 = rate(state[0] + h * k3[0])
        state = state + h / 6.0 * (k1 + 2 * k2 + 2 * k3 + k4)
    return state


@pytest.mark.parametrize("trail", [0.04, -0.03, 0.012])
@pytest.mark.parametrize("motion", [(1.0, 0.3, 0.5), (-1.0, 0.01, -2.0), (0.01, 0.02, 3.0), (0.0, 0.0, 2.0),
                                    (0.04, 0.0, 1.0), (0.0, 0.0, 0.0), (-0.5, 0.0, 0.0)])  # fmt: skip
def test_a_tick_of_a_powered_caster_is_exact(motion, trail):
    for dt in (0.01, 0.05):
        np.testing.assert_allclose(follow(*motion, trail, dt), integrated(*motion, trail, dt, 400), atol=1e-9)


@given(speeds, speeds, st.floats(-6, 6), st.sampled_from([0.04, -0.03, 0.012]), st.floats(0.01, 0.99))
def test_the_time_of_a_turn_is_when_it_has_turned_so_far(along, across, omega, trail, share):
    turn, _ = follow(along, across, omega, trail, 0.02)
    reach = share * abs(turn)
    if 1e-6 < reach < 3.0:
        time = time_of_turn(along, across, omega, trail, turn, reach, 0.02)
        assert 0.0 < time < 0.02
        assert abs(follow(along, across, omega, trail, time)[0]) == pytest.approx(reach, rel=1e-6)


def driven(chassis, twists, dt, limits=None, steer=None, parts=200):
    """Pose after twists (T, 3), each held by rolling wheels through the motion that its tick asks for, in small parts.

    Wheels roll as the exact motion of the modules says; what is checked is angles and mean speeds at the ticks' ends.
    """
    pipeline, pose = CommandPipeline(chassis, limits), np.zeros(3)
    angles = np.zeros(len(chassis.steered)) if steer is None else np.array(steer)
    pipeline.reset(angles)
    for twist in twists:
        body = geometry.rotate(-pose[2], np.array(twist))
        command = pipeline.step(body, dt)
        held, now = _held(pipeline, dt), angles
        ways = np.zeros(len(angles))
        for _ in range(parts):
            h = dt / parts
            middle = now + 0.5 * h * chassis.powered_inverse(held, now).steer_rates
            rates = chassis.powered_inverse(held, middle)
            ways, now = ways + h * rates.speeds, now + h * rates.steer_rates
            found = chassis.forward(rates.speeds, middle, rates.steer_rates)
            pose = geometry.compose(pose, geometry.exp(found * h))
        np.testing.assert_allclose(command.steer, now, atol=1e-5)
        np.testing.assert_allclose(command.speeds, ways / dt, atol=1e-3)
        angles = np.array(command.steer)
    return pose, pipeline


def _held(pipeline, dt):
    return discretise(pipeline.applied.twist, dt)


def test_powered_casters_go_any_way_at_once_and_straight_while_spinning():
    """1 m/s to the left from modules that point ahead, backwards and askew, turning at 3 rad/s, in one second."""
    pose, pipeline = driven(swerve3(), [(0.0, 1.0, 3.0)] * 100, 0.01, steer=[0.0, math.pi, -2.0], parts=30)
    np.testing.assert_allclose(pose, [0.0, 1.0, 3.0], atol=2e-5)
    assert pipeline.applied.binding == ""


def test_powered_casters_keep_to_their_steering_rate_and_drive_speed():
    chassis, rng, dt = swerve3(0.03, 0.5, steer_rate=6.0, max_speed=20.0), np.random.default_rng(5), 0.01
    pipeline, before = CommandPipeline(chassis, Limits(accel_m_s2=4.0)), np.zeros(3)
    bound = set()
    for tick in range(600):
        if tick % 20 == 0:
            twist = rng.uniform(-1, 1, 3) * [2.0, 2.0, 5.0]
        command = pipeline.step(twist, dt)
        rates = np.subtract(command.steer, before) / dt
        assert np.abs(rates).max() <= 6.0 * (1 + 1e-9)
        assert np.abs(caster.drive_speeds(chassis, command.speeds, rates)).max() <= 20.0 * (1 + 1e-9)
        before = np.array(command.steer)
        bound.add(pipeline.applied.binding)
    assert bound >= {*chassis.names, "acceleration"}


def test_a_limited_powered_caster_uses_its_whole_steering_rate():
    pipeline = CommandPipeline(swerve3(0.03, steer_rate=6.0))
    command = pipeline.step((0.0, 1.0, 0.0), 0.01)
    assert np.abs(command.steer).max() == pytest.approx(0.06, rel=1e-6)
    assert pipeline.applied.binding in pipeline.chassis.names
    np.testing.assert_allclose(pipeline.applied.twist, [0.0, pipeline.applied.scale, 0.0], atol=1e-15)


@pytest.mark.parametrize("trail", [0.04, 0.005, 0.0])
def test_modules_keep_their_angle_at_rest(trail):
    pipeline = CommandPipeline(swerve3(trail, coupling=0.4, steer_rate=6.0))
    for _ in range(20):
        angle = pipeline.step((0.3, 0.4, 1.0), 0.01).steer
    assert pipeline.step((0.0, 0.0, 0.0), 0.01) == ((0.0, 0.0, 0.0), angle)


@given(st.integers(0, 2**32 - 1), st.sampled_from([0.005, -0.008, 0.0]))
def test_modules_that_are_not_powered_never_turn_more_than_90_degrees_for_one_command(seed, trail):
    """But for the hysteresis of 5 degrees; a short caster's lean is inside."""
    rng = np.random.default_rng(seed)
    pipeline, before = CommandPipeline(swerve3(trail)), np.zeros(3)
    for _ in range(20):
        twist = rng.uniform(-1, 1, 3) * [2.0, 2.0, 5.0]
        command = pipeline.step(twist, 0.01)
        turned = np.abs(np.subtract(command.steer, before))
        assert turned.max() <= math.radians(95.1)
        before = np.array(command.steer)


@pytest.mark.parametrize("omega", [0.0, 1.5])
def test_a_short_caster_does_not_slip_sideways_on_an_arc_nor_on_a_straight_line(omega):
    """n . v = c (omega + d') at every module, to what angles that change in steps of a tick can do."""
    chassis, dt, heading = swerve3(0.008), 0.01, 0.0
    plain = swerve3(0.0)
    for world in (False, True):
        pipeline, blind, before, sideways = CommandPipeline(chassis), CommandPipeline(plain), None, []
        for _ in range(60):
            twist = np.array([1.0, 0.2, omega])
            if world:
                twist = geometry.rotate(-heading, twist)
            steer = [np.array(p.step(twist, dt).steer) for p in (pipeline, blind)]
            heading += omega * dt
            if before is not None:
                found = []
                for angles, last in zip(steer, before, strict=True):
                    rows = chassis.wheel_rows(_held(pipeline, dt))
                    _, across = caster._turned(chassis, rows, angles)
                    found.append(np.abs(across - 0.008 * (omega + (angles - last) / dt)).max())
                sideways.append(found)
            before = steer
        leaning, upright = np.max(sideways[5:], axis=0)
        assert leaning < 4e-4
        if omega and not world:
            assert upright > 0.01


def test_coupling_leaves_room_for_the_drive_that_makes_up_for_it():
    chassis, dt, before = swerve3(0.0, 1.0, steer_rate=10.0, max_speed=20.0), 0.01, np.zeros(3)
    pipeline, scaled = CommandPipeline(chassis), 0
    rng = np.random.default_rng(2)
    for tick in range(300):
        if tick % 15 == 0:
            twist = rng.uniform(-1, 1, 3) * [2.0, 2.0, 5.0]
        command = pipeline.step(twist, dt)
        rates = np.subtract(command.steer, before) / dt
        assert np.abs(caster.drive_speeds(chassis, command.speeds, rates)).max() <= 20.0 * (1 + 1e-9)
        scaled += np.abs(command.speeds).max() < 19.9
        before = np.array(command.steer)
    assert scaled


MIXED = [
    Wheel.omni(0.25, 0.0, math.pi / 2, 0.05, max_speed=30.0),
    Wheel.swerve(-0.2, 0.2, 0.05, caster=0.05, coupling=-0.3, max_speed=40.0, steer_rate=8.0),
    Wheel.swerve(-0.2, -0.2, 0.06, yaw=0.4, caster=-0.03, max_speed=50.0, steer_rate=12.0),
]


@pytest.mark.parametrize("limits", [None, Limits(1.0, 3.0, 2.0, 5.0)])
@pytest.mark.parametrize(
    "chassis",
    [
        swerve3(0.04, 0.0, 6.0),
        swerve3(0.03, 0.5, 6.0, 20.0),
        swerve3(-0.02, -0.5),
        swerve3(0.005, 0.0, 6.0),
        swerve3(0.005, 0.6, 6.0, 20.0),
        swerve3(-0.008, 0.0),
        swerve3(0.0, 0.7, 6.0, 20.0),
        Chassis(MIXED),
        Chassis([replace(w, caster=0.1 * w.caster) for w in MIXED]),
    ],
)
def test_kernel_and_python_give_the_same_commands(chassis, limits):
    pipeline, kin = CommandPipeline(chassis, limits), kernel.arrays(chassis, limits)
    memory = np.zeros(kernel.memory_size(kin))
    speeds, steer = np.zeros(len(chassis.wheels)), np.zeros(len(chassis.steered))
    rng = np.random.default_rng(6)
    for tick in range(1500):
        if tick % 5 == 0:
            twist = rng.uniform(-1, 1, 3) * [3.0, 3.0, 8.0] * rng.choice([0.0, 1e-3, 0.3, 1])
        dt = float(rng.choice([0.005, 0.01, 0.02]))
        command = pipeline.step(tuple(twist.tolist()), dt)
        scale = kernel.command_step(kin, twist, dt, memory, speeds, steer)
        np.testing.assert_allclose(speeds, command.speeds, rtol=1e-7, atol=1e-7)
        np.testing.assert_allclose(steer, command.steer, rtol=1e-8, atol=1e-8)
        assert scale == pytest.approx(pipeline.applied.scale, rel=1e-8)
        # unstable backwards motion makes rounding grow: start again from the same angles
        pipeline._memory[:] = memory.tolist()
