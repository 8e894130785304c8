"""Reference and estimate in, command out. A new controller is one file and one line in `CONTROLLERS`."""

from importlib import import_module
from importlib.metadata import entry_points
from typing import Any

from holodrive.control.kernel import KernelController
from holodrive.control.parameters import made
from holodrive.errors import UnknownName
from holodrive.interfaces import Controller, ControllerPlug
from holodrive.robots.spec import Robot

# name -> "module:class" of a frozen parameter class (interfaces.ControllerPlug)
CONTROLLERS: dict[str, str] = {
    "go_to_pose": "holodrive.control.go_to_pose:GoToPose",
    "pid": "holodrive.control.pid:Pid",
}
ENTRY_POINTS = "holodrive.controllers"  # where other packages register theirs


def names() -> list[str]:
    """All controllers, ours and those of other installed packages."""
    return sorted({*CONTROLLERS, *(point.name for point in entry_points(group=ENTRY_POINTS))})


def plug_class(name: str) -> Any:
    """The parameter class of a controller.

    Raises:
        UnknownName: no such controller.
    """
    if name in CONTROLLERS:
        module, _, attribute = CONTROLLERS[name].partition(":")
        return getattr(import_module(module), attribute)
    for point in entry_points(group=ENTRY_POINTS, name=name):
        return point.load()
    raise UnknownName("controller", name, names())


def plug(name: str, params: dict[str, Any] | None = None) -> ControllerPlug:
    """A controller's parameters, `params` over its defaults.

    Raises:
        UnknownName: no such controller.
        InputError: no such parameter, or a value that it does not allow.
    """
    result: ControllerPlug = made(f"controller {name}", plug_class(name), params or {})
    return result


def controller(name: str, robot: Robot, params: dict[str, Any] | None = None) -> Controller:
    """A controller for the ordinary loop."""
    return KernelController(plug(name, params), robot)


__all__ = ["CONTROLLERS", "ENTRY_POINTS", "KernelController", "controller", "names", "plug", "plug_class"]
