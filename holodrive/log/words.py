"""What the numbers of a run are called for people: label, unit, digits, and which way is better."""

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Literal

from holodrive.svg import number

Better = Literal["low", "high", ""]


@dataclass(frozen=True)
class Words:
    """How one metric is told.

    Attributes:
        label: words.
        unit: that is shown; "" for a plain count, "yes/no" for a truth value.
        factor: shown = factor * value.
        better: which way is better, "" when neither is.
        help: one sentence that says what exactly is meant.
        infinite: what an infinite value means, in words.
    """

    label: str
    unit: str = ""
    factor: float = 1.0
    better: Better = ""
    help: str = ""
    infinite: str = "∞"


_DEG = math.degrees(1.0)

METRICS: dict[str, Words] = {
    "arrived": Words("arrived", "yes/no", better="high", help="whether the goal was reached within its tolerance"),
    "time_s": Words("time", "s", better="low", help="from start to arrival or to the end of the run"),
    "path_length_m": Words("path length", "m", better="low", help="of the true path"),
    "turns": Words("turns", better="low", help="changes of driving direction"),
    "min_clearance_m": Words(
        "nearest obstacle", "m", better="high", help="least gap from the footprint to anything", infinite="none"
    ),
    "collisions": Words("collisions", better="low", help="times that the robot touched something"),
    "no_rule": Words("no rule fired", better="low", help="times that a fuzzy controller had no rule to fire"),
    "moved_collisions": Words("ran into", better="low", help="collisions in which the robot itself was moving"),
    "iae_m_s": Words("error integral (IAE)", "m·s", better="low", help="integral of the absolute position error"),
    "ise_m2_s": Words("squared error (ISE)", "m²·s", better="low", help="integral of the squared position error"),
    "rms_error_m": Words("RMS error", "m", better="low", help="root mean square distance from the reference"),
    "max_error_m": Words("largest error", "m", better="low", help="largest distance from the reference"),
    "final_error_m": Words("end error", "m", better="low", help="distance from the reference at the end"),
    "final_heading_error_rad": Words("end heading error", "°", _DEG, "low", "heading error at the end"),
    "error_iae_m_s": Words("error integral", "m·s", better="low", help="of the distance to the moving reference"),
    "error_max_m": Words("largest error", "m", better="low", help="distance to the moving reference"),
    "distance_iae_m_s": Words("distance integral", "m·s", better="low", help="of the distance to the path"),
    "distance_rms_m": Words("RMS distance", "m", better="low", help="root mean square distance to the path"),
    "distance_max_m": Words("largest distance", "m", better="low", help="to the path"),
    "end_error_m": Words("end error", "m", better="low", help="distance from the truth at the end"),
    "rmse_m": Words("RMS error", "m", better="low", help="root mean square distance from the truth"),
    "heading_error_rad": Words("end heading error", "°", _DEG, "low", "heading against the truth at the end"),
    "ended_at_s": Words("ended at", "s", help="time of the last tick"),
    "energy_j": Words("energy", "J", better="low", help="electrical energy taken from the battery"),
    "saturated_share": Words("saturated", "%", 100.0, "low", "share of the time with a wheel at its limit"),
    "mean_speed_m_s": Words("mean speed", "m/s", help="path length over time"),
}

# units that read better for small values: unit, factor, used below this value
_SMALLER = {
    "m": ("mm", 1e3, 1.0),
    "m/s": ("mm/s", 1e3, 0.1),
    "m·s": ("mm·s", 1e3, 0.1),
    "m²·s": ("mm²·s", 1e6, 1e-3),
}

# the longest suffix wins; each gives the unit shown and the factor to it
_SUFFIXES = {
    "_m2_s": ("m²·s", 1.0),
    "_rad_s": ("rad/s", 1.0),
    "_m_s": ("m/s", 1.0),
    "_rad": ("°", _DEG),
    "_deg": ("°", 1.0),
    "_share": ("%", 100.0),
    "_pct": ("%", 1.0),
    "_mm2": ("mm²", 1.0),
    "_mm": ("mm", 1.0),
    "_m": ("m", 1.0),
    "_s": ("s", 1.0),
    "_j": ("J", 1.0),
    "_hz": ("Hz", 1.0),
    "_v": ("V", 1.0),
    "_a": ("A", 1.0),
}


def words(name: str) -> Words:
    """The words of a metric; for one that is not known, read from its name and the unit at its end."""
    if name in METRICS:
        return METRICS[name]
    for suffix, (unit, factor) in _SUFFIXES.items():
        if name.lower().endswith(suffix):
            return Words(name[: -len(suffix)].replace("_", " "), unit, factor)
    return Words(name.replace("_", " "))


def told(name: str, values: Iterable[float]) -> tuple[str, list[str]]:
    """Unit and texts of one metric over several runs: one unit and the same decimals for all of them."""
    how = words(name)
    values = [float(value) for value in values]
    if how.unit == "yes/no":
        return "", ["—" if math.isnan(v) else "yes" if v else "no" for v in values]
    shown = [how.factor * v for v in values]
    unit = how.unit
    largest = max((abs(v) for v in shown if math.isfinite(v)), default=0.0)
    small, factor, below = _SMALLER.get(unit, (unit, 1.0, 0.0))
    if 0.0 < largest < below:
        unit, shown, largest = small, [factor * v for v in shown], factor * largest
    decimals = 0 if not unit and all(v.is_integer() for v in shown if math.isfinite(v)) else _decimals(largest, unit)
    return unit, [how.infinite if math.isinf(v) else number(v, decimals) for v in shown]


def with_unit(name: str, value: float) -> str:
    """One metric as text with its unit."""
    unit, (text,) = told(name, [value])
    return joined(text, unit)


def joined(text: str, unit: str) -> str:
    """Number and unit, with a no-break space where there is a space in print."""
    return text if not unit or not text[-1].isdigit() else f"{text}{unit}" if unit == "°" else f"{text}\u00a0{unit}"


def ordered(metrics: Mapping[str, float]) -> list[str]:
    """Names of metrics, the known ones first and in their usual order."""
    known = [name for name in METRICS if name in metrics]
    return known + [name for name in metrics if name not in METRICS]


def _decimals(largest: float, unit: str) -> int:
    """Four significant digits, three for angles and shares, tenths of millimetres; never more than six decimals."""
    if largest <= 0.0:
        return 0
    digits = 3 if unit in _THREE_DIGITS else 4
    least = 1 if unit.startswith("mm") or (unit in ("°", "%") and largest < 100.0) else 0
    return min(3 if unit in _THREE_DIGITS else 5, max(least, digits - 1 - math.floor(math.log10(largest))))


_THREE_DIGITS = ("°", "%", "mm", "mm/s", "mm·s", "mm²·s")
