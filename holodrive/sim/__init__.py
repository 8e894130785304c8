"""SIMULATE: physics, sensors, `SimBase` for the ordinary loop and `rollout` for compiled batches."""

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from holodrive.sim.base import SimBase
    from holodrive.sim.batch import Rollout, rollout

__all__ = ["Rollout", "SimBase", "rollout"]


def __getattr__(name: str) -> Any:
    # compiling the roll-out takes seconds: only who asks for it waits
    if name == "SimBase":
        from holodrive.sim.base import SimBase

        return SimBase
    if name in ("Rollout", "rollout"):
        from importlib import import_module

        return getattr(import_module("holodrive.sim.batch"), name)
    raise AttributeError(f"module 'holodrive.sim' has no attribute {name!r}")
