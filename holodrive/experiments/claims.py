"""What a paper prints beside what this software finds: one claim, one line, one verdict."""

import math
from collections.abc import Iterable
from dataclasses import dataclass
from html import escape
from typing import Literal

from holodrive.reports.tables import Table

Verdict = Literal[
    "agrees",  # ours is the printed value within the stated tolerance
    "differs",  # it is not, and nothing in the paper decides who is right
    "contradicts itself",  # two places of the paper cannot both be right
    "cannot be",  # the printed value is impossible under what the paper says elsewhere
    "not comparable",  # the paper does not say enough to compute the value
    "not printed",  # what the paper does not tell of itself
    "no number",  # a photograph or a drawing
]
Value = float | str | None
_HEADERS = ("where", "what", "printed", "ours", "difference", "verdict", "note")


@dataclass(frozen=True)
class Claim:
    """One printed value.

    Attributes:
        where: table, figure, equation or section.
        what: the quantity in words.
        printed, ours: numbers in `unit`, or words; None where there is none.
        unit: of both.
        verdict: see `Verdict`.
        note: why, and where the paper contradicts itself.
    """

    where: str
    what: str
    printed: Value
    ours: Value
    verdict: Verdict
    unit: str = ""
    note: str = ""

    @property
    def difference(self) -> str:
        """Of ours from the printed value, in percent of it; empty where there is nothing to divide."""
        if not (isinstance(self.printed, float) and isinstance(self.ours, float)):
            return ""
        if self.printed == 0.0 or not math.isfinite(self.ours):
            return ""
        share = 100.0 * (self.ours - self.printed) / abs(self.printed)
        return "0 %" if abs(share) < 0.05 else f"{share:+.{1 if abs(share) < 100 else 0}f} %".replace("-", "−")


def claimed(
    where: str, what: str, printed: float, ours: float, unit: str = "", *, within: float = 0.01, note: str = ""
) -> Claim:
    """A claim about one number: it agrees when ours is within that share of the printed value.

    Args:
        within: tolerance as a share of the printed value.
    """
    good = abs(ours - printed) <= within * abs(printed)
    return Claim(where, what, float(printed), float(ours), "agrees" if good else "differs", unit, note)


def claim_table(claims: Iterable[Claim], title: str = "") -> Table:
    """All claims as one table; its plain data has the numbers themselves."""
    listed = list(claims)
    cells = tuple(
        (c.where, c.what, _shown(c.printed, c.unit), _shown(c.ours, c.unit), c.difference, c.verdict, c.note)
        for c in listed
    )
    data = tuple(
        {
            "where": c.where,
            "what": c.what,
            "unit": c.unit,
            "printed": c.printed,
            "ours": c.ours,
            "difference": c.difference,
            "verdict": c.verdict,
            "note": c.note,
        }
        for c in listed
    )
    numeric = (False, False, True, True, True, False, False)
    return Table(title, _HEADERS, cells, data, numeric)


@dataclass(frozen=True)
class ClaimSection:
    """Claims on a page: a table in which each note stands under its row."""

    title: str
    claims: tuple[Claim, ...]

    def html(self) -> str:
        """What stands under the heading."""
        head = "".join(f'<th scope="col">{name}</th>' for name in _HEADERS[:-1])
        rows = "".join(self._row(cells) for cells in claim_table(self.claims).cells)
        return f'<div class="scroll"><table><thead><tr>{head}</tr></thead><tbody>{rows}</tbody></table></div>'

    def _row(self, cells: tuple[str, ...]) -> str:
        where, *others, note = cells
        row = f'<th scope="row">{escape(where)}</th>' + "".join(f'<td class="wrap">{escape(c)}</td>' for c in others)
        if not note:
            return f"<tr>{row}</tr>"
        return f'<tr class="noted">{row}</tr><tr class="remark"><td></td><td colspan="5">{escape(note)}</td></tr>'


def _shown(value: Value, unit: str) -> str:
    if value is None:
        return "—"
    if isinstance(value, str):
        return value
    digits = f"{value:.4g}" if abs(value) < 1e4 else f"{value:.0f}"
    return f"{digits}{'' if unit == '°' else ' '}{unit}".strip().replace("-", "−")
