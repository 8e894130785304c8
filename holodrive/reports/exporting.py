"""`export`: a run as a table of numbers, one row a control tick, with the unit in the name of every column."""

import csv
import json
import math
from importlib import import_module
from pathlib import Path
from typing import Any

import numpy as np

from holodrive.errors import InputError, MissingExtra
from holodrive.log.run import Run
from holodrive.log.sensing import motor_names
from holodrive.reports.rendering import KNOWN, TABLES, ending
from holodrive.reports.tables import plain
from holodrive.types import Array

_POSE = (("x_m", "m"), ("y_m", "m"), ("theta_rad", "rad"))
_TWIST = (("vx_m_s", "m/s"), ("vy_m_s", "m/s"), ("omega_rad_s", "rad/s"))
_MOTOR = (("current_a", "A"), ("torque_n_m", "N m"), ("electrical_w", "W"), ("mechanical_w", "W"))
_COVARIANCE = (
    ("xx_m2", "m^2", 0, 0), ("xy_m2", "m^2", 0, 1), ("yy_m2", "m^2", 1, 1), ("xtheta_m_rad", "m rad", 0, 2),
    ("ytheta_m_rad", "m rad", 1, 2), ("thetatheta_rad2", "rad^2", 2, 2),
)  # fmt: skip


def export(run: Run, path: str | Path) -> Path:
    """Write the ticks of a run as .csv or .parquet, or its metrics and settings as .json.

    Unknown values are empty cells (CSV) and nulls (Parquet, JSON). Parquet needs the extra `data`.

    Raises:
        InputError: an unknown ending, or a file that cannot be written.
        MissingExtra: Parquet without pyarrow.
    """
    path = Path(path)
    suffix = ending(path, TABLES, "export", KNOWN, "render")
    writer = {".csv": _csv, ".parquet": _parquet, ".json": _json}[suffix]
    try:
        writer(run, path)
    except OSError as error:
        raise InputError(f"{path} cannot be written: {error.strerror or error}") from error
    return path


def columns(run: Run) -> dict[str, tuple[str, Array]]:
    """Name -> (unit, values (T,)) of all that is known at every tick; names are unique and end in their unit."""
    table: dict[str, tuple[str, Array]] = {"time_s": ("s", run.time)}
    table |= {name: (unit, run.pose[:, i]) for i, (name, unit) in enumerate(_POSE)}
    for group, values, names in (
        ("estimate", run.estimate, _POSE),
        ("reference", run.reference, _POSE),
        ("twist", run.twist, _TWIST),
        ("decided", run.decided, _TWIST),
    ):
        table |= {f"{group}.{name}": (unit, values[:, i]) for i, (name, unit) in enumerate(names)}
    table |= {f"covariance.{name}": (unit, run.covariance[:, i, j]) for name, unit, i, j in _COVARIANCE}
    for i, wheel in enumerate(run.robot.wheels):
        table[f"wheel_command.{wheel.name}_rad_s"] = ("rad/s", run.wheel_commands[:, i])
        table[f"wheel.{wheel.name}_rad_s"] = ("rad/s", run.wheel_speeds[:, i])
        table[f"duty.{wheel.name}"] = ("1", run.duty[:, i])
    for i, index in enumerate(run.robot.steered):
        name = run.robot.wheels[index].name
        table[f"steer_command.{name}_rad"] = ("rad", run.steer_commands[:, i])
        table[f"steer.{name}_rad"] = ("rad", run.steer[:, i])
    if np.isfinite(run.motors).any():
        for i, name in enumerate(motor_names(run.robot)):
            for values, (what, unit) in zip(run.motor_state, _MOTOR, strict=True):
                table[f"motor.{name}.{what}"] = (unit, values[:, i])
    return table | {"slip_m_s": ("m/s", run.slip)}


def _csv(run: Run, path: Path) -> None:
    table = columns(run)
    with path.open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file)
        writer.writerow(table)
        for start in range(0, len(run.time), 4096):  # in blocks, so that an hour's run needs no copy of itself as text
            block = np.column_stack([values[start : start + 4096] for _, values in table.values()])
            writer.writerows([["" if math.isnan(v) else repr(v) for v in row] for row in block.tolist()])


def _parquet(run: Run, path: Path) -> None:
    try:
        arrow, parquet = import_module("pyarrow"), import_module("pyarrow.parquet")
    except ImportError as error:
        raise MissingExtra("a Parquet file", "pyarrow", "data") from error
    table = columns(run)
    fields = [arrow.field(name, arrow.float64(), metadata={"unit": unit}) for name, (unit, _) in table.items()]
    about = {
        "robot": run.robot.text or run.robot.name,
        "world": (run.world.text or run.world.name) if run.world else "",
        "settings": json.dumps(plain(run.settings)),
        "metrics": json.dumps(plain(run.metrics)),
    }
    # from_pandas is pyarrow's name for "NaN is null"
    arrays = [arrow.array(np.ascontiguousarray(values), from_pandas=True) for _, values in table.values()]
    content = arrow.Table.from_arrays(arrays, schema=arrow.schema(fields, metadata=about))
    parquet.write_table(content, path, compression="zstd")


def _json(run: Run, path: Path) -> None:
    events = [
        {"time_s": e.time, "kind": e.kind, "text": e.text, "pose": list(e.pose), "data": e.data} for e in run.events
    ]
    content: dict[str, Any] = {"metrics": run.metrics, "settings": run.settings, "events": events}
    path.write_text(json.dumps(plain(content), indent=2, ensure_ascii=False) + "\n", encoding="utf-8")
