"""The wheel equation and the two maps: laws over random bases, and the papers' numbers."""

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from holodrive import geometry, robots
from holodrive.errors import ChassisError, InputError
from holodrive.kinematics import Chassis, Wheel
from holodrive.kinematics.discretise import discretise

seeds = st.integers(0, 2**32 - 1)
twists = st.tuples(st.floats(-3, 3), st.floats(-3, 3), st.floats(-6, 6)).map(np.array)


def close(a, b, tolerance):
    np.testing.assert_allclose(a, b, rtol=0.0, atol=tolerance)


@given(seeds, twists)
def test_forward_undoes_inverse(chassis_of_seed, seed, twist):
    """To 1e-12 times the condition number, over random bases of all kinds of wheel."""
    chassis = chassis_of_seed(seed)
    command = chassis.inverse(twist)
    error = chassis.forward(command.speeds, command.steer) - twist
    scale = np.array([1.0, 1.0, chassis.characteristic_length])
    assert np.abs(error * scale).max() <= 1e-12 * chassis.condition * max(1.0, np.abs(twist * scale).max())


@given(seeds, twists, twists, st.floats(-2, 2))
def test_wheel_rows_are_linear_in_the_twist(chassis_of_seed, seed, a, b, k):
    chassis = chassis_of_seed(seed)
    left, right = chassis.wheel_rows(a + k * b), chassis.wheel_rows(a) + k * chassis.wheel_rows(b)
    close(left, right, 1e-12 * np.abs(chassis.jacobian).max() * 20)


@given(seeds, twists, st.tuples(st.floats(-1, 1), st.floats(-1, 1), st.floats(-3, 3)).map(np.array))
def test_moving_and_turning_base_link_changes_no_wheel(chassis_of_seed, seed, twist, frame):
    """`frame` is the pose of the old base_link in the new one."""
    chassis = chassis_of_seed(seed)
    moved = []
    for wheel in chassis.wheels:
        x, y, yaw = geometry.compose(frame, [wheel.x, wheel.y, wheel.yaw])
        moved.append(replace(wheel, x=float(x), y=float(y), yaw=float(yaw)))
    before, after = chassis.inverse(twist), Chassis(moved).inverse(geometry.adjoint(frame) @ twist)
    close(after.speeds, before.speeds, 1e-10 * max(1.0, np.abs(before.speeds).max()))
    turning = np.abs(before.speeds[list(chassis.steered)]) > 1e-6
    close(np.sin(0.5 * (after.steer - before.steer))[turning], 0.0, 1e-7)


@given(seeds, twists)
def test_a_mirrored_base_does_the_mirrored_motion(chassis_of_seed, seed, twist):
    chassis = chassis_of_seed(seed)
    mirrored = Chassis([replace(w, y=-w.y, yaw=-w.yaw, roller=-w.roller) for w in chassis.wheels])
    before, after = chassis.inverse(twist), mirrored.inverse(twist * [1, -1, -1])
    close(after.speeds, before.speeds, 1e-11 * max(1.0, np.abs(before.speeds).max()))
    turning = np.abs(before.speeds[list(chassis.steered)]) > 1e-6
    close(np.sin(0.5 * (after.steer + before.steer))[turning], 0.0, 1e-9)


@given(seeds, twists, st.tuples(st.floats(-2, 2), st.floats(-2, 2)))
def test_inverse_about_a_centre_gives_that_point_the_velocity(chassis_of_seed, seed, twist, centre):
    chassis = chassis_of_seed(seed)
    command = chassis.inverse(twist, centre)
    vx, vy, omega = chassis.forward(command.speeds, command.steer)
    close([vx - omega * centre[1], vy + omega * centre[0], omega], twist, 1e-10 * chassis.condition)


def test_zero_twist_gives_zero_wheel_speeds(base):
    command = base.inverse([0.0, 0.0, 0.0])
    assert not np.any(command.speeds)
    assert command.steer.shape == (len(base.steered),)


def test_batches_of_any_shape_equal_single_calls(base):
    twist = np.random.default_rng(2).normal(size=(3, 4, 3))
    batch = base.inverse(twist)
    assert batch.speeds.shape == (3, 4, len(base.wheels))
    single = base.inverse(twist[1, 2])
    close(batch.speeds[1, 2], single.speeds, 1e-14)
    close(base.forward(batch.speeds, batch.steer), twist, 1e-12)


