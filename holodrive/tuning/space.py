"""Which fields of a controller may change, and how far: parameters as points of a unit cube."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields
from importlib import import_module
from typing import Any

import numpy as np

from holodrive import control
from holodrive.errors import InputError, UnknownName
from holodrive.types import Array


@dataclass(frozen=True)
class Range:
    """One field's bounds, in the field's own unit.

    Attributes:
        field: of the controller.
        low, high: least and greatest value.
        log: equal steps are equal ratios; for gains that may be off by a factor.
    """

    field: str
    low: float
    high: float
    log: bool = False

    def __post_init__(self) -> None:
        if not (math.isfinite(self.low) and math.isfinite(self.high) and self.low < self.high):
            raise InputError(f"{self.field} is to lie in {self.low:g}..{self.high:g}; give low < high, both finite")
        if self.log and not self.low > 0.0:
            raise InputError(f"{self.field} from {self.low:g} on cannot have a logarithmic scale; give low > 0")

    def unit(self, value: float) -> float:
        """0 at the low end, 1 at the high end; what lies outside is taken to the nearer end."""
        value = min(max(value, self.low), self.high)
        if self.log:
            return math.log(value / self.low) / math.log(self.high / self.low)
        return (value - self.low) / (self.high - self.low)

    def value(self, unit: float) -> float:
        """The value of a place in 0..1; never outside the bounds."""
        ratio = self.high / self.low if self.log else 1.0
        found = self.low * ratio**unit if self.log else self.low + unit * (self.high - self.low)
        return float(min(max(found, self.low), self.high))


@dataclass(frozen=True)
class Space:
    """The fields that may change, each with its range."""

    ranges: tuple[Range, ...]

    def __post_init__(self) -> None:
        names = [one.field for one in self.ranges]
        if not names:
            raise InputError("tuning takes 1 or more fields")
        if len(set(names)) < len(names):
            raise InputError(f"a field is tuned once; found {', '.join(names)}")

    @property
    def names(self) -> tuple[str, ...]:
        """Of the fields."""
        return tuple(one.field for one in self.ranges)

    def unit(self, values: Mapping[str, float]) -> Array:
        """(p,) place in the unit cube."""
        return np.array([one.unit(values[one.field]) for one in self.ranges])

    def values(self, unit: Array) -> dict[str, float]:
        """Field -> value of a place in the unit cube (p,)."""
        return {one.field: one.value(float(place)) for one, place in zip(self.ranges, unit, strict=True)}

    def start(self, controller: str, params: Mapping[str, Any]) -> dict[str, float]:
        """Field -> value that the controller has with `params`; the middle where it leaves a field open.

        Raises:
            InputError: a field that is no number.
        """
        plug: Any = control.compiled(controller, dict(params))
        if hasattr(plug, "resolved"):  # fields that are None until the plug asks its profile
            plug = plug.resolved()
        return {one.field: _number(one, getattr(plug, one.field)) for one in self.ranges}


def space(controller: str, names: Sequence[str] = (), ranges: Sequence[Range] = ()) -> Space:
    """The space of a controller's fields.

    Args:
        controller: registered name; its module says in `BOUNDS` how far each field may go, as (low, high) or
            (low, high, "log").
        names: of the fields to tune with those bounds; all of `BOUNDS` when neither names nor ranges are given.
        ranges: of fields with bounds of your own.

    Raises:
        UnknownName: no such controller or field.
        InputError: a field without bounds.
    """
    cls = control.plug_class(controller)
    known = [field.name for field in fields(cls)]
    for name in (*names, *(one.field for one in ranges)):
        if name not in known:
            raise UnknownName(f"parameter of {controller}", name, known)
    bounds: Mapping[str, Any] = getattr(import_module(cls.__module__), "BOUNDS", {})
    if not bounds and not ranges and not names:
        raise InputError(
            f"controller {controller!r} says no bounds of its own (BOUNDS in {cls.__module__}); "
            "give some: --field NAME=LOW:HIGH"
        )
    for name in names:
        if name not in bounds:
            raise InputError(f"{controller} says no bounds for {name!r}; give them: --field {name}=LOW:HIGH")
    chosen = names or (() if ranges else tuple(bounds))
    own = {one.field for one in ranges}
    return Space((*(_range(name, bounds[name]) for name in chosen if name not in own), *ranges))


def parse_range(text: str) -> Range:
    """`name=low:high` or `name=low:high:log`.

    Raises:
        InputError: anything else.
    """
    name, _, span = text.partition("=")
    parts = [part.strip() for part in span.split(":")]
    try:
        low, high = (float(part) for part in parts[:2])
    except ValueError:
        low = high = math.nan
    if not name.strip() or len(parts) not in (2, 3) or math.isnan(low + high) or parts[2:] not in ([], ["log"]):
        raise InputError(f"a field's range is NAME=LOW:HIGH or NAME=LOW:HIGH:log, such as kp=0.2:5; found {text!r}")
    return Range(name.strip(), low, high, bool(parts[2:]))


def _range(name: str, bounds: Sequence[Any]) -> Range:
    return Range(name, float(bounds[0]), float(bounds[1]), "log" in bounds[2:])


def _number(one: Range, value: Any) -> float:
    if value is None:
        return one.value(0.5)
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise InputError(f"{one.field} is {value!r}; only numbers can be tuned")
    return float(value)
