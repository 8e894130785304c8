"""Limit, discretise, invert: straight lines stay straight, limits hold, modules behave, kernel and Python agree."""

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from holodrive import geometry, robots
from holodrive.errors import CommandError, InputError
from holodrive.kinematics import Chassis, Wheel, kernel, swerve
from holodrive.kinematics.discretise import discretise
from holodrive.kinematics.limits import desaturate, loads
from holodrive.kinematics.pipeline import CommandPipeline
from holodrive.kinematics.settings import HYSTERESIS
from holodrive.robots.spec import Limits
from holodrive.types import WheelCommand

seeds = st.integers(0, 2**32 - 1)
KINDS = ["hybrid3", "omni3", "omni4", "mecanum4", "swerve3", "swerve4", "mixed"]


def drive_straight(chassis, velocity, omega, dt, ticks, limits=None):
    """Poses (ticks + 1, 3) of a base told to move with a world velocity while spinning, and the pipeline."""
    pipeline = CommandPipeline(chassis, limits)
    poses = [np.zeros(3)]
    for _ in range(ticks):
        body = geometry.rotate(-poses[-1][2], np.array([*velocity, omega]))
        command = pipeline.step(body, dt)
        assert np.all(np.abs(command.speeds) <= chassis.max_speeds)
        held = chassis.forward(command.speeds, command.steer)
        poses.append(geometry.compose(poses[-1], geometry.exp(held * dt)))
    return np.array(poses), pipeline


def off_the_line(poses, velocity):
    unit = np.array(velocity) / math.hypot(*velocity)
    return float(np.abs(poses[:, 0] * -unit[1] + poses[:, 1] * unit[0]).max())


@given(
    st.sampled_from(KINDS),
    st.floats(-math.pi, math.pi),
    st.floats(0.05, 6.0),
    st.floats(-15.0, 15.0),
    st.sampled_from([0.005, 0.01, 0.02, 0.05]),
    st.booleans(),
)
def test_a_straight_line_stays_straight_while_spinning_at_any_saturation(
    bases, kind, direction, speed, omega, dt, accelerates
):
    """To 1e-9 m over a second, on every kind of base, with and without acceleration limits."""
    chassis = bases[kind]
    # a module whose contact passes through rest keeps its angle there, which is a deliberate loss
    assume(all(abs(speed - abs(omega) * math.hypot(w.x, w.y)) > 0.05 * speed for w in chassis.wheels if w.steered))
    velocity = (speed * math.cos(direction), speed * math.sin(direction))
    limits = Limits(accel_m_s2=2.0, yaw_accel_rad_s2=9.0) if accelerates else None
    poses, pipeline = drive_straight(chassis, velocity, omega, dt, round(1.0 / dt), limits)
    assert off_the_line(poses, velocity) < 1e-9
    assert math.hypot(*poses[-1, :2]) > 1e-4 or pipeline.applied.scale < 1e-3


@pytest.mark.parametrize(("omega", "dt"), [(6.0, 0.02), (12.0, 0.02), (6.0, 0.05)])
def test_the_peers_recipe_leaves_the_line_and_ours_does_not(bases, omega, dt):
    """Swerve on a 0.6 m square, 4 m/s wheels, 4 m/s ahead while spinning: discretise-then-desaturate is off by
    centimetres (56, 119 and 141 mm in the three cases)."""
    chassis = bases["swerve4"]
    poses, _ = drive_straight(chassis, (4.0, 0.0), omega, dt, round(1.0 / dt))
    assert off_the_line(poses, (1.0, 0.0)) < 1e-9
    pose = np.zeros(3)
    for _ in range(round(1.0 / dt)):
        body = geometry.rotate(-pose[2], np.array([4.0, 0.0, omega]))
        command = chassis.inverse(discretise(body, dt))
        speeds = desaturate(command.speeds, chassis.max_speeds)
        pose = geometry.compose(pose, geometry.exp(chassis.forward(speeds, command.steer) * dt))
    expected = {(6.0, 0.02): -0.056, (12.0, 0.02): -0.119, (6.0, 0.05): -0.141}[omega, dt]
    assert pose[1] == pytest.approx(expected, abs=0.001)


