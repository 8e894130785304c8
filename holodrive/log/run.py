"""A recorded run as arrays: what a log holds, what reports draw, what a comparison compares."""

from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from holodrive.robots.spec import Robot
from holodrive.types import (
    Array,
    Command,
    Estimate,
    Event,
    MotorState,
    Pose,
    Reference,
    Scan,
    Twist,
    WheelCommand,
    WheelState,
)
from holodrive.worlds.spec import World


class Tick(NamedTuple):
    """One control tick, as the loop hands it to the recorder.

    `decided` is what the controller asked for, `applied` what was really sent after pipeline, gate and base.
    `truth` and `true_twist` are known in simulation and with motion capture only. `duty` (n,) is None when unknown.
    `gyro`, `accel` (2,) and `mice` (k, 2) are those of the observation, None without such a sensor.
    `motors` is None where nobody knows what the motors do.
    """

    time: float
    estimate: Estimate
    reference: Reference
    decided: Command
    applied: WheelCommand
    wheels: WheelState
    truth: Pose | None = None
    true_twist: Twist | None = None
    duty: Array | None = None
    gyro: float | None = None
    accel: Array | None = None
    mice: Array | None = None
    motors: MotorState | None = None


def _nothing() -> Array:
    return np.empty(0)


@dataclass(frozen=True)
class Run:
    """A whole run; T ticks, n wheels, m steered wheels, k mice. Unknown values are NaN.

    Attributes:
        robot, world: as they were, with their TOML texts.
        settings: what it takes to repeat the run, JSON-able: controller, params, plant, seed, reference,
            duration, version, id.
        time: (T,) [s].
        pose: (T, 3) true pose in `map`.
        estimate: (T, 3) believed pose; `covariance`: (T, 3, 3).
        reference: (T, 3) wanted pose.
        twist: (T, 3) true body twist.
        decided: (T, 3) twist that the controller asked for (NaN for wheel commands).
        wheel_commands: (T, n) applied [rad/s]; `wheel_speeds`: (T, n) measured [rad/s].
        steer_commands, steer: (T, m) [rad].
        duty: (T, n) in [-1, 1].
        slip: (T,) [m/s of rim].
        scans, events: as they came.
        metrics: name -> number, see `holodrive.metrics`.
        path: of the log file, when there is one.
        damage: one line about what of the file could not be read; empty for a whole one.
        gyro: (T,) yaw rate as measured [rad/s].
        accel: (T, 2) specific force as measured, in the axes of the IMU [m/s^2].
        mice: (T, k, 2) displacement of each ground sensor since the last tick, in its own axes [m].
        motors: (T, n + m, 4) current [A], torque [N m], electrical and mechanical power [W] of drives and steerings,
            means of the control period that begins at the tick; see `motor_state`.
    """

    robot: Robot
    world: World | None
    settings: dict[str, Any]
    time: Array
    pose: Array
    estimate: Array
    covariance: Array
    reference: Array
    twist: Array
    decided: Array
    wheel_commands: Array
    wheel_speeds: Array
    steer_commands: Array
    steer: Array
    duty: Array
    slip: Array
    scans: tuple[Scan, ...] = ()
    events: tuple[Event, ...] = ()
    metrics: dict[str, float] = field(default_factory=dict)
    path: Path | None = None
    damage: str = ""
    gyro: Array = field(default_factory=_nothing)
    accel: Array = field(default_factory=_nothing)
    mice: Array = field(default_factory=_nothing)
    motors: Array = field(default_factory=_nothing)

    def __post_init__(self) -> None:
        """What sensors were left out are unknown at every tick."""
        motors = len(self.robot.wheels) + len(self.robot.steered)
        shapes = (("gyro", ()), ("accel", (2,)), ("mice", (len(self.robot.mice), 2)), ("motors", (motors, 4)))
        for name, shape in shapes:
            if not np.size(getattr(self, name)):
                object.__setattr__(self, name, np.full((len(self.time), *shape), np.nan))

    @property
    def motor_state(self) -> MotorState:
        """What the motors did, each (T, n + m); NaN where nobody knows."""
        return MotorState(*np.moveaxis(self.motors, -1, 0))

    @property
    def ended(self) -> str:
        """Why it ended: "arrived", "fault" (the gate refused a command), "interrupted" or "duration"."""
        kinds = {event.kind for event in self.events}
        if "gate" in kinds or "stop" in kinds:
            return "fault" if "gate" in kinds else "interrupted"
        at_the_end = [event for event in self.events if event.kind == "arrived" and event.time >= self.time[-1]]
        return "arrived" if at_the_end else "duration"

    def _repr_html_(self) -> str:
        """For notebooks: the metrics and the path over the world."""
        from holodrive.log.drawing import notebook

        return notebook(self)
