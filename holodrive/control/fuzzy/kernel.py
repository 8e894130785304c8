"""The fuzzy engine: one compiled kernel for scalar calls, batches and roll-outs. It allocates nothing.

Reads the flat vector of `control.fuzzy.packing`. Conclusions are defuzzified exactly: `area` integrates what lies
between the break points of all sets, `ordered` has the closed form for sets of which only neighbours overlap.
"""

import math

from holodrive.control.fuzzy import area, ordered
from holodrive.control.fuzzy import packing as pk
from holodrive.control.fuzzy.degree import degree, joined
from holodrive.leaf import leaf

SILENT = 1e-290  # a rule below this strength does not fire: areas of such sets are no longer normal numbers


@leaf
def evaluate_into(spec, x, clamp, out, work):  # type: ignore[no-untyped-def]
    """Outputs of a system; NaN where no rule fires or an input is NaN.

    Args:
        spec: packed system.
        x: (n_in,) in the system's units.
        clamp: 1.0 brings inputs into their universe first, 0.0 leaves them.
        out: (n_out,) is written.
        work: (work_size,) scratch.
    """
    n_out = int(spec[pk.N_OUT])
    if not fire_into(spec, x, clamp, work):
        for k in range(n_out):
            out[k] = math.nan
        return
    at_outputs = int(spec[pk.AT_OUTPUTS])
    for k in range(n_out):
        at = int(spec[at_outputs + k])
        form = int(spec[at + pk.FORM])
        if form == pk.SUGENO:
            out[k] = _sugeno(spec, at, k, work)
        elif not raise_heights(spec, at, k, work):
            out[k] = math.nan
        elif form == pk.ORDERED:
            out[k] = ordered.centroid(spec, at, work[heights_at(spec) :])
        elif form == pk.CELLS:
            list_parts(spec, at, k, work)
            out[k] = area.defuzzified(spec, at, work[parts_at(spec) :])
        elif form == pk.SAMPLES:
            out[k] = _sampled(spec, at, work[heights_at(spec) :])
        else:
            out[k] = _of_singletons(spec, at, work[heights_at(spec) :])


@leaf
def strengths_into(spec, x, clamp, strengths):  # type: ignore[no-untyped-def]
    """Strength of each rule, weight included, into strengths (n_rules,); NaN where an input is NaN."""
    n_in, n_out, at_slots = int(spec[pk.N_IN]), int(spec[pk.N_OUT]), int(spec[pk.AT_SLOTS])
    missing = _any_nan(x, n_in)
    for r in range(int(spec[pk.N_RULES])):
        at = int(spec[pk.AT_RULES]) + r * (pk.SLOTS + n_in + n_out)
        strength = -1.0  # nothing joined yet
        for i in range(n_in):
            slot = int(spec[at + pk.SLOTS + i])
            if slot != 0:
                record = int(spec[at_slots + 2 * (abs(slot) - 1)])
                mu = degree(spec, record, _clamped(spec, x[i], i, clamp))
                strength = joined(spec, spec[at], strength, mu if slot > 0 else 1.0 - mu)
        strength *= spec[at + pk.WEIGHT]
        strengths[r] = math.nan if missing else strength if strength > SILENT else 0.0


@leaf
def fire_into(spec, x, clamp, work):  # type: ignore[no-untyped-def]
    """Inputs, degrees, and the list of the rules that fire into `work`; whether all inputs are numbers.

    The list: how many, then place of the rule and its strength for each.
    """
    n_in, n_out, n_slots = int(spec[pk.N_IN]), int(spec[pk.N_OUT]), int(spec[pk.N_SLOTS])
    if _any_nan(x, n_in):
        return False
    for i in range(n_in):
        work[i] = _clamped(spec, x[i], i, clamp)
    silent = _degrees(spec, n_in, n_slots, work)
    at, fired = int(spec[pk.AT_RULES]), n_in + n_slots
    n = 0
    for _ in range(int(spec[pk.N_RULES])):
        if int(spec[at + pk.NEEDS]) & silent == 0:  # most rules end here
            strength = _strength(spec, at, n_in, work)
            if strength > SILENT:
                work[fired + 1 + 2 * n], work[fired + 2 + 2 * n] = at, strength
                n += 1
        at += pk.SLOTS + n_in + n_out
    work[fired] = n
    return True


