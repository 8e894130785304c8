"""Runs with mice as a CSV file: columns run, kind, time, dx.NAME and dy.NAME of each mouse, one row a sample.

dx and dy are what the mouse counted since the row before, in its own axes, as it tells them. The rows of a run stand
together. What was measured of the runs stands in lines above the table, as TOML behind `#`:

    # turns = 5.5
    # length = "1 m"
    # end.spin = { x = "2 mm", y = "-1 mm", turns = 5.5 }
    # end.ahead = { x = "1.002 m", y = "4 mm", turn = "0.5 deg" }

A run of the kind `track` tells where it went in columns x_m, y_m and theta_rad instead.
"""

import csv
import io
import math
import tomllib
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from holodrive.calibration.mouse_runs import DIRECTIONS, KINDS, Accuracy, MouseRun, spin, straight, tracked
from holodrive.calibration.separators import separated
from holodrive.errors import Fault, FileFaults, InputError, did_you_mean
from holodrive.files import units
from holodrive.files.source import read as read_text
from holodrive.types import Array

NEEDED = ("run", "kind", "time")
TRACK = ("x_m", "y_m", "theta_rad")
LARGEST = 64 * 2**20  # bytes
MOST_FAULTS = 20
_NUMBERS = {"turns": "number", "length": "length", "tape": "length", "angle": "angle", "centre": "length"}
_END = {"x": "length", "y": "length", "turn": "angle", "turns": "number"}


@dataclass
class _File:
    """A file while it is read."""

    name: str
    lines: list[str]
    settings: dict[str, float] = field(default_factory=dict)
    ends: dict[str, dict[str, float]] = field(default_factory=dict)
    faults: list[Fault] = field(default_factory=list)
    times: dict[str, int] = field(default_factory=dict)
    more: int = 0

    def fault(self, line: int, message: str, hint: str = "") -> None:
        """One fault, the same one of many rows once; `line` counts from 1, 0 is the whole file."""
        seen = self.times[message] = self.times.get(message, 0) + 1
        if seen > 1:
            return
        if len(self.faults) >= MOST_FAULTS:
            self.more += 1
            return
        source = self.lines[line - 1][:200] if 0 < line <= len(self.lines) else ""
        self.faults.append(Fault(self.name, line, message, 1, source, hint))

    def refuse(self) -> None:
        """Raise all of them, when there are any."""
        if self.faults:
            rest = [Fault(self.name, 0, f"{self.more} more faults are not listed")] if self.more else []
            raise FileFaults(self.name, [*(replace(one, message=self._counted(one)) for one in self.faults), *rest])

    def _counted(self, fault: Fault) -> str:
        more = self.times[fault.message] - 1
        return f"{fault.message} (and in {more} more line{'s' if more > 1 else ''})" if more else fault.message


@dataclass(frozen=True)
class _Rows:
    """The rows of one run: numbers (N, columns) and the line of the first."""

    name: str
    kind: str
    line: int
    numbers: Array


def read_csv(
    path: str | Path,
    mice: Sequence[str],
    *,
    turns: float | None = None,
    length_m: float | None = None,
    accuracy: Accuracy | None = None,
) -> tuple[MouseRun, ...]:
    """The runs of a file.

    Args:
        path: of the CSV file.
        mice: names of the robot's mice.
        turns, length_m: of spins and straight runs of which the file says nothing else; over the file's own.
        accuracy: over the file's own.

    Raises:
        FileFaults: all that is wrong, with its line: missing columns, numbers that are none, times that do not rise,
            empty runs, runs of which nothing is known.
    """
    text, name = read_text(path, LARGEST)
    return parse_csv(text, mice, name, turns=turns, length_m=length_m, accuracy=accuracy)


def parse_csv(
    text: str,
    mice: Sequence[str],
    name: str = "runs.csv",
    *,
    turns: float | None = None,
    length_m: float | None = None,
    accuracy: Accuracy | None = None,
) -> tuple[MouseRun, ...]:
    """As `read_csv`, from text; `name` is the file's in messages."""
    file = _File(name, text.splitlines())
    start = _settings(file)
    file.refuse()
    if turns is not None:
        file.settings["turns"] = turns
    if length_m is not None:
        file.settings["length"] = length_m
    exact = accuracy or _accuracy(file)
    columns, parts = _parts(file, start, mice)
    file.refuse()
    runs: list[MouseRun] = []
    for part in parts:
        try:
            runs += _runs(file, part, columns, mice, exact)
        except InputError as error:
            file.fault(part.line, str(error))
    for asked in file.ends:
        if asked not in {part.name for part in parts}:
            known = [part.name for part in parts]
            file.fault(
                0, f"end.{asked} is of no run in the file{did_you_mean(asked, known)}", f"runs: {', '.join(known)}"
            )
    file.refuse()
    return tuple(runs)


