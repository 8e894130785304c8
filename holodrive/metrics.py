"""What a run is judged by: each number defined once, for a recorded run and inside compiled roll-outs.

All are taken at control ticks. With p the true position (the believed one where no truth is known), r the
reference's, e = |p - r| [m] and t the time:

    arrived               1.0 when the controller said that it was there
    time_s                from the first to the last tick
    path_length_m         sum of |p_k - p_(k-1)|
    turns                 changes of the path's direction above 10 deg: the path is cut into chords of 2 cm, bends of
                          one sense that follow each other are one turn, however long it lasts
    min_clearance_m       least distance from the round footprint to an obstacle or wall; infinite with none
    collisions            contacts that began
    moved_collisions      those in which the robot itself moved, faster than 1 cm/s: it was not just run into
    iae_m_s               integral of e dt (trapezoids)
    ise_m2_s              integral of e^2 dt
    rms_error_m           sqrt(ise / time)
    max_error_m           largest e
    final_error_m         e at the last tick
    final_heading_error_rad   |heading - reference heading|, wrapped, at the last tick
    energy_j              drawn from the battery; NaN where currents are not known
    saturated_share       share of the ticks with a duty at its limit; NaN where duties are not known
    mean_speed_m_s        path length over time
    no_rule               how often a stretch began in which a fuzzy controller had no rule to fire

While a fixed goal is the reference, e is the distance still to go.
"""

import math
from typing import TYPE_CHECKING

import numpy as np
from numba import njit
from numpy.typing import ArrayLike

from holodrive.leaf import leaf
from holodrive.obstacles import clearance

if TYPE_CHECKING:
    from holodrive.log.run import Run
    from holodrive.worlds.spec import World

NAMES = (
    "arrived",
    "time_s",
    "path_length_m",
    "turns",
    "min_clearance_m",
    "collisions",
    "moved_collisions",
    "iae_m_s",
    "ise_m2_s",
    "rms_error_m",
    "max_error_m",
    "final_error_m",
    "final_heading_error_rad",
    "energy_j",
    "saturated_share",
    "mean_speed_m_s",
    "no_rule",
)
(ARRIVED, TIME, PATH, TURNS, CLEARANCE, COLLISIONS, MOVED_COLLISIONS, IAE, ISE) = range(9)
(RMS, MAX_ERROR, FINAL_ERROR, FINAL_HEADING, ENERGY, SATURATED, MEAN_SPEED, NO_RULE) = range(9, 17)

TURN_CHORD_M = 0.02
TURN_RAD = math.radians(10.0)
STRAIGHT_RAD = math.radians(0.2)  # a bend from chord to chord below this ends a turn: radii above 5.7 m are straight
FULL_DUTY = 1.0 - 1e-9

# the accumulator: the metrics themselves come first, under their numbers above; then what it takes to go on
_TICKS, _DUTIES, _T0, _T, _X, _Y, _ANCHOR_X, _ANCHOR_Y, _DIRECTION, _BEND, _SILENT = range(17, 28)
SIZE = 28


class Tally:
    """Metrics of a run that comes in pieces, so that a run of any length needs no memory of its own.

    Args:
        world: for the clearance; None has no obstacles.
        footprint_m: radius of the robot.
    """

    def __init__(self, world: "World | None", footprint_m: float) -> None:
        self._world, self._footprint_m = world, footprint_m
        self._acc = np.zeros(SIZE)
        start(self._acc)

    def add(self, piece: "Run") -> None:
        """Count the ticks and events of the next piece: true poses where they are known, believed ones else."""
        pose = np.ascontiguousarray(piece.pose if np.isfinite(piece.pose).any() else piece.estimate)
        _fold(self._acc, piece.time, pose, np.ascontiguousarray(piece.reference), np.ascontiguousarray(piece.duty))
        gap = clearance(self._world, piece.time, pose, self._footprint_m)
        self._acc[CLEARANCE] = np.min(gap[np.isfinite(gap)], initial=self._acc[CLEARANCE])
        for event in piece.events:
            if event.kind == "arrived":
                self._acc[ARRIVED] = 1.0
            elif event.kind == "collision":
                self._acc[COLLISIONS] += 1.0
                self._acc[MOVED_COLLISIONS] += float(event.data.get("moved") in ("robot", "both"))
            elif event.kind == "no_rule":
                self._acc[NO_RULE] += 1.0

    def result(self, energy_j: float = math.nan) -> dict[str, float]:
        """All metrics up to now; `energy_j` was drawn from the battery, where somebody knows."""
        acc = self._acc.copy()
        acc[ENERGY] = energy_j
        finish(acc)
        return dict(zip(NAMES, acc[: len(NAMES)].tolist(), strict=True))


