"""Tables I and II computed again from their own runs, and what the units of their numbers can be."""

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from holodrive.experiments.claims import Claim, Verdict
from holodrive.experiments.experiment import Result, Setting
from holodrive.experiments.mecanum import printed, statistics
from holodrive.experiments.mecanum.printed import Row
from holodrive.reports.plots import Chart, Line
from holodrive.reports.sections import ChartSection, TableSection
from holodrive.reports.tables import Table
from holodrive.types import Array

_HALVES = (("0° to 84.4°", slice(0, 16)), ("180° to 264.4°", slice(16, 32)))
_RUNS = ("run 1", "run 2", "run 3", "run 4")


@dataclass(frozen=True)
class Printed:
    """One of the two tables.

    Attributes:
        name: "Table I" or "Table II".
        quantity, unit: of the runs.
        rows: as printed.
        population: whether its SD is that of the population.
    """

    name: str
    quantity: str
    unit: str
    rows: tuple[Row, ...]
    population: bool

    @property
    def columns(self) -> statistics.Columns:
        """Statistics of its rows."""
        return statistics.Columns.of(self.rows)


IAE = Printed("Table I", "IAE", "mm", printed.TABLE_I, population=True)
ISE = Printed("Table II", "ISE", "mm²", printed.TABLE_II, population=False)


def table_i(setting: Setting) -> Result:
    """Claims about Table I."""
    claims = (*_conventions(IAE), *_misprint(), _above_half(IAE, printed.ABOVE_HALF_IAE), *_copies(), *_growth(IAE))
    return Result(claims, (_recomputed(IAE), _over_angle(IAE)), _data(IAE))


def table_ii(setting: Setting) -> Result:
    """Claims about Table II."""
    claims = (
        Claim("Table II", "header", "Integral of Squared Error, IAE (mm²)", "ISE", "contradicts itself",
              note="the text calls it ISE, and its numbers are not those of Table I"),
        *_conventions(ISE),
        _above_half(ISE, printed.ABOVE_HALF_ISE),
        *_growth(ISE),
    )  # fmt: skip
    return Result(claims, (_recomputed(ISE), _over_angle(ISE)), _data(ISE))


def units(setting: Setting) -> Result:
    """What the numbers can be: sums over samples, or integrals over time; of which error."""
    absolute, squared = statistics.values(IAE.rows), statistics.values(ISE.rows)
    least, weighted = statistics.least_samples(absolute, squared), statistics.weighted_error(absolute, squared)
    period = 1e-3 * printed.CONTROL_PERIOD_MS
    reach = float(least.max()) * printed.SPEED_LIMIT * 1e-3
    claims = (
        Claim("Tables I, II", "unit of an integral over time", "mm, mm²", "mm·s, mm²·s", "contradicts itself",
              note="the printed units are those of sums over samples; the names are those of integrals"),
        Claim("Tables I, II", "samples a run needs at least, median and most", None, _pair(least, 0), "not printed",
              note="N ≥ (Σ|e|)² / Σe² (Cauchy and Schwarz), each run of Table I with the same run of Table II"),
        Claim("Tables I, II", "as sums: a run lasts at least, median and most", None, _pair(period * least, 1, "s"),
              "not printed", note=f"at {printed.CONTROL_PERIOD_MS:g} ms a sample; quite possible"),
        Claim("Tables I, II", "as integrals: a run lasts at least, median and most", None, _pair(least, 0, "s"),
              "not printed", note="the same bound read in seconds: minutes for one straight path, in which "
              f"{printed.SPEED_LIMIT:g} mm/s would be {reach:.0f} m; unlikely, not impossible: the length of a path is "
              "not printed"),
        Claim("Tables I, II", "sums or integrals", "not said", "cannot be decided", "not comparable",
              note="here Σ|e|, ∫|e|dt, RMS and largest error are all given, each with its unit"),
        Claim("Tables I, II", "ISE / IAE, median and most", None, _pair(weighted, 2, "mm"), "not printed",
              note="the mean error weighted by itself, the same for sums and integrals; a run's largest error is at "
              "least that"),
        Claim("Tables I, II", "as sums: largest error, at most", None, float(np.sqrt(squared.max())), "not printed",
              "mm", "no sample can be larger than the root of the sum of squares"),
        _which_error(float(squared.min())),
        *_overall(IAE, period),
        *_overall(ISE, period),
    )  # fmt: skip
    data = {"least_samples": least.tolist(), "weighted_error_mm": weighted.tolist()}
    return Result(claims, data=data)


def _overall(table: Printed, period_s: float) -> list[Claim]:
    mean = float(table.columns.mean.mean())
    note = f"as a sum at {printed.CONTROL_PERIOD_MS:g} ms, {period_s * mean:.3g} {table.unit}·s as an integral"
    return [Claim(table.name, "mean of all runs", None, mean, "not printed", table.unit, note)]


