"""Where each key of a TOML text stands. `tomllib` reads the values; this finds their lines and columns.

It trusts the text to be TOML and stops quietly where it is not (tomllib then says what is wrong), but it refuses
nesting and dotted keys that are too deep, before tomllib would spend its stack or minutes on them.
"""

import re
from bisect import bisect_right
from dataclasses import dataclass, field

Key = str | int
Path = tuple[Key, ...]

DEEPEST = 12  # levels; our files need five


@dataclass(frozen=True, slots=True)
class Spot:
    """Line and columns, from 1, of a key and of its value."""

    line: int
    key_column: int
    value_line: int
    value_column: int


@dataclass(frozen=True, slots=True)
class Statement:
    """A `key = value`, a `[header]` or a `[[header]]`, by offsets into the text.

    Attributes:
        path: of the key or table; an entry of a list of tables ends in its number.
        start: of the key or the brackets.
        value: of the value; for a header its start.
        end: behind the value or the brackets.
        brackets: 0, 1 or 2.
    """

    path: Path
    start: int
    value: int
    end: int
    brackets: int


class TooDeepError(Exception):
    """Nesting beyond `DEEPEST`."""

    def __init__(self, line: int, column: int) -> None:
        self.line, self.column = line, column
        super().__init__()


class _Odd(Exception):
    """Not an error: the sign that the text is not TOML from here on."""


@dataclass(slots=True)
class Index:
    """Spots of all paths, the statements in their order, and the paths written twice with their first line."""

    spots: dict[Path, Spot] = field(default_factory=dict)
    statements: list[Statement] = field(default_factory=list)
    twice: list[tuple[Path, Spot, int]] = field(default_factory=list)


def scan(text: str) -> Index:
    """The index of a text; raises `TooDeepError`."""
    return _Scanner(text).run()


def value_end(text: str, start: int) -> int:
    """Where the value that starts there ends; raises ValueError where there is none."""
    scanner = _Scanner(text)
    scanner.at = start
    try:
        scanner.value(())
    except _Odd:
        raise ValueError(f"no TOML value at {start}") from None
    return len(text[: scanner.at].rstrip())


_SPACE = re.compile(r"[ \t]*")
_BLANK = re.compile(r"(?:[ \t\n]|#[^\n]*)*")
_BARE_KEY = re.compile(r"[A-Za-z0-9_-]+")
_SCALAR = re.compile(r"[^,\]}\n#]+")
_STRINGS = (  # the order matters: long forms first
    re.compile(r'"""(?:[^"\\]|\\.|"(?!""))*"{3,5}', re.DOTALL),
    re.compile(r"'''(?:[^']|'(?!''))*'{3,5}", re.DOTALL),
    re.compile(r'"(?!"")(?:[^"\\\n]|\\.)*"'),
    re.compile(r"'(?!'')[^'\n]*'"),
)


