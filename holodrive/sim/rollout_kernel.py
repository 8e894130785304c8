"""The roll-out: the whole closed loop of many robots in one compiled function.

It is compiled for one explicit signature when this module is first imported (some seconds, once; then it comes from
the cache) and takes controller and estimator as first-class functions, so that a user's own kernel runs at once.
Robots know nothing of one another: any cut into chunks, on any number of threads, gives the same bits.
"""

import math
from typing import Any

import numpy as np
from numba import float64, int64, njit, types, uint64, void

from holodrive import layout, metrics
from holodrive.kinematics.kernel import command_step
from holodrive.leaf import borrowed, leaf, set_all
from holodrive.references import MEMORY_SIZE, OUT_SIZE, reference_step
from holodrive.sim import model as md
from holodrive.sim import state as st
from holodrive.sim.contact import free_distance
from holodrive.sim.period import MOTORS, SLIP, accept, advance, fill
from holodrive.sim.period import start as put_at

TWIST, WHEELS, DUTY = 0, 1, 2  # kinds of command
KINDS = {"twist": TWIST, "wheels": WHEELS, "duty": DUTY}

# columns of a log; after them wheel commands (n), measured wheel speeds (n), duties (n), steering angles (m);
# on the plant "motors" then current, torque, electrical and mechanical power of each drive and steering
LOG_TIME, LOG_POSE, LOG_ESTIMATE, LOG_REFERENCE, LOG_TWIST, LOG_WHEELS = 0, 1, 4, 7, 10, 13


VECTOR, TABLE, CUBE = float64[::1], float64[:, ::1], float64[:, :, ::1]
PLUG: Any = types.FunctionType(void(VECTOR, VECTOR, VECTOR, VECTOR))
_UNI_TUPLE: Any = types.UniTuple
SWITCHES = _UNI_TUPLE(int64, 7)
SIGNATURE: Any = void(
    PLUG,  # controller
    PLUG,  # estimator
    SWITCHES,  # estimate is truth, plant, command, reference kind, ticks, stop on arrival, log every
    VECTOR,  # model of the robot
    VECTOR,  # obstacles
    VECTOR,  # kinematics
    int64[::1],  # robots to run
    TABLE,  # (n, 3) starts
    uint64[::1],  # (n,) keys of the random streams
    TABLE,  # (n, p) controller parameters
    VECTOR,  # estimator parameters
    int64[::1],  # sizes of memory: controller, estimator, pipeline
    TABLE,  # rows of all references
    types.Array(int64, 2, "C"),  # (n, 2) first row, end
    CUBE,  # (n, T, k) log
    TABLE,  # (n, metrics.SIZE)
    CUBE,  # (n, E, st.EVENT_SIZE) events
    TABLE,  # (n, st.SIZE) final states
)