def test_steered_wheels_get_the_plain_polar_form(bases):
    command = bases["swerve4"].inverse(np.random.default_rng(3).normal(size=(100, 3)))
    assert np.all(command.speeds >= 0.0)
    assert np.all(np.abs(command.steer) <= math.pi)


def test_steering_counts_from_the_yaw_of_the_module():
    straight = [Wheel.swerve(0.3, 0.2, 0.05), Wheel.swerve(-0.3, 0.1, 0.05)]
    turned = [replace(wheel, yaw=0.4) for wheel in straight]
    a, b = Chassis(straight).inverse([1.0, 0.5, 0.2]), Chassis(turned).inverse([1.0, 0.5, 0.2])
    close(b.steer, a.steer - 0.4, 1e-14)
    close(b.speeds, a.speeds, 1e-13)


def test_wheels_are_named_by_the_dict_by_themselves_or_by_number():
    three = [Wheel.omni(math.cos(a), math.sin(a), a + math.pi / 2, 0.1) for a in (0.0, 2.0, 4.0)]
    assert Chassis({"a": three[0], "b": three[1], "c": three[2]}).names == ("a", "b", "c")
    assert Chassis([replace(three[0], name="nose"), *three[1:]]).names == ("nose", "wheel2", "wheel3")
    with pytest.raises(ChassisError, match="two wheels are called 'a'"):
        Chassis([replace(wheel, name="a") for wheel in three])
    with pytest.raises(ChassisError, match="without wheels"):
        Chassis([])


def test_a_given_name_may_not_be_the_default_name_of_another_wheel():
    three = [Wheel.omni(math.cos(a), math.sin(a), a + math.pi / 2, 0.1) for a in (0.0, 2.0, 4.0)]
    refuses(
        lambda: Chassis([replace(three[0], name="wheel2"), *three[1:]]),
        "wheel 1 is called 'wheel2', which would be the name of wheel 2; give wheel 2 a name",
    )
    # its own default name, and any name where every wheel has one, are a wheel's to have
    assert Chassis([three[0], replace(three[1], name="wheel2"), three[2]]).names == ("wheel1", "wheel2", "wheel3")
    names = ("wheel2", "wheel1", "c")
    assert Chassis([replace(w, name=n) for w, n in zip(three, names, strict=True)]).names == names
    refuses(lambda: Chassis({1: three[0], "1": three[1], "c": three[2]}), "two wheels are called '1'")


@pytest.mark.parametrize(
    ("make", "said"),
    [
        (lambda: Wheel.omni(0, 0, 0, 0.0), "radius is 0"),
        (lambda: Wheel.omni(0, math.nan, 0, 0.1), "y is nan"),
        (lambda: Wheel.mecanum(0, 0, 0, 0.1, math.pi / 2, name="fl"), "'fl': its rollers run free"),
        (lambda: Wheel.swerve(0, 0, 0.1, max_speed=-1.0), "max_speed is -1"),
    ],
)
def test_an_impossible_wheel_is_refused_in_words(make, said):
    with pytest.raises(InputError, match=said):
        make()


def test_wrong_shapes_are_named(bases):
    with pytest.raises(ChassisError, match=r"expected \(\.\.\., 4\)"):
        bases["mecanum4"].forward([1.0, 2.0])
    with pytest.raises(ChassisError, match=r"needs steering angles.*one for each of fl, fr, rl, rr"):
        bases["swerve4"].forward([1.0, 2.0, 3.0, 4.0])


@pytest.mark.parametrize("twist", [[1, 2, 3, 4], [[1, 2, 3, 4]], [1, 2], 5.0, [], [[1, 2, 3], [4, 5]], ["fast"], None])
@pytest.mark.parametrize("kind", ["omni3", "swerve4"])
def test_what_is_not_a_twist_is_refused_in_one_line(bases, kind, twist):
    chassis = bases[kind]
    for function in (chassis.inverse, chassis.wheel_rows, chassis.saturate, chassis.wheels[0].roller_speed):
        refuses(lambda function=function: function(twist), "twist", r"expected (\(\.\.\., 3\): vx|an array of numbers)")
    refuses(lambda: chassis.inverse_acceleration([0, 0, 0], twist), "rate of a twist")
    refuses(lambda: discretise(twist, 0.01), "twist")


@pytest.mark.parametrize("centre", [[0.1, 0.2, 0.3], [0.1], 0.1, [], "nose"])
def test_what_is_not_a_point_is_refused_in_one_line(bases, centre):
    refuses(lambda: bases["omni3"].inverse([1, 2, 3], centre), "centre")


