"""Changes to a TOML file that leave the rest of it as its author wrote it: comments, order, units, blank lines.

`edited` changes text, `save` writes a file in one step. Whoever edits a robot parses the new text before saving it
(`robots.parse(text, file)` raises all its faults), so that no change makes a good file a bad one:

    text = edited(robot.text, {"sensor.mouse.one.mount": {"x": 0.0123, "y": -0.0456, "yaw": 1.5712}})
    robots.parse(text, file)
    save(file, text)

The text is changed in place, at the offsets that `scan` finds, and read again after each change; at the end it must
mean exactly what was asked for, else it is refused.
"""

import math
import os
import re
import tempfile
import tomllib
from collections.abc import Mapping
from contextlib import suppress
from copy import deepcopy
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from holodrive.errors import InputError
from holodrive.files import write
from holodrive.files.scan import Statement, TooDeepError, scan, value_end
from holodrive.files.units import shown

Keys = tuple[str, ...]
_COMMENT = re.compile(r"([ \t]*)(#[^\n]*)?(?=\n|$)")


@dataclass(frozen=True, slots=True)
class Noted:
    """A value with a comment, which takes the place of the one on its line; inside `{ }` there is no place for it."""

    value: object
    comment: str


def edited(text: str, changes: Mapping[str, object]) -> str:
    """The text with other values at some paths.

    A value that is there is replaced on its line, and the comment behind it stays. A table is made equal to the one
    given: keys it has in common keep their place and comments, others go with their lines, new ones come at its end.
    What is not there yet is added: a key at the end of its table, a table behind its family or at the end of the file.

    Args:
        text: a TOML file.
        changes: path such as "sensor.mouse.one.mount" -> number, text, list, table, `Noted`, or None to remove.

    Raises:
        InputError: the text is no TOML, a path leads through something that is no table, or a value has no TOML.
    """
    found = text.replace("\r\n", "\n")
    wanted = _read(found)
    for path, value in changes.items():
        keys = tuple(path.split("."))
        if not all(keys):
            raise InputError(f"{path!r} is no path of a key; write it as sensor.mouse.one.mount")
        _set(wanted, keys, value)
        try:
            found = _change(found, keys, value)
        except (TooDeepError, KeyError, TypeError, ValueError):
            raise _by_hand(path) from None
    if _filled(_meaning(found)) != _filled(wanted):
        raise _by_hand(", ".join(changes))
    return found.replace("\n", "\r\n") if "\r\n" in text else found


def save(path: str | Path, text: str) -> None:
    """Write a file whole or not at all: whoever reads it sees the old text or the new one, even after a power cut.

    A link stays a link, and the file keeps its permissions.

    Raises:
        InputError: when it cannot be written; the file is then as it was.
    """
    temporary = None
    try:
        target = Path(os.path.realpath(path))
        descriptor, temporary = tempfile.mkstemp(dir=target.parent, prefix=f".{target.name[:100]}.", suffix=".part")
        with os.fdopen(descriptor, "w", encoding="utf-8", newline="") as stream:
            stream.write(text)
            stream.flush()
            os.fsync(stream.fileno())
        os.chmod(temporary, _mode(target))
        os.replace(temporary, target)
    except (OSError, ValueError) as error:
        if temporary is not None:
            with suppress(OSError):
                os.unlink(temporary)
        reason = error.strerror if isinstance(error, OSError) and error.strerror else str(error)
        raise InputError(f"{path} cannot be written: {reason.lower()}; nothing was changed") from None


def _mode(target: Path) -> int:
    """Permissions of the file, or of a new one."""
    if target.exists():
        return target.stat().st_mode & 0o777
    mask = os.umask(0)
    os.umask(mask)
    return 0o666 & ~mask


# --- what a change means -----------------------------------------------------------------------------


def _read(text: str) -> dict[str, Any]:
    try:
        return tomllib.loads(text)
    except (ValueError, RecursionError) as error:
        raise InputError(f"what is no TOML cannot be edited: {error}") from None


def _meaning(text: str) -> dict[str, Any] | None:
    try:
        return tomllib.loads(text)
    except (ValueError, RecursionError):
        return None


def _filled(table: dict[str, Any] | None) -> dict[str, Any] | None:
    """Without empty tables: one whose last entry went may be gone with it."""
    if table is None:
        return None
    inner = {key: _filled(value) if isinstance(value, dict) else value for key, value in table.items()}
    return {key: value for key, value in inner.items() if value != {}}


