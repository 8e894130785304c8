"""Keep to the wall clock: absolute deadlines, so that a late tick does not delay all that follow."""

import time
from collections.abc import Callable


class RealTime:
    """Call with the time of the next tick [s since start]; sleeps until then and counts what came late.

    Args:
        speed: how much faster than the wall clock.
        clock, sleep: injected for tests.
    """

    def __init__(
        self,
        speed: float = 1.0,
        clock: Callable[[], float] = time.monotonic,
        sleep: Callable[[float], None] = time.sleep,
    ) -> None:
        self._speed, self._clock, self._sleep = speed, clock, sleep
        self._start: float | None = None
        self.late = 0
        self.worst_s = 0.0

    def __call__(self, time_s: float) -> None:
        """Wait for `time_s`."""
        if self._start is None:
            self._start = self._clock() - time_s / self._speed
        wait = self._start + time_s / self._speed - self._clock()
        if wait > 0.0:
            self._sleep(wait)
        elif wait < 0.0:
            self.late += 1
            self.worst_s = max(self.worst_s, -wait)