class _Scanner:
    def __init__(self, text: str) -> None:
        self.text, self.at = text, 0
        self.starts = [0] + [match.end() for match in re.finditer("\n", text)]
        self.index = Index()
        self.headers: set[Path] = set()
        self.counts: dict[Path, int] = {}
        self.prefix: Path = ()

    def run(self) -> Index:
        try:
            self._skip(_BLANK)
            while self.at < len(self.text):
                self._statement()
                self._skip(_BLANK)
        except _Odd:
            pass
        return self.index

    def _statement(self) -> None:
        if self.text.startswith("[[", self.at):
            self._header(2)
        elif self.text.startswith("[", self.at):
            self._header(1)
        else:
            start = self.at
            path, value = self._pair(self.prefix, 1)
            end = len(self.text[value : self.at].rstrip()) + value
            self.index.statements.append(Statement(path, start, value, end, 0))
            self._skip(_SPACE)
            if self.at < len(self.text) and self.text[self.at] not in "\n#":
                raise _Odd

    def _header(self, brackets: int) -> None:
        start = self.at
        self.at += brackets
        parts = self._key()
        if not self.text.startswith("]" * brackets, self.at):
            raise _Odd
        self.at += brackets
        path = (*self._resolve(parts[:-1]), parts[-1])
        for upto in range(1, len(path)):
            self._note(path[:upto], start, start, quietly=True)
        if brackets == 2:
            self.counts[path] = self.counts.get(path, 0) + 1
            self._note(path, start, start, quietly=True)
            path = (*path, self.counts[path] - 1)
        elif path in self.headers:
            self.index.twice.append((path, self._spot(start, start), self.index.spots[path].line))
            path = (*path, "")  # its keys are no second fault
        if path not in self.headers:
            self.headers.add(path)
            self.index.spots[path] = self._spot(start, start)
        self.prefix = path
        self.index.statements.append(Statement(path, start, start, self.at, brackets))

    def value(self, path: Path) -> None:
        """Step over one value."""
        self._value(path, 1)

    def _resolve(self, parts: list[str]) -> Path:
        path: Path = ()
        for part in parts:
            path = (*path, part)
            if path in self.counts:
                path = (*path, self.counts[path] - 1)
        return path

    def _pair(self, prefix: Path, depth: int) -> tuple[Path, int]:
        """The path of a pair and where its value starts."""
        start = self.at
        path = prefix + tuple(self._key())
        if not self.text.startswith("=", self.at):
            raise _Odd
        self.at += 1
        self._skip(_SPACE)
        for upto in range(len(prefix) + 1, len(path)):
            self._note(path[:upto], start, start, quietly=True)
        value = self.at
        self._note(path, start, value, quietly=False)
        self._value(path, depth)
        return path, value

    def _value(self, path: Path, depth: int) -> None:
        if depth > DEEPEST:
            raise TooDeepError(*self._place(self.at))
        opening = self.text[self.at : self.at + 1]
        if opening == "[":
            self._list(path, depth)
        elif opening == "{":
            self._inline(path, depth)
        elif opening in "\"'":
            self._string()
        else:
            self._need(_SCALAR)

    def _list(self, path: Path, depth: int) -> None:
        self.at += 1
        number = 0
        while True:
            self._skip(_BLANK)
            if self._take("]"):
                return
            self._note((*path, number), self.at, self.at, quietly=True)
            self._value((*path, number), depth + 1)
            number += 1
            self._skip(_BLANK)
            if not self._take(","):
                if self._take("]"):
                    return
                raise _Odd

    def _inline(self, path: Path, depth: int) -> None:
        self.at += 1
        while True:
            self._skip(_SPACE)
            if self._take("}"):
                return
            self._pair(path, depth + 1)
            self._skip(_SPACE)
            if not self._take(","):
                if self._take("}"):
                    return
                raise _Odd

    def _key(self) -> list[str]:
        parts: list[str] = []
        while True:
            self._skip(_SPACE)
            start = self.at
            if self.text[self.at : self.at + 1] in ('"', "'"):
                self._string()
                parts.append(_unquoted(self.text[start : self.at]))
            else:
                self._need(_BARE_KEY)
                parts.append(self.text[start : self.at])
            if len(parts) > DEEPEST:
                raise TooDeepError(*self._place(start))
            self._skip(_SPACE)
            if not self._take("."):
                return parts

    def _string(self) -> None:
        for pattern in _STRINGS:
            match = pattern.match(self.text, self.at)
            if match:
                self.at = match.end()
                return
        raise _Odd

    def _take(self, character: str) -> bool:
        found = self.text.startswith(character, self.at)
        self.at += found
        return found

    def _skip(self, pattern: re.Pattern[str]) -> None:
        match = pattern.match(self.text, self.at)
        self.at = match.end() if match else self.at

    def _need(self, pattern: re.Pattern[str]) -> None:
        match = pattern.match(self.text, self.at)
        if match is None:
            raise _Odd
        self.at = match.end()

    def _note(self, path: Path, key_at: int, value_at: int, *, quietly: bool) -> None:
        known = self.index.spots.get(path)
        if known is None:
            self.index.spots[path] = self._spot(key_at, value_at)
        elif not quietly:
            self.index.twice.append((path, self._spot(key_at, value_at), known.line))

    def _spot(self, key_at: int, value_at: int) -> Spot:
        return Spot(*self._place(key_at), *self._place(value_at))

    def _place(self, at: int) -> tuple[int, int]:
        line = bisect_right(self.starts, at)
        return line, at - self.starts[line - 1] + 1


def _unquoted(key: str) -> str:
    """The text of a quoted key; escapes are left to tomllib, such keys only lose their line."""
    return key[1:-1]