@given(seeds, st.tuples(st.floats(-9, 9), st.floats(-9, 9), st.floats(-30, 30)), st.floats(1e-3, 0.03))
def test_no_wheel_exceeds_its_limit_and_one_reaches_it_when_scaled(chassis_of_seed, seed, twist, dt):
    chassis = chassis_of_seed(seed)
    assume(abs(twist[2]) * dt < 1.0)
    pipeline = CommandPipeline(chassis)
    pipeline.step(twist, dt)
    applied = pipeline.applied
    load = loads(chassis, discretise(applied.twist, dt))
    assert load.max() <= 1.0
    if applied.scale < 1.0:
        assert load[chassis.names.index(applied.binding)] == pytest.approx(1.0, abs=1e-7)
        np.testing.assert_allclose(applied.twist, applied.scale * np.array(twist), rtol=1e-14, atol=1e-300)
    else:
        assert applied.binding == ""


@pytest.mark.parametrize("limits", [None, Limits(0.8, 2.0), Limits(1.0, 3.0, 2.0, 5.0), Limits(accel_m_s2=3.0)])
def test_kernel_and_python_give_the_same_commands(base, limits):
    """Tick by tick with shared history: random twists, rests, reversals, several periods."""
    chassis = Chassis({w.name: replace(w, steer_rate=6.0) if w.steered else w for w in base.wheels})
    pipeline, kin = CommandPipeline(chassis, limits), kernel.arrays(chassis, limits)
    memory = np.zeros(kernel.memory_size(kin))
    speeds, steer = np.zeros(len(chassis.wheels)), np.zeros(len(chassis.steered))
    rng = np.random.default_rng(6)
    for tick in range(2000):
        twist = np.zeros(3) if tick % 17 == 0 else rng.uniform(-1, 1, 3) * [3.0, 3.0, 8.0] * rng.choice([1e-3, 0.3, 1])
        dt = float(rng.choice([0.005, 0.01, 0.02, 0.05]))
        command = pipeline.step(twist, dt)
        scale = kernel.command_step(kin, twist, dt, memory, speeds, steer)
        np.testing.assert_allclose(speeds, command.speeds, rtol=1e-10, atol=1e-10)
        np.testing.assert_allclose(steer, command.steer, rtol=1e-11, atol=1e-11)
        assert scale == pytest.approx(pipeline.applied.scale, rel=1e-12)


def test_base_limits_scale_and_are_named(bases):
    pipeline = CommandPipeline(bases["swerve4"], Limits(speed_m_s=1.0, yaw_rate_rad_s=2.0))
    pipeline.step((3.0, 4.0, 1.0), 0.01)
    assert pipeline.applied.binding == "speed"
    np.testing.assert_allclose(pipeline.applied.twist, [0.6, 0.8, 0.2])
    pipeline.step((0.3, 0.4, -8.0), 0.01)
    assert (pipeline.applied.binding, pipeline.applied.scale) == ("yaw rate", 0.25)


def test_acceleration_is_bounded_in_the_world_and_keeps_the_way(bases):
    """From rest to 1 m/s at 2 m/s^2 takes half a second, straight."""
    pipeline = CommandPipeline(bases["swerve4"], Limits(accel_m_s2=2.0))
    speeds = []
    for _ in range(60):
        pipeline.step((0.6, 0.8, 0.0), 0.01)
        speeds.append(np.hypot(*pipeline.applied.twist[:2]))
    np.testing.assert_allclose(np.diff(speeds)[:48], 0.02, rtol=1e-12)
    assert speeds[49] == pytest.approx(1.0)
    assert speeds[-1] == 1.0
    pipeline.reset(twist=(1.0, 0.0, 0.0))
    pipeline.step((1.0, 0.1, 0.0), 0.01)
    assert pipeline.applied.binding == "acceleration"
    np.testing.assert_allclose(pipeline.applied.twist, [1.0, 0.02, 0.0])


