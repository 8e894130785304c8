"""The plant of motors: each drive and each steering with its own electromechanics, sub-stepped; no slip.

    D_k dq_k/dt = eta g T_k - drag_k(q_k) q_k - G_k . f,   f = M dxi/dt,   xi = sum_k G_k q_k

q are the speeds of the output shafts (drives, then steerings), D what turns with each, T the torque at the rotor
behind a gear of g to 1, xi the twist of the centre of mass that the wheels make, M the robot's mass and inertia, f
what the body's inertia puts against the shafts. The body moves as its wheels say, by least squares (as on the plant
"first_order"), and G are the columns of that map at the present steering angles; so in a straight line n wheels
carry m r^2 / n each, and in a turn on the spot I r^2 / sum |p|^2. All shafts of one sub-step are solved together,

    f = (M^-1 + G D^-1 G^T)^-1 G D^-1 t,   t the torques of motors and friction.

When the modules turn, the same shafts make another twist: the body keeps its momentum, and the shafts take what that
costs. So a robot that spins while it drives straight needs no force for it.

The board runs once a physics step. It holds the command of the control tick, and its loops are those of
`actuators.speed_loop` (drives) and of `robots.spec.Steering`: voltage = kp (target - angle) - kd rate.
"""

import math

from holodrive.actuators.averaged import averaged_substep
from holodrive.actuators.bldc import (
    BACK_EMF,
    COPPER_J,
    CURRENT_A,
    CURRENT_B,
    CURRENT_C,
    EFFICIENCY,
    GEAR,
    HELD_D,
    HELD_Q,
    INDUCTANCE,
    INPUT_J,
    RESISTANCE,
)
from holodrive.actuators.dc_motor import bus_voltage, dry_friction
from holodrive.actuators.foc import foc_substep, torque_of_duty
from holodrive.actuators.six_step import six_step_substep
from holodrive.actuators.speed_loop import speed_loop_step
from holodrive.leaf import leaf
from holodrive.sim import model as md
from holodrive.sim import motor_blocks as mb
from holodrive.sim import state as st
from holodrive.sim.caster import lever, trail
from holodrive.sim.first_order import servo_step, with_wheel
from holodrive.sim.roll import roll, stand
from holodrive.sim.turn import turn_factors

_SLEWS = 0.95  # of the fastest steering: from there on a module slews
_LEAST_BUS = 1e-3  # of the battery's voltage: windings may want more current than it can ever give
_DEAD = 1e-200  # A, V, rad/s


@leaf
def motors_period(model, obstacles, state, events):  # type: ignore[no-untyped-def]
    """One control period of physics steps with the commands in `state`."""
    n, m = int(model[md.N]), int(model[md.M])
    stand(state)
    for k in range(int(model[md.STEPS])):
        board(model, state, n, m, k * model[md.DT])
        levers(model, state, n, m)
        vx, vy, omega = shafts(model, state, n, m)
        roll(model, obstacles, state, events, k, vx, vy, omega)
    tell(model, state, n, m)


@leaf
def conductance(model, state, count, h):  # type: ignore[no-untyped-def]
    """How much more the drivers draw for each volt more, within a sub-step of `h` [s], at this step's duties [S]."""
    per_volt = 0.0
    for k in range(count):
        at, p = st.MOTOR + k * st.MOTOR_ROW, int(model[md.MOTORS_AT]) + k * mb.BLOCK
        if model[p + mb.KIND] != mb.SERVO:
            duty, r, react = state[at + st.MOTOR_DUTY], model[p + RESISTANCE], model[p + INDUCTANCE] / h
            # a current loop brings its current to duty times voltage over R at once, with the voltage that takes
            per_volt += duty * duty * ((r + react) / (r * r) if model[p + mb.KIND] == mb.FOC else 1.0 / (r + react))
    return per_volt


@leaf
def board(model, state, n, m, since):  # type: ignore[no-untyped-def]
    """The duties of this physics step, which begins `since` [s] after the control tick."""
    for j in range(m):
        steer_loop(model, state, n, j, since)
    for i in range(n):
        drive_loop(model, state, n, i)


