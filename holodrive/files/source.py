"""A TOML file under examination: its table, where each key stands, and the faults found so far."""

import re
import stat
import tomllib
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field, replace
from difflib import get_close_matches
from pathlib import Path as FilePath
from typing import Any

from holodrive.errors import Fault, FileFaults
from holodrive.files.scan import Index, Path, Spot, TooDeepError, scan
from holodrive.files.units import shown

Table = dict[str, Any]
Migration = Callable[[Table], Table]

LARGEST = 256 * 1024  # bytes; some four thousand obstacles
MOST_FAULTS = 100  # more are counted, not listed
LONGEST = 400  # characters of a message; only hostile keys make longer ones


@dataclass(slots=True)
class Source:
    """What a file said.

    Attributes:
        file: as messages name it.
        text: of the file.
        table: the values; overrides and migrations are in it.
        settings: path -> the text of the `--set` that put the value there.
        borrowed: path -> the path in the same file that the value was taken from (shared defaults).
    """

    file: str
    text: str
    table: Table = field(default_factory=dict)
    index: Index = field(default_factory=Index)
    settings: dict[Path, str] = field(default_factory=dict)
    borrowed: dict[Path, Path] = field(default_factory=dict)
    faults: list[Fault] = field(default_factory=list)
    unlisted: int = 0
    lines: list[str] = field(default_factory=list, init=False)

    def __post_init__(self) -> None:
        self.lines = self.text.split("\n")

    @property
    def full(self) -> bool:
        """Whether more faults would only be counted."""
        return len(self.faults) >= MOST_FAULTS

    def fault(self, path: Path, message: str, hint: str = "", *, at_key: bool = False) -> None:
        """Note a fault of the value (or the key) at `path`; the same words at the same place count once."""
        setting = self._setting(path)
        if setting is not None:
            self._add(Fault(f"--set {setting.partition('=')[0]}", 0, message, source=setting, hint=hint))
            return
        spot = self._spot(path)
        if spot is None:
            self._add(Fault(self.file, 0, message, hint=hint))
        elif at_key:
            self.fault_at(spot.line, spot.key_column, message, hint)
        else:
            self.fault_at(spot.value_line, spot.value_column, message, hint)

    def fault_at(self, line: int, column: int, message: str, hint: str = "") -> None:
        """Note a fault at a line and column."""
        lines = self.lines
        source = lines[line - 1][:200] if 0 < line <= len(lines) else ""
        self._add(Fault(self.file, line, message, column, source, hint))

    def refuse(self) -> None:
        """Raise all the faults noted so far, in the order of the file, if there are any."""
        if not self.faults:
            return
        faults = sorted(self.faults, key=lambda fault: (fault.line, fault.column))
        if self.unlisted:
            faults.append(Fault(self.file, 0, f"{self.unlisted} more faults are not listed"))
        raise FileFaults(self.file, faults)

    def _add(self, fault: Fault) -> None:
        if len(fault.message) > LONGEST or len(fault.hint) > LONGEST:
            fault = replace(fault, message=_clipped(fault.message), hint=_clipped(fault.hint))
        if fault in self.faults:
            return
        if len(self.faults) < MOST_FAULTS:
            self.faults.append(fault)
        else:
            self.unlisted += 1

    def _setting(self, path: Path) -> str | None:
        """The `--set` that gave this value or the nearest table around it."""
        for upto in range(len(path), 0, -1):
            if path[:upto] in self.settings:
                return self.settings[path[:upto]]
        return None

    def _spot(self, path: Path) -> Spot | None:
        for upto in range(len(path), 0, -1):
            head = path[:upto]
            if head in self.borrowed:
                return self._spot(self.borrowed[head] + path[upto:])
            if head in self.index.spots:
                return self.index.spots[head]
        return None


def read(path: str | FilePath, largest: int = LARGEST) -> tuple[str, str]:
    """(text, name) of a UTF-8 file of at most `largest` bytes; whatever prevents that is a FileFaults."""
    name = str(path)
    try:
        file = FilePath(path)
        if not stat.S_ISREG(file.stat().st_mode):
            raise _whole(name, "is not a file" if not file.is_dir() else "is a folder, not a file")
        with file.open("rb") as stream:
            data = stream.read(largest + 1)
            size = file.stat().st_size
    except FileNotFoundError:
        raise _whole(name, "there is no such file", _neighbour(FilePath(path))) from None
    except (OSError, ValueError) as error:
        reason = error.strerror if isinstance(error, OSError) and error.strerror else str(error)
        raise _whole(name, f"cannot be read: {reason.lower()}") from None
    if len(data) > largest:
        raise _whole(name, f"{size / 1e6:.3g} MB is too large; at most {largest // 1024} KiB are read")
    try:
        return data.decode("utf-8-sig"), name
    except UnicodeDecodeError as error:
        line = data[: error.start].count(b"\n") + 1
        message = f"byte {error.start + 1} is not UTF-8 text (found 0x{data[error.start]:02x})"
        raise FileFaults(name, [Fault(name, line, message, hint="save the file as UTF-8")]) from None