def test_a_twist_that_is_not_a_number_never_becomes_a_speed(base):
    for twist in ((math.nan, 0, 0), (0, math.inf, 0), (0, 0, -math.inf)):
        pipeline, kin = CommandPipeline(base), kernel.arrays(base)
        pipeline.reset([0.3] * len(base.steered))
        command = pipeline.step(twist, 0.01)
        assert np.all(np.isnan(command.speeds))
        assert command.steer == (0.3,) * len(base.steered)
        speeds, steer, memory = np.zeros(len(base.wheels)), np.zeros(len(base.steered)), np.full(99, 0.3)
        memory[kernel.STEER + len(base.steered) :] = 0.0
        assert math.isnan(kernel.command_step(kin, np.array(twist, dtype=float), 0.01, memory, speeds, steer))
        assert np.all(np.isnan(speeds))
        np.testing.assert_allclose(steer, 0.3)
        # and the next good command is a command again
        assert np.all(np.isfinite(pipeline.step((0.01, 0, 0), 0.01).speeds))


def test_a_tick_without_length_is_not_a_command(base):
    assert np.all(np.isnan(CommandPipeline(base).step((0.1, 0, 0), 0.0).speeds))


@pytest.mark.parametrize("dt", [math.inf, math.nan, -0.01, -math.inf])
@pytest.mark.parametrize("limits", [None, Limits(accel_m_s2=2.0)])
def test_a_tick_of_impossible_length_is_refused_and_leaves_no_trace(base, limits, dt):
    pipeline, twin = CommandPipeline(base, limits), CommandPipeline(base, limits)
    for each in (pipeline, twin):
        each.step((0.1, 0.05, 0.2), 0.01)
    with pytest.raises(InputError, match=rf"a tick of {dt} s; its length must be finite and greater than 0"):
        pipeline.step((0.1, 0.05, 0.2), dt)
    assert pipeline.steer == twin.steer
    assert pipeline.step((0.1, 0.06, 0.2), 0.01) == twin.step((0.1, 0.06, 0.2), 0.01)
    # the kernel cannot raise: it gives NaN, which the gate turns into a stop, and keeps its angles
    kin = kernel.arrays(base, limits)
    speeds, steer = np.zeros(len(base.wheels)), np.zeros(len(base.steered))
    memory = np.full(kernel.memory_size(kin), 0.3)
    assert math.isnan(kernel.command_step(kin, np.array([0.1, 0.05, 0.2]), dt, memory, speeds, steer))
    assert np.all(np.isnan(speeds))
    assert np.all(np.isfinite(memory))
    np.testing.assert_array_equal(memory[kernel.STEER : kernel.STEER + len(steer)], 0.3)


def test_applied_tells_what_acceleration_limits_took(bases):
    """`share` is how far towards the wanted twist they let go; a wheel or a speed limit may bind in the same tick."""
    pipeline = CommandPipeline(bases["swerve4"], Limits(accel_m_s2=2.0))
    assert pipeline.applied.share == 1.0
    pipeline.step((0.6, 0.8, 0.0), 0.01)
    assert pipeline.applied.share == pytest.approx(0.02)
    assert (pipeline.applied.scale, pipeline.applied.binding) == (1.0, "acceleration")
    pipeline.reset(twist=(0.6, 0.8, 0.0))
    pipeline.step((0.6, 0.8, 0.0), 0.01)
    assert (pipeline.applied.share, pipeline.applied.binding) == (1.0, "")
    pipeline.reset(twist=(9.0, 0.0, 0.0))
    pipeline.step((0.0, 0.0, 0.0), 0.01)
    assert pipeline.applied.binding == "fl"
    assert pipeline.applied.scale < 1.0
    assert pipeline.applied.share == pytest.approx(0.02 / 9.0)
    pipeline.step((math.nan, 0.0, 0.0), 0.01)
    assert math.isnan(pipeline.applied.share)
    free = CommandPipeline(bases["swerve4"])
    free.step((0.6, 0.8, 0.0), 0.01)
    assert free.applied.share == 1.0
    assert bases["swerve4"].saturate([9.0, 0.0, 0.0]).share == 1.0


