"""Plain data as a table: for terminals, plain text, Markdown, HTML and JSON, with units and digits that read well."""

import json
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from html import escape
from typing import TYPE_CHECKING, Any

from holodrive.log.run import Run
from holodrive.log.words import joined, ordered, told, words

if TYPE_CHECKING:
    from rich.table import Table as RichTable


@dataclass(frozen=True)
class Table:
    """Cells as text, beside the plain values they came from.

    Attributes:
        title: above the table; may be empty.
        headers: (c) names of columns, with units.
        cells: (r, c) texts.
        data: what `json` gives: the values themselves.
        numeric: (c) columns set flush right.
        best: (row, column) of cells that hold the best value of their row.
    """

    title: str
    headers: tuple[str, ...]
    cells: tuple[tuple[str, ...], ...]
    data: tuple[Mapping[str, Any], ...]
    numeric: tuple[bool, ...]
    best: frozenset[tuple[int, int]] = frozenset()

    def rich(self) -> "RichTable":
        """For `rich.print`; the best values are bold and marked, so that no meaning hangs on colour."""
        from rich import box
        from rich.table import Table as RichTable
        from rich.text import Text

        shown = RichTable(title=self.title or None, box=box.SIMPLE_HEAD, title_justify="left", title_style="bold")
        for header, right in zip(self.headers, self.numeric, strict=True):
            shown.add_column(header, justify="right" if right else "left")
        for i, row in enumerate(self.cells):
            texts = [
                Text(self._marked(i, j), style="bold green" if (i, j) in self.best else "") for j in range(len(row))
            ]
            shown.add_row(*texts)
        return shown

    def text(self) -> str:
        """Aligned columns in plain characters."""
        rows = [self.headers, *(tuple(self._marked(i, j) for j in range(len(row))) for i, row in enumerate(self.cells))]
        widths = [max(len(row[j]) for row in rows) for j in range(len(self.headers))]
        lines = [
            "  ".join(
                c.rjust(w) if right else c.ljust(w) for c, w, right in zip(row, widths, self.numeric, strict=True)
            )
            for row in rows
        ]
        return "\n".join(line.rstrip() for line in ([self.title] if self.title else []) + lines)

    def markdown(self) -> str:
        """A pipe table."""
        rule = ["---:" if right else "---" for right in self.numeric]
        rows = [[self._marked(i, j).replace("|", "\\|") for j in range(len(row))] for i, row in enumerate(self.cells)]
        lines = [f"| {' | '.join(row)} |" for row in ([h.replace("|", "\\|") for h in self.headers], rule, *rows)]
        return "\n".join(([f"**{self.title}**", ""] if self.title else []) + lines)

    def json(self) -> str:
        """The plain values; NaN and infinity become null."""
        return json.dumps([plain(row) for row in self.data], indent=2, ensure_ascii=False)

    def html(self) -> str:
        """A table element whose cells are escaped."""
        classes = ["number" if right else "" for right in self.numeric]
        head = "".join(
            f'<th scope="col" class="{k}">{_unbroken(h)}</th>' for h, k in zip(self.headers, classes, strict=True)
        )
        body = ""
        for i, row in enumerate(self.cells):
            body += "<tr>"
            for j, (cell, class_) in enumerate(zip(row, classes, strict=True)):
                mark = (
                    f'<b class="best">{escape(cell)} <span title="best">▲</span></b>'
                    if (i, j) in self.best
                    else escape(cell)
                )
                body += f'<th scope="row">{mark}</th>' if j == 0 else f'<td class="{class_}">{mark}</td>'
            body += "</tr>"
        caption = f"<caption>{escape(self.title)}</caption>" if self.title else ""
        return f'<div class="scroll"><table>{caption}<thead><tr>{head}</tr></thead><tbody>{body}</tbody></table></div>'

    def _marked(self, row: int, column: int) -> str:
        cell = self.cells[row][column]
        return f"{cell} *" if (row, column) in self.best else cell


