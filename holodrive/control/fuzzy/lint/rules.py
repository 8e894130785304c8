"""Lint of rules: missing, duplicate, contradictory, dead and masked ones, and sets that none of them names."""

import math
from collections.abc import Iterator
from itertools import combinations

import numpy as np
from numpy.typing import NDArray

from holodrive.control.fuzzy.lint.finding import Finding, rule_words
from holodrive.control.fuzzy.lint.inputs import dead_share
from holodrive.control.fuzzy.lint.patterns import MOST, Patterns, fired, input_patterns
from holodrive.control.fuzzy.shape import Shape, breaks, shapes
from holodrive.control.fuzzy.system import Rule, System

_TOLD = 3  # combinations named in one finding; the others are counted


def check_rules(system: System) -> Iterator[Finding]:
    """All checks that look at rules as such."""
    yield from _missing(system)
    yield from _pairs(system)
    yield from _dead(system)
    yield from _unused(system)


def _missing(system: System) -> Iterator[Finding]:
    counts = [max(len(v.sets), 1) for v in system.inputs]
    found = [input_patterns(system, i) for i in range(len(system.inputs))]
    if max(math.prod(counts), math.prod(len(one) for one in found)) > MOST:
        yield Finding(
            "F-LARGE", "info", f"{math.prod(counts)} combinations of sets: whether each has a rule was not looked at"
        )
        return
    crisp = [_crisp(count, len(v.sets)) for count, v in zip(counts, system.inputs, strict=True)]
    fires = fired(system, crisp)
    covered = [_without_gaps(one) for one in found]
    dead = dead_share(system, covered)
    every = math.prod(counts)
    holes = np.argwhere(~fires.any(axis=-1))
    if len(holes):
        effect = f"nothing fires in {100.0 * dead:.2g} % of the universe" if dead > 0.0 else "neighbours cover for it"
        text = f"{len(holes)} of {every} combinations have no rule: {_combinations(system, holes)}; {effect}"
        yield Finding("F-MISSING", "error" if dead > 0.0 else "warning", text, value=dead)
    for k, variable in enumerate(system.outputs):
        speaks = [rule.outputs[k] > 0 for rule in system.rules]
        holes = np.argwhere(fires.any(axis=-1) & ~fires[..., speaks].any(axis=-1))
        if not (any(speaks) and len(holes)):
            continue
        share = dead_share(system, covered, k) - dead
        effect = f"it is silent in {100.0 * share:.2g} % of the universe" if share > 0.0 else "neighbours cover for it"
        text = (
            f"{len(holes)} of {every} combinations have rules, but none that speaks about {variable.name}: "
            f"{_combinations(system, holes)}; {effect}"
        )
        yield Finding("F-MISSING", "error" if share > 0.0 else "warning", text, variable=variable.name, value=share)


def _crisp(count: int, sets: int) -> Patterns:
    """As if an input were wholly in one set at a time."""
    holds: NDArray[np.bool_] = np.eye(count, dtype=bool)[:, :sets]
    return Patterns(holds, ~holds, np.ones(count), np.arange(count, dtype=np.float64))


def _without_gaps(one: Patterns) -> Patterns:
    """Without the places where no set holds: those are told as gaps of the input."""
    keep = one.holds.any(axis=-1) if one.holds.shape[1] else np.ones(len(one), dtype=bool)
    return Patterns(one.holds[keep], one.short[keep], one.width[keep], one.place[keep])


def _combinations(system: System, holes: NDArray[np.intp]) -> str:
    """The first ones, and how many more there are."""
    more = f" and {len(holes) - _TOLD} more" if len(holes) > _TOLD else ""
    return "; ".join(_combination(system, hole) for hole in holes[:_TOLD].tolist()) + more


def _combination(system: System, hole: list[int]) -> str:
    named = [f"{v.name}={v.sets[i].name}" for v, i in zip(system.inputs, hole, strict=True) if v.sets]
    return ", ".join(named)


def _condition(rule: Rule) -> tuple[tuple[int, ...], str]:
    """What makes two conditions the same; with one literal the connective says nothing."""
    return rule.inputs, "and" if sum(1 for one in rule.inputs if one) == 1 else rule.connective


def _pairs(system: System) -> Iterator[Finding]:
    """Contradictions and duplicates; two rules about different outputs are neither."""
    groups: dict[tuple[tuple[int, ...], str], list[int]] = {}
    for number, rule in enumerate(system.rules, 1):
        if rule.weight > 0.0:
            groups.setdefault(_condition(rule), []).append(number)
    for group in groups.values():
        for first, second in combinations(group, 2):
            a, b = system.rules[first - 1], system.rules[second - 1]
            both = [(k, x, y) for k, (x, y) in enumerate(zip(a.outputs, b.outputs, strict=True)) if x and y]
            against = [system.outputs[k] for k, x, y in both if x != y]
            if against:
                variable = against[0]
                k = system.outputs.index(variable)
                names = " and ".join(variable.sets[rule.outputs[k] - 1].name for rule in (a, b))
                yield Finding(
                    "F-CONTRADICT", "error",
                    f"rules {first} and {second} have the same condition, but say that {variable.name} is {names}",
                    variable=variable.name, rules=(first, second),
                )  # fmt: skip
            elif both and a.outputs == b.outputs:
                yield Finding(
                    "F-DUPLICATE", "warning", f"rules {first} and {second} say the same: {rule_words(system, a)}",
                    rules=(first, second),
                )  # fmt: skip