def test_a_base_whose_wheels_saturate_by_heading_loses_speed_faster_than_the_acceleration_limit(bases):
    """As the pipeline's text says: wheels come after acceleration. Gaining speed stays bounded."""
    pipeline, heading, speeds, dt = CommandPipeline(bases["mecanum4"], Limits(accel_m_s2=0.1)), 0.0, [], 0.01
    bound = set()
    for _ in range(3000):
        pipeline.step(geometry.rotate(-heading, np.array([0.55, 0.0, 1.0])), dt)
        speeds.append(np.hypot(*pipeline.applied.twist[:2]))
        heading += pipeline.applied.twist[2] * dt
        bound.add(pipeline.applied.binding)
    rates = np.diff(speeds) / dt
    assert rates.max() == pytest.approx(0.1)
    assert rates.min() == pytest.approx(-0.142, abs=0.001)
    assert bound >= {"acceleration", "fl", "fr"}


def one_module(steer_rate=math.inf):
    """Two parallel modules, so that a translation turns both alike."""
    return Chassis([Wheel.swerve(0.0, y, 0.1, max_speed=100.0, steer_rate=steer_rate) for y in (0.2, -0.2)])


def test_modules_turn_the_shorter_way_and_drive_backwards():
    pipeline = CommandPipeline(one_module())
    command = pipeline.step((-1.0, 0.2, 0.0), 0.01)
    assert command.steer == pytest.approx([-math.atan2(0.2, 1.0)] * 2)
    assert command.speeds == pytest.approx([-math.hypot(1.0, 0.2) / 0.1] * 2)


def test_modules_keep_their_angle_at_rest():
    pipeline = CommandPipeline(one_module())
    angle = pipeline.step((1.0, 1.0, 0.0), 0.01).steer
    assert pipeline.step((0.0, 0.0, 0.0), 0.01) == ((0.0, 0.0), angle)
    crawl = pipeline.step((0.0, 5e-4, 0.0), 0.01)
    assert crawl.steer == angle
    # what is left of the crawl along the wheel is driven
    assert crawl.speeds == pytest.approx([5e-3 * math.cos(math.pi / 4)] * 2)


def test_steering_rate_holds_and_drive_waits_by_the_cosine():
    pipeline = CommandPipeline(one_module(steer_rate=5.0))
    command = pipeline.step((math.cos(1.2), math.sin(1.2), 0.0), 0.1)
    assert command.steer == pytest.approx([0.5] * 2)
    assert command.speeds == pytest.approx([10.0 * math.cos(0.7)] * 2)
    for _ in range(2):
        command = pipeline.step((math.cos(1.2), math.sin(1.2), 0.0), 0.1)
    assert command.steer == pytest.approx([1.2] * 2)
    assert command.speeds == pytest.approx([10.0] * 2)


def test_flips_have_hysteresis_but_a_fresh_module_decides_at_90_degrees():
    def steer_of(first_deg, second_deg):
        pipeline = CommandPipeline(one_module())
        for angle in (math.radians(first_deg), math.radians(second_deg)):
            command = pipeline.step((math.cos(angle), math.sin(angle), 0.0), 0.01)
        return math.degrees(command.steer[0]), command.speeds[0]

    assert steer_of(0.0, 93.0) == pytest.approx((93.0, 10.0))  # inside the band it stays forwards
    assert steer_of(0.0, 96.0) == pytest.approx((-84.0, -10.0))
    assert steer_of(-179.0, -179.0 + 92.0) == pytest.approx((93.0, -10.0))  # and stays backwards
    fresh = CommandPipeline(one_module())
    assert fresh.step((math.cos(1.58), math.sin(1.58), 0.0), 0.01).steer == pytest.approx([1.58 - math.pi] * 2)


