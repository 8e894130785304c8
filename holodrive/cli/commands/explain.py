"""`holodrive explain`."""

from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from holodrive.cli.options import checked_ending, out_option, verb
from holodrive.cli.output import Output
from holodrive.errors import InputError, UnknownName

if TYPE_CHECKING:
    from holodrive.control.fuzzy.lint import Finding
    from holodrive.control.fuzzy.system import System

_SYSTEMS = (".fis", ".fcl", ".fml", ".xml", ".c", ".h")


@verb("explain", ["repaired --at DH=700,DL=300,DR=2500", "paper_viii --surface DH,DL -o surface.svg"])
@click.argument("system")
@click.option("--at", metavar="NAME=VALUE,...", help="Explain what comes out at this input, in the system's own units.")
@click.option("--lint", "only_lint", is_flag=True, help="The linter's findings only; exit code 1 when one is an error.")
@click.option("--surface", metavar="NAME,NAME", help="The two inputs of the control surface; -o says where to draw it.")
@click.option("--sensor-range", metavar="LOW,HIGH", help="What the inputs' sensor can tell, for the linter.")
@click.option("--no-clamp", is_flag=True, help="Leave inputs beyond their range as they are.")
@out_option("Write .html (all of it), .svg (surface), or the system as .fis, .fcl, .fml, .xml, .c or .h.")
def command(
    out: Output, system: str, at: str | None, only_lint: bool, surface: str | None, sensor_range: str | None,
    no_clamp: bool, path: str | None,
) -> int:  # fmt: skip
    """What is in a fuzzy SYSTEM (a profile or a .fis, .fcl, .fml file), what is wrong with it, what it does and why."""
    checked_ending(path, "-o", ".html", ".svg", *_SYSTEMS)
    if surface and not (path and path.lower().endswith((".svg", ".html"))):
        raise InputError("--surface is a picture: say where to with -o surface.svg or -o page.html")
    from holodrive.control import fuzzy
    from holodrive.control.fuzzy.lint import lint

    loaded = fuzzy.load(system)
    point = point_of(loaded, at) if at else None
    across = _across(loaded, surface)
    limits = range_of(sensor_range) if sensor_range else None
    found = lint(loaded, limits)
    if path:
        _write(loaded, Path(path), point, across, limits, not no_clamp)
    told = loaded.explain(point, not no_clamp) if point else None
    if out.json:
        data = {} if only_lint else _described(loaded)
        data |= {"findings": [_plain(one) for one in found]}
        out.data(data | ({"explanation": told.data()} if told else {}))
    else:
        if not only_lint:
            out.text(told.text() if told else _text(loaded))
        if only_lint or not told:
            out.text("\n".join(map(str, found)) or "lint    nothing found")
        if path:
            out.line("wrote", path)
    out.next(_next(system, loaded, at, path, no_clamp))
    return int(only_lint and any(one.severity == "error" for one in found))


def point_of(system: "System", text: str) -> list[float]:
    """`DH=700,DL=300,DR=2500` as values in the order of the inputs.

    Raises:
        InputError: an input missing, twice, or no number.
        UnknownName: no such input.
    """
    names = [v.name for v in system.inputs]
    values: dict[str, float] = {}
    example = ",".join(f"{v.name}={0.5 * (v.low + v.high):g}" for v in system.inputs)
    for part in text.split(","):
        name, equals, number = (piece.strip() for piece in part.partition("="))
        if not equals:
            raise InputError(f"--at wants NAME=VALUE for every input, such as {example}; found {part.strip()!r}")
        if name not in names:
            raise UnknownName("fuzzy input", name, names)
        if name in values:
            raise InputError(f"--at gives {name} twice")
        values[name] = _number(number, f"--at {name}")
    missing = [name for name in names if name not in values]
    if missing:
        raise InputError(f"--at says nothing about {', '.join(missing)}; it wants every input, such as {example}")
    return [values[name] for name in names]


