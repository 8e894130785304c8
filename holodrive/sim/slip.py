"""The plant with wheel-ground slip: a rigid body, gearmotors, a battery, and friction that saturates.

At each contact the tyre slides over the ground with velocity (s, q) along the direction of traction a and along the
direction f in which a roller runs free, f square to a:

    s = a . v - kappa r w,  q = f . v - sigma r w,  kappa = a . e, sigma = f . e, e the rolling direction
    force = -k_a s a - k_f q f,  k = mu N / sqrt(slip^2 + v0^2)       (a plain tyre: one k for both, friction circle)
    J dw/dt = efficiency K i - b w - coulomb(w) - r e . force

Semi-implicit: the motor's conductance and the friction secants are frozen at the step's start, the coefficients k at
the slip of then or, where a wheel breaks loose within the step, of the pass before; everything that is linear in the
new velocities is solved for. Each wheel's new speed depends on the body alone,

    D w' = N + dt h . xi',  D = J + dt (b + eta K^2 g + r^2 (k_a kappa^2 + k_f sigma^2)),
    h = r (k_a kappa A + k_f sigma F)

so that only a symmetric positive 3 x 3 system for the body is left: stable at any step, and never a gain of energy
without a motor. Velocities are those of the centre of mass, so that the mass matrix is diagonal and the turn of the
body's axes is an exact rotation at the end of the step.

The contact of a caster is c behind its axis, and its steering sweeps it sideways: q = f . v - c d'. A steering servo
does what its command says, whatever the ground's or a coupling's torque about its axis.
"""

import math

from holodrive import obstacles as ob
from holodrive.actuators.dc_motor import bus_voltage, conductance, dry_friction
from holodrive.leaf import leaf
from holodrive.sim import model as md
from holodrive.sim import state as st
from holodrive.sim.caster import carried_by_steering, trail
from holodrive.sim.contact import keep_outside
from holodrive.sim.first_order import steer
from holodrive.sim.turn import turn_factors

# places in a wheel's row at `state.CONTACT`: rows along traction and along the free direction, then this step's numbers
_A, _F, _KAPPA, _SIGMA, _N, _D, _H, _G, _S, _Q, _SWEEP = 0, 3, 6, 7, 8, 9, 10, 13, 14, 15, 16
_MOST_PASSES = 20  # of one step; one does while slip changes little
_EXCESS = 1.02  # of the grip, that a force may reach before the step is solved again


@leaf
def slip_period(model, obstacles, state, events):  # type: ignore[no-untyped-def]
    """One control period of physics steps with the duties and steering commands in `state`."""
    n, steps, dt = int(model[md.N]), int(model[md.STEPS]), model[md.DT]
    steered, fastest, cx, cy = model[md.M] > 0.0, obstacles[ob.FASTEST] * dt, model[md.COM_X], model[md.COM_Y]
    theta, free = state[st.POSE + 2], state[st.FREE]
    c, s = math.cos(theta), math.sin(theta)
    x, y = state[st.POSE] + c * cx - s * cy, state[st.POSE + 1] + s * cx + c * cy
    omega = state[st.TWIST + 2]
    vx, vy = state[st.TWIST] - omega * cy, state[st.TWIST + 1] + omega * cx
    contacts(model, state, n)
    moved_x = moved_y = moved_turn = 0.0
    for k in range(steps):
        if steered:
            steer(model, state, n)
            contacts(model, state, n)
        voltage = battery(model, state, n)
        vx, vy, omega = grip_step(model, state, voltage, n, vx, vy, omega)
        spin(model, state, voltage, n, vx, vy, omega)
        x, y, turn = x + (c * vx - s * vy) * dt, y + (s * vx + c * vy) * dt, omega * dt
        theta += turn
        sine, versine = turn_factors(turn)
        ds, dc = sine * turn, versine * turn
        c, s = c - (dc * c + ds * s), s - (dc * s - ds * c)
        vx, vy = vx - (dc * vx - ds * vy), vy - (dc * vy + ds * vx)
        bx, by = vx + omega * cy, vy - omega * cx
        moved_x, moved_y, moved_turn = moved_x + bx * dt, moved_y + by * dt, moved_turn + turn
        free -= (abs(bx) + abs(by)) * dt + fastest
        if free < 0.0 or k == steps - 1:
            state[st.POSE], state[st.POSE + 1], state[st.POSE + 2] = x - c * cx + s * cy, y - s * cx - c * cy, theta
            state[st.TWIST], state[st.TWIST + 1], state[st.TWIST + 2] = bx, by, omega
            if free < 0.0:
                keep_outside(model, obstacles, state, events, (state[st.TICK] * steps + k + 1) * dt)
                free = state[st.FREE]
                x, y = state[st.POSE] + c * cx - s * cy, state[st.POSE + 1] + s * cx + c * cy
                vx, vy = state[st.TWIST] - omega * cy, state[st.TWIST + 1] + omega * cx
    state[st.FREE] = free
    state[st.MOVED], state[st.MOVED + 1], state[st.MOVED + 2] = moved_x, moved_y, moved_turn


