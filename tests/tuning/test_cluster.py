"""A Dask cluster gives the numbers that threads give; what can be wrong with it is told in one line."""

import builtins
import os
import signal
from collections.abc import Iterator
from typing import Any

import numpy as np
import pytest

from holodrive.errors import InputError, MissingExtra
from holodrive.tuning import Job, Problem, cluster, sweep, tune
from holodrive.tuning.cluster import Cluster

distributed = pytest.importorskip("distributed")


@pytest.fixture(scope="module")
def workers() -> Iterator[Any]:
    """Two worker processes on this machine."""
    options = {"n_workers": 2, "threads_per_worker": 1, "processes": True, "dashboard_address": "127.0.0.1:0"}
    with distributed.LocalCluster(**options, host="127.0.0.1", silence_logs=50) as local:
        yield local


def test_equal_bit_for_bit(workers: Any, courses: Job) -> None:
    """Several cuts, in two processes and in this one; progress comes as they are done."""
    seen: list[int] = []
    here = sweep(courses, 1)
    there = sweep(courses, workers.scheduler_address, block=3, progress=lambda done, total: seen.append(done))
    assert np.array_equal(here.values, there.values, equal_nan=True)
    assert seen == sorted(seen)
    assert seen[-1] == 20


def test_tuning_agrees_too(workers: Any, problem: Problem) -> None:
    """The search asks the same questions and gets the same answers."""
    small: dict[str, Any] = {
        "budget": 28, "runs": 2, "validation_seeds": range(20_000, 20_002), "heldout_seeds": range(30_000, 30_004)
    }  # fmt: skip
    assert tune(problem, **small, backend=workers.scheduler_address).to_json() == tune(problem, **small).to_json()


def test_workers_with_other_sources_are_refused(workers: Any, courses: Job, monkeypatch: pytest.MonkeyPatch) -> None:
    """Before any task is sent."""
    monkeypatch.setattr(cluster, "_ours", lambda: "9.9.9 (ffff), numba 0, numpy 0")
    with pytest.raises(InputError, match=r"worker tcp://.* runs .*, this process 9\.9\.9"):
        sweep(courses, workers.scheduler_address)


def test_a_worker_that_dies_is_no_loss(workers: Any, courses: Job) -> None:
    """Its tasks run again elsewhere, with the same numbers."""
    here = sweep(courses, 1)
    with Cluster(workers.scheduler_address) as runner:
        pids = list(runner.client.run(os.getpid).values())
        killed: list[int] = []

        def kill(done: int, total: int) -> None:
            if not killed:
                killed.append(pids[0])
                os.kill(pids[0], signal.SIGKILL)

        there = sweep(courses, runner, block=1, progress=kill)
    assert killed
    assert np.array_equal(here.values, there.values, equal_nan=True)


def test_nobody_there(courses: Job, monkeypatch: pytest.MonkeyPatch) -> None:
    """One line after a short time, with what to do."""
    monkeypatch.setattr(cluster, "TIMEOUT_S", 0.3)
    with pytest.raises(InputError, match=r"no Dask scheduler answers at 'tcp://127\.0\.0\.1:9'.*dask scheduler"):
        sweep(courses, "tcp://127.0.0.1:9")
    with pytest.raises(InputError, match="no address of a Dask scheduler"):
        sweep(courses, "not an address")


def test_without_distributed(courses: Job, monkeypatch: pytest.MonkeyPatch) -> None:
    """It is an extra."""
    real = builtins.__import__

    def without(name: str, *rest: Any, **more: Any) -> Any:
        if name == "distributed":
            raise ImportError(name)
        return real(name, *rest, **more)

    monkeypatch.setattr(builtins, "__import__", without)
    with pytest.raises(MissingExtra, match=r"holodrive\[cluster\]"):
        sweep(courses, "tcp://127.0.0.1:9")