@leaf
def _degrees(spec, n_in, n_slots, work):  # type: ignore[no-untyped-def]
    """Degrees of all slots into `work`; the slots that are 0, as bits."""
    at_slots = int(spec[pk.AT_SLOTS])
    silent = 0
    for slot in range(n_slots):
        mu = degree(spec, int(spec[at_slots + 2 * slot]), work[int(spec[at_slots + 2 * slot + 1])])
        work[n_in + slot] = mu
        if mu == 0.0 and slot < pk.BITS:
            silent |= 1 << slot
    return silent


@leaf
def _strength(spec, at, n_in, work):  # type: ignore[no-untyped-def]
    """Of the rule at `at`, weight included."""
    strength = -1.0
    for i in range(n_in):
        slot = int(spec[at + pk.SLOTS + i])
        if slot > 0:
            strength = joined(spec, spec[at], strength, work[n_in + slot - 1])
        elif slot < 0:
            strength = joined(spec, spec[at], strength, 1.0 - work[n_in - slot - 1])
    return strength * spec[at + pk.WEIGHT]


@leaf
def raise_heights(spec, at, output, work):  # type: ignore[no-untyped-def]
    """Height of each of an output's sets from the rules that fire; whether any of these speaks of this output.

    Cutting or scaling a set by several strengths and taking the greatest is the same as doing so by the greatest
    strength; scaled sets add up as their strengths. Only sets that are cut and then added must be taken rule by rule,
    see `list_parts`.
    """
    heights, fired = heights_at(spec), fired_at(spec)
    for k in range(int(spec[at + pk.N_SETS])):
        work[heights + k] = 0.0
    adds = int(spec[pk.AGGREGATION]) == pk.SUM
    column = pk.SLOTS + int(spec[pk.N_IN]) + output
    fires = False
    for k in range(int(work[fired])):
        number, strength = int(spec[int(work[fired + 1 + 2 * k]) + column]), work[fired + 2 + 2 * k]
        if number > 0:
            fires = True
            place = heights + number - 1
            work[place] = work[place] + strength if adds else max(work[place], strength)
    return fires


@leaf
def fired_at(spec):  # type: ignore[no-untyped-def]
    """Place of the list of rules that fire in `work`."""
    return int(spec[pk.N_IN]) + int(spec[pk.N_SLOTS])


@leaf
def heights_at(spec):  # type: ignore[no-untyped-def]
    """Place of the heights in `work`."""
    return fired_at(spec) + 1 + 2 * int(spec[pk.N_RULES])


@leaf
def parts_at(spec):  # type: ignore[no-untyped-def]
    """Place of the list of parts in `work`; see `area`."""
    return heights_at(spec) + int(spec[pk.MOST_SETS])


@leaf
def list_parts(spec, at, output, work):  # type: ignore[no-untyped-def]
    """The sets with their heights, or the rules' sets with their strengths, for `area`: number, set, height ..."""
    parts, heights, fired = parts_at(spec), heights_at(spec), fired_at(spec)
    column = pk.SLOTS + int(spec[pk.N_IN]) + output
    n = 0
    if int(spec[pk.AGGREGATION]) == pk.SUM and int(spec[pk.IMPLICATION]) == pk.MIN:
        for k in range(int(work[fired])):
            number = int(spec[int(work[fired + 1 + 2 * k]) + column])
            if number > 0:
                work[parts + 1 + 2 * n], work[parts + 2 + 2 * n] = number - 1, work[fired + 2 + 2 * k]
                n += 1
    else:
        for k in range(int(spec[at + pk.N_SETS])):
            if work[heights + k] > 0.0:
                work[parts + 1 + 2 * n], work[parts + 2 + 2 * n] = k, work[heights + k]
                n += 1
    work[parts] = n


