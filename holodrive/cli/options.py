"""What the verbs have in common: their frame (-q, -v, --json, examples) and the options that several of them take."""

import functools
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import click

from holodrive.cli.output import Output
from holodrive.errors import InputError

Function = Callable[..., Any]


def verb(name: str, examples: Sequence[str]) -> Callable[[Function], click.Command]:
    """Makes a function `f(out, ...)` the command `name`, with the common options and its examples in the help."""

    def wrap(function: Function) -> click.Command:
        @functools.wraps(function)
        @click.pass_context
        def call(ctx: click.Context, /, *args: Any, quiet: bool, verbose: bool, as_json: bool, **kwargs: Any) -> Any:
            out = ctx.ensure_object(Output)
            out.set(quiet=quiet, verbose=verbose, json=as_json)
            return function(out, *args, **kwargs)

        call = click.option("--json", "as_json", is_flag=True, help="The result as JSON.")(call)
        call = click.option("-v", "--verbose", is_flag=True, help="Say more; show the trace of an error.")(call)
        call = click.option("-q", "--quiet", is_flag=True, help="No progress and no hints.")(call)
        epilog = "\b\nExamples:\n" + "\n".join(f"  holodrive {name} {example}".rstrip() for example in examples)
        return click.command(name, epilog=epilog, context_settings={"help_option_names": ["-h", "--help"]})(call)

    return wrap


def robot_argument(function: Function) -> Function:
    """ROBOT: a name of the catalog or a file."""
    return click.argument("robot", shell_complete=_complete("robots"))(function)


def world_option(function: Function) -> Function:
    """-w: a name of the catalog or a file."""
    text = "World, by name or file; the open floor when not given."
    return click.option("-w", "--world", metavar="WORLD", help=text, shell_complete=_complete("worlds"))(function)


def seed_option(function: Function) -> Function:
    """--seed: of all noise."""
    return click.option(
        "--seed", type=click.IntRange(0, 2**63 - 1), default=0, show_default=True, help="Of all noise."
    )(function)


def plant_option(function: Function) -> Function:
    """--plant: which physics."""
    choice = click.Choice(["first_order", "slip", "pwm_map", "motors"])
    text = (
        "Physics: wheels that follow with a lag; motors and wheel slip; the robot's measured actuators; "
        "or motors in full, commutation and steering included."
    )
    return click.option("--plant", type=choice, default="first_order", show_default=True, help=text)(function)


def estimator_option(function: Function) -> Function:
    """--estimator: how the robot knows where it is."""
    text = "How the robot knows where it is; auto is by wheels, or by mice without encoders."
    return click.option("--estimator", metavar="NAME", default="auto", show_default=True, help=text)(function)


def set_option(function: Function) -> Function:
    """--set key=value, as often as wanted."""
    text = "Another value for a key of the robot's file, or of the controller: controller.KEY=VALUE. May be repeated."
    return click.option("--set", "settings", multiple=True, metavar="KEY=VALUE", help=text)(function)


def out_option(text: str, required: bool = False) -> Callable[[Function], Function]:
    """-o: the file to write."""
    return click.option("-o", "--out", "path", type=click.Path(), required=required, help=text)


def checked_ending(path: str | None, option: str, *endings: str) -> None:
    """Refuse a file to write before any work: its ending is not one of these, or there is no folder to write it to.

    Another ending may be something else that would be lost; without a folder the work itself would be.

    Raises:
        InputError: naming the option and what is allowed.
    """
    if not path:
        return
    if not path.lower().endswith(endings):
        raise InputError(f"{option} writes {' or '.join(endings)}; found {path!r}")
    if not Path(path).parent.is_dir():
        folder = str(Path(path).parent)
        raise InputError(f"{option} cannot write {path}: no folder {folder!r}; make it, or choose another place")


def split_settings(settings: Sequence[str]) -> tuple[dict[str, Any], dict[str, Any]]:
    """`KEY=VALUE` texts as (overrides of the robot, parameters of the controller)."""
    robot: dict[str, Any] = {}
    controller: dict[str, Any] = {}
    for setting in settings:
        key, equals, text = setting.partition("=")
        if not equals or not key.strip() or not text.strip():
            raise InputError(f"--set wants KEY=VALUE, such as wheel.front.radius=50mm; found {setting!r}")
        key, text = key.strip(), text.strip()
        if key.startswith("controller."):
            controller[key.removeprefix("controller.")] = value_of(text)
        else:
            robot[key] = text  # read as the value of a TOML key, or as text with a unit
    return robot, controller


def value_of(text: str) -> Any:
    """A number, true or false when it reads as one, else the text (which may hold a unit)."""
    if text in ("true", "false"):
        return text == "true"
    for kind in (int, float):
        try:
            return kind(text)
        except ValueError:
            continue
    return text


def pose_of(text: str, what: str) -> tuple[float, ...]:
    """`x,y` or `x,y,heading`: metres and radians, or with a unit (`50cm,2m,90deg`)."""
    parts = [part.strip() for part in text.split(",")]
    if len(parts) not in (2, 3):
        raise InputError(f"{what} wants x,y or x,y,heading, such as 0.5,4.5 or 1,2,90deg; found {text!r}")
    return tuple(quantity_of(part, what, "angle" if i == 2 else "length") for i, part in enumerate(parts))


def quantity_of(text: str, what: str, dimension: str) -> float:
    """A plain SI number or text with a unit, as SI."""
    from holodrive.files import units

    value = value_of(text)
    try:
        return units.parse(value, dimension)
    except units.QuantityError as error:
        raise InputError(f"{what}: {error}") from error


def _complete(catalog: str) -> Callable[[click.Context, click.Parameter, str], list[Any]]:
    def complete(ctx: click.Context, parameter: click.Parameter, incomplete: str) -> list[Any]:
        from importlib import import_module

        from click.shell_completion import CompletionItem

        names = [name for name in import_module(f"holodrive.{catalog}").names() if name.startswith(incomplete)]
        return names or [CompletionItem(incomplete, type="file")]

    return complete
