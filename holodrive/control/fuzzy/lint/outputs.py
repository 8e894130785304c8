"""Lint of outputs: ends that cannot be reached, no zero, and jumps, by one-sided limits at the break points."""

import math
from collections.abc import Iterator
from dataclasses import replace
from itertools import product

import numpy as np

from holodrive.control.fuzzy.evaluation import evaluate
from holodrive.control.fuzzy.lint.finding import Finding, numbers, with_unit
from holodrive.control.fuzzy.lint.patterns import input_patterns
from holodrive.control.fuzzy.sets import Set
from holodrive.control.fuzzy.shape import Shape, breaks, shapes
from holodrive.control.fuzzy.system import Rule, System, Variable
from holodrive.types import Array

SHORT = 0.05  # share of an output's range that an end may be missed by before it is told
_STEP = 1e-6  # share of an input's universe: the two points that a one-sided limit is drawn from
_MOST = 20_000  # places of the other inputs that a jump is looked for at
# change little when memberships do; a bisector leaps over the gap between two sets that outweigh each other in turn
_SMOOTH = ("centroid", "wtaver", "wtsum")


def check_outputs(system: System) -> Iterator[Finding]:
    """All checks that look at what comes out."""
    plain = replace(system, fuzzylab=False)
    for index, variable in enumerate(system.outputs):
        if used := _used(system, index):
            yield from _beyond(plain, index, used)
            yield from _zero(system, variable, used)
            yield from _reach(plain, index, used)
    if system.defuzzification in _SMOOTH:
        yield from _jumps(plain)
    else:
        yield Finding(
            "F-STEPS", "info",
            f"defuzzification by {system.defuzzification} jumps wherever one rule overtakes another; jumps not told",
        )  # fmt: skip


def conclusion(system: System, output: int, index: int) -> tuple[float, float]:
    """What an output is when set `index` (from 1) is its only conclusion: in the limit of no strength, and at full.

    Found by the engine itself, from a system of one input that is the strength of one rule.
    """
    variable = replace(system.outputs[output], default=np.nan)
    one = variable.sets[index - 1]
    if one.kind in ("constant", "linear"):
        return one.params[-1], one.params[-1]
    strength = Variable("strength", 0.0, 1.0, (Set("on", "triangle", (0.0, 1.0, 1.0)),))
    ramp = replace(
        system, name="ramp", inputs=(strength,), outputs=(variable,), rules=(Rule((1,), (index,)),), fuzzylab=False
    )
    near, far, full = evaluate(ramp, np.array([[_STEP], [2.0 * _STEP], [1.0]]), True)[:, 0].tolist()
    return 2.0 * near - far, full


def _used(system: System, output: int) -> list[int]:
    """Numbers of the sets that a rule concludes."""
    return sorted({rule.outputs[output] for rule in system.rules if rule.weight > 0.0} - {0})


def _beyond(system: System, output: int, used: list[int]) -> Iterator[Finding]:
    """Sets that a rule concludes and that do not reach into the range."""
    variable = system.outputs[output]
    for index in used:
        if not math.isnan(conclusion(system, output, index)[1]):
            continue
        rules = tuple(n for n, rule in enumerate(system.rules, 1) if rule.outputs[output] == index)
        yield Finding(
            "F-DEAD", "warning",
            f"set {variable.sets[index - 1].name} of {variable.name} has no part in its range, {variable.low:g} to "
            f"{with_unit(variable.high, variable.unit)}: {numbers(rules)} say{'s' * (len(rules) == 1)} nothing of it",
            variable=variable.name, rules=rules,
        )  # fmt: skip


def _zero(system: System, variable: Variable, used: list[int]) -> Iterator[Finding]:
    if not variable.low < 0.0 < variable.high:
        return
    sets = [variable.sets[i - 1] for i in used]
    if any(one.kind == "linear" for one in sets):
        return
    spans = [_support(one, variable) for one in sets]
    near = 0.01 * min(-variable.low, variable.high)  # a lone number within one hundredth counts as zero
    if any(low - near * (low == high) <= 0.0 <= high + near * (low == high) for low, high in spans):
        return
    below = max((high for _, high in spans if high < 0.0), default=variable.low)
    above = min((low for low, _ in spans if low > 0.0), default=variable.high)
    yield Finding(
        "F-ZERO", "warning",
        f"no set of {variable.name} holds 0: between {below:g} and {with_unit(above, variable.unit)} there is none, "
        "so no rule can ask for a stop",
        variable=variable.name, at=0.0, value=above - below,
    )  # fmt: skip