@leaf
def drive_loop(model, state, n, i):  # type: ignore[no-untyped-def]
    """Duty of one drive; by feed-forward alone where the wheel's speed is not measured."""
    at, p, w = st.MOTOR + i * st.MOTOR_ROW, int(model[md.MOTORS_AT]) + i * mb.BLOCK, md.WHEELS + i * md.BLOCK
    command, unit, j = state[st.COMMAND + i], model[w + md.PER_NO_LOAD], int(model[w + md.STEERED])
    if j >= 0 and state[st.DIRECT] == 0.0:  # the steering turns the wheel against its drive, which makes up for it
        command += model[p + mb.COUPLING] * state[st.MOTOR + (n + j) * st.MOTOR_ROW + st.MOTOR_SPEED]
    measured = state[at + st.MOTOR_MEASURED]
    measured += model[md.LOOP_SHARE] * (state[at + st.MOTOR_SPEED] - measured)
    state[at + st.MOTOR_MEASURED] = measured
    if state[st.DIRECT] != 0.0:
        duty, state[at + st.MOTOR_INTEGRAL] = command, 0.0
    elif math.isnan(model[w + md.COUNT_RAD]):
        duty = command * unit
    else:
        duty, state[at + st.MOTOR_INTEGRAL] = speed_loop_step(
            command,
            measured,
            state[at + st.MOTOR_INTEGRAL],
            unit,
            model[md.LOOP_KP],
            model[md.LOOP_KI],
            model[md.DT],
            model[md.LOOP_AHEAD],
        )
    duty = min(1.0, max(-1.0, duty))
    state[at + st.MOTOR_DUTY] = state[st.DUTY + i] = duty


@leaf
def steer_loop(model, state, n, j, since):  # type: ignore[no-untyped-def]
    """Duty of one steering motor, towards a target that moves at no more than the steering's rate.

    With feed-forward, a target whose commands move evenly moves on within the control tick, so that its mean is what
    was commanded, and the rate's own voltage is added: a module that turns steadily follows without lag. A module that
    slews to a new direction has no feed-forward, which would carry it beyond.
    """
    at, p = st.MOTOR + (n + j) * st.MOTOR_ROW, int(model[md.MOTORS_AT]) + (n + j) * mb.BLOCK
    command, rate, ahead = state[st.STEER_COMMAND + j], model[p + mb.RATE], model[md.LOOP_AHEAD]
    period, dt = model[md.PERIOD], model[md.DT]
    if since == 0.0:
        moving = (command - state[at + st.MOTOR_LAST]) / period
        state[at + st.MOTOR_MOVING] = even_rate(moving, state[at + st.MOTOR_RATE], _SLEWS * rate)
        state[at + st.MOTOR_LAST], state[at + st.MOTOR_RATE] = command, moving
    if model[p + mb.KIND] == mb.SERVO:
        return
    moving, old = ahead * state[at + st.MOTOR_MOVING], state[at + st.MOTOR_TARGET]
    goal = command + moving * (since - 0.5 * period)
    target = old + min(rate * dt, max(-rate * dt, goal - old))
    state[at + st.MOTOR_TARGET] = target
    volts = model[p + mb.KP] * (target - state[st.STEER + j]) - model[p + mb.KD] * state[at + st.MOTOR_SPEED]
    volts += moving * (model[p + mb.KD] + model[p + mb.AHEAD])
    state[at + st.MOTOR_DUTY] = min(1.0, max(-1.0, volts / model[p + mb.NOMINAL]))


@leaf
def even_rate(now, before, limit):  # type: ignore[no-untyped-def]
    """The rate [rad/s] that two ticks have in common; 0 where one of them slews, for a slew ends without notice."""
    if now * before <= 0.0 or max(abs(now), abs(before)) >= limit:
        return 0.0
    return now if abs(now) < abs(before) else before


@leaf
def levers(model, state, n, m):  # type: ignore[no-untyped-def]
    """What each shaft makes of the body's motion in this step, at the steering angles of its middle.

    Servos move here; angles in `state` stand at the middle of the step until `shafts` has taken it.
    """
    dt = model[md.DT]
    for j in range(m):
        at, p = st.MOTOR + (n + j) * st.MOTOR_ROW, int(model[md.MOTORS_AT]) + (n + j) * mb.BLOCK
        old = state[st.STEER + j]
        state[at + st.MOTOR_FROM] = old
        if model[p + mb.KIND] == mb.SERVO:
            servo_step(model, state, md.WHEELS + int(model[p + mb.PLACE]) * md.BLOCK)
            state[at + st.MOTOR_SPEED] = (state[st.STEER + j] - old) / dt
        state[st.STEER + j] = old + 0.5 * dt * state[at + st.MOTOR_SPEED]
    for i in range(n):
        lever_of_wheel(model, state, n, i)
    join(model, state, n + m)
    carry(model, state, n + m)


