"""What the simulated Mecanum robot does on the paper's paths."""

import numpy as np
import pytest

from holodrive.experiments import Setting
from holodrive.experiments.mecanum import comparison, complex_paths, monte_carlo, paths, straight, tracking


def test_all_straight_paths_are_kept_within_a_centimetre_and_cosine_gains_stray_less():
    printed, cosine = (straight.runs(v).figures()["distance_max_m"] for v in (tracking.PRINTED, tracking.COSINE))
    assert len(printed) == 128
    assert printed.max() < 0.01
    assert np.median(cosine) < 0.3 * np.median(printed)


@pytest.mark.parametrize("path", complex_paths.shapes().values(), ids=["eight", "infinity"])
def test_cosine_gains_lower_the_largest_distance_on_a_complex_path_by_a_third(path):
    printed, cosine = (
        complex_paths.runs(v, path).figures()["distance_max_m"] for v in (tracking.PRINTED, tracking.COSINE)
    )
    assert printed.max() < 0.01
    assert np.median(1.0 - cosine / printed) > 0.3


def test_an_observer_has_a_fifth_of_the_error_and_of_the_distance_of_la_g_as_printed():
    path = paths.straight(61.875)
    printed, better = (
        tracking.batch(v, [path] * 4).figures() for v in (tracking.PRINTED, tracking.Variant("dob", controller="dob"))
    )
    for name in ("error_iae_m_s", "distance_iae_m_s"):
        assert 5.0 * np.median(better[name]) < np.median(printed[name])


def test_one_factor_for_both_pairs_keeps_a_step_on_its_line_and_clipping_does_not():
    rows = {row["tracker"]: row["distance_max_m"] for row in straight.steps(Setting()).data["rows"]}
    assert rows[tracking.PRINTED.name] < 0.006 < 0.015 < rows[tracking.CLIPPED.name]


def test_la_g_that_believes_the_printed_recursion_does_not_move():
    claim = complex_paths.literal()
    assert claim.ours == "0 mm"
    assert claim.verdict == "cannot be"


def test_a_run_in_the_loop_has_the_figures_of_the_batch():
    """The two engines draw the same noise for the same number, so that one check covers both."""
    path = paths.straight(22.5)
    run = comparison.driven(tracking.PRINTED, path, seed=3)
    one = tracking.batch(tracking.PRINTED, [path], seed=3).figures()
    assert comparison.figures(run, path)["error_iae_m_s"] == pytest.approx(one["error_iae_m_s"][0], rel=1e-6)


def test_robots_of_the_monte_carlo_are_numbered_and_within_their_ranges():
    draws = [monte_carlo.Draw.number(k) for k in range(50)]
    assert draws[7] == monte_carlo.Draw.number(7) != draws[8]
    for draw in draws:
        assert 0.02 <= draw.dead_time_s <= 0.08
        assert 10.2 <= draw.voltage_v <= 14.2
        assert draw.period_s in (0.012, 0.015, 0.018)
        assert draw.robot().control_period_s == draw.period_s


def test_paths_leave_in_the_direction_opposite_to_their_angle():
    """Angles are the paper's: from target to start, counter-clockwise from the robot's right."""
    end = paths.straight(0.0).rows[-1, 1:3]
    np.testing.assert_allclose(end, (0.0, paths.LENGTH_M), atol=1e-12)  # to the left: y in our frame
    end = paths.straight(264.375).rows[-1, 1:3]
    assert end[0] > 0.99 * paths.LENGTH_M  # ahead