@leaf
def contacts(model, state, n):  # type: ignore[no-untyped-def]
    """Directions of traction and of free rolling as rows over the twist of the centre of mass."""
    trails = model[md.CASTER_AT] > 0.0
    for i in range(n):
        w, t = md.WHEELS + i * md.BLOCK, st.CONTACT + i * st.CONTACT_ROW
        j = int(model[w + md.STEERED])
        if j < 0:
            for k in range(8):
                state[t + k] = model[w + md.TRACTION + k]
            continue
        angle, px, py = model[w + md.YAW] + state[st.STEER + j], model[w + md.PX], model[w + md.PY]
        ax, ay = math.cos(angle), math.sin(angle)
        state[t + _A], state[t + _A + 1], state[t + _A + 2] = ax, ay, px * ay - py * ax
        state[t + _F], state[t + _F + 1], state[t + _F + 2] = -ay, ax, px * ax + py * ay
        state[t + _KAPPA], state[t + _SIGMA] = model[w + md.RADIUS], 0.0
        if trails:  # the contact is `caster` behind the axis, on the same line of traction
            caster = trail(model, i)
            state[t + _F + 2] -= caster
            state[t + _SWEEP] = caster * state[st.STEER_RATE + j]


@leaf
def battery(model, state, n):  # type: ignore[no-untyped-def]
    """Conductances of the motors under their current limits, and the voltage [V] that the battery holds."""
    last = state[st.VOLTAGE]
    at_zero = per_volt = 0.0
    for i in range(n):
        w, t = md.WHEELS + i * md.BLOCK, st.CONTACT + i * st.CONTACT_ROW
        duty, current = state[st.DUTY + i], state[st.CURRENT + i]
        speed = state[st.WHEEL_SPEED + i] + carried_by_steering(model, state, i)  # of the drive
        emf, reactance = model[w + md.BACK_EMF], model[w + md.REACTANCE]
        g = conductance(duty * last, speed, current, emf, model[w + md.RESISTANCE], reactance, model[w + md.LIMIT])
        state[t + _G] = g
        at_zero += duty * g * (reactance * current - emf * speed)
        per_volt += duty * duty * g
    full = model[md.BATTERY_V] if state[st.CHARGE] < model[md.BATTERY_C] else 0.0
    voltage = bus_voltage(full, model[md.BATTERY_R], at_zero, per_volt)
    state[st.VOLTAGE] = voltage
    return voltage


