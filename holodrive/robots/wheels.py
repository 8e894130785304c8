"""The wheel tables of a robot file, over what they share, as `WheelSpec`s."""

import math
from typing import Any

from holodrive.files.edge import check, known_keys
from holodrive.files.scan import Path
from holodrive.files.source import Source, Table, meant, section
from holodrive.files.units import QuantityError, parse, shown
from holodrive.layout import MAX_WHEELS
from holodrive.robots import checks, parts
from holodrive.robots.form import SteeringForm, WheelForm
from holodrive.robots.naming import check_name
from holodrive.robots.place import xy
from holodrive.robots.spec import Motor, Steering, WheelSpec

KINDS = ("omni", "mecanum", "swerve")


def wheels(source: Source) -> dict[str, WheelSpec | None]:
    """All wheels by name, in the order of the file; None for one with faults."""
    tables = source.table.get("wheel")
    shared = _shared(source)
    if not isinstance(tables, dict) or not tables:
        what = "the file has no wheels" if tables in (None, {}) else f"{shown(tables)} stands where wheels should be"
        source.fault(("wheel",), what, "write a table for each, such as [wheel.front]")
        return {}
    if len(tables) > MAX_WHEELS:
        first = list(tables)[MAX_WHEELS]
        source.fault(("wheel", first), f"a robot has at most {MAX_WHEELS} wheels, found {len(tables)}", at_key=True)
        return {}
    return {name: _wheel(name, table, shared, source) for name, table in tables.items()}


def _shared(source: Source) -> Table:
    defaults = source.table.get("defaults", {})
    if not isinstance(defaults, dict):
        source.fault(("defaults",), f"{shown(defaults)} stands where [defaults.wheel] should be")
        return {}
    for key in defaults:
        if key != "wheel":
            source.fault(("defaults", key), f"unknown table [defaults.{key}]", "did you mean 'wheel'?", at_key=True)
    shared = defaults.get("wheel", {})
    if not isinstance(shared, dict):
        source.fault(("defaults", "wheel"), f"{shown(shared)} stands where [defaults.wheel] should be")
        return {}
    known = known_keys(WheelForm, ())
    for key in shared:
        if key not in known:
            place: Path = ("defaults", "wheel", key)
            source.fault(place, f"unknown key '{key}' in [defaults.wheel]", meant(key, known), at_key=True)
    return {key: value for key, value in shared.items() if key in known}


def _wheel(name: str, own: object, shared: Table, source: Source) -> WheelSpec | None:
    path: Path = ("wheel", name)
    check_name(name, path, source)
    if not isinstance(own, dict):
        source.fault(path, f"{shown(own)} stands where a table [wheel.{name}] should be")
        return None
    table = _merged(path, own, shared, source)
    faults = len(source.faults) + source.unlisted
    motor = parts.motor(table["motor"], (*path, "motor"), source) if "motor" in table else None
    steering_motor = _steering_motor(table.get("steering"), path, source)
    encoder = parts.encoder(table["encoder"], (*path, "encoder"), source) if "encoder" in table else None
    form, fields = check(WheelForm, table, path, source, also=_needs(table))
    _fits_kind(table, fields, path, source)
    max_speed = _max_speed(table, fields, motor, path, source)
    if form is None or motor is None or len(source.faults) + source.unlisted > faults:
        return None
    x, y = xy(form.at)
    return WheelSpec(
        name=name,
        kind=form.kind,
        x=x,
        y=y,
        yaw=form.yaw,
        radius=form.radius,
        motor=motor,
        max_speed_rad_s=max_speed,
        roller=form.roller,
        width=form.width,
        encoder=encoder,
        steering=_steering(form.steering, steering_motor) if form.steering else None,
        inverted=form.inverted,
    )


def _steering_motor(table: object, path: Path, source: Source) -> Motor | None:
    if not isinstance(table, dict) or "motor" not in table:
        return None
    return parts.motor(table["motor"], (*path, "steering", "motor"), source)


