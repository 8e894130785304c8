"""Driving by keys, without a terminal."""

import math

import numpy as np
import pytest

from holodrive.runtime.teleop import KeyTeleop, TeleopSettings, split_keys
from holodrive.types import Estimate, Observation, Pose, Reference, Twist, WheelState

NOTHING = Estimate(Pose(0, 0, 0), Twist(0, 0, 0), np.zeros((3, 3)))
WANTED = Reference(Pose(0, 0, 0))


def at(time):
    return Observation(time, 0.01, WheelState(np.zeros(3), np.zeros(3), np.zeros(0)))


def twists(script, times, settings=None):
    """The twist at each time, with `script` {time: keys} typed."""
    teleop = KeyTeleop(lambda: script.get(now, []), settings or TeleopSettings(speed_m_s=1.0, yaw_rate_rad_s=1.0))
    result = []
    for now in times:
        result.append(teleop.step(WANTED, NOTHING, at(now)))
    return result


@pytest.mark.parametrize(
    ("key", "twist"),
    [
        ("w", (1, 0, 0)),
        ("s", (-1, 0, 0)),
        ("a", (0, 1, 0)),
        ("d", (0, -1, 0)),
        ("q", (0, 0, 1)),
        ("\x1b[C", (0, -1, 0)),
    ],
)
def test_a_key_drives_in_its_direction(key, twist):
    assert twists({0.0: [key]}, [0.0])[0].command == twist


def test_a_key_that_is_let_go_stops_the_robot_by_itself():
    answers = twists({0.0: ["w"]}, [0.0, 0.5, 0.61])
    assert [a.command.vx for a in answers] == [1.0, 1.0, 0.0]


def test_keys_add_up_and_opposites_replace_each_other():
    assert twists({0.0: ["w", "a"]}, [0.0])[0].command == (1, 1, 0)
    assert twists({0.0: ["w"], 0.1: ["s"]}, [0.0, 0.1])[1].command == (-1, 0, 0)


def test_space_and_any_unknown_key_stop_at_once():
    for key in (" ", "k", "\x1b[5"):
        assert twists({0.0: ["w"], 0.1: [key]}, [0.0, 0.1])[1].command == (0, 0, 0)


def test_plus_and_minus_change_the_speed():
    factor = TeleopSettings().factor
    assert math.isclose(twists({0.0: ["+", "w"]}, [0.0])[0].command.vx, factor)


def test_x_ends():
    assert twists({0.0: ["x"]}, [0.0])[0].arrived


def test_what_a_terminal_sends_is_split_into_keys():
    assert split_keys("w\x1b[Aa\x1b") == ["w", "\x1b[A", "a", "\x1b"]
