"""What is found wrong in the first paper, found by computing."""

import numpy as np
import pytest

from holodrive.experiments import Setting
from holodrive.experiments.hybrid import equations, printed
from holodrive.experiments.hybrid.course import table_ix

SETTING = Setting(worlds=4, seeds=1)


def test_equation_19_agrees_and_equation_23_has_two_wrong_signs():
    result = equations.equations(SETTING)
    by_where = {}
    for claim in result.claims:
        by_where.setdefault(claim.where, []).append(claim)
    assert len(by_where["Eq. 19"]) == 8
    off = [claim.what for claim in by_where["Eq. 19"] if claim.verdict != "agrees"]
    assert off == ["wheel 1 per omega", "wheel 2 per omega", "wheel 3 per omega"]  # 4.52 needs 23.05 cm
    wrong = [claim.what for claim in by_where["Eq. 23"] if claim.verdict == "contradicts itself"]
    assert wrong == ["vx per wheel 3", "vy per wheel 3"]
    assert not np.allclose(np.linalg.inv(printed.EQ_19), printed.EQ_23, atol=1e-2)


def test_the_printed_wheel_radius_does_not_give_the_printed_equation():
    claim = next(c for c in equations.equations(SETTING).claims if c.what == "wheel radius")
    assert claim.ours == pytest.approx(5.1, abs=1e-9)
    assert claim.printed == 5.0


def test_the_printed_motor_cannot_drive_the_printed_path_in_the_printed_time():
    claim = next(c for c in equations.equations(SETTING).claims if c.where == "Tables II, X")
    assert claim.verdict == "cannot be"
    assert claim.ours < 0.5 * claim.printed


def test_the_shipped_course_is_the_printed_one_and_its_goal_lies_in_obstacle_4():
    claims = table_ix(SETTING).claims
    assert [c.verdict for c in claims[:4]] == ["agrees"] * 4
    assert next(c for c in claims if "end point" in c.what).ours == "0 cm"