def _by_hand(path: str) -> InputError:
    return InputError(f"{path} cannot be changed in the way this file is written; change it by hand")


def _plain(value: object) -> Any:
    """The value as TOML has it: no notes, no numpy, no tuples."""
    if isinstance(value, Noted):
        return _plain(value.value)
    if isinstance(value, Mapping):
        return {str(key): _plain(inner) for key, inner in value.items() if inner is not None}
    if hasattr(value, "tolist"):  # numpy's arrays and numbers
        return _plain(value.tolist())
    if isinstance(value, list | tuple):
        return [_plain(inner) for inner in value]
    if isinstance(value, float) and not math.isfinite(value):
        raise InputError(f"{value!r} is not a finite number and has no place in a file")
    if isinstance(value, bool | int | float | str):
        return value
    raise InputError(f"{shown(value)} has no place in a TOML file")


def _set(table: dict[str, Any], keys: Keys, value: object) -> None:
    """The same change in plain tables."""
    for depth, key in enumerate(keys[:-1], 1):
        inner = table.get(key, {}) if value is None else table.setdefault(key, {})
        if not isinstance(inner, dict):
            raise InputError(f"{'.'.join(keys[:depth])} is {shown(inner)} and holds no keys")
        table = inner
    if value is None:
        table.pop(keys[-1], None)
    else:
        table[keys[-1]] = deepcopy(_plain(value))


def _at(table: Any, keys: Keys) -> Any:
    """What stands there, or None."""
    for key in keys:
        table = table.get(key) if isinstance(table, dict) else None
    return table


# --- the text -------------------------------------------------------------------------------------------


def _change(text: str, keys: Keys, value: object) -> str:
    note = value.comment if isinstance(value, Noted) else None
    value = value.value if isinstance(value, Noted) else value
    old = _at(_read(text), keys)
    if value is None:
        return text if old is None else _remove(text, keys)
    if isinstance(value, Mapping):
        in_line = old is not None and _pair_around(text, keys) is not None
        if isinstance(old, dict) and not in_line:
            return _merge(text, keys, old, value)
        if old is None and not in_line and not _is_line(text, keys, value):
            return _add_table(text, keys, value)
    plain = _plain(value)
    if isinstance(old, dict) and _pair_around(text, keys) is None:  # lines of its own give way to one
        text, old = _remove(text, keys), None
    if old is None:
        text = _add(text, keys, plain)
    elif repr(plain) != repr(old):  # what is the same stays as it is written
        text = _replace(text, keys, plain)
    return text if note is None else _annotate(text, keys, note)


def _is_line(text: str, keys: Keys, table: Mapping[str, object]) -> bool:
    """Whether a new table goes on a line `key = { ... }`: it holds plain values, and its own table has a header."""
    if _pair_around(text, keys[:-1]) is not None:
        return True
    return not _holds_tables(table) and _header(text, keys[:-1]) is not None


def _holds_tables(table: Mapping[str, object]) -> bool:
    return any(isinstance(each.value if isinstance(each, Noted) else each, Mapping) for each in table.values())


def _merge(text: str, keys: Keys, old: dict[str, Any], new: Mapping[str, object]) -> str:
    """Make a table that has a header, or dotted keys, equal to another."""
    for key in old:
        if new.get(key) is None:
            text = _remove(text, (*keys, key))
    for key, value in new.items():
        text = _change(text, (*keys, str(key)), value)
    return text


def _replace(text: str, keys: Keys, value: object) -> str:
    """Another value in the same place; a comment behind it keeps its column where it can."""
    spot = scan(text).spots[keys]
    start = _line_start(text, spot.value_line) + spot.value_column - 1
    return _swap(text, start, value_end(text, start), write.value(value))


def _swap(text: str, start: int, end: int, new: str) -> str:
    behind = _COMMENT.match(text, end)
    if behind and behind[2] and "\n" not in text[start:end]:
        gap = max(1, len(behind[1]) + end - start - len(new))
        return f"{text[:start]}{new}{' ' * gap}{text[behind.start(2) :]}"
    return text[:start] + new + text[end:]


