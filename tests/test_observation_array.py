"""Claims about packing an observation into the flat vector."""

import numpy as np
import pytest

from holodrive import layout
from holodrive.errors import InputError
from holodrive.observation_array import empty_observation, fill_observation
from holodrive.types import Estimate, Observation, Pose, Reference, Scan, Twist, WheelState

WHEELS = WheelState(np.array([1.0, 2.0, 3.0]), np.array([4.0, 5.0, 6.0]), np.array([0.5]))


def test_every_value_is_found_at_its_index() -> None:
    scan = Scan(1.9, np.linspace(0.0, -1.0, 5), np.arange(5.0), np.linspace(-0.4, 0.0, 5))
    observation = Observation(2.0, 0.01, WHEELS, 0.3, np.array([0.1, 0.2]), np.array([[7.0, 8.0]]), scan, True)
    estimate = Estimate(Pose(1, 2, 3), Twist(4, 5, 6), np.eye(3), 0.0)
    out = empty_observation(5)
    fill_observation(out, observation, estimate, Reference(Pose(9, 8, 7), last=False))
    assert (out[layout.TIME], out[layout.DT], out[layout.GYRO], out[layout.REF_LAST]) == (2.0, 0.01, 0.3, 0.0)
    np.testing.assert_array_equal(out[layout.POSE : layout.POSE + 6], [1, 2, 3, 4, 5, 6])
    np.testing.assert_array_equal(out[layout.REF_POSE : layout.REF_POSE + 9], [9, 8, 7, 0, 0, 0, 0, 0, 0])
    np.testing.assert_array_equal(out[layout.WHEEL_POSITION : layout.WHEEL_POSITION + 3], [1, 2, 3])
    np.testing.assert_array_equal(out[layout.WHEEL_SPEED : layout.WHEEL_SPEED + 3], [4, 5, 6])
    assert (out[layout.N_WHEELS], out[layout.N_STEER], out[layout.STEER], out[layout.N_MICE], out[layout.N_BEAMS]) == (
        3,
        1,
        0.5,
        1,
        5,
    )
    np.testing.assert_array_equal(out[layout.MICE : layout.MICE + 2], [7, 8])
    np.testing.assert_allclose([out[layout.BEAM_STEP], out[layout.BEAM_PERIOD]], [-0.25, 0.1])
    np.testing.assert_array_equal(out[layout.BEAMS :], np.arange(5.0))


def test_what_is_not_known_is_nan_and_not_left_from_before() -> None:
    out = empty_observation(4)
    scan = Scan(1.0, np.zeros(4), np.ones(4), np.zeros(4))
    fill_observation(out, Observation(0.0, 0.01, WHEELS, 1.0, np.ones(2), np.ones((1, 2)), scan, True))
    fill_observation(out, Observation(0.0, 0.01, WHEELS))
    assert np.isnan(
        out[
            [
                layout.GYRO,
                layout.ACCEL,
                layout.ACCEL + 1,
                layout.SCAN_TIME,
                layout.POSE,
                layout.REF_POSE,
                layout.REF_LAST,
            ]
        ]
    ).all()
    assert (out[layout.N_BEAMS], out[layout.N_MICE], out[layout.SCAN_IS_NEW]) == (0.0, 0.0, 0.0)


def test_the_step_between_beams_survives_the_wrap_of_the_angle() -> None:
    out = empty_observation(2)
    scan = Scan(0.0, np.array([np.pi, -np.pi + 0.1]), np.ones(2), np.zeros(2))
    fill_observation(out, Observation(0.0, 0.01, WHEELS, scan=scan))
    assert out[layout.BEAM_STEP] == pytest.approx(0.1)


def test_too_many_beams_are_refused_in_one_line() -> None:
    scan = Scan(0.0, np.zeros(3), np.ones(3), np.zeros(3))
    with pytest.raises(InputError, match="3 beams, the observation has room for 2"):
        fill_observation(empty_observation(2), Observation(0.0, 0.01, WHEELS, scan=scan))
