"""Wheels that trail behind their steering axis: the maps, there and back, first and second order, three faces."""

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from holodrive import geometry
from holodrive.errors import ChassisError
from holodrive.kinematics import Chassis, Wheel, caster, kernel
from holodrive.kinematics.caster_kernel import caster_forward_step, wheel_twist

seeds = st.integers(0, 2**32 - 1)
twists = st.tuples(st.floats(-3, 3), st.floats(-3, 3), st.floats(-6, 6)).map(np.array)


def powered4(trail=0.04, coupling=0.0, **limits):
    places = {"fl": (0.3, 0.25), "fr": (0.3, -0.25), "rl": (-0.3, 0.25), "rr": (-0.3, -0.25)}
    return Chassis(
        {
            name: Wheel.swerve(x, y, 0.05, caster=trail, coupling=coupling, **{"max_speed": 80.0, **limits})
            for name, (x, y) in places.items()
        }
    )


def trailing(chassis, seed, all_of_them=False):
    """The same base with casters of both signs, up to 50 mm, on its steered wheels."""
    rng = np.random.default_rng(seed)
    least = 0.01 if all_of_them else 0.0
    wheels = [
        replace(w, caster=float(rng.choice([-1, 1]) * rng.uniform(least, 0.05)), coupling=float(rng.uniform(-1, 1)))
        if w.steered
        else w
        for w in chassis.wheels
    ]
    return Chassis(wheels)


def steerable(chassis_of_seed, seed):
    chassis = chassis_of_seed(seed)
    assume(chassis.steered)
    return trailing(chassis, seed, all_of_them=True)


@given(seeds, twists)
def test_powered_casters_give_any_twist_at_once_from_any_steering_angle(chassis_of_seed, seed, twist):
    chassis = steerable(chassis_of_seed, seed)
    steer = np.random.default_rng(seed).uniform(-7, 7, len(chassis.steered))
    rates = chassis.powered_inverse(twist, steer)
    solution = chassis.solve(rates.speeds, steer, steer_rates=rates.steer_rates)
    condition = np.linalg.cond(chassis.matrix_at(steer))
    assume(condition < 1e3)
    np.testing.assert_allclose(solution.twist, twist, atol=1e-12 * condition)
    np.testing.assert_allclose(solution.slip, 0.0, atol=1e-11)
    np.testing.assert_allclose(chassis.forward(rates.speeds, steer, rates.steer_rates), solution.twist, atol=1e-11)


@given(seeds, twists)
def test_the_contact_of_a_powered_caster_rolls_and_does_not_slide(chassis_of_seed, seed, twist):
    """Against the motion of the contact point itself: p - c e(d) carried with body and module, minus r w e."""
    chassis = steerable(chassis_of_seed, seed)
    steer = np.random.default_rng(seed).uniform(-7, 7, len(chassis.steered))
    rates = chassis.powered_inverse(twist, steer)
    vx, vy, omega = twist
    for j, i in enumerate(chassis.steered):
        w, angle = chassis.wheels[i], chassis.wheels[i].yaw + steer[j]
        e, n = np.array([math.cos(angle), math.sin(angle)]), np.array([-math.sin(angle), math.cos(angle)])
        place = np.array([w.x, w.y]) - w.caster * e
        moved = np.array([vx - omega * place[1], vy + omega * place[0]]) - w.caster * rates.steer_rates[j] * n
        np.testing.assert_allclose(moved, w.radius * rates.speeds[i] * e, atol=1e-11)


@given(seeds, twists)
def test_forward_undoes_the_steady_inverse(chassis_of_seed, seed, twist):
    chassis = steerable(chassis_of_seed, seed)
    rows = chassis.wheel_rows(twist)
    v = np.hypot(rows[chassis.steered_rows], rows[chassis.steered_rows + 1])
    assume(np.all(v > np.abs(chassis.casters * twist[2])))
    command = chassis.inverse(twist)
    assert np.all(command.speeds[list(chassis.steered)] >= 0.0)
    assert np.all(np.abs(command.steer) <= math.pi)
    condition = np.linalg.cond(chassis.matrix_at(command.steer))
    assume(condition < 1e3)
    np.testing.assert_allclose(chassis.forward(*command), twist, atol=1e-12 * condition)


