"""Observations in, belief out. A new estimator is one file and one line in `ESTIMATORS`."""

from importlib import import_module
from typing import TYPE_CHECKING, Any

from holodrive.errors import InputError, UnknownName

if TYPE_CHECKING:
    from holodrive.estimation.evaluation import Evaluation, Medians, evaluate, medians
    from holodrive.estimation.fused_odometry import FusedOdometry
    from holodrive.estimation.kernel import KernelEstimator
    from holodrive.estimation.mouse_corrected import MouseCorrected
    from holodrive.estimation.mouse_odometry import MouseOdometry
    from holodrive.estimation.mouse_printed import MousePrinted
    from holodrive.estimation.odometry import Odometry, track
    from holodrive.estimation.wheel_odometry import WheelOdometry
    from holodrive.interfaces import Estimator, Plug
    from holodrive.robots.spec import Robot

# name -> "module:class" of a frozen parameter class (interfaces.Plug)
ESTIMATORS: dict[str, str] = {
    "ekf": "holodrive.estimation.ekf:Ekf",
    "fused_odometry": "holodrive.estimation.fused_odometry:FusedOdometry",
    "mouse_corrected": "holodrive.estimation.mouse_corrected:MouseCorrected",
    "mouse_odometry": "holodrive.estimation.mouse_odometry:MouseOdometry",
    "mouse_printed": "holodrive.estimation.mouse_printed:MousePrinted",
    "wheel_odometry": "holodrive.estimation.wheel_odometry:WheelOdometry",
}
# Numba and all that needs it is imported when it is first asked for
_WHERE = {
    "Evaluation": "holodrive.estimation.evaluation",
    "FusedOdometry": "holodrive.estimation.fused_odometry",
    "MouseCorrected": "holodrive.estimation.mouse_corrected",
    "MousePrinted": "holodrive.estimation.mouse_printed",
    "KernelEstimator": "holodrive.estimation.kernel",
    "Medians": "holodrive.estimation.evaluation",
    "MouseOdometry": "holodrive.estimation.mouse_odometry",
    "Odometry": "holodrive.estimation.odometry",
    "WheelOdometry": "holodrive.estimation.wheel_odometry",
    "evaluate": "holodrive.estimation.evaluation",
    "medians": "holodrive.estimation.evaluation",
    "track": "holodrive.estimation.odometry",
}


def names() -> list[str]:
    """All estimators."""
    return sorted(ESTIMATORS)


def plug_class(name: str) -> Any:
    """The parameter class of an estimator.

    Raises:
        UnknownName: no such estimator.
    """
    if name not in ESTIMATORS:
        raise UnknownName("estimator", name, ESTIMATORS)
    module, _, attribute = ESTIMATORS[name].partition(":")
    return getattr(import_module(module), attribute)


def default_name(robot: "Robot") -> str:
    """The estimator for a robot that asks for none ("auto"): by its wheels if all have encoders, else by its mice.

    Raises:
        InputError: it has neither an encoder on every wheel nor two mice.
    """
    if all(wheel.encoder is not None for wheel in robot.wheels):
        return "wheel_odometry"
    if sum(mouse.axes == "xy" for mouse in robot.mice) >= 2:
        return "mouse_odometry"
    blind = ", ".join(wheel.name for wheel in robot.wheels if wheel.encoder is None)
    raise InputError(
        f"{robot.name} cannot tell where it is: no encoder on {blind}, and {len(robot.mice)} mice where two are "
        "needed; give the wheels encoders, add [sensor.mouse.NAME], or name an estimator"
    )


def summary(name: str) -> str:
    """One line about an estimator: the first of its module."""
    return str(import_module(plug_class(name).__module__).__doc__).partition("\n")[0]


def plug(name: str) -> "Plug":
    """An estimator's parameters with their defaults."""
    result: Plug = plug_class(name)()
    return result


def estimator(name: str, robot: "Robot") -> "Estimator":
    """An estimator for the ordinary loop."""
    from holodrive.estimation.kernel import KernelEstimator

    return KernelEstimator(plug(name), robot)


def __getattr__(name: str) -> Any:
    if name not in _WHERE:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    value = getattr(import_module(_WHERE[name]), name)
    globals()[name] = value
    return value


__all__ = [
    "ESTIMATORS",
    "Evaluation",
    "FusedOdometry",
    "KernelEstimator",
    "Medians",
    "MouseCorrected",
    "MouseOdometry",
    "MousePrinted",
    "Odometry",
    "WheelOdometry",
    "default_name",
    "estimator",
    "evaluate",
    "medians",
    "names",
    "plug",
    "plug_class",
    "summary",
    "track",
]
