"""The JSON Schema of world files. `python -m holodrive.worlds.json_schema` writes it anew."""

from pathlib import Path
from typing import Any

from holodrive.files.edge import Form
from holodrive.files.json_schema import Schema, definitions, document, ref, text
from holodrive.worlds.checks import ACCEPTABLE
from holodrive.worlds.form import ArenaForm, BoxForm, CircleForm, GoalForm, MoverForm, StartForm, WallForm, WorldForm

FOLDER = Path(__file__).parent


def world() -> Schema:
    """Of world files."""
    single: dict[str, type[Form]] = {"world": WorldForm, "arena": ArenaForm, "start": StartForm, "goal": GoalForm}
    lists: dict[str, type[Form]] = {"circle": CircleForm, "wall": WallForm, "box": BoxForm, "mover": MoverForm}
    parts = definitions([*single.values(), *lists.values()])
    parts["WorldForm"]["properties"]["accept"]["items"] = {"enum": list(ACCEPTABLE)}
    parts["ArenaForm"]["dependencies"] = {"width": ["height"], "height": ["width"]}
    properties: dict[str, Any] = {name: ref(form) for name, form in single.items()}
    properties |= {name: {"type": "array", "items": ref(form)} for name, form in lists.items()}
    return document("holodrive world file", properties, ["world"], parts)


SHIPPED = {"world.schema.json": world}

if __name__ == "__main__":
    for name, make in SHIPPED.items():
        (FOLDER / name).write_text(text(make()), encoding="utf-8")