def table_names(path: str | FilePath) -> set[str]:
    """The top-level keys that a file seems to have, as far as it can be read: enough to tell a world from a robot.

    Takes no longer for a hostile file than for any other; that one's own reader then says what is wrong.
    """
    try:
        text, _ = read(path)
        spots = scan(text.replace("\r\n", "\n")).spots
    except (FileFaults, TooDeepError):
        return set()
    return {str(where[0]) for where in spots}


def open_text(
    text: str,
    file: str,
    *,
    newest: int,
    migrations: Mapping[int, Migration],
    overrides: Mapping[str, object] | None = None,
    collections: Iterable[str] = (),
    libraries: Iterable[str] = (),
) -> Source:
    """Parse a TOML text, bring it to the newest schema and apply `--set` overrides.

    Args:
        text: the file's content.
        file: its name in messages.
        newest: the schema number that this release writes.
        migrations: from schema number n to the function that makes a table of schema n + 1.
        overrides: dotted key -> value; text is read as TOML where it is TOML ("3.2", "true"), else as it stands.
        collections: dotted names of the tables of named or numbered things, such as "wheel".
        libraries: keys whose text is a name of a library, such as "motor"; an override below one changes that entry.

    Raises:
        FileFaults: when the text is no TOML or its schema is unknown (nothing else can then be judged).
    """
    source = Source(file, text.replace("\r\n", "\n"))
    if len(text) > LARGEST:
        raise _whole(file, f"{len(text) / 1e6:.3g} MB is too large; at most {LARGEST // 1024} KiB are read")
    if not text.strip():
        raise _whole(file, "the file is empty", f"a complete file begins with `schema = {newest}`")
    _parse(source)
    _migrate(source, newest, migrations)
    for key, value in (overrides or {}).items():
        _override(source, key, value, tuple(collections), tuple(libraries))
    return source


def _parse(source: Source) -> None:
    try:
        source.index = scan(source.text)
    except TooDeepError as error:
        source.fault_at(error.line, error.column, "nested too deep; no key of these files is")
        source.refuse()
    for path, spot, first in source.index.twice:
        source.fault_at(spot.line, spot.key_column, f"{dotted(path)} is written twice; the first is in line {first}")
    source.refuse()
    try:
        source.table = tomllib.loads(source.text)
    except tomllib.TOMLDecodeError as error:
        _syntax_fault(source, str(error))
    except (ValueError, RecursionError, OverflowError):  # int() refuses more than 4300 digits with a bare ValueError
        source.fault_at(0, 1, "not valid TOML: a number has too many digits")
    source.refuse()


_TOML_PLACE = re.compile(r"(.*) \(at (?:line (\d+), column (\d+)|end of document)\)", re.DOTALL)


def _syntax_fault(source: Source, message: str) -> None:
    match = _TOML_PLACE.fullmatch(message)
    words = match[1] if match else message
    what = f"not valid TOML: {words[:1].lower()}{words[1:]}"
    lines = source.lines
    line, column = (int(match[2]), int(match[3])) if match and match[2] else (len(lines), len(lines[-1]) + 1)
    if line > 1 and column == 1 and not lines[line - 1].strip():
        line, column = line - 1, len(lines[line - 2]) + 1  # an unfinished line is noticed at the start of the next
    source.fault_at(line, column, what, _syntax_hint(words, lines[line - 1] if line <= len(lines) else ""))


def _syntax_hint(words: str, line: str) -> str:
    key, equals, value = line.partition("=")
    if words == "Illegal character '\\n'":
        return "a text has no closing quote"
    if equals and not value.partition("#")[0].strip():
        return f"there is no value after '{key.strip()} ='"
    if not equals and line.strip() and not line.strip().startswith(("[", "#")):
        return "a line is `key = value` or a [table]"
    if equals and re.match(r"\s*[-+.\d][^\"'\[{#]*[A-Za-z%°]", value):
        return f'put a quantity with a unit in quotes: {key.strip()} = "{value.partition("#")[0].strip()}"'
    if equals and re.match(r"\s*[A-Za-z]", value):
        return f'put text in quotes: {key.strip()} = "{value.partition("#")[0].strip()}"'
    return ""


