"""Runs with ground mice: what they counted, and what is known of where the robot went.

A mouse's displacement in its own axes is linear in the body-axes integral m of the twist, whatever the speed profile:
c = (1/scale) R(phi)^T [[1, 0, -y], [0, 1, x]] m, so that the totals of a run say all of the mounting; the samples are
needed only where a tape measured the end of a run that did not go quite straight.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike

from holodrive import geometry
from holodrive.errors import InputError
from holodrive.types import Array

Kind = Literal["spin", "ahead", "back", "left", "right", "track"]
KINDS: tuple[Kind, ...] = ("spin", "ahead", "back", "left", "right", "track")
DIRECTIONS: dict[str, float] = {"ahead": 0.0, "back": math.pi, "left": 0.5 * math.pi, "right": -0.5 * math.pi}  # rad
_CLOSED = 0.5  # |1 - exp(i turn)| below which a spin comes back on itself and its end says nothing of its centre
_MOST = 1024  # samples of a run that are kept apart; 5 turns in so many pieces are 2 deg each
_PIECES, _FEWEST = 40, 8  # of a run with a track, and samples in one of them


@dataclass(frozen=True, slots=True)
class Accuracy:
    """How well people and tapes measure (standard deviations).

    Attributes:
        tape_m: of a length or an end position.
        turn_rad: of a turn that was read off marks on the floor.
        centre_m: how far from the robot's centre it may have turned, where nobody measured that.
        astray: how far aside a straight run may have gone, as a part of its length, where nobody measured that.
        astray_rad: how far it may have turned, where nobody measured that.
        track: of a track that is known (wheel odometry, truth), as a part of the way or turn.
        track_m, track_rad: the same for a short piece, at least.
    """

    tape_m: float = 1e-3
    turn_rad: float = math.radians(0.5)
    centre_m: float = 5e-3
    astray: float = 0.01
    astray_rad: float = math.radians(2.0)
    track: float = 2e-3
    track_m: float = 1e-4
    track_rad: float = 1e-4

    def __post_init__(self) -> None:
        for name in ("tape_m", "turn_rad", "centre_m", "astray", "astray_rad", "track", "track_m", "track_rad"):
            value = getattr(self, name)
            if not (value > 0.0 and math.isfinite(value)):
                raise InputError(f"an accuracy is a number above 0; found {name} = {value}")


@dataclass(frozen=True, slots=True)
class Measured:
    """What is known of a run.

    Attributes:
        what: "end" is the pose at the end seen from the start, the turn not wrapped; "body" is the integral of the
            twist in body axes.
        value: (3,) [m, m, rad]; NaN where nothing is known.
        sigma: (3,) standard deviations.
    """

    what: Literal["end", "body"]
    value: Array
    sigma: Array


@dataclass(frozen=True)
class MouseRun:
    """One run of k mice.

    Attributes:
        name: for people; runs of one name are pieces of one run.
        kind: what was driven.
        counts: (N, k, 2) that each mouse counted since the sample before, in its own axes.
        measured: what is known of the run.
        way: (k,) counts along the way, the sum of the samples' lengths.
        squares: (N, k, 2) squared counts, for noise that grows with the way; where samples were added up, their sum.
    """

    name: str
    kind: Kind
    counts: Array
    measured: tuple[Measured, ...]
    way: Array = field(init=False)
    squares: Array = field(init=False)

    def __post_init__(self) -> None:
        object.__setattr__(self, "way", np.hypot(self.counts[..., 0], self.counts[..., 1]).sum(axis=0))
        object.__setattr__(self, "squares", _merged(self.counts**2))
        object.__setattr__(self, "counts", _merged(self.counts))

    @property
    def total(self) -> Array:
        """(k, 2) counts from start to end."""
        return np.asarray(self.counts.sum(axis=0))

    @property
    def turn_rad(self) -> float:
        """How far the robot turned, as far as that was measured; 0 where not."""
        known = [each.value[2] for each in self.measured if math.isfinite(each.value[2])]
        return float(known[0]) if known else 0.0


def spin(name: str, counts: ArrayLike, turn_rad: float, end: ArrayLike | None, accuracy: Accuracy) -> MouseRun:
    """A turn on the spot.

    After whole turns every robot stands where it began, about whatever point it turned; only an end that was measured
    near a half turn tells that point. Otherwise it is taken for the robot's centre, within `accuracy.centre_m`.

    Args:
        name: of the run.
        counts: (N, k, 2).
        turn_rad: counter-clockwise, whole turns counted.
        end: (x, y) of the end seen from the start [m], None when nobody measured it.
        accuracy: of the measuring.
    """
    if not (math.isfinite(turn_rad) and abs(turn_rad) > 0.1):
        raise InputError(f"run {name!r}: a spin turns by a known angle, a turn or more at best; found {turn_rad:g} rad")
    told = end is not None and abs(1.0 - np.exp(1j * turn_rad)) > _CLOSED
    if told:
        x, y = np.asarray(end, dtype=np.float64)
        sigma = (accuracy.tape_m, accuracy.tape_m, accuracy.turn_rad)
        known = Measured("end", np.array([x, y, turn_rad]), np.array(sigma))
    else:
        off = accuracy.centre_m * abs(turn_rad)
        known = Measured("body", np.array([0.0, 0.0, turn_rad]), np.array([off, off, accuracy.turn_rad]))
    return MouseRun(name, "spin", np.asarray(counts, dtype=np.float64), (known,))


def straight(
    name: str, kind: Kind, counts: ArrayLike, end: ArrayLike, turn_rad: float | None, accuracy: Accuracy
) -> MouseRun:
    """A straight run.

    Args:
        name: of the run.
        kind: "ahead", "back", "left" or "right".
        counts: (N, k, 2).
        end: (x, y) of the end seen from the start [m]; a NaN was not measured (as a rule the way aside).
        turn_rad: at the end against the start, None when nobody measured it.
        accuracy: of the measuring.
    """
    x, y = np.asarray(end, dtype=np.float64)
    length = math.hypot(0.0 if math.isnan(x) else x, 0.0 if math.isnan(y) else y)
    if not length > 0.0:
        raise InputError(f"run {name!r}: a straight run has a known length above 0; found ({x:g}, {y:g}) m")
    aside = accuracy.astray * length
    value = np.array([x, y, 0.0 if turn_rad is None else turn_rad])
    sigma = np.array([accuracy.tape_m, accuracy.tape_m, accuracy.astray_rad if turn_rad is None else accuracy.turn_rad])
    missing = np.isnan(value)
    value[missing], sigma[missing] = 0.0, aside
    return MouseRun(name, kind, np.asarray(counts, dtype=np.float64), (Measured("end", value, sigma),))


def tracked(name: str, counts: ArrayLike, track: ArrayLike, accuracy: Accuracy) -> list[MouseRun]:
    """Pieces of any motion whose track is known: by wheel odometry, motion capture or a simulator's truth.

    Args:
        name: of the run.
        counts: (N, k, 2) since the sample before; those of the first sample have no track and do not count.
        track: (N, 3) poses at the samples, headings wrapped or not; rows with NaN end a piece.
        accuracy: of the track.
    """
    counts, track = np.asarray(counts, dtype=np.float64), np.asarray(track, dtype=np.float64)
    size = max(_FEWEST, math.ceil((len(track) - 1) / _PIECES))
    pieces = []
    for begin in range(0, len(track) - 1, size):
        part = track[begin : begin + size + 1]
        if len(part) < 2 or not np.isfinite(part).all():
            continue
        steps = geometry.log(geometry.between(part[:-1], part[1:]))
        way, turn = np.hypot(steps[:, 0], steps[:, 1]).sum(), np.abs(steps[:, 2]).sum()
        across = accuracy.track_m + accuracy.track * way
        sigma = np.array([across, across, accuracy.track_rad + accuracy.track * turn])
        known = Measured("body", steps.sum(axis=0), sigma)
        pieces.append(MouseRun(name, "track", counts[begin + 1 : begin + len(part)], (known,)))
    if not pieces:
        raise InputError(f"run {name!r}: its track holds no two poses in a row that are numbers")
    return pieces


def check(runs: Sequence[MouseRun], mice: Sequence[str]) -> None:
    """Refuse runs that no fit can use.

    Raises:
        InputError: the first fault: no run, an empty one, a dead mouse, or one whose axes are mirrored.
    """
    if not runs:
        raise InputError("mice are calibrated from runs: a spin and two straight ones; found none")
    for run in runs:
        if not len(run.counts):
            raise InputError(f"run {run.name!r} is empty; drive it again, or leave it out")
        if run.counts.shape[1:] != (len(mice), 2):
            raise InputError(
                f"run {run.name!r} has counts of the shape {run.counts.shape} for the mice {', '.join(mice)}"
            )
        if not np.isfinite(run.counts).all():
            raise InputError(f"run {run.name!r} has counts that are not finite")
    _alive(runs, mice)
    _not_mirrored(runs, mice)


def _alive(runs: Sequence[MouseRun], mice: Sequence[str]) -> None:
    """A mouse may stand still in a spin about itself, but in no straight run."""
    for run in runs:
        if run.kind in DIRECTIONS:
            for i, name in enumerate(mice):
                most = int(np.argmax(run.way))
                if run.way[i] <= 0.1 * run.way[most] or run.way[i] < 10.0:
                    beside = f" where {mice[most]} counted {run.way[most]:.0f}" if most != i else ""
                    raise InputError(
                        f"mouse {name} counted {run.way[i]:.0f} in run {run.name!r}{beside}: dead, lifted off or not "
                        "connected? Mend it and drive the run again"
                    )
    for i, name in enumerate(mice):
        if not any(run.way[i] > 0.0 for run in runs):
            raise InputError(f"mouse {name} counted nothing in any run: dead, lifted off or not connected?")


def _not_mirrored(runs: Sequence[MouseRun], mice: Sequence[str]) -> None:
    """Its axes must follow each other counter-clockwise, as those of the robot do."""
    straights = [run for run in runs if run.kind in DIRECTIONS]
    for a in straights:
        for b in straights:
            between = DIRECTIONS[b.kind] - DIRECTIONS[a.kind]
            if abs(math.sin(between)) < 0.5:
                continue
            for i, name in enumerate(mice):
                (ax, ay), (bx, by) = a.total[i], b.total[i]
                if math.sin(between) * (ax * by - ay * bx) < 0.0:
                    raise InputError(
                        f"mouse {name} sees runs {a.name!r} and {b.name!r} mirrored: its y is not to the left of its "
                        "x; swap its columns or the sign of one"
                    )


def _merged(counts: Array) -> Array:
    """At most `_MOST` samples, neighbours added up."""
    group = math.ceil(len(counts) / _MOST)
    if group <= 1:
        return counts
    return np.asarray(np.add.reduceat(counts, np.arange(0, len(counts), group), axis=0))
