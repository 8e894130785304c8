"""Benchmarks T1 to T3, tables XI and XII, figure 35: a circle, a lemniscate and a step of the pose, tracked.

The paper says neither path nor gains nor start. Here all is stated: circle of r 0.5 m in 60 s from 0.28 m beside it
and turned by 1 rad; a lemniscate of half-width 0.75 m; a step of 0.5 m; `hybrid3_table_x`, wheel odometry with the
encoder's counts, both plants. Errors are true pose minus reference.
"""

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace

import numpy as np

from holodrive import build, geometry, planning, references
from holodrive.experiments.claims import Claim
from holodrive.experiments.experiment import Result, Setting
from holodrive.experiments.hybrid import printed, robots
from holodrive.experiments.hybrid.variants import Variant
from holodrive.log.run import Run
from holodrive.reports.plots import Chart, Line
from holodrive.reports.sections import ComparisonSection, Section, TableSection
from holodrive.reports.tables import table
from holodrive.types import Array, Pose

CIRCLE_M, CIRCLE_S = 0.5, 60.0
LEMNISCATE_M, LEMNISCATE_SPEED = 0.75, 0.1
STEP_M, STEP_S = 0.5, 15.0
OFFSET = (0.2, -0.2, 1.0)  # m, m, rad: start of T1 and T2 from the reference's
BAND = 0.02  # of the step: settled inside it

# Position gains of both trackers, each found with 1600 runs by benchmarks/trackers.py: on T1 for moving references, on
# T3 for the step. Those of the heading are the controllers' own.
GAINS: Mapping[str, Mapping[str, Mapping[str, float]]] = {
    "moving": {
        "pid": {"kp": 5.943, "ki": 1.14, "kd": 0.04745},
        "fuzzy_pd": {"span_m": 0.3827, "span_m_s": 7.809, "gain_m_s": 0.9324, "small_in": 0.4025, "small_out": 0.8737},
    },
    "step": {
        "pid": {"kp": 6.233, "ki": 0.001029, "kd": 0.001022},
        "fuzzy_pd": {"span_m": 0.1218, "span_m_s": 5.607, "gain_m_s": 0.618, "small_in": 0.6349, "small_out": 0.8921},
    },
}
NAVIGATORS = (
    Variant("FLC with goal blend"),
    Variant("FLC + PID", controller="fuzzy_pid"),
    Variant("FLC + MPC", controller="fuzzy_mpc"),
)


REPLAYED = ("FLC with goal blend", "FLC + PID", "PID")


def trackers(gains: str) -> dict[str, Variant]:
    """PID and fuzzy-PD with the gains for "moving" references or for the "step"."""
    return {
        "PID": Variant("PID", GAINS[gains]["pid"], controller="pid"),
        "fuzzy-PD": Variant("fuzzy-PD", GAINS[gains]["fuzzy_pd"], controller="fuzzy_pd"),
    }


@dataclass(frozen=True)
class Track:
    """A reference with a start.

    Attributes:
        title: one line.
        reference: where to be.
        start: (x, y, theta) [m, m, rad].
        duration_s: how long.
    """

    title: str
    reference: references.Table
    start: Pose
    duration_s: float


def t1_track() -> Track:
    """Circle of r 0.5 m in 60 s, start offset (0.2 m, -0.2 m, 1 rad)."""
    speed = 2.0 * math.pi * CIRCLE_M / CIRCLE_S
    reference = planning.follow(planning.circle(CIRCLE_M), speed_m_s=speed)
    return Track("T1: circle of r 0.5 m at 52 mm/s", reference, _beside(reference), reference.duration_s)


def t2_track() -> Track:
    """Lemniscate of half-width 0.75 m at 0.1 m/s, the same offset."""
    reference = planning.follow(planning.lemniscate(LEMNISCATE_M), speed_m_s=LEMNISCATE_SPEED)
    return Track("T2: lemniscate of half-width 0.75 m at 0.1 m/s", reference, _beside(reference), reference.duration_s)


def t3_track() -> Track:
    """A step of 0.5 m ahead."""
    return Track("T3: step of 0.5 m ahead", references.fixed_goal((STEP_M, 0.0, 0.0)), Pose(0.0, 0.0, 0.0), STEP_S)


def _beside(reference: references.Table) -> Pose:
    first = reference.rows[0, 1:4]
    return Pose(*(float(a + b) for a, b in zip(first, OFFSET, strict=True)))


def driven(variant: Variant, track: Track, seed: int) -> Run:
    """One run along a track in the ordinary loop."""
    base = build.simulate(robots.table_x(), None, plant=variant.plant, seed=seed, start=track.start)
    return build.drive(
        base,
        variant.controller,
        trajectory=track.reference,
        params=dict(variant.params),
        duration_s=track.duration_s,
        stop_on_arrival=False,
    )


