"""One table of trackers: LA-G as the paper has it, and what feed-forward, an observer and prediction add."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from holodrive import build, planning
from holodrive.experiments.claims import Claim
from holodrive.experiments.experiment import Result, Setting
from holodrive.experiments.mecanum import paths, tracking
from holodrive.experiments.mecanum.complex_paths import shapes
from holodrive.experiments.mecanum.tracking import PLANT, Variant
from holodrive.geometry import wrap
from holodrive.log.run import Run
from holodrive.references import Table
from holodrive.reports.sections import ComparisonSection, Section, TableSection
from holodrive.reports.tables import table

TRACKERS = (
    tracking.PRINTED,
    tracking.COSINE,
    Variant("PID, one per axis", controller="pid"),
    Variant("feed-forward + PI per wheel", controller="ff_pi"),
    Variant("disturbance observer", controller="dob"),
    Variant("LTV-MPC", controller="mpc"),
)


def driven(variant: Variant, path: Table, seed: int) -> Run:
    """One run in the ordinary loop, with everything recorded."""
    base = build.simulate(tracking.robot(), None, plant=PLANT, seed=seed)
    return build.drive(
        base,
        variant.controller,
        trajectory=path,
        estimator=variant.estimator,
        params=dict(variant.params),
        duration_s=paths.duration(path),
        stop_on_arrival=False,
    )


def figures(run: Run, path: Table) -> dict[str, float]:
    """Errors of one run: from the moving target and from the path, SI."""
    error = np.hypot(*(run.pose - run.reference)[:, :2].T)
    distance = planning.distance_to_path(path, run.pose)
    heading = wrap(run.pose[:, 2] - run.reference[:, 2])
    period = run.robot.control_period_s
    return {
        "error_iae_m_s": float(error.sum() * period),
        "error_max_m": float(error.max()),
        "distance_iae_m_s": float(distance.sum() * period),
        "distance_max_m": float(distance.max()),
        "heading_rms_rad": float(np.sqrt(np.mean(heading**2))),
    }


def comparison(setting: Setting) -> Result:
    """All trackers on both complex paths: same plant, sensors, delays and seeds."""
    rows: list[dict[str, Any]] = []
    sections: list[Section] = []
    for name, path in shapes().items():
        first: dict[str, Run] = {}
        for variant in TRACKERS:
            setting.tell(f"            {variant.name}: {name}")
            runs = [driven(variant, path, seed) for seed in range(1, setting.seeds + 1)]
            each = [figures(run, path) for run in runs]
            middle = {key: float(np.median([row[key] for row in each])) for key in each[0]}
            rows.append({"path": name, "tracker": variant.name, **middle})
            first[variant.name] = runs[0]
        sections.append(ComparisonSection(tuple(first.values()), tuple(first), f"Trackers on the {name}"))
    _add_ratios(rows)
    note = (
        f"Medians over {setting.seeds} noise seeds; robot mecanum4_mice, plant pwm_map, the two mice as only sensors, "
        f"lemniscate of half width {1e3 * paths.HALF_WIDTH_M:g} mm at {1e3 * paths.SPEED_M_S:g} mm/s. Error: from the "
        "moving target, in which a P controller's lag along the path counts; distance: from the path alone. Ratios are "
        "those of LA-G as printed over each tracker's: how many times less."
    )
    sections.insert(0, TableSection("Trackers on the same robot", table(rows), note))
    return Result(tuple(_claims(rows)), tuple(sections), {"rows": rows})


def _add_ratios(rows: Sequence[dict[str, Any]]) -> None:
    printed = {row["path"]: dict(row) for row in rows if row["tracker"] == tracking.PRINTED.name}
    for row in rows:
        for key in ("error", "distance"):
            row[f"{key}_times_less"] = printed[row["path"]][f"{key}_iae_m_s"] / row[f"{key}_iae_m_s"]


def _claims(rows: Sequence[dict[str, Any]]) -> list[Claim]:
    claims = []
    for path in shapes():
        ours = [row for row in rows if row["path"] == path]
        for key, what in (("error", "error integral"), ("distance", "integral of the distance to the path")):
            best = max(ours, key=lambda row, name=f"{key}_times_less": row[name])  # type: ignore[misc]
            claims.append(
                Claim("beyond", f"{what} on the {path}: LA-G as printed over the best", None,
                      float(best[f"{key}_times_less"]), "not printed", "times", f"best: {best['tracker']}")
            )  # fmt: skip
    return claims


__all__ = ["TRACKERS", "comparison", "driven", "figures"]