@leaf
def write_log(model, state, obs, row):  # type: ignore[no-untyped-def]
    """One row of a log, after the tick that it tells of."""
    row[LOG_TIME] = obs[layout.TIME]
    for i in range(3):
        row[LOG_POSE + i] = state[st.TICK_POSE + i]
        row[LOG_ESTIMATE + i] = obs[layout.POSE + i]
        row[LOG_REFERENCE + i] = obs[layout.REF_POSE + i]
        row[LOG_TWIST + i] = state[st.TICK_TWIST + i]
    n = int(model[md.N])
    for i in range(n):
        row[LOG_WHEELS + i] = state[st.COMMAND + i]
        row[LOG_WHEELS + n + i] = obs[layout.WHEEL_SPEED + i]
        row[LOG_WHEELS + 2 * n + i] = state[st.DUTY + i]
    m = int(model[md.M])
    for j in range(m):
        row[LOG_WHEELS + 3 * n + j] = obs[layout.STEER + j]
    first, each = LOG_WHEELS + 3 * n + m, 4
    for k in range((row.shape[0] - first) // each):
        at = st.MOTOR + k * st.MOTOR_ROW + st.MOTOR_CURRENT
        for i in range(each):
            row[first + each * k + i] = state[at + i]


@leaf
def look_around(model, obstacles, state, acc):  # type: ignore[no-untyped-def]
    """Least clearance so far; asked of the world only where the robot may have come nearer than ever."""
    if state[st.FREE] < acc[metrics.CLEARANCE]:
        gap = free_distance(model, obstacles, state, state[st.TICK] * model[md.PERIOD])
        state[st.FREE] = gap
        acc[metrics.CLEARANCE] = min(gap, acc[metrics.CLEARANCE])


@leaf
def send(model, state, events, kind, kin, command, wanted, pipe, speeds, steer):  # type: ignore[no-untyped-def]
    """A controller's command to the wheels: through the limit - discretise - invert pipeline when it is a twist."""
    if kind == TWIST:
        finite = not math.isnan(command_step(kin, wanted, model[md.PERIOD], pipe, speeds, steer))
        if finite and state[st.FAULT] == 0.0:
            # the pipeline keeps to the wheels' limits, so there is nothing that `accept` would change
            state[st.DIRECT] = 0.0
            for i in range(int(model[md.N])):
                state[st.COMMAND + i] = speeds[i]
            for j in range(int(model[md.M])):
                state[st.STEER_COMMAND + j] = steer[j]
        elif not finite:
            speeds[0] = math.nan
            accept(model, state, events, speeds, steer, False)
        return
    for i in range(int(model[md.N])):
        speeds[i] = command[layout.VALUE + i]
    for j in range(int(model[md.M])):
        steer[j] = command[layout.COMMAND_STEER + j]
    accept(model, state, events, speeds, steer, kind == DUTY)


@leaf
def run_robot(  # type: ignore[no-untyped-def]
    controller, estimator, switches, model, obstacles, kin, key, start, params, estimator_params, rows, log, acc,
    events, state, ranges, pending, obs, memory, belief_memory, pipe, speeds, steer, belief, command, reference,
    reference_memory,
):  # fmt: skip
    """One robot's run: observe, estimate, reference, command, apply, record, as the ordinary loop does."""
    truth, plant, command_kind, reference_kind, ticks, stop_on_arrival, log_every = switches
    # the caller holds them all; see `borrowed`
    model, obstacles, kin, params = borrowed(model), borrowed(obstacles), borrowed(kin), borrowed(params)
    estimator_params, rows, log, acc = borrowed(estimator_params), borrowed(rows), borrowed(log), borrowed(acc)
    events, state, ranges, pending = borrowed(events), borrowed(state), borrowed(ranges), borrowed(pending)
    obs, memory, belief_memory, pipe = borrowed(obs), borrowed(memory), borrowed(belief_memory), borrowed(pipe)
    speeds, steer, belief, command = borrowed(speeds), borrowed(steer), borrowed(belief), borrowed(command)
    reference, reference_memory = borrowed(reference), borrowed(reference_memory)
    put_at(model, obstacles, state, key, ranges, pending, start[0], start[1], start[2])
    for array in (obs, memory, belief_memory, pipe, reference_memory, belief):
        set_all(array, 0.0)
    for i in range(3):
        belief_memory[layout.START_POSE + i] = start[i]
    metrics.start(acc)
    pose, duty = state[st.POSE : st.POSE + 3], state[st.DUTY : st.DUTY + speeds.shape[0]]
    wanted = command[layout.VALUE : layout.VALUE + 3]
    for k in range(ticks):
        fill(model, state, ranges, obs)
        if truth:
            for i in range(6):
                belief[i] = state[st.POSE + i]
        else:
            estimator(obs, belief_memory, estimator_params, belief)
        for i in range(6):
            obs[layout.POSE + i] = belief[i]
        reference_step(rows, reference_kind, reference_memory, obs[layout.TIME], belief[0], belief[1], reference)
        for i in range(OUT_SIZE):
            obs[layout.REF_POSE + i] = reference[i]
        set_all(command, 0.0)
        controller(obs, memory, params, command)
        metrics.count_no_rule(acc, command[layout.NO_RULE])
        look_around(model, obstacles, state, acc)
        metrics.tick(acc, obs[layout.TIME], pose, reference)
        send(model, state, events, command_kind, kin, command, wanted, pipe, speeds, steer)
        advance(plant, model, obstacles, state, events, key, ranges, pending)
        metrics.count_duty(acc, duty)
        if log.shape[0] > 0 and k % log_every == 0:
            write_log(model, state, obs, log[k // log_every])
        if command[layout.ARRIVED] != 0.0:
            acc[metrics.ARRIVED] = 1.0
        if stop_on_arrival and command[layout.ARRIVED] != 0.0:
            break
    acc[metrics.COLLISIONS], acc[metrics.MOVED_COLLISIONS] = state[st.COLLISIONS], state[st.MOVED_COLLISIONS]
    acc[metrics.ENERGY] = state[st.ENERGY] if plant in (SLIP, MOTORS) else math.nan
    metrics.finish(acc)


@njit(SIGNATURE, cache=True, nogil=True, error_model="numpy")
def run_robots(  # type: ignore[no-untyped-def]
    controller, estimator, switches, model, obstacles, kin, robots, starts, keys, params, estimator_params,
    memory_sizes, reference_rows, reference_bounds, log, accs, event_tables, states,
):  # fmt: skip
    """Run some robots of a batch one after another, with one set of scratch arrays."""
    beams, n, m = int(model[md.BEAMS]), int(model[md.N]), int(model[md.M])
    ranges, pending, obs = np.empty(beams), np.empty(beams), np.empty(layout.OBS_HEADER + beams)
    memory, belief_memory = np.empty(max(1, memory_sizes[0])), np.empty(max(3, memory_sizes[1]))
    pipe, speeds, steer = np.empty(memory_sizes[2]), np.empty(n), np.empty(m)
    belief, command = np.zeros(layout.ESTIMATE_SIZE), np.zeros(layout.COMMAND_SIZE)
    reference, reference_memory = np.zeros(OUT_SIZE), np.zeros(MEMORY_SIZE)
    for robot in robots:
        rows = reference_rows[reference_bounds[robot, 0] : reference_bounds[robot, 1]]
        run_robot(
            controller, estimator, switches, model, obstacles, kin, keys[robot], starts[robot], params[robot],
            estimator_params, rows, log[robot], accs[robot], event_tables[robot], states[robot], ranges, pending, obs,
            memory, belief_memory, pipe, speeds, steer, belief, command, reference, reference_memory,
        )  # fmt: skip


@njit(cache=True)
def no_plug(obs, memory, params, out):  # type: ignore[no-untyped-def]
    """Stands where no estimator is asked for."""
    out[0] = 0.0
