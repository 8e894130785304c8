"""Rules of FCL: IF with AND, OR, NOT and parentheses, THEN with commas or ANDs, WITH a weight."""

import math
from typing import Literal

from holodrive.control.fuzzy.files.draft import DraftVariable, position
from holodrive.control.fuzzy.files.fcl_reader import PendingRule, Reader, SyntaxFault
from holodrive.control.fuzzy.files.fcl_tokens import Token
from holodrive.control.fuzzy.files.rules import Condition, Is, Joined, Norms, Not, flat_rules
from holodrive.control.fuzzy.system import Rule
from holodrive.errors import InputError, did_you_mean

DEEPEST = 50  # parentheses within parentheses
NORMS = {
    "AND": ("conjunction", {"MIN": "min", "PROD": "prod", "BDIF": "bounded"}),
    "OR": ("disjunction", {"MAX": "max", "ASUM": "probor", "BSUM": "bounded"}),
    "ACT": ("implication", {"MIN": "min", "PROD": "prod"}),
    "ACCU": ("aggregation", {"MAX": "max", "NSUM": "sum", "SUM": "sum"}),
}
_OTHER = {"MIN": "MAX", "PROD": "ASUM", "BDIF": "BSUM"}  # the standard's pairs: one of AND and OR implies the other


def rule(reader: Reader, opening: Token) -> None:
    """`RULE name : IF ... THEN ... [WITH weight] ;`, the word RULE being read."""
    if reader.peek().kind in ("word", "number"):
        reader.take()  # people and explanations count rules from 1
    reader.expect(":")
    reader.expect("IF")
    condition = _condition(reader, 0)
    reader.expect("THEN")
    conclusions = [_conclusion(reader)]
    while reader.takes(",") or reader.takes("AND"):
        conclusions.append(_conclusion(reader))
    weight = 1.0
    if reader.takes("WITH"):
        place = reader.peek()
        weight = reader.number("the weight")
        if not 0.0 <= weight <= 1.0:
            raise SyntaxFault(place, f"the weight is {weight:g}; it must be from 0 to 1")
    reader.expect(";")
    reader.rules.append(PendingRule(opening.line, condition, conclusions, weight))


def _condition(reader: Reader, depth: int) -> Condition:
    """OR binds less than AND, AND less than NOT (IEC 61131-7)."""
    return _joined(reader, depth, "or")


def _joined(reader: Reader, depth: int, by: Literal["and", "or"]) -> Condition:
    def part() -> Condition:
        return _joined(reader, depth, "and") if by == "or" else _single(reader, depth)

    parts = [part()]
    while reader.takes(by.upper()):
        parts.append(part())
    return parts[0] if len(parts) == 1 else Joined(by, tuple(parts))


def _single(reader: Reader, depth: int) -> Condition:
    if depth > DEEPEST:
        raise SyntaxFault(reader.peek(), f"more than {DEEPEST} parentheses stand within each other")
    if reader.takes("NOT"):
        return Not(_single(reader, depth + 1))
    opening = reader.peek()
    if reader.takes("("):
        inner = _condition(reader, depth + 1)
        if not reader.takes(")"):
            raise SyntaxFault(opening, "this parenthesis is not closed")
        return inner
    index, number = _is(reader, reader.draft.inputs, "input")
    return Is(index, number)


def _conclusion(reader: Reader) -> tuple[int, int]:
    start = reader.peek()
    index, number = _is(reader, reader.draft.outputs, "output")
    if number < 0:
        raise SyntaxFault(start, "a conclusion cannot be NOT")
    return index, number


def _is(reader: Reader, variables: list[DraftVariable], what: str) -> tuple[int, int]:
    """`variable IS [NOT] term`: index of the variable from 0, number of the set from 1, negative for NOT."""
    name = reader.name(f"an {what}")
    index = position([one.name for one in variables], name.text) - 1
    if index < 0:
        raise _unknown(name, what, [one.name for one in variables])
    reader.expect("IS")
    negative = reader.takes("NOT")
    place = reader.name(f"a term of {name.text}")
    number = variables[index].find(place.text)
    if not number and id(variables[index]) not in reader.blocks:
        number = 1  # that it has no block is said once; nothing comes of this file
    if not number:
        raise _unknown(place, f"term of {variables[index].name}", variables[index].names)
    return index, -number if negative else number


def _unknown(token: Token, what: str, known: list[str]) -> SyntaxFault:
    near = did_you_mean(token.text, known)
    return SyntaxFault(
        token,
        f"no {what} called {token.text!r}{near}",
        f"known: {', '.join(known)}" if known else f"there is no {what} at all",
    )


def settled_rules(reader: Reader) -> None:
    """The rules of the file as rules of a system, now that it is known how it joins."""
    draft, options = reader.draft, reader.draft.options
    words = {key: token.upper for key, token in reader.norms.items()}
    if "AND" not in words:
        words["AND"] = next((one for one, other in _OTHER.items() if other == words.get("OR")), "MIN")
    words.setdefault("OR", _OTHER[words["AND"]])
    for key, word in words.items():
        name, allowed = NORMS[key]
        options[name] = allowed[word]
    strongest = options.get("aggregation", "max") == "max" and options.get("kind") != "sugeno"
    norms = Norms(options["conjunction"], options["disjunction"], strongest)
    for pending in reader.rules:
        try:
            parts = flat_rules(pending.condition, norms, [one.name for one in draft.inputs])
        except InputError as error:
            draft.fault(pending.line, str(error))
            continue
        if math.isnan(pending.weight):
            continue
        for chosen, connective in parts:
            inputs = tuple(chosen.get(index, 0) for index in range(len(draft.inputs)))
            for outputs in _outputs(pending.conclusions, len(draft.outputs)):
                draft.add_rule(pending.line, Rule(inputs, outputs, pending.weight, connective))


def _outputs(conclusions: list[tuple[int, int]], count: int) -> list[tuple[int, ...]]:
    """One row of sets; an output that is concluded twice gets a second row, which is a rule of its own."""
    rows: list[dict[int, int]] = []
    for index, number in conclusions:
        row = next((one for one in rows if index not in one), None)
        if row is None:
            rows.append(row := {})
        row[index] = number
    return [tuple(row.get(index, 0) for index in range(count)) for row in rows]
