"""Motors and sensors of a robot: a name of a library, or a table in the robot's own file."""

from collections.abc import Mapping
from typing import Any, TypeVar

from holodrive.files.edge import Form, check
from holodrive.files.scan import Path
from holodrive.files.source import Source, Table, meant
from holodrive.files.units import shown
from holodrive.robots import motors, sensors
from holodrive.robots.form import EncoderForm, ImuForm, LidarForm, MotorForm, Mount, MouseForm
from holodrive.robots.place import xy
from holodrive.robots.spec import Encoder, Imu, Lidar, Motor, Mouse
from holodrive.types import Pose

F = TypeVar("F", bound=Form)
OFF = 0.5  # of the no-load speed: how far voltage / back_emf may be from it before it must be a mistake


def motor(found: object, path: Path, source: Source) -> Motor | None:
    """The motor that a wheel names or describes; None when faults were noted."""
    form, fields = _part(MotorForm, "motor", found, path, source)
    _fits(fields, path, source)
    if fields.get("kind") == "dc" and fields.get("drive", "averaged") != "averaged":
        source.fault(
            (*path, "drive"),
            f'a dc motor has brushes that commutate it; found drive = "{fields["drive"]}"',
            "leave 'drive' out, or did you mean kind = \"bldc\"?",
        )
    return None if form is None else motor_of(form)


def motor_of(form: MotorForm) -> Motor:
    """All values brought behind the gear: speeds divided by it, constants times it, inertia times its square."""
    g = form.gear if form.shaft == "motor" else 1.0
    return Motor(
        name=form.name,
        kind=form.kind,
        voltage_v=form.voltage,
        no_load_speed_rad_s=form.no_load_speed / g,
        back_emf_v_s_rad=form.back_emf * g,
        resistance_ohm=form.resistance,
        inductance_h=form.inductance,
        efficiency=form.efficiency,
        coulomb_friction_n_m=form.coulomb_friction * g,
        viscous_friction_n_m_s_rad=form.viscous_friction * g * g,
        inertia_kg_m2=form.inertia * g * g,
        current_limit_a=float("inf") if form.current_limit is None else form.current_limit,
        lag_s=form.lag,
        gear=form.gear,
        source=form.source,
        poles=form.poles,
        emf=form.emf,
        drive=form.drive,
    )


def _fits(fields: Mapping[str, Any], path: Path, source: Source) -> None:
    """No-load speed, voltage and back-EMF must tell of the same motor."""
    try:
        voltage, constant, stated = fields["voltage"], fields["back_emf"], fields["no_load_speed"]
        resistance = fields["resistance"] / (fields.get("efficiency", 1.0) * constant)
    except KeyError:
        return
    drop = resistance * fields.get("coulomb_friction", 0.0)
    speed = (voltage - drop) / (constant + resistance * fields.get("viscous_friction", 0.0))
    if not OFF * stated <= speed <= stated / OFF:
        place = (*path, "back_emf")
        source.fault(
            place,
            f"at {voltage:g} V this motor would turn at {max(speed, 0.0):.4g} rad/s without load, "
            f"but no_load_speed says {stated:.4g} rad/s",
            "check voltage, back_emf, friction and the shaft they are seen from",
        )


def encoder(found: object, path: Path, source: Source) -> Encoder | None:
    """The encoder that a wheel names or describes."""
    form, _ = _part(EncoderForm, "encoder", found, path, source)
    return None if form is None else encoder_of(form)


def encoder_of(form: EncoderForm) -> Encoder:
    """The spec of an encoder."""
    return Encoder(counts_per_turn=form.counts_per_turn, name=form.name or "encoder", source=form.source)


def lidar(table: object, path: Path, source: Source) -> Lidar | None:
    """The range sensor of `[sensor.lidar]`."""
    form, fields = _table(LidarForm, "lidar", table, path, source)
    nearest, farthest = fields.get("range_min"), fields.get("range_max")
    if nearest is not None and farthest is not None and nearest >= farthest:
        source.fault((*path, "range_min"), f"range_min {nearest:g} m is not below range_max {farthest:g} m")
        return None
    return None if form is None else lidar_of(form)


