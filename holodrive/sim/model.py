"""A robot as the kernels of the simulator read it: one flat float64 vector for one physics step.

One vector makes a kernel call cheap (a tuple of thirty arrays costs microseconds). It has a header, a block for each
wheel, a row for each mouse, and the directions of the lidar's beams.
"""

import math
from functools import lru_cache

import numpy as np

from holodrive.actuators import duty_curve
from holodrive.actuators.lag import lag_factors
from holodrive.errors import InputError
from holodrive.kinematics import Chassis, kernel
from holodrive.layout import MAX_MICE, MAX_WHEELS
from holodrive.robots.spec import Imu, Lidar, Robot
from holodrive.sim import motor_blocks
from holodrive.sim.loads import GRAVITY, wheel_loads
from holodrive.types import Array

# --- header --------------------------------------------------------------------------------------
N = 0  # wheels
M = 1  # of them steered
MICE = 2  # ground sensors
STEPS = 3  # physics steps in a control period
DT = 4  # s
PERIOD = 5  # s
FOOTPRINT = 6  # m
MASS = 7  # kg
INERTIA = 8  # kg m^2, about the centre of mass
COM_X, COM_Y = 9, 10  # m
SLIP_SPEED = 11  # m/s
BATTERY_V, BATTERY_R, BATTERY_C = 12, 13, 14  # V, ohm, C
LOOP_KP, LOOP_KI = 15, 16
LOOP_FILTER = 17  # share of the new encoder speed that is let in at each control tick
IMU_RATE = 18  # Hz; 0 = none
IMU_X, IMU_Y, IMU_THETA = 19, 20, 21
GYRO_NOISE, GYRO_BIAS, GYRO_WALK = 22, 23, 24
ACCEL_NOISE = 25
BEAMS = 26  # 0 = no lidar
LIDAR_X, LIDAR_Y, LIDAR_THETA = 27, 28, 29
SCAN_PERIOD = 30  # s
BEAM_PERIOD = 31  # s from beam to beam; 0 for an instantaneous scan
FIRST_BEAM, BEAM_STEP = 32, 33  # rad, sensor frame; the step is negative for a clockwise sensor
RANGE_MIN, RANGE_MAX = 34, 35  # m
RANGE_NOISE, RANGE_NOISE_RELATIVE = 36, 37
DROPOUT = 38
MICE_AT = 39  # where the mice begin
BEAMS_AT = 40  # where the cosines of the beams begin; their sines follow
ALIKE = 41  # 1 when no wheel is steered and all have one lag
MAP_AT = 42  # where the measured actuators begin; 0 = none
LINEARIZER_AT = 43  # where the motor board's curves begin; 0 = none
MOTORS_AT = 44  # where the motors begin: a block for each drive, then one for each steering
SUBSTEPS = 45  # of a physics step on the plant "motors"
LOOP_SHARE = 46  # share of a new wheel speed that the board lets in at each physics step, plant "motors"
LOOP_AHEAD = 47  # share of feed-forward
CASTER_AT = 48  # where the kinematics begin of a robot with casters or couplings; 0 = none
WHEELS = 49  # the first wheel's block begins here

# --- block of a wheel ----------------------------------------------------------------------------
STEERED = 0  # place in steering arrays, or -1
RADIUS = 1  # m
MAX_SPEED = 2  # rad/s
COUNTS = 3  # encoder counts per rad; NaN without an encoder, and so are the next two
BACK = 4  # 3: column of the chassis' least-squares inverse
BACK_ACROSS = 7  # 3: the second column of a steered wheel
NO_LOAD = 10  # rad/s
DECAY, MEAN = 11, 12  # first-order lag over one step
TURN, TURN_LIMIT = 13, 14  # steering servo over one step: share of the gap, rad
YAW = 15  # rad
PX, PY = 16, 17  # m, contact seen from the centre of mass
TRACTION = 18  # 3: row over the twist of the centre of mass along the direction of traction
FREE = 21  # 3: the same along the direction in which a roller runs free
KAPPA_R = 24  # m: rim speed along traction per wheel speed
SIGMA_R = 25  # m: rim speed along the free direction per wheel speed
GRIP, ROLLING = 26, 27  # N: largest friction along traction, along the free direction
BACK_EMF, RESISTANCE = 28, 29  # V s/rad, ohm
REACTANCE = 30  # ohm, L / dt
TORQUE = 31  # N m/A: efficiency times back EMF
COULOMB, VISCOUS = 32, 33  # N m, N m s/rad
SPIN = 34  # kg m^2, rotor and gear
LIMIT = 35  # A
COUNT_RAD, COUNT_SPEED = 36, 37  # rad per count; rad/s per count in a control period
SLOWNESS, PER_NO_LOAD = 38, 39  # s/rad: 1 / MAX_SPEED, 1 / NO_LOAD
BLOCK = 40

# --- row of a mouse ------------------------------------------------------------------------------
MOUSE_X, MOUSE_Y, MOUSE_THETA, MOUSE_COUNT, MOUSE_NOISE, MOUSE_AXES = range(6)  # m, m, rad, m per count, 1, 1 or 2
MOUSE = 6

