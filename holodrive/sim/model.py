"""A robot as the kernels of the simulator read it: arrays made once from its description, a step and a period."""

import math
from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np

from holodrive.actuators.lag import lag_factors
from holodrive.errors import InputError
from holodrive.kinematics import Chassis
from holodrive.layout import MAX_MICE, MAX_WHEELS
from holodrive.robots.spec import Imu, Robot
from holodrive.sim.lidar import LidarModel, lidar_model
from holodrive.sim.loads import GRAVITY, wheel_loads
from holodrive.types import Array


class WheelModel(NamedTuple):
    """Wheels (n,), SI. Vectors are unit vectors of a fixed wheel, or a steered one's at angle 0.

    `forward` (3, rows) is the chassis' least-squares inverse; `row` the first row of each wheel; `steered` its place
    in steering arrays or -1. `decay`, `mean` are the first-order lag's factors for one step, `turn` the servo's.
    `ax, ay` is the direction of traction (a roller's axis), `ex, ey` the rolling direction, `px, py` the contact
    seen from the centre of mass; `grip` and `rolling` [N] are the friction force along traction and along the
    direction in which the roller runs free.
    """

    radius: Array
    max_speed: Array
    steered: Array
    row: Array
    forward: Array
    no_load: Array
    decay: Array
    mean: Array
    turn: Array
    turn_limit: Array
    yaw: Array
    ax: Array
    ay: Array
    ex: Array
    ey: Array
    px: Array
    py: Array
    grip: Array
    rolling: Array
    counts: Array  # encoder counts per rad, 0 = no encoder


class MotorModel(NamedTuple):
    """Gearmotors (n,) seen from the output shaft; `reactance` is L / dt [ohm]."""

    back_emf: Array
    resistance: Array
    reactance: Array
    efficiency: Array
    coulomb: Array
    viscous: Array
    inertia: Array
    limit: Array


class ImuModel(NamedTuple):
    """Yaw gyro and accelerometer; `rate` 0 = none, no reading."""

    rate: float
    x: float
    y: float
    theta: float
    gyro_noise: float
    gyro_bias: float
    gyro_walk: float
    accel_noise: float


class RobotModel(NamedTuple):
    """One robot at one physics step. `steps` physics steps of `dt` make one control period of `period` seconds."""

    n: int
    m: int
    dt: float
    period: float
    steps: int
    footprint: float
    mass: float
    inertia: float
    com_x: float
    com_y: float
    slip_speed: float
    battery_voltage: float
    battery_resistance: float
    battery_capacity: float
    loop_kp: float
    loop_ki: float
    loop_filter: float  # share of the new encoder speed that is let in at each control tick
    wheels: WheelModel
    motors: MotorModel
    lidar: LidarModel
    imu: ImuModel
    mice: Array  # (k, 5) x, y, theta of the mount, m per count, relative noise


@lru_cache(maxsize=64)
def model_of(robot: Robot, dt_s: float) -> RobotModel:
    """The model of a described robot at a physics step [s].

    Raises:
        InputError: the step does not divide the control period, or the robot cannot stand on its wheels.
    """
    steps = round(robot.control_period_s / dt_s) if dt_s > 0.0 and math.isfinite(dt_s) else 0
    if steps < 1 or abs(steps * dt_s - robot.control_period_s) > 1e-9 * robot.control_period_s:
        raise InputError(
            f"a physics step of {dt_s} s does not divide the control period of {robot.name}, "
            f"{robot.control_period_s} s; take the period over a whole number"
        )
    if len(robot.wheels) > MAX_WHEELS or len(robot.mice) > MAX_MICE:
        raise InputError(
            f"{robot.name} has {len(robot.wheels)} wheels and {len(robot.mice)} mice; "
            f"the simulator takes at most {MAX_WHEELS} and {MAX_MICE}"
        )
    return RobotModel(
        n=len(robot.wheels),
        m=len(robot.steered),
        dt=robot.control_period_s / steps,
        period=robot.control_period_s,
        steps=steps,
        footprint=robot.footprint_radius_m,
        mass=robot.mass_kg,
        inertia=robot.inertia_kg_m2,
        com_x=robot.centre_of_mass[0],
        com_y=robot.centre_of_mass[1],
        slip_speed=robot.ground.slip_speed_m_s,
        battery_voltage=robot.battery.voltage_v,
        battery_resistance=robot.battery.resistance_ohm,
        battery_capacity=robot.battery.capacity_c,
        loop_kp=robot.speed_loop.kp,
        loop_ki=robot.speed_loop.ki,
        loop_filter=1.0 - lag_factors(robot.speed_loop.filter_s, robot.control_period_s)[0],
        wheels=_wheels(robot, robot.control_period_s / steps),
        motors=_motors(robot, robot.control_period_s / steps),
        lidar=lidar_model(robot.lidar),
        imu=_imu(robot.imu),
        mice=_rows([(*mouse.mount, mouse.resolution_m, mouse.noise_relative) for mouse in robot.mice], 5),
    )


