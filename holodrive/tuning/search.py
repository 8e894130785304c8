"""CMA-ES in the unit cube, asked and told (Hansen and Ostermeier 2001, by the package `cma`)."""

import math
import warnings
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from holodrive.errors import InputError
from holodrive.types import Array

TRIES = 200  # for one candidate that is allowed


class Search:
    """An evolution strategy over (p,) points in 0..1.

    Args:
        start: (p,) where it begins.
        sigma: standard deviation of the first candidates, as a share of the cube's edge.
        population: candidates of a generation; 4 + 3 ln p when None.
        seed: of all its random numbers; nothing global is touched.
        allowed: whether a point may be a candidate; others are drawn again.
    """

    def __init__(
        self,
        start: Array,
        sigma: float,
        population: int | None,
        seed: int,
        allowed: Callable[[Array], bool] = lambda point: True,
    ) -> None:
        if not (0.0 < sigma <= 1.0):
            raise InputError(f"sigma is {sigma:g}; it is a share of the fields' ranges, above 0 and at most 1")
        if population is not None and population < 4:
            raise InputError(f"a population of {population} cannot learn a direction; take 4 or more")
        self._p, self.allowed = len(start), allowed
        random = np.random.default_rng(seed)
        options = {
            "bounds": [0.0, 1.0],
            "seed": math.nan,  # leaves NumPy's global generator alone
            "randn": lambda *shape: random.standard_normal(shape),
            "popsize": population,
            "verbose": -9,
            "verb_log": 0,
        }
        # a second coordinate that means nothing: the strategy is not made for one
        padded = np.append(start, [0.5] * (2 - self._p))
        self._es: Any = _cma().CMAEvolutionStrategy(
            padded, sigma, {key: value for key, value in options.items() if value is not None}
        )
        self.population = int(self._es.popsize)
        self._asked: list[Array] = []

    def ask(self) -> list[Array]:
        """The candidates of the next generation, each (p,).

        Raises:
            InputError: hardly any point is allowed.
        """
        self._asked = self._es.ask()
        for k, point in enumerate(self._asked):
            found, tries = point, 0
            while not self.allowed(found[: self._p]):
                if (tries := tries + 1) > TRIES:
                    raise InputError("hardly any values in these ranges are allowed together; give narrower ranges")
                found = self._es.ask(1)[0]
            self._asked[k] = found
        return [point[: self._p] for point in self._asked]

    def tell(self, costs: Sequence[float]) -> None:
        """The costs of the candidates that were asked for, in their order."""
        self._es.tell(self._asked, [float(cost) for cost in costs])

    @property
    def favourite(self) -> Array:
        """(p,) the middle of what the strategy believes to be good."""
        return np.asarray(self._es.result.xfavorite[: self._p], dtype=np.float64)

    @property
    def spread(self) -> float:
        """Standard deviation of the next candidates, the mean over the axes, as a share of the edge."""
        return float(np.mean(self._es.result.stds[: self._p]))

    @property
    def converged(self) -> str:
        """Why there is nothing left to find; "" while there is."""
        return ", ".join(self._es.stop())


def _cma() -> Any:
    with warnings.catch_warnings():  # it tells at import that it cannot plot, which nobody asks of it
        warnings.filterwarnings("ignore", message="Could not import matplotlib", category=UserWarning)
        import cma

    return cma