def errors(run: Run) -> Array:
    """(T, 3) reference minus true pose, heading wrapped [m, m, rad] (eq. 31 of the paper)."""
    found = run.reference - run.pose
    found[:, 2] = geometry.wrap(found[:, 2])
    return np.asarray(found)


def mse(run: Run) -> Array:
    """(3,) mean square error of x, y and heading [m^2, m^2, rad^2]."""
    return np.asarray(np.mean(errors(run) ** 2, axis=0))


def figures(run: Run) -> dict[str, float]:
    """Errors of one run on a moving reference, with the approach and without its first 10 s."""
    e = errors(run)
    away = np.hypot(e[:, 0], e[:, 1])
    late = run.time >= 10.0
    x, y, theta = mse(run)
    return {
        "mse_x_m2": float(x),
        "mse_y_m2": float(y),
        "mse_theta_rad2": float(theta),
        "rms_error_m": float(np.sqrt(np.mean(away**2))),
        "rms_after_10s_m": float(np.sqrt(np.mean(away[late] ** 2))),
        "max_after_10s_m": float(np.max(away[late])),
    }


def step_figures(run: Run) -> dict[str, float]:
    """Rise 10 to 90 %, settling into 2 %, overshoot and what is left at the end, of x after a step."""
    share = run.pose[:, 0] / STEP_M
    passed = [run.time[np.argmax(share >= level)] if np.any(share >= level) else math.nan for level in (0.1, 0.9)]
    outside = np.flatnonzero(np.abs(share - 1.0) > BAND)
    settled = run.time[outside[-1] + 1] if len(outside) and outside[-1] + 1 < len(run.time) else math.nan
    return {
        "rise_s": float(passed[1] - passed[0]),
        "settling_s": float(settled),
        "overshoot_pct": float(max(0.0, 100.0 * (np.max(share) - 1.0))),
        "left_m": float(abs(np.mean(share[run.time >= run.time[-1] - 1.0]) - 1.0) * STEP_M),
    }


def repeated(
    variant: Variant, track: Track, seeds: int, measure: Callable[[Run], dict[str, float]] = figures
) -> tuple[dict[str, list[float]], Run]:
    """Each figure under noise seeds 1, 2 ..., and the first run."""
    runs = [driven(variant, track, seed) for seed in range(1, seeds + 1)]
    rows = [measure(run) for run in runs]
    return {name: [row[name] for row in rows] for name in rows[0]}, runs[0]


def medians(
    variant: Variant, track: Track, seeds: int, measure: Callable[[Run], dict[str, float]] = figures
) -> dict[str, float]:
    """Median of each figure over noise seeds 1, 2 ..."""
    return {name: float(np.median(values)) for name, values in repeated(variant, track, seeds, measure)[0].items()}


def t1(setting: Setting) -> Result:
    """Every tracker on the circle, on both plants."""
    return _moving(t1_track(), setting)


def t2(setting: Setting) -> Result:
    """Every tracker on the lemniscate, on both plants."""
    return _moving(t2_track(), setting)


def _moving(track: Track, setting: Setting) -> Result:
    rows, first = [], {}
    for variant in (
        replace(v, plant=plant)
        for plant in ("first_order", "slip")
        for v in (*NAVIGATORS, *trackers("moving").values())
    ):
        setting.tell(f"            {variant.name}, {variant.plant}")
        found, run = repeated(variant, track, setting.seeds)
        row = {name: float(np.median(values)) for name, values in found.items()}
        rms = [1e3 * value for value in found["rms_error_m"]]
        between = f"{min(rms):.1f} to {max(rms):.1f}"
        rows.append({"controller": variant.name, "plant": variant.plant, **row, "rms_range_mm": between})
        if variant.plant == "first_order":
            first[variant.name] = run
    note = (
        f"Medians over {setting.seeds} noise seeds. Start ({OFFSET[0]:g} m, {OFFSET[1]:g} m, {OFFSET[2]:g} rad) from "
        "the reference's. Sensors: encoders of 400 counts, RPLIDAR A1 with 1 % noise; position gains of PID and "
        f"fuzzy-PD {dict(GAINS['moving']['pid'])} and {dict(GAINS['moving']['fuzzy_pd'])}, all else as by default."
    )
    sections: tuple[Section, ...] = (
        TableSection(track.title, table(rows), note),
        ComparisonSection(tuple(first[name] for name in REPLAYED), REPLAYED, f"{track.title}, paths"),
    )
    return Result(sections=sections, data={"rows": rows})