def lidar_of(form: LidarForm) -> Lidar:
    """The spec of a range sensor."""
    return Lidar(
        name=form.name,
        mount=_pose(form.mount),
        rate_hz=form.rate,
        beams=form.beams,
        field_of_view_rad=form.field_of_view,
        clockwise=form.clockwise,
        range_min=form.range_min,
        range_max=form.range_max,
        noise_m=form.noise,
        noise_relative=form.noise_relative,
        dropout=form.dropout,
        motion_distortion=form.motion_distortion,
        source=form.source,
    )


def imu(table: object, path: Path, source: Source) -> Imu | None:
    """The gyro and accelerometer of `[sensor.imu]`."""
    form, _ = _table(ImuForm, "imu", table, path, source)
    return None if form is None else imu_of(form)


def imu_of(form: ImuForm) -> Imu:
    """The spec of a gyro and accelerometer."""
    return Imu(
        name=form.name,
        mount=_pose(form.mount),
        rate_hz=form.rate,
        gyro_noise_rad_s=form.gyro_noise,
        gyro_bias_rad_s=form.gyro_bias,
        gyro_bias_walk_rad_s=form.gyro_bias_walk,
        accel_noise_m_s2=form.accel_noise,
        source=form.source,
    )


def mouse(name: str, table: object, path: Path, source: Source) -> Mouse | None:
    """The mouse of `[sensor.mouse.NAME]`."""
    form, _ = _table(MouseForm, "mouse", table, path, source)
    return None if form is None else mouse_of(form, name)


def mouse_of(form: MouseForm, name: str) -> Mouse:
    """The spec of a mouse."""
    return Mouse(
        name=name,
        mount=_pose(form.mount),
        resolution_m=form.resolution,
        noise_relative=form.noise_relative,
        source=form.source,
        axes=form.axes,
    )


def _part(form: type[F], kind: str, found: object, path: Path, source: Source) -> tuple[F | None, dict[str, Any]]:
    """Check a part that is written as a library name or as a table."""
    if isinstance(found, str):
        values = _model(found, kind, path, source)
        return (None, {}) if values is None else check(form, values, path, source)
    if not isinstance(found, dict):
        library = "motor" if kind == "motor" else "sensor"
        article = "an" if kind == "encoder" else "a"
        source.fault(path, f"{shown(found)} is not {article} {kind}; write a name of the {library} library or a table")
        return None, {}
    return _table(form, kind, found, path, source)


def _table(form: type[F], kind: str, table: object, path: Path, source: Source) -> tuple[F | None, dict[str, Any]]:
    """Check a part's table after the values of its `model` are put under it."""
    if not isinstance(table, dict) or "model" not in table:
        return check(form, table, path, source)
    model = table["model"]
    own = {key: value for key, value in table.items() if key != "model"}
    values = None
    if isinstance(model, str):
        values = _model(model, kind, (*path, "model"), source)
    else:
        source.fault((*path, "model"), f"{shown(model)} is not text; model is a name of the library")
    if values is None:  # judge what is written all the same; what the model would have given is not missing
        return None, check(form, {**_any_model(kind), **own}, path, source)[1]
    return check(form, {**values, **own}, path, source)


def _model(name: str, kind: str, path: Path, source: Source) -> Table | None:
    if kind == "motor":
        known = motors.names()
        if name in known:
            return {"name": name, **motors.table(name)}
        source.fault(path, f"no motor called {shown(name)} in the motor library", meant(name, known))
        return None
    known = sensors.names(kind)
    if name in known:
        return {**({"name": name} if kind != "mouse" else {}), **sensors.table(name)}
    what = f"no {kind} called {shown(name)} in the sensor library"
    if name in sensors.names():
        what = f"{name} is not a sensor of the kind {kind} but of the kind {sensors.kind(name)}"
    source.fault(path, what, meant(name, known))
    return None


def _any_model(kind: str) -> Table:
    return motors.table(motors.names()[0]) if kind == "motor" else sensors.table(sensors.names(kind)[0])


def _pose(mount: Mount) -> Pose:
    x, y = xy(mount)
    return Pose(x, y, mount.yaw)
