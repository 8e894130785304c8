"""The 8 and the infinity of section V.C, and figure 17."""

from typing import Any

import numpy as np

from holodrive.experiments.claims import Claim
from holodrive.experiments.experiment import Result, Setting
from holodrive.experiments.mecanum import floor, paths, printed, tracking
from holodrive.experiments.mecanum.tracking import Tracks, Variant
from holodrive.experiments.pictures import Gallery
from holodrive.references import Table
from holodrive.reports.sections import TableSection
from holodrive.reports.tables import table

SEEDS = 8
SEED = 2
COMPARED = (
    tracking.PRINTED,
    tracking.CLEAN,
    tracking.COSINE,
    tracking.CLIPPED,
    tracking.NO_BAND,
    tracking.RECURSION,
)


def shapes() -> dict[str, Table]:
    """The two paths by the paper's names."""
    return {"8": paths.eight(), "∞": paths.infinity()}


def runs(variant: Variant, path: Table, seeds: int = SEEDS) -> Tracks:
    """Runs under as many noise seeds."""
    return tracking.batch(variant, [path] * seeds, SEED)


def complex_paths(setting: Setting) -> Result:
    """Largest distance and integrals of each variant on both paths."""
    rows: list[dict[str, Any]] = []
    for variant in COMPARED:
        for name, path in shapes().items():
            setting.tell(f"            {variant.name}: {name}")
            found = runs(variant, path).figures()
            rows.append({"tracker": variant.name, "path": name, **_medians(found)})
    note = (
        f"Lemniscate of half width {1e3 * paths.HALF_WIDTH_M:g} mm at {1e3 * paths.SPEED_M_S:g} mm/s, ramp reference, "
        f"the heading kept; medians over {SEEDS} noise seeds, and the largest of them. Size and speed are not printed. "
        "Each pair clipped costs where a command is above 37 mm/s: at the start of a step, not on a slow ramp. "
        "Without dead band the heading controller, which has priority, keeps the robot from its position for most of "
        "the time: mice of 10 um are never at exactly 0."
    )
    return Result((*_claims(rows), literal()), (TableSection("Complex paths", table(rows), note),), {"rows": rows})


def _medians(found: dict[str, Any]) -> dict[str, float]:
    return {
        "error_iae_m_s": float(np.median(found["error_iae_m_s"])),
        "error_max_m": float(np.median(found["error_max_m"])),
        "distance_iae_m_s": float(np.median(found["distance_iae_m_s"])),
        "distance_max_m": float(np.median(found["distance_max_m"])),
        "worst_distance_m": float(found["distance_max_m"].max()),
    }


def _claims(rows: list[dict[str, Any]]) -> tuple[Claim, ...]:
    def of(variant: Variant, key: str) -> dict[str, float]:
        return {row["path"]: row[key] for row in rows if row["tracker"] == variant.name}

    claims, bar = [], printed.COMPLEX_LARGEST_ERROR
    worst, theirs, ours = (
        of(tracking.PRINTED, "worst_distance_m"),
        of(tracking.PRINTED, "distance_max_m"),
        of(tracking.COSINE, "distance_max_m"),
    )
    for name in theirs:
        largest, lower = 1e3 * worst[name], 100.0 * (1.0 - ours[name] / theirs[name])
        claims += [
            Claim("section V.C", f"largest error on the {name}", f"not more than {bar:g} mm", f"{largest:.2f} mm",
                  "agrees" if largest <= bar else "differs", note="LA-G as printed; our distance to the path"),
            Claim("beyond", f"cosine gains: largest distance on the {name}, lower by", None, lower, "not printed", "%",
                  "the exact map from direction to the two diagonals instead of the linear one"),
        ]  # fmt: skip
    return tuple(claims)


def literal() -> Claim:
    """What the robot does that believes eq. 1 to 7 as they are printed."""
    way = runs(tracking.LITERAL, paths.eight(), 1).pose[0]
    length = 1e3 * float(np.hypot(*np.diff(way[:, :2], axis=0).T).sum())
    stands = length < 1.0
    note = (
        "at rest x_1 = 0, where y_m is printed as the x of before and y_m: both mice fall onto one place, the heading "
        "of eq. 7 is 0/0, and a command that is not a number stops the wheels"
    )
    return Claim("Eq. 1 to 7", "LA-G localised as printed: way on the 8", "tracks it", f"{length:.0f} mm",
                 "cannot be" if stands else "differs", note=note if stands else "")  # fmt: skip


def figure_17(setting: Setting) -> Result:
    """Both paths as they were driven."""
    pictures = []
    for name, path in shapes().items():
        reference = path.rows[:, 1:3]
        ways = [("reference", reference)]
        ways += [(v.name, runs(v, path, 1).pose[0]) for v in (tracking.PRINTED, tracking.COSINE)]
        pictures.append((name, floor.picture(name, ways)))
    note = "The printed size is unknown: the figure's text names x from -10 to -100 mm of the infinity."
    return Result(sections=(Gallery("Figure 17: complex paths", tuple(pictures), note),))


__all__ = ["complex_paths", "figure_17", "literal", "runs", "shapes"]