@leaf
def grip_step(model, state, voltage, n, vx, vy, omega):  # type: ignore[no-untyped-def]
    """New velocity of the centre of mass (3): solved again with the new slip where a wheel breaks loose within a step.

    Friction frozen at the slip before would then push far above the grip (at full duty from rest, 1.5 to 9 times).
    Each pass lowers the energy that friction, motors and inertia share, so the passes converge to the implicit step.
    """
    for i in range(n):
        measure(state, i, vx, vy, omega, state[st.WHEEL_SPEED + i])
    nx, ny, turn = body_step(model, state, voltage, n, vx, vy, omega)
    for _ in range(_MOST_PASSES - 1):
        if holds(model, state, n, nx, ny, turn):
            break
        nx, ny, turn = body_step(model, state, voltage, n, vx, vy, omega)
    return nx, ny, turn


@leaf
def measure(state, i, vx, vy, omega, speed):  # type: ignore[no-untyped-def]
    """Write how a tyre slides [m/s] along its traction and along its free direction."""
    t = st.CONTACT + i * st.CONTACT_ROW
    state[t + _S] = state[t + _A] * vx + state[t + _A + 1] * vy + state[t + _A + 2] * omega - state[t + _KAPPA] * speed
    side = state[t + _F] * vx + state[t + _F + 1] * vy + state[t + _F + 2] * omega
    state[t + _Q] = side - state[t + _SIGMA] * speed - state[t + _SWEEP]


@leaf
def holds(model, state, n, vx, vy, omega):  # type: ignore[no-untyped-def]
    """Whether no force of the step just solved exceeds its grip; the new slips are noted for the next pass."""
    floor, fine = model[md.SLIP_SPEED] * model[md.SLIP_SPEED], True
    for i in range(n):
        w, t = md.WHEELS + i * md.BLOCK, st.CONTACT + i * st.CONTACT_ROW
        plain = 1.0 if model[w + md.STEERED] >= 0.0 else 0.0
        before = state[t + _S] * state[t + _S] + plain * state[t + _Q] * state[t + _Q] + floor
        pull = state[t + _H] * vx + state[t + _H + 1] * vy + state[t + _H + 2] * omega
        measure(state, i, vx, vy, omega, (state[t + _N] + pull) * state[t + _D])
        now = state[t + _S] * state[t + _S] + plain * state[t + _Q] * state[t + _Q]
        fine = fine and now <= _EXCESS * _EXCESS * before
    return fine


@leaf
def body_step(model, state, voltage, n, vx, vy, omega):  # type: ignore[no-untyped-def]
    """One pass: new velocity of the centre of mass in the old axes (3); what the wheels need of it goes to `state`."""
    dt, floor, mass = model[md.DT], model[md.SLIP_SPEED] * model[md.SLIP_SPEED], model[md.MASS]
    m11, m22, m33 = mass, mass, model[md.INERTIA]
    b1, b2, b3 = mass * vx, mass * vy, model[md.INERTIA] * omega
    m12 = m13 = m23 = 0.0
    for i in range(n):
        w, t, speed = md.WHEELS + i * md.BLOCK, st.CONTACT + i * st.CONTACT_ROW, state[st.WHEEL_SPEED + i]
        a1, a2, a3 = state[t + _A], state[t + _A + 1], state[t + _A + 2]
        f1, f2, f3 = state[t + _F], state[t + _F + 1], state[t + _F + 2]
        kr, sr = state[t + _KAPPA], state[t + _SIGMA]
        s, q = state[t + _S], state[t + _Q]
        if model[w + md.STEERED] >= 0.0:  # friction circle of a plain tyre
            k_a = dt * model[w + md.GRIP] / math.sqrt(s * s + q * q + floor)
            k_f = k_a
        else:
            k_a = dt * model[w + md.GRIP] / math.sqrt(s * s + floor)
            k_f = dt * model[w + md.ROLLING] / math.sqrt(q * q + floor)
        ka, fs = k_a * kr, k_f * sr
        ready, damping = motor_step(model, state, w, i, voltage, state[t + _G], speed)
        inverse = 1.0 / (model[w + md.SPIN] + dt * damping + ka * kr + fs * sr)
        h1, h2, h3 = ka * a1 + fs * f1, ka * a2 + fs * f2, ka * a3 + fs * f3
        state[t + _N], state[t + _D] = ready, inverse
        state[t + _H], state[t + _H + 1], state[t + _H + 2] = h1, h2, h3
        p1, p2, p3 = h1 * inverse, h2 * inverse, h3 * inverse
        m11 += k_a * a1 * a1 + k_f * f1 * f1 - h1 * p1
        m12 += k_a * a1 * a2 + k_f * f1 * f2 - h1 * p2
        m13 += k_a * a1 * a3 + k_f * f1 * f3 - h1 * p3
        m22 += k_a * a2 * a2 + k_f * f2 * f2 - h2 * p2
        m23 += k_a * a2 * a3 + k_f * f2 * f3 - h2 * p3
        m33 += k_a * a3 * a3 + k_f * f3 * f3 - h3 * p3
        b1, b2, b3 = b1 + p1 * ready, b2 + p2 * ready, b3 + p3 * ready
        if state[t + _SWEEP] != 0.0:  # of steered wheels alone, whose fs is 0
            sweep = k_f * state[t + _SWEEP]
            b1, b2, b3 = b1 + sweep * f1, b2 + sweep * f2, b3 + sweep * f3
    return solve_symmetric(m11, m12, m13, m22, m23, m33, b1, b2, b3)