# --- measured actuators: header, then the curves (`actuators.duty_curve.pack`) --------------------
MAP_COUNTS = 0  # PWM counts of full duty
MAP_VOLTAGE = 1  # V
MAP_DEAD_TIME, MAP_DEAD_SPREAD = 2, 3  # s
MAP_DECAY, MAP_MEAN = 4, 5  # first-order lag over one step
MAP_SPREAD, MAP_NOISE = 6, 7  # parts of the speed
MAP_CURVES = 8


@lru_cache(maxsize=64)
def model_of(robot: Robot, dt_s: float) -> Array:
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
    n, mice, beams = len(robot.wheels), len(robot.mice), robot.lidar.beams if robot.lidar else 0
    actuators = _actuators(robot, robot.control_period_s / steps)
    board = duty_curve.pack(robot.linearizer.wheels) if robot.linearizer else np.zeros(0)
    ahead = WHEELS + n * BLOCK + mice * MOUSE + 2 * beams
    motors = motor_blocks.pack(robot)
    chassis = Chassis.of(robot)
    trailing = kernel.arrays(chassis) if chassis.trails else np.zeros(0)
    model = np.concatenate([np.zeros(ahead), actuators, board, motors, trailing])
    model[CASTER_AT] = len(model) - len(trailing) if len(trailing) else 0
    model[MAP_AT] = ahead if len(actuators) else 0
    model[LINEARIZER_AT] = ahead + len(actuators) if len(board) else 0
    model[MOTORS_AT] = ahead + len(actuators) + len(board)
    model[SUBSTEPS] = motor_blocks.substeps(robot, robot.control_period_s / steps)
    model[N], model[M], model[MICE], model[STEPS] = n, len(robot.steered), mice, steps
    model[MICE_AT] = WHEELS + n * BLOCK
    model[BEAMS_AT] = model[MICE_AT] + mice * MOUSE
    model[ALIKE] = float(not robot.steered and len({wheel.motor.lag_s for wheel in robot.wheels}) == 1)
    _body(model, robot, robot.control_period_s / steps)
    _wheels(model, robot, robot.control_period_s / steps)
    if robot.imu:
        _imu(model, robot.imu)
    if robot.lidar:
        _lidar(model, robot.lidar)
    for k, mouse in enumerate(robot.mice):
        at = int(model[MICE_AT]) + k * MOUSE
        model[at : at + MOUSE] = (*mouse.mount, mouse.resolution_m, mouse.noise_relative, len(mouse.axes))
    return model


def beam_angles(model: Array) -> Array:
    """(b,) directions of the beams in the sensor's frame [rad]."""
    return np.asarray(model[FIRST_BEAM] + model[BEAM_STEP] * np.arange(int(model[BEAMS]), dtype=np.float64))


def _body(model: Array, robot: Robot, dt: float) -> None:
    model[DT], model[PERIOD], model[FOOTPRINT] = dt, robot.control_period_s, robot.footprint_radius_m
    model[MASS], model[INERTIA] = robot.mass_kg, robot.inertia_kg_m2
    model[COM_X], model[COM_Y] = robot.centre_of_mass
    model[SLIP_SPEED] = robot.ground.slip_speed_m_s
    battery, loop = robot.battery, robot.speed_loop
    model[BATTERY_V], model[BATTERY_R], model[BATTERY_C] = battery.voltage_v, battery.resistance_ohm, battery.capacity_c
    model[LOOP_KP], model[LOOP_KI] = loop.kp, loop.ki
    model[LOOP_FILTER] = 1.0 - lag_factors(loop.filter_s, robot.control_period_s)[0]
    model[LOOP_SHARE] = 1.0 - lag_factors(loop.filter_s, dt)[0]
    model[LOOP_AHEAD] = loop.feed_forward


