"""A robot as canonical TOML."""

from dataclasses import asdict
from typing import Any

from holodrive.files.write import table
from holodrive.robots.checks import WHEELS_OUTSIDE, reach
from holodrive.robots.spec import (
    DutyCurve,
    DutyMap,
    Encoder,
    Imu,
    Lidar,
    Motor,
    Mouse,
    PwmMap,
    Robot,
    Steering,
    WheelSpec,
)
from holodrive.types import Pose


def text(robot: Robot) -> str:
    """The whole file; parts that all wheels share are written once, in `[defaults.wheel]`."""
    shared = _shared(robot)
    blocks = ["#:schema robot.schema.json\nschema = 1\n", _robot(robot)]
    if "steering" in shared and robot.wheels[0].steering:
        blocks += _steering(("defaults", "wheel", "steering"), robot.wheels[0].steering)
    if "motor" in shared:
        blocks.append(table(("defaults", "wheel", "motor"), _motor(robot.wheels[0].motor)))
    for wheel in robot.wheels:
        blocks += _wheel(wheel, shared)
    blocks += _sensors(robot)
    blocks += [
        table(("battery",), _keys(asdict(robot.battery), "_v", "_ohm", "_c")),
        table(("ground",), _keys(asdict(robot.ground), "_m_s")),
        table(("limits",), _keys(asdict(robot.limits), "_m_s", "_rad_s", "_m_s2", "_rad_s2")),
        table(("speed_loop",), _keys(asdict(robot.speed_loop), "_s")),
    ]
    if robot.linearizer:
        blocks.append(table(("linearizer",), {"speed_scale": robot.linearizer.speed_scale}))
        blocks += _curves("linearizer", robot.linearizer.wheels, robot)
    if robot.pwm_map:
        blocks.append(table(("pwm_map",), _pwm_map(robot.pwm_map)))
        blocks += _curves("pwm_map", robot.pwm_map.wheels, robot)
    return "\n".join(blocks)


def _robot(robot: Robot) -> str:
    x, y = robot.centre_of_mass
    outside = reach(robot.wheels) > robot.footprint_radius_m * (1.0 + 1e-9)
    return table(
        ("robot",),
        {
            "name": robot.name,
            "title": robot.title or None,
            "source": robot.source or None,
            "accept": [WHEELS_OUTSIDE] if outside else None,
            "mass": robot.mass_kg,
            "inertia": robot.inertia_kg_m2,
            "centre_of_mass": {"x": x, "y": y},
            "footprint_radius": robot.footprint_radius_m,
            "control_period": robot.control_period_s,
        },
    )


def _shared(robot: Robot) -> set[str]:
    """Parts that all wheels have alike; a steering only where all wheels are steered."""
    shared = {part for part in ("motor", "steering") if len({getattr(wheel, part) for wheel in robot.wheels}) == 1}
    return shared if robot.wheels[0].steering else shared - {"steering"}


def _wheel(wheel: WheelSpec, shared: set[str]) -> list[str]:
    path = ("wheel", wheel.name)
    swerve = wheel.kind == "swerve"
    keys = {
        "kind": wheel.kind,
        "at": {"x": wheel.x, "y": wheel.y},
        "yaw": wheel.yaw,
        "roller": None if swerve else wheel.roller,
        "radius": wheel.radius,
        "width": wheel.width,
        "max_speed": wheel.max_speed_rad_s,
        "inverted": wheel.inverted,
        "encoder": _encoder(wheel.encoder) if wheel.encoder else None,
    }
    blocks = [table(path, keys)]
    if "motor" not in shared:
        blocks.append(table((*path, "motor"), _motor(wheel.motor)))
    if wheel.steering and "steering" not in shared:
        blocks += _steering((*path, "steering"), wheel.steering)
    return blocks


def _steering(path: tuple[str, ...], steering: Steering) -> list[str]:
    keys = {
        "rate": steering.rate_rad_s,
        "lag": steering.lag_s,
        "caster": steering.caster_m,
        "coupling": steering.coupling,
        "kp": steering.kp_v_rad,
        "kd": steering.kd_v_s_rad,
        "inertia": steering.inertia_kg_m2,
    }
    blocks = [table(path, keys)]
    return [*blocks, table((*path, "motor"), _motor(steering.motor))] if steering.motor else blocks