def test_a_caster_behind_a_straight_run_changes_nothing_and_in_a_turn_leans_inwards():
    plain, chassis = powered4(0.0), powered4(0.04)
    np.testing.assert_allclose(chassis.inverse([1.0, 0.5, 0.0]), plain.inverse([1.0, 0.5, 0.0]))
    # turning about a centre 1 m to the left of an axis, the contact lies on the circle's tangent point
    single = chassis.inverse([0.0, 0.0, 1.0])
    for wheel, angle in zip(chassis.wheels, single.steer, strict=True):
        contact = np.array([wheel.x, wheel.y]) - wheel.caster * np.array([math.cos(angle), math.sin(angle)])
        assert contact @ [math.cos(angle), math.sin(angle)] == pytest.approx(0.0, abs=1e-14)


@given(seeds)
def test_the_compiled_forward_is_the_batch_forward(chassis_of_seed, seed):
    chassis = trailing(chassis_of_seed(seed), seed)
    assume(chassis.castered)
    rng = np.random.default_rng(seed)
    speeds, m = rng.normal(size=len(chassis.wheels)), len(chassis.steered)
    steer, rates, ago = rng.uniform(-4, 4, m), rng.normal(size=m), 0.1
    angles = steer - ago * rates
    condition = np.linalg.cond(chassis.matrix_at(angles))
    assume(condition < 1e3)
    solution = chassis.solve(speeds, angles, steer_rates=rates)
    twist, kin = np.zeros(3), kernel.arrays(chassis)
    slip = caster_forward_step(kin, speeds, steer, rates, ago, twist)
    close = {"rtol": 0.0, "atol": 1e-13 * condition**2 * max(1.0, np.abs(solution.twist).max())}
    np.testing.assert_allclose(twist, solution.twist, **close)
    assert slip == pytest.approx(float(solution.slip), rel=1e-8, abs=1e-8)
    np.testing.assert_allclose(chassis.scalar.forward(*speeds, *angles, *rates), solution.twist, **close)
    # wheels add up
    parts = np.zeros(3)
    for i, wheel in enumerate(chassis.wheels):
        roll, sweep = speeds[i], 0.0
        if wheel.steered:
            roll, sweep = speeds[i] * wheel.radius, wheel.caster * rates[chassis.steered.index(i)]
        parts += wheel_twist(kin, i, steer, rates, ago, roll, sweep)
    np.testing.assert_allclose(parts, twist, **close)


@given(seeds, twists)
def test_the_scalar_inverse_is_the_batch_inverse(chassis_of_seed, seed, twist):
    chassis = steerable(chassis_of_seed, seed)
    n, command = len(chassis.wheels), chassis.inverse(twist)
    rows = chassis.wheel_rows(twist)
    assume(np.all(np.hypot(rows[chassis.steered_rows], rows[chassis.steered_rows + 1]) > 1e-3))
    scalar = chassis.scalar.inverse(*map(float, twist))
    # where the arc is just possible its sine has no slope, and the angle only half of the digits
    np.testing.assert_allclose(scalar[:n], command.speeds, atol=1e-6 * np.abs(chassis.jacobian).max() * 10)
    np.testing.assert_allclose(np.sin(0.5 * np.subtract(scalar[n:], command.steer)), 0.0, atol=1e-7)


def test_without_casters_the_caster_forward_is_the_plain_one(base):
    rng = np.random.default_rng(3)
    speeds, m = rng.normal(size=len(base.wheels)), len(base.steered)
    steer, rates, twist = rng.normal(size=m), rng.normal(size=m), np.zeros(3)
    slip = caster_forward_step(kernel.arrays(base), speeds, steer, rates, 0.0, twist)
    np.testing.assert_allclose(twist, base.forward(speeds, steer), atol=1e-12)
    assert slip == pytest.approx(float(base.solve(speeds, steer).slip), abs=1e-12)
    np.testing.assert_array_equal(base.forward(speeds, steer, rates), base.forward(speeds, steer))


