"""Runs of the Mecanum robot along paths, many at once, and what is measured of them."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from holodrive import build, planning, robots
from holodrive.experiments.mecanum import paths
from holodrive.references import Table
from holodrive.robots.spec import Robot
from holodrive.types import Array

ROBOT = "mecanum4_mice"
PLANT: build.Plant = "pwm_map"


@dataclass(frozen=True)
class Variant:
    """A tracker with its parameters and the estimator it believes.

    Attributes:
        name: in tables and pictures.
        params: of the controller, over its defaults.
        controller: registered name, with a compiled kernel.
        estimator: registered name.
    """

    name: str
    params: Mapping[str, Any] = field(default_factory=dict)
    controller: str = "la_g"
    estimator: str = "mouse_odometry"


PRINTED = Variant("LA-G as printed", {"variant": "printed"})
CLEAN = Variant("LA-G, clean gains", {"variant": "clean"})
COSINE = Variant("LA-G, cosine gains", {"variant": "cosine"})
CLIPPED = Variant("LA-G as printed, each pair clipped", {"variant": "printed", "saturation": "pairs"})
NO_BAND = Variant("LA-G as printed, no dead band", {"variant": "printed", "dead_band_rad": 0.0, "hysteresis_rad": 0.0})
RECURSION = Variant("LA-G as printed, localised as corrected", {"variant": "printed"}, estimator="mouse_corrected")
LITERAL = Variant("LA-G as printed, localised as printed", {"variant": "printed"}, estimator="mouse_printed")


@dataclass(frozen=True)
class Tracks:
    """n runs, T control ticks each.

    Attributes:
        time: (T,) [s].
        pose: (n, T, 3) true [m, m, rad].
        reference: (n, T, 3) wanted.
        error: (n, T) distance to the reference [m].
        distance: (n, T) distance to the path, wherever the reference is on it [m].
        period_s: between ticks.
    """

    time: Array
    pose: Array
    reference: Array
    error: Array
    distance: Array
    period_s: float

    def figures(self) -> dict[str, Array]:
        """Of each run (n,): integrals by ticks and by time, root mean square, largest; SI."""
        found = {}
        for name, e in (("error", self.error), ("distance", self.distance)):
            found[f"{name}_sum_m"] = e.sum(axis=1)
            found[f"{name}_square_sum_m2"] = (e**2).sum(axis=1)
            found[f"{name}_iae_m_s"] = e.sum(axis=1) * self.period_s
            found[f"{name}_rms_m"] = np.sqrt((e**2).mean(axis=1))
            found[f"{name}_max_m"] = e.max(axis=1)
        return found


def robot() -> Robot:
    """The paper's robot: four Mecanum wheels without encoders, two ball mice, four measured actuators."""
    return robots.load(ROBOT)


def batch(
    variant: Variant,
    tables: Sequence[Table],
    seed: int = 0,
    first: int = 0,
    base: Robot | None = None,
    targets: Sequence[Table] | None = None,
) -> Tracks:
    """One compiled run along each path of equal length, on the measured actuators; run k has the noise of its number.

    Args:
        variant: who drives.
        tables: (n) paths; runs last as long as the longest of them and what it takes to settle.
        seed, first: of the noise: run k is number `first` + k of the seed.
        base: another robot than the paper's.
        targets: (n) references to drive to; the paths themselves when None.
    """
    described = base or robot()
    found = build.rollout(
        described,
        None,
        variant.controller,
        estimator=variant.estimator,
        reference=list(targets or tables),
        n=len(tables),
        params=dict(variant.params),
        t=max(paths.duration(table) for table in tables),
        plant=PLANT,
        seed=seed,
        first=first,
        log_every=1,
    )
    pose = np.stack([found.column(name) for name in ("x", "y", "theta")], axis=-1)
    reference = np.stack([found.column(f"ref_{name}") for name in ("x", "y", "theta")], axis=-1)
    error = np.hypot(pose[..., 0] - reference[..., 0], pose[..., 1] - reference[..., 1])
    distance = np.stack([planning.distance_to_path(table, way) for table, way in zip(tables, pose, strict=True)])
    return Tracks(found.column("time")[0], pose, reference, error, distance, described.control_period_s)


__all__ = [
    "CLEAN",
    "CLIPPED",
    "COSINE",
    "LITERAL",
    "NO_BAND",
    "PLANT",
    "PRINTED",
    "Tracks",
    "Variant",
    "batch",
    "robot",
]