def t3(setting: Setting) -> Result:
    """Every tracker on the step, first_order."""
    rows = []
    for variant in (*NAVIGATORS, *trackers("step").values()):
        row = medians(variant, t3_track(), setting.seeds, step_figures)
        rows.append({"controller": variant.name, **row})
    note = f"Medians over {setting.seeds} noise seeds; rise from 10 to 90 %, settling into 2 %."
    return Result(sections=(TableSection(t3_track().title, table(rows), note),), data={"rows": rows})


def table_xi(setting: Setting) -> Result:
    """Mean square errors of PID and fuzzy tracker: printed on an unknown path, ours on T1."""
    claims = []
    for name, label in (("PID", "PID"), ("FLC", "fuzzy-PD")):
        row = medians(trackers("moving")[label], t1_track(), setting.seeds)
        for axis, unit, ours, said in zip(
            ("x", "y", "theta"), ("m^2", "m^2", "rad^2"), list(row.values())[:3], printed.MSE[name], strict=True
        ):
            note = "" if axis != "x" else "trajectory, gains, duration and start are not printed; ours is T1"
            claims.append(Claim("Table XI", f"{name}: MSE {axis}", said, ours, "not comparable", unit, note))
    claims += [
        Claim("Table XI", "unit of the MSE", "m, rad", "m^2, rad^2", "contradicts itself"),
        Claim("text", "position MSE", f"below {printed.MSE_BELOW} m",
              f"printed up to {max(*printed.MSE['PID'][:2], *printed.MSE['FLC'][:2]):.4f}", "contradicts itself",
              note="Table XI has three of four position errors above it"),
        Claim("Table VII, VIII", "what 'FLC' tracks with", "—", "a second fuzzy controller", "not comparable",
              note="the 27 rules have no goal input; the tracker of Tables XI and XII must be another, not described"),
    ]  # fmt: skip
    return Result(tuple(claims))


def table_xii(setting: Setting) -> Result:
    """Rise, settling, error and overshoot: printed for an unknown signal, ours for T3."""
    claims = []
    for name, label in (("PID", "PID"), ("FLC", "fuzzy-PD")):
        row = medians(trackers("step")[label], t3_track(), setting.seeds, step_figures)
        ours = (row["rise_s"], row["settling_s"], row["left_m"], row["overshoot_pct"])
        words = (("rise time", "s"), ("settling time", "s"), ("steady state error", ""), ("overshoot", ""))
        for (what, unit), said, found in zip(words, printed.STEP[name], ours, strict=True):
            claims.append(Claim("Table XII", f"{name}: {what}", said, found, "not comparable", unit))
    speed = float(printed.MOTOR_RPM * math.pi / 30.0 / np.max(np.abs(_jacobian()[:, 0])))
    least = 0.8 * STEP_M / speed
    claims += [
        Claim("Table XII", "rise time of a 0.5 m step at 22 rpm", printed.STEP["FLC"][0], least, "cannot be", "s",
              f"10 to 90 % at {100.0 * speed:.1f} cm/s; the printed time allows a step of "
              f"{100.0 * printed.STEP['FLC'][0] * speed / 0.8:.0f} cm"),
        Claim("Table XII", "steady state error", "abstract: improved accuracy", "PID 0.01, FLC 0.02",
              "contradicts itself"),
        Claim("Table XII", "signal, amplitude, units of error and overshoot", "—", "—", "not comparable",
              note="none is printed; ours are metres left after 15 s and percent"),
    ]  # fmt: skip
    return Result(tuple(claims))


def figure_35(setting: Setting) -> Result:
    """Trajectories of the two trackers."""
    track = t1_track()
    runs = {label: driven(trackers("moving")[label], track, 1) for label in ("PID", "fuzzy-PD")}
    lines = tuple(
        Line(name, run.time, 1e3 * np.hypot(*errors(run)[:, :2].T), i) for i, (name, run) in enumerate(runs.items())
    )
    chart = Chart("Distance from the reference", "mm", lines, low=0.0)
    from holodrive.experiments.pictures import Gallery

    sections: tuple[Section, ...] = (
        ComparisonSection(tuple(runs.values()), tuple(runs), "Figure 35: PID and fuzzy tracker on T1"),
        Gallery("Figure 35: errors", (("distance from the reference", chart.svg()),)),
    )
    note = "the figure's path has no numbers; ours is T1"
    return Result((Claim("Fig. 35", "trajectory comparison", "—", "drawn", "no number", note=note),), sections)


def _jacobian() -> Array:
    from holodrive.kinematics import Chassis

    return Chassis.of(robots.printed()).jacobian
