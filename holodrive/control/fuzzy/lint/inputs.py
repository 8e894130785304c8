"""Lint of inputs: gaps and coverage by break points, and what a sensor tells beyond the universe."""

import math
from collections.abc import Iterator

import numpy as np

from holodrive.control.fuzzy.lint.finding import Finding, with_unit
from holodrive.control.fuzzy.lint.patterns import MOST, Patterns, fired, input_patterns
from holodrive.control.fuzzy.shape import Shape, breaks, shapes
from holodrive.control.fuzzy.system import System, Variable
from holodrive.types import Array

HALF = 0.5  # every two neighbours of a good partition cross at one half (Ruspini's with straight sides)
_TINY = 1e-9


def check_inputs(system: System) -> Iterator[Finding]:
    """Gaps, weak coverage and sums of every input that has sets."""
    for index, variable in enumerate(system.inputs):
        curves = shapes(variable)
        if not curves:
            continue
        places = breaks(curves, variable.low, variable.high)
        gaps = list(_gaps(curves, places))
        yield from (_gap(system, index, low, high) for low, high in gaps)
        values, where = _limits(curves, places)
        yield from _cover(variable, values, where, bool(gaps))
        yield from _sum(variable, values, where)


def check_range(system: System, sensor_range: tuple[float, float]) -> Iterator[Finding]:
    """The share of the sensor's cube in which no rule fires when inputs are not clamped."""
    low, high = sensor_range
    beyond = [v for v in system.inputs if v.sets and (low < v.low or high > v.high)]
    if not beyond:
        return
    found = [input_patterns(system, i, low, high) for i in range(len(system.inputs))]
    if math.prod(len(one) for one in found) > MOST:
        yield Finding("F-LARGE", "info", "too many combinations of inputs: how much lies beyond was not weighed")
        return
    dead = dead_share(system, found)
    if dead > _TINY:
        names = ", ".join(v.name for v in beyond)
        universe = " and ".join(dict.fromkeys(f"{v.low:g}..{with_unit(v.high, v.unit)}" for v in beyond))
        yield Finding(
            "F-RANGE", "warning",
            f"the sensor tells {low:g}..{high:g}, but the universe of {names} is {universe}: without clamping no rule "
            f"fires in {100.0 * dead:.1f} % of what it can tell",
            variable=beyond[0].name if len(beyond) == 1 else "", at=beyond[0].high, value=dead,
        )  # fmt: skip


def dead_share(system: System, found: list[Patterns], output: int | None = None) -> float:
    """Share of the box that the patterns cover in which no rule fires, or none that speaks about an output."""
    fires = fired(system, found)
    if output is not None:
        fires = fires[..., [rule.outputs[output] > 0 for rule in system.rules]]
    weights = [one.width / one.width.sum() for one in found]
    volume = weights[0]
    for weight in weights[1:]:
        volume = np.multiply.outer(volume, weight)
    return float(volume[~fires.any(axis=-1)].sum())


def _gaps(curves: list[Shape], places: Array) -> Iterator[tuple[float, float]]:
    """Places and stretches where every set is zero, as (first, last)."""
    middles = 0.5 * (places[:-1] + places[1:])
    empty_at = np.all([c.at(places) <= 0.0 for c in curves], axis=0)
    empty_in = np.all([c.at(middles) <= 0.0 for c in curves], axis=0)
    start: float | None = None
    for i, place in enumerate(places.tolist()):
        inside = bool(empty_at[i]) or bool(i > 0 and empty_in[i - 1]) or bool(i < len(middles) and empty_in[i])
        before = i > 0 and bool(empty_in[i - 1])
        after = i < len(middles) and bool(empty_in[i])
        if inside and start is None:
            start = place
        if start is not None and not after:
            if before or empty_at[i]:
                yield start, place
            start = None


def _gap(system: System, index: int, low: float, high: float) -> Finding:
    variable = system.inputs[index]
    middle = 0.5 * (low + high)
    fires = any(_fires_without(system, number, index) for number in range(len(system.rules)))
    end = with_unit(high, variable.unit)
    where = f"at {end}" if low == high else f"from {low:g} to {end}"
    effect = "some rules still fire" if fires else "no rule fires"
    return Finding(
        "F-GAP", "warning" if fires else "error", f"{variable.name} {where} belongs to no set; {effect} there",
        variable=variable.name, at=middle, value=high - low,
    )  # fmt: skip


def _fires_without(system: System, number: int, index: int) -> bool:
    """Whether a rule can fire where every set of an input is zero."""
    rule = system.rules[number]
    if rule.weight <= 0.0:
        return False
    if rule.connective == "and":
        return rule.inputs[index] <= 0  # not named, or named by NOT
    return rule.inputs[index] < 0 or any(one for i, one in enumerate(rule.inputs) if i != index)


def _limits(curves: list[Shape], places: Array) -> tuple[Array, Array]:
    """Memberships (k, n_sets) at every place, its limits from both sides too; and the places (k,) they belong to."""
    rows = [np.stack([c.at(places) for c in curves], axis=-1)]
    rows += [np.stack([c.before(places[1:]) for c in curves], axis=-1)]
    rows += [np.stack([c.after(places[:-1]) for c in curves], axis=-1)]
    return np.concatenate(rows), np.concatenate([places, places[1:], places[:-1]])


def _cover(variable: Variable, values: Array, where: Array, has_gap: bool) -> Iterator[Finding]:
    greatest = values.max(axis=-1)
    least = int(np.argmin(greatest))
    if has_gap or greatest[least] >= HALF - _TINY:
        return
    at = float(where[least])
    yield Finding(
        "F-COVER", "info",
        f"{variable.name} is covered only to {greatest[least]:.2f} at {with_unit(at, variable.unit)}: "
        "rules are weak where sets cross below one half",
        variable=variable.name, at=at, value=float(greatest[least]),
    )  # fmt: skip


def _sum(variable: Variable, values: Array, where: Array) -> Iterator[Finding]:
    total = values.sum(axis=-1)
    low, high = float(total.min()), float(total.max())
    if max(abs(low - 1.0), abs(high - 1.0)) <= 1e-4:  # a curved set is drawn to within 1e-5
        return
    worst = int(np.argmax(np.abs(total - 1.0)))
    yield Finding(
        "F-SUM", "info", f"the memberships of {variable.name} sum to between {low:.3g} and {high:.3g}, not to 1",
        variable=variable.name, at=float(where[worst]), value=float(total[worst]),
    )  # fmt: skip