@leaf
def _sugeno(spec, at, output, work):  # type: ignore[no-untyped-def]
    """Mean or sum of the conclusions, weighted by strength."""
    fired, column = fired_at(spec), pk.SLOTS + int(spec[pk.N_IN]) + output
    total, weights = 0.0, 0.0
    for k in range(int(work[fired])):
        number, weight = int(spec[int(work[fired + 1 + 2 * k]) + column]), work[fired + 2 + 2 * k]
        if number > 0:
            total += weight * conclusion(spec, at, number - 1, work)
            weights += weight
    if weights == 0.0:
        return math.nan
    return total / weights if int(spec[pk.DEFUZZIFICATION]) == pk.WTAVER else total


@leaf
def conclusion(spec, at, number, x):  # type: ignore[no-untyped-def]
    """k . x + c of a Sugeno conclusion."""
    n_in = int(spec[pk.N_IN])
    place = at + pk.TABLE + number * (n_in + 1)
    value = spec[place + n_in]
    for i in range(n_in):
        if spec[place + i] != 0.0:  # so that an infinite input that it does not use leaves it alone
            value += spec[place + i] * x[i]
    return value


@leaf
def _sampled(spec, at, heights):  # type: ignore[no-untyped-def]
    """Centroid over samples as fuzzylab does it: sum mu u / sum mu; NaN when all samples miss."""
    total, moment = 0.0, 0.0
    for i in range(int(spec[at + pk.N_TABLE])):
        mu = sample(spec, at, i, heights)
        total += mu
        moment += mu * spec[at + pk.TABLE + i]
    return moment / total if total > 0.0 else math.nan


@leaf
def sample(spec, at, i, heights):  # type: ignore[no-untyped-def]
    """Greatest of the cut sets at the i-th sample."""
    n_sets = int(spec[at + pk.N_SETS])
    row = at + pk.TABLE + int(spec[at + pk.N_TABLE]) + i * n_sets
    mu = 0.0
    for k in range(n_sets):
        mu = max(mu, min(spec[row + k], heights[k]))
    return mu


@leaf
def _of_singletons(spec, at, heights):  # type: ignore[no-untyped-def]
    """Sets of one place: mean by height, median by height, or mean, least or greatest of the highest."""
    n, method = int(spec[at + pk.N_SETS]), int(spec[pk.DEFUZZIFICATION])
    total, moment, top = 0.0, 0.0, 0.0
    for k in range(n):
        total += heights[k]
        moment += heights[k] * spec[at + pk.TABLE + k]
        top = max(top, heights[k])
    if method == pk.CENTROID:
        return moment / total
    if method == pk.BISECTOR:
        return _median(spec, at, heights, 0.5 * total)
    low, high, sum_, count = math.inf, -math.inf, 0.0, 0
    for k in range(n):
        if heights[k] >= top * area.LEVEL:
            place = spec[at + pk.TABLE + k]
            low, high, sum_, count = min(low, place), max(high, place), sum_ + place, count + 1
    return low if method == pk.SOM else high if method == pk.LOM else sum_ / count


@leaf
def _median(spec, at, heights, half):  # type: ignore[no-untyped-def]
    """Least place such that the heights up to it make half of all."""
    n, best = int(spec[at + pk.N_SETS]), math.inf
    for k in range(n):
        place, below = spec[at + pk.TABLE + k], 0.0
        for j in range(n):
            if spec[at + pk.TABLE + j] <= place:
                below += heights[j]
        if heights[k] > 0.0 and below >= half and place < best:
            best = place
    return best


@leaf
def _any_nan(x, n):  # type: ignore[no-untyped-def]
    missing = False
    for i in range(n):
        missing = missing or math.isnan(x[i])
    return missing


@leaf
def _clamped(spec, value, i, clamp):  # type: ignore[no-untyped-def]
    if clamp == 0.0:
        return value
    at = int(spec[pk.AT_INPUTS]) + 2 * i
    return min(max(value, spec[at]), spec[at + 1])
