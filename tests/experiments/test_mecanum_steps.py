"""Figures 4, 5 and 7 of the second paper: the printed cubics, found again from steps of actuators that follow them."""

import numpy as np
import pytest

from holodrive.experiments import Setting
from holodrive.experiments.mecanum import actuators, printed, steps
from holodrive.reports.page import report


@pytest.mark.parametrize("name", list(printed.CUBICS))
def test_a_cubic_fitted_to_simulated_steps_is_the_printed_one_within_2_percent_of_full_scale(name):
    claim = next(c for c in steps.figure_7(Setting()).claims if c.where == printed.EQUATIONS[name])
    assert claim.verdict == "agrees"
    one = steps.fit_of(steps.calibration(), name)
    top = actuators.speed_at(name, 255.0)
    ours = [actuators.speed_at(name, pwm) for pwm in one.pwm]
    assert np.max(np.abs(1e3 * one.speed_m_s - ours)) < 0.02 * top


def test_equation_8_reads_a_step_slower_than_its_tail_by_the_lag():
    one = steps.fit_of(steps.calibration(), "W2W3_B")
    fast = one.speed_m_s > 0.01
    short = 1.0 - one.speed_eq8_m_s[fast] / one.speed_m_s[fast]
    assert np.all((short > 0.02) & (short < 0.06))  # lag of 50 ms in steps of 1.5 s
    claim = next(c for c in steps.figure_5(Setting()).claims if c.where == "Eq. 8")
    assert claim.ours == pytest.approx(1e3 * one.speed_eq8_m_s[-1])


def test_what_is_simulated_from_the_printed_numbers_is_not_called_agreement_with_them():
    for figure in (steps.figure_4, steps.figure_5):
        assert not [c for c in figure(Setting()).claims if c.verdict == "agrees"]


def test_all_three_figures_have_one_chart_for_each_actuation():
    for figure in (steps.figure_4, steps.figure_5, steps.figure_7):
        section = figure(Setting()).sections[0]
        assert len(section.charts) == 4
        assert report(section).html.count('class="chart"') == 4