def range_of(text: str) -> tuple[float, float]:
    """`120,3000` as two numbers."""
    parts = text.split(",")
    if len(parts) != 2:
        raise InputError(f"--sensor-range wants LOW,HIGH, such as 120,3000; found {text!r}")
    return _number(parts[0], "--sensor-range"), _number(parts[1], "--sensor-range")


def _number(text: str, what: str) -> float:
    try:
        return float(text)
    except ValueError:
        raise InputError(f"{what} wants a number; found {text.strip()!r}") from None


def _across(system: "System", text: str | None) -> tuple[str, str] | None:
    if text is None:
        return None
    names = [part.strip() for part in text.split(",")]
    for name in names:
        system.input_index(name)
    if len(names) != 2 or names[0] == names[1]:
        raise InputError(f"--surface wants two different inputs, such as DH,DL; found {text!r}")
    return names[0], names[1]


def _write(
    system: "System", path: Path, point: list[float] | None, across: tuple[str, str] | None,
    limits: tuple[float, float] | None, clamp: bool,
) -> None:  # fmt: skip
    ending = path.suffix.lower()
    if ending in _SYSTEMS:
        from holodrive.control.fuzzy import files

        files.write(system, path)
        return
    from holodrive.reports.fuzzy import FuzzySection, surfaces_svg

    if ending == ".html":
        from holodrive.reports.page import report

        report(FuzzySection(system, point, across, limits, clamp)).save(path)
        return
    names = across or tuple(v.name for v in system.inputs[:2])
    if len(names) != 2:
        raise InputError(f"{system.name!r} has one input; a control surface needs two")
    path.write_text(surfaces_svg(system, (names[0], names[1]), point, clamp), encoding="utf-8")


def _text(system: "System") -> str:
    lines = [f"{'system':<8}{system.name}" + (f": {system.source}" if system.source else "")]
    joins = f"AND {system.conjunction}, OR {system.disjunction}, {system.implication}, {system.aggregation}"
    lines.append(f"{'kind':<8}{system.kind}, {len(system.rules)} rules, {joins}, {system.defuzzification}")
    for what, variables in (("input", system.inputs), ("output", system.outputs)):
        for variable in variables:
            unit = f" {variable.unit}" if variable.unit else ""
            lines.append(f"{what:<8}{variable.name}  {variable.low:g}..{variable.high:g}{unit}")
            for one in variable.sets:
                lines.append(f"{'':<8}  {one.name:<6} {one.kind:<10} {', '.join(f'{p:g}' for p in one.params)}")
    return "\n".join([*lines, ""])


def _described(system: "System") -> dict[str, Any]:
    names = ("name", "source", "kind", "conjunction", "disjunction", "implication", "aggregation", "defuzzification")
    return {name: getattr(system, name) for name in names} | {
        "inputs": [_variable(v) for v in system.inputs],
        "outputs": [_variable(v) for v in system.outputs],
        "rules": len(system.rules),
    }


def _variable(variable: Any) -> dict[str, Any]:
    sets = [{"name": one.name, "kind": one.kind, "params": one.params} for one in variable.sets]
    return {"name": variable.name, "unit": variable.unit, "low": variable.low, "high": variable.high, "sets": sets}


def _plain(one: "Finding") -> dict[str, Any]:
    names = ("code", "severity", "text", "variable", "rules", "at", "value")
    return {name: getattr(one, name) for name in names}


def _next(name: str, system: "System", at: str | None, path: str | None, no_clamp: bool) -> str:
    if path and path.lower().endswith((".html", ".svg")):
        return f"open {path}"
    if at is None:
        middle = ",".join(f"{v.name}={0.5 * (v.low + v.high):g}" for v in system.inputs)
        return f"holodrive explain {name} --at {middle}"
    return f"holodrive explain {name} --at {at}{' --no-clamp' * no_clamp} -o explained.html"
