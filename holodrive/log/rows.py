"""Control ticks as rows of float64: what the recorder buffers, the log stores and a `Run` is made from.

A row is the message `holodrive_msgs/msg/Tick` without the lengths of its sequences, then what IMU, mice and motors told
(messages of their own), so that writing and reading a log move whole rows and no number is ever rounded.
"""

import math
from collections.abc import Mapping, Sequence
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np

from holodrive.log.run import Run, Tick
from holodrive.robots.spec import Robot
from holodrive.types import Array, DutyCommand, Event, Scan, Twist, WheelCommand
from holodrive.worlds.spec import World

# name and count of the fixed fields, in the order of the message
FIXED: tuple[tuple[str, int], ...] = (
    ("time", 1),
    ("estimate", 3),
    ("estimate_twist", 3),
    ("covariance", 9),
    ("slip", 1),
    ("reference", 3),
    ("reference_twist", 3),
    ("reference_accel", 3),
    ("reference_last", 1),
    ("truth", 3),
    ("true_twist", 3),
    ("decided_kind", 1),
    ("decided_twist", 3),
)
# then the sequences: n of the wheels, m of the steered wheels
SEQUENCES: tuple[tuple[str, str], ...] = (
    ("decided_wheels", "n"),
    ("decided_steer", "m"),
    ("applied_wheels", "n"),
    ("applied_steer", "m"),
    ("wheel_position", "n"),
    ("wheel_speed", "n"),
    ("steer", "m"),
    ("duty", "n"),
)
KIND_TWIST, KIND_WHEELS, KIND_DUTY = 0.0, 1.0, 2.0
_NAN = math.nan
_NAN2, _NAN3 = (_NAN, _NAN), (_NAN, _NAN, _NAN)


class Columns:
    """Where each field lies in the row of a robot with `n` wheels, `m` of them steered, and `k` mice."""

    def __init__(self, n: int, m: int, k: int) -> None:
        self.n, self.m, self.k = n, m, k
        self.counts = dict(FIXED) | {name: n if kind == "n" else m for name, kind in SEQUENCES}
        self.counts |= {"gyro": 1, "accel": 2, "mice": 2 * k, "motors": 4 * (n + m)}
        self.at: dict[str, slice] = {}
        start = 0
        for name, count in self.counts.items():
            self.at[name] = slice(start, start + count)
            start += count
        self.size = start
        self._tail = [self.at[name] for name, _ in SEQUENCES]
        self._head_size = self.at["decided_wheels"].start
        self._imu = slice(self.at["gyro"].start, self.at["accel"].stop)

    def __getitem__(self, name: str) -> slice:
        return self.at[name]

    def fill(self, row: Array, tick: Tick) -> None:
        """Write a tick into a row (size,).

        Raises:
            ValueError: an array has another length than the robot has wheels or mice.
        """
        estimate, reference, wheels = tick.estimate, tick.reference, tick.wheels
        kind, twist, decided, decided_steer = _decided(tick.decided)
        row[: self._head_size] = (
            tick.time,
            *estimate.pose,
            *estimate.twist,
            *np.asarray(estimate.covariance).ravel().tolist(),
            estimate.slip,
            *reference.pose,
            *reference.twist,
            *reference.accel,
            1.0 if reference.last else 0.0,
            *(tick.truth or _NAN3),
            *(tick.true_twist or _NAN3),
            kind,
            *twist,
        )
        # a motor-duty command is in `duty`, it has no wheel speed
        applied = tick.applied.speeds if isinstance(tick.applied, WheelCommand) else _NAN
        values = (
            decided,
            decided_steer,
            applied,
            tick.applied.steer,
            wheels.position,
            wheels.speed,
            wheels.steer,
            _NAN if tick.duty is None else tick.duty,
        )
        for where, value in zip(self._tail, values, strict=True):
            if where.start != where.stop:
                row[where] = value
        self._fill_sensors(row, tick)

    def _fill_sensors(self, row: Array, tick: Tick) -> None:
        gyro, accel, mice = tick.gyro, tick.accel, tick.mice
        if gyro is None and accel is None:
            row[self._imu] = _NAN
        else:
            row[self._imu] = (_NAN if gyro is None else gyro, *(_NAN2 if accel is None else accel))
        if mice is None:
            row[self.at["mice"]] = _NAN
        elif np.shape(mice) == (self.k, 2):
            row[self.at["mice"]] = np.ravel(mice)
        elif np.size(mice) or self.k:
            raise ValueError(f"the robot has {self.k} mice, a tick has displacements of shape {np.shape(mice)}")
        if tick.motors is None:
            row[self.at["motors"]] = _NAN
        elif np.shape(tick.motors) == (4, self.n + self.m):
            row[self.at["motors"]] = np.transpose(tick.motors).ravel()
        else:
            found = np.shape(tick.motors)[1:]
            raise ValueError(
                f"the robot has {self.n + self.m} drives and steerings, a tick has motors of shape {found}"
            )


@cache
def columns(n: int, m: int, k: int) -> Columns:
    """The row layout for `n` wheels, `m` of them steered, and `k` mice."""
    return Columns(n, m, k)


def columns_of(robot: Robot) -> Columns:
    """The row layout of a robot."""
    return columns(len(robot.wheels), len(robot.steered), len(robot.mice))


def _decided(command: Twist | WheelCommand | DutyCommand) -> tuple[float, Sequence[float], Any, Any]:
    if isinstance(command, Twist):
        return KIND_TWIST, command, _NAN, _NAN
    kind, values = (KIND_WHEELS, command.speeds) if isinstance(command, WheelCommand) else (KIND_DUTY, command.duty)
    return kind, _NAN3, values, command.steer if len(command.steer) else _NAN


def run_of_rows(
    rows: Array,
    robot: Robot,
    world: World | None,
    settings: Mapping[str, Any],
    *,
    scans: Sequence[Scan] = (),
    events: Sequence[Event] = (),
    metrics: Mapping[str, float] | None = None,
    path: Path | None = None,
    damage: str = "",
) -> Run:
    """A `Run` from rows (T, size)."""
    at = columns_of(robot)

    def part(name: str) -> Array:
        return np.ascontiguousarray(rows[:, at[name]])

    return Run(
        robot=robot,
        world=world,
        settings=dict(settings),
        time=part("time")[:, 0],
        pose=part("truth"),
        estimate=part("estimate"),
        covariance=part("covariance").reshape(-1, 3, 3),
        reference=part("reference"),
        twist=part("true_twist"),
        decided=part("decided_twist"),
        wheel_commands=part("applied_wheels"),
        wheel_speeds=part("wheel_speed"),
        steer_commands=part("applied_steer"),
        steer=part("steer"),
        duty=part("duty"),
        slip=part("slip")[:, 0],
        gyro=part("gyro")[:, 0],
        accel=part("accel"),
        mice=part("mice").reshape(len(rows), at.k, 2),
        motors=part("motors").reshape(len(rows), at.n + at.m, 4),
        scans=tuple(scans),
        events=tuple(events),
        metrics=dict(metrics or {}),
        path=path,
        damage=damage,
    )
