"""From the tables of a robot file to a `Robot`, with every fault of the file noted on the way."""

import math
from typing import Any, TypeVar

from holodrive.files.edge import Form, check, known_keys
from holodrive.files.scan import Path
from holodrive.files.source import Source, meant
from holodrive.files.units import shown
from holodrive.layout import MAX_MICE
from holodrive.robots import checks, duty_maps, parts
from holodrive.robots.form import BatteryForm, GroundForm, LimitsForm, RobotForm, SpeedLoopForm
from holodrive.robots.naming import check_name
from holodrive.robots.place import xy
from holodrive.robots.spec import Battery, Ground, Imu, Lidar, Limits, Mouse, Robot, SpeedLoop, WheelSpec
from holodrive.robots.wheels import wheels

F = TypeVar("F", bound=Form)

SECTIONS = (
    "schema",
    "robot",
    "defaults",
    "wheel",
    "sensor",
    "battery",
    "ground",
    "limits",
    "speed_loop",
    "linearizer",
    "pwm_map",
)
SENSORS = ("lidar", "imu", "mouse")


def robot(source: Source) -> Robot:
    """The robot of a file; raises FileFaults with all its faults."""
    table = source.table
    for key in table:
        if key not in SECTIONS:
            source.fault(
                (key,),
                f"unknown table [{key}]" if isinstance(table[key], dict) else f"unknown key '{key}'",
                meant(key, SECTIONS),
                at_key=True,
            )
    base, fields = _section(RobotForm, "robot", source, required=True)
    for number, name in enumerate(fields.get("accept", [])):
        if name not in checks.ACCEPTABLE:
            place = ("robot", "accept", number)
            source.fault(place, f"{shown(name)} cannot be accepted", meant(name, checks.ACCEPTABLE))
    all_wheels = wheels(source)
    lidar, imu, mice = _sensors(source)
    battery = _battery(source, all_wheels)
    ground, _ = _section(GroundForm, "ground", source)
    limits, limit_fields = _section(LimitsForm, "limits", source)
    loop, _ = _section(SpeedLoopForm, "speed_loop", source)
    linearizer = duty_maps.linearizer(all_wheels, source)
    pwm_map = duty_maps.pwm_map(all_wheels, battery.voltage_v if battery else 0.0, source)
    checks.whole(all_wheels, fields, limit_fields, source)
    checks.mice(mice, all_wheels, fields, source)
    source.refuse()
    if not (base and battery and ground and limits and loop):
        raise AssertionError(f"{source.file}: a form without faults is missing")
    spec_wheels = tuple(wheel for wheel in all_wheels.values() if wheel is not None)
    return Robot(
        name=base.name,
        title=base.title,
        source=base.source,
        wheels=spec_wheels,
        mass_kg=base.mass,
        inertia_kg_m2=base.inertia or derived_inertia(base.mass, spec_wheels),
        footprint_radius_m=base.footprint_radius or checks.reach(spec_wheels),
        centre_of_mass=xy(base.centre_of_mass) if base.centre_of_mass else (0.0, 0.0),
        battery=battery,
        ground=Ground(ground.friction, ground.roller_resistance, ground.slip_speed),
        limits=Limits(
            *(math.inf if v is None else v for v in (limits.speed, limits.yaw_rate, limits.accel, limits.yaw_accel))
        ),
        speed_loop=SpeedLoop(loop.kp, loop.ki, loop.filter, loop.feed_forward),
        lidar=lidar,
        imu=imu,
        mice=mice,
        control_period_s=base.control_period,
        linearizer=linearizer,
        pwm_map=pwm_map,
        text=source.text,
    )


def derived_inertia(mass_kg: float, all_wheels: tuple[WheelSpec, ...]) -> float:
    """1/2 m R^2 of a disc out to the farthest wheel contact."""
    return 0.5 * mass_kg * max(math.hypot(wheel.x, wheel.y) for wheel in all_wheels) ** 2


def _section(form: type[F], name: str, source: Source, *, required: bool = False) -> tuple[F | None, dict[str, Any]]:
    if name not in source.table and required:
        source.fault((), f"the file has no [{name}] table; it needs {', '.join(_needed(form))}")
        return None, {}
    return check(form, source.table.get(name, {}), (name,), source)


def _needed(form: type[Form]) -> list[str]:
    return [
        key for key, info in zip(known_keys(form, ()), form.model_fields.values(), strict=True) if info.is_required()
    ]


def _sensors(source: Source) -> tuple[Lidar | None, Imu | None, tuple[Mouse, ...]]:
    table = source.table.get("sensor", {})
    if not isinstance(table, dict):
        source.fault(("sensor",), f"{shown(table)} stands where tables such as [sensor.lidar] should be")
        return None, None, ()
    for key in table:
        if key not in SENSORS:
            source.fault(
                ("sensor", key), f"unknown sensor '{key}'; choose lidar, imu or mouse", meant(key, SENSORS), at_key=True
            )
    lidar = parts.lidar(table["lidar"], ("sensor", "lidar"), source) if "lidar" in table else None
    imu = parts.imu(table["imu"], ("sensor", "imu"), source) if "imu" in table else None
    return lidar, imu, _mice(table.get("mouse", {}), source)


def _mice(table: object, source: Source) -> tuple[Mouse, ...]:
    path: Path = ("sensor", "mouse")
    if not isinstance(table, dict) or any(not isinstance(entry, dict) for entry in table.values()):
        source.fault(path, "mice are tables with a name, such as [sensor.mouse.left]")
        return ()
    if len(table) > MAX_MICE:
        first = list(table)[MAX_MICE]
        source.fault((*path, first), f"a robot has at most {MAX_MICE} mice, found {len(table)}", at_key=True)
        return ()
    for name in table:
        check_name(name, (*path, name), source)
    found = [parts.mouse(name, entry, (*path, name), source) for name, entry in table.items()]
    return tuple(one for one in found if one is not None)


def _battery(source: Source, all_wheels: dict[str, WheelSpec | None]) -> Battery | None:
    if "battery" in source.table:
        form, _ = check(BatteryForm, source.table["battery"], ("battery",), source)
        if form is None:
            return None
        return Battery(form.voltage, form.resistance, math.inf if form.capacity is None else form.capacity)
    whole = [wheel for wheel in all_wheels.values() if wheel is not None]
    steering = [wheel.steering.motor for wheel in whole if wheel.steering and wheel.steering.motor]
    voltages = sorted({motor.voltage_v for motor in [*(wheel.motor for wheel in whole), *steering]})
    if len(voltages) > 1:
        listed = ", ".join(f"{voltage:g} V" for voltage in voltages)
        source.fault((), f"the motors need {listed}; a [battery] table must say the voltage")
    return Battery(voltages[0]) if voltages else None
