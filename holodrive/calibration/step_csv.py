"""Steps as a CSV file: one row a sample, columns group, direction, pwm, time, x, y.

Units stand in the header (`x_mm`, `time [ms]`); without one they are SI. The rows of a step stand together, and its
first row is the moment of the command. A step that is repeated at once is told apart by a column `run`.
Columns that are not known are left alone.
"""

import csv
import io
import math
import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from holodrive.calibration.groups import BACKWARD, FORWARD, Group
from holodrive.calibration.separators import separated
from holodrive.calibration.step_record import StepRecord
from holodrive.calibration.step_response import MOVED_COUNTS
from holodrive.errors import Fault, FileFaults
from holodrive.files.source import read as read_text
from holodrive.types import Array

NEEDED = ("group", "direction", "pwm", "time", "x", "y")
UNITS = {
    "time": {"s": 1.0, "ms": 1e-3, "us": 1e-6},
    "x": {"m": 1.0, "cm": 1e-2, "mm": 1e-3, "um": 1e-6},
    "y": {"m": 1.0, "cm": 1e-2, "mm": 1e-3, "um": 1e-6},
}
_DIRECTIONS = {
    "forward": FORWARD, "f": FORWARD, "+": FORWARD, "+1": FORWARD, "1": FORWARD,
    "backward": BACKWARD, "b": BACKWARD, "-": BACKWARD, "-1": BACKWARD,
}  # fmt: skip
_HEADER = re.compile(r"([a-z]+)(?:_([a-z]+)|\s*[\[(]\s*([a-zµ]+)\s*[\])])?")
LARGEST = 64 * 2**20  # bytes
MOST_FAULTS = 20
_FLAT = 0.2  # of a step's samples: a reading that stands so long at the end while the PWM is on has stopped telling
_FLAT_SAMPLES = 5
_STRONGER = 0.05  # of full PWM above one that moved: a step that stands there has a loose wire, no dead zone
_FAR_COUNTS = 50.0  # of the sensor: a step that goes so far tells its direction
_SIGNED = 0.1  # of the longest displacement: one so far below 0 tells a file with signs from one of amounts
_BESIDE = math.cos(math.radians(30.0))  # a dead axis of the sensor leaves a step 45 degrees beside its diagonal


@dataclass(frozen=True)
class _Row:
    line: int
    key: tuple[str, str, float, str]
    time: float
    x: float
    y: float


def read_csv(path: str | Path, groups: Sequence[Group], counts: float = 255.0) -> tuple[StepRecord, ...]:
    """The steps of a file.

    Args:
        path: of the CSV file.
        groups: of the robot; every one must have steps in both directions.
        counts: of full PWM.

    Raises:
        FileFaults: all that is wrong, with its line: missing columns, numbers that are none, times that do not rise,
            steps that are empty, saturated or never move, groups and directions that are missing.
    """
    text, name = read_text(path, LARGEST)
    return parse_csv(text, groups, counts, name)


def parse_csv(text: str, groups: Sequence[Group], counts: float = 255.0, name: str = "steps.csv") -> tuple[
    StepRecord, ...
]:  # fmt: skip
    """As `read_csv`, from text; `name` is the file's in messages."""
    faults = _Faults(name, text.splitlines())
    reader = csv.reader(io.StringIO(text, newline=""))
    rows = _rows(reader, {group.name: group for group in groups}, counts, faults)
    faults.refuse()
    records = [_record(part, groups) for part in _parts(rows, faults)]
    faults.refuse()
    _check(records, groups, counts, faults)
    faults.refuse()
    return tuple(records)


def write_csv(records: Iterable[StepRecord]) -> str:
    """The text of a file that `read_csv` reads back, to the last bit."""
    lines = ["group,direction,pwm,run,time_s,x_m,y_m"]
    for run, record in enumerate(records):
        head = f"{record.group},{record.direction},{record.pwm:g},{run}"
        lines += [
            f"{head},{t!r},{x!r},{y!r}"
            for t, x, y in zip(record.time.tolist(), record.x.tolist(), record.y.tolist(), strict=True)
        ]
    return "\n".join(lines) + "\n"


class _Faults:
    """Faults of one file, in its order: the same one of many rows once, those past the twentieth counted only."""

    def __init__(self, name: str, lines: Sequence[str]) -> None:
        self.name, self.lines = name, lines
        self.found: list[Fault] = []
        self.times: dict[str, int] = {}
        self.more = 0

    def add(self, line: int, message: str, hint: str = "") -> None:
        seen = self.times[message] = self.times.get(message, 0) + 1
        if seen > 1:
            return
        if len(self.found) >= MOST_FAULTS:
            self.more += 1
            return
        source = self.lines[line - 1][:200] if 0 < line <= len(self.lines) else ""
        self.found.append(Fault(self.name, line, message, 1, source, hint))

    def refuse(self) -> None:
        if self.found:
            told = [replace(one, message=one.message + self._again(one)) for one in self.found]
            rest = [Fault(self.name, 0, f"{self.more} more faults are not listed")] if self.more else []
            raise FileFaults(self.name, [*told, *rest])

    def _again(self, fault: Fault) -> str:
        more = self.times[fault.message] - 1
        return f" (and in {more} more line{'s' if more > 1 else ''})" if more else ""


