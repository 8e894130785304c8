"""The duty curves of a robot file: `[linearizer]` and `[pwm_map]`, which name each wheel once, in groups."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TypeVar

from holodrive.files.edge import check, known_keys
from holodrive.files.scan import Path
from holodrive.files.source import Source, Table, meant, section
from holodrive.files.units import QuantityError, parse, shown
from holodrive.robots import curves
from holodrive.robots.form import CurveForm, CurveGroupForm, LinearizerForm, PwmMapForm
from holodrive.robots.naming import check_name
from holodrive.robots.spec import DutyCurve, DutyMap, Linearizer, PwmMap, WheelSpec

F = TypeVar("F", bound=LinearizerForm)
Wheels = Mapping[str, WheelSpec | None]  # in the order of the file; None for one with faults


@dataclass(frozen=True, slots=True)
class _Scale:
    """What lies between the numbers of a table and duty over wheel speed."""

    speed_unit: float  # m/s of rim or rad/s of the wheel
    angular: bool
    counts: int
    speed_scale: float

    def curve(self, form: CurveForm, radius_m: float) -> DutyCurve:
        unit_m_s = self.speed_unit * radius_m if self.angular else self.speed_unit
        if form.cubic is not None:
            return curves.from_cubic(
                form.cubic,
                speed_unit_m_s=unit_m_s,
                counts=self.counts,
                speed_scale=self.speed_scale,
                radius_m=radius_m,
                top=form.top,
            )
        if form.points is not None:
            return curves.from_points(
                form.points,
                speed_unit_m_s=unit_m_s,
                counts=self.counts,
                speed_scale=self.speed_scale,
                radius_m=radius_m,
            )
        return curves.from_pieces(form.knots or (), form.pieces or ())


def linearizer(wheels: Wheels, source: Source) -> Linearizer | None:
    """What `[linearizer]` says; None without one, or when faults were noted."""
    form, maps = _table(LinearizerForm, "linearizer", wheels, source)
    return Linearizer(maps, form.speed_scale) if form and maps else None


def pwm_map(wheels: Wheels, battery_v: float, source: Source) -> PwmMap | None:
    """What `[pwm_map]` says; None without one, or when faults were noted."""
    form, maps = _table(PwmMapForm, "pwm_map", wheels, source)
    if form is None or maps is None:
        return None
    return PwmMap(
        wheels=maps,
        counts=form.counts,
        voltage_v=battery_v if form.voltage is None else form.voltage,
        dead_time_s=form.dead_time,
        dead_time_spread_s=form.dead_time_spread,
        lag_s=form.lag,
        speed_spread=form.speed_spread,
        speed_noise=form.speed_noise,
        speed_scale=form.speed_scale,
    )


def _table(form: type[F], name: str, wheels: Wheels, source: Source) -> tuple[F | None, tuple[DutyMap, ...] | None]:
    """The plain keys of a table of curves, and the curves of all wheels in their order."""
    if name not in source.table:
        return None, None
    path: Path = (name,)
    table = source.table[name]
    if not isinstance(table, dict):
        return check(form, table, path, source)[0], None
    known = known_keys(form, ())
    groups = {key: value for key, value in table.items() if isinstance(value, dict) and key not in known}
    found, _ = check(form, {key: value for key, value in table.items() if key not in groups}, path, source)
    scale = _scale(found, path, source) if found else None
    maps = _maps(groups, path, scale, wheels, source)
    return found, tuple(maps[wheel] for wheel in wheels) if set(maps) == set(wheels) else None


def _scale(form: LinearizerForm, path: Path, source: Source) -> _Scale | None:
    for dimension in ("speed", "angular speed"):
        try:
            unit = parse(f"1 {form.speed_unit}", dimension)
        except QuantityError:
            continue
        return _Scale(unit, dimension == "angular speed", form.counts, form.speed_scale)
    what = f'speed_unit {shown(form.speed_unit)} is no unit of speed; choose such as "mm/s", "m/s" or "rad/s"'
    source.fault((*path, "speed_unit"), what)
    return None


def _maps(groups: Table, path: Path, scale: _Scale | None, wheels: Wheels, source: Source) -> dict[str, DutyMap]:
    """Curves by wheel; every wheel must be in one group."""
    maps: dict[str, DutyMap] = {}
    taken: dict[str, str] = {}  # wheel -> its group
    whole = True  # whether all groups say what wheels they have
    for name, table in groups.items():
        check_name(name, (*path, name), source)
        form, fields = check(CurveGroupForm, table, (*path, name), source)
        whole = whole and "wheels" in fields
        if fields.get("wheels") == []:
            source.fault((*path, name, "wheels"), f"{section((*path, name))} names no wheel")
        own = _members(fields.get("wheels", []), (*path, name), taken, wheels, source)
        if form and scale:
            for wheel in own:
                found = _map(form, scale, wheels[wheel], (*path, name), source)
                if found:
                    maps[wheel] = found
    missing = [wheel for wheel in wheels if wheel not in taken]
    if missing and whole:
        named = f"wheel {missing[0]} is" if len(missing) == 1 else f"wheels {', '.join(missing)} are"
        source.fault(path, f"{named} in no group of {section(path)}; every wheel must be in one", at_key=True)
    return maps


def _members(names: list[str], path: Path, taken: dict[str, str], wheels: Wheels, source: Source) -> list[str]:
    """The wheels of one group, each for the first time."""
    own = []
    for number, wheel in enumerate(names):
        place = (*path, "wheels", number)
        if wheel not in wheels:
            source.fault(place, f"there is no wheel {shown(wheel)}", meant(wheel, wheels))
        elif wheel in taken:
            source.fault(place, f"wheel {wheel} is in {taken[wheel]} already; every wheel must be in one group")
        else:
            taken[wheel] = section(path)
            own.append(wheel)
    return own


def _map(form: CurveGroupForm, scale: _Scale, wheel: WheelSpec | None, path: Path, source: Source) -> DutyMap | None:
    radius_m = wheel.radius if wheel else 1.0  # a faulty wheel's curves can be judged all the same
    found = []
    for way, curve in (("forward", form.forward), ("backward", form.backward)):
        place: Path = (*path, way)
        try:
            found.append(scale.curve(curve, radius_m))
        except curves.CurveError as error:
            written = next(key for key in ("cubic", "points", "knots") if getattr(curve, key) is not None)
            place = (*place, written) if error.point is None else (*place, written, error.point)
            source.fault(place, f"{section((*path, way))}: {error}")
    return DutyMap(*found) if len(found) == 2 else None
