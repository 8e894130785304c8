"""A fuzzy system as one flat vector of numbers, which the kernel reads: made once, evaluated anywhere.

header   | HEADER numbers: counts, joins as numbers, places of the blocks below
inputs   | low, high for each input to be clamped to; infinite for fuzzylab, which does not clamp
slots    | place of the set's record and number of its input, for each set of each input ("slot")
records  | kind, number of parameters, parameters (triangles and trapezoids as feet and shoulders a, b, c, d)
rules    | OR?, weight, slot of each input (from 1, negative NOT, 0 not named), set of each output (from 1, 0 none)
outputs  | place of each output's block
blocks   | form, number of sets, length of the table, the table; as the form says:
  SUGENO     | k1 ... kn, c of each conclusion
  SINGLETONS | place of each set
  SAMPLES    | place of each sample (all first), then the memberships of all sets at each
  CELLS      | left end, right end of each cell, then all sets' heights at its left and at its right end; between
             | neighbouring break points of all sets ("cell") every set is straight
  ORDERED    | as CELLS, and after them (number of the set, a, b, c, d) from left to right: only neighbours overlap
"""

import math
from itertools import pairwise
from typing import get_args

import numpy as np

from holodrive.control.fuzzy import system as described
from holodrive.control.fuzzy.membership import corners, membership, polyline
from holodrive.control.fuzzy.sets import Set, SetKind
from holodrive.types import Array

N_IN, N_OUT, N_RULES, N_SLOTS, SUGENO_KIND, AND, OR, IMPLICATION, AGGREGATION, DEFUZZIFICATION = range(10)
AT_INPUTS, AT_SLOTS, AT_RULES, AT_OUTPUTS, MOST_SETS, WORK, HEADER = range(10, 17)

# numbers of the joins are their places in `system`'s lists
MIN, PROD, BOUNDED = 0, 1, 2
MAX, PROBOR = 0, 1
SUM = 1
CENTROID, BISECTOR, MOM, SOM, LOM, WTAVER, WTSUM = range(7)
TRAPEZOID, GAUSSIAN, BELL, SINGLETON, POLYLINE = range(5)  # kinds of input sets

WEIGHT, NEEDS, SLOTS = 1, 2, 3  # of a rule
BITS = 53  # slots that have a bit in NEEDS: a double holds no more
FORM, N_SETS, N_TABLE, TABLE = range(4)  # of an output's block
SUGENO, SINGLETONS, SAMPLES, CELLS, ORDERED = range(5)
SAMPLE_COUNT = 101  # of fuzzylab

_KINDS: dict[SetKind, int] = {
    "triangle": TRAPEZOID,
    "trapezoid": TRAPEZOID,
    "gaussian": GAUSSIAN,
    "bell": BELL,
    "singleton": SINGLETON,
    "polyline": POLYLINE,
}


def pack(system: described.System) -> Array:
    """The flat vector (k,) of a system."""
    n_in, n_out, n_rules = len(system.inputs), len(system.outputs), len(system.rules)
    header = np.zeros(HEADER)
    header[[N_IN, N_OUT, N_RULES]] = n_in, n_out, n_rules
    header[SUGENO_KIND] = system.kind == "sugeno"
    header[AND] = get_args(described.Conjunction).index(system.conjunction)
    header[OR] = get_args(described.Disjunction).index(system.disjunction)
    header[IMPLICATION] = get_args(described.Implication).index(system.implication)
    header[AGGREGATION] = get_args(described.Aggregation).index(system.aggregation)
    header[DEFUZZIFICATION] = get_args(described.Defuzzification).index(system.defuzzification)
    header[AT_INPUTS] = HEADER
    ends = [(-math.inf, math.inf) if system.fuzzylab else (one.low, one.high) for one in system.inputs]
    slots = _slots(system, HEADER + 2 * n_in)
    header[[AT_SLOTS, N_SLOTS]] = HEADER + 2 * n_in, sum(len(one.sets) for one in system.inputs)
    header[AT_RULES] = header[AT_SLOTS] + len(slots)
    rules = _rules(system)
    header[AT_OUTPUTS] = at = header[AT_RULES] + rules.size
    blocks = [_block(system, index) for index in range(n_out)]
    places = at + n_out + np.cumsum([0, *(len(block) for block in blocks[:-1])])
    header[MOST_SETS] = max(len(one.sets) for one in system.outputs)
    header[WORK] = _work_size(header)
    return np.concatenate([header, np.ravel(ends), slots, rules.ravel(), places, *blocks])


def work_size(packed: Array) -> int:
    """Length of the scratch vector that the kernel needs for this system."""
    return int(packed[WORK])


