"""What the wheels can do: scaling keeps direction, corners are corners, the binding wheel is at its limit."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from holodrive.errors import ChassisError, CommandError
from holodrive.kinematics import Chassis, Wheel
from holodrive.kinematics.discretise import discretise
from holodrive.kinematics.limits import desaturate, loads
from holodrive.kinematics.pose_update import exact

seeds = st.integers(0, 2**32 - 1)
twists = st.tuples(st.floats(-5, 5), st.floats(-5, 5), st.floats(-20, 20)).map(np.array)


@given(seeds, twists)
def test_saturation_keeps_direction_fits_and_wastes_nothing(chassis_of_seed, seed, twist):
    chassis = chassis_of_seed(seed)
    applied = chassis.saturate(twist)
    np.testing.assert_allclose(applied.twist, applied.scale * twist, rtol=1e-15)
    load = loads(chassis, applied.twist)
    assert load.max() <= 1.0 + 1e-14
    if applied.scale < 1.0:
        assert load[chassis.names.index(applied.binding)] == pytest.approx(1.0, abs=1e-13)
    else:
        assert applied.binding == ""


def test_saturation_of_a_batch_is_that_of_its_twists(base):
    twist = np.random.default_rng(4).normal(size=(6, 5, 3))
    batch = base.saturate(twist)
    assert batch.scale.shape == batch.binding.shape == (6, 5)
    for index in np.ndindex(6, 5):
        single = base.saturate(twist[index])
        np.testing.assert_allclose(batch.twist[index], single.twist, rtol=1e-15)
        assert batch.binding[index] == single.binding


@given(seeds, st.floats(-math.pi, math.pi), st.floats(-1.5, 1.5))
def test_max_speed_is_on_the_edge_of_the_possible(chassis_of_seed, seed, direction, turn):
    """A little more is impossible; where it is NaN no speed that way is possible."""
    chassis = chassis_of_seed(seed)
    omega = turn * chassis.polytope.turn_in_place
    speed = float(chassis.max_speed(direction, omega))

    def possible(value):
        return loads(chassis, [value * math.cos(direction), value * math.sin(direction), omega]).max()

    if math.isnan(speed):
        assert min(possible(value) for value in np.linspace(0.0, 20.0, 400)) > 1.0
    else:
        assert possible(speed) == pytest.approx(1.0, abs=1e-9)
        assert possible(speed * (1.0 + 1e-6) + 1e-9) > 1.0


def test_the_polytope_of_fixed_wheels_has_exact_corners(bases):
    """Three limits are met at each corner, and no possible twist lies outside their hull."""
    from scipy.spatial import ConvexHull

    for name in ("hybrid3", "omni3", "omni4", "mecanum4"):
        chassis = bases[name]
        corners = chassis.polytope.vertices
        load = loads(chassis, corners)
        assert np.all(load <= 1.0 + 1e-9)
        assert np.all(np.sum(load > 1.0 - 1e-9, axis=1) >= 3)
        np.testing.assert_allclose(sorted(map(tuple, np.round(corners, 9))), sorted(map(tuple, np.round(-corners, 9))))
        hull = ConvexHull(corners)
        rng = np.random.default_rng(5)
        edge = chassis.saturate(1e3 * rng.normal(size=(500, 3))).twist
        assert np.max(hull.equations @ np.append(edge, np.ones((500, 1)), axis=1).T) < 1e-9


def test_a_corner_of_n_equal_rates_is_a_parallelepiped_for_three_wheels(bases):
    corners = bases["hybrid3"].polytope
    assert len(corners.vertices) == 8
    wheel = 2.0 * 22.0 * 2.0 * math.pi / 60.0
    assert corners.volume == pytest.approx(wheel**3 / abs(np.linalg.det(bases["hybrid3"].jacobian)))


@given(seeds, st.floats(-1.2, 1.2))
def test_sections_hold_exactly_the_possible_translations(chassis_of_seed, seed, turn):
    chassis = chassis_of_seed(seed)
    omega = turn * chassis.polytope.turn_in_place
    section = chassis.polytope.section(omega)
    if len(section) == 0:
        assert abs(turn) > 1.0
        return
    corners = np.column_stack([section, np.full(len(section), omega)])
    assert loads(chassis, corners).max() <= 1.0 + 1e-8
    if len(section) > 2 and not chassis.steered:
        middle = section.mean(axis=0)
        outside = middle + (section - middle) * (1.0 + 1e-6)
        assert np.all(loads(chassis, np.column_stack([outside, np.full(len(section), omega)])).max(axis=1) > 1.0)


def test_the_hybrid_at_22_rpm_is_as_fast_as_computed_from_the_paper(bases):
    """22 RPM through eq. 16 of the first paper: slowest at 15 deg, fastest at 245 deg."""
    chassis = bases["hybrid3"]
    assert float(chassis.max_speed(0.0)) == pytest.approx(0.0860, abs=1e-4)
    assert float(chassis.max_speed(math.pi / 2)) == pytest.approx(0.1175, abs=1e-4)
    slowest, at = chassis.polytope.slowest
    assert (slowest, math.degrees(at)) == pytest.approx((0.0831, 15.0), abs=1e-4)
    fastest, at = chassis.polytope.fastest
    assert (fastest, math.degrees(at)) == pytest.approx((0.1293, 65.0), abs=0.2)
    assert chassis.polytope.turn_in_place == pytest.approx(0.511, abs=5e-4)


def test_slowest_and_fastest_bound_all_directions(base):
    angles = np.linspace(-math.pi, math.pi, 721)
    speeds = base.max_speed(angles)
    assert speeds.min() >= base.polytope.slowest[0] - 1e-12
    assert speeds.max() <= base.polytope.fastest[0] * (1.0 + 1e-3 * bool(base.steered)) + 1e-12
    assert float(base.max_speed(base.polytope.slowest[1])) == pytest.approx(base.polytope.slowest[0])


def test_without_limits_speeds_are_infinite_and_the_polytope_says_what_is_missing():
    chassis = Chassis({"a": Wheel.swerve(0.2, 0.0, 0.05), "b": Wheel.swerve(-0.2, 0.0, 0.05)})
    assert chassis.max_speed(0.3) == math.inf
    assert chassis.saturate([1e9, 0.0, 0.0]).scale == 1.0
    with pytest.raises(ChassisError, match="wheel 'a' has no max_speed"):
        chassis.polytope.section()


def test_desaturation_is_common_to_all_wheels():
    np.testing.assert_allclose(desaturate([5, 6, 4, 7], 5.5), np.array([5, 6, 4, 7]) * 5.5 / 7)
    np.testing.assert_allclose(desaturate([[1.0, 8.0], [0.0, 0.0]], [2.0, 4.0]), [[0.5, 4.0], [0.0, 0.0]])


@given(twists, st.floats(1e-3, 0.1))
def test_discretised_twist_ends_where_the_straight_line_does(twist, dt):
    end = exact(np.zeros(3), discretise(twist, dt), dt)
    np.testing.assert_allclose(end, twist * dt, rtol=0.0, atol=1e-14)


def test_discretise_refuses_what_no_twist_can_do():
    with pytest.raises(CommandError, match="full turn"):
        discretise([1.0, 0.0, 100.0], 0.1)
    with pytest.raises(CommandError, match="greater than 0"):
        discretise([1.0, 0.0, 1.0], 0.0)
