"""Two runs side by side, number by number: is the second what the first was?"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from holodrive.log.run import Run
from holodrive.types import Array, Scan

CHANNELS = (
    *("time", "pose", "estimate", "covariance", "reference", "twist", "decided"),
    *("wheel_commands", "wheel_speeds", "steer_commands", "steer", "duty", "slip"),
)
SENSORS = ("gyro", "accel", "mice", "motors")


@dataclass(frozen=True, slots=True)
class Difference:
    """How one channel of two runs differs.

    Attributes:
        channel: name of the array in `Run`, "scans" or "events".
        count: ticks (scans, events) that differ or have no partner.
        max_abs: largest difference of a number, in the channel's unit; infinite where one is NaN and the other not.
        first_time: of the first difference [s].
        text: for people.
    """

    channel: str
    count: int
    max_abs: float
    first_time: float
    text: str


def compare(a: Run, b: Run) -> tuple[Difference, ...]:
    """What differs between two runs, bit for bit; nothing for equal ones. NaN equals NaN.

    Scans are compared as the log keeps them, in float32 and with stamps to a microsecond. A sensor is compared where
    both runs have it at all: older logs know no IMU, no mice and no motors.
    """
    found = [_arrays(name, a, b) for name in CHANNELS]
    found += [_arrays(name, a, b) for name in SENSORS if _known(name, a) and _known(name, b)]
    found += [_scans(a.scans, b.scans), _events(a, b)]
    return tuple(difference for difference in found if difference is not None)


def _known(name: str, run: Run) -> bool:
    return not bool(np.isnan(getattr(run, name)).all())


def _arrays(name: str, a: Run, b: Run) -> Difference | None:
    first, second = getattr(a, name), getattr(b, name)
    if first.shape[1:] != second.shape[1:]:
        text = f"{name}: {first.shape[1:]} numbers a tick against {second.shape[1:]}"
        return Difference(name, max(len(first), len(second)), np.inf, 0.0, text)
    ticks = min(len(first), len(second))
    odd = max(len(first), len(second)) - ticks
    differs = ~((first[:ticks] == second[:ticks]) | (np.isnan(first[:ticks]) & np.isnan(second[:ticks])))
    rows = np.flatnonzero(differs.any(axis=tuple(range(1, differs.ndim))))
    if not len(rows) and not odd:
        return None
    longer = a.time if len(a.time) > len(b.time) else b.time
    time = float(a.time[rows[0]]) if len(rows) else float(longer[ticks])
    max_abs = _largest(first[:ticks][differs], second[:ticks][differs])
    parts = [f"{len(rows)} of {ticks} ticks differ by up to {max_abs:.3g}"] if len(rows) else []
    parts += [f"{odd} ticks have no partner"] if odd else []
    return Difference(name, len(rows) + odd, max_abs, time, f"{name}: {', '.join(parts)}, first at {time:.3f} s")


def _largest(first: Array, second: Array) -> float:
    if not len(first):
        return 0.0
    with np.errstate(invalid="ignore"):
        gap = np.abs(first - second)
    return float(np.where(np.isnan(gap), np.inf, gap).max())


def _scans(a: Sequence[Scan], b: Sequence[Scan]) -> Difference | None:
    scans = min(len(a), len(b))
    odd = max(len(a), len(b)) - scans
    gaps = [_scan_gap(one, other) for one, other in zip(a[:scans], b[:scans], strict=True)]
    bad = [i for i, gap in enumerate(gaps) if gap > 0.0]
    if not bad and not odd:
        return None
    time = a[bad[0]].stamp if bad else (a if len(a) > len(b) else b)[scans].stamp
    max_abs = max((gap for gap in gaps if np.isfinite(gap)), default=0.0) if bad else 0.0
    text = f"scans: {len(bad)} of {scans} differ by up to {max_abs:.3g} m, {odd} have no partner, first at {time:.3f} s"
    return Difference("scans", len(bad) + odd, max_abs, time, text)


def _scan_gap(a: Scan, b: Scan) -> float:
    """Largest difference of a range [m] as float32; infinite for different beams or stamps."""
    if a.ranges.shape != b.ranges.shape or abs(a.stamp - b.stamp) > 1e-6:
        return np.inf
    first, second = a.ranges.astype(np.float32), b.ranges.astype(np.float32)
    differs = ~((first == second) | (np.isnan(first) & np.isnan(second)))
    return _largest(first[differs].astype(np.float64), second[differs].astype(np.float64))


def _events(a: Run, b: Run) -> Difference | None:
    events = min(len(a.events), len(b.events))
    odd = max(len(a.events), len(b.events)) - events
    bad = [
        i
        for i, (one, other) in enumerate(zip(a.events[:events], b.events[:events], strict=True))
        if (one.time, one.kind, one.text) != (other.time, other.kind, other.text)
    ]
    if not bad and not odd:
        return None
    time = (a.events if len(a.events) > len(b.events) or bad else b.events)[bad[0] if bad else events].time
    text = f"events: {len(bad)} of {events} differ, {odd} have no partner, first at {time:.3f} s"
    return Difference("events", len(bad) + odd, np.inf if bad else 0.0, time, text)
