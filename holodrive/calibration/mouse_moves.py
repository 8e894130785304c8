"""The moves that calibrate mice, driven open loop: whoever does not know his sensors cannot steer by them."""

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from holodrive.calibration.mouse_runs import DIRECTIONS, Accuracy, Kind, MouseRun, spin, straight
from holodrive.errors import InputError
from holodrive.interfaces import CommandKind
from holodrive.kinematics.chassis import Chassis
from holodrive.kinematics.limits import loads
from holodrive.robots.spec import Robot
from holodrive.types import Array, Decision, Estimate, Observation, Pose, Reference, Twist

SHARE = 0.7  # of what the wheels can do, so that no wheel is at its limit
SETTLE_S = 1.0  # standing still after a move: the robot comes to rest before anybody measures
_STILL = Decision(Twist(0.0, 0.0, 0.0))


@dataclass(frozen=True, slots=True)
class Move:
    """One of the moves: a body twist for a time.

    Attributes:
        name, kind: as of the run that comes of it.
        twist: held in `base_link`.
        duration_s: of the twist; the robot then stands for `SETTLE_S`.
    """

    name: str
    kind: Kind
    twist: Twist
    duration_s: float


class Stand(NamedTuple):
    """Where a robot stands after a move, as a person with a tape says it.

    Attributes:
        x, y: of the end seen from the start [m].
        turn_rad: against the start, whole turns counted.
    """

    x: float
    y: float
    turn_rad: float


def moves(robot: Robot, turns: float, length_m: float) -> tuple[Move, ...]:
    """A spin, a run ahead and a run to the left, as fast as is comfortable.

    Args:
        robot: whose wheels say how fast.
        turns: of the spin, counter-clockwise; best so many and a half.
        length_m: of each straight run.
    """
    if not (math.isfinite(turns) and 0.25 <= abs(turns) <= 1000.0):
        raise InputError(f"--turns is a number from 0.25 to 1000 turns (negative turns right); found {turns:g}")
    if not (math.isfinite(length_m) and 0.05 <= length_m <= 100.0):
        raise InputError(f"--length is 5 cm to 100 m; found {length_m:g} m")
    chassis, limits = Chassis.of(robot), robot.limits
    rate = min(SHARE / float(np.max(loads(chassis, (0.0, 0.0, 1.0)))), limits.yaw_rate_rad_s)
    found = [Move("spin", "spin", Twist(0.0, 0.0, math.copysign(rate, turns)), 2.0 * math.pi * abs(turns) / rate)]
    straights: tuple[Kind, ...] = ("ahead", "left")
    for kind in straights:
        c, s = math.cos(DIRECTIONS[kind]), math.sin(DIRECTIONS[kind])
        speed = min(SHARE / float(np.max(loads(chassis, (c, s, 0.0)))), limits.speed_m_s)
        found.append(Move(kind, kind, Twist(speed * c, speed * s, 0.0), length_m / speed))
    return tuple(found)


class OpenLoop:
    """A controller that drives one move and then stands still."""

    command_kind: CommandKind = "twist"

    def __init__(self, move: Move) -> None:
        self.move = move
        self._began = math.nan

    def reset(self) -> None:
        """From the beginning of the move."""
        self._began = math.nan

    def step(self, reference: Reference, estimate: Estimate, observation: Observation) -> Decision:
        """The twist of the move, zero after it, `arrived` when the robot has come to rest."""
        if math.isnan(self._began):
            self._began = observation.time
        passed = observation.time - self._began
        if passed < self.move.duration_s - 1e-9:
            return Decision(self.move.twist)
        return _STILL._replace(arrived=passed >= self.move.duration_s + SETTLE_S)


class Blind:
    """An estimator that believes to stand at the start: nothing is known yet to believe otherwise."""

    def __init__(self) -> None:
        self._estimate = Estimate(Pose(0.0, 0.0, 0.0), Twist(0.0, 0.0, 0.0), np.zeros((3, 3)))

    def reset(self, pose: Pose) -> None:
        """Stand there."""
        self._estimate = Estimate(pose, Twist(0.0, 0.0, 0.0), np.zeros((3, 3)))

    def step(self, observation: Observation) -> Estimate:
        """Still there."""
        return self._estimate


class Driven(NamedTuple):
    """A move that was driven.

    Attributes:
        move: as it was asked for.
        time: (N,) of the samples [s].
        counts: (N, k, 2) of the mice since the sample before.
        stand: where the robot was measured to stand after it.
    """

    move: Move
    time: Array
    counts: Array
    stand: Stand


def run_of(driven: Driven, accuracy: Accuracy) -> MouseRun:
    """The run that a move has become."""
    (name, kind), stand = (driven.move.name, driven.move.kind), driven.stand
    if kind == "spin":
        return spin(name, driven.counts, stand.turn_rad, (stand.x, stand.y), accuracy)
    return straight(name, kind, driven.counts, (stand.x, stand.y), stand.turn_rad, accuracy)


def by_tape(before: Pose, after: Pose, accuracy: Accuracy, generator: np.random.Generator) -> Stand:
    """What a person with a tape reads of two true poses; the headings are not wrapped."""
    dx, dy = after.x - before.x, after.y - before.y
    c, s = math.cos(before.theta), math.sin(before.theta)
    noise = generator.normal(size=3) * (accuracy.tape_m, accuracy.tape_m, accuracy.turn_rad)
    true = (c * dx + s * dy, c * dy - s * dx, after.theta - before.theta)
    return Stand(*(float(value + error) for value, error in zip(true, noise, strict=True)))
