"""Who runs the tasks: threads of this process, or the workers of a Dask cluster. Results come in the tasks' order."""

import os
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor, as_completed
from types import TracebackType
from typing import Protocol, Self

from holodrive.errors import InputError
from holodrive.tuning.task import Task, run_task
from holodrive.types import Array

Done = Callable[[int], None]  # called with the index of each task that has come back


class Backend(Protocol):
    """Somebody who runs tasks."""

    @property
    def slots(self) -> int:
        """How many tasks run at once."""
        ...

    def run(self, tasks: Sequence[Task], done: Done) -> list[Array]:
        """What `run_task` gives of each, in their order."""
        ...

    def __enter__(self) -> Self: ...

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None: ...


class Threads:
    """Threads of this process; each task holds one, and the compiled roll-out lets the others go on.

    Args:
        workers: how many; all cores when None.
    """

    def __init__(self, workers: int | None = None) -> None:
        if workers is not None and workers < 1:
            raise InputError(f"a sweep takes 1 or more threads; found {workers}")
        self.slots = workers or cores()

    def run(self, tasks: Sequence[Task], done: Done) -> list[Array]:
        """What `run_task` gives of each, in their order."""
        if self.slots == 1 or len(tasks) == 1:
            return [self._one(task, index, done) for index, task in enumerate(tasks)]
        with ThreadPoolExecutor(min(self.slots, len(tasks))) as pool:
            futures = {pool.submit(run_task, task): index for index, task in enumerate(tasks)}
            try:
                for future in as_completed(futures):
                    future.result()
                    done(futures[future])
            except BaseException:  # Ctrl-C too: what has not begun shall not begin
                pool.shutdown(wait=False, cancel_futures=True)
                raise
            return [future.result() for future in futures]

    def _one(self, task: Task, index: int, done: Done) -> Array:
        result = run_task(task)
        done(index)
        return result

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        return None


class Open:
    """A backend that stays open when a sweep is done with it: for several sweeps on one cluster."""

    def __init__(self, runner: Backend) -> None:
        self.slots, self._runner = runner.slots, runner

    def run(self, tasks: Sequence[Task], done: Done) -> list[Array]:
        """What `run_task` gives of each, in their order."""
        return self._runner.run(tasks, done)

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        return None


def backend_of(what: "Backend | str | int | None") -> Backend:
    """Threads (None: all cores; a number of them), a cluster by its scheduler's address, or a backend as it is."""
    if isinstance(what, str):
        from holodrive.tuning.cluster import Cluster

        return Cluster(what)
    return Threads(what) if what is None or isinstance(what, int) else what


def cores() -> int:
    """That this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
