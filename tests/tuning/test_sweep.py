"""A sweep's numbers depend on the job, and on nothing about how it was run."""

from dataclasses import replace

import numpy as np
import pytest

import holodrive as hd
from holodrive import worlds
from holodrive.errors import InputError, UnknownName
from holodrive.tuning import Job, Places, Sweep, Threads, job, sweep
from holodrive.tuning.task import COLUMNS, Task, run_task


@pytest.fixture(scope="module")
def reference(courses: Job) -> Sweep:
    return sweep(courses, 1)


def equal(a: Sweep, b: Sweep) -> bool:
    return np.array_equal(a.values, b.values, equal_nan=True)


@pytest.mark.parametrize(("threads", "block"), [(1, 1), (2, 3), (3, None), (2, 64)])
def test_equal_for_any_threads_and_any_cut(courses: Job, reference: Sweep, threads: int, block: int | None) -> None:
    """Bit for bit."""
    assert equal(sweep(courses, threads, block=block), reference)


def test_a_run_is_the_same_alone(courses: Job, reference: Sweep) -> None:
    """Number 10007 of the second variant, on its own."""
    alone = sweep(replace(courses, variants=courses.variants[1:]).over(range(10_007, 10_008)))
    assert np.array_equal(alone.values[0, 0], reference.values[1, 7], equal_nan=True)


def test_equal_to_the_roll_out(courses: Job, reference: Sweep) -> None:
    """A sweep is `hd.rollout` of the same worlds, keyed by the same numbers."""
    places = [worlds.course(number) for number in courses.numbers]
    direct = hd.rollout("hybrid3_table_x", places, "go_to_pose", n=10, first=10_000, t=4.0, stop_on_arrival=True)
    for name, values in direct.metrics.items():
        assert np.array_equal(reference[name][0], values, equal_nan=True), name


def test_variants_meet_the_same_noise(courses: Job) -> None:
    """Equal variants have equal outcomes; unequal ones do not."""
    twice = sweep(replace(courses, variants=({"k_xy": 2.0}, {"k_xy": 2.0}, {"k_xy": 0.5})))
    assert np.array_equal(twice.values[0], twice.values[1], equal_nan=True)
    assert not np.array_equal(twice.values[0], twice.values[2], equal_nan=True)


def test_a_list_of_worlds_goes_round() -> None:
    """Run k takes place in world k modulo their number; noise differs all the same."""
    both = [worlds.course(3), worlds.course(4)]
    found = sweep(job("hybrid3_table_x", both, "go_to_pose", count=4, t=2.0))
    assert found["straight_m"][0].tolist() == found["straight_m"][0, [0, 1, 0, 1]].tolist()
    assert found["final_error_m"][0, 0] != found["final_error_m"][0, 2]


def test_a_job_survives_json(courses: Job, circle: Job) -> None:
    """It goes to another machine as text."""
    for one in (courses, circle):
        assert Job.from_json(one.to_json()) == one


def test_progress_ends_with_all_runs(courses: Job) -> None:
    """It only grows."""
    seen: list[tuple[int, int]] = []
    sweep(courses, 2, block=4, progress=lambda done, total: seen.append((done, total)))
    assert seen == sorted(seen)
    assert seen[-1] == (20, 20)


def test_ctrl_c_leaves_a_sweep(courses: Job) -> None:
    """What has not begun does not begin."""

    def stop(done: int, total: int) -> None:
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        sweep(courses, 2, block=1, progress=stop)


def test_a_task_of_other_sources_is_refused(courses: Job) -> None:
    """Workers with another version would mix their numbers with ours."""
    with pytest.raises(InputError, match="install the same on both"):
        run_task(Task(courses.to_json(), "0.0.1"))


def test_bad_jobs_are_refused_before_anything_runs(courses: Job) -> None:
    """One clear line each."""
    for change, words in (
        ({"count": 0}, "1 or more runs"),
        ({"variants": ()}, "1 or more variants"),
        ({"t": float("nan")}, "t > 0"),
        ({"dt": 0.0}, "dt"),
    ):
        with pytest.raises(InputError, match=words):
            replace(courses, **change)
    with pytest.raises(InputError, match=r"no parameter 'k_yx'.*k_xy"):
        sweep(replace(courses, variants=({"k_yx": 1.0},)))
    with pytest.raises(UnknownName, match="generator"):
        Places("corse")
    with pytest.raises(InputError, match="one of them"):
        Places()
    with pytest.raises(InputError, match="crossers"):
        Places("generate", crossers=2)
    with pytest.raises(InputError, match="no goal"):
        job("hybrid3", "open", "pid")
    with pytest.raises(InputError, match="not both"):
        job("hybrid3", "open", "pid", goal=(1, 1, 0), reference={"kind": "goal", "pose": [0, 0, 0]})
    with pytest.raises(InputError, match="1 or more threads"):
        Threads(0)
    with pytest.raises(InputError, match="block=0"):
        sweep(courses, block=0)
    for text in ("[]", "{", '{"robots": 1}'):
        with pytest.raises(InputError, match="job"):
            Job.from_json(text)
    with pytest.raises(UnknownName, match="rms_error_m"):
        Sweep(courses, np.zeros((2, 10, len(COLUMNS))))["rms_eror_m"]
