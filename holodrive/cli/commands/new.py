"""`holodrive new`."""

import keyword
from pathlib import Path

import click

from holodrive.cli.options import out_option, verb
from holodrive.cli.output import Output
from holodrive.errors import InputError


@verb("new", ["robot my_base", "controller my_controller -o my_controller.py"])
@click.argument("kind", type=click.Choice(["robot", "world", "controller"]))
@click.argument("name")
@out_option("File to write; NAME.toml or NAME.py when not given.")
@click.option("--force", is_flag=True, help="Write over a file that is there.")
def command(out: Output, kind: str, name: str, path: str | None, force: bool) -> None:
    """Write a commented start for a robot, a world or a controller called NAME."""
    if not name.isidentifier() or keyword.iskeyword(name):
        raise InputError(f"{name!r} is no good name: use letters, digits and _, such as my_{kind}")
    target = Path(path or f"{name}.{'py' if kind == 'controller' else 'toml'}")
    if target.exists() and not force:
        raise InputError(f"{target} is there already; --force writes over it, -o FILE writes elsewhere")
    target.parent.mkdir(parents=True, exist_ok=True)
    target.write_text(_text(kind, name), encoding="utf-8")
    after = {
        "robot": f"holodrive check {target}",
        "world": f"holodrive check {target}",
        "controller": f"python {target}",
    }
    if out.json:
        out.data({"kind": kind, "name": name, "file": str(target), "next": after[kind]})
        return
    out.line("wrote", str(target))
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
