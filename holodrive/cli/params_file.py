"""`--params`: a controller's parameters from a file, such as `holodrive tune` writes."""

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import click

from holodrive.errors import InputError

Function = Callable[..., Any]


def params_option(function: Function) -> Function:
    """Adds the option; the file arrives as `params_path`."""
    text = "Parameters of the controller from a file of holodrive tune; --set comes on top."
    return click.option("--params", "params_path", metavar="FILE", type=click.Path(), help=text)(function)


def with_file(path: str | None, controller: str, params: dict[str, Any]) -> tuple[str, dict[str, Any]]:
    """The controller and its parameters, `params` over those of the file.

    The file's controller is taken where the user named none with -c.

    Raises:
        InputError: the file holds no parameters, or those of another controller.
    """
    if path is None:
        return controller, params
    try:
        values = json.loads(Path(path).read_text(encoding="utf-8"))
    except OSError as error:
        raise InputError(f"--params: {path} cannot be read: {error.strerror}") from error
    except ValueError as error:
        raise InputError(f"--params: {path} is no JSON: {error}") from error
    if not isinstance(values, dict) or not isinstance(values.get("params"), dict):
        raise InputError(f'--params: {path} has no "params"; it wants a file of holodrive tune')
    source = click.get_current_context().get_parameter_source("controller")
    own = values.get("controller", controller)
    if source is click.core.ParameterSource.DEFAULT:
        controller = own
    if own != controller:
        raise InputError(f"--params: {path} is for controller {own!r}, and -c says {controller!r}")
    return controller, {**values["params"], **params}