def write_csv(
    runs: Iterable[tuple[str, str, ArrayLike, ArrayLike]],
    mice: Sequence[str],
    ends: dict[str, tuple[float, float, float]],
    accuracy: Accuracy,
) -> str:
    """The text of a file that `read_csv` reads back.

    Args:
        runs: name, kind, times (N,) [s] and counts (N, k, 2) of each.
        mice: names.
        ends: (x, y, turn) of the end of each run [m, m, rad].
        accuracy: of the measuring.
    """
    lines = [f'# tape = "{1e3 * accuracy.tape_m:.10g} mm"', f'# angle = "{math.degrees(accuracy.turn_rad):.10g} deg"']
    lines += [
        f'# end.{name} = {{ x = "{1e3 * x:.7g} mm", y = "{1e3 * y:.7g} mm", turn = "{math.degrees(turn):.10g} deg" }}'
        for name, (x, y, turn) in ends.items()
    ]
    lines.append(",".join([*NEEDED, *_of_mice(mice)]))
    for name, kind, time, counts in runs:
        for t, row in zip(np.asarray(time), np.asarray(counts).reshape(len(np.asarray(time)), -1), strict=True):
            lines.append(f"{name},{kind},{t:.6f}," + ",".join(f"{value:.10g}" for value in row))
    return "\n".join(lines) + "\n"


def _of_mice(mice: Sequence[str]) -> list[str]:
    return [f"{axis}.{mouse}" for mouse in mice for axis in ("dx", "dy")]


def _settings(file: _File) -> int:
    """Read `# key = value` lines; gives the number of the line that names the columns, 0 for none."""
    for number, line in enumerate(file.lines, start=1):
        if not line.strip():
            continue
        if not line.startswith("#"):
            return number
        text = line.lstrip("#").strip()
        if "=" not in text:
            continue
        try:
            table = tomllib.loads(text)
        except (tomllib.TOMLDecodeError, RecursionError) as error:
            file.fault(number, f'not of the form key = "value": {error}')
            continue
        for key, value in table.items():
            _setting(file, number, key, value)
    return 0


def _setting(file: _File, line: int, key: str, value: Any) -> None:
    known = [*_NUMBERS, "end"]
    if key == "end" and isinstance(value, dict):
        for run, table in value.items():
            _end(file, line, run, table)
    elif key in _NUMBERS:
        found = _quantity(file, line, key, value, _NUMBERS[key])
        if found is not None:
            file.settings[key] = found
            if key in ("tape", "angle", "centre") and not found > 0.0:
                file.fault(line, f"{key} = {value!r} is an accuracy, a number above 0")
    else:
        file.fault(line, f"unknown key {key!r}{did_you_mean(key, known)}", f"known: {', '.join(known)}.RUN")


def _end(file: _File, line: int, run: str, table: Any) -> None:
    if not isinstance(table, dict):
        file.fault(line, f"end.{run} is a table", 'such as { x = "1.002 m", y = "4 mm", turn = "0.5 deg" }')
        return
    out: dict[str, float] = {}
    for key, value in table.items():
        if key not in _END:
            file.fault(line, f"unknown key {key!r} in end.{run}{did_you_mean(key, _END)}", f"known: {', '.join(_END)}")
            continue
        found = _quantity(file, line, f"end.{run}.{key}", value, _END[key])
        if found is not None:
            out["turn" if key == "turns" else key] = 2.0 * math.pi * found if key == "turns" else found
    file.ends[run] = out


def _quantity(file: _File, line: int, key: str, value: Any, dimension: str) -> float | None:
    try:
        return units.parse(value, dimension)
    except units.QuantityError as error:
        file.fault(line, f"{key}: {error}", error.hint)
        return None


def _accuracy(file: _File) -> Accuracy:
    given = {"tape": "tape_m", "angle": "turn_rad", "centre": "centre_m"}
    return replace(Accuracy(), **{name: file.settings[key] for key, name in given.items() if key in file.settings})


