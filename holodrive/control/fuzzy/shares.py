"""How much of an output each rule makes: the area of the aggregated set that it wins."""

from itertools import combinations

import numpy as np

from holodrive.control.fuzzy.shape import Shape, breaks
from holodrive.control.fuzzy.system import System
from holodrive.types import Array


def shares(system: System, strengths: Array) -> Array:
    """Share (n_rules, n_out) of each rule in each output, for rules' strengths (n_rules,).

    Each column sums to 1 where a rule speaks about that output, else to 0.

    - Aggregation by max: a rule has the area in which its conclusion is the highest. Where several are equally high
      the strongest rule has it, and rules of equal strength halve it: a weaker rule with the same conclusion has 0,
      and indeed changes nothing.
    - Aggregation by sum: a rule has its own conclusion's area.
    - Singletons weigh with their height in place of an area.
    - Sugeno: a rule has its strength among those that speak about the output.

    The share says who made the set, not who moved the centroid: a rule at the set's edge moves it further than one in
    its middle. What a rule does to the number is told by leaving it out.
    """
    result = np.zeros((len(system.rules), len(system.outputs)))
    for output in range(len(system.outputs)):
        # fuzzylab takes the conclusions of the next output for this one's
        source = (output + 1) % len(system.outputs) if system.fuzzylab else output
        speaks = [r for r, rule in enumerate(system.rules) if strengths[r] > 0.0 and rule.outputs[source]]
        if speaks:
            won = _won(system, source, speaks, strengths[speaks])
            result[speaks, output] = won / won.sum() if won.sum() > 0.0 else 1.0 / len(speaks)
    return result


def _won(system: System, output: int, speaks: list[int], heights: Array) -> Array:
    """Area or weight (k,) that each of the rules that speak has."""
    variable = system.outputs[output]
    sets = [variable.sets[system.rules[r].outputs[output] - 1] for r in speaks]
    if system.kind == "sugeno":
        return heights
    if sets[0].kind == "singleton":
        places = np.array([one.params[0] for one in sets])
        return heights if system.aggregation == "sum" else _highest(places, heights)
    curves = [Shape.of(one, variable.low, variable.high) for one in sets]
    places = _cut_places(system, curves, heights, variable.low, variable.high)
    left, right = places[:-1], places[1:]
    starts = np.stack([_implied(system, c.after(left), h) for c, h in zip(curves, heights, strict=True)])
    ends = np.stack([_implied(system, c.before(right), h) for c, h in zip(curves, heights, strict=True)])
    areas = 0.5 * (starts + ends) * (right - left)  # (k, cells)
    if system.aggregation == "sum":
        return np.asarray(areas.sum(axis=1))
    wins = areas >= areas.max(axis=0) * (1.0 - 1e-12)
    strongest = np.where(wins, heights[:, None], 0.0).max(axis=0)
    wins &= heights[:, None] >= strongest
    return np.asarray((wins / wins.sum(axis=0) * areas).sum(axis=1))


def _highest(places: Array, heights: Array) -> Array:
    """Singletons under max: at each place the highest stands, equals halve it."""
    won = np.zeros(len(places))
    for place in np.unique(places):
        here = places == place
        best = here & (heights == heights[here].max())
        won[best] = heights[best] / best.sum()
    return won


def _implied(system: System, m: Array, height: float) -> Array:
    return np.minimum(m, height) if system.implication == "min" else m * height


def _cut_places(system: System, curves: list[Shape], heights: Array, low: float, high: float) -> Array:
    """Places between which every cut or scaled set is straight and no two change their order."""
    places = breaks(curves, low, high, crossings=False)
    if system.implication == "min":
        level = [Shape(np.array([low]), np.array([height])) for height in heights]
        kinks = [breaks([c, flat], low, high) for c, flat in zip(curves, level, strict=True)]
        places = np.unique(np.concatenate([places, *kinks]))
    left, right = places[:-1], places[1:]
    starts = [_implied(system, c.after(left), h) for c, h in zip(curves, heights, strict=True)]
    ends = [_implied(system, c.before(right), h) for c, h in zip(curves, heights, strict=True)]
    found = [places]
    for a, b in combinations(range(len(curves)), 2):
        d0, d1 = starts[a] - starts[b], ends[a] - ends[b]
        cross = d0 * d1 < 0.0
        found.append(left[cross] + (right - left)[cross] * d0[cross] / (d0 - d1)[cross])
    return np.unique(np.concatenate(found))
