"""Charts of open-loop steps, from plain arrays."""

import numpy as np

from holodrive.reports.steps import NAMED, crosses, fit_chart, response_chart, speed_chart

TIME = np.linspace(0.0, 1.5, 101)


def test_displacements_have_a_line_a_step_and_names_for_some() -> None:
    """By PWM, in mm."""
    pwm = [float(p) for p in range(45, 255, 10)]
    chart = response_chart("W1W4 forward", pwm, [TIME] * len(pwm), [1e-3 * p * TIME for p in pwm])
    assert len(chart.lines) == len(pwm)
    named = [line.name for line in chart.lines if line.name]
    assert len(named) == NAMED
    assert named[0] == "PWM 45"
    assert named[-1] == "PWM 245"
    assert chart.lines[0].y[-1] == 45 * 1.5
    assert "Displacement, W1W4 forward" in chart.svg()


def test_speeds_have_a_line_a_group_and_direction() -> None:
    """In mm/s over counts."""
    chart = speed_chart([("a", np.array([50.0, 255.0]), np.array([0.0, 0.04])), ("b", np.zeros(2), np.zeros(2))])
    assert [line.name for line in chart.lines] == ["a", "b"]
    assert chart.lines[0].y[-1] == 40.0
    assert chart.x_unit == "counts"


def test_measured_points_are_crosses_with_gaps() -> None:
    """Each about its point, and small."""
    x, y = crosses(np.array([0.0, 10.0]), np.array([0.0, 100.0]))
    assert len(x) == len(y) == 12
    assert np.isnan(x).sum() == 4
    np.testing.assert_allclose(np.nanmean(x.reshape(2, 6), axis=1), [0.0, 10.0], atol=1e-12)
    assert np.nanmax(np.abs(y.reshape(2, 6) - [[0.0], [100.0]])) < 3.0


def test_curves_stand_beside_what_was_measured() -> None:
    """PWM over speed."""
    v = np.linspace(0.0, 0.04, 5)
    chart = fit_chart("W1W4 forward", 50.0 + 5e3 * v, v, [("found", 50.0 + 5e3 * v, v), ("before", 60.0 + v, v)])
    assert [line.name for line in chart.lines] == ["found", "before", "measured"]
    assert "from 50 to" in chart.described() or "from 4" in chart.described()
    assert chart.svg().startswith("<svg")
