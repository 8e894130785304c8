"""Where a command's words go: results to standard output, progress and hints to standard error."""

import math
import os
import re
import sys
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from typing import Any

import click

LABEL = 8  # characters of the first column
STEP_S = 5.0  # between two lines of progress in a pipe


class Output:
    """What the options -q, -v and --json say, and the ways to speak that follow from it."""

    def __init__(self) -> None:
        self.quiet = self.verbose = self.json = False
        self.arguments: list[str] = []  # as the user gave them

    def set(self, quiet: bool = False, verbose: bool = False, json: bool = False) -> None:
        """Add what one level of the command line says."""
        self.quiet, self.verbose, self.json = self.quiet or quiet, self.verbose or verbose, self.json or json

    def line(self, label: str, text: str) -> None:
        """One labelled line of result: `robot  hybrid3 ...`."""
        self.text(f"{label:<{LABEL}}{text}")

    def text(self, text: str) -> None:
        """Result as it is."""
        click.echo(text, color=colour())

    def table(self, header: Sequence[str], rows: Sequence[Sequence[object]], left: int = 1) -> None:
        """Columns as wide as they need to be; the first `left` of them flush left, the others flush right."""
        self.text(table(header, rows, left))

    def data(self, value: Mapping[str, Any] | Sequence[Any]) -> None:
        """The result for machines: one JSON document; what is not a number becomes null."""
        import json

        click.echo(json.dumps(plain(value), indent=2, ensure_ascii=False))

    def note(self, text: str) -> None:
        """A line for people, not part of the result."""
        if not self.quiet:
            click.echo(text, err=True, color=colour())

    def warn(self, text: str) -> None:
        """A line that is worth reading even with -q."""
        click.echo(click.style("warning: ", fg="yellow") + text, err=True, color=colour())

    def next(self, text: str) -> None:
        """What to type next; the last line of every command."""
        self.note(click.style(f"{'next':<{LABEL}}", dim=True) + re.sub(r"\bholodrive (?=[a-z])", program() + " ", text))

    @contextmanager
    def progress(self, label: str, total: float, unit: str = "") -> Iterator[Callable[[float], None]]:
        """Gives a function to call with what is done of `total`: a bar on a terminal, a line now and then in a pipe."""
        if self.quiet or self.json:
            yield lambda done: None
        elif colour() is not False and sys.stderr.isatty():
            with _bar(label, total, unit) as update:
                yield update
        else:
            yield _lines(self, label, total, unit)


def table(header: Sequence[str], rows: Sequence[Sequence[object]], left: int = 1) -> str:
    """A plain-text table."""
    cells = [[str(cell) for cell in row] for row in (header, *rows)]
    widths = [max(len(row[i]) for row in cells) for i in range(len(header))]
    pad = [str.ljust if i < left else str.rjust for i in range(len(header))]
    lines = ["  ".join(pad[i](cell, widths[i]) for i, cell in enumerate(row)).rstrip() for row in cells]
    return "\n".join(lines)


def program() -> str:
    """How this user can call holodrive from here: by name, or by path when it is not on PATH."""
    import shutil

    called = sys.argv[0]
    if os.path.basename(called) != "holodrive" or shutil.which("holodrive"):
        return "holodrive"
    near = os.path.relpath(called)
    return called if near.startswith("..") else near


def colour() -> bool | None:
    """False when colours are not wanted (NO_COLOR, a dumb terminal), None to let click decide by the stream."""
    return False if os.environ.get("NO_COLOR") or os.environ.get("TERM") == "dumb" else None


def plain(value: Any) -> Any:
    """Values as JSON knows them."""
    if isinstance(value, Mapping):
        return {str(key): plain(item) for key, item in value.items()}
    if hasattr(value, "tolist"):  # NumPy arrays and scalars
        return plain(value.tolist())
    if isinstance(value, (list, tuple, set, frozenset)):
        return [plain(item) for item in value]
    if isinstance(value, float):
        return value if math.isfinite(value) else None
    return value if value is None or isinstance(value, (bool, int, str)) else str(value)


@contextmanager
def _bar(label: str, total: float, unit: str) -> Iterator[Callable[[float], None]]:
    from rich.console import Console
    from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn

    digits = _digits(unit)
    columns = (
        TextColumn(f"{label:<{LABEL - 1}}"),
        BarColumn(),
        TextColumn("{task.percentage:>3.0f} %"),
        TextColumn(f"{{task.completed:{digits}}} of {{task.total:{digits}}} {unit}"),
        TimeElapsedColumn(),
    )
    with Progress(*columns, console=Console(stderr=True), transient=True) as bar:
        task = bar.add_task(label, total=total)
        last = 0.0

        def update(done: float) -> None:
            nonlocal last
            if (now := time.monotonic()) - last > 0.05 or done >= total:  # a call may come each control tick
                last = now
                bar.update(task, completed=done)

        yield update


def _digits(unit: str) -> str:
    """How progress is written: seconds with a decimal, counts without."""
    return ".1f" if unit.startswith("s ") else ".0f"


def _lines(out: Output, label: str, total: float, unit: str) -> Callable[[float], None]:
    last, digits = 0.0, _digits(unit)

    def update(done: float) -> None:
        nonlocal last
        last = last or time.monotonic()  # counts from the first call: what comes before it is not progress
        if (now := time.monotonic()) - last > STEP_S:
            last = now
            share = f"{100.0 * done / total:3.0f} %  {done:{digits}} of {total:{digits}} {unit}"
            out.note(f"{label:<{LABEL}}{share}".rstrip())

    return update
