"""One control period of a simulated robot: take a command, move, look. Base and roll-out call the same three."""

import math

import numpy as np

from holodrive import layout
from holodrive.actuators.duty_curve import duty_of
from holodrive.actuators.speed_loop import speed_loop_step
from holodrive.errors import InputError, UnknownName
from holodrive.kinematics import Chassis
from holodrive.leaf import leaf, set_all
from holodrive.robots.spec import Robot
from holodrive.sim import model as md
from holodrive.sim import motor_blocks
from holodrive.sim import state as st
from holodrive.sim.caster import carried_by_steering
from holodrive.sim.contact import free_distance, write_event
from holodrive.sim.first_order import first_order_period
from holodrive.sim.motors import motors_period
from holodrive.sim.pwm_map import pwm_map_period
from holodrive.sim.sensors import sense
from holodrive.sim.slip import slip_period
from holodrive.types import Array

FIRST_ORDER, SLIP, PWM_MAP, MOTORS = 0, 1, 2, 3  # plants
_DEAD = 1e-200
PLANTS = {"first_order": FIRST_ORDER, "slip": SLIP, "pwm_map": PWM_MAP, "motors": MOTORS}


@leaf
def start(model, obstacles, state, key, ranges, pending, x, y, theta):  # type: ignore[no-untyped-def]
    """Put a robot at rest at a pose at time 0 and read its sensors."""
    set_all(state, 0.0)
    state[st.POSE], state[st.POSE + 1], state[st.POSE + 2] = x, y, theta
    for i in range(3):
        state[st.TICK_POSE + i] = state[st.POSE + i]
    state[st.GYRO] = state[st.ACCEL] = state[st.ACCEL + 1] = state[st.SCAN_TIME] = math.nan
    state[st.VOLTAGE] = model[md.BATTERY_V]
    state[st.FREE] = free_distance(model, obstacles, state, 0.0)
    for i in range(int(model[md.N])):  # NaN without an encoder
        state[st.MEASURED + i] = 0.0 * model[md.WHEELS + i * md.BLOCK + md.COUNTS]
    set_all(ranges, math.nan)
    sense(model, obstacles, state, key, ranges, pending)


@leaf
def accept(model, state, events, values, steer, direct):  # type: ignore[no-untyped-def]
    """Take wheel speeds (n,) [rad/s], or duties when `direct`, and steering angles (m,) [rad] for the next period.

    A number that is not finite stops the robot for good (`state.FAULT`). Speeds over a wheel's limit are scaled
    down together, which keeps the direction; duties are cut at 1.
    """
    n, m = int(model[md.N]), int(model[md.M])
    load, total = 0.0, 0.0
    for i in range(n):
        total += values[i]
        load = max(load, abs(values[i]) * model[md.WHEELS + i * md.BLOCK + md.SLOWNESS])
    for j in range(m):
        total += steer[j]
    # a sum is finite only if all its terms are
    if not math.isfinite(total) and state[st.FAULT] == 0.0:
        state[st.FAULT] = 1.0
        write_event(state, events, state[st.TICK] * model[md.PERIOD], st.COMMAND_FAULT)
    state[st.DIRECT] = 0.0
    if state[st.FAULT] != 0.0:
        for i in range(n):
            state[st.COMMAND + i] = 0.0
        return
    if direct:
        state[st.DIRECT] = 1.0
        for i in range(n):
            state[st.COMMAND + i] = min(1.0, max(-1.0, values[i]))
    else:
        scale = 1.0 / load if load > 1.0 else 1.0
        for i in range(n):
            state[st.COMMAND + i] = scale * values[i]
    for j in range(m):
        state[st.STEER_COMMAND + j] = steer[j]


@leaf
def advance(plant, model, obstacles, state, events, key, ranges, pending):  # type: ignore[no-untyped-def]
    """One control period: speed loop, physics, sensors. The robot must not stand still in time afterwards."""
    if plant != MOTORS:  # the board of that plant runs within the period
        drive(model, state)
    if plant == PWM_MAP:
        drive_measured(model, state)
    for i in range(3):
        state[st.TICK_POSE + i] = state[st.POSE + i]
        state[st.TICK_TWIST + i] = state[st.TWIST + i]
    if plant == FIRST_ORDER:
        first_order_period(model, obstacles, state, events)
    elif plant == SLIP:
        slip_period(model, obstacles, state, events)
    elif plant == MOTORS:
        motors_period(model, obstacles, state, events)
    else:
        pwm_map_period(model, obstacles, state, events, key)
    flush(state, st.TWIST, 3)
    flush(state, st.WHEEL_SPEED, int(model[md.N]))
    flush(state, st.CURRENT, int(model[md.N]))
    state[st.TICK] += 1.0
    sense(model, obstacles, state, key, ranges, pending)


@leaf
def flush(state, first, count):  # type: ignore[no-untyped-def]
    """Make zero of what has died away: numbers below 1e-308 cost a hundred times the time of others."""
    for i in range(first, first + count):
        if abs(state[i]) < _DEAD:
            state[i] = 0.0