def _work_size(header: Array) -> int:
    """Inputs, degrees, rules that fire (2 each and their number); of one output heights and parts (5 each and their
    number); points of a cell (2 each).
    """
    most, n_rules = int(header[MOST_SETS]), int(header[N_RULES])
    parts = max(most, n_rules)
    points = 2 + max(most + 3 * most * (most - 1) // 2, n_rules)
    return int(header[N_IN] + header[N_SLOTS]) + 1 + 2 * n_rules + most + 1 + 5 * parts + 2 * points


def _slots(system: described.System, at: int) -> Array:
    """Places and inputs of all records, then the records."""
    sets = [(index, one) for index, variable in enumerate(system.inputs) for one in variable.sets]
    records = [_record(one) for _, one in sets]
    places = at + 2 * len(sets) + np.cumsum([0, *(len(record) for record in records)])
    table = [number for place, (index, _) in zip(places, sets, strict=False) for number in (float(place), index)]
    return np.array([*table, *(number for record in records for number in record)], dtype=np.float64)


def _record(one: Set) -> list[float]:
    params = corners(one) if one.kind in ("triangle", "trapezoid") else one.params
    return [_KINDS[one.kind], len(params), *params]


def _rules(system: described.System) -> Array:
    """(n_rules, 3 + n_in + n_out); fuzzylab keeps output j's conclusions in place j - 1 (its evalfis.py, line 149)."""
    first = np.cumsum([0, *(len(one.sets) for one in system.inputs)])
    rows = []
    for rule in system.rules:
        slots = [math.copysign(base + abs(k), k) if k else 0.0 for base, k in zip(first, rule.inputs, strict=False)]
        outputs = np.roll(rule.outputs, -1) if system.fuzzylab else rule.outputs
        needs = sum(2.0 ** (slot - 1.0) for slot in slots if 0 < slot <= BITS) if rule.connective == "and" else 0.0
        rows.append([rule.connective == "or", rule.weight, needs, *slots, *outputs])
    return np.array(rows, dtype=np.float64)


def _block(system: described.System, index: int) -> Array:
    """Block of the output that `evaluate` gives at this place."""
    universe = system.outputs[index]
    variable = system.outputs[(index + 1) % len(system.outputs)] if system.fuzzylab else universe
    sets = variable.sets
    if system.kind == "sugeno":
        n_in = len(system.inputs)
        rows = [one.params if one.kind == "linear" else (*[0.0] * n_in, *one.params) for one in sets]
        return _joined(SUGENO, len(sets), len(sets), [number for row in rows for number in row])
    if not sets:
        return _joined(CELLS, 0, 0, [])
    if sets[0].kind == "singleton":  # then all are: `System` sees to that
        return _joined(SINGLETONS, len(sets), len(sets), [one.params[0] for one in sets])
    if system.fuzzylab:
        places = np.linspace(universe.low, universe.high, SAMPLE_COUNT)
        heights = np.stack([membership(one, places) for one in sets], axis=1)
        return _joined(SAMPLES, len(sets), SAMPLE_COUNT, [*places, *heights.ravel()])
    cells = _cells(sets, universe.low, universe.high)
    fast = system.aggregation == "max" and system.defuzzification == "centroid"
    order = _order(sets, universe.low, universe.high, system.implication == "prod") if fast else None
    rows = [] if order is None else [(k, *corners(sets[k])) for k in order]
    form = CELLS if order is None else ORDERED
    return _joined(form, len(sets), len(cells), [*cells.ravel(), *(number for row in rows for number in row)])


def _joined(form: int, n_sets: int, n_table: int, table: list[float]) -> Array:
    return np.array([form, n_sets, n_table, *table], dtype=np.float64)


def _cells(sets: tuple[Set, ...], low: float, high: float) -> Array:
    """(n_cells, 2 + 2 n_sets)."""
    lines = [polyline(one, low, high) for one in sets]
    ends = np.unique(np.concatenate([np.array([low, high]), *(places for places, _ in lines)]))
    ends = ends[(ends >= low) & (ends <= high)]
    left, right = ends[:-1], ends[1:]
    heights = [(_limit(*line, left, "right"), _limit(*line, right, "left")) for line in lines]
    return np.column_stack([left, right, *(h for h, _ in heights), *(h for _, h in heights)])


def _limit(places: Array, heights: Array, at: Array, side: str) -> Array:
    """Height just right or just left of each place; a polyline may jump there."""
    if side == "right":
        after = np.clip(np.searchsorted(places, at, side="right"), 1, len(places) - 1)
    else:
        after = np.clip(np.searchsorted(places, at, side="left"), 1, len(places) - 1)
    before = after - 1
    width = places[after] - places[before]
    share = np.clip(np.divide(at - places[before], width, out=np.zeros_like(width), where=width > 0.0), 0.0, 1.0)
    return np.asarray(heights[before] * (1.0 - share) + heights[after] * share)


def _order(sets: tuple[Set, ...], low: float, high: float, scales: bool) -> list[int] | None:
    """Sets from left to right, when only neighbours overlap and each only by its side; None otherwise.

    Two cut sets of which one is to the right of the other in all four corners share what is below the right one's
    rising and the left one's falling side; scaled sets may cross elsewhere unless their tops are apart.
    """
    if any(one.kind not in ("triangle", "trapezoid") for one in sets):
        return None
    shapes = [corners(one) for one in sets]
    order = sorted(range(len(sets)), key=lambda k: shapes[k])
    rows = [shapes[k] for k in order]
    if rows[0][0] < low or rows[-1][3] > high:
        return None
    for left, right in pairwise(rows):
        if not all(a <= b for a, b in zip(left, right, strict=True)):
            return None
        if scales and (right[0] < left[1] or left[3] > right[2]):
            return None
    if any(left[3] > right[0] for left, right in zip(rows, rows[2:], strict=False)):
        return None
    return order