@leaf
def lever_of_wheel(model, state, n, i):  # type: ignore[no-untyped-def]
    """What the drive of wheel i, and its steering, make of the body's motion: by caster and by coupling."""
    w, place = md.WHEELS + i * md.BLOCK, st.MOTOR + i * st.MOTOR_ROW + st.MOTOR_LEVER
    j, trails = int(model[w + md.STEERED]), model[md.CASTER_AT] > 0.0
    if trails:
        gx, gy, gw = lever(model, state, i, model[w + md.RADIUS] if j >= 0 else 1.0, 0.0)
    else:
        gx, gy, gw = with_wheel(model, state, w, 1.0, 0.0, 0.0, 0.0)
    write_lever(model, state, place, gx, gy, gw)
    if trails and j >= 0:
        back = model[int(model[md.MOTORS_AT]) + i * mb.BLOCK + mb.COUPLING]
        sx, sy, sw = lever(model, state, i, 0.0, trail(model, i))
        place = st.MOTOR + (n + j) * st.MOTOR_ROW + st.MOTOR_LEVER
        write_lever(model, state, place, sx - back * gx, sy - back * gy, sw - back * gw)


@leaf
def write_lever(model, state, place, x, y, w):  # type: ignore[no-untyped-def]
    """A shaft's twist of `base_link` as that of the centre of mass."""
    state[place], state[place + 1], state[place + 2] = x - w * model[md.COM_Y], y + w * model[md.COM_X], w


@leaf
def join(model, state, count):  # type: ignore[no-untyped-def]
    """(M^-1 + G D^-1 G^T)^-1, upper triangle into `state`: mass of the body that the shafts feel together."""
    a11 = a22 = 1.0 / model[md.MASS]
    a33, a12, a13, a23 = 1.0 / model[md.INERTIA], 0.0, 0.0, 0.0
    for k in range(count):
        p, g = int(model[md.MOTORS_AT]) + k * mb.BLOCK, st.MOTOR + k * st.MOTOR_ROW + st.MOTOR_LEVER
        if model[p + mb.KIND] != mb.SERVO:
            ease, gx, gy, gw = 1.0 / model[p + mb.INERTIA], state[g], state[g + 1], state[g + 2]
            a11, a22, a33 = a11 + ease * gx * gx, a22 + ease * gy * gy, a33 + ease * gw * gw
            a12, a13, a23 = a12 + ease * gx * gy, a13 + ease * gx * gw, a23 + ease * gy * gw
    c11, c12, c13 = a22 * a33 - a23 * a23, a13 * a23 - a12 * a33, a12 * a23 - a13 * a22
    part = 1.0 / (a11 * c11 + a12 * c12 + a13 * c13)
    state[st.MASS], state[st.MASS + 1], state[st.MASS + 2] = part * c11, part * c12, part * c13
    state[st.MASS + 3] = part * (a11 * a33 - a13 * a13)
    state[st.MASS + 4] = part * (a12 * a13 - a11 * a23)
    state[st.MASS + 5] = part * (a11 * a22 - a12 * a12)


@leaf
def felt(state, x, y, w):  # type: ignore[no-untyped-def]
    """The matrix of `join` times a vector."""
    m11, m12, m13 = state[st.MASS], state[st.MASS + 1], state[st.MASS + 2]
    m22, m23, m33 = state[st.MASS + 3], state[st.MASS + 4], state[st.MASS + 5]
    return m11 * x + m12 * y + m13 * w, m12 * x + m22 * y + m23 * w, m13 * x + m23 * y + m33 * w


@leaf
def carry(model, state, count):  # type: ignore[no-untyped-def]
    """Bring the body's momentum from the last step, and the last angles, over to these: an impulse on all shafts."""
    cx, cy, cw = state[st.CARRIED], state[st.CARRIED + 1], state[st.CARRIED + 2]
    sine, versine = turn_factors(cw * model[md.DT])
    sine, versine = sine * cw * model[md.DT], versine * cw * model[md.DT]
    x, y = cx - versine * cx + sine * cy, cy - versine * cy - sine * cx  # the same velocity in axes that have turned
    mx, my, mw = made(state, count)
    fx, fy, fw = felt(state, x - mx, y - my, cw - mw)
    for k in range(count):
        at, p = st.MOTOR + k * st.MOTOR_ROW, int(model[md.MOTORS_AT]) + k * mb.BLOCK
        if model[p + mb.KIND] != mb.SERVO:
            state[at + st.MOTOR_SPEED] += against(state, at, fx, fy, fw) / model[p + mb.INERTIA]


