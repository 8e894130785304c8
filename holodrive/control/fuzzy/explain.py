"""`explain`: why a fuzzy system gives what it gives at one input, rule by rule."""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from html import escape
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from holodrive.control.fuzzy.evaluation import evaluate, membership, strengths
from holodrive.control.fuzzy.lint.finding import rule_words, with_unit
from holodrive.control.fuzzy.shares import shares
from holodrive.control.fuzzy.system import System, Variable
from holodrive.errors import InputError
from holodrive.svg import number


@dataclass(frozen=True)
class Reading:
    """One input as the system takes it.

    Attributes:
        name, unit: of the variable.
        value: as given.
        used: after clamping to the universe.
        memberships: (set, membership) of all its sets.
    """

    name: str
    unit: str
    value: float
    used: float
    memberships: tuple[tuple[str, float], ...]


@dataclass(frozen=True)
class FiredRule:
    """One rule that fired.

    Attributes:
        number: from 1.
        words: IF ... THEN ....
        strength: weight included, above 0.
        shares: (n_out) share of each output's area that it won, see `shares.shares`.
        without: (n_out) the outputs if this rule were left out; NaN where nothing would fire.
    """

    number: int
    words: str
    strength: float
    shares: tuple[float, ...]
    without: tuple[float, ...]


@dataclass(frozen=True)
class Explanation:
    """Why the outputs are what they are.

    Attributes:
        system: its name.
        inputs: as taken.
        names: of the outputs.
        outputs: their values; NaN where no rule speaks.
        rules: those that fired, strongest first.
        note: what happened when nothing fired, or "".
    """

    system: str
    inputs: tuple[Reading, ...]
    names: tuple[str, ...]
    outputs: tuple[float, ...]
    rules: tuple[FiredRule, ...]
    note: str = ""

    def text(self) -> str:
        """For a terminal, up to about 120 columns."""
        lines = [f"{one.name:<6} {_taken(one):<24} {_told(one.memberships)}" for one in self.inputs]
        if self.rules:
            lines += ["", *_columns(self._header(), self._rows())]
        lines += ["", *(f"{name:<6} {number(v, 1)}" for name, v in zip(self.names, self.outputs, strict=True))]
        return "\n".join(lines + ([self.note] if self.note else []))

    def data(self) -> dict[str, Any]:
        """As plain values for JSON."""
        return {
            "system": self.system,
            "inputs": [
                {"name": r.name, "value": r.value, "used": r.used, "memberships": dict(r.memberships)}
                for r in self.inputs
            ],
            "outputs": dict(zip(self.names, self.outputs, strict=True)),
            "rules": [
                {
                    "rule": one.number,
                    "words": one.words,
                    "strength": one.strength,
                    "share": dict(zip(self.names, one.shares, strict=True)),
                    "without": dict(zip(self.names, one.without, strict=True)),
                }
                for one in self.rules
            ],
            "note": self.note,
        }

    def html(self) -> str:
        """Tables for a page."""
        rows = "".join(
            f'<tr><th scope="row">{escape(r.name)}</th><td class="number">{escape(_taken(r))}</td>'
            f"<td>{escape(_told(r.memberships))}</td></tr>"
            for r in self.inputs
        )
        head = '<tr><th scope="col">input</th><th scope="col" class="number">value</th><th scope="col">sets</th></tr>'
        text = f'<div class="scroll"><table><thead>{head}</thead><tbody>{rows}</tbody></table></div>'
        if self.rules:
            head = "".join(f'<th scope="col"{_right(i)}>{escape(h)}</th>' for i, h in enumerate(self._header()))
            rows = "".join(
                "<tr>" + "".join(f"<td{_right(i)}>{escape(cell)}</td>" for i, cell in enumerate(row)) + "</tr>"
                for row in self._rows()
            )
            text += f'<div class="scroll"><table><thead><tr>{head}</tr></thead><tbody>{rows}</tbody></table></div>'
        values = ", ".join(f"{n} = {number(v, 1)}" for n, v in zip(self.names, self.outputs, strict=True))
        return f"{text}<p><strong>{escape(values)}</strong> {escape(self.note)}</p>"

    def _repr_html_(self) -> str:
        """For notebooks."""
        return f"<figure><figcaption><b>{escape(self.system)}</b></figcaption>{self.html()}</figure>"

    def _header(self) -> list[str]:
        return [
            "rule",
            "says",
            "strength",
            *(f"{n} share" for n in self.names),
            *(f"{n} without" for n in self.names),
        ]

    def _rows(self) -> list[list[str]]:
        return [
            [
                str(one.number),
                one.words,
                number(one.strength, 3),
                *(f"{number(100.0 * s, 1)} %" for s in one.shares),
                *(number(v, 1) for v in one.without),
            ]
            for one in self.rules
        ]


