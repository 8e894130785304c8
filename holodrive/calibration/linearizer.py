"""All groups of a robot calibrated: the linearizer, its tables for the robot's file, and what people compare."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from holodrive.calibration.duty_fit import CurveFit, fit
from holodrive.calibration.groups import BACKWARD, DIRECTIONS, FORWARD, Group, groups_of
from holodrive.calibration.step_record import StepRecord
from holodrive.calibration.step_response import Step, analyse
from holodrive.errors import InputError
from holodrive.robots import curves
from holodrive.robots.spec import DutyCurve, DutyMap, Linearizer, Robot
from holodrive.types import Array

_MM = 1e-3  # m in the unit of the file's speeds
_DIGITS = 8  # of coefficients in the file
_BELIEVED = 5.0  # times faster or slower than the file's motors; a wrong unit is ten times or more


@dataclass(frozen=True)
class Calibration:
    """What the steps of one robot tell.

    Attributes:
        robot: its name.
        counts: of full PWM.
        groups: in the order of the fits.
        fits: one for each group and direction, forward first.
        steps: all steps, analysed, in the order in which they were measured.
    """

    robot: str
    counts: float
    groups: tuple[Group, ...]
    fits: tuple[CurveFit, ...]
    steps: tuple[Step, ...]

    def fit_of(self, group: str, direction: str) -> CurveFit:
        """The fit of one group in one direction."""
        return next(one for one in self.fits if (one.group, one.direction) == (group, direction))

    def steps_of(self, group: str, direction: str) -> tuple[Step, ...]:
        """The steps of one group in one direction, as measured."""
        return tuple(s for s in self.steps if (s.record.group, s.record.direction) == (group, direction))

    @property
    def speed_scale(self) -> float:
        """Rim speed over the speed that was measured."""
        return self.groups[0].speed_scale

    def linearizer(self, robot: Robot) -> Linearizer:
        """The linearizer of a robot whose wheels these are."""
        maps: dict[int, DutyMap] = {}
        for group in self.groups:
            for wheel in group.wheels:
                pair = [self._curve(robot, group, wheel, direction) for direction in DIRECTIONS]
                maps[wheel] = DutyMap(*pair)
        return Linearizer(tuple(maps[i] for i in range(len(robot.wheels))), self.speed_scale)

    def toml_tables(self, robot: Robot) -> dict[str, Any]:
        """[linearizer] of the robot's file: speeds in mm/s, PWM in counts."""
        table: dict[str, Any] = {
            "counts": int(self.counts),
            "speed_unit": "mm/s",
            "speed_scale": self.speed_scale,
        }
        for group in self.groups:
            name = group.name.lower() if group.diagonal else group.name
            table[name] = {
                "wheels": [robot.wheels[i].name for i in group.wheels],
                **{direction: self._entry(robot, group, direction) for direction in DIRECTIONS},
            }
        return table

    def _entry(self, robot: Robot, group: Group, direction: str) -> dict[str, Any]:
        one = self.fit_of(group.name, direction)
        if one.method == "points":
            return {"points": [[_rounded(pwm), _rounded(speed)] for pwm, speed in one.points.tolist()]}
        entry: dict[str, Any] = {"cubic": [_rounded(value) for value in one.cubic]}
        top = self._top(robot, group, one)
        return entry if top is None else entry | {"top": _rounded(top)}

    def _curve(self, robot: Robot, group: Group, wheel: int, direction: str) -> DutyCurve:
        """The curve as the robot's file will say it, so that file and value are the same."""
        entry = self._entry(robot, group, direction)
        scale = {
            "speed_unit_m_s": _MM,
            "counts": self.counts,
            "speed_scale": group.speed_scale,
            "radius_m": robot.wheels[wheel].radius,
        }
        if "points" in entry:
            return curves.from_points(entry["points"], **scale)
        return curves.from_cubic(entry["cubic"], top=entry.get("top"), **scale)

    def _top(self, robot: Robot, group: Group, one: CurveFit) -> float | None:
        """Where the cubic ends [mm/s]: None where it rises to full PWM by itself, else the fastest that was seen."""
        scale = {"speed_scale": group.speed_scale, "radius_m": robot.wheels[group.wheels[0]].radius}
        try:
            curves.from_cubic(
                [_rounded(value) for value in one.cubic], speed_unit_m_s=_MM, counts=self.counts, top=None, **scale
            )
        except InputError:
            return float(one.top_m_s) / _MM
        return None


