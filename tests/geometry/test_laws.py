"""SE(2): group axioms, exp and log, stability near zero and at pi, against 50-digit arithmetic."""

import math

import mpmath as mp
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from holodrive import geometry as g
from holodrive.kinematics import kernel

mp.mp.dps = 50

coordinate = st.floats(-10.0, 10.0)
pose = st.tuples(coordinate, coordinate, st.floats(-math.pi, math.pi)).map(np.array)
twist = st.tuples(coordinate, coordinate, st.floats(-3.1, 3.1)).map(np.array)
ANGLES = [0.0, 1e-300, 1e-12, 1e-9, 1e-5, 9.99e-3, 1e-2, 1.001e-2, 0.3, 1.0, 3.0, 3.1415, math.pi]


def same(a, b, tolerance=1e-12):
    np.testing.assert_allclose(a, b, rtol=0.0, atol=tolerance)


def same_pose(a, b, tolerance=1e-12):
    same(a[..., :2], b[..., :2], tolerance)
    same(np.sin(0.5 * (a[..., 2] - b[..., 2])), 0.0, tolerance)


@given(pose, pose, pose)
def test_composition_is_associative(a, b, c):
    same(g.compose(g.compose(a, b), c), g.compose(a, g.compose(b, c)), 1e-13 * 40)


@given(pose)
def test_the_origin_is_neutral_and_inverses_cancel(a):
    same(g.compose(a, np.zeros(3)), a, 0.0)
    same(g.compose(np.zeros(3), a), a, 0.0)
    same(g.compose(a, g.inverse(a)), np.zeros(3), 1e-14 * 20)
    same(g.compose(g.inverse(a), a), np.zeros(3), 1e-14 * 20)


@given(pose, pose)
def test_between_is_what_compose_needs_to_get_there(a, b):
    same_pose(g.compose(a, g.between(a, b)), b, 1e-13)


@given(twist)
def test_log_undoes_exp(xi):
    same(g.log(g.exp(xi)), xi, 1e-12)


@given(pose)
def test_exp_undoes_log(a):
    same_pose(g.exp(g.log(a)), a, 1e-13)


@given(twist)
def test_half_the_twist_twice_is_the_whole(xi):
    half = g.exp(0.5 * xi)
    same(g.compose(half, half), g.exp(xi), 1e-13)


@given(pose, twist)
def test_the_adjoint_moves_a_twist_through_a_pose(a, xi):
    moved = g.compose(g.compose(a, g.exp(xi)), g.inverse(a))
    same_pose(g.exp(g.adjoint(a) @ xi), moved, 1e-12)


@pytest.mark.parametrize("omega", [sign * angle for angle in [*ANGLES, 10.0, 100.0] for sign in (1, -1)])
def test_exp_agrees_with_50_digits_at_every_size_of_angle(omega):
    vx, vy, w = mp.mpf(0.7), mp.mpf(-1.3), mp.mpf(omega)
    s = mp.sin(w) / w if w else mp.mpf(1)
    c = (1 - mp.cos(w)) / w if w else mp.mpf(0)
    got = g.exp([0.7, -1.3, omega])
    # relative to the length of the move; sin and cos of large angles are themselves rounded once
    assert abs(got[0] - (s * vx - c * vy)) < 4e-16 * 1.5
    assert abs(got[1] - (c * vx + s * vy)) < 4e-16 * 1.5
    assert got[2] == omega


@pytest.mark.parametrize("theta", [sign * angle for angle in ANGLES for sign in (1, -1)])
def test_log_agrees_with_50_digits_at_every_size_of_angle(theta):
    x, y = mp.mpf(0.7), mp.mpf(-1.3)
    t = mp.mpf(math.pi if theta == -math.pi else theta)
    half = t / 2 * mp.cot(t / 2) if t else mp.mpf(1)
    got = g.log([0.7, -1.3, theta])
    assert abs(got[0] - (half * x + t / 2 * y)) < 1e-15
    assert abs(got[1] - (half * y - t / 2 * x)) < 1e-15
    assert got[2] == t


@given(st.floats(-1e4, 1e4))
def test_wrap_gives_the_same_direction_in_half_open_range(angle):
    wrapped = float(g.wrap(angle))
    assert -math.pi < wrapped <= math.pi
    same([math.cos(wrapped), math.sin(wrapped)], [math.cos(angle), math.sin(angle)], 2e-12)


def test_minus_pi_and_plus_pi_are_plus_pi():
    assert g.wrap(-math.pi) == math.pi
    assert g.wrap(math.pi) == math.pi
    assert g.log([0.0, 0.0, -math.pi])[2] == math.pi


def near_turns():
    """The 40 floats around each multiple of pi up to 50 half turns, and large angles."""
    found = []
    for k in range(-50, 51):
        low = high = k * math.pi
        for _ in range(20):
            low, high = math.nextafter(low, -math.inf), math.nextafter(high, math.inf)
            found += [low, high]
    return np.array([*found, 1e9, -1e9, 1e15, -1e15, 1e300, -1e300])


@pytest.mark.parametrize("wrap", [g.wrap, np.vectorize(kernel.wrap)])
def test_wrap_never_leaves_its_range_by_a_last_digit(wrap):
    angles = near_turns()
    angles = angles if wrap is g.wrap else angles[np.abs(angles) < 1e6]
    wrapped = wrap(angles)
    assert np.all((wrapped > -math.pi) & (wrapped <= math.pi))


@pytest.mark.parametrize("wrap", [g.wrap, np.vectorize(kernel.wrap)])
@given(angle=st.floats(-math.pi, math.pi, exclude_min=True))
def test_wrap_leaves_an_angle_in_range_as_it_is_bit_for_bit(wrap, angle):
    assert float(wrap(angle)).hex() == angle.hex()


@pytest.mark.parametrize("wrap", [g.wrap, kernel.wrap])
def test_wrap_at_the_edges_of_its_range(wrap):
    assert wrap(-3.1415926535897927) == -3.1415926535897927
    assert wrap(math.nextafter(math.pi, 4.0)) == -3.1415926535897927
    assert wrap(-math.pi) == math.pi
    assert math.copysign(1.0, wrap(-0.0)) == -1.0
    assert math.isnan(wrap(math.nan))


def test_headings_count_turns():
    quarter = np.array([0.0, 0.0, math.pi / 2])
    turned = np.zeros(3)
    for _ in range(9):
        turned = g.compose(turned, quarter)
    assert turned[2] == pytest.approx(4.5 * math.pi)


def test_functions_take_any_leading_shape_and_agree_with_one_at_a_time():
    rng = np.random.default_rng(1)
    a, b = rng.normal(size=(4, 5, 3)), rng.normal(size=(5, 3))
    for function, arguments in (
        (g.compose, (a, b)),
        (g.between, (a, b)),
        (g.exp, (a,)),
        (g.log, (a,)),
        (g.inverse, (a,)),
    ):
        batch = function(*arguments)
        one = function(*(argument[(2, 3)] if argument.ndim == 3 else argument[3] for argument in arguments))
        same(batch[2, 3], one, 0.0)
    assert g.adjoint(a).shape == (4, 5, 3, 3)


def test_a_wrong_shape_is_named():
    with pytest.raises(ValueError, match=r"\(\.\.\., 3\)"):
        g.exp([1.0, 2.0])