@leaf
def drive(model, state):  # type: ignore[no-untyped-def]
    """The motor board: wheel-speed commands to duties; by feed-forward alone where there is no encoder."""
    kp, ki, period = model[md.LOOP_KP], model[md.LOOP_KI], model[md.PERIOD]
    trails = model[md.CASTER_AT] > 0.0
    for i in range(int(model[md.N])):
        w, command = md.WHEELS + i * md.BLOCK, state[st.COMMAND + i]
        if trails and state[st.DIRECT] == 0.0:
            # the steering turns the wheel against its drive, as fast as it did when the board last looked
            command += carried_by_steering(model, state, i)
        unit = model[w + md.PER_NO_LOAD]
        if state[st.DIRECT] != 0.0:
            state[st.DUTY + i], state[st.INTEGRAL + i] = command, 0.0
        elif math.isnan(model[w + md.COUNT_RAD]):
            state[st.DUTY + i] = min(1.0, max(-1.0, command * unit))
        else:
            state[st.DUTY + i], state[st.INTEGRAL + i] = speed_loop_step(
                command, state[st.MEASURED + i], state[st.INTEGRAL + i], unit, kp, ki, period, model[md.LOOP_AHEAD]
            )


@leaf
def drive_measured(model, state):  # type: ignore[no-untyped-def]
    """The board of measured actuators: the linearizer instead of the straight feed-forward, and whole PWM counts.

    What the speed loop adds to its feed-forward is kept; without encoder it adds nothing. The plants with linear
    motors need no linearizer, so this is for the plant "pwm_map" alone.
    """
    counts, board = model[int(model[md.MAP_AT]) + md.MAP_COUNTS], int(model[md.LINEARIZER_AT])
    for i in range(int(model[md.N])):
        w, command, duty = md.WHEELS + i * md.BLOCK, state[st.COMMAND + i], state[st.DUTY + i]
        if board > 0 and state[st.DIRECT] == 0.0 and command != 0.0:
            if math.isnan(model[w + md.COUNT_RAD]):
                trim = 0.0
            else:
                trim = state[st.INTEGRAL + i] + model[md.LOOP_KP] * (command - state[st.MEASURED + i])
            duty = duty_of(model, board, i, command) + trim * model[w + md.PER_NO_LOAD]
        state[st.DUTY + i] = min(1.0, max(-1.0, np.rint(duty * counts) / counts))


@leaf
def fill(model, state, ranges, obs):  # type: ignore[no-untyped-def]
    """Write what the sensors tell into a flat observation (`holodrive.layout`); belief and wish stay as they are."""
    obs[layout.TIME], obs[layout.DT] = state[st.TICK] * model[md.PERIOD], model[md.PERIOD]
    obs[layout.GYRO] = state[st.GYRO]
    obs[layout.ACCEL], obs[layout.ACCEL + 1] = state[st.ACCEL], state[st.ACCEL + 1]
    n, m = int(model[md.N]), int(model[md.M])
    obs[layout.N_WHEELS], obs[layout.N_STEER] = n, m
    for i in range(n):
        obs[layout.WHEEL_POSITION + i] = state[st.COUNT + i] * model[md.WHEELS + i * md.BLOCK + md.COUNT_RAD]
        obs[layout.WHEEL_SPEED + i] = state[st.MEASURED + i]
    for j in range(m):
        obs[layout.STEER + j] = state[st.STEER + j]
    mice = int(model[md.MICE])
    obs[layout.N_MICE] = mice
    for k in range(2 * mice):
        obs[layout.MICE + k] = state[st.MICE + k]
    fresh = state[st.SCAN_IS_NEW]
    obs[layout.SCAN_IS_NEW], obs[layout.SCAN_TIME] = fresh, state[st.SCAN_TIME]
    if fresh != 0.0:
        obs[layout.N_BEAMS], obs[layout.BEAM_FIRST] = model[md.BEAMS], model[md.FIRST_BEAM]
        obs[layout.BEAM_STEP], obs[layout.BEAM_PERIOD] = model[md.BEAM_STEP], model[md.BEAM_PERIOD]
        for i in range(ranges.shape[0]):
            obs[layout.BEAMS + i] = ranges[i]


def plant_number(robot: Robot, plant: str) -> int:
    """The plant's number in the kernels.

    Raises:
        UnknownName: no such plant.
        InputError: the robot's actuators were never measured, which "pwm_map" needs, or it has casters, which that
            plant does not know, or its motors are not described well enough for "motors".
    """
    if plant not in PLANTS:
        raise UnknownName("plant", plant, PLANTS)
    if plant == "pwm_map" and robot.pwm_map is None:
        raise InputError(
            f"{robot.name} has no [pwm_map], which the plant pwm_map simulates; add one to its file, "
            "or choose the plant first_order, slip or motors"
        )
    if plant == "pwm_map" and Chassis.of(robot).trails:
        raise InputError(
            f"{robot.name} has wheels with caster or coupling, which the plant pwm_map does not simulate; "
            "choose the plant first_order, slip or motors"
        )
    if plant == "motors":
        motor_blocks.check(robot)
    return PLANTS[plant]


def state_size(plant: int, model: Array) -> int:
    """How long the state row of one robot is."""
    return st.MOTOR + st.MOTOR_ROW * int(model[md.N] + model[md.M]) if plant == MOTORS else st.SIZE


def scratch(plant: int, model: Array, events: int = 64) -> tuple[Array, Array, Array, Array]:
    """State row, event table, newest scan and scan under way of one robot."""
    beams = int(model[md.BEAMS])
    return (
        np.zeros(state_size(plant, model)),
        np.zeros((events, st.EVENT_SIZE)),
        np.full(beams, math.nan),
        np.zeros(beams),
    )
