"""Second order: agrees with finite differences, and back and forth is the identity."""

import numpy as np
from hypothesis import assume, given
from hypothesis import strategies as st

from holodrive import geometry

seeds = st.integers(0, 2**32 - 1)
twists = st.tuples(st.floats(-3, 3), st.floats(-3, 3), st.floats(-6, 6)).map(np.array)


def slowest_contact(chassis, twist):
    speeds = chassis.inverse(twist).speeds * chassis.radii
    return np.min(speeds[list(chassis.steered)], initial=np.inf)


@given(seeds, twists, twists)
def test_wheel_and_steering_rates_are_the_derivatives_of_the_inverse(chassis_of_seed, seed, twist, accel):
    chassis = chassis_of_seed(seed)
    assume(slowest_contact(chassis, twist) > 0.1)
    rates, h = chassis.inverse_acceleration(twist, accel), 1e-6
    after, before = chassis.inverse(twist + h * accel), chassis.inverse(twist - h * accel)
    size = np.abs(chassis.jacobian).max() * 30
    np.testing.assert_allclose((after.speeds - before.speeds) / (2 * h), rates.speeds, atol=1e-6 * size)
    turn = geometry.wrap(after.steer - before.steer) / (2 * h)
    np.testing.assert_allclose(turn, rates.steer, atol=1e-4)


@given(seeds, twists, twists)
def test_forward_undoes_inverse_at_second_order(chassis_of_seed, seed, twist, accel):
    chassis = chassis_of_seed(seed)
    assume(slowest_contact(chassis, twist) > 1e-3)
    command, rates = chassis.inverse(twist), chassis.inverse_acceleration(twist, accel)
    found = chassis.forward_acceleration(command.speeds, rates.speeds, command.steer, rates.steer)
    np.testing.assert_allclose(found, accel, atol=1e-10 * chassis.condition)


@given(seeds, twists, twists)
def test_contact_acceleration_is_that_of_the_point_over_the_ground(chassis_of_seed, seed, twist, accel):
    """Against finite differences of the contact points' world velocity, which turns with the base."""
    chassis, h = chassis_of_seed(seed), 1e-6

    def world_velocity(time):
        vx, vy, omega = twist + time * accel
        heading = twist[2] * time
        body = np.array([[vx - omega * w.y, vy + omega * w.x] for w in chassis.wheels])
        return geometry.rotate(heading, body)

    expected = (world_velocity(h) - world_velocity(-h)) / (2 * h)
    np.testing.assert_allclose(chassis.inverse_acceleration(twist, accel).contact, expected, atol=1e-5)


def test_turning_in_place_pulls_towards_the_centre(bases):
    contact = bases["swerve4"].inverse_acceleration([0, 0, 2.0], [0, 0, 0]).contact
    places = np.array([[w.x, w.y] for w in bases["swerve4"].wheels])
    np.testing.assert_allclose(contact, -4.0 * places)


def test_a_module_at_rest_points_along_its_acceleration(bases):
    rates = bases["swerve4"].inverse_acceleration([0, 0, 0], [3.0, 4.0, 0.0])
    np.testing.assert_allclose(rates.speeds, 100.0)
    np.testing.assert_allclose(rates.steer, 0.0)


def test_batches_equal_single_calls(base):
    rng = np.random.default_rng(12)
    twist, accel = rng.normal(size=(7, 3)), rng.normal(size=(7, 3))
    batch = base.inverse_acceleration(twist, accel)
    for i in range(7):
        single = base.inverse_acceleration(twist[i], accel[i])
        for a, b in zip(batch, single, strict=True):
            np.testing.assert_allclose(a[i], b, atol=1e-12)
