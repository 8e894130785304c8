"""A run kept in memory: the recorder's face without a file."""

import math
from collections.abc import Mapping
from copy import deepcopy
from typing import TYPE_CHECKING, Any

import numpy as np

from holodrive.log.rows import columns_of, run_of_rows
from holodrive.log.run import Run, Tick
from holodrive.robots.spec import Robot
from holodrive.types import Event, Scan
from holodrive.worlds.spec import World

if TYPE_CHECKING:
    from holodrive.metrics import Tally

_ROWS_AT_FIRST = 1024


class RunBuilder:
    """Collects ticks, scans and events, and makes a `Run` of them.

    Args:
        robot, world, settings: as the `Run` shall tell them.
        keep_scans: False drops the scans, which are most of a long run's memory.
        keep_ticks: at least so many of the newest ticks stay, with the scans and events of their time; all when None.
            Metrics count all ticks in either case.
    """

    def __init__(
        self,
        robot: Robot,
        world: World | None,
        settings: Mapping[str, Any],
        *,
        keep_scans: bool = True,
        keep_ticks: int | None = None,
    ) -> None:
        self._robot, self._world, self._settings = robot, world, dict(settings)
        self._columns = columns_of(robot)
        self._rows = np.empty((_ROWS_AT_FIRST, self._columns.size))
        self._count = 0
        self._keep_ticks = keep_ticks
        self._tally: Tally | None = None
        self._keep_scans = keep_scans
        self._scans: list[Scan] = []
        self._events: list[Event] = []

    def tick(self, tick: Tick) -> None:
        """Take one control tick; the values are copied."""
        if self._keep_ticks is not None and self._count >= 2 * self._keep_ticks:
            self._drop(self._count - self._keep_ticks)
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

    def metrics(self, energy_j: float = math.nan) -> dict[str, float]:
        """Metrics of all ticks up to now, dropped ones included."""
        tally = deepcopy(self._tally) if self._tally else self._new_tally()
        tally.add(self.build())
        return tally.result(energy_j)

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

    def _drop(self, count: int) -> None:
        """Let the oldest ticks, their scans and events go, counted."""
        self._tally = self._tally or self._new_tally()
        cut = float(self._rows[count, self._columns.at["time"]][0])
        old = [event for event in self._events if event.time < cut]
        self._events = [event for event in self._events if event.time >= cut]
        self._scans = [scan for scan in self._scans if scan.stamp >= cut]
        piece = run_of_rows(self._rows[:count].copy(), self._robot, self._world, self._settings, scans=(), events=old)
        self._tally.add(piece)
        self._rows[: self._count - count] = self._rows[count : self._count]
        self._count -= count

    def _new_tally(self) -> "Tally":
        from holodrive.metrics import Tally  # with Numba, which reading a log does not need

        return Tally(self._world, self._robot.footprint_radius_m)
