"""Lint of left and right: sets, rules and wheel commands that should mirror each other."""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from holodrive.control.fuzzy.lint.finding import Finding, numbers
from holodrive.control.fuzzy.lint.outputs import conclusion
from holodrive.control.fuzzy.shape import breaks, shapes
from holodrive.control.fuzzy.system import Rule, System, Variable
from holodrive.errors import InputError

Mirror = tuple[tuple[str, str], ...]

_SIDES = (("left", "right"), ("Left", "Right"), ("LEFT", "RIGHT"))


@dataclass(frozen=True)
class Sides:
    """Indices of the mirrored variables, the left one first, and of rules' wheels where there is one pair of each."""

    inputs: tuple[tuple[int, int], ...]
    outputs: tuple[tuple[int, int], ...]

    @property
    def drives(self) -> bool:
        """Whether it reads as ranges to both sides that command a left and a right wheel."""
        return len(self.inputs) == 1 and len(self.outputs) == 1


def sides_of(system: System, mirror: Mirror | None) -> Sides:
    """The mirrored pairs, as declared or as the names say (DL and DR, L and R, `left_wheel` and `right_wheel`).

    Raises:
        InputError: a pair that names no two inputs or two outputs.
    """
    names = [v.name for v in system.inputs], [v.name for v in system.outputs]
    pairs = found_pairs([*names[0], *names[1]]) if mirror is None else mirror
    result: tuple[list[tuple[int, int]], list[tuple[int, int]]] = ([], [])
    for left, right in pairs:
        place = next((i for i, known in enumerate(names) if left in known and right in known), None)
        if place is None and mirror is not None:
            raise InputError(
                f"the mirror pair {left!r}, {right!r} names no two inputs or two outputs; "
                f"inputs: {', '.join(names[0])}; outputs: {', '.join(names[1])}"
            )
        if place is not None:
            result[place].append((names[place].index(left), names[place].index(right)))
    return Sides(tuple(result[0]), tuple(result[1]))


def found_pairs(names: list[str]) -> Mirror:
    """Pairs of names, left first, that differ in nothing but left and right, or a last or lone letter L and R."""
    pairs = []
    for name in names:
        others = [name.replace(a, b) for a, b in _SIDES if a in name]
        if name[-1:] in ("L", "l") and (len(name) <= 3 or name[-2] == "_"):
            others.append(name[:-1] + ("R" if name[-1] == "L" else "r"))
        pairs += [(name, other) for other in others if other in names]
    return tuple(pairs)


def check_mirror(system: System, sides: Sides) -> Iterator[Finding]:
    """Sets and rules of left and right."""
    for what, pairs, variables in (("IN", sides.inputs, system.inputs), ("OUT", sides.outputs, system.outputs)):
        for left, right in pairs:
            yield from _sets(system, what, variables[left], variables[right])
    if sides.inputs and sides.outputs:
        yield from _rules(system, sides)


def _sets(system: System, what: str, left: Variable, right: Variable) -> Iterator[Finding]:
    code, both = f"F-MIRROR-{what}", f"{left.name} and {right.name}"
    if (left.low, left.high) != (right.low, right.high):
        text = f"{both} have different ranges: {left.low:g}..{left.high:g} and {right.low:g}..{right.high:g}"
        yield Finding(code, "warning", text, variable=left.name)
        return
    if len(left.sets) != len(right.sets):
        text = f"{both} have {len(left.sets)} and {len(right.sets)} sets"
        yield Finding(code, "warning", text, variable=left.name)
        return
    differ = []
    worst, where = 0.0, np.nan
    for i, (a, b) in enumerate(zip(left.sets, right.sets, strict=True)):
        size, at = _difference(left, right, i) if not a.is_conclusion else (float(a.params != b.params), np.nan)
        if size > 1e-12:
            differ.append(f"{a.name} {_told(a.params)} and {_told(b.params)}")
            worst, where = (size, at) if size > worst else (worst, where)
    if not differ:
        return
    text = f"the sets of {both} differ: {', '.join(differ)}"
    if what == "OUT":
        text += _drift(system, left, right)
    yield Finding(code, "warning", text, variable=left.name, at=where, value=worst)