def explain(system: System, x: ArrayLike, clamp: bool = True) -> Explanation:
    """Which rules fire at x (n_in,), how strongly, their share of each output, and what changes without each.

    Args:
        system: to explain.
        x: in the system's units.
        clamp: bring inputs into their universe first; never done by a system that behaves as fuzzylab.

    Raises:
        InputError: x is not one input of the system.
    """
    given = np.asarray(x, dtype=np.float64)
    if given.shape != (len(system.inputs),):
        names = ", ".join(one.name for one in system.inputs)
        raise InputError(f"{system.name!r} is explained for one input ({names}); found an array {given.shape}")
    clamps = clamp and not system.fuzzylab
    used = np.array([_clamped(v, value) if clamps else value for v, value in zip(system.inputs, given, strict=True)])
    fired = np.nan_to_num(strengths(system, given, clamp))
    outputs = evaluate(system, given, clamp)
    parts = shares(system, fired)
    rules = tuple(
        FiredRule(
            int(r) + 1, rule_words(system, system.rules[r]), float(fired[r]), tuple(parts[r].tolist()),
            tuple(evaluate(without(system, int(r) + 1), given, clamp).tolist()),
        )
        for r in np.argsort(-fired, kind="stable")
        if fired[r] > 0.0
    )  # fmt: skip
    inputs = tuple(
        Reading(v.name, v.unit, float(a), float(b), tuple((s.name, float(membership(s, b))) for s in v.sets))
        for v, a, b in zip(system.inputs, given, used, strict=True)
    )
    said = tuple(v.name for v in system.outputs)
    return Explanation(system.name, inputs, said, tuple(outputs.tolist()), rules, _note(system, inputs, rules))


def without(system: System, rule: int) -> System:
    """The system as if one of its rules, counted from 1, were not there; the others keep their numbers."""
    rules = list(system.rules)
    rules[rule - 1] = replace(rules[rule - 1], weight=0.0)
    return replace(system, rules=tuple(rules))


def _clamped(variable: Variable, value: float) -> float:
    return value if math.isnan(value) else min(max(value, variable.low), variable.high)


def _note(system: System, inputs: Sequence[Reading], rules: tuple[FiredRule, ...]) -> str:
    """Why nothing came out."""
    if rules:
        silent = [v.name for k, v in enumerate(system.outputs) if not any(r.shares[k] > 0.0 for r in rules)]
        return f"No rule that fired speaks about {', '.join(silent)}." if silent else ""
    unknown = [r.name for r in inputs if math.isnan(r.value)]
    beyond = [
        f"{r.name} = {with_unit(r.used, r.unit)} lies outside {v.low:g}..{v.high:g}"
        for r, v in zip(inputs, system.inputs, strict=True)
        if not (v.low <= r.used <= v.high or math.isnan(r.used))
    ]
    empty = [
        f"{r.name} = {with_unit(r.used, r.unit)} belongs to no set"
        for r in inputs
        if r.memberships and not any(m > 0.0 for _, m in r.memberships)
    ]
    if unknown:
        why = f"{', '.join(unknown)} is not a number"
    else:
        why = ", ".join(beyond or empty) or "no rule has this combination"
    defaults = [f"{v.name} = {v.default:g}" for v in system.outputs if math.isfinite(v.default)]
    known = f"its defaults are {', '.join(defaults)}" if defaults else "it has no default"
    return f"No rule fired: {why}. The system says nothing; {known}, and whoever asked must decide."


def _taken(reading: Reading) -> str:
    """The value, and what it was clamped to."""
    text = with_unit(reading.value, reading.unit)
    return text if reading.used == reading.value or math.isnan(reading.value) else f"{text} taken as {reading.used:g}"


def _told(memberships: tuple[tuple[str, float], ...]) -> str:
    """`N 0.20, M 0.80`; sets at zero are left out."""
    held = [f"{name} {m:.3g}" for name, m in memberships if m > 0.0]
    return ", ".join(held) or ("in no set" if memberships else "")


def _right(column: int) -> str:
    return "" if column == 1 else ' class="number"'


def _columns(header: list[str], rows: list[list[str]]) -> list[str]:
    widths = [max(len(row[i]) for row in (header, *rows)) for i in range(len(header))]
    return [
        "  ".join(
            c.ljust(w) if i == 1 else c.rjust(w) for i, (c, w) in enumerate(zip(row, widths, strict=True))
        ).rstrip()
        for row in (header, *rows)
    ]
