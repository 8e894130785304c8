"""The controllers that are set side by side, and how each is run."""

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from holodrive import build, tuning, worlds
from holodrive.experiments.experiment import Setting
from holodrive.experiments.hybrid import robots
from holodrive.log.run import Run
from holodrive.robots.spec import Robot
from holodrive.tuning import Sweep
from holodrive.types import Array
from holodrive.worlds.spec import World

RANDOM_S = 90.0  # s for a random world with the motors that Table X needs
# a goal is sought, else they would reach none; nothing else is added
AS_PRINTED = {"mode": "differential", "barrier": False, "patience_s": math.inf, "inertia_s": 0.0}


@dataclass(frozen=True)
class Variant:
    """A controller with its parameters.

    Attributes:
        name: in tables and pictures.
        params: of the controller.
        controller: registered name.
        plant: physics.
        slow: with the 22 rpm motors that the paper prints instead of those that its results need.
        plan: planner whose path is followed, "" for none.
    """

    name: str
    params: Mapping[str, Any] = field(default_factory=dict)
    controller: str = "fuzzy"
    plant: build.Plant = "first_order"
    slow: bool = False
    plan: str = ""

    @property
    def robot(self) -> Robot:
        """Which base drives."""
        return robots.printed() if self.slow else robots.table_x()


REPAIRED = Variant("repaired")
TUNED = Variant("tuned", {"profile": "tuned"})
DIFFERENTIAL = Variant("repaired, differential", {"mode": "differential"})
PRINTED_VIII = Variant("Table VIII as printed", {"profile": "paper_viii", **AS_PRINTED})
PRINTED_VII = Variant("Table VII as printed", {"profile": "paper_vii", **AS_PRINTED})
SWAPPED = Variant(
    "Table VIII, L and R swapped by fuzzylab", {"profile": "paper_viii", "fuzzylab_compat": True, **AS_PRINTED}
)
WITHOUT_RULES = Variant("goal and barrier, rules never asked", {"blocked_m": 0.0, "free_m": 1e-6})

AVOIDERS = (REPAIRED, TUNED, DIFFERENTIAL, PRINTED_VIII, PRINTED_VII, SWAPPED)


def drive(variant: Variant, world: World, seed: int = 1, duration_s: float = 120.0, **reference: Any) -> Run:
    """One run in the ordinary loop, with everything recorded."""
    base = build.simulate(variant.robot, world, plant=variant.plant, seed=seed)
    return build.drive(base, variant.controller, params=dict(variant.params), duration_s=duration_s, **reference)


def swept(variant: Variant, setting: Setting, crossers: int = 0) -> Sweep:
    """One compiled run in each random world: world number k has the noise of run k, wherever it is computed."""
    job = tuning.job(
        variant.robot,
        tuning.Places(generator="course", crossers=crossers),
        variant.controller,
        params=dict(variant.params),
        first=setting.first_seed,
        count=setting.worlds,
        t=RANDOM_S,
        plant=variant.plant,
    )
    return tuning.sweep(job, setting.cluster or setting.workers)


def path(variant: Variant, number: int, crossers: int = 0) -> Array:
    """(T, 2) true positions in random world `number`, the same run as in `swept` [m]."""
    world = worlds.course(number, crossers)
    params = {"arrive_m": world.goal.tolerance_m, "arrive_rad": math.pi} if world.goal else {}
    again = build.rollout(
        variant.robot,
        [world],
        variant.controller,
        params={**params, **variant.params},
        t=RANDOM_S,
        first=number,
        plant=variant.plant,
        stop_on_arrival=True,
        log_every=10,
    )
    return np.stack([again.column("x")[0], again.column("y")[0]], axis=1)
