"""Choosing a motion among things that move: played out, it stays clear of them."""

import math

import numpy as np
import pytest

from holodrive.control import foresight as fs

R, MARGIN, HORIZON, SPEED = 0.23, 0.1, 4.0, 0.28
NOTHING = np.zeros(0)


def chosen_among(movers, wish, points=()):
    rows = np.array([(*mover, math.inf) for mover in movers], dtype=np.float64).ravel()
    points = np.array(points, dtype=np.float64).reshape(-1, 2)
    xs, ys = np.ascontiguousarray(points[:, 0]), np.ascontiguousarray(points[:, 1])
    out = np.zeros(2)
    angle = math.atan2(wish[1], wish[0])
    fs.evade(*wish, 0.0, 0.0, xs, ys, len(xs), rows, len(movers), R, MARGIN, 0.045, HORIZON, SPEED, angle, fs.WAYS, out)
    return out, rows


def gap_after(velocity, mover, until=HORIZON):
    t = np.linspace(0.0, until, 200)
    x = mover[0] + t * mover[2] - t * velocity[0]
    y = mover[1] + t * mover[3] - t * velocity[1]
    return np.min(np.hypot(x, y)) - R - mover[4]


def test_a_wish_that_meets_nobody_is_left_alone():
    out, _ = chosen_among([(2.0, 1.0, -0.1, 0.0, 0.15)], (0.0, -0.2))
    assert tuple(out) == (0.0, -0.2)


@pytest.mark.parametrize("mover", [(0.9, 0.5, -0.25, 0.0, 0.15), (-0.9, 0.6, 0.25, 0.0, 0.15)])
def test_who_would_meet_a_crosser_on_the_way_does_something_else(mover):
    wish = (0.0, 0.2)
    assert gap_after(wish, mover) < MARGIN
    out, _ = chosen_among([mover], wish)
    assert tuple(out) != wish
    assert gap_after(out, mover, 1.0) > 0.0


def test_one_that_stands_in_somebodys_way_goes_out_of_it():
    mover = (1.0, 0.05, -0.25, 0.0, 0.15)
    out, _ = chosen_among([mover], (1e-6, 0.0))
    assert math.hypot(*out) == pytest.approx(SPEED)
    assert abs(out[1]) > 0.2


def test_it_does_not_evade_into_what_stands():
    """A wall close below and to the left: out of the crosser's way there is up only."""
    wall = [(x, -0.3) for x in np.linspace(-1.0, 1.0, 41)] + [(-0.3, y) for y in np.linspace(-0.3, 1.0, 27)]
    out, _ = chosen_among([(1.2, -0.05, -0.25, 0.0, 0.15)], (1e-6, 0.0), wall)
    assert out[1] > 0.1


def test_a_touch_that_cannot_be_helped_is_met_standing():
    cage = [(0.28 * math.cos(a), 0.28 * math.sin(a)) for a in np.linspace(0.5, 2 * math.pi - 0.5, 60)]
    out, _ = chosen_among([(0.43, 0.0, -0.3, 0.0, 0.15)], (0.2, 0.0), cage)
    assert tuple(out) == (0.0, 0.0)


def test_who_may_turn_back_counts_on_both_ways():
    """Behind one that comes to a wall in a second, it is not clear."""
    row = np.array([1.0, 0.0, 0.3, 0.0, 0.15, 1.0])
    near, _, _ = fs.play(0.0, 0.0, 0.0, 0.0, 0.0, row, 1, R, MARGIN, HORIZON)
    assert near < HORIZON
    row[5] = math.inf
    assert fs.play(0.0, 0.0, 0.0, 0.0, 0.0, row, 1, R, MARGIN, HORIZON)[0] == HORIZON
