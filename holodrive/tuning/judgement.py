"""How good one variant is over runs that tuning has not seen: rates and means, each with its interval."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from holodrive import metrics
from holodrive.tuning.objective import Objective
from holodrive.tuning.statistics import interval_of_mean, wilson
from holodrive.tuning.sweep import Sweep
from holodrive.types import Array


@dataclass(frozen=True)
class Rate:
    """Successes of n, with a 95 % Wilson interval."""

    count: int
    n: int
    low: float
    high: float

    @property
    def share(self) -> float:
        """Of the n."""
        return self.count / self.n


@dataclass(frozen=True)
class Spread:
    """A metric over runs: mean with a 95 % bootstrap interval, median, 5 % and 95 % quantile; NaN where unknown."""

    mean: float
    low: float
    high: float
    median: float
    p5: float
    p95: float


@dataclass(frozen=True)
class Judgement:
    """One variant over the same runs as others.

    Attributes:
        cost: what tuning makes small.
        succeeded: arrived and ran into nothing; collided: ran into something.
        metrics: name -> spread. Times, lengths and clearances are those of the runs that succeeded, where any did.
    """

    cost: Spread
    succeeded: Rate
    collided: Rate
    metrics: dict[str, Spread]

    @classmethod
    def from_dict(cls, values: dict[str, Any]) -> "Judgement":
        """Of what `dataclasses.asdict` gives."""
        return cls(
            Spread(**values["cost"]),
            Rate(**values["succeeded"]),
            Rate(**values["collided"]),
            {name: Spread(**spread) for name, spread in values["metrics"].items()},
        )


def judge(runs: Sweep, objective: Objective) -> tuple[Judgement, ...]:
    """One judgement for each variant of a sweep."""
    costs = objective.costs(runs)
    return tuple(_judge(runs, costs[k], k) for k in range(len(costs)))


def gain(before: Array, after: Array) -> tuple[float, float, float]:
    """Mean of after - before over the same runs, and its 95 % interval: paired, so that worlds do not blur it."""
    change = np.asarray(after) - np.asarray(before)
    return (float(change.mean()), *interval_of_mean(change))


def _judge(runs: Sweep, cost: Array, k: int) -> Judgement:
    succeeded, collided = runs.succeeded[k], runs["moved_collisions"][k] > 0.0
    of = succeeded if succeeded.any() else np.ones(len(cost), dtype=bool)
    return Judgement(
        _spread(cost),
        _rate(succeeded),
        _rate(collided),
        {name: _spread(runs[name][k][of]) for name in metrics.NAMES if name not in ("arrived", "collisions")},
    )


def _rate(which: Array) -> Rate:
    count, n = int(which.sum()), len(which)
    return Rate(count, n, *wilson(count, n))


def _spread(values: Array | Sequence[float]) -> Spread:
    found = np.asarray(values, dtype=np.float64)
    found = found[np.isfinite(found)]
    if not len(found):
        return Spread(*[float("nan")] * 6)
    p5, median, p95 = (float(value) for value in np.quantile(found, (0.05, 0.5, 0.95)))
    return Spread(float(found.mean()), *interval_of_mean(found), median, p5, p95)
