"""`holodrive new`."""

import json
import keyword
from importlib import import_module
from pathlib import Path

import click

from holodrive.cli.options import out_option, verb
from holodrive.cli.output import Output
from holodrive.errors import InputError


@verb("new", ["robot my_base", "controller my_controller -o my_controller.py"])
@click.argument("kind", type=click.Choice(["robot", "world", "controller"]))
@click.argument("name")
@out_option("File to write; NAME.toml or NAME.py when not given.")
@click.option("--schema", is_flag=True, help="Also write the JSON Schema beside it: editors then complete and check.")
@click.option("--force", is_flag=True, help="Write over a file that is there.")
def command(out: Output, kind: str, name: str, path: str | None, schema: bool, force: bool) -> None:
    """Write a commented start for a robot, a world or a controller called NAME."""
    if not name.isidentifier() or keyword.iskeyword(name):
        raise InputError(f"{name!r} is no good name: use letters, digits and _, such as my_{kind}")
    target = Path(path or f"{name}.{'py' if kind == 'controller' else 'toml'}")
    if target.exists() and not force:
        raise InputError(f"{target} is there already; --force writes over it, -o FILE writes elsewhere")
    target.parent.mkdir(parents=True, exist_ok=True)
    target.write_text(_text(kind, name), encoding="utf-8")
    written = [str(target)]
    if schema and kind != "controller":
        beside = target.with_name(f"{kind}.schema.json")
        beside.write_text(json.dumps(import_module(f"holodrive.{kind}s").schema(), indent=2), encoding="utf-8")
        written.append(str(beside))
    after = {
        "robot": f"holodrive check {target}",
        "world": f"holodrive check {target}",
        "controller": f"python {target}",
    }
    if out.json:
        out.data({"kind": kind, "name": name, "files": written, "next": after[kind]})
        return
    out.line("wrote", ", ".join(written))
    out.next(after[kind])


def _text(kind: str, name: str) -> str:
    if kind == "robot":
        from holodrive import robots

        return robots.template(name)
    if kind == "world":
        from holodrive import worlds

        return worlds.template(name)
    source = Path(__file__).with_name("controller_template.txt").read_text(encoding="utf-8")
    return source.replace("NAME", name)
