"""What tuning makes small: the mean over runs of a cost that is defined here, and nowhere else.

A metric's name is its own cost; one of which more is better (arrived, min_clearance_m) counts with a minus. Several
are added, each with a weight: `rms_error_m + 0.1*max_error_m`. A run that a fault stopped, or in which the robot ran
into something, costs `WORST`; so does one whose metric is not finite.

`success` is for driving to a goal among obstacles. With r = (distance still to go) / (distance at the start), at
most 1, and the gap = least clearance from the footprint to anything:

    arrived        0.3 time / t + 0.3 (path / straight - 1) + 0.3 max(0, 1 - gap / 10 cm), at most 0.9
    not arrived    1 + r
    ran into something, or stopped by a fault       2 + r

So no saving of time is worth a run that does not arrive, and no arrival a collision; and a start with which nothing
arrives yet still has a way down.
"""

import re
from dataclasses import dataclass
from typing import Any

import numpy as np

from holodrive import metrics
from holodrive.errors import InputError, UnknownName
from holodrive.log.words import words
from holodrive.tuning.sweep import Sweep
from holodrive.types import Array

SUCCESS = "success"
WORST = 1e3
COMFORTABLE_M = 0.1  # a wider gap is not worth a detour
_SHARE = 0.3  # each of time, length and gap
_TERM = re.compile(r"\s*(?:([0-9.eE+-]+)\s*\*)?\s*([A-Za-z]\w*)\s*")


@dataclass(frozen=True)
class Objective:
    """A cost of runs.

    Attributes:
        text: as the user gave it.
        terms: (weight, metric), added up; empty for `success`.
    """

    text: str
    terms: tuple[tuple[float, str], ...]

    @classmethod
    def parse(cls, text: str) -> "Objective":
        """From `success` or `metric + 0.1*metric`.

        Raises:
            UnknownName: no such metric.
            InputError: it cannot be read.
        """
        if text.strip() == SUCCESS:
            return cls(SUCCESS, ())
        terms = []
        for part in text.split("+"):
            match = _TERM.fullmatch(part)
            try:
                weight = float(match[1] or 1.0) if match else 0.0
            except ValueError:
                weight = 0.0
            if match is None or not (0.0 < weight < np.inf):
                raise InputError(f"a metric to tune for is success, NAME or NAME + 0.1*NAME; found {text!r}")
            if match[2] not in metrics.NAMES:
                raise UnknownName("metric", match[2], (SUCCESS, *metrics.NAMES))
            terms.append((-weight if words(match[2]).better == "high" else weight, match[2]))
        return cls(text.strip(), tuple(terms))

    def costs(self, runs: Sweep) -> Array:
        """(variants, runs) cost of each run.

        Raises:
            InputError: a metric of which nothing is known in these runs.
        """
        return self._sum(runs) if self.terms else success_cost(runs)

    def _sum(self, runs: Sweep) -> Array:
        total: Any = np.zeros(runs["fault"].shape)
        for weight, name in self.terms:
            if not np.isfinite(runs[name]).any():
                raise InputError(f"{name} is not known in these runs (plant {runs.job.plant}); tune for another metric")
            total = total + weight * runs[name]
        bad = (runs["fault"] != 0.0) | (runs["moved_collisions"] > 0.0) | ~np.isfinite(total)
        return np.where(bad, WORST, total)


def success_cost(runs: Sweep) -> Array:
    """(variants, runs) the cost `success`, as the module's docstring says."""
    straight = np.maximum(runs["straight_m"], 1e-9)
    left = np.clip(np.nan_to_num(runs["final_error_m"] / straight, nan=1.0), 0.0, 1.0)
    near = np.maximum(0.0, 1.0 - np.maximum(runs["min_clearance_m"], 0.0) / COMFORTABLE_M)
    longer = np.maximum(0.0, runs["path_length_m"] / straight - 1.0)
    well = np.minimum(_SHARE * (runs["time_s"] / runs.job.t + longer + near), 3.0 * _SHARE)
    hit = (runs["moved_collisions"] > 0.0) | (runs["fault"] != 0.0)
    return np.asarray(np.where(hit, 2.0 + left, np.where(runs["arrived"] == 1.0, well, 1.0 + left)))
