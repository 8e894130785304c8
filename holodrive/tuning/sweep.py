"""A job's runs, all of them: cut into tasks, given to a backend, put together in order."""

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from holodrive.errors import InputError, UnknownName
from holodrive.tuning.backends import Backend, backend_of
from holodrive.tuning.job import Job
from holodrive.tuning.task import COLUMNS, Task, sources
from holodrive.types import Array

LARGEST_BLOCK = 64  # runs of one task
TASKS_A_SLOT = 4  # so that all end at about the same time

Progress = Callable[[int, int], None]  # runs that are done, runs in all


@dataclass(frozen=True)
class Sweep:
    """What became of a job.

    Attributes:
        job: that ran.
        values: (variants, runs, columns), columns as `task.COLUMNS`.
    """

    job: Job
    values: Array

    @cached_property
    def metrics(self) -> dict[str, Array]:
        """name -> (variants, runs): those of `holodrive.metrics`, `fault` and `straight_m`."""
        return {name: self.values[:, :, k] for k, name in enumerate(COLUMNS)}

    def __getitem__(self, name: str) -> Array:
        """(variants, runs) one metric.

        Raises:
            UnknownName: no such metric.
        """
        if name not in self.metrics:
            raise UnknownName("metric", name, COLUMNS)
        return self.metrics[name]

    @property
    def succeeded(self) -> Array:
        """(variants, runs) bool: arrived, and touched nothing while it moved itself."""
        return np.asarray((self["arrived"] == 1.0) & (self["moved_collisions"] == 0.0) & (self["fault"] == 0.0))


def sweep(
    job: Job,
    backend: Backend | str | int | None = None,
    *,
    block: int | None = None,
    progress: Progress | None = None,
) -> Sweep:
    """Run every variant of a job under all its numbers.

    The numbers that come out are the same, bit for bit, for any number of threads, any `block` and any number of
    worker processes with equal sources on equal processors.

    Args:
        job: what to run.
        backend: None for all cores here, a number of threads, the address of a Dask scheduler ("tcp://host:8786"),
            or a backend that is open already.
        block: runs of one task; chosen by the number of cores when None.
        progress: called with the runs that are done and those in all.

    Raises:
        InputError: the job cannot be, or the cluster does not answer or runs other sources.
    """
    if block is not None and block < 1:
        raise InputError(f"a task takes 1 or more runs; found block={block}")
    job.check()
    total = len(job.variants) * job.count
    finished = 0
    with backend_of(backend) as runner:
        size = block or max(1, min(LARGEST_BLOCK, math.ceil(total / (TASKS_A_SLOT * runner.slots))))
        pieces = [
            replace(job, variants=(variant,), first=first, count=min(size, job.first + job.count - first))
            for variant in job.variants
            for first in range(job.first, job.first + job.count, size)
        ]

        def done(index: int) -> None:
            nonlocal finished
            finished += pieces[index].count
            if progress:
                progress(finished, total)

        rows = runner.run([Task(piece.to_json(), sources()) for piece in pieces], done)
    return Sweep(job, np.concatenate(rows).reshape(len(job.variants), job.count, len(COLUMNS)))