def _told(params: tuple[float, ...]) -> str:
    return f"({', '.join(f'{value:g}' for value in params)})"


def _difference(left: Variable, right: Variable, index: int) -> tuple[float, float]:
    """Greatest difference of memberships, and where."""
    a, b = shapes(left)[index], shapes(right)[index]
    places = breaks([a, b], left.low, left.high)
    gaps = [
        np.abs(a.at(places) - b.at(places)),
        np.append(np.abs(a.after(places[:-1]) - b.after(places[:-1])), 0.0),
        np.append(0.0, np.abs(a.before(places[1:]) - b.before(places[1:]))),
    ]
    size = np.max(gaps, axis=0)
    worst = int(np.argmax(size))
    return float(size[worst]), float(places[worst])


def _drift(system: System, left: Variable, right: Variable) -> str:
    """What the same conclusion on both sides makes of a straight way, worst set first."""
    outputs = list(system.outputs)
    kl, kr = outputs.index(left), outputs.index(right)
    drifts = [
        (conclusion(system, kr, i)[1] - conclusion(system, kl, i)[1], left.sets[i - 1].name)
        for i in range(1, len(left.sets) + 1)
    ]
    size, name = max(drifts, key=lambda pair: abs(pair[0]))
    if abs(size) <= 1e-9:
        return ""
    return f"; told {name} alike, {right.name} − {left.name} is {size:.3g}"


def _rules(system: System, sides: Sides) -> Iterator[Finding]:
    by_condition: dict[tuple[tuple[int, ...], str], int] = {}
    for number, rule in enumerate(system.rules, 1):
        by_condition.setdefault((rule.inputs, rule.connective), number)
    seen: set[int] = set()
    for number, rule in enumerate(system.rules, 1):
        swapped = swap(rule, sides)
        other = by_condition.get((swapped.inputs, swapped.connective))
        if number in seen or (other is not None and other in seen):
            continue
        if other is None:
            text = f"rule {number} has no mirror: no rule has its condition with left and right swapped"
            yield Finding("F-MIRROR-RULE", "warning", text, rules=(number,))
        elif swapped.inputs == rule.inputs:
            if swapped.outputs != rule.outputs:
                text = f"rule {number} turns although left and right are alike ({_concludes(system, rule)})"
                yield Finding("F-TIE", "info", text, rules=(number,))
        elif system.rules[other - 1].outputs != swapped.outputs:
            seen |= {number, other}
            text = (
                f"{numbers((number, other))} are mirrors, but say {_concludes(system, rule)} and "
                f"{_concludes(system, system.rules[other - 1])}"
            )
            yield Finding("F-MIRROR-RULE", "warning", text, rules=(number, other))
        elif system.rules[other - 1].weight != rule.weight:
            seen |= {number, other}
            text = f"{numbers((number, other))} are mirrors, but weigh {rule.weight:g} and "
            text += f"{system.rules[other - 1].weight:g}"
            yield Finding("F-MIRROR-RULE", "warning", text, rules=(number, other))


def swap(rule: Rule, sides: Sides) -> Rule:
    """A rule with left and right swapped in its condition and its conclusion."""
    inputs, outputs = list(rule.inputs), list(rule.outputs)
    for values, pairs in ((inputs, sides.inputs), (outputs, sides.outputs)):
        for left, right in pairs:
            values[left], values[right] = values[right], values[left]
    return Rule(tuple(inputs), tuple(outputs), rule.weight, rule.connective)


def _concludes(system: System, rule: Rule) -> str:
    """`L=P, R=PZ`."""
    return ", ".join(f"{v.name}={v.sets[i - 1].name}" for v, i in zip(system.outputs, rule.outputs, strict=True) if i)
