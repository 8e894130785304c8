"""The format for your own recordings: a CSV table with named columns (docs/recordings.md).

All faults of a file are told at once, each with its line.
"""

import math
import tomllib
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from holodrive import robots
from holodrive.errors import Fault, FileFaults, HolodriveError, LogError, did_you_mean
from holodrive.log.recording import Recording
from holodrive.robots.spec import Robot
from holodrive.types import Array

_TRUTH = ("x_m", "y_m", "theta_rad")
_GYRO = "gyro_rad_s"
_KEYS = ("robot", "name", "family", "source", "licence", "counts_per_turn")
_SHOWN = 20  # faults of the rows; a file of the wrong kind has one on each line


def fits(path: Path, head: bytes) -> bool:
    """Whether the file is text."""
    return b"\x00" not in head


def runs(path: Path) -> list[str]:
    """The one run."""
    return [path.stem]


@dataclass
class _File:
    """A file while it is read: what was found, and what is wrong."""

    path: Path
    lines: list[str]
    faults: list[Fault] = field(default_factory=list)

    def fault(self, line: int, message: str, hint: str = "", column: int = 1) -> None:
        """One fault; `line` counts from 1, 0 is the whole file."""
        source = self.lines[line - 1] if 0 < line <= len(self.lines) else ""
        self.faults.append(Fault(str(self.path), line, message, column, source, hint))

    def stop_at_faults(self) -> None:
        """Raise all of them, when there are any."""
        if self.faults:
            raise FileFaults(str(self.path), self.faults)


def read(path: Path, run: str, robot: str | None) -> Recording:
    """The recording of a CSV file.

    Raises:
        FileFaults: all that is wrong with it.
    """
    try:
        text = path.read_text(encoding="utf-8-sig")
    except (OSError, UnicodeDecodeError) as error:
        raise LogError(f"{path}: cannot be read as text: {error}") from None
    file = _File(path, text.splitlines())
    settings = _settings(file)
    start, names = _columns(file)
    spec = _robot(file, robot or settings.get("robot"))
    file.stop_at_faults()
    assert spec is not None
    _check_columns(file, start, names, spec)
    file.stop_at_faults()
    lines, table = _table(file, start, names)
    file.stop_at_faults()
    _check_time(file, lines, table[:, names.index("t")])
    return _recording(file, names, table, settings, spec, robot)


def _settings(file: _File) -> dict[str, Any]:
    """`# key = value` lines above the table, or the file of the same name that ends in .toml."""
    out: dict[str, Any] = {}
    for number, line in enumerate(file.lines, start=1):
        if not line.startswith("#"):
            break
        text = line.lstrip("#").strip()
        if "=" in text:
            _take_settings(file, out, text, number)
    beside = file.path.with_suffix(".toml")
    if not out and beside.is_file():
        _take_settings(file, out, beside.read_text(encoding="utf-8"), 0, beside.name)
    return out


_LONGEST_LINE = 500


def _take_settings(file: _File, out: dict[str, Any], text: str, line: int, where: str = "") -> None:
    prefix = f"{where}: " if where else ""
    if any(len(part) > _LONGEST_LINE for part in text.splitlines()):
        file.fault(line, f"{prefix}a line of more than {_LONGEST_LINE} characters is no setting")
        return
    try:
        values = tomllib.loads(text)
    except (tomllib.TOMLDecodeError, RecursionError) as error:
        file.fault(line, f'{prefix}not of the form key = "value": {error}')
        return
    for key, value in values.items():
        if key not in _KEYS:
            file.fault(line, f"{prefix}unknown key {key!r}{did_you_mean(key, _KEYS)}", f"known: {', '.join(_KEYS)}")
        elif key != "counts_per_turn" and not isinstance(value, str):
            file.fault(line, f"{prefix}{key} = {value!r}, expected a text in quotes")
        else:
            out[key] = value


def _columns(file: _File) -> tuple[int, list[str]]:
    """Line of the column names (from 1), and the names."""
    for number, line in enumerate(file.lines, start=1):
        if line.strip() and not line.startswith("#"):
            return number, [name.strip() for name in line.split(",")]
    file.fault(0, "no line of column names", "such as: t,wheel.left,wheel.right,wheel.rear")
    return 0, []


def _robot(file: _File, name: str | None) -> Robot | None:
    if name is None:
        file.fault(1, "which robot was recorded?", 'write # robot = "NAME" above the table, NAME as in holodrive list')
        return None
    try:
        beside = file.path.parent / name
        return robots.load(beside if name.endswith(".toml") and beside.is_file() else name)
    except HolodriveError as error:
        file.fault(_line_of(file, "robot"), str(error))
        return None


def _line_of(file: _File, key: str) -> int:
    for number, line in enumerate(file.lines, start=1):
        if line.startswith("#") and line.lstrip("# ").startswith(key):
            return number
    return 0