@leaf
def made(state, count):  # type: ignore[no-untyped-def]
    """Twist (3) of the centre of mass that all shafts make."""
    x = y = w = 0.0
    for k in range(count):
        at = st.MOTOR + k * st.MOTOR_ROW
        g, speed = at + st.MOTOR_LEVER, state[at + st.MOTOR_SPEED]
        x, y, w = x + state[g] * speed, y + state[g + 1] * speed, w + state[g + 2] * speed
    return x, y, w


@leaf
def against(state, at, fx, fy, fw):  # type: ignore[no-untyped-def]
    """Torque [N m] of a wrench at the centre of mass about the shaft of a row."""
    g = at + st.MOTOR_LEVER
    return state[g] * fx + state[g + 1] * fy + state[g + 2] * fw


@leaf
def shafts(model, state, n, m):  # type: ignore[no-untyped-def]
    """All motors over one physics step; returns the body's mean twist (3), `base_link` axes.

    The battery sags by what the drivers drew in the sub-step before, and by what its own change of voltage makes of
    that, so that a weak one does not swing. What braking gives back is burnt, not stored.
    """
    count, dt, parts = n + m, model[md.DT], int(model[md.SUBSTEPS])
    for k in range(count):
        state[st.MOTOR + k * st.MOTOR_ROW + st.MOTOR_TURNED] = 0.0
    h, spent, bus, drawn = dt / parts, 0.0, state[st.VOLTAGE], state[st.BUS_CURRENT]
    full = model[md.BATTERY_V] if state[st.CHARGE] < model[md.BATTERY_C] else 0.0
    per_volt = conductance(model, state, count, h)
    for _ in range(parts):
        bus = max(_LEAST_BUS * full, bus_voltage(full, model[md.BATTERY_R], drawn - per_volt * bus, per_volt))
        taken = substep(model, state, count, bus, h)
        spent += taken
        drawn = max(0.0, taken) / (h * bus) if bus > 0.0 else 0.0
    state[st.VOLTAGE], state[st.BUS_CURRENT] = bus, drawn
    x = y = w = 0.0
    for k in range(count):
        at = st.MOTOR + k * st.MOTOR_ROW
        if model[int(model[md.MOTORS_AT]) + k * mb.BLOCK + mb.KIND] == mb.SERVO:
            state[at + st.MOTOR_TURNED] = state[at + st.MOTOR_SPEED] * dt
        g, mean = at + st.MOTOR_LEVER, state[at + st.MOTOR_TURNED] / dt
        x, y, w = x + state[g] * mean, y + state[g + 1] * mean, w + state[g + 2] * mean
    state[st.CARRIED], state[st.CARRIED + 1], state[st.CARRIED + 2] = made(state, count)
    settle(model, state, n, m)
    state[st.CHARGE] += max(0.0, spent) / bus if bus > 0.0 else 0.0
    state[st.ENERGY] += max(0.0, spent)
    return x + w * model[md.COM_Y], y - w * model[md.COM_X], w


@leaf
def settle(model, state, n, m):  # type: ignore[no-untyped-def]
    """Angles and speeds of wheels and modules at the end of a step, from those of their shafts."""
    for j in range(m):
        at = st.MOTOR + (n + j) * st.MOTOR_ROW
        state[st.STEER + j] = state[at + st.MOTOR_FROM] + state[at + st.MOTOR_TURNED]
        if model[md.CASTER_AT] > 0.0:
            state[st.STEER_RATE + j] = state[at + st.MOTOR_SPEED]
    for i in range(n):
        at, p = st.MOTOR + i * st.MOTOR_ROW, int(model[md.MOTORS_AT]) + i * mb.BLOCK
        speed, turned, j = (
            state[at + st.MOTOR_SPEED],
            state[at + st.MOTOR_TURNED],
            int(model[md.WHEELS + i * md.BLOCK + md.STEERED]),
        )
        if j >= 0:
            steering = st.MOTOR + (n + j) * st.MOTOR_ROW
            speed -= model[p + mb.COUPLING] * state[steering + st.MOTOR_SPEED]
            turned -= model[p + mb.COUPLING] * state[steering + st.MOTOR_TURNED]
        state[st.WHEEL_SPEED + i] = speed
        state[st.WHEEL_ANGLE + i] += turned