def test_leading_axes_that_do_not_fit_are_refused_in_one_line(bases):
    refuses(lambda: bases["omni3"].inverse(np.zeros((5, 3)), np.zeros((4, 2))), r"twist \(5,\), centre \(4,\)")
    refuses(lambda: bases["swerve4"].forward(np.zeros((5, 4)), np.zeros((3, 4))), r"speeds \(5,\), steer \(3,\)")


def test_steering_angles_belong_to_steered_wheels(bases):
    for steer in ([0.1], 0.1, [0.1] * 4):
        for call in (bases["mecanum4"].forward, bases["mecanum4"].solve):
            refuses(lambda call=call, steer=steer: call([1, 2, 3, 4], steer), "no steered wheel")
    refuses(lambda: bases["mecanum4"].forward_acceleration([0] * 4, [0] * 4, (), [0.1]), "no steered wheel")
    # an inverse's own empty answer goes back in, for one and for many
    for twist in (np.zeros(3), np.zeros((2, 3))):
        command = bases["mecanum4"].inverse(twist)
        close(bases["mecanum4"].forward(command.speeds, command.steer), twist, 0.0)
    for call in (bases["swerve4"].forward, bases["swerve4"].solve):
        for steer in (None, (), 0.1, [0.1] * 3):
            refuses(lambda call=call, steer=steer: call([1, 2, 3, 4], steer), "one for each of fl, fr, rl, rr")
    refuses(lambda: bases["swerve4"].forward_acceleration([0] * 4, [0] * 4, [0] * 4, [0.1]), "rates of steering")


@pytest.mark.parametrize("wheels", [{"a": 3}, [None], "wheels", 3, None])
def test_what_is_not_a_wheel_is_refused_in_one_line(wheels):
    refuses(lambda: Chassis(wheels), r"Wheel\.omni")


def test_arrays_that_all_users_of_a_robot_share_cannot_be_written():
    chassis = Chassis.of(robots.load("swerve4"))
    shared = [value for name in dir(chassis) if isinstance(value := getattr(chassis, name), np.ndarray)]
    polytope = Chassis.of(robots.load("hybrid3")).polytope
    shared += [value for name in dir(polytope) if isinstance(value := getattr(polytope, name), np.ndarray)]
    assert len(shared) >= 9
    for array in shared:
        with pytest.raises(ValueError, match="read-only"):
            array[...] = 0


def test_a_base_without_steered_wheels_answers_with_arrays_of_the_callers_own(bases):
    speeds = bases["omni3"].inverse([1.0, 0.0, 0.0]).speeds
    speeds[:] = 0.0
    assert np.any(bases["omni3"].inverse([1.0, 0.0, 0.0]).speeds)


def refuses(call, *said):
    with pytest.raises(InputError) as caught:
        call()
    assert "\n" not in str(caught.value)
    for part in said:
        caught.match(part)


def test_condition_numbers_are_the_papers(bases):
    for name, condition in {"hybrid3": 4.540015, "omni3": math.sqrt(2), "omni4": math.sqrt(2), "mecanum4": 1.0}.items():
        assert bases[name].condition == pytest.approx(condition, abs=1e-6)
    assert bases["swerve3"].condition == pytest.approx(1.0, abs=1e-12)
    assert bases["hybrid3"].warnings == ()


@pytest.mark.parametrize(("gamma_deg", "condition"), [(45, 4.54), (60, 2.41), (75, 1.73), (90, 1.41)])
def test_steeper_rollers_condition_the_hybrid_better(gamma_deg, condition):
    third, gamma = 2.0 * math.pi / 3.0, math.radians(gamma_deg)
    chassis = Chassis(
        [
            Wheel.from_paper(0.0, 0.0, -math.pi / 2, 0.23, 0.051),
            Wheel.from_paper(-third, -third, gamma, 0.23, 0.051),
            Wheel.from_paper(third, third, -gamma, 0.23, 0.051),
        ]
    )
    assert chassis.condition == pytest.approx(condition, abs=0.006)


def test_a_poor_layout_warns_in_words(chassis_of_seed):
    small = [Wheel.omni(x, y, yaw, 0.05) for x, y, yaw in ((0.2, 0.0, 1.6), (-0.2, 0.0, 1.5), (0.0, 0.1, 1.57))]
    chassis = Chassis(small)
    assert chassis.condition > 10.0
    assert "is above 10" in chassis.warnings[0]