def _columns(header: Sequence[str], faults: _Faults) -> tuple[dict[str, int], dict[str, float]]:
    """Where the columns are, and the factors to SI."""
    where: dict[str, int] = {}
    factors: dict[str, float] = {}
    seen = [cell.strip() for cell in header]
    for i, cell in enumerate(seen):
        match = _HEADER.fullmatch(cell.lower())
        column, unit = (match[1], match[2] or match[3]) if match else ("", None)
        if column not in (*NEEDED, "run") or (unit and column not in UNITS):
            continue
        if column in where:
            faults.add(1, f"two columns tell {column}: {seen[where[column]]!r} and {cell!r}", "keep one of them")
        allowed = UNITS.get(column, {})
        if unit and unit.replace("µ", "u") not in allowed:
            faults.add(1, f"column {cell!r} has an unknown unit", f"allowed for {column}: {', '.join(allowed)}")
        where[column], factors[column] = i, allowed.get((unit or "").replace("µ", "u"), 1.0)
    missing = [column for column in NEEDED if column not in where]
    if missing:
        found = ", ".join(seen[:12]) or "nothing"
        hint = separated(header) or f"columns are {', '.join(NEEDED)}"
        faults.add(1, f"missing columns: {', '.join(missing)}; found {found}", hint)
    return where, factors


def _rows(reader: Iterable[list[str]], groups: dict[str, Group], counts: float, faults: _Faults) -> list[_Row]:
    rows: list[_Row] = []
    where: dict[str, int] = {}
    factors: dict[str, float] = {}
    try:
        for cells in reader:
            line = reader.line_num  # type: ignore[attr-defined]
            if not any(cell.strip() for cell in cells) or cells[0].lstrip().startswith("#"):
                continue
            if not where:
                where, factors = _columns(cells, faults)
                if faults.found:
                    return []
            elif (row := _row(line, cells, where, factors, groups, counts, faults)) is not None:
                rows.append(row)
    except csv.Error as error:
        faults.add(reader.line_num, f"is not CSV: {error}")  # type: ignore[attr-defined]
    if not where and not faults.found:
        faults.add(1, "the file is empty", f"its first line names the columns: {', '.join(NEEDED)}")
    elif not rows and not faults.found:
        faults.add(1, "there are no samples below the header")
    return rows


def _row(
    line: int, cells: list[str], where: dict[str, int], factors: dict[str, float], groups: dict[str, Group],
    counts: float, faults: _Faults,
) -> _Row | None:  # fmt: skip
    if len(cells) <= max(where.values()):
        faults.add(line, f"has {len(cells)} cells; the header has {max(where.values()) + 1} or more")
        return None
    text = {column: cells[i].strip() for column, i in where.items()}
    direction = _DIRECTIONS.get(text["direction"].lower())
    group = {name.lower(): name for name in groups}.get(text["group"].lower())
    if group is None:
        faults.add(line, f"no group of wheels called {text['group']!r}; known: {', '.join(groups)}")
    if direction is None:
        faults.add(line, f"direction is {text['direction']!r}; allowed: forward, backward")
    numbers = {column: _number(text[column], column, line, faults) for column in ("pwm", "time", "x", "y")}
    if group is None or direction is None or any(not math.isfinite(value) for value in numbers.values()):
        return None
    pwm = abs(numbers["pwm"])
    if pwm > counts:
        faults.add(line, f"PWM {pwm:g} is above full PWM, {counts:g} counts: the step is saturated")
        return None
    if pwm == 0.0:
        faults.add(line, "PWM is 0: that is no step", "leave out the rows between steps")
        return None
    key = (group, direction, pwm, text.get("run", ""))
    return _Row(line, key, *(numbers[column] * factors[column] for column in ("time", "x", "y")))


def _number(text: str, column: str, line: int, faults: _Faults) -> float:
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not math.isfinite(value):
        faults.add(line, f"{column} is {text!r}, not a number")
    return value


def _parts(rows: Sequence[_Row], faults: _Faults) -> list[list[_Row]]:
    """The rows of each step."""
    parts: list[list[_Row]] = []
    for row in rows:
        if parts and parts[-1][0].key == row.key:
            if row.time <= parts[-1][-1].time:
                faults.add(
                    row.line,
                    f"time does not rise within a step: {row.time:g} s after {parts[-1][-1].time:g} s",
                    "a step that is repeated at once needs a column run with another value",
                )
            parts[-1].append(row)
        else:
            parts.append([row])
    for part in parts:
        if len(part) < 2:
            group, direction, pwm, _ = part[0].key
            faults.add(part[0].line, f"the step {group} {direction} at PWM {pwm:g} is empty: it has one sample only")
    return parts


def _record(part: Sequence[_Row], groups: Sequence[Group]) -> StepRecord:
    group, direction, pwm, _ = part[0].key
    time, x, y = (np.array([getattr(row, name) for row in part]) for name in ("time", "x", "y"))
    diagonal = next(one.diagonal for one in groups if one.name == group)
    return StepRecord(group, direction, pwm, time, x - x[0], y - y[0], float(time[0]), diagonal, part[0].line)


