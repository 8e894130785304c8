"""The charts of a run: errors, velocities, wheels, steering, duty, slip, motors."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from holodrive.geometry import wrap
from holodrive.log.drawing import best_pose
from holodrive.log.run import Run
from holodrive.reports.plots import DASHES, Chart, Line
from holodrive.types import Array, MotorState


@dataclass(frozen=True)
class ChartGroup:
    """Charts that belong together under one heading; `note` says how to read them."""

    title: str
    note: str
    charts: tuple[Chart, ...]


def chart_groups(run: Run) -> list[ChartGroup]:
    """All groups of which a run knows something."""
    groups = [
        ChartGroup("Error over time", "Distance from the reference, and of the estimate from the truth.", errors(run)),
        ChartGroup(
            "Body velocity",
            "Solid: what the base did. Pale: what the controller asked for, cut at three times that.",
            velocities(run),
        ),
        ChartGroup("Wheel speeds", "Pale: commanded. Solid: measured.", wheels(run)),
        ChartGroup("Steering", "Pale: commanded. Solid: measured.", steering(run)),
        ChartGroup("Motors and ground", "Duty of each motor; rim speed in which the wheels contradict.", effort(run)),
        ChartGroup(
            "Currents and power",
            "Means of each control tick. Current is what makes torque, as in a DC motor of the same constants; "
            "below 0 W a motor brakes, and the efficiency is that of all drives together while they drive.",
            motors(run),
        ),
    ]
    shown = []
    for group in groups:
        charts = tuple(chart for chart in group.charts if chart.known())
        if charts:
            shown.append(ChartGroup(group.title, group.note, charts))
    return shown


def errors(run: Run) -> tuple[Chart, ...]:
    """Position and heading error of the robot against the reference and of the estimate against the truth."""
    tracking, belief = position_error(best_pose(run), run.reference), position_error(run.estimate, run.pose)
    factor, unit = _metres(tracking, belief)
    marks = tuple(event.time for event in run.events if event.kind != "arrived")
    names = ("robot from reference", "estimate from truth")
    headings = heading_error(best_pose(run), run.reference), heading_error(run.estimate, run.pose)
    return (
        Chart(
            "Position error", unit, _lines(names, run.time, (tracking * factor, belief * factor)), low=0.0, marks=marks
        ),
        Chart("Heading error", "°", _lines(names, run.time, headings), least=0.2, marks=marks),
    )


def velocities(run: Run) -> tuple[Chart, ...]:
    """Forward, sideways and yaw velocity of the base: asked for and true."""
    charts = []
    for i, (title, unit) in enumerate((("Forward", "m/s"), ("Sideways", "m/s"), ("Yaw rate", "rad/s"))):
        lines = (Line("asked", run.time, run.decided[:, i], i, pale=True), Line("true", run.time, run.twist[:, i], i))
        charts.append(Chart(title, unit, lines, width=350.0, height=180.0, least=0.01))
    return tuple(charts)


def wheels(run: Run) -> tuple[Chart, ...]:
    """One small chart a wheel, all on the same scale: commanded and measured speed."""
    both = np.concatenate([run.wheel_commands.ravel(), run.wheel_speeds.ravel()])
    both = both[np.isfinite(both)]
    low, high = (float(both.min()), float(both.max())) if len(both) else (None, None)
    # four charts stand better as two and two
    size = (460.0, 200.0) if len(run.robot.wheels) in (2, 4) else (350.0, 180.0)
    return tuple(
        Chart(wheel.name, "rad/s", _pair(i, run.time, run.wheel_commands[:, i], run.wheel_speeds[:, i]), low=low,
              high=high, width=size[0], height=size[1])
        for i, wheel in enumerate(run.robot.wheels)
    )  # fmt: skip


def steering(run: Run) -> tuple[Chart, ...]:
    """One small chart a steered wheel: commanded and measured angle."""
    size = (460.0, 200.0) if len(run.robot.steered) in (2, 4) else (350.0, 180.0)
    degrees, wanted = np.degrees(run.steer), np.degrees(run.steer_commands)
    return tuple(
        Chart(run.robot.wheels[wheel].name, "°", _pair(wheel, run.time, wanted[:, i], degrees[:, i]), width=size[0],
              height=size[1])
        for i, wheel in enumerate(run.robot.steered)
        if i < run.steer.shape[1]
    )  # fmt: skip


def effort(run: Run) -> tuple[Chart, ...]:
    """Duty of every motor and slip of the base."""
    duty = tuple(
        Line(wheel.name, run.time, 100.0 * run.duty[:, i], i, dash=DASHES[i % len(DASHES)])
        for i, wheel in enumerate(run.robot.wheels)
    )
    slip = (Line("", run.time, 1e3 * run.slip, 3),)
    return (Chart("Duty", "%", duty, low=-100.0, high=100.0), Chart("Wheel slip", "mm/s", slip, low=0.0, least=1.0))


def motors(run: Run) -> tuple[Chart, ...]:
    """Current and torque of each drive, current of each steering, power of all, efficiency of the drives."""
    n, state = len(run.robot.wheels), run.motor_state
    drives = [wheel.name for wheel in run.robot.wheels]
    steered = [run.robot.wheels[i].name for i in run.robot.steered]
    known = np.isfinite(run.motors).any(axis=(0, 2))
    total = [np.nansum(values[:, known], axis=1) if known.any() else np.full(len(run.time), np.nan) for values in state]
    power = (Line("electrical", run.time, total[2], 3), Line("mechanical", run.time, total[3], 2))
    given = MotorState(*(np.sum(values[:, :n], axis=1) for values in state)).efficiency
    return (
        Chart("Drive current", "A", _lines(drives, run.time, list(state.current[:, :n].T)), least=0.1),
        Chart("Drive torque", "N m", _lines(drives, run.time, list(state.torque[:, :n].T)), least=0.01),
        Chart("Steering current", "A", _lines(steered, run.time, list(state.current[:, n:].T)), least=0.1),
        Chart("Power of all motors", "W", power, least=0.1),
        Chart("Efficiency of the drives", "%", (Line("", run.time, 100.0 * given, 4),), low=0.0, high=100.0),
    )


def position_error(a: Array, b: Array) -> Array:
    """Distance (T,) [m] between two tracks of poses (T, 3)."""
    return np.asarray(np.hypot(a[:, 0] - b[:, 0], a[:, 1] - b[:, 1]))


def heading_error(a: Array, b: Array) -> Array:
    """Heading of `a` minus that of `b` (T,), wrapped, in degrees."""
    return np.degrees(wrap(a[:, 2] - b[:, 2]))


def compared(runs: Sequence[Run], names: Sequence[str]) -> tuple[Chart, ...]:
    """Errors and speed of several runs on common axes, one line a run."""
    tracks = [position_error(best_pose(run), run.reference) for run in runs]
    factor, unit = _metres(*tracks)
    times = [run.time for run in runs]
    speeds = [np.hypot(run.twist[:, 0], run.twist[:, 1]) for run in runs]
    turns = [heading_error(best_pose(run), run.reference) for run in runs]
    peaks = [np.abs(run.duty).max(axis=1, initial=0.0) * 100.0 for run in runs]
    charts = (
        Chart(
            "Position error",
            unit,
            _many(names, times, [factor * track for track in tracks]),
            low=0.0,
            least=1.0 if unit == "mm" else 0.0,
        ),
        Chart("Heading error", "°", _many(names, times, turns), least=0.2),
        Chart("Speed", "m/s", _many(names, times, speeds), low=0.0),
        Chart("Largest duty of a wheel", "%", _many(names, times, peaks), low=0.0, high=100.0),
    )
    return tuple(chart for chart in charts if chart.known())


def _pair(colour: int, time: Array, commanded: Array, measured: Array) -> tuple[Line, ...]:
    return Line("commanded", time, commanded, colour, pale=True), Line("measured", time, measured, colour)


def _many(names: Sequence[str], times: Sequence[Array], values: Sequence[Array]) -> tuple[Line, ...]:
    return tuple(
        Line(name, x, y, i, dash=DASHES[i % len(DASHES)])
        for i, (name, x, y) in enumerate(zip(names, times, values, strict=True))
    )


def _lines(names: Sequence[str], time: Array, values: Sequence[Array]) -> tuple[Line, ...]:
    return _many(names, [time] * len(names), values)


def _metres(*errors: Array) -> tuple[float, str]:
    """Factor and unit in which errors [m] read well."""
    largest = max((float(np.nanmax(e)) for e in errors if np.isfinite(e).any()), default=0.0)
    return (1.0, "m") if largest >= 1.0 else (1e3, "mm")