def _parts(file: _File, start: int, mice: Sequence[str]) -> tuple[dict[str, int], list[_Rows]]:
    """Where the numbers are in a row, and the rows run by run."""
    if not start:
        file.fault(0, "the file is empty", f"its first line names the columns: {', '.join([*NEEDED, *_of_mice(mice)])}")
        return {}, []
    reader = csv.reader(io.StringIO("\n".join(file.lines[start - 1 :]), newline=""))
    where = {name.strip(): i for i, name in enumerate(next(reader))}
    needed = [*NEEDED, *_of_mice(mice)]
    if missing := [name for name in needed if name not in where]:
        found = ", ".join(list(where)[:12]) or "nothing"
        hint = separated(list(where)) or f"columns are {', '.join(needed)}"
        file.fault(start, f"missing columns: {', '.join(missing)}; found {found}", hint)
        return {}, []
    given = [name for name in TRACK if name in where]
    if given and len(given) < len(TRACK):
        lacking = ", ".join(name for name in TRACK if name not in where)
        file.fault(start, f"the track lacks {lacking}", "all of x_m, y_m, theta_rad, or none")
        return {}, []
    names = ["time", *_of_mice(mice), *given]
    rows: list[tuple[str, str, int, list[float]]] = []
    for cells in reader:
        line = start - 1 + reader.line_num
        if not any(cell.strip() for cell in cells) or cells[0].startswith("#"):
            continue
        if len(cells) <= max(where[name] for name in [*needed, *given]):
            file.fault(line, f"has {len(cells)} cells; the header has {len(where)}")
            continue
        kind = cells[where["kind"]].strip().lower()
        if kind not in KINDS:
            file.fault(line, f"kind is {kind!r}{did_you_mean(kind, KINDS)}", f"allowed: {', '.join(KINDS)}")
            continue
        numbers = [_number(file, line, name, cells[where[name]]) for name in names]
        rows.append((cells[where["run"]].strip(), kind, line, numbers))
    if not rows and not file.faults:
        file.fault(start, "there are no samples below the header")
    return {name: i for i, name in enumerate(names)}, _by_run(file, rows)


def _number(file: _File, line: int, name: str, text: str) -> float:
    text = text.strip()
    if not text and name in TRACK:
        return math.nan
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not math.isfinite(value) and name not in TRACK:
        file.fault(line, f"{name} is {text!r}, not a number")
    return value


def _by_run(file: _File, rows: Sequence[tuple[str, str, int, list[float]]]) -> list[_Rows]:
    groups: list[tuple[str, str, int, list[list[float]]]] = []
    for name, kind, line, numbers in rows:
        if not groups or groups[-1][0] != name:
            if any(name == each[0] for each in groups):
                file.fault(line, f"run {name!r} goes on here after another one; the rows of a run stand together")
            groups.append((name, kind, line, []))
        elif groups[-1][1] != kind:
            file.fault(line, f"run {name!r} is {groups[-1][1]} and {kind}; a run has one kind")
        elif not numbers[0] > groups[-1][3][-1][0]:
            before = groups[-1][3][-1][0]
            file.fault(line, f"time does not rise within run {name!r}: {numbers[0]:g} s after {before:g} s")
        groups[-1][3].append(numbers)
    for name, _, line, each in groups:
        if len(each) < 2:
            file.fault(line, f"run {name!r} is empty: it has one sample only")
    return [_Rows(name, kind, line, np.array(each)) for name, kind, line, each in groups]


def _runs(file: _File, part: _Rows, columns: dict[str, int], mice: Sequence[str], accuracy: Accuracy) -> list[MouseRun]:
    counts = part.numbers[:, [columns[name] for name in _of_mice(mice)]].reshape(len(part.numbers), len(mice), 2)
    end = file.ends.get(part.name, {})
    if part.kind == "track":
        if TRACK[0] not in columns:
            raise InputError(f"run {part.name!r} is a track: the file needs the columns {', '.join(TRACK)}")
        return tracked(part.name, counts, part.numbers[:, [columns[name] for name in TRACK]], accuracy)
    if part.kind == "spin":
        turn = end.get("turn", 2.0 * math.pi * file.settings.get("turns", math.nan))
        if math.isnan(turn):
            raise InputError(
                f"by how much did run {part.name!r} turn? Give --turns N, or # end.{part.name} = {{ turns = N }}"
            )
        place = (end["x"], end["y"]) if "x" in end and "y" in end else None
        return [spin(part.name, counts, turn, place, accuracy)]
    length = file.settings.get("length", math.nan)
    angle = DIRECTIONS[part.kind]
    along = np.round((math.cos(angle), math.sin(angle)))  # of the length; the way aside is not known from it
    x, y = (end.get(axis, length * share if share else math.nan) for axis, share in zip("xy", along, strict=True))
    if math.isnan(x if along[0] else y):
        raise InputError(
            f"how far did run {part.name!r} go? Give --length L, or # end.{part.name} = {{ x = ..., y = ... }}"
        )
    kind = next(each for each in KINDS if each == part.kind)
    return [straight(part.name, kind, counts, (x, y), end.get("turn"), accuracy)]


__all__ = ["NEEDED", "TRACK", "parse_csv", "read_csv", "write_csv"]
