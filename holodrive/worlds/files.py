"""World files: TOML to `World` and back, the shipped catalog, the schema for editors, the start of a new file."""

import json
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

from holodrive.files import library
from holodrive.files.source import Migration, open_text, read
from holodrive.worlds.spec import World

SCHEMA = 1
MIGRATIONS: dict[int, Migration] = {}  # from schema n to the function that makes a table of schema n + 1

_HERE = Path(__file__).parent
CATALOG = _HERE / "catalog"


def names() -> tuple[str, ...]:
    """The shipped worlds."""
    return library.names(CATALOG)


def load(name_or_path: str | Path, overrides: Mapping[str, object] | None = None) -> World:
    """A shipped world by its name, or a world file by its path.

    Args:
        name_or_path: "open", or a path that ends in `.toml`.
        overrides: dotted key -> value, as `--set` gives them: {"goal.tolerance": "5 cm", "circle.1.radius": 0.2}.

    Raises:
        UnknownName: no world of that name.
        FileFaults: all that is wrong in the file or the overrides.
    """
    text, file = read(library.find("world", CATALOG, name_or_path))
    return parse(text, file, overrides)


def parse(text: str, file: str = "world.toml", overrides: Mapping[str, object] | None = None) -> World:
    """The world that a TOML text describes; `file` is its name in messages."""
    from holodrive.worlds.assemble import world

    source = open_text(text, file, newest=SCHEMA, migrations=MIGRATIONS, overrides=overrides)
    found = world(source)
    return replace(found, text=dump(found)) if overrides else found


def dump(world: World) -> str:
    """A canonical file, in SI at full precision; `parse(dump(world))` equals `world` but for `text`."""
    from holodrive.worlds.canonical import text

    return text(world)


def schema() -> dict[str, Any]:
    """The JSON Schema of world files, as it is shipped."""
    found: dict[str, Any] = json.loads((_HERE / "world.schema.json").read_text(encoding="utf-8"))
    return found


def template(name: str) -> str:
    """A commented world file to start from, valid as it is."""
    from holodrive.files.write import value

    return (_HERE / "template.toml").read_text(encoding="utf-8").replace('"NAME"', value(name))
