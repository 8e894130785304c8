"""Every plug of the platform on one page. Implementations are final classes; none inherits from another."""

from typing import TYPE_CHECKING, Any, ClassVar, Literal, Protocol

from holodrive.types import Array, Command, Decision, DutyCommand, Estimate, Observation, Pose, Reference, WheelCommand

if TYPE_CHECKING:
    from holodrive.robots.spec import Robot

CommandKind = Literal["twist", "wheels", "duty"]


class Base(Protocol):
    """A robot that can be driven: simulated or real."""

    robot: "Robot"

    def observe(self) -> Observation:
        """What the sensors tell now."""
        ...

    def apply(self, command: WheelCommand | DutyCommand) -> WheelCommand | DutyCommand:
        """Hold the command for one control period (`robot.control_period_s`); give what was really sent."""
        ...

    def close(self) -> None:
        """Stop the wheels and let go; harmless when called twice."""
        ...


class Controller(Protocol):
    """Reference and estimate in, command out, once a control tick."""

    command_kind: CommandKind

    def reset(self) -> None:
        """Forget everything."""
        ...

    def step(self, reference: Reference, estimate: Estimate, observation: Observation) -> Decision:
        """One tick."""
        ...


class Estimator(Protocol):
    """Observations in, belief out, once a control tick, before the controller."""

    def reset(self, pose: Pose) -> None:
        """Start from a known pose."""
        ...

    def step(self, observation: Observation) -> Estimate:
        """One tick."""
        ...


class ReferenceSource(Protocol):
    """Where the robot shall be."""

    def reset(self) -> None:
        """Start from the beginning."""
        ...

    def step(self, time: float, pose: Pose) -> Reference:
        """The reference at `time` [s] since start, given where the robot believes to be."""
        ...


class Plug(Protocol):
    """Parameters of a compiled controller or estimator: a frozen dataclass that can pack itself.

    `kernel` is a module-level `@njit(cache=True)` function `(obs, memory, params, out)` over the arrays of
    `holodrive.layout`; `out` is a command for a controller, an estimate for an estimator.
    One kernel serves the roll-out and, wrapped (`control.kernel`, `estimation.kernel`), the ordinary loop.
    """

    kernel: ClassVar[Any]

    def memory_size(self, robot: "Robot") -> int:
        """How many float64 the kernel keeps between ticks; they start as zeros."""
        ...

    def pack(self, robot: "Robot") -> Array:
        """The parameters, and what of the robot the kernel needs, as one vector."""
        ...


class ControllerPlug(Plug, Protocol):
    """A compiled controller also says what its command means."""

    command_kind: ClassVar[CommandKind]


class PlainPlug(Protocol):
    """Parameters of a controller that cannot be compiled, such as one that calls a solver: it only drives in the loop.

    A frozen dataclass, registered as a `ControllerPlug` is; it has no `kernel`.
    """

    command_kind: ClassVar[CommandKind]

    def controller(self, robot: "Robot") -> Controller:
        """A controller for this robot, at its beginning."""
        ...


__all__ = [
    "Base",
    "Command",
    "CommandKind",
    "Controller",
    "ControllerPlug",
    "Estimator",
    "PlainPlug",
    "Plug",
    "ReferenceSource",
]
