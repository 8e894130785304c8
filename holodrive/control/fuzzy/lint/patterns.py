"""Where which rules can fire: each input falls into few patterns of sets that hold or do not, exactly."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from holodrive.control.fuzzy.shape import breaks, shapes
from holodrive.control.fuzzy.system import System
from holodrive.types import Array

MOST = 200_000  # combinations of patterns that are looked at; more only happens from seven inputs on


@dataclass(frozen=True)
class Patterns:
    """The patterns of one input; k of them.

    Attributes:
        holds: (k, n_sets) whether a set's membership is above 0.
        short: (k, n_sets) whether it is below 1, so that NOT holds.
        width: (k,) how much of the input's range shows this pattern; 0 for single places.
        place: (k,) a place that shows it.
    """

    holds: NDArray[np.bool_]
    short: NDArray[np.bool_]
    width: Array
    place: Array

    def __len__(self) -> int:
        """How many."""
        return len(self.place)


def input_patterns(system: System, index: int, low: float | None = None, high: float | None = None) -> Patterns:
    """The patterns of an input between two places, by default over its universe."""
    variable = system.inputs[index]
    low = variable.low if low is None else low
    high = variable.high if high is None else high
    curves = shapes(variable, low, high)
    places = breaks(curves, low, high)
    middles = 0.5 * (places[:-1] + places[1:])
    at = np.concatenate([middles, places])  # stretches first, so that a pattern's place lies inside one if it can
    width = np.concatenate([np.diff(places), np.zeros(len(places))])
    values = np.stack([curve.at(at) for curve in curves], axis=-1) if curves else np.zeros((len(at), 0))
    keys = np.concatenate([values > 0.0, values < 1.0], axis=-1)
    _, first, which = np.unique(keys, axis=0, return_index=True, return_inverse=True)
    total = np.bincount(which.reshape(-1), weights=width, minlength=len(first)).astype(np.float64)
    return Patterns(values[first] > 0.0, values[first] < 1.0, total, at[first])


def fired(system: System, found: list[Patterns]) -> NDArray[np.bool_]:
    """Whether each rule fires (strength above 0) for each combination of patterns: (k1, ..., kn, n_rules).

    Exact for min and prod, max, probor and bounded sum; the bounded product can still be zero where this says true.
    """
    shape = tuple(len(one) for one in found)
    result = np.empty((*shape, len(system.rules)), dtype=bool)
    for number, rule in enumerate(system.rules):
        every = rule.connective == "and"
        value = np.full(shape, every)
        for index, (literal, one) in enumerate(zip(rule.inputs, found, strict=True)):
            if not literal:
                continue
            holds = one.holds[:, literal - 1] if literal > 0 else one.short[:, -literal - 1]
            holds = holds.reshape([-1 if i == index else 1 for i in range(len(found))])
            value = value & holds if every else value | holds
        result[..., number] = value & (rule.weight > 0.0)
    return result