def _check(records: Sequence[StepRecord], groups: Sequence[Group], counts: float, faults: _Faults) -> None:
    """What cannot be calibrated from: saturated readings, steps that never move, missing or wrong directions."""
    if (strongest := max(one.pwm for one in records)) <= 1.0:
        text = f"no PWM is above {strongest:g} of {counts:g} counts"
        faults.add(records[0].line, text, f"pwm is in counts: multiply parts of full duty by {counts:g}")
    ends = np.array([(one.x[-1], one.y[-1]) for one in records])
    signed = bool(ends.min() < -_SIGNED * np.abs(ends).max())
    for group in groups:
        for direction in (FORWARD, BACKWARD):
            mine = [one for one in records if (one.group, one.direction) == (group.name, direction)]
            moved = [one for one in mine if one.travel()[-1] > MOVED_COUNTS * group.resolution_m]
            if not mine:
                faults.add(0, f"there are no steps of {group.name} {direction}; every group needs both directions")
            elif not moved:
                text = f"no step of {group.name} {direction} ever moves, up to PWM {max(one.pwm for one in mine):g}"
                faults.add(mine[0].line, text, "is the sensor connected, and x and y in the unit of the header?")
            _beside(moved, group, signed, faults)
            for one in mine:
                weaker = [other.pwm for other in moved if other.pwm < one.pwm - _STRONGER * counts]
                if weaker and one not in moved:
                    text = f"the step {one.name} never moves, although PWM {min(weaker):g} does"
                    faults.add(one.line, text, "leave it out, or measure it again")
            for one in moved:
                if at := _saturated(one.time, one.travel(), group.resolution_m):
                    text = f"the sensor is saturated in the step {one.name}: its reading stands still from {at:g} s on"
                    faults.add(one.line, text, "end the step where the sensor's range ends")


def _beside(moved: Sequence[StepRecord], group: Group, signed: bool, faults: _Faults) -> None:
    """Refuse a group and direction of which most steps go somewhere else; amounts without signs tell less."""
    far = [one for one in moved if math.hypot(one.x[-1], one.y[-1]) > _FAR_COUNTS * group.resolution_m]
    off = [one for one in far if _along(one, signed) < _BESIDE]
    if not off or 2 * len(off) <= len(far):
        return
    one = off[0]
    x, y = _way(one, signed)
    went, wanted = math.degrees(math.atan2(one.y[-1], one.x[-1])), math.degrees(math.atan2(y, x))
    text = f"the step {one.name} goes to {went:.0f} deg and not to {wanted:.0f} deg"
    if len(off) > 1:
        text += f", and {len(off) - 1} more of {group.name} {one.direction} go wrong"
    hint = "is an axis dead or in another unit?" if group.diagonal and not signed else (
        "x is ahead and y to the left: a wrong sign, forward and backward exchanged, an axis dead or in another unit?"
        if group.diagonal
        else "x is the travel of the rim, below 0 backward: a wrong sign, or forward and backward exchanged?"
    )  # fmt: skip
    faults.add(one.line, text, hint)


def _along(one: StepRecord, signed: bool) -> float:
    """Cosine between where a step went and where it should."""
    x, y = _way(one, signed)
    return (x * float(one.x[-1]) + y * float(one.y[-1])) / math.hypot(one.x[-1], one.y[-1])


def _way(one: StepRecord, signed: bool) -> tuple[float, float]:
    """Unit vector, x ahead and y to the left, of a group and direction (Keek et al., Figure 3), or its amounts."""
    if not signed:
        return (math.sqrt(0.5), math.sqrt(0.5)) if one.diagonal else (1.0, 0.0)
    sign = 1.0 if one.direction == FORWARD else -1.0
    if not one.diagonal:
        return sign, 0.0
    half = sign * math.sqrt(0.5)
    return half, half if one.group == "W1W4" else -half


def _saturated(time: Array, travel: Array, resolution_m: float) -> float:
    """When the reading of a step that moved stopped for good [s]; 0 for one that goes on to its end."""
    last = np.flatnonzero(np.abs(travel - travel[-1]) > 1e-9)
    flat = len(travel) - 1 - (int(last[-1]) + 1 if len(last) else 0)
    if flat < max(_FLAT_SAMPLES, _FLAT * len(travel)):
        return 0.0
    moving = travel[: len(travel) - flat]
    began = int(np.flatnonzero(travel > MOVED_COUNTS * resolution_m)[0])
    # a crawl of less than a count a sample pauses between counts: it must stand for longer than it ever has
    pauses = np.diff(np.flatnonzero(np.diff(moving[max(0, began - 1) :]) > 0.0), prepend=0)
    longest = int(pauses.max()) if len(pauses) else 0
    return float(time[len(travel) - flat - 1]) if flat > 3 * max(longest, 1) else 0.0


__all__ = ["NEEDED", "UNITS", "parse_csv", "read_csv", "write_csv"]