def _add(text: str, keys: Keys, value: object) -> str:
    """A new key: inside the braces that its table is written in, or on a line of its table."""
    around = _pair_around(text, keys[:-1])
    if around is not None:
        inner = deepcopy(_at(_read(text), _names(around)))
        _set(inner, keys[len(around.path) :], value)
        return _swap(text, around.value, around.end, write.value(inner))
    owner = next(keys[:n] for n in range(len(keys) - 1, -1, -1) if n == 0 or _header(text, keys[:n]) is not None)
    dotted = any(s.path[: len(owner) + 1] == keys[: len(owner) + 1] for s in _pairs(text, owner))
    if len(owner) < len(keys) - 1 and not dotted:
        return _add_table(text, keys[:-1], {keys[-1]: value})
    line = ".".join(write.key(key) for key in keys[len(owner) :]) + f" = {write.value(value)}\n"
    lines = _pairs(text, owner)
    header = _header(text, owner)
    if lines:
        return _insert(text, _line_end(text, lines[-1].end), line)
    return _insert(text, _line_end(text, header.end), line) if header else line + text


def _add_table(text: str, keys: Keys, table: Mapping[str, object]) -> str:
    """A new table under its header, behind the last of its family, or at the end of the file."""
    block = _block(keys, table)
    for n in range(len(keys) - 1, 0, -1):
        family = [s for s in scan(text).statements if s.path[:n] == keys[:n]]
        if family:
            return _insert(text, _line_end(text, family[-1].end), f"\n{block}")
    return _insert(text.rstrip("\n") + "\n", len(text.rstrip("\n")) + 1, f"\n{block}")


def _block(keys: Keys, table: Mapping[str, object]) -> str:
    """A table as text; tables in it that hold tables get headers of their own."""
    blocks, lines = [], []
    for key, each in table.items():
        value, note = (each.value, each.comment) if isinstance(each, Noted) else (each, None)
        if isinstance(value, Mapping) and _holds_tables(value):
            blocks.append(_block((*keys, str(key)), value))
        elif value is not None:
            lines.append(f"{write.key(str(key))} = {write.value(_plain(value))}{_comment(note, 2)}\n")
    if lines or not blocks:
        blocks.insert(0, f"[{'.'.join(write.key(key) for key in keys)}]\n{''.join(lines)}")
    return "\n".join(blocks)


def _remove(text: str, keys: Keys) -> str:
    """Without a key or a whole table: its lines, with the comments on them, but no line that is a comment alone."""
    around = _pair_around(text, keys[:-1])
    if around is not None:
        inner = deepcopy(_at(_read(text), _names(around)))
        _set(inner, keys[len(around.path) :], None)
        return _swap(text, around.value, around.end, write.value(inner))
    for statement in reversed(scan(text).statements):
        if statement.path[: len(keys)] == keys:
            start = text.rfind("\n", 0, statement.start) + 1
            if statement.brackets and text[:start].endswith("\n\n"):
                start -= 1
            text = text[:start] + text[_line_end(text, statement.end) :]
    return text


def _annotate(text: str, keys: Keys, note: str) -> str:
    """Another comment on the line of a key."""
    statement = next((s for s in scan(text).statements if s.path == keys and not s.brackets), None)
    behind = _COMMENT.match(text, statement.end) if statement else None
    if statement is None or behind is None:
        return text
    return text[: statement.end] + _comment(note, len(behind[1]) if behind[2] else 2) + text[behind.end() :]


def _comment(note: str | None, gap: int) -> str:
    return "" if note is None else f"{' ' * gap}# {' '.join(note.split())}"


def _header(text: str, keys: Keys) -> Statement | None:
    return next((s for s in scan(text).statements if s.path == keys and s.brackets == 1), None)


def _pair_around(text: str, keys: Keys) -> Statement | None:
    """The line `key = value` that is, or holds in braces, what stands at these keys."""
    return next((s for s in scan(text).statements if not s.brackets and s.path == keys[: len(s.path)]), None)


def _pairs(text: str, owner: Keys) -> list[Statement]:
    """The lines `key = value` between a header and the next; of the whole file's own keys for ()."""
    found, inside = [], owner == ()
    for statement in scan(text).statements:
        if statement.brackets:
            inside = statement.path == owner
        elif inside:
            found.append(statement)
    return found


def _names(statement: Statement) -> Keys:
    return tuple(str(part) for part in statement.path)


def _line_start(text: str, line: int) -> int:
    """Offset of a line, counted from 1."""
    at = 0
    for _ in range(line - 1):
        at = text.index("\n", at) + 1
    return at


def _line_end(text: str, at: int) -> int:
    """Offset of the line after the one that holds this offset."""
    end = text.find("\n", at)
    return len(text) if end < 0 else end + 1


def _insert(text: str, at: int, lines: str) -> str:
    before = text[:at] if not text[:at] or text[:at].endswith("\n") else text[:at] + "\n"
    return before + lines + text[at:]