@given(seeds, twists, twists)
def test_second_order_of_the_inverse_is_its_derivative(chassis_of_seed, seed, twist, accel):
    chassis, h = steerable(chassis_of_seed, seed), 1e-6
    rows = chassis.wheel_rows(twist)
    v = np.hypot(rows[chassis.steered_rows], rows[chassis.steered_rows + 1])
    assume(np.all(v > 0.1 + 1.5 * np.abs(chassis.casters * twist[2])))
    rates = chassis.inverse_acceleration(twist, accel)
    after, before = chassis.inverse(twist + h * accel), chassis.inverse(twist - h * accel)
    size = np.abs(chassis.jacobian).max() * 30
    np.testing.assert_allclose((after.speeds - before.speeds) / (2 * h), rates.speeds, atol=1e-5 * size)
    turn = geometry.wrap(after.steer - before.steer) / (2 * h)
    np.testing.assert_allclose(turn, rates.steer, atol=1e-3)


@given(seeds, twists, twists)
def test_second_order_of_powered_casters_is_their_derivative_and_comes_back(chassis_of_seed, seed, twist, accel):
    chassis, h = steerable(chassis_of_seed, seed), 1e-6
    steer = np.random.default_rng(seed).uniform(-7, 7, len(chassis.steered))
    now, rates = chassis.powered_inverse(twist, steer), caster.powered_acceleration(chassis, twist, accel, steer)
    np.testing.assert_array_equal(rates.steer_rates, now.steer_rates)

    def at(t):
        return chassis.powered_inverse(twist + t * accel, steer + t * now.steer_rates)

    after, before = at(h), at(-h)
    largest = 1.0 + np.abs(rates.steer_accels).max() * np.abs(now.steer_rates).max()
    size = np.abs(chassis.jacobian).max() * 30 + np.abs(rates.speeds).max()
    np.testing.assert_allclose((after.speeds - before.speeds) / (2 * h), rates.speeds, atol=1e-5 * size)
    found = (after.steer_rates - before.steer_rates) / (2 * h)
    np.testing.assert_allclose(found, rates.steer_accels, atol=1e-5 * largest)
    condition = np.linalg.cond(chassis.matrix_at(steer))
    assume(condition < 1e3)
    back = chassis.forward_acceleration(now.speeds, rates.speeds, steer, rates.steer_rates, rates.steer_accels)
    np.testing.assert_allclose(back, accel, atol=1e-11 * condition * largest)


def test_coupling_turns_the_wheel_against_its_drive():
    chassis = powered4(0.0, coupling=0.5)
    assert not chassis.castered
    rates = np.array([1.0, -2.0, 0.0, 4.0])
    np.testing.assert_array_equal(caster.wheel_speeds(chassis, np.zeros(4), rates), -0.5 * rates)
    np.testing.assert_array_equal(
        caster.wheel_speeds(chassis, caster.drive_speeds(chassis, [1.0, 2.0, 3.0, 4.0], rates), rates), [1, 2, 3, 4]
    )


def test_powered_casters_need_casters(bases):
    for chassis in (bases["swerve4"], bases["omni4"]):
        with pytest.raises(ChassisError, match="give each a caster"):
            chassis.powered_inverse([1, 0, 0], np.zeros(4) if chassis.steered else ())


def test_batches_equal_single_calls():
    chassis, rng = powered4(0.03, 0.2), np.random.default_rng(12)
    twist, steer = rng.normal(size=(7, 3)), rng.normal(size=(7, 4))
    rates = chassis.powered_inverse(twist, steer)
    found = chassis.forward(rates.speeds, steer, rates.steer_rates)
    np.testing.assert_allclose(found, twist, atol=1e-12)
    for i in range(7):
        single = chassis.powered_inverse(twist[i], steer[i])
        np.testing.assert_allclose(single.speeds, rates.speeds[i])
        np.testing.assert_allclose(chassis.forward(single.speeds, steer[i], single.steer_rates), found[i], atol=1e-12)
    np.testing.assert_allclose(chassis.inverse(twist).steer[3], chassis.inverse(twist[3]).steer)
