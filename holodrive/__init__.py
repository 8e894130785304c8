"""Omnidirectional (holonomic) mobile robots: describe, simulate, drive, record, replay.

>>> import holodrive as hd
>>> robot = hd.load("hybrid3")
>>> [round(row, 4) for row in hd.Chassis.of(robot).jacobian[1].tolist()]
[26.7848, 7.177, 4.5098]

Everything heavy is imported when it is first asked for.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

from holodrive import _numba_cache

__version__ = "0.1.0"

_numba_cache.use_own_folder()

# name -> module that has it; the vocabulary of the package on one page
_WHERE = {
    "load": "holodrive.build",
    "world": "holodrive.build",
    "simulate": "holodrive.build",
    "drive": "holodrive.build",
    "plan": "holodrive.build",
    "rollout": "holodrive.build",
    "report": "holodrive.reports",
    "replay": "holodrive.build",
    "rerun": "holodrive.build",
    "compare": "holodrive.log",
    "render": "holodrive.reports",
    "export": "holodrive.reports",
    "read": "holodrive.log",
    "Chassis": "holodrive.kinematics",
    "Wheel": "holodrive.kinematics",
    "Robot": "holodrive.robots.spec",
    "World": "holodrive.worlds.spec",
    "Run": "holodrive.log.run",
    "Pose": "holodrive.types",
    "Twist": "holodrive.types",
    "WheelCommand": "holodrive.types",
    "DutyCommand": "holodrive.types",
    "WheelState": "holodrive.types",
    "Scan": "holodrive.types",
    "Observation": "holodrive.types",
    "Estimate": "holodrive.types",
    "Reference": "holodrive.types",
    "Decision": "holodrive.types",
    "HolodriveError": "holodrive.errors",
}
_MODULES = ("control", "errors", "estimation", "geometry", "kinematics", "planning", "references", "robots", "worlds")

__all__ = [
    "Chassis",
    "Decision",
    "DutyCommand",
    "Estimate",
    "HolodriveError",
    "Observation",
    "Pose",
    "Reference",
    "Robot",
    "Run",
    "Scan",
    "Twist",
    "Wheel",
    "WheelCommand",
    "WheelState",
    "World",
    "__version__",
    "compare",
    "control",
    "drive",
    "errors",
    "estimation",
    "export",
    "geometry",
    "kinematics",
    "load",
    "plan",
    "planning",
    "read",
    "references",
    "render",
    "replay",
    "report",
    "rerun",
    "robots",
    "rollout",
    "simulate",
    "world",
    "worlds",
]

if TYPE_CHECKING:
    from holodrive import control, errors, estimation, geometry, kinematics, planning, references, robots, worlds
    from holodrive.build import drive, load, plan, replay, rerun, rollout, simulate, world
    from holodrive.errors import HolodriveError
    from holodrive.kinematics import Chassis, Wheel
    from holodrive.log.compare import compare
    from holodrive.log.reader import read
    from holodrive.log.run import Run
    from holodrive.reports import export, render, report
    from holodrive.robots.spec import Robot
    from holodrive.types import (
        Decision,
        DutyCommand,
        Estimate,
        Observation,
        Pose,
        Reference,
        Scan,
        Twist,
        WheelCommand,
        WheelState,
    )
    from holodrive.worlds.spec import World


def __getattr__(name: str) -> Any:
    if name in _WHERE:
        value = getattr(import_module(_WHERE[name]), name)
    elif name in _MODULES:
        value = import_module(f"holodrive.{name}")
    else:
        raise AttributeError(f"module 'holodrive' has no attribute {name!r}")
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return __all__