def _which_error(least: float) -> Claim:
    """A run to a target at distance d begins with an error of d, which falls no faster than the robot moves."""
    fastest = math.sqrt(2.0) * printed.SPEED_LIMIT  # both pairs at their limit
    as_sum, as_integral = math.sqrt(least), (3.0 * fastest * least) ** (1.0 / 3.0)
    return Claim(
        "Tables I, II", "which error", "not said", "not that to the target", "not comparable",
        note=f"it cannot be the distance to a standing target: with a least ISE of {least:.4g} no path would be longer "
        f"than {as_sum:.1f} mm (sums) or {as_integral:.1f} mm (integrals, at {fastest:.0f} mm/s)",
    )  # fmt: skip


def _conventions(table: Printed) -> list[Claim]:
    """Which of the two standard deviations is printed, and which one COV is made of."""
    columns, count = table.columns, len(table.rows)
    said = "not said"
    deviation = columns.population if table.population else columns.sample
    fit_sd = int(statistics.fits(statistics.deviations(table.rows), deviation).sum())
    fit_cov = int(statistics.fits(statistics.variations(table.rows), columns.sample / columns.mean).sum())
    itself: Verdict = "contradicts itself" if table.population else "agrees"
    kind = "n, of the population" if table.population else "n − 1, of a sample"
    note = "so COV is not SD / mean in any row" if table.population else "so COV is SD / mean"
    return [
        Claim(table.name, f"SD with {kind}", said, f"{fit_sd} of {count} rows", "not printed"),
        Claim(table.name, "COV with n − 1, of a sample", said, f"{fit_cov} of {count} rows", itself, note=note),
    ]


def _misprint() -> list[Claim]:
    """The one row of Table I whose SD and COV fit its runs neither way."""
    columns = IAE.columns
    off = [i for i in range(len(IAE.rows)) if not _row_fits(IAE, i)]
    claims = []
    for i in off:
        row = IAE.rows[i]
        tried, found = statistics.misprints(row)
        others = "no other" if len(found) == 1 else f"{len(found)}"
        note = "; ".join(f"with {value:.4f} in experiment {k} SD and COV are as printed" for k, value in found)
        note += f"; of {tried} ways to change one digit of the row {others} does so"
        where = f"Table I, {row.angle_deg:g}°"
        claims += [
            Claim(where, "SD", row.deviation, float(columns.population[i]), "contradicts itself", "mm", note),
            Claim(where, "COV", row.variation, float(columns.sample[i] / columns.mean[i]), "contradicts itself"),
        ]
    return claims


def _above_half(table: Printed, angles: tuple[float, ...]) -> Claim:
    """'All COVs are below 0.50 except ...'."""
    by_runs = table.columns.sample / table.columns.mean
    printed_cov = statistics.variations(table.rows)
    listed = [
        ", ".join(f"{angle:g}°" for angle, above in zip(table.columns.angle_deg, cov > 0.5, strict=True) if above)
        for cov in (printed_cov, by_runs)
    ]
    said = ", ".join(f"{angle:g}°" for angle in angles)
    verdict: Verdict = "agrees" if said == listed[1] else "contradicts itself"
    note = "" if verdict == "agrees" else f"by the printed COV {listed[0]}, and so with the misprint above put right"
    return Claim(f"text, {table.name}", "angles with a COV above 0.5", said, listed[1] or "none", verdict, note=note)


def _copies() -> list[Claim]:
    """Rows and runs that hold the same numbers."""
    absolute, squared = statistics.values(IAE.rows), statistics.values(ISE.rows)
    claims = []
    least = statistics.least_samples(absolute, squared).min(axis=1)
    found = statistics.twins(IAE.rows)
    for a, b in sorted({(t.first[0], t.second[0]) for t in found}):
        pairs = [t for t in found if (t.first[0], t.second[0]) == (a, b)]
        one, other = IAE.rows[a], IAE.rows[b]
        if a == b:
            claims.append(_same_run(a, pairs[0]))
            continue
        strange, usual = (a, b) if least[a] < least[b] else (b, a)
        others = np.delete(least, strange).min()
        claims.append(
            Claim("Table I", f"runs of {one.angle_deg:g}° that stand again at {other.angle_deg:g}°", None,
                  f"{len(pairs)} of 4, in another order", "cannot be",
                  note=f"equal to {1e-4:g} mm; the rows of Table II differ. {IAE.rows[strange].angle_deg:g}° holds the "
                  f"copy: its two rows fit {least[strange]:.0f} samples, those of {IAE.rows[usual].angle_deg:g}° need "
                  f"{least[usual]:.0f} and all others {others:.0f} or more")
        )  # fmt: skip
    return claims


def _same_run(row: int, twin: statistics.Twin) -> Claim:
    first, second = twin.first[1], twin.second[1]
    same = ISE.rows[row].runs[first - 1] == ISE.rows[row].runs[second - 1]
    return Claim(
        "Tables I, II" if same else "Table I", f"{IAE.rows[row].angle_deg:g}°: experiments {first} and {second}",
        None, "the same number" + (" in both tables" if same else ""), "cannot be",
        note="one of the four runs is missing; SD and COV count it twice",
    )  # fmt: skip