def exactly_square():
    """(goal, now) [rad] for every whole degree and some turns, 90 degrees apart but for rounding."""
    return [
        (math.radians(now + side * 90 + 360 * turns), math.radians(now))
        for now in range(-180, 181)
        for side in (-1, 1)
        for turns in (-1, 0, 1)
    ]


def test_rounding_does_not_decide_at_90_degrees():
    """A module square to its goal keeps driving forwards: in the batch, plain floats and the kernel alike."""
    chassis = one_module()
    kin = kernel.arrays(chassis)
    for goal, now in exactly_square():
        for sign in (-1.0, 0.0, 1.0):
            assert swerve.optimise(1.0, goal, now, sign=sign)[0] == 1.0
        pipeline = CommandPipeline(chassis)
        pipeline.reset([now, now])
        command = pipeline.step((math.cos(goal), math.sin(goal), 0.0), 0.01)
        speeds, steer, memory = np.zeros(2), np.zeros(2), np.array([0.0, 0.0, 0.0, now, now, 0.0, 0.0])
        kernel.command_step(kin, np.array([math.cos(goal), math.sin(goal), 0.0]), 0.01, memory, speeds, steer)
        assert np.all(np.asarray(command.speeds) > 0.0)
        assert np.all(speeds > 0.0)
        np.testing.assert_allclose(steer, command.steer, rtol=0.0, atol=1e-12)


@pytest.mark.parametrize("sign", [-1.0, 1.0])
def test_rounding_does_not_decide_at_the_edge_of_the_hysteresis(sign):
    """At 90 degrees + `sign` 5 degrees a moving module keeps its drive sign, in all three faces."""
    chassis = one_module()
    kin, edge = kernel.arrays(chassis), math.pi / 2 + sign * HYSTERESIS
    for degrees in range(-180, 181):
        now = math.radians(degrees)
        goal = now + edge
        assert swerve.optimise(1.0, goal, now, hysteresis=HYSTERESIS, sign=sign)[0] == sign
        pipeline, speeds, steer = CommandPipeline(chassis), np.zeros(2), np.zeros(2)
        pipeline.reset([now, now])
        memory = np.array([0.0, 0.0, 0.0, now, now, 0.0, 0.0])
        for angle in (now if sign > 0 else now + math.pi, goal):
            twist = (math.cos(angle), math.sin(angle), 0.0)
            command = pipeline.step(twist, 0.01)
            kernel.command_step(kin, np.array(twist), 0.01, memory, speeds, steer)
        assert np.all(np.sign(command.speeds) == sign)
        assert np.all(np.sign(speeds) == sign)


@pytest.mark.parametrize("beyond", [-1e-6, 1e-6])
def test_a_little_beyond_90_degrees_flips_and_a_little_before_does_not(beyond):
    goal = math.pi / 2 + beyond
    expected = -1.0 if beyond > 0.0 else 1.0
    assert swerve.optimise(1.0, goal, 0.0)[0] == expected
    command = CommandPipeline(one_module()).step((math.cos(goal), math.sin(goal), 0.0), 0.01)
    speeds, steer, kin = np.zeros(2), np.zeros(2), kernel.arrays(one_module())
    kernel.command_step(kin, np.array([math.cos(goal), math.sin(goal), 0.0]), 0.01, np.zeros(7), speeds, steer)
    assert np.all(np.sign(command.speeds) == expected)
    assert np.all(np.sign(speeds) == expected)


