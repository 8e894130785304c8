"""What a spreadsheet writes where a comma is wanted."""

from collections.abc import Sequence


def separated(header: Sequence[str]) -> str:
    """A hint for a header line that stands in one cell because something else than a comma divides it, else nothing."""
    if len(header) != 1:
        return ""
    for name, sign in (("semicolons", ";"), ("tabs", "\t")):
        if sign in header[0]:
            return f"{name} stand between the cells: write commas there, and points in numbers"
    return ""
