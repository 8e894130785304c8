"""Canonical TOML: plain SI numbers at full precision, so that reading it back gives the same floats."""

import math
import re
from collections.abc import Mapping, Sequence

_BARE = re.compile(r"[A-Za-z0-9_-]+")
_ESCAPES = {"\\": "\\\\", '"': '\\"', "\n": "\\n", "\t": "\\t", "\r": "\\r", "\b": "\\b", "\f": "\\f"}


def table(path: Sequence[str], values: Mapping[str, object], *, entry: bool = False) -> str:
    """A `[header]` (or `[[header]]`) with its keys; None and infinite values are left out, they have no text."""
    name = ".".join(key(part) for part in path)
    lines = [f"[[{name}]]" if entry else f"[{name}]"] if path else []
    lines += [f"{key(k)} = {value(v)}" for k, v in values.items() if not _absent(v)]
    return "\n".join(lines) + "\n"


def key(text: str) -> str:
    """A key, quoted when it must be."""
    return text if _BARE.fullmatch(text) else value(text)


def value(item: object) -> str:
    """A TOML value."""
    if isinstance(item, bool):
        return "true" if item else "false"
    if isinstance(item, int):
        return str(item)
    if isinstance(item, float):
        return repr(float(item))
    if isinstance(item, str):
        return '"' + "".join(_character(c) for c in item) + '"'
    if isinstance(item, Mapping):
        return "{ " + ", ".join(f"{key(k)} = {value(v)}" for k, v in item.items() if not _absent(v)) + " }"
    if isinstance(item, Sequence):
        return "[" + ", ".join(value(v) for v in item) + "]"
    raise TypeError(f"no TOML for {type(item).__name__}")


def _absent(item: object) -> bool:
    return item is None or (isinstance(item, float) and math.isinf(item))


def _character(character: str) -> str:
    if character in _ESCAPES:
        return _ESCAPES[character]
    return f"\\u{ord(character):04x}" if ord(character) < 32 or ord(character) == 127 else character
