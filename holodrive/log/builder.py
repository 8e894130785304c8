"""A run kept in memory: the recorder's face without a file."""

from collections.abc import Mapping
from typing import Any

import numpy as np

from holodrive.log.rows import columns_of, run_of_rows
from holodrive.log.run import Run, Tick
from holodrive.robots.spec import Robot
from holodrive.types import Event, Scan
from holodrive.worlds.spec import World

_ROWS_AT_FIRST = 1024


class RunBuilder:
    """Collects ticks, scans and events, and makes a `Run` of them.

    Args:
        robot, world, settings: as the `Run` shall tell them.
        keep_scans: False drops the scans, which are most of a long run's memory.
    """

    def __init__(
        self, robot: Robot, world: World | None, settings: Mapping[str, Any], *, keep_scans: bool = True
    ) -> None:
        self._robot, self._world, self._settings = robot, world, dict(settings)
        self._columns = columns_of(robot)
        self._rows = np.empty((_ROWS_AT_FIRST, self._columns.size))
        self._count = 0
        self._keep_scans = keep_scans
        self._scans: list[Scan] = []
        self._events: list[Event] = []

    def tick(self, tick: Tick) -> None:
        """Take one control tick; the values are copied."""
        if self._count == len(self._rows):
            self._rows = np.concatenate([self._rows, np.empty_like(self._rows)])
        self._columns.fill(self._rows[self._count], tick)
        self._count += 1

    def scan(self, scan: Scan) -> None:
        """Take a scan."""
        if self._keep_scans:
            self._scans.append(scan)

    def event(self, event: Event) -> None:
        """Take an event."""
        self._events.append(event)

    def build(self, metrics: Mapping[str, float] | None = None) -> Run:
        """All that was taken up to now."""
        return run_of_rows(
            self._rows[: self._count].copy(),
            self._robot,
            self._world,
            self._settings,
            scans=self._scans,
            events=self._events,
            metrics=metrics,
        )
