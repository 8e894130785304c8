"""One tree of exceptions. A message names the thing, what was found, what is allowed, what to do next.

Library code raises; only the command line prints and exits (`exit_code`: 1 failed check,
2 wrong input, 3 hardware fault).
"""

from collections.abc import Iterable
from dataclasses import dataclass
from difflib import get_close_matches


class HolodriveError(Exception):
    """Root of everything this package raises on purpose."""

    exit_code = 1


class InputError(HolodriveError):
    """Something that the user wrote or passed is wrong."""

    exit_code = 2


class HardwareFault(HolodriveError):
    """A device does not answer or answers nonsense."""

    exit_code = 3


class ChassisError(InputError):
    """The wheels of a base cannot do what a holonomic base must do."""


class CommandError(InputError):
    """A command that may not reach the motors: NaN, infinite, over a limit, of the wrong kind."""


class LogError(InputError):
    """A recording that cannot be read, or does not hold what was asked of it."""


class UnknownName(InputError):
    """No entry of that name in a registry or catalog."""

    def __init__(self, kind: str, name: str, known: Iterable[str]) -> None:
        self.kind, self.name, self.known = kind, name, sorted(known)
        super().__init__(f"no {kind} called {name!r}{with_known(name, self.known)}")


class MissingExtra(InputError):
    """An optional dependency is needed for this and is not installed."""

    def __init__(self, what: str, package: str, extra: str) -> None:
        super().__init__(f"{what} needs {package}, which is not installed: pip install 'holodrive[{extra}]'")


@dataclass(frozen=True)
class Fault:
    """One fault of one file. `line` and `column` count from 1; 0 means the whole file."""

    file: str
    line: int
    message: str
    column: int = 1
    source: str = ""
    hint: str = ""

    def one_line(self) -> str:
        """`file:line: message (hint)`."""
        where = f"{self.file}:{self.line}" if self.line else self.file
        return f"{where}: {self.message}" + (f" ({self.hint})" if self.hint else "")


class FileFaults(InputError):
    """All the faults of one file at once."""

    def __init__(self, file: str, faults: Iterable[Fault]) -> None:
        self.file, self.faults = file, tuple(faults)
        super().__init__("\n".join(fault.one_line() for fault in self.faults))


def did_you_mean(name: str, known: Iterable[str]) -> str:
    """`". Did you mean 'x'?"` when a known name is near, else nothing."""
    near = get_close_matches(name.lower(), list(known), n=1, cutoff=0.6)
    return f". Did you mean {near[0]!r}?" if near else ""


def with_known(name: str, known: Iterable[str]) -> str:
    """`". Did you mean 'x'? Known: x, y"`, or `"; known: x, y"` when nothing is near."""
    names, hint = ", ".join(known), did_you_mean(name, known)
    return f"{hint} Known: {names}" if hint else f"; known: {names}"