def _wheels(model: Array, robot: Robot, dt: float) -> None:
    chassis, (cx, cy), ground = Chassis.of(robot), robot.centre_of_mass, robot.ground
    places = [(wheel.x, wheel.y) for wheel in robot.wheels]
    loads = wheel_loads(places, (cx, cy), robot.mass_kg * GRAVITY, robot.name)
    for i, (wheel, load) in enumerate(zip(robot.wheels, loads, strict=True)):
        w, motor, swerve = model[WHEELS + i * BLOCK :][:BLOCK], wheel.motor, wheel.kind == "swerve"
        w[STEERED] = robot.steered.index(i) if swerve else -1
        w[RADIUS], w[MAX_SPEED], w[YAW] = wheel.radius, wheel.max_speed_rad_s, wheel.yaw
        w[COUNTS] = wheel.encoder.counts_per_turn / (2.0 * math.pi) if wheel.encoder else math.nan
        w[COUNT_RAD], w[COUNT_SPEED] = 1.0 / w[COUNTS], 1.0 / (w[COUNTS] * robot.control_period_s)
        w[SLOWNESS], w[PER_NO_LOAD] = 1.0 / wheel.max_speed_rad_s, 1.0 / motor.no_load_speed_rad_s
        row = chassis.row[i]
        w[BACK : BACK + 3] = chassis.least_squares[:, row]
        if swerve:
            w[BACK_ACROSS : BACK_ACROSS + 3] = chassis.least_squares[:, row + 1]
        w[DECAY], w[MEAN] = lag_factors(motor.lag_s, dt)
        servo = wheel.steering
        w[TURN] = 1.0 - lag_factors(servo.lag_s, dt)[0] if servo else 1.0
        w[TURN_LIMIT] = servo.rate_rad_s * dt if servo else math.inf
        w[PX], w[PY] = wheel.x - cx, wheel.y - cy
        contact(w, wheel.yaw, wheel.yaw + (0.0 if swerve else wheel.roller))
        # a plain tyre grips sideways as well; a roller only resists
        w[GRIP] = ground.friction * load
        w[ROLLING] = (ground.friction if swerve else ground.roller_resistance) * load
        w[NO_LOAD], w[BACK_EMF], w[RESISTANCE] = motor.no_load_speed_rad_s, motor.back_emf_v_s_rad, motor.resistance_ohm
        w[REACTANCE], w[TORQUE] = motor.inductance_h / dt, motor.efficiency * motor.back_emf_v_s_rad
        w[COULOMB], w[VISCOUS] = motor.coulomb_friction_n_m, motor.viscous_friction_n_m_s_rad
        w[SPIN], w[LIMIT] = max(motor.inertia_kg_m2, 1e-9), motor.current_limit_a


def contact(w: Array, roll: float, traction: float) -> None:
    """Write the rows of a contact that rolls along `roll` [rad] and grips along `traction` [rad]."""
    ax, ay, ex, ey = math.cos(traction), math.sin(traction), math.cos(roll), math.sin(roll)
    w[TRACTION : TRACTION + 3] = ax, ay, w[PX] * ay - w[PY] * ax
    w[FREE : FREE + 3] = -ay, ax, w[PX] * ax + w[PY] * ay
    w[KAPPA_R], w[SIGMA_R] = (ax * ex + ay * ey) * w[RADIUS], (ax * ey - ay * ex) * w[RADIUS]


def _imu(model: Array, imu: Imu) -> None:
    model[IMU_RATE] = imu.rate_hz
    model[IMU_X], model[IMU_Y], model[IMU_THETA] = imu.mount
    model[GYRO_NOISE], model[GYRO_BIAS], model[GYRO_WALK] = (
        imu.gyro_noise_rad_s,
        imu.gyro_bias_rad_s,
        imu.gyro_bias_walk_rad_s,
    )
    model[ACCEL_NOISE] = imu.accel_noise_m_s2


def _lidar(model: Array, lidar: Lidar) -> None:
    whole = lidar.field_of_view_rad >= 2.0 * math.pi - 1e-9
    gaps = lidar.beams if whole else max(1, lidar.beams - 1)
    turn = -1.0 if lidar.clockwise else 1.0
    model[BEAMS] = lidar.beams
    model[LIDAR_X], model[LIDAR_Y], model[LIDAR_THETA] = lidar.mount
    model[FIRST_BEAM] = 0.0 if whole else -0.5 * turn * lidar.field_of_view_rad
    model[BEAM_STEP] = turn * min(lidar.field_of_view_rad, 2.0 * math.pi) / gaps
    model[SCAN_PERIOD] = 1.0 / lidar.rate_hz
    # the mirror turns evenly, so that a narrow field of view is seen in a part of the revolution only
    if lidar.motion_distortion:
        model[BEAM_PERIOD] = abs(model[BEAM_STEP]) / (2.0 * math.pi) / lidar.rate_hz
    model[RANGE_MIN], model[RANGE_MAX] = lidar.range_min, lidar.range_max
    model[RANGE_NOISE], model[RANGE_NOISE_RELATIVE], model[DROPOUT] = lidar.noise_m, lidar.noise_relative, lidar.dropout
    angles, at, beams = beam_angles(model), int(model[BEAMS_AT]), lidar.beams
    model[at : at + beams], model[at + beams : at + 2 * beams] = np.cos(angles), np.sin(angles)


def _actuators(robot: Robot, dt: float) -> Array:
    """The measured actuators of a robot as the header and curves of the plant "pwm_map"; empty without."""
    known = robot.pwm_map
    if known is None:
        return np.zeros(0)
    header = np.zeros(MAP_CURVES)
    header[MAP_COUNTS], header[MAP_VOLTAGE] = known.counts, known.voltage_v
    header[MAP_DEAD_TIME], header[MAP_DEAD_SPREAD] = known.dead_time_s, known.dead_time_spread_s
    header[MAP_DECAY], header[MAP_MEAN] = lag_factors(known.lag_s, dt)
    header[MAP_SPREAD], header[MAP_NOISE] = known.speed_spread, known.speed_noise
    return np.concatenate([header, duty_curve.pack(known.wheels)])