def _wheels(robot: Robot, dt: float) -> WheelModel:
    chassis, wheels = Chassis.of(robot), robot.wheels
    lags = [lag_factors(w.motor.lag_s, dt) for w in wheels]
    roll = _vector(w.yaw for w in wheels)
    traction = _vector(w.yaw + (0.0 if w.kind == "swerve" else w.roller) for w in wheels)
    (cx, cy), ground = robot.centre_of_mass, robot.ground
    load = wheel_loads([(w.x, w.y) for w in wheels], (cx, cy), robot.mass_kg * GRAVITY, robot.name)
    steered = [robot.steered.index(i) if w.kind == "swerve" else -1 for i, w in enumerate(wheels)]
    servo = [wheels[i].steering for i in robot.steered]
    return WheelModel(
        radius=_vector(w.radius for w in wheels),
        max_speed=_vector(w.max_speed_rad_s for w in wheels),
        steered=np.array(steered, dtype=np.int64),
        row=np.ascontiguousarray(chassis.row, dtype=np.int64),
        forward=np.array(chassis.least_squares, dtype=np.float64, order="C"),
        no_load=_vector(w.motor.no_load_speed_rad_s for w in wheels),
        decay=_vector(lag[0] for lag in lags),
        mean=_vector(lag[1] for lag in lags),
        turn=_vector(1.0 - lag_factors(s.lag_s, dt)[0] if s else 1.0 for s in servo),
        turn_limit=_vector(s.rate_rad_s * dt if s else math.inf for s in servo),
        yaw=roll,
        ax=np.cos(traction),
        ay=np.sin(traction),
        ex=np.cos(roll),
        ey=np.sin(roll),
        px=_vector(w.x - cx for w in wheels),
        py=_vector(w.y - cy for w in wheels),
        grip=ground.friction * load,
        # a plain tyre grips sideways as well; a roller only resists
        rolling=_vector(ground.friction if w.kind == "swerve" else ground.roller_resistance for w in wheels) * load,
        counts=_vector(w.encoder.counts_per_turn / (2.0 * math.pi) if w.encoder else 0.0 for w in wheels),
    )


def _motors(robot: Robot, dt: float) -> MotorModel:
    motors = [w.motor for w in robot.wheels]
    return MotorModel(
        back_emf=_vector(m.back_emf_v_s_rad for m in motors),
        resistance=_vector(m.resistance_ohm for m in motors),
        reactance=_vector(m.inductance_h / dt for m in motors),
        efficiency=_vector(m.efficiency for m in motors),
        coulomb=_vector(m.coulomb_friction_n_m for m in motors),
        viscous=_vector(m.viscous_friction_n_m_s_rad for m in motors),
        inertia=_vector(max(m.inertia_kg_m2, 1e-9) for m in motors),
        limit=_vector(m.current_limit_a for m in motors),
    )


def _imu(imu: Imu | None) -> ImuModel:
    if imu is None:
        return ImuModel(0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
    return ImuModel(
        imu.rate_hz,
        imu.mount.x,
        imu.mount.y,
        imu.mount.theta,
        imu.gyro_noise_rad_s,
        imu.gyro_bias_rad_s,
        imu.gyro_bias_walk_rad_s,
        imu.accel_noise_m_s2,
    )


def _vector(values: Any) -> Array:
    return np.array(list(values), dtype=np.float64)


def _rows(rows: list[Any], width: int) -> Array:
    return np.ascontiguousarray(np.array(rows, dtype=np.float64).reshape(-1, width))
