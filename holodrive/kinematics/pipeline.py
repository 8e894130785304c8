"""From a wanted twist to wheels, in the order that keeps straight lines straight: limit, discretise, invert.

1. limit: speed, yaw rate and acceleration of the base, then what the wheels can do; the direction is kept,
2. discretise: the twist that, held for one tick, ends where the straight line does although the base turns,
3. invert, then per steered wheel: shortest turn, hold at rest, steering rate, cosine scaling.

The usual recipe (discretise, then scale the wheels) bends the line, because it scales a twist that was bent for
another turn rate; see the test that shows it.

Wheels come after acceleration, because a wheel cannot go faster than it can. So the acceleration limits are no bound
for a base whose wheels saturate: how fast a twist they allow varies with the heading, and where a base turns into a
direction that its wheels drive slower in, it slows down as fast as that takes. Gaining speed again is bounded. To
keep accelerations bounded, command no more than the slowest direction allows at that yaw rate (or limit it so with
`Limits.speed_m_s`).
"""

import math
from typing import TYPE_CHECKING, Any

import numpy as np

from holodrive.errors import CommandError
from holodrive.kinematics.chassis import Chassis
from holodrive.kinematics.limits import Applied
from holodrive.kinematics.scalar_step import ACCEL, NOTHING, SPEED, YAW_RATE, command_step
from holodrive.types import Twist, WheelCommand

if TYPE_CHECKING:
    from collections.abc import Sequence

    from holodrive.robots.spec import Limits, Robot

_new = tuple.__new__
_WHAT_BINDS = {NOTHING: "", SPEED: "speed", YAW_RATE: "yaw rate", ACCEL: "acceleration"}


class CommandPipeline:
    """The command step of one robot, with its state: the last twist and the steering angles.

    Args:
        robot: a described robot, or a chassis (whose wheels carry the limits).
        limits: instead of the robot's own.
    """

    __slots__ = ("_bounds", "_memory", "_result", "_step", "chassis")

    def __init__(self, robot: "Robot | Chassis", limits: "Limits | None" = None) -> None:
        self.chassis = robot if isinstance(robot, Chassis) else Chassis.of(robot)
        if limits is None and not isinstance(robot, Chassis):
            limits = robot.limits
        self._step = command_step(self.chassis, limits)
        self._bounds = tuple(wheel.max_speed for wheel in self.chassis.wheels)
        self.reset()

    def reset(self, steer: "Sequence[float] | None" = None, twist: "Sequence[float]" = (0.0, 0.0, 0.0)) -> None:
        """Start anew: modules at `steer` (m,) [rad] (0 when not given), the base moving with `twist`."""
        m = len(self.chassis.steered)
        angles = [0.0] * m if steer is None else [float(angle) for angle in steer]
        if len(angles) != m:
            raise CommandError(f"{len(angles)} steering angles for a base with {m} steered wheels; give {m}")
        self._memory = [*(float(value) for value in twist), *angles, *([0.0] * m)]
        self._result: tuple[Any, ...] = ((), (), *self._memory[:3], 1.0, NOTHING, 1.0)

    def step(self, twist: "Twist | Sequence[float]", dt_s: float) -> WheelCommand:
        """Wheels for one tick of `dt_s` seconds: tuples of n speeds [rad/s] and m steering angles [rad], not wrapped.

        A twist that is not finite, or a tick without length, gives NaN speeds, which the gate turns into a stop.

        Raises:
            CommandError: `dt_s` is negative, infinite or NaN; no state has changed.
        """
        self._result = result = self._step(*twist, dt_s, self._memory)  # type: ignore[call-arg]
        return _new(WheelCommand, result[:2])  # half the time of WheelCommand(...)

    @property
    def applied(self) -> Applied:
        """What the last step made of its command: the twist before discretisation, and what took how much of it.

        `share` below 1 tells that an acceleration limit bound, `scale` below 1 that a speed limit or a wheel did.
        """
        vx, vy, omega, scale, binding, share = self._result[2:]
        name = self.chassis.names[binding] if binding >= 0 else _WHAT_BINDS[binding]
        return Applied(np.array([vx, vy, omega]), scale, name, share)

    @property
    def steer(self) -> tuple[float, ...]:
        """Steering angles (m,) [rad] of the last step."""
        return tuple(self._memory[3 : 3 + len(self.chassis.steered)])

    def saturate(self, command: WheelCommand) -> WheelCommand:
        """Wheel speeds scaled by one common factor into the wheels' limits, so that the motion keeps its direction."""
        speeds = tuple(float(speed) for speed in command.speeds)
        if len(speeds) != len(self._bounds):
            raise CommandError(f"{len(speeds)} wheel speeds for a base with {len(self._bounds)} wheels")
        worst = max(abs(speed) / bound for speed, bound in zip(speeds, self._bounds, strict=True))
        if worst > 1.0 and math.isfinite(worst):
            speeds = tuple(speed / worst for speed in speeds)
        return WheelCommand(speeds, command.steer)