@leaf
def motor_step(model, state, w, i, voltage, conductance, speed):  # type: ignore[no-untyped-def]
    """Angular momentum N with the motor's push in it [N m s], and all that brakes per speed [N m s/rad]."""
    torque = model[w + md.TORQUE] * conductance
    push = state[st.DUTY + i] * voltage + model[w + md.REACTANCE] * state[st.CURRENT + i]
    carried = carried_by_steering(model, state, i)
    friction = dry_friction(model[w + md.COULOMB], speed + carried)
    damping = model[w + md.VISCOUS] + friction + torque * model[w + md.BACK_EMF]
    ready = model[w + md.SPIN] * speed + model[md.DT] * torque * push
    return ready - model[md.DT] * damping * carried, damping


@leaf
def solve_symmetric(m11, m12, m13, m22, m23, m33, b1, b2, b3):  # type: ignore[no-untyped-def]
    """x of M x = b for a symmetric positive 3 x 3 matrix: L D L^T by hand."""
    l21, l31 = m12 / m11, m13 / m11
    d2, u23 = m22 - l21 * m12, m23 - l31 * m12
    l32 = u23 / d2
    d3 = m33 - l31 * m13 - l32 * u23
    y2 = b2 - l21 * b1
    x3 = (b3 - l31 * b1 - l32 * y2) / d3
    x2 = y2 / d2 - l32 * x3
    return b1 / m11 - l21 * x2 - l31 * x3, x2, x3


@leaf
def spin(model, state, voltage, n, vx, vy, omega):  # type: ignore[no-untyped-def]
    """Wheel speeds, angles, currents and what the battery gave, from the body's new velocity."""
    dt, drawn = model[md.DT], 0.0
    for i in range(n):
        w, t = md.WHEELS + i * md.BLOCK, st.CONTACT + i * st.CONTACT_ROW
        pull = state[t + _H] * vx + state[t + _H + 1] * vy + state[t + _H + 2] * omega
        speed = (state[t + _N] + pull) * state[t + _D]
        push = state[st.DUTY + i] * voltage + model[w + md.REACTANCE] * state[st.CURRENT + i]
        drive = speed + carried_by_steering(model, state, i)
        current = state[t + _G] * (push - model[w + md.BACK_EMF] * drive)
        state[st.WHEEL_SPEED + i], state[st.CURRENT + i] = speed, current
        state[st.WHEEL_ANGLE + i] += speed * dt
        drawn += state[st.DUTY + i] * current
    # what braking gives back is burnt, not stored
    state[st.CHARGE] += max(drawn, 0.0) * dt
    state[st.ENERGY] += max(drawn, 0.0) * voltage * dt
