"""From the condition of a rule, with AND, OR, NOT and parentheses, to rules that join each input once.

A `Rule` joins one set of each input by one connective. What does not fit is split into several rules where that is
the same controller: a conclusion that several rules draw counts as strongly as the strongest of them when rules are
aggregated by their maximum, and every AND distributes over OR = max. Elsewhere the rule is refused.
"""

from dataclasses import dataclass
from typing import Literal

from holodrive.errors import InputError

MOST_PARTS = 1000  # rules that one rule of a file may become

_DUAL = {("min", "max"), ("prod", "probor"), ("bounded", "bounded")}  # NOT (a AND b) = NOT a OR NOT b

Flat = tuple[dict[int, int], Literal["and", "or"]]  # input -> set from 1, negative = NOT


@dataclass(frozen=True, slots=True)
class Is:
    """An input, from 0, is a set, from 1; a negative number is NOT that set."""

    input: int
    set: int


@dataclass(frozen=True, slots=True)
class Not:
    """NOT before parentheses."""

    part: "Condition"


@dataclass(frozen=True, slots=True)
class Joined:
    """Parts joined by AND or OR."""

    by: Literal["and", "or"]
    parts: tuple["Condition", ...]


Condition = Is | Not | Joined


@dataclass(frozen=True, slots=True)
class Norms:
    """How the system joins: conjunction, disjunction, and whether the strongest of rules with one conclusion counts."""

    conjunction: str
    disjunction: str
    strongest: bool


def flat_rules(condition: Condition, norms: Norms, names: list[str]) -> list[Flat]:
    """The rules that together mean the condition; `names` are those of the inputs, for messages.

    Raises:
        InputError: no rules mean the same under these norms.
    """
    condition = _flattened(_inward(condition, False, norms))
    if isinstance(condition, Is):
        return [({condition.input: condition.set}, "and")]
    assert isinstance(condition, Joined)
    if all(isinstance(part, Is) for part in condition.parts):
        leaves = [part for part in condition.parts if isinstance(part, Is)]
        return [_all(leaves, norms, names)] if condition.by == "and" else _any(leaves, norms, names)
    _need_strongest(norms, "mixes AND and OR")
    return [_all(leaves, norms, names) for leaves in _alternatives(condition)]


def _inward(condition: Condition, negated: bool, norms: Norms) -> Condition:
    """NOT moved to the sets."""
    if isinstance(condition, Is):
        return Is(condition.input, -condition.set) if negated else condition
    if isinstance(condition, Not):
        return _inward(condition.part, not negated, norms)
    if negated and (norms.conjunction, norms.disjunction) not in _DUAL:
        raise InputError(
            f"NOT before parentheses needs AND and OR that belong together; {norms.conjunction} and "
            f"{norms.disjunction} do not"
        )
    other: Literal["and", "or"] = "or" if condition.by == "and" else "and"
    return Joined(other if negated else condition.by, tuple(_inward(part, negated, norms) for part in condition.parts))


def _flattened(condition: Condition) -> Condition:
    """AND of ANDs is one AND, OR of ORs one OR."""
    if not isinstance(condition, Joined):
        return condition
    parts: list[Condition] = []
    for part in map(_flattened, condition.parts):
        parts += part.parts if isinstance(part, Joined) and part.by == condition.by else [part]
    return parts[0] if len(parts) == 1 else Joined(condition.by, tuple(parts))


def _all(leaves: list[Is], norms: Norms, names: list[str]) -> Flat:
    chosen: dict[int, int] = {}
    for leaf in leaves:
        if chosen.get(leaf.input, leaf.set) != leaf.set:
            raise InputError(
                f"two conditions on {names[leaf.input]!r} are joined by AND; a rule names an input once",
            )
        if leaf.input in chosen and norms.conjunction != "min":
            raise InputError(f"the same condition on {names[leaf.input]!r} comes twice; it would count twice")
        chosen[leaf.input] = leaf.set
    return chosen, "and"


def _any(leaves: list[Is], norms: Norms, names: list[str]) -> list[Flat]:
    """One rule, or several where an input is named more than once."""
    groups: list[dict[int, int]] = []
    for leaf in leaves:
        group = next((one for one in groups if one.get(leaf.input, leaf.set) == leaf.set), None)
        if (group is None and groups) or (group is not None and leaf.input in group):
            _need_strongest(norms, f"names {names[leaf.input]!r} more than once")
        if group is None:
            group = {}
            groups.append(group)
        group[leaf.input] = leaf.set
    return [(group, "or" if len(group) > 1 else "and") for group in groups]


def _alternatives(condition: Condition) -> list[list[Is]]:
    """The disjunctive normal form: every inner list is a conjunction."""
    if isinstance(condition, Is):
        return [[condition]]
    assert isinstance(condition, Joined)
    inner = [_alternatives(part) for part in condition.parts]
    if condition.by == "or":
        return [one for alternatives in inner for one in alternatives]
    found: list[list[Is]] = [[]]
    for alternatives in inner:
        if len(found) * len(alternatives) > MOST_PARTS:
            raise InputError(f"written out, the condition has more than {MOST_PARTS} rules")
        found = [[*left, *right] for left in found for right in alternatives]
    return found


def _need_strongest(norms: Norms, what: str) -> None:
    if norms.disjunction != "max" or not norms.strongest:
        raise InputError(
            f"the condition {what}, which several rules could only say with OR = max and rules aggregated by max; "
            f"here OR is {norms.disjunction} and rules are {'aggregated by max' if norms.strongest else 'summed'}"
        )
