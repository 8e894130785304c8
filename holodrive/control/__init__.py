"""Reference and estimate in, command out. A new controller is one file and one line in `CONTROLLERS`."""

import math
from dataclasses import fields
from importlib import import_module
from importlib.metadata import entry_points
from typing import Any

from holodrive.control.custom import FunctionController, KernelPlug
from holodrive.control.kernel import KernelController
from holodrive.control.parameters import made
from holodrive.errors import InputError, UnknownName
from holodrive.interfaces import Controller, ControllerPlug, PlainPlug
from holodrive.robots.spec import Robot
from holodrive.worlds.spec import World

# name -> "module:class" of a frozen parameter class (interfaces.ControllerPlug or PlainPlug)
CONTROLLERS: dict[str, str] = {
    "dob": "holodrive.control.disturbance_observer:Dob",
    "feed_forward": "holodrive.control.feed_forward:FeedForward",
    "ff_pi": "holodrive.control.ff_pi:FfPi",
    "fuzzy": "holodrive.control.fuzzy_avoidance:FuzzyAvoidance",
    "fuzzy_mpc": "holodrive.control.fuzzy_mpc:FuzzyMpc",
    "fuzzy_pd": "holodrive.control.fuzzy_pd:FuzzyPd",
    "fuzzy_pid": "holodrive.control.fuzzy_pid:FuzzyPid",
    "go_to_pose": "holodrive.control.go_to_pose:GoToPose",
    "la_g": "holodrive.control.la_g:LaG",
    "mpc": "holodrive.control.ltv_mpc:LtvMpc",
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


def plug(name: str, params: dict[str, Any] | None = None) -> ControllerPlug | PlainPlug:
    """A controller's parameters, `params` over its defaults.

    Raises:
        UnknownName: no such controller.
        InputError: no such parameter, or a value that it does not allow.
    """
    result: ControllerPlug | PlainPlug = made(f"controller {name}", plug_class(name), params or {})
    return result


def compiled(name: str, params: dict[str, Any] | None = None) -> ControllerPlug:
    """As `plug`, for roll-outs.

    Raises:
        UnknownName, InputError: as `plug`, or a controller without a kernel.
    """
    found: Any = plug(name, params)
    if not hasattr(found, "kernel"):
        with_kernel = [known for known in names() if hasattr(plug_class(known), "kernel")]
        raise InputError(
            f"controller {name!r} has no compiled kernel: it drives in the ordinary loop (hd.drive) only; "
            f"those for roll-outs: {', '.join(with_kernel)}"
        )
    result: ControllerPlug = found
    return result


def with_arrival(name: str, params: dict[str, Any] | None, world: World | None) -> dict[str, Any]:
    """`params` of a controller that drives to a world's goal: the goal's tolerances are its own where nothing is said.

    Args:
        name: of the controller; one without `arrive_m` and `arrive_rad` takes none.
        params: what the user said; it has precedence.
        world: None where the goal is not a world's.

    Raises:
        UnknownName: no such controller.
    """
    given = dict(params or {})
    if world is None or world.goal is None:
        return given
    known = {field.name for field in fields(plug_class(name))}
    wanted = {
        "arrive_m": world.goal.tolerance_m,
        "arrive_rad": world.goal.tolerance_rad if world.goal.heading_matters else math.pi,
    }
    return {**{key: value for key, value in wanted.items() if key in known}, **given}


def controller(what: Any, robot: Robot, params: dict[str, Any] | None = None) -> Controller:
    """A controller for the ordinary loop.

    Args:
        what: a registered name; a plug, compiled or plain; a controller; or a function of reference, estimate and
            observation.
        robot: to be driven.
        params: over a named controller's defaults.

    Raises:
        UnknownName, InputError: as `plug`, or something that cannot control.
    """
    if isinstance(what, str):
        return controller(plug(what, params), robot)
    if params:
        raise InputError("params go with a controller's name; set the parameters of a controller object on itself")
    if hasattr(what, "kernel"):
        return KernelController(what, robot)
    if hasattr(what, "controller"):
        plain: PlainPlug = what
        return plain.controller(robot)
    if hasattr(what, "step") and hasattr(what, "reset"):
        controller_object: Controller = what
        return controller_object
    if callable(what):
        return FunctionController(what)
    raise InputError(f"{what!r} is no controller: give a name, a function, or an object with step and reset")


__all__ = [
    "CONTROLLERS",
    "ENTRY_POINTS",
    "FunctionController",
    "KernelController",
    "KernelPlug",
    "compiled",
    "controller",
    "names",
    "plug",
    "plug_class",
    "with_arrival",
]
