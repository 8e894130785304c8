"""What an experiment is: parts (a table, a figure, a benchmark) that can be made one by one."""

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

from holodrive.errors import UnknownName
from holodrive.experiments.claims import Claim
from holodrive.reports.sections import Section

Progress = Callable[[str], None]


def _silent(text: str) -> None:
    """Nobody listens."""


@dataclass(frozen=True)
class Setting:
    """How much to compute.

    Attributes:
        worlds: random worlds of each benchmark that has them.
        seeds: noise seeds of each run that is repeated.
        first_seed: of the random worlds; from 100000 on none was looked at while designing.
        workers: threads; all cores when None.
        cluster: address of a Dask scheduler that shall do the roll-outs; None for this machine.
        tell: called with a line on what is being done.
    """

    worlds: int = 300
    seeds: int = 3
    first_seed: int = 100_000
    workers: int | None = None
    cluster: str | None = None
    tell: Progress = _silent


@dataclass(frozen=True)
class Result:
    """What a part found.

    Attributes:
        claims: printed values beside ours.
        sections: pictures and tables for the report.
        data: the numbers, JSON-able.
    """

    claims: tuple[Claim, ...] = ()
    sections: tuple[Section, ...] = ()
    data: dict[str, Any] = field(default_factory=dict)


@dataclass(frozen=True)
class Part:
    """One table, figure or benchmark of an experiment.

    Attributes:
        key: how it is asked for, such as "table-x" or "a3".
        title: one line.
        make: computes it.
    """

    key: str
    title: str
    make: Callable[[Setting], Result]


@dataclass(frozen=True)
class Experiment:
    """A paper, or a benchmark, to reproduce.

    Attributes:
        name: as `holodrive reproduce NAME`.
        title: of the paper.
        lead: two or three sentences for the head of the report.
        parts: in reading order.
    """

    name: str
    title: str
    lead: str
    parts: tuple[Part, ...]

    def part(self, key: str) -> Part:
        """One part by its key.

        Raises:
            UnknownName: no such part.
        """
        for part in self.parts:
            if part.key == key:
                return part
        raise UnknownName(f"part of {self.name}", key, [part.key for part in self.parts])
