"""What tuning makes small."""

import numpy as np
import pytest

from holodrive.errors import InputError, UnknownName
from holodrive.tuning import Job, Objective, Sweep
from holodrive.tuning.objective import WORST
from holodrive.tuning.task import COLUMNS


def runs(job: Job, **metrics: float) -> Sweep:
    """One run of one variant that went as said."""
    values = {"time_s": 2.0, "path_length_m": 3.0, "straight_m": 3.0, "min_clearance_m": 0.2} | metrics
    return Sweep(job, np.array([[[values.get(name, 0.0) for name in COLUMNS]]]))


def cost(job: Job, **metrics: float) -> float:
    return float(Objective.parse("success").costs(runs(job, **metrics))[0, 0])


def test_arrival_comes_before_speed_and_no_collision_before_arrival(courses: Job) -> None:
    """The worst arrival costs less than the best run that does not arrive, and that less than the best collision."""
    slow = cost(courses, arrived=1.0, time_s=4.0, path_length_m=90.0, min_clearance_m=0.0)
    near = cost(courses, final_error_m=0.01)
    hit = cost(courses, arrived=1.0, moved_collisions=1.0)
    far_and_hit = cost(courses, final_error_m=5.0, moved_collisions=1.0)
    assert cost(courses, arrived=1.0) < slow <= 0.9 < 1.0 < near < cost(courses, final_error_m=2.0) <= 2.0 <= hit
    assert hit < far_and_hit == cost(courses, final_error_m=5.0, fault=1.0)


@pytest.mark.parametrize(
    ("better", "worse"),
    [({"time_s": 1.0}, {"time_s": 3.0}), ({"path_length_m": 3.1}, {"path_length_m": 3.5}),
     ({"min_clearance_m": 0.08}, {"min_clearance_m": 0.02})],
)  # fmt: skip
def test_among_arrivals_each_virtue_counts(courses: Job, better: dict[str, float], worse: dict[str, float]) -> None:
    assert cost(courses, arrived=1.0, **better) < cost(courses, arrived=1.0, **worse)


def test_being_run_into_is_no_fault(courses: Job) -> None:
    """Only collisions in which the robot moved count."""
    assert cost(courses, arrived=1.0, collisions=1.0) == cost(courses, arrived=1.0)


def test_metrics_add_up_and_more_of_a_good_thing_is_less(courses: Job) -> None:
    """`a + 0.5*b` is that sum; clearance has a minus."""
    found = runs(courses, rms_error_m=0.2, energy_j=4.0, min_clearance_m=0.3)
    assert Objective.parse("rms_error_m + 0.5*energy_j").costs(found)[0, 0] == pytest.approx(2.2)
    assert Objective.parse("min_clearance_m").costs(found)[0, 0] == pytest.approx(-0.3)


def test_runs_that_went_wrong_cost_most(courses: Job) -> None:
    """A fault, a collision, a metric that is not finite."""
    objective = Objective.parse("rms_error_m+time_s")
    for wrong in ({"fault": 1.0}, {"moved_collisions": 2.0}, {"rms_error_m": np.inf}):
        both = Sweep(courses, np.concatenate([runs(courses).values, runs(courses, **wrong).values], axis=1))
        assert objective.costs(both)[0].tolist() == [2.0, WORST]


def test_a_metric_of_which_nothing_is_known_is_refused(courses: Job) -> None:
    """Energy is not known on the plant without currents."""
    with pytest.raises(InputError, match=r"energy_j is not known .*first_order"):
        Objective.parse("energy_j").costs(runs(courses, energy_j=np.nan))


@pytest.mark.parametrize("text", ["", "+", "0*time_s", "-1*time_s", "time_s - 3", "nan*time_s", "1.2.3*time_s"])
def test_texts_that_cannot_be_read(text: str) -> None:
    with pytest.raises(InputError, match="metric to tune for"):
        Objective.parse(text)


def test_an_unknown_metric_is_told_the_near_one() -> None:
    with pytest.raises(UnknownName, match="Did you mean 'rms_error_m'"):
        Objective.parse("rms_eror_m")
