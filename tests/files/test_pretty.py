"""Faults in the form of a compiler's."""

import pytest

from holodrive import robots
from holodrive.errors import Fault, FileFaults
from holodrive.files import errors_text, fault_text

BAD = """schema = 1
[robot]
name = "bad"
mass = "5 kg"
[wheel.front]
kind = "omnni"
radius = "51 kg"
yaw = "90 deg"
gama = "-45 deg"
motor = "jgb37-545b-22rpm"
at = { x = "20 cm", y = 0 }
"""

SHOWN = """error: kind 'omnni' is not known; choose omni, mecanum or swerve
  --> bad.toml:6:8
   6 | kind = "omnni"
     |        ^^^^^^^
     = did you mean 'omni'?

error: '51 kg' is not a length; write a number in m or text such as "23 cm"
  --> bad.toml:7:10
   7 | radius = "51 kg"
     |          ^^^^^^^

error: unknown key 'gama' in [wheel.front]
  --> bad.toml:9:1
   9 | gama = "-45 deg"
     | ^^^^
     = known: kind, at, yaw, roller, radius, width, motor, encoder, steering, inverted, max_speed

3 problems in bad.toml; nothing was run."""


def test_all_faults_are_printed_with_their_line_and_a_mark():
    with pytest.raises(FileFaults) as error:
        robots.parse(BAD, "bad.toml")
    assert errors_text(error.value) == SHOWN


def test_a_fault_of_an_override_shows_the_override():
    with pytest.raises(FileFaults) as error:
        robots.load("omni3", {"wheel.front.radius": "51 kg"})
    assert errors_text(error.value).split("\n")[1:3] == [
        "  --> --set wheel.front.radius",
        "     | wheel.front.radius=51 kg",
    ]


def test_a_fault_of_a_whole_file_has_two_lines():
    assert fault_text(Fault("x.toml", 0, "there is no such file")) == "error: there is no such file\n  --> x.toml"


def test_tabs_do_not_move_the_mark():
    shown = fault_text(Fault("x.toml", 1, "wrong", column=2, source="\tradius = 1")).split("\n")
    assert shown[3].index("^") == shown[2].index("r")
