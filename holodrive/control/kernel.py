"""A compiled controller in the ordinary loop: the same kernel, one tick at a time."""

import numpy as np

from holodrive import layout
from holodrive.interfaces import CommandKind, ControllerPlug
from holodrive.observation_array import empty_observation, fill_observation
from holodrive.robots.spec import Robot
from holodrive.types import Command, Decision, DutyCommand, Estimate, Observation, Reference, Twist, WheelCommand


class KernelController:
    """An `interfaces.Controller` around a plug's kernel.

    Attributes:
        plug: the parameters; its `faults`, if it has any, are the texts of the fault numbers.
        memory: what the kernel keeps between ticks.
    """

    def __init__(self, plug: ControllerPlug, robot: Robot) -> None:
        self.plug = plug
        self.command_kind: CommandKind = plug.command_kind
        self._wheels, self._steered = len(robot.wheels), len(robot.steered)
        self._observation = empty_observation(robot.lidar.beams if robot.lidar else 0)
        self.memory = np.zeros(max(1, plug.memory_size(robot)))
        self._faults: dict[int, str] = getattr(plug, "faults", {})
        self._params = plug.pack(robot)
        self._command = np.zeros(layout.COMMAND_SIZE)

    def reset(self) -> None:
        """Forget everything."""
        self.memory[:] = 0.0

    def step(self, reference: Reference, estimate: Estimate, observation: Observation) -> Decision:
        """One tick."""
        self._command[:] = 0.0
        fill_observation(self._observation, observation, estimate, reference)
        self.plug.kernel(self._observation, self.memory, self._params, self._command)
        out = self._command.tolist()
        return Decision(
            self._as_command(out),
            out[layout.ARRIVED] != 0.0,
            self._fault(out[layout.FAULT]),
            out[layout.NO_RULE] != 0.0,
        )

    def _fault(self, number: float) -> str:
        if not number:
            return ""
        text = self._faults.get(int(number))
        return f"controller fault {number:g}" + (f": {text}" if text else "")

    def _as_command(self, out: list[float]) -> Command:
        if self.command_kind == "twist":
            return Twist(*out[:3])
        values = tuple(out[: self._wheels])
        steer = tuple(out[layout.COMMAND_STEER : layout.COMMAND_STEER + self._steered])
        return WheelCommand(values, steer) if self.command_kind == "wheels" else DutyCommand(values, steer)