def _support(one: Set, variable: Variable) -> tuple[float, float]:
    if one.kind in ("constant", "singleton"):
        return one.params[-1], one.params[-1]
    curve = Shape.of(one, variable.low, variable.high)
    places = breaks([curve], variable.low, variable.high)
    middles = 0.5 * (places[:-1] + places[1:])
    holds = curve.at(middles) > 0.0
    return (float(places[:-1][holds].min()), float(places[1:][holds].max())) if holds.any() else (np.inf, -np.inf)


def _reach(system: System, output: int, used: list[int]) -> Iterator[Finding]:
    """What lies between the lowest and the highest conclusion is all that can come out."""
    variable = system.outputs[output]
    if system.defuzzification == "wtsum" or any(variable.sets[i - 1].kind == "linear" for i in used):
        return  # conclusions add up, or move with the inputs: no such ends
    ends = [value for i in used for value in conclusion(system, output, i) if np.isfinite(value)]
    if not ends:
        return
    low, high = min(ends), max(ends)
    room = SHORT * (variable.high - variable.low)
    if low - variable.low > room or variable.high - high > room:
        yield Finding(
            "F-REACH", "info",
            f"{variable.name} can only be from {low:.4g} to {high:.4g}, not {variable.low:g} to "
            f"{with_unit(variable.high, variable.unit)} as its range says",
            variable=variable.name, value=(high - low) / (variable.high - variable.low),
        )  # fmt: skip


def _jumps(system: System) -> Iterator[Finding]:
    """Every inner break point of every input at which an output's limits from both sides differ."""
    places = [_places(system, i) for i in range(len(system.inputs))]
    if any(_count(places, i) > _MOST for i in range(len(places))):
        places = [input_patterns(system, i).place for i in range(len(system.inputs))]
    for index, variable in enumerate(system.inputs):
        if not variable.sets:
            continue
        if _count(places, index) > _MOST:
            yield Finding("F-LARGE", "info", f"too many combinations: jumps along {variable.name} were not looked for")
            continue
        others = _combined([p for i, p in enumerate(places) if i != index])
        inner = np.unique(np.concatenate([curve.x for curve in shapes(variable)]))
        for place in inner[(inner > variable.low) & (inner < variable.high)].tolist():
            yield from _jump(system, index, place, others)


def _combined(places: list[Array]) -> Array:
    """Every combination (m, n) of n lists of places; one empty row of none."""
    rows = list(product(*places))
    return np.array(rows, dtype=np.float64).reshape(len(rows), len(places))


def _count(places: list[Array], index: int) -> int:
    return math.prod(len(p) for i, p in enumerate(places) if i != index)


def _places(system: System, index: int) -> Array:
    """Break points of an input and the middles between them: one of each piece on which outputs are smooth."""
    variable = system.inputs[index]
    curves = shapes(variable)
    if any(one.kind in ("gaussian", "bell") for one in variable.sets):
        return input_patterns(system, index).place  # smooth everywhere: only which rules fire can matter
    points = breaks(curves, variable.low, variable.high)
    return np.unique(np.concatenate([points, 0.5 * (points[:-1] + points[1:])]))


def _jump(system: System, index: int, place: float, others: Array) -> Iterator[Finding]:
    variable = system.inputs[index]
    below, above = (limits(system, index, place, others, side) for side in (-1.0, 1.0))
    size = np.abs(above - below)  # (m, n_out)
    spans = np.array([v.high - v.low for v in system.outputs])
    share = np.where(np.isfinite(size), size / spans, 0.0)
    if share.max(initial=0.0) <= 1e-6:
        return
    row, output = (int(i) for i in np.unravel_index(int(np.argmax(share)), share.shape))
    names = [v.name for i, v in enumerate(system.inputs) if i != index]
    held = ", ".join(f"{name} = {value:.6g}" for name, value in zip(names, others[row].tolist(), strict=True))
    yield Finding(
        "F-JUMP", "warning",
        f"{system.outputs[output].name} jumps by {size[row, output]:.4g}, from {below[row, output]:.4g} to "
        f"{above[row, output]:.4g}, where {variable.name} passes {with_unit(place, variable.unit)}"
        + (f" (at {held})" if held else ""),
        variable=variable.name, at=place, value=float(size[row, output]),
    )  # fmt: skip


def limits(system: System, index: int, place: float, others: Array, side: float) -> Array:
    """One-sided limits (m, n_out) of the outputs as one input goes to a place and the others are held.

    Args:
        system: to evaluate.
        index: of the moving input.
        place: where it goes to, in its own units.
        others: (m, n_in - 1) the other inputs.
        side: +1 from above, -1 from below.

    Outputs are smooth beside a break point, so the straight line through two near values meets the limit to second
    order in a millionth of the universe.
    """
    step = side * _STEP * (system.inputs[index].high - system.inputs[index].low)
    near, far = (
        evaluate(system, np.insert(others, index, place + times * step, axis=1), False) for times in (1.0, 2.0)
    )
    return np.asarray(2.0 * near - far)