def _check_columns(file: _File, line: int, names: Sequence[str], robot: Robot) -> None:
    """Column names against the robot's wheels."""
    wheels = [wheel.name for wheel in robot.wheels]
    steered = [wheels[i] for i in robot.steered]
    known = ["t", _GYRO, *_TRUTH, *(f"steer.{name}" for name in steered)]
    known += [f"{kind}.{name}" for kind in ("wheel", "ticks") for name in wheels]
    for place, name in enumerate(names):
        if name not in known:
            hint = f"robot {robot.name!r} has the wheels {', '.join(wheels)}" if "." in name else ""
            file.fault(line, f"unknown column {name!r}{did_you_mean(name, known)}", hint, place + 1)
        if name in names[:place]:
            file.fault(line, f"column {name!r} is there twice", column=place + 1)
    if "t" not in names:
        file.fault(line, "no column 't'", "the time of each row in seconds")
    for name in wheels:
        there = [f"{kind}.{name}" for kind in ("wheel", "ticks") if f"{kind}.{name}" in names]
        if len(there) != 1:
            message = f"wheel {name!r} has {' and '.join(there)}" if there else f"no column for wheel {name!r}"
            file.fault(line, message, f"one of wheel.{name} [rad] and ticks.{name}")
    for name in steered:
        if f"steer.{name}" not in names:
            file.fault(line, f"no column 'steer.{name}'", "steering angle in radians")
    given = [name for name in _TRUTH if name in names]
    if given and len(given) < len(_TRUTH):
        missing = ", ".join(name for name in _TRUTH if name not in names)
        file.fault(line, f"the true pose lacks {missing}", "all of x_m, y_m, theta_rad, or none")


def _table(file: _File, start: int, names: Sequence[str]) -> tuple[list[int], Array]:
    """Line numbers (N,) and numbers (N, columns); empty cells of truth and gyro are NaN."""
    may_be_empty = [name in _TRUTH or name == _GYRO for name in names]
    numbers, rows = [], []
    for number in range(start + 1, len(file.lines) + 1):
        line = file.lines[number - 1]
        if not line.strip() or line.startswith("#"):
            continue
        cells = line.split(",")
        if len(cells) != len(names):
            hint = "separate by commas" if ";" in line or "\t" in line else ""
            file.fault(number, f"{len(cells)} cells, expected {len(names)}", hint)
        else:
            rows.append([_number(file, number, *each) for each in zip(names, cells, may_be_empty, strict=True)])
            numbers.append(number)
        if len(file.faults) > _SHOWN:
            file.fault(number, f"reading stopped after {_SHOWN} faults")
            break
    if not file.faults and len(rows) < 2:
        file.fault(start, f"{len(rows)} rows of numbers, expected at least 2")
    return numbers, np.array(rows, dtype=np.float64).reshape(len(rows), len(names))


def _number(file: _File, line: int, name: str, cell: str, may_be_empty: bool) -> float:
    text = cell.strip()
    if not text and may_be_empty:
        return math.nan
    try:
        value = float(text)
    except ValueError:
        file.fault(line, f"{name}: {text!r} is not a number" if text else f"{name}: an empty cell, expected a number")
        return 0.0
    if not math.isfinite(value) and not may_be_empty:
        file.fault(line, f"{name}: {text} is not finite", "leave out rows without a reading")
        return 0.0
    return value if math.isfinite(value) else math.nan


def _check_time(file: _File, lines: Sequence[int], time: Array) -> None:
    for row in np.flatnonzero(np.diff(time) < 0.0)[:_SHOWN] + 1:
        file.fault(lines[row], f"time goes back from {time[row - 1]:g} to {time[row]:g} s", "sort the rows by time")


def _recording(
    file: _File, names: list[str], table: Array, settings: dict[str, Any], spec: Robot, robot: str | None
) -> Recording:
    wheels = tuple(wheel.name for wheel in spec.wheels)
    steered = tuple(wheels[i] for i in spec.steered)
    position = np.stack([_angle(file, names, table, settings, spec, i) for i in range(len(wheels))], axis=-1)
    file.stop_at_faults()
    time = table[:, names.index("t")]
    truth = table[:, [names.index(name) for name in _TRUTH]] if _TRUTH[0] in names else np.empty((0, 3))
    known = np.flatnonzero(np.isfinite(truth).all(axis=1))
    return Recording(
        name=settings.get("name", file.path.stem),
        robot=robot or settings.get("robot", spec.name),
        time=time,
        wheels=wheels,
        position=position,
        steered=steered,
        steer=table[:, [names.index(f"steer.{name}") for name in steered]],
        gyro=table[:, names.index(_GYRO)] if _GYRO in names else np.empty(0),
        truth_time=time[known],
        truth=truth[known],
        family=settings.get("family", ""),
        source=settings.get("source", ""),
        licence=settings.get("licence", ""),
        path=file.path,
        spec=spec,
    )


def _angle(file: _File, names: list[str], table: Array, settings: dict[str, Any], spec: Robot, i: int) -> Array:
    """(N,) angle of a wheel [rad]."""
    wheel = spec.wheels[i]
    if f"wheel.{wheel.name}" in names:
        return table[:, names.index(f"wheel.{wheel.name}")]
    given = settings.get("counts_per_turn", wheel.encoder.counts_per_turn if wheel.encoder else None)
    counts = given.get(wheel.name) if isinstance(given, dict) else given
    line = _line_of(file, "counts_per_turn")
    if not isinstance(counts, int | float) or isinstance(counts, bool) or not (0.0 < counts < math.inf):
        found = "is not known" if counts is None else f"is {counts!r}"
        hint = "write # counts_per_turn = NUMBER above the table, counts of one turn of the wheel"
        file.fault(line, f"counts_per_turn of wheel {wheel.name!r} {found}, expected a number above 0", hint)
        return table[:, 0]
    return table[:, names.index(f"ticks.{wheel.name}")] * (2.0 * math.pi / float(counts))
