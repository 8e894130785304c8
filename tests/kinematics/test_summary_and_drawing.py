"""What people are told and shown about a base."""

import json
import xml.etree.ElementTree as ET

import pytest

from holodrive import robots
from holodrive.kinematics import Chassis, Wheel, drawing, summary

CATALOG = ["hybrid3", "omni3", "mecanum4", "swerve3", "swerve4", "omni4"]


@pytest.mark.parametrize("name", CATALOG)
def test_the_summary_is_json_and_names_every_wheel(name):
    robot = robots.load(name)
    data = json.loads(json.dumps(summary.as_dict(robot), allow_nan=False))
    assert data["name"] == name
    assert data["rank"] == 3
    text = summary.as_text(robot)
    for wheel in robot.wheels:
        assert wheel.name in text
    assert "condition" in text
    assert "slowest direction" in text


def test_the_hybrids_text_tells_what_binds(bases):
    text = summary.as_text(bases["hybrid3"])
    assert "condition  4.54" in text
    assert "none to spare" in text
    ahead = next(line for line in text.splitlines() if "ahead" in line)
    assert ahead.endswith("bound by right, left")


def test_top_speeds_are_possible_and_bound_by_wheels_at_their_limit(base):
    for top in summary.summarise(base).top_speeds:
        assert top.binding
        assert base.saturate(top.twist).scale == pytest.approx(1.0)


def test_without_limits_there_are_no_top_speeds():
    chassis = Chassis([Wheel.swerve(0.2, 0.0, 0.05), Wheel.swerve(-0.2, 0.0, 0.05)])
    assert summary.summarise(chassis).top_speeds == ()
    assert "no top speeds" in summary.as_text(chassis)


def test_latex_has_one_row_for_each_equation(bases):
    text = summary.latex(bases["mixed"])
    assert text.count(r"\begin{bmatrix}") == 3
    assert r"\omega_{\mathrm{omni}}" in text
    assert r"v_{\mathrm{swerve},\perp}" in text


@pytest.mark.parametrize("name", CATALOG)
def test_drawings_are_well_formed_and_name_every_wheel(name):
    robot = robots.load(name)
    picture = ET.fromstring(drawing.chassis_svg(robot))
    words = "".join(picture.itertext())
    for wheel in robot.wheels:
        assert wheel.name in words
    ET.fromstring(drawing.polytope_svg(robot))


def test_hostile_names_do_not_break_the_picture(bases):
    wheels = {f"<{name}&\"'>": wheel for name, wheel in zip("abc", bases["hybrid3"].wheels, strict=True)}
    assert "<a&" not in drawing.chassis_svg(Chassis(wheels))
    ET.fromstring(drawing.chassis_svg(Chassis(wheels)))


def test_the_speed_outline_has_one_line_for_each_yaw_rate(bases):
    picture = drawing.polytope_svg(bases["swerve4"], omegas=(0.0, 1.0, 2.0, 3.0))
    assert picture.count("<polygon") >= 4
    assert "omega = 3 rad/s" in picture