def of_arrays(
    time: ArrayLike,
    pose: ArrayLike,
    reference: ArrayLike,
    duty: ArrayLike | None = None,
    *,
    clearance_m: ArrayLike = math.inf,
    arrived: bool = False,
    collisions: int = 0,
    moved_collisions: int = 0,
    energy_j: float = math.nan,
) -> dict[str, float]:
    """All metrics of arrays; ticks with NaN in the pose are left out.

    Args:
        time: (T,) [s]. pose, reference: (T, 3) x, y, heading [m, m, rad]. duty: (T, n), NaN or None when unknown.
        clearance_m: (T,) or one number, from the footprint to the nearest obstacle.
        arrived, collisions, moved_collisions, energy_j: as counted elsewhere.
    """
    times, poses = np.asarray(time, dtype=np.float64), np.ascontiguousarray(pose, dtype=np.float64)
    references = np.ascontiguousarray(reference, dtype=np.float64)
    duties = np.full((len(times), 1), math.nan) if duty is None else np.ascontiguousarray(duty, dtype=np.float64)
    acc = np.zeros(SIZE)
    start(acc)
    _fold(acc, times, poses, references, duties)
    gaps = np.asarray(clearance_m, dtype=np.float64)
    acc[CLEARANCE] = np.min(gaps[np.isfinite(gaps)], initial=math.inf)
    acc[ARRIVED], acc[COLLISIONS], acc[MOVED_COLLISIONS] = float(arrived), collisions, moved_collisions
    acc[ENERGY] = energy_j
    finish(acc)
    return dict(zip(NAMES, acc[: len(NAMES)].tolist(), strict=True))


@njit(cache=True, error_model="numpy")
def _fold(acc, time, pose, reference, duty):  # type: ignore[no-untyped-def]
    for k in range(time.shape[0]):
        if math.isfinite(pose[k, 0] + pose[k, 1] + pose[k, 2]):
            tick(acc, time[k], pose[k], reference[k])
            count_duty(acc, duty[k])


@leaf
def start(acc):  # type: ignore[no-untyped-def]
    """Make an accumulator (SIZE,) ready for a new run."""
    for i in range(acc.shape[0]):
        acc[i] = 0.0
    acc[CLEARANCE] = math.inf
    acc[_DIRECTION] = acc[FINAL_ERROR] = acc[FINAL_HEADING] = math.nan


@leaf
def tick(acc, time, pose, reference):  # type: ignore[no-untyped-def]
    """Count one control tick: pose and reference as (3,) [m, m, rad]."""
    x, y = pose[0], pose[1]
    ex, ey = x - reference[0], y - reference[1]
    square = ex * ex + ey * ey
    error = math.sqrt(square)
    if acc[_TICKS] == 0.0:
        acc[_T0], acc[_ANCHOR_X], acc[_ANCHOR_Y] = time, x, y
    else:
        dx, dy, dt = x - acc[_X], y - acc[_Y], time - acc[_T]
        acc[PATH] += math.sqrt(dx * dx + dy * dy)
        acc[IAE] += 0.5 * (acc[FINAL_ERROR] + error) * dt
        acc[ISE] += 0.5 * (acc[FINAL_ERROR] * acc[FINAL_ERROR] + square) * dt
        ax, ay = x - acc[_ANCHOR_X], y - acc[_ANCHOR_Y]
        if ax * ax + ay * ay >= TURN_CHORD_M * TURN_CHORD_M:
            bend(acc, math.atan2(ay, ax))
            acc[_ANCHOR_X], acc[_ANCHOR_Y] = x, y
    acc[MAX_ERROR] = max(acc[MAX_ERROR], error)
    acc[FINAL_ERROR], acc[FINAL_HEADING] = error, wrapped(pose[2] - reference[2])
    acc[_X], acc[_Y], acc[_T] = x, y, time
    acc[_TICKS] += 1.0


@leaf
def bend(acc, direction):  # type: ignore[no-untyped-def]
    """Add a chord to the path: bends of one sense make one turn."""
    if math.isfinite(acc[_DIRECTION]):
        change = wrapped(direction - acc[_DIRECTION])
        before = acc[_BEND]
        if abs(change) < STRAIGHT_RAD:
            acc[_BEND] = 0.0
        else:
            acc[_BEND] = before + change if before * change > 0.0 else change
        same = before * acc[_BEND] > 0.0
        if abs(acc[_BEND]) > TURN_RAD and not (same and abs(before) > TURN_RAD):
            acc[TURNS] += 1.0
    acc[_DIRECTION] = direction


@leaf
def count_duty(acc, duty):  # type: ignore[no-untyped-def]
    """Count one tick's duties (n,)."""
    known = full = False
    for i in range(duty.shape[0]):
        known = known or not math.isnan(duty[i])
        full = full or abs(duty[i]) >= FULL_DUTY
    if known:
        acc[_DUTIES] += 1.0
        if full:
            acc[SATURATED] += 1.0


@leaf
def count_no_rule(acc, silent):  # type: ignore[no-untyped-def]
    """Count where a stretch begins in which a fuzzy controller has no rule to fire (`silent` is 1.0, else 0.0)."""
    if silent > acc[_SILENT]:
        acc[NO_RULE] += 1.0
    acc[_SILENT] = silent


@leaf
def finish(acc):  # type: ignore[no-untyped-def]
    """Turn sums into the metrics that are ratios; the first len(NAMES) numbers are the metrics now."""
    time = acc[_T] - acc[_T0]
    acc[TIME] = time
    acc[RMS] = math.sqrt(acc[ISE] / time) if time > 0.0 else acc[FINAL_ERROR]
    acc[MEAN_SPEED] = acc[PATH] / time if time > 0.0 else 0.0
    acc[SATURATED] = acc[SATURATED] / acc[_DUTIES] if acc[_DUTIES] > 0.0 else math.nan
    acc[FINAL_HEADING] = abs(acc[FINAL_HEADING])


@leaf
def wrapped(angle):  # type: ignore[no-untyped-def]
    """Angle [rad] in (-pi, pi]."""
    return angle - 2.0 * math.pi * math.ceil((angle - math.pi) / (2.0 * math.pi))
