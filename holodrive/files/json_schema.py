"""JSON Schemas for editors, made from the same forms that check the files."""

import json
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from pydantic.json_schema import models_json_schema

from holodrive.files.edge import Form

DRAFT = "http://json-schema.org/draft-07/schema#"  # the draft that TOML editors know
NAME_PATTERN = r"^[\w-]{1,60}$"
Schema = dict[str, Any]


def definitions(forms: Sequence[type[Form]]) -> dict[str, Schema]:
    """The schema of each form and of those inside it, by class name."""
    _, found = models_json_schema([(form, "validation") for form in forms], ref_template="#/definitions/{model}")
    return {name: _tidy(schema) for name, schema in found["$defs"].items()}


def document(title: str, properties: dict[str, Schema], required: list[str], parts: dict[str, Schema]) -> Schema:
    """A whole file: its tables, which of them it must have, and the definitions they refer to."""
    number = {"const": 1, "description": "the number of this form of file; always 1 so far"}
    return {
        "$schema": DRAFT,
        "title": title,
        "type": "object",
        "properties": {"schema": number, **properties},
        "required": ["schema", *required],
        "additionalProperties": False,
        "definitions": parts,
    }


def ref(form: type[Form]) -> Schema:
    """A reference to the definition of a form."""
    return {"$ref": f"#/definitions/{form.__name__}"}


def by_name(content: Schema) -> Schema:
    """A table of named tables."""
    return {"type": "object", "patternProperties": {NAME_PATTERN: content}, "additionalProperties": False}


def text(schema: Schema) -> str:
    """As it is shipped."""
    return json.dumps(schema, indent=1, ensure_ascii=True) + "\n"


def is_current(schema: Schema, file: Path) -> bool:
    """Whether the shipped file says the same."""
    return file.read_text(encoding="utf-8") == text(schema)


def _tidy(node: Any) -> Any:
    """Without what only pydantic says: generated titles, and null, which TOML does not have."""
    if isinstance(node, list):
        return [_tidy(item) for item in node]
    if not isinstance(node, dict):
        return node
    tidy = {
        key: _tidy(value)
        for key, value in node.items()
        if not (key == "title" and isinstance(value, str)) and not (key == "default" and value is None)
    }
    if "properties" in tidy:  # a field may itself be called title
        tidy["properties"] = {name: _tidy(field) for name, field in node["properties"].items()}
    options = tidy.get("anyOf")
    if isinstance(options, list):
        kept = [option for option in options if option != {"type": "null"}]
        if len(kept) == 1:
            del tidy["anyOf"]
            tidy = {**kept[0], **tidy}
        else:
            tidy["anyOf"] = kept
    return tidy