@leaf
def substep(model, state, count, bus, h):  # type: ignore[no-untyped-def]
    """Currents and speeds of all shafts over `h` [s]: torques first, then all accelerations together.

    Returns the energy that the drivers took [J].
    """
    x = y = w = taken = 0.0
    for k in range(count):
        at, p = st.MOTOR + k * st.MOTOR_ROW, int(model[md.MOTORS_AT]) + k * mb.BLOCK
        kind = model[p + mb.KIND]
        if kind == mb.SERVO:
            continue
        taken -= state[at + INPUT_J]
        middle = state[at + st.MOTOR_SPEED] + 0.5 * h * state[at + st.MOTOR_ACCEL]
        rotor, duty = middle * model[p + GEAR], state[at + st.MOTOR_DUTY]
        if kind == mb.SIX_STEP:
            torque = six_step_substep(state, at, model, p, duty, bus, rotor, h)
        elif kind == mb.FOC:
            demand = torque_of_duty(model, p, duty, bus, rotor)
            torque = foc_substep(state, at, model, p, demand, bus, rotor, h)
        else:
            torque = averaged_substep(state, at, model, p, duty, bus, rotor, h)
        taken += state[at + INPUT_J]
        drag = model[p + mb.VISCOUS]
        if model[p + mb.COULOMB] > 0.0:
            drag += dry_friction(model[p + mb.COULOMB], middle)
        push = model[p + EFFICIENCY] * model[p + GEAR] * torque
        # implicit in the shaft's own friction, so that a stiff one cannot swing
        share = (push - drag * state[at + st.MOTOR_SPEED]) / (model[p + mb.INERTIA] + 0.5 * h * drag)
        state[at + st.MOTOR_READY] = share * model[p + mb.INERTIA]
        state[at + st.MOTOR_IMPULSE] += torque * h
        g = at + st.MOTOR_LEVER
        x, y, w = x + state[g] * share, y + state[g + 1] * share, w + state[g + 2] * share
    fx, fy, fw = felt(state, x, y, w)
    for k in range(count):
        at, p = st.MOTOR + k * st.MOTOR_ROW, int(model[md.MOTORS_AT]) + k * mb.BLOCK
        if model[p + mb.KIND] != mb.SERVO:
            accel = (state[at + st.MOTOR_READY] - against(state, at, fx, fy, fw)) / model[p + mb.INERTIA]
            turned = h * (state[at + st.MOTOR_SPEED] + 0.5 * h * accel)
            state[at + st.MOTOR_TURNED] += turned
            state[at + st.MOTOR_SHAFT_J] += turned * state[at + st.MOTOR_READY]
            state[at + st.MOTOR_SPEED] += h * accel
            state[at + st.MOTOR_ACCEL] = accel
    return taken


@leaf
def tell(model, state, n, m):  # type: ignore[no-untyped-def]
    """What the motors did in the control period, and sums since start; what has died away becomes zero."""
    period = model[md.PERIOD]
    for k in range(n + m):
        at, p = st.MOTOR + k * st.MOTOR_ROW, int(model[md.MOTORS_AT]) + k * mb.BLOCK
        if model[p + mb.KIND] == mb.SERVO:
            for i in range(st.MOTOR_CURRENT, st.MOTOR_OUTPUT_J + 1):
                state[at + i] = math.nan
            continue
        for i in (CURRENT_A, CURRENT_B, CURRENT_C, HELD_D, HELD_Q, st.MOTOR_SPEED, st.MOTOR_ACCEL):
            if abs(state[at + i]) < _DEAD:
                state[at + i] = 0.0
        state[at + st.MOTOR_INPUT] = state[at + INPUT_J] / period
        state[at + st.MOTOR_OUTPUT] = state[at + st.MOTOR_SHAFT_J] / period
        mean = state[at + st.MOTOR_IMPULSE] / period
        state[at + st.MOTOR_TORQUE] = mean * model[p + GEAR] * model[p + EFFICIENCY]
        state[at + st.MOTOR_CURRENT] = mean / model[p + BACK_EMF]
        state[at + st.MOTOR_INPUT_J] += state[at + INPUT_J]
        state[at + st.MOTOR_COPPER_J] += state[at + COPPER_J]
        state[at + st.MOTOR_OUTPUT_J] += state[at + st.MOTOR_SHAFT_J]
        state[at + INPUT_J] = state[at + COPPER_J] = state[at + st.MOTOR_SHAFT_J] = state[at + st.MOTOR_IMPULSE] = 0.0
        if k < n:
            state[st.CURRENT + k] = state[at + st.MOTOR_CURRENT]