def _growth(table: Printed) -> list[Claim]:
    """'Significantly deteriorates' towards 90 and 270 degrees."""
    columns = table.columns
    worse = np.zeros(len(columns.mean), dtype=bool)
    for low, high in printed.WORSE_FROM_TO:
        worse |= (columns.angle_deg >= low) & (columns.angle_deg <= high)
    inside, outside = columns.mean[worse], columns.mean[~worse]
    factor = float(inside.mean() / outside.mean())
    least, most = columns.angle_deg[worse][inside.argmin()], columns.angle_deg[~worse][outside.argmax()]
    note = (
        f"mean {inside.mean():.0f} {table.unit} where the text says worse, {outside.mean():.0f} elsewhere; the two "
        f"overlap: {least:g}° with {inside.min():.0f} counts as worse, {most:g}° with {outside.max():.0f} does not"
    )
    claims = [
        Claim(f"text, {table.name}", "error grows towards 90° and 270°", "significantly", f"× {factor:.1f}",
              "agrees" if factor > 1.0 else "contradicts itself", note=note)
    ]  # fmt: skip
    if table is IAE:
        ends = columns.mean[[0, 15, 16, 31]]
        claims.append(
            Claim("Table I", "mean at 0°, 84.4°, 180° and 264.4°", None, ", ".join(f"{v:.0f}" for v in ends) + " mm",
                  "not printed", note="the text names a cause, motors that cannot keep a small difference of speeds, "
                  "and does not measure it. The simulated plant has the four printed curves, whole PWM counts, dead "
                  "times and lag; nothing else in it knows the direction of travel")
        )  # fmt: skip
    return claims


def _row_fits(table: Printed, i: int) -> bool:
    columns, row = table.columns, table.rows[i]
    deviation = columns.population[i] if table.population else columns.sample[i]
    off = (row.deviation - deviation, row.variation - columns.sample[i] / columns.mean[i])
    return bool(max(map(abs, off)) <= statistics.DIGIT)


def _recomputed(table: Printed) -> TableSection:
    columns = table.columns
    headers = ("angle", "run 1", "run 2", "run 3", "run 4", "mean", "SD printed", "SD, n", "SD, n − 1", "COV printed",
               "COV, n", "COV, n − 1")  # fmt: skip
    cells, data = [], []
    for i, row in enumerate(table.rows):
        mean, pop, sample = (float(c[i]) for c in (columns.mean, columns.population, columns.sample))
        numbers = (row.deviation, pop, sample, row.variation, pop / mean, sample / mean)
        good = _row_fits(table, i)
        texts = (*(f"{value:.4f}" for value in row.runs), f"{mean:.1f}", *(f"{value:.4f}" for value in numbers))
        cells.append((f"{row.angle_deg:g}°{'' if good else ' ≠'}", *texts))
        data.append(_plain_row(row, mean, pop, sample, good))
    numeric = (False, *(True for _ in headers[1:]))
    kind = "population's (n)" if table.population else "sample's (n − 1)"
    note = (
        f"Runs, mean and SD in {table.unit}. ≠ marks a row whose SD is not the {kind} or whose COV is not the sample's "
        "over the mean, to one unit of the last digit."
    )
    title = f"{table.name}, computed again"
    return TableSection(title, Table("", headers, tuple(cells), tuple(data), numeric), note)


def _plain_row(row: Row, mean: float, pop: float, sample: float, good: bool) -> dict[str, Any]:
    return {
        "angle_deg": row.angle_deg, "runs": list(row.runs), "mean": mean,
        "sd_printed": row.deviation, "sd_population": pop, "sd_sample": sample,
        "cov_printed": row.variation, "cov_population": pop / mean, "cov_sample": sample / mean, "fits": good,
    }  # fmt: skip


def _over_angle(table: Printed) -> ChartSection:
    runs, columns = statistics.values(table.rows), table.columns
    most = float(runs.max())
    charts = tuple(
        Chart(
            f"{table.quantity}, {name}", table.unit,
            (Line("mean", columns.angle_deg[half], columns.mean[half], 0),
             *(Line(label, columns.angle_deg[half], runs[half, k], k + 1, dash="2 3")
               for k, label in enumerate(_RUNS))),
            x_name="angle of the path", x_unit="°", low=0.0, high=most, height=300.0,
        )
        for name, half in _HALVES
    )  # fmt: skip
    return ChartSection(f"{table.name} over the angle", charts, "As printed, misprint and copies included.")


def _data(table: Printed) -> dict[str, Any]:
    return {"rows": list(_recomputed(table).table.data)}


def _pair(values: Array, digits: int, unit: str = "") -> str:
    return f"{np.median(values):.{digits}f}, {values.max():.{digits}f} {unit}".strip()
