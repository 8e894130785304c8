"""From what a run recorded to steps: where a duty is held, from the tick that commanded it to the tick after."""

from collections.abc import Sequence

import numpy as np

from holodrive.calibration.groups import BACKWARD, FORWARD, Group
from holodrive.calibration.step_record import StepRecord
from holodrive.errors import InputError
from holodrive.log.run import Tick
from holodrive.robots.spec import Robot
from holodrive.types import Array, DutyCommand, Event, Scan

_ALIKE = 1e-9  # of full duty


class StepLog:
    """Keeps of a run in calibration what steps are made of; a sink of `runtime.Loop`."""

    def __init__(self) -> None:
        self._time: list[float] = []
        self._pose: list[tuple[float, float, float]] = []
        self._duty: list[tuple[float, ...]] = []
        self._angle: list[Array] = []

    def tick(self, tick: Tick) -> None:
        """One control tick."""
        self._time.append(tick.time)
        self._pose.append(tick.estimate.pose)
        decided = tick.decided
        still = (0.0,) * len(tick.wheels.position)
        self._duty.append(tuple(decided.duty) if isinstance(decided, DutyCommand) else still)
        self._angle.append(tick.wheels.position)

    def scan(self, scan: Scan) -> None:
        """Scans tell nothing of actuators."""

    def event(self, event: Event) -> None:
        """Nor do events."""

    def records(self, robot: Robot, groups: Sequence[Group], counts: float) -> tuple[StepRecord, ...]:
        """The steps, as `records_of`."""
        arrays = (np.array(each, dtype=np.float64) for each in (self._time, self._pose, self._duty, self._angle))
        time, pose, duty, angle = arrays
        return records_of(robot, groups, time, pose, duty, angle, counts) if len(time) else ()


def records_of(
    robot: Robot,
    groups: Sequence[Group],
    time: Array,
    pose: Array,
    duty: Array,
    wheel_angle: Array | None = None,
    counts: float = 255.0,
) -> tuple[StepRecord, ...]:
    """The steps of a run; ticks in which no group alone holds one duty belong to none.

    Args:
        robot: that was driven; groups: of its wheels.
        time: (T,) of the ticks [s].
        pose: (T, 3) believed at each tick, before its command [m, m, rad].
        duty: (T, n) commanded at each tick.
        wheel_angle: (T, n) of the encoders [rad]; needed for groups that are measured by theirs.
        counts: of full PWM.

    Raises:
        InputError: a group is measured by its encoder and there are no wheel angles.
    """
    edges = np.flatnonzero(np.any(np.abs(np.diff(duty, axis=0)) > _ALIKE, axis=1)) + 1
    begins = [0, *edges.tolist()]
    ends = [*edges.tolist(), len(time)]
    records = []
    for begin, end in zip(begins, ends, strict=True):
        driven = np.flatnonzero(duty[begin])
        group = next((one for one in groups if tuple(driven) == tuple(sorted(one.wheels))), None)
        if group is None or np.ptp(duty[begin][driven]) > _ALIKE:
            continue
        window = slice(begin, min(end + 1, len(time)))  # the tick after still saw the duty's whole last period
        if window.stop - window.start < 2:
            continue
        x, y = _moved(robot, group, pose[window], None if wheel_angle is None else wheel_angle[window])
        value = float(duty[begin, driven[0]])
        records.append(
            StepRecord(
                group.name,
                FORWARD if value > 0.0 else BACKWARD,
                float(round(abs(value) * counts)),
                time[window],
                x,
                y,
                float(time[begin]),
                group.diagonal,
            )
        )
    return tuple(records)


def _moved(robot: Robot, group: Group, pose: Array, angle: Array | None) -> tuple[Array, Array]:
    """(N,) displacements in the robot's frame at the first tick, or of a wheel's rim and 0."""
    if group.diagonal:
        c, s = np.cos(pose[0, 2]), np.sin(pose[0, 2])
        dx, dy = pose[:, 0] - pose[0, 0], pose[:, 1] - pose[0, 1]
        return np.asarray(c * dx + s * dy), np.asarray(c * dy - s * dx)
    if angle is None:
        raise InputError(f"{group.name} is measured by its encoder; give wheel_angle")
    wheel = group.wheels[0]
    travel = robot.wheels[wheel].radius * (angle[:, wheel] - angle[0, wheel])
    return np.asarray(travel), np.zeros_like(travel)
