"""The pictures of the third paper, and what becomes of them when one thing is changed."""

import math
from dataclasses import replace

import numpy as np
import pytest

from holodrive import experiments
from holodrive.experiments import Setting
from holodrive.experiments.swerve import printed, robots, runs, search
from holodrive.experiments.swerve.runs import drive, there_and_back

SETTING = Setting(workers=2)


def test_turning_one_way_is_no_swing_and_a_wave_swings_by_twice_its_height():
    t = np.linspace(0.0, 10.0, 2001)[:, None]
    assert there_and_back(-150.0 * (1.0 - np.exp(-t))) == 0.0
    assert there_and_back(3.0 * np.sin(t)) == pytest.approx(6.0, rel=1e-4)
    assert there_and_back(np.hstack([t, np.exp(-((t - 5.0) ** 2))])) == pytest.approx(1.0)


@pytest.mark.parametrize("goal", runs.GOALS)
@pytest.mark.parametrize("setup", [robots.BLDC, robots.FOC, robots.AVERAGED], ids=lambda setup: setup.name)
def test_the_robot_with_bldc_motors_arrives_smoothly_however_they_are_fed(setup, goal):
    track = drive(setup, goal)
    assert 6.0 < track.arrival_s < 8.0
    assert track.swing_deg < 0.5
    assert track.end_rpm < 0.5
    assert track.heading_error_deg[-1] == pytest.approx(0.0, abs=0.5)


def test_its_fastest_wheel_turns_at_about_700_rpm():
    assert drive(robots.BLDC).peak_rpm == pytest.approx(printed.BLDC_PEAK_RPM, rel=0.05)


@pytest.mark.parametrize("goal", runs.GOALS)
def test_the_robot_with_dc_motors_of_2_7_henry_is_there_sooner_and_its_modules_swing(goal):
    track = drive(robots.DC_HENRY, goal)
    assert track.arrival_s < drive(robots.BLDC, goal).arrival_s - 1.0
    assert track.peak_rpm == pytest.approx(printed.DC_PEAK_RPM, rel=0.05)
    assert track.swing_deg > 20.0
    assert track.end_rpm > 5.0 * drive(robots.BLDC, goal).end_rpm


@pytest.mark.parametrize("goal", runs.GOALS)
def test_with_2_7_millihenry_a_setting_is_sooner_still_and_swings_nowhere(goal):
    track = drive(robots.DC_MILLI, goal)
    assert track.arrival_s < drive(robots.DC_HENRY, goal).arrival_s
    assert track.swing_deg < 0.5
    assert track.peak_rpm < 1.05 * printed.DC_PEAK_RPM


def test_under_the_bldc_robots_controller_and_limit_dc_motors_do_the_same():
    exchanged = drive(replace(robots.BLDC, motor=robots.DC_MILLI.motor))
    assert exchanged.arrival_s == pytest.approx(drive(robots.BLDC).arrival_s, rel=0.05)
    assert exchanged.steady
    assert not drive(replace(robots.BLDC, motor=robots.DC_HENRY.motor)).arrived


def test_the_grid_is_the_same_for_all_motors():
    grids = [[one.gains for one in search.settings(setup)] for setup in search.SEARCHED]
    assert grids[0] == grids[1] == grids[2]
    assert len(set(grids[0])) == math.prod(map(len, search.GRID)) == 180


@pytest.mark.parametrize("key", ["runs", "figure-6", "figure-7", "figure-8", "figure-9", "mass"])
def test_parts_make_their_pictures_and_tables(key):
    result = experiments.load("swerve").part(key).make(SETTING)
    assert result.claims
    assert all(section.html() for section in result.sections)


@pytest.mark.campaign
def test_few_settings_tame_2_7_henry_and_2_7_millihenry_is_as_easy_as_bldc():
    counts = {setup.name: len(search.searched(setup).steady) for setup in search.SEARCHED}
    assert counts[robots.DC_HENRY.name] <= 5
    assert counts[robots.DC_MILLI.name] >= 0.9 * counts[robots.AVERAGED.name] > 50