def test_modules_about_square_to_their_goal_flip_all_or_none():
    """Noise around 90 degrees must not turn one module clockwise and its neighbours the other way."""
    chassis = Chassis([Wheel.swerve(x, y, 0.1) for x, y in ((0.3, 0.3), (0.3, -0.3), (-0.3, 0.3), (-0.3, -0.3))])
    rng = np.random.default_rng(7)
    for _ in range(50):
        pipeline, kin = CommandPipeline(chassis), kernel.arrays(chassis)
        start = rng.normal(0.0, math.radians(1.0), 4)
        pipeline.reset(start)
        command = pipeline.step((0.0, 1.0, 0.0), 0.01)
        assert len(set(np.sign(np.subtract(command.steer, start)))) == 1
        memory, speeds, steer = np.concatenate([np.zeros(3), start, np.zeros(4)]), np.zeros(4), np.zeros(4)
        kernel.command_step(kin, np.array([0.0, 1.0, 0.0]), 0.01, memory, speeds, steer)
        np.testing.assert_allclose(steer, command.steer, atol=1e-12)


def test_module_functions_on_arrays():
    speed, angle = swerve.optimise([-2.0, 1.0, 1.0], [math.pi, 0.5, 3.0], [math.pi / 4, 0.0, 0.0])
    np.testing.assert_allclose(speed, [2.0, 1.0, -1.0])
    np.testing.assert_allclose(angle, [0.0, 0.5, 3.0 - math.pi], atol=1e-15)
    # exactly 90 degrees does not flip; with hysteresis it depends on the way it drives now
    assert swerve.optimise(1.0, math.pi / 2, 0.0)[0] == 1.0
    assert swerve.optimise(1.0, 1.6, 0.0, hysteresis=0.1, sign=1.0)[0] == 1.0
    assert swerve.optimise(1.0, 1.5, 0.0, hysteresis=0.1, sign=-1.0)[0] == -1.0
    np.testing.assert_allclose(swerve.cosine_scale(2.0, math.pi / 4, 0.0), math.sqrt(2))


def test_wheel_commands_are_scaled_in_common(base):
    pipeline, kin = CommandPipeline(base), kernel.arrays(base)
    speeds = 3.0 * base.max_speeds * np.linspace(-1.0, 0.5, len(base.wheels))
    scaled = pipeline.saturate(WheelCommand(speeds, ()))
    np.testing.assert_allclose(scaled.speeds, speeds / 3.0)
    compiled = speeds.copy()
    assert kernel.saturate_wheels(kin, compiled) == pytest.approx(1.0 / 3.0)
    np.testing.assert_allclose(compiled, scaled.speeds)
    assert pipeline.saturate(WheelCommand((0.1,) * len(base.wheels), ())).speeds == (0.1,) * len(base.wheels)
    with pytest.raises(CommandError, match="wheel speeds for a base with"):
        pipeline.saturate(WheelCommand((1.0,), ()))


def test_reset_wants_an_angle_for_each_module(bases):
    with pytest.raises(CommandError, match="give 4"):
        CommandPipeline(bases["swerve4"]).reset([0.0])


@pytest.mark.parametrize("name", ["hybrid3", "omni3", "omni4", "mecanum4", "swerve3", "swerve4"])
def test_the_catalogs_robots_have_pipelines_with_their_limits(name):
    robot = robots.load(name)
    pipeline = CommandPipeline(robot)
    assert pipeline.chassis is Chassis.of(robot)
    for _ in range(300):
        command = pipeline.step((100.0, 50.0, 20.0), robot.control_period_s)
    assert np.all(np.abs(command.speeds) <= [wheel.max_speed_rad_s for wheel in robot.wheels])
    assert np.hypot(*pipeline.applied.twist[:2]) <= robot.limits.speed_m_s * (1 + 1e-12)
    assert kernel.arrays(robot)[kernel.SPEED] == robot.limits.speed_m_s
