"""Robot files: TOML to `Robot` and back, the shipped catalog, the schema for editors, the start of a new file."""

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from holodrive.files import library
from holodrive.files.source import Migration, open_text, read
from holodrive.robots.spec import Robot

SCHEMA = 1
MIGRATIONS: dict[int, Migration] = {}  # from schema n to the function that makes a table of schema n + 1
COLLECTIONS = ("wheel", "sensor.mouse", "linearizer", "pwm_map")
LIBRARIES = ("motor", "encoder")  # keys whose text is a name of a library

_HERE = Path(__file__).parent
CATALOG = _HERE / "catalog"


def names() -> tuple[str, ...]:
    """The shipped robots."""
    return library.names(CATALOG)


def load(name_or_path: str | Path, overrides: Mapping[str, object] | None = None) -> Robot:
    """A shipped robot by its name, or a robot file by its path.

    Args:
        name_or_path: "hybrid3", or a path that ends in `.toml`.
        overrides: dotted key -> value, as `--set` gives them: {"wheel.front.radius": "50 mm"}.

    Raises:
        UnknownName: no robot of that name.
        FileFaults: all that is wrong in the file or the overrides.
    """
    text, file = read(library.find("robot", CATALOG, name_or_path))
    return parse(text, file, overrides)


def parse(text: str, file: str = "robot.toml", overrides: Mapping[str, object] | None = None) -> Robot:
    """The robot that a TOML text describes; `file` is its name in messages."""
    from dataclasses import replace

    from holodrive.robots.assemble import robot

    names: dict[str, tuple[str, ...]] = {"collections": COLLECTIONS, "libraries": LIBRARIES}
    source = open_text(text, file, newest=SCHEMA, migrations=MIGRATIONS, overrides=overrides, **names)
    found = robot(source)
    return replace(found, text=dump(found)) if overrides else found


def dump(robot: Robot) -> str:
    """A canonical file: every value written, in SI, at full precision, nothing that lives in a library.

    `parse(dump(robot))` equals `robot` but for `text`.
    """
    from holodrive.robots.canonical import text

    return text(robot)


def schema() -> dict[str, Any]:
    """The JSON Schema of robot files, as it is shipped."""
    found: dict[str, Any] = json.loads((_HERE / "robot.schema.json").read_text(encoding="utf-8"))
    return found


def template(name: str) -> str:
    """A commented robot file to start from, valid as it is."""
    from holodrive.files.write import value

    return (_HERE / "template.toml").read_text(encoding="utf-8").replace('"NAME"', value(name))