def _dead(system: System) -> Iterator[Finding]:
    curves = [shapes(v) for v in system.inputs]
    never = {n for n in range(1, len(system.rules) + 1) if _never_fires(system, curves, n)}
    for number in sorted(never):
        rule = system.rules[number - 1]
        why = "its weight is 0" if rule.weight == 0.0 else "its condition holds nowhere in the universe"
        yield Finding("F-DEAD", "warning", f"rule {number} never fires: {why}", rules=(number,))
    if system.kind == "sugeno" or system.aggregation != "max":
        return  # every rule adds to the outcome there
    for number in range(1, len(system.rules) + 1):
        for other in range(1, len(system.rules) + 1):
            if other == number or {number, other} & never or not _masks(system, curves, other, number):
                continue
            yield Finding(
                "F-MASKED", "warning",
                f"rule {number} changes nothing: rule {other} is always at least as strong and says the same",
                rules=(number, other),
            )  # fmt: skip
            break


def _never_fires(system: System, curves: list[list[Shape]], number: int) -> bool:
    rule = system.rules[number - 1]
    tops = [
        _top(curves[index][abs(literal) - 1], literal, variable.low, variable.high)
        for index, (literal, variable) in enumerate(zip(rule.inputs, system.inputs, strict=True))
        if literal
    ]
    strength = max(tops)
    if rule.connective == "and":
        bounded = sum(tops) - (len(tops) - 1)
        strength = bounded if system.conjunction == "bounded" else min(tops)
    return rule.weight * max(strength, 0.0) <= 0.0


def _top(curve: Shape, literal: int, low: float, high: float) -> float:
    """The greatest membership of a literal over the universe."""
    places = breaks([curve], low, high, crossings=False)
    values = np.concatenate([curve.at(places), curve.before(places[1:]), curve.after(places[:-1])])
    return float(values.max() if literal > 0 else 1.0 - values.min())


def _masks(system: System, curves: list[list[Shape]], over: int, under: int) -> bool:
    """Whether rule `over` hides rule `under` everywhere, by each literal; a duplicate's second hides nothing."""
    a, b = system.rules[over - 1], system.rules[under - 1]
    same = _condition(a) == _condition(b)
    if a.connective != b.connective and not same:
        return False
    if same and a.outputs == b.outputs:
        return False  # told as duplicate
    says = all(y in (x, 0) for x, y in zip(a.outputs, b.outputs, strict=True)) and any(b.outputs)
    if not says or a.weight < b.weight:
        return False
    for index, (x, y) in enumerate(zip(a.inputs, b.inputs, strict=True)):
        if x == y:
            continue
        none_over = a.connective == "and" and x == 0  # not asked: as good as 1
        none_under = a.connective == "or" and y == 0  # not asked: as good as 0
        if not (none_over or none_under or (x and y and _above(system, curves, index, x, y))):
            return False
    return True


def _above(system: System, curves: list[list[Shape]], index: int, x: int, y: int) -> bool:
    """Whether literal x of an input is everywhere at least literal y."""
    variable = system.inputs[index]
    upper, lower = curves[index][abs(x) - 1], curves[index][abs(y) - 1]
    places = breaks([upper, lower], variable.low, variable.high)
    for side in ("at", "before", "after"):
        where = places if side == "at" else places[1:] if side == "before" else places[:-1]
        a, b = getattr(upper, side)(where), getattr(lower, side)(where)
        a, b = a if x > 0 else 1.0 - a, b if y > 0 else 1.0 - b
        if np.any(a < b - 1e-12):
            return False
    return True


def _unused(system: System) -> Iterator[Finding]:
    named = [{abs(rule.inputs[i]) for rule in system.rules} - {0} for i in range(len(system.inputs))]
    said = [{rule.outputs[k] for rule in system.rules} - {0} for k in range(len(system.outputs))]
    for variable, used in zip((*system.inputs, *system.outputs), (*named, *said), strict=True):
        linear = system.kind == "sugeno" and any(s.kind == "linear" for v in system.outputs for s in v.sets)
        if not used and not (linear and variable in system.inputs):
            yield Finding("F-UNUSED", "info", f"no rule names {variable.name}", variable=variable.name)
            continue
        idle = [one.name for i, one in enumerate(variable.sets, 1) if used and i not in used]
        if idle:
            what = f"set {idle[0]}" if len(idle) == 1 else f"sets {', '.join(idle)}"
            yield Finding("F-UNUSED", "info", f"no rule names the {what} of {variable.name}", variable=variable.name)
