"""Each metric against a path whose value is plain."""

import math
from itertools import pairwise

import numpy as np
import pytest

from holodrive import metrics

GOAL = (2.0, 0.0, 0.0)


def told(time, pose, reference=None, **more):
    pose = np.asarray(pose, dtype=float)
    reference = np.tile(GOAL, (len(pose), 1)) if reference is None else reference
    return metrics.of_arrays(time, pose, reference, **more)


def polyline(*corners, step=0.001):
    """Poses along straight lines between corners."""
    points = [np.array(corners[0], dtype=float)]
    for a, b in pairwise(np.array(corners, dtype=float)):
        count = round(np.linalg.norm(b - a) / step)
        points += [a + (b - a) * k / count for k in range(1, count + 1)]
    return np.column_stack([np.array(points), np.zeros(len(points))])


def test_a_straight_run_to_the_goal():
    time = np.linspace(0.0, 10.0, 1001)
    pose = np.column_stack([0.2 * time, np.zeros(1001), np.full(1001, 0.3)])
    out = told(time, pose, arrived=True, collisions=3, moved_collisions=1, energy_j=5.0, clearance_m=[0.4, 0.2, 0.3])
    assert out["arrived"] == 1.0
    assert out["time_s"] == pytest.approx(10.0)
    assert out["path_length_m"] == pytest.approx(2.0)
    assert out["mean_speed_m_s"] == pytest.approx(0.2)
    assert out["turns"] == 0
    assert out["iae_m_s"] == pytest.approx(10.0)  # 2 m going to 0 in 10 s
    assert out["ise_m2_s"] == pytest.approx(40.0 / 3.0, rel=1e-5)
    assert out["rms_error_m"] == pytest.approx(2.0 / math.sqrt(3.0), rel=1e-5)
    assert out["max_error_m"] == pytest.approx(2.0)
    assert out["final_error_m"] == pytest.approx(0.0, abs=1e-12)
    assert out["final_heading_error_rad"] == pytest.approx(0.3)
    assert (out["collisions"], out["moved_collisions"], out["energy_j"]) == (3.0, 1.0, 5.0)
    assert out["min_clearance_m"] == 0.2
    assert list(out) == list(metrics.NAMES)


def test_heading_error_goes_the_short_way_round():
    out = told([0.0, 1.0], [(0.0, 0.0, 0.0), (0.0, 0.0, 2.0 * math.pi - 0.1)])
    assert out["final_heading_error_rad"] == pytest.approx(0.1)


@pytest.mark.parametrize(
    ("corners", "turns"),
    [
        (((0, 0), (1, 0)), 0),
        (((0, 0), (1, 0), (2, 0.1)), 0),  # 5.7 degrees
        (((0, 0), (1, 0), (1, 1)), 1),
        (((0, 0), (1, 0), (1, 1), (0, 1)), 2),
        (((0, 0), (1, 0), (2, 1), (3, 0), (4, 1)), 3),
        (((0, 0), (1, 0), (0, 0)), 1),
    ],
)
def test_turns_are_the_corners_of_a_polyline_above_ten_degrees(corners, turns):
    pose = polyline(*corners)
    assert told(np.arange(len(pose)) * 0.01, pose)["turns"] == turns


def test_a_whole_circle_is_one_turn_and_an_eight_two():
    t = np.linspace(0.0, 2.0 * np.pi, 2000)
    circle = np.column_stack([np.cos(t), np.sin(t), t])
    eight = np.column_stack([np.sin(t), np.sin(2.0 * t), t])
    assert told(t, circle)["turns"] == 1
    assert told(t, eight)["turns"] in (2, 3)  # starts in the middle of a bend or of the crossing


def test_turns_do_not_depend_on_how_often_the_path_is_sampled():
    for step in (0.0005, 0.001, 0.004):
        pose = polyline((0, 0), (1, 0), (2, 1), (3, 0), step=step)
        assert told(np.arange(len(pose)), pose)["turns"] == 2


def test_saturation_counts_ticks_with_a_full_duty_among_those_with_a_duty():
    duty = np.array([[0.1, 1.0], [0.2, 0.3], [math.nan, math.nan], [-1.0, -1.0]])
    out = told(np.arange(4.0), np.zeros((4, 3)), duty=duty)
    assert out["saturated_share"] == pytest.approx(2.0 / 3.0)


def test_what_is_not_known_is_nan():
    out = told([0.0, 1.0], np.zeros((2, 3)))
    assert math.isnan(out["energy_j"])
    assert math.isnan(out["saturated_share"])
    assert out["min_clearance_m"] == math.inf


def test_ticks_without_a_pose_are_left_out():
    pose = np.array([(0.0, 0.0, 0.0), (math.nan,) * 3, (1.0, 0.0, 0.0)])
    assert told([0.0, 1.0, 2.0], pose)["path_length_m"] == pytest.approx(1.0)


def test_a_run_of_one_tick_has_numbers():
    out = told([3.0], [(1.0, 0.0, 0.0)])
    assert (out["time_s"], out["path_length_m"], out["mean_speed_m_s"], out["rms_error_m"]) == (0.0, 0.0, 0.0, 1.0)