def _migrate(source: Source, newest: int, migrations: Mapping[int, Migration]) -> None:
    found = source.table.get("schema")
    if "schema" not in source.table:
        source.fault((), "the file does not say its schema", f"write `schema = {newest}` as its first line")
    elif not isinstance(found, int) or isinstance(found, bool) or found < min([newest, *migrations]):
        source.fault(("schema",), f"schema {shown(found)} is not known; this release writes schema {newest}")
    elif found > newest:
        source.fault(
            ("schema",),
            f"schema {shown(found)} is newer than this release of holodrive, which reads up to {newest}",
            "install a newer holodrive",
        )
    source.refuse()
    for number in range(int(source.table["schema"]), newest):
        source.table = {**migrations[number](source.table), "schema": number + 1}


def _override(
    source: Source, key: str, value: object, collections: tuple[str, ...], libraries: tuple[str, ...]
) -> None:
    text = f"{key}={value if isinstance(value, str) else _toml(value)}"
    parts = key.split(".")
    if not all(parts):
        _refuse_setting(source, key, text, f"{key!r} is not a key; write it as wheel.front.radius")
        return
    if parts[0] == "schema":
        _refuse_setting(source, key, text, "the schema of a file cannot be set")
        return
    path: Path = ()
    node: Any = source.table
    for depth, part in enumerate(parts[:-1]):
        inside = ".".join(parts[:depth])
        if isinstance(node, list):
            number = _element(node, part)
            if number is None:
                known = [str(entry.get("name", n + 1)) for n, entry in enumerate(node) if isinstance(entry, dict)]
                _refuse_setting(source, key, text, f"there is no {inside} {part!r}", meant(part, known))
                return
            path, node = (*path, number), node[number]
        elif not isinstance(node, dict):
            _refuse_setting(source, key, text, f"{inside} is {shown(node)} and holds no keys")
            return
        else:
            if part not in node and inside in collections:
                _refuse_setting(source, key, text, f"there is no {inside} {part!r}", meant(part, node))
                return
            if part in libraries and isinstance(node.get(part), str):  # a name with changes
                node[part] = {"model": node[part]}
            path, node = (*path, part), node.setdefault(part, {})
    if not isinstance(node, dict):
        _refuse_setting(source, key, text, f"{'.'.join(parts[:-1])} is {shown(node)} and holds no keys")
        return
    node[parts[-1]] = _value(value)
    source.settings[(*path, parts[-1])] = text


def _refuse_setting(source: Source, key: str, text: str, message: str, hint: str = "") -> None:
    source.faults.append(Fault(f"--set {key}", 0, message, source=text, hint=hint))


def _element(entries: list[Any], part: str) -> int | None:
    """Index of the entry with that name, or of that number counted from 1."""
    for number, entry in enumerate(entries):
        if isinstance(entry, dict) and entry.get("name") == part:
            return number
    return int(part) - 1 if part.isdecimal() and 1 <= int(part) <= len(entries) else None


_LONGEST_VALUE = 1000  # characters that are worth reading as TOML


def _value(value: object) -> object:
    if not isinstance(value, str) or len(value) > _LONGEST_VALUE:
        return value
    try:
        parsed = tomllib.loads(f"value = {value}")
    except (ValueError, RecursionError):
        return value
    return parsed["value"] if list(parsed) == ["value"] else value


def _toml(value: object) -> str:
    return shown(value) if isinstance(value, bool | int | float) else str(value)


def dotted(path: Path) -> str:
    """A path as people write it: tables in brackets at the start, entries of a list by their number."""
    text = ""
    for part in path:
        text += f" {part + 1}" if isinstance(part, int) else f".{part}" if text.strip() else part
    return text or "the file"


def section(path: Path) -> str:
    """A table as its header is written: `[wheel.front]`, or `[[circle]] 3` for an entry of a list."""
    lists = [at for at, part in enumerate(path) if isinstance(part, int)]
    if not lists:
        return f"[{dotted(path)}]" if path else "the file"
    head, rest = path[: lists[0]], path[lists[0] :]
    return f"[[{dotted(head)}]]{dotted(('', *rest))}"


def meant(word: str, known: Iterable[str]) -> str:
    """The hint for a word that is not among the known ones."""
    words = [str(name) for name in known]
    near = get_close_matches(word.lower(), words, n=1, cutoff=0.6) if len(word) <= 60 else []
    if near:
        return f"did you mean '{near[0]}'?"
    return f"known: {', '.join(words[:20])}" if words else ""


def _clipped(text: str) -> str:
    return text if len(text) <= LONGEST else f"{text[: LONGEST - 3]}..."


def _neighbour(path: FilePath) -> str:
    try:
        kinds = {".toml", path.suffix}
        names = [entry.name for entry in path.parent.iterdir() if entry.suffix in kinds][:200]
    except OSError:
        return ""
    near = get_close_matches(path.name, names, n=1, cutoff=0.6)
    return f"did you mean '{near[0]}'?" if near else ""


def _whole(name: str, message: str, hint: str = "") -> FileFaults:
    return FileFaults(name, [Fault(name, 0, message, hint=hint)])