def _motor(motor: Motor) -> dict[str, object]:
    return {
        "name": motor.name or None,
        "source": motor.source or None,
        "kind": motor.kind,
        "gear": motor.gear,
        "voltage": motor.voltage_v,
        "no_load_speed": motor.no_load_speed_rad_s,
        "back_emf": motor.back_emf_v_s_rad,
        "resistance": motor.resistance_ohm,
        "inductance": motor.inductance_h,
        "inertia": motor.inertia_kg_m2,
        "efficiency": motor.efficiency,
        "coulomb_friction": motor.coulomb_friction_n_m,
        "viscous_friction": motor.viscous_friction_n_m_s_rad,
        "current_limit": motor.current_limit_a,
        "lag": motor.lag_s,
        "poles": motor.poles,
        "emf": motor.emf,
        "drive": motor.drive,
    }


def _encoder(encoder: Encoder) -> dict[str, object]:
    return {
        "name": encoder.name,
        "source": encoder.source or None,
        "counts_per_turn": encoder.counts_per_turn,
    }


def _sensors(robot: Robot) -> list[str]:
    blocks = []
    if robot.lidar:
        blocks.append(table(("sensor", "lidar"), _lidar(robot.lidar)))
    if robot.imu:
        blocks.append(table(("sensor", "imu"), _imu(robot.imu)))
    return blocks + [table(("sensor", "mouse", mouse.name), _mouse(mouse)) for mouse in robot.mice]


def _lidar(lidar: Lidar) -> dict[str, object]:
    return {
        "name": lidar.name,
        "source": lidar.source or None,
        "mount": _mount(lidar.mount),
        "rate": lidar.rate_hz,
        "beams": lidar.beams,
        "field_of_view": lidar.field_of_view_rad,
        "clockwise": lidar.clockwise,
        "range_min": lidar.range_min,
        "range_max": lidar.range_max,
        "noise": lidar.noise_m,
        "noise_relative": lidar.noise_relative,
        "dropout": lidar.dropout,
        "motion_distortion": lidar.motion_distortion,
    }


def _imu(imu: Imu) -> dict[str, object]:
    return {
        "name": imu.name,
        "source": imu.source or None,
        "mount": _mount(imu.mount),
        "rate": imu.rate_hz,
        "gyro_noise": imu.gyro_noise_rad_s,
        "gyro_bias": imu.gyro_bias_rad_s,
        "gyro_bias_walk": imu.gyro_bias_walk_rad_s,
        "accel_noise": imu.accel_noise_m_s2,
    }


def _mouse(mouse: Mouse) -> dict[str, object]:
    return {
        "source": mouse.source or None,
        "mount": _mount(mouse.mount),
        "resolution": mouse.resolution_m,
        "noise_relative": mouse.noise_relative,
        "axes": mouse.axes,
    }


def _mount(pose: Pose) -> dict[str, float]:
    return {"x": pose.x, "y": pose.y, "yaw": pose.theta}


def _pwm_map(known: PwmMap) -> dict[str, object]:
    return {
        "counts": known.counts,
        "speed_scale": known.speed_scale,
        "voltage": known.voltage_v,
        "dead_time": known.dead_time_s,
        "dead_time_spread": known.dead_time_spread_s,
        "lag": known.lag_s,
        "speed_spread": known.speed_spread,
        "speed_noise": known.speed_noise,
    }


def _curves(name: str, maps: tuple[DutyMap, ...], robot: Robot) -> list[str]:
    """A table for all wheels that have the same curves."""
    groups: dict[DutyMap, list[str]] = {}
    for wheel, known in zip(robot.wheels, maps, strict=True):
        groups.setdefault(known, []).append(wheel.name)
    return [
        table((name, f"group{n}"), {"wheels": members, "forward": _curve(m.forward), "backward": _curve(m.backward)})
        for n, (m, members) in enumerate(groups.items(), 1)
    ]


def _curve(curve: DutyCurve) -> dict[str, object]:
    return {"knots": curve.knots, "pieces": curve.pieces}


def _keys(values: dict[str, Any], *units: str) -> dict[str, Any]:
    """File keys of a spec: field names without their unit."""
    found = {}
    for name, value in values.items():
        ending = max((unit for unit in units if name.endswith(unit)), key=len, default="")
        found[name.removesuffix(ending)] = value
    return found