def calibrate(
    robot: Robot, records: Sequence[StepRecord], counts: float = 255.0, *, measured_elsewhere: bool = True
) -> Calibration:
    """All steps of a robot to its curves.

    Args:
        robot: whose wheels were stepped.
        records: in the order in which they were measured.
        counts: of full PWM.
        measured_elsewhere: by a sensor that the robot need not have.

    Raises:
        InputError: a group without steps in a direction, or with too few that move.
    """
    groups = groups_of(robot, measured_elsewhere=measured_elsewhere)
    resolution = {group.name: group.resolution_m for group in groups}
    steps = tuple(analyse(record, resolution[record.group]) for record in records)
    fits = []
    for group in groups:
        for direction in (FORWARD, BACKWARD):
            mine = [s for s in steps if (s.record.group, s.record.direction) == (group.name, direction)]
            if not mine:
                raise InputError(f"there are no steps of {group.name} {direction}; every group needs both directions")
            fits.append(fit(mine, counts))
    found = Calibration(robot.name, counts, groups, tuple(fits), steps)
    _believable(found, robot)
    return _usable(found, robot)


def _believable(found: Calibration, robot: Robot) -> None:
    """Refuse speeds that the motors of the robot's file cannot make: most often a unit.

    Raises:
        InputError: a group that is several times as fast as its motors without load, or as slow with strong PWM.
    """
    for one in found.fits:
        group = next(each for each in found.groups if each.name == one.group)
        wheels = [robot.wheels[i] for i in group.wheels]
        free = max(wheel.motor.no_load_speed_rad_s * wheel.radius for wheel in wheels)
        rim, part = float(one.speed_m_s.max()) * group.speed_scale, float(one.pwm[-1]) / found.counts
        fast = rim > _BELIEVED * free
        if fast or (part >= 0.5 and rim * _BELIEVED < part * free):
            raise InputError(
                f"{one.group} {one.direction} comes out at {rim:.3g} m/s of rim with PWM {one.pwm[-1]:g}, "
                f"and its motors do {free:.3g} m/s without load: are time, x and y in the units that the header "
                f"names, and do motor and radius of {robot.name} hold? Nothing is taken over"
            )


def _usable(found: Calibration, robot: Robot) -> Calibration:
    """A cubic that a robot's file would refuse, such as one that ends above full PWM, gives way to points."""
    fits = []
    for one in found.fits:
        group = next(each for each in found.groups if each.name == one.group)
        try:
            found._curve(robot, group, group.wheels[0], one.direction)
            fits.append(one)
        except InputError:
            points = one.points
            missed = np.abs(np.interp(one.pwm, points[:, 0], points[:, 1]) - one.speed_m_s / _MM)
            fits.append(
                replace(
                    one,
                    method="points",
                    dead_zone=float(points[0, 0]),
                    top_m_s=_MM * float(points[-1, 1]),
                    max_error_m_s=_MM * float(missed.max()),
                )
            )
    return replace(found, fits=tuple(fits))


def curve_values(
    robot: Robot, linearizer: Linearizer, group: Group, direction: str, counts: float, speeds: Array
) -> Array:
    """(P,) PWM that a linearizer gives for speeds (P,) [m/s] of a group, as measured."""
    wheel = group.wheels[0]
    each = linearizer.wheels[wheel]
    curve = each.forward if direction == FORWARD else each.backward
    return counts * duty_values(curve, speeds * group.speed_scale / robot.wheels[wheel].radius)


def duty_values(curve: DutyCurve, speeds: Array) -> Array:
    """(P,) duty of a curve at wheel speeds (P,) of 0 or more [rad/s]; straight on beyond its end."""
    knots, pieces = np.array(curve.knots), np.array(curve.pieces)
    k = np.clip(np.searchsorted(knots, speeds, side="right") - 1, 0, len(pieces) - 1)
    w = np.minimum(speeds, knots[-1]) - knots[k]
    c = pieces[k]
    duty = c[:, 0] + w * (c[:, 1] + w * (c[:, 2] + w * c[:, 3]))
    last, reach = pieces[-1], knots[-1] - knots[-2]
    slope = last[1] + reach * (2.0 * last[2] + reach * 3.0 * last[3])
    return np.asarray(duty + slope * np.maximum(speeds - knots[-1], 0.0))


def _rounded(value: float) -> float:
    return float(f"{value:.{_DIGITS}g}")


__all__ = ["Calibration", "calibrate", "curve_values", "duty_values"]
