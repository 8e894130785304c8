"""The gate: every command for the motors passes this one pure function, from whatever source it comes.

NaN means stop, never "keep the last"; zero goes to all wheels in the same tick; a fault latches until `rearm`.
A command inside the limits passes unchanged: scaling is the pipeline's work, and what still exceeds a limit
after it is a fault of the software, not a wish to be fulfilled in part.
"""

import math
from dataclasses import dataclass
from typing import NamedTuple

from holodrive.robots.spec import Robot
from holodrive.types import DutyCommand, WheelCommand

_ROUNDING = 1.0 + 1e-9  # what floating point may add to a command that was scaled to its limit


@dataclass(frozen=True, slots=True)
class GateLimits:
    """What may pass.

    Attributes:
        wheels: names, for the message.
        speeds_rad_s: (n,) largest absolute wheel speed.
        steered: how many steering angles a command carries.
        calibration: whether open-loop duty may pass.
    """

    wheels: tuple[str, ...]
    speeds_rad_s: tuple[float, ...]
    steered: int
    calibration: bool = False

    @classmethod
    def of(cls, robot: Robot, calibration: bool = False) -> "GateLimits":
        """The limits of a robot's wheels."""
        return cls(
            tuple(wheel.name for wheel in robot.wheels),
            tuple(wheel.max_speed_rad_s for wheel in robot.wheels),
            len(robot.steered),
            calibration,
        )


class GateState(NamedTuple):
    """What the gate remembers: the latched fault ("" = none) and the steering angles that stay when it stops."""

    fault: str = ""
    steer: tuple[float, ...] = ()


class Verdict(NamedTuple):
    """What goes to the motors, what the gate remembers, and why it refused ("" = it passed)."""

    command: WheelCommand | DutyCommand
    state: GateState
    reason: str


def gate(command: WheelCommand | DutyCommand, state: GateState, limits: GateLimits) -> Verdict:
    """Pass a command, or stop all wheels and latch.

    Args:
        command: wheel speeds [rad/s] or duty [-1, 1], with steering angles [rad].
        state: from the verdict before; `GateState()` at the start.
        limits: of this robot.
    """
    if state.fault:
        return Verdict(_stop(state, limits), state, state.fault)
    reason = _refusal(command, limits)
    if reason:
        state = GateState(reason, state.steer)
        return Verdict(_stop(state, limits), state, reason)
    return Verdict(command, GateState("", tuple(float(angle) for angle in command.steer)), "")


def rearm(state: GateState) -> GateState:
    """Forget the fault: a person's explicit act after the cause has gone."""
    return GateState("", state.steer)


def _stop(state: GateState, limits: GateLimits) -> WheelCommand:
    steer = state.steer if len(state.steer) == limits.steered else (0.0,) * limits.steered
    return WheelCommand((0.0,) * len(limits.wheels), steer)


def _refusal(command: WheelCommand | DutyCommand, limits: GateLimits) -> str:
    """Why this command may not pass, in words; "" when it may."""
    match command:
        case WheelCommand():
            return _check(command.speeds, limits.speeds_rad_s, "rad/s", command.steer, limits)
        case DutyCommand() if limits.calibration:
            return _check(command.duty, (1.0,) * len(limits.wheels), "of full duty", command.steer, limits)
        case DutyCommand():
            return "a duty command passes in calibration mode only; command wheel speeds or a twist"
    return f"a {type(command).__name__} is not a command for motors; allowed: WheelCommand, DutyCommand"


def _check(values: object, bounds: tuple[float, ...], unit: str, steer: object, limits: GateLimits) -> str:
    numbers, angles = _numbers(values), _numbers(steer)
    if numbers is None or angles is None:
        return f"the command holds something that is not a number: {values}, {steer}"
    if len(numbers) != len(bounds) or len(angles) != limits.steered:
        return (
            f"the command is for {len(numbers)} wheels and {len(angles)} steering angles; "
            f"this robot has {len(bounds)} and {limits.steered}"
        )
    for name, value, bound in zip(limits.wheels, numbers, bounds, strict=True):
        if not math.isfinite(value):
            return f"wheel {name} is commanded {value}; it must be finite"
        if abs(value) > bound * _ROUNDING:
            return f"wheel {name} is commanded {value:.4g} {unit}; its limit is {bound:.4g}"
    bad = next((angle for angle in angles if not math.isfinite(angle)), None)
    return "" if bad is None else f"a steering angle is {bad}; it must be finite"


def _numbers(values: object) -> list[float] | None:
    try:
        return [float(value) for value in values]  # type: ignore[attr-defined]
    except (TypeError, ValueError, OverflowError):
        return None
