"""Small jobs that everything about tuning is tried with."""

from dataclasses import replace

import pytest

from holodrive import planning
from holodrive.tuning import Job, Objective, Problem, job, parse_range, space


@pytest.fixture(scope="session")
def courses() -> Job:
    """Two variants in random worlds, half a minute short of any goal."""
    return job("hybrid3_table_x", "course", "go_to_pose", variants=({}, {"k_xy": 3.0}), first=10_000, count=10, t=4.0)


@pytest.fixture(scope="session")
def circle() -> Job:
    """A circle driven fast enough that gains matter; the start is off the path."""
    path = planning.follow(planning.circle(0.3, (-0.3, 0.0)), 0.3)
    return job(
        "hybrid3_table_x", "open", "pid", reference=path.recipe, params={"ki": 0.0}, start=(0.1, -0.1, 0.3), t=5.0
    )


@pytest.fixture
def problem(circle: Job) -> Problem:
    """The PID's gains on the circle, from a poor start."""
    poor = replace(circle, params={"kp": 0.4, "ki": 0.0, "kd": 0.0})
    ranges = [parse_range("kp=0.2:10:log"), parse_range("kp_theta=0.2:10:log"), parse_range("kd=0:0.3")]
    return Problem(poor, space("pid", ranges=ranges), Objective.parse("rms_error_m"))
