"""Controllers of one's own, without a class: a plain function, or a compiled kernel."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from holodrive.errors import InputError
from holodrive.interfaces import CommandKind
from holodrive.robots.spec import Robot
from holodrive.types import Array, Command, Decision, Estimate, Observation, Reference, Twist

Law = Callable[[Reference, Estimate, Observation], Command | Decision]


class FunctionController:
    """An `interfaces.Controller` around `f(reference, estimate, observation) -> Twist`.

    The function may also give wheel speeds, duty (calibration only) or a whole `Decision`.
    """

    command_kind: CommandKind = "twist"

    def __init__(self, law: Law) -> None:
        self._law = law

    def reset(self) -> None:
        """A function has nothing to forget."""

    def step(self, reference: Reference, estimate: Estimate, observation: Observation) -> Decision:
        """Ask the function."""
        answer = self._law(reference, estimate, observation)
        if isinstance(answer, Decision):
            return answer
        if isinstance(answer, Command):
            return Decision(answer)
        try:
            vx, vy, omega = answer
        except (TypeError, ValueError):
            raise InputError(
                f"the controller {getattr(self._law, '__name__', self._law)!r} gave {answer!r}; "
                "it must give a Twist, a WheelCommand, a DutyCommand or a Decision"
            ) from None
        return Decision(Twist(vx, vy, omega))


@dataclass(frozen=True, eq=False)
class KernelPlug:
    """A user's own `@njit` kernel `(obs, memory, params, command)` as a `interfaces.ControllerPlug`.

    Attributes:
        kernel: over the arrays of `holodrive.layout`; it need not be compiled for anything else than float64 vectors.
        command_kind: what `command` means.
        params: its numbers.
        memory: how many float64 it keeps between ticks.
    """

    kernel: Any
    command_kind: CommandKind = "twist"
    params: tuple[float, ...] = ()
    memory: int = 0

    def memory_size(self, robot: Robot) -> int:
        """As given."""
        return self.memory

    def pack(self, robot: Robot) -> Array:
        """As given; at least one number, so that the vector is never empty."""
        return np.array(self.params or (0.0,), dtype=np.float64)