def table(rows: Sequence[Mapping[str, Any]], columns: Sequence[str] | None = None, title: str = "") -> Table:
    """A table of records: one row each, one column a key; numbers of a column share unit and decimals.

    Args:
        rows: records; a missing value is an empty cell.
        columns: keys in the wanted order; by default all keys, in order of first appearance.
        title: above the table.
    """
    keys = list(columns) if columns is not None else list(dict.fromkeys(key for row in rows for key in row))
    headers, texts, numeric = [], [], []
    for key in keys:
        values = [row.get(key) for row in rows]
        plain_numbers = [v for v in values if v is not None]
        is_number = bool(plain_numbers) and all(
            isinstance(v, int | float) and not isinstance(v, bool) for v in plain_numbers
        )
        if is_number:
            unit, cells = told(key, [math.nan if v is None else float(v) for v in values])
            cells = ["" if v is None else cell for v, cell in zip(values, cells, strict=True)]
            headers.append(f"{words(key).label}, {unit}" if unit else words(key).label)
        else:
            cells = [_text(v) for v in values]
            headers.append(words(key).label)
        texts.append(cells)
        numeric.append(is_number)
    by_row = tuple(zip(*texts, strict=True)) if texts else ()
    return Table(title, tuple(headers), by_row, tuple(rows), tuple(numeric))


def metric_table(runs: Sequence[Run], names: Sequence[str], title: str = "") -> Table:
    """One row a metric, one column a run; the best value of a row is marked, differences are to the first run.

    A run that ran into something or did not arrive is no rival of one that arrived unharmed: it is soon at its end.
    """
    merged: dict[str, float] = {}
    for run in runs:
        merged |= run.metrics
    cells, data, best = [], [], set()
    fair = _fair(runs)
    for i, name in enumerate(ordered(merged)):
        values = [float(run.metrics.get(name, math.nan)) for run in runs]
        unit, texts = told(name, values)
        shown = [joined(text, unit) for text in texts]
        for j in range(1, len(runs)):
            shown[j] += _difference(values[0], values[j])
        competing = [value if ok else math.nan for value, ok in zip(values, fair, strict=True)]
        best |= {(i, j + 1) for j in _best(name, competing, texts) if fair[j]}
        cells.append((words(name).label, *shown))
        data.append({"metric": name, **dict(zip(names, values, strict=True))})
    numeric = (False, *(True for _ in runs))
    return Table(title, ("metric", *names), tuple(cells), tuple(data), numeric, frozenset(best))


def plain(value: Any) -> Any:
    """Values that JSON knows: NumPy scalars and arrays unpacked, what is not finite as null."""
    if isinstance(value, Mapping):
        return {str(key): plain(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [plain(item) for item in value]
    if hasattr(value, "tolist"):
        return plain(value.tolist())
    if isinstance(value, float):
        return value if math.isfinite(value) else None
    return value if value is None or isinstance(value, bool | int | str) else str(value)


def _fair(runs: Sequence[Run]) -> list[bool]:
    """Which runs compete for the best values: those that arrived unharmed, else the unharmed ones, else all."""
    unharmed = [not run.metrics.get("moved_collisions", run.metrics.get("collisions", 0.0)) > 0.0 for run in runs]
    there = [ok and run.metrics.get("arrived", 0.0) > 0.0 for ok, run in zip(unharmed, runs, strict=True)]
    return next((some for some in (there, unharmed) if any(some)), [True for _ in runs])


def _best(name: str, values: Sequence[float], texts: Sequence[str]) -> list[int]:
    """Columns with the best value; none when nothing is known to be better, or all are told alike."""
    better = words(name).better
    known = [v for v in values if math.isfinite(v)]
    if (
        not better
        or len(known) < 2
        or len({text for text, v in zip(texts, values, strict=True) if math.isfinite(v)}) < 2
    ):
        return []
    # some errors keep their sign; the one nearest to zero is the best
    target = min(known, key=abs) if better == "low" else max(known)
    told_best = {text for text, v in zip(texts, values, strict=True) if v == target}
    return [j for j, text in enumerate(texts) if text in told_best]


def _difference(base: float, value: float) -> str:
    """` (+12 %)`, or nothing where a ratio says nothing."""
    if not (math.isfinite(base) and math.isfinite(value)) or base in (0.0, value):
        return ""
    share = 100.0 * (value - base) / abs(base)
    return f" ({share:+.{0 if abs(share) >= 10 else 1}f} %)".replace("-", "−") if abs(share) < 1000 else ""


def _unbroken(header: str) -> str:
    """A header whose unit does not stand alone on a line of its own."""
    return escape(header).replace(", ", ",&nbsp;")


def _text(value: Any) -> str:
    if value is None:
        return ""
    if isinstance(value, bool):
        return "yes" if value else "no"
    return str(value)
