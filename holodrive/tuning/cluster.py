"""An existing Dask cluster as a backend: tasks go out as text, rows of numbers come back."""

import asyncio
import re
from collections.abc import Sequence
from types import TracebackType
from typing import Any, Self

from holodrive.errors import HolodriveError, InputError, MissingExtra
from holodrive.tuning.backends import Done
from holodrive.tuning.task import Task, sources, told
from holodrive.types import Array

TIMEOUT_S = 5.0  # for a scheduler to answer, and for a worker to be there
RETRIES = 3  # of a task whose worker has died

_ADDRESS = re.compile(r"(\w+://)?[^\s/]+:\d+")


class Cluster:
    """The workers of a Dask scheduler; every one of them runs the same sources as this process, or is refused.

    Args:
        address: of the scheduler, "tcp://host:8786".
        timeout_s: for it to answer; `TIMEOUT_S` when None.

    Attributes:
        client: of Dask, for whoever wants more of it.

    Raises:
        MissingExtra: `distributed` is not installed.
        InputError: nobody answers, no workers are there, or one runs other sources.
    """

    def __init__(self, address: str, timeout_s: float | None = None) -> None:
        timeout_s = TIMEOUT_S if timeout_s is None else timeout_s
        try:
            import distributed
        except ImportError as error:
            raise MissingExtra("--cluster", "distributed", "cluster") from error
        self._distributed: Any = distributed
        self.address = address
        self.client = self._connected(address, timeout_s)
        try:
            self.client.wait_for_workers(1, timeout=timeout_s)
            self.slots = sum(self.client.nthreads().values())
            self._check_sources()
        except TimeoutError as error:
            self.client.close()
            raise InputError(
                f"the Dask scheduler at {address} has no workers; start some: dask worker {address}"
            ) from error
        except BaseException:
            self.client.close()
            raise

    def run(self, tasks: Sequence[Task], done: Done) -> list[Array]:
        """What `run_task` gives of each, in their order; a task whose worker dies is run by another one."""
        futures = [self.client.submit(told, task, pure=False, retries=RETRIES) for task in tasks]
        index_of = {future.key: index for index, future in enumerate(futures)}
        rows: list[Array | None] = [None] * len(tasks)
        try:
            for future, answer in self._distributed.as_completed(futures, loop=self.client.loop, with_results=True):
                if isinstance(answer, str):
                    raise InputError(f"the cluster at {self.address} refuses a task: {answer}")
                rows[index_of[future.key]] = answer
                done(index_of[future.key])
        except (self._distributed.KilledWorker, asyncio.CancelledError, OSError) as error:
            raise HolodriveError(f"the cluster at {self.address} was lost: {str(error).splitlines()[0]}") from error
        finally:
            self.client.cancel([future for future in futures if not future.done()])
        return [row for row in rows if row is not None]

    def _connected(self, address: str, timeout_s: float) -> Any:
        if not _ADDRESS.fullmatch(address):  # a client that is refused its address leaves a trace behind
            raise InputError(f"{address!r} is no address of a Dask scheduler; such as tcp://host:8786")
        try:
            return self._distributed.Client(address, timeout=timeout_s, set_as_default=False)
        except (OSError, TimeoutError, ValueError) as error:
            raise InputError(
                f"no Dask scheduler answers at {address!r} within {timeout_s:g} s; "
                "start one with `dask scheduler` and give its address, such as tcp://host:8786"
            ) from error

    def _check_sources(self) -> None:
        found = self.client.run(sources, on_error="return")
        for worker, answer in found.items():
            if isinstance(answer, BaseException):
                raise InputError(f"worker {worker} cannot run holodrive: {answer}; install {_ours()} on it")
            if answer != _ours():
                raise InputError(f"worker {worker} runs {answer}, this process {_ours()}; install the same on both")

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.client.close()


def _ours() -> str:
    return sources()