def _steering(form: SteeringForm, motor: Motor | None) -> Steering:
    return Steering(
        rate_rad_s=form.rate,
        lag_s=form.lag,
        caster_m=form.caster,
        coupling=form.coupling,
        motor=motor,
        kp_v_rad=form.kp,
        kd_v_s_rad=form.kd,
        inertia_kg_m2=form.inertia,
    )


def _merged(path: Path, own: Table, shared: Table, source: Source) -> Table:
    """The wheel's own keys over the shared ones; shared tables lend their keys one by one."""
    merged: Table = {}
    for key, value in {**shared, **own}.items():
        lent = shared.get(key)
        if key not in own:
            source.borrowed[(*path, key)] = ("defaults", "wheel", key)
            merged[key] = value
        elif isinstance(value, dict) and isinstance(lent, dict) and key != "at":
            for inner in set(lent) - set(value):
                source.borrowed[(*path, key, inner)] = ("defaults", "wheel", key, inner)
            merged[key] = {**lent, **value}
            if key == "steering" and "motor" in value:
                merged[key]["motor"] = _changed(value["motor"], lent.get("motor"))
        else:
            merged[key] = _changed(value, lent) if key == "motor" else value
    return merged


def _changed(own: object, lent: object) -> object:
    """A motor of which only some keys are written, and no kind, changes the one whose name is shared."""
    if isinstance(own, dict) and isinstance(lent, str) and not {"model", "kind"} & set(own):
        return {"model": lent, **own}
    return own


def _needs(table: Table) -> dict[str, str]:
    kind = table.get("kind")
    needs = {}
    if kind in ("omni", "mecanum"):
        needs["yaw"] = "the direction in which positive speed drives"
    if kind == "mecanum":
        needs["roller"] = "the axis of the roller on the ground, from the rolling direction (45 deg or -45 deg)"
    if kind == "swerve":
        needs["steering"] = 'the steering servo, such as { rate = "6 rad/s", lag = "50 ms" }'
    return needs


def _fits_kind(table: Table, fields: dict[str, Any], path: Path, source: Source) -> None:
    kind, roller = table.get("kind"), fields.get("roller")
    if kind == "mecanum" and roller is not None and "roller" in table:
        message = checks.mecanum_roller(roller)
        if message:
            source.fault((*path, "roller"), message, "45 deg or -45 deg is usual")
    if kind == "omni" and roller is not None and abs(math.sin(roller)) > 1e-9:
        source.fault(
            (*path, "roller"),
            f"the rollers of an omni wheel lie at 0 deg, found {shown(table['roller'])}",
            'did you mean kind = "mecanum"?',
        )
    if kind == "swerve" and "roller" in table:
        source.fault((*path, "roller"), "a swerve wheel has no rollers; leave 'roller' out", at_key=True)
    if kind in ("omni", "mecanum") and "steering" in table:
        source.fault((*path, "steering"), f"{section(path)} is not steered; leave 'steering' out", at_key=True)


def _max_speed(table: Table, fields: dict[str, Any], motor: Motor | None, path: Path, source: Source) -> float:
    """The wheel's limit [rad/s]: an angular speed, or a rim speed over the radius."""
    own = motor.no_load_speed_rad_s if motor else math.inf
    if "max_speed" not in table:
        return own
    found, radius = table["max_speed"], fields.get("radius")
    place = (*path, "max_speed")
    try:
        rim = parse(found, "speed") if isinstance(found, str) else None
    except QuantityError:
        rim = None
    try:
        limit = (math.inf if radius is None else rim / radius) if rim is not None else parse(found, "angular speed")
    except QuantityError as error:
        source.fault(place, str(error), error.hint)
        return own
    if limit <= 0.0:
        source.fault(place, f"max_speed {shown(found)} must be above 0")
    elif motor is not None and radius is not None and limit > own * (1.0 + 1e-12):
        rpm = own * 30.0 / math.pi
        source.fault(
            place,
            f"{motor.name or 'the motor'} gives {rpm:.4g} rpm x {radius * 1e3:.4g} mm = {own * radius:.3g} m/s, "
            f"limit says {limit * radius:.3g} m/s",
        )
    return limit
