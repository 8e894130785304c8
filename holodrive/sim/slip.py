"""The plant with wheel-ground slip: a rigid body, gearmotors, a battery, and friction that saturates (papers.md E).

At each contact the tyre slides over the ground with velocity (s, q) along the direction of traction a and along the
direction f in which a roller runs free, f square to a:

    s = a . v - kappa r w,  q = f . v - sigma r w,  kappa = a . e, sigma = f . e, e the rolling direction
    force = -k_a s a - k_f q f,  k = mu N / sqrt(slip^2 + v0^2)       (a plain tyre: one k for both, friction circle)
    J dw/dt = efficiency K i - b w - coulomb(w) - r e . force

Semi-implicit: the coefficients k, the motor's conductance and the friction secants are frozen at the step's start,
everything that is linear in the new velocities is solved for. Each wheel's new speed depends on the body alone,

    D w' = N + dt h . xi',  D = J + dt (b + eta K^2 g + r^2 (k_a kappa^2 + k_f sigma^2)),
    h = r (k_a kappa A + k_f sigma F)

so that only a symmetric positive 3 x 3 system for the body is left: stable at any step, and never a gain of energy
without a motor. Velocities are those of the centre of mass, so that the mass matrix is diagonal and the turn of the
body's axes is an exact rotation at the end of the step.
"""

import math

import numpy as np
from numba import njit

from holodrive.actuators.dc_motor import bus_voltage, conductance, dry_friction
from holodrive.layout import MAX_WHEELS
from holodrive.sim import state as st
from holodrive.sim.contact import keep_outside
from holodrive.sim.first_order import steer
from holodrive.sim.turn import turn_factors

# columns of the contact table: A (3), F (3), kappa r, sigma r, then this step's N, 1 / D, dt h (3), conductance
_A, _F, _KAPPA, _SIGMA, _N, _D, _H, _G = 0, 3, 6, 7, 8, 9, 10, 13
_COLUMNS = 14


@njit(cache=True, error_model="numpy")
def slip_period(model, obstacles, state, events):  # type: ignore[no-untyped-def]
    """One control period of `model.steps` physics steps with the duties and steering commands in `state`."""
    dt, fastest, cx, cy = model.dt, obstacles.fastest * model.dt, model.com_x, model.com_y
    tick, theta = state[st.TICK], state[st.POSE + 2]
    c, s, free = math.cos(theta), math.sin(theta), state[st.FREE]
    x, y = state[st.POSE] + c * cx - s * cy, state[st.POSE + 1] + s * cx + c * cy
    omega = state[st.TWIST + 2]
    vx, vy = state[st.TWIST] - omega * cy, state[st.TWIST + 1] + omega * cx
    table = np.empty((MAX_WHEELS, _COLUMNS))
    for i in range(model.n):
        contact_rows(model.wheels, state, table, i)
    moved_x = moved_y = moved_turn = 0.0
    for k in range(model.steps):
        if model.m > 0:
            steer(model.wheels, state, model.m)
            for i in range(model.n):
                if model.wheels.steered[i] >= 0:
                    contact_rows(model.wheels, state, table, i)
        vx, vy, omega = body_step(model, state, table, battery(model, state, table, dt), vx, vy, omega)
        x, y, turn = x + (c * vx - s * vy) * dt, y + (s * vx + c * vy) * dt, omega * dt
        theta += turn
        sine, versine = turn_factors(turn)
        ds, dc = sine * turn, versine * turn
        c, s = c - (dc * c + ds * s), s - (dc * s - ds * c)
        vx, vy = vx - (dc * vx - ds * vy), vy - (dc * vy + ds * vx)
        bx, by = vx + omega * cy, vy - omega * cx
        moved_x, moved_y, moved_turn = moved_x + bx * dt, moved_y + by * dt, moved_turn + turn
        free -= (abs(bx) + abs(by)) * dt + fastest
        if free < 0.0 or k == model.steps - 1:
            state[st.POSE], state[st.POSE + 1], state[st.POSE + 2] = x - c * cx + s * cy, y - s * cx - c * cy, theta
            state[st.TWIST], state[st.TWIST + 1], state[st.TWIST + 2] = bx, by, omega
            if free < 0.0:
                keep_outside(model, obstacles, state, events, (tick * model.steps + k + 1) * dt)
                free = state[st.FREE]
                x, y = state[st.POSE] + c * cx - s * cy, state[st.POSE + 1] + s * cx + c * cy
                vx, vy = state[st.TWIST] - omega * cy, state[st.TWIST + 1] + omega * cx
    state[st.FREE] = free
    state[st.MOVED], state[st.MOVED + 1], state[st.MOVED + 2] = moved_x, moved_y, moved_turn


@njit(cache=True, error_model="numpy")
def contact_rows(wheels, state, table, i):  # type: ignore[no-untyped-def]
    """Directions of traction and of free rolling as rows over the twist of the centre of mass."""
    ax, ay, ex, ey = wheels.ax[i], wheels.ay[i], wheels.ex[i], wheels.ey[i]
    j = wheels.steered[i]
    if j >= 0:
        angle = wheels.yaw[i] + state[st.STEER + j]
        ax, ay = math.cos(angle), math.sin(angle)
        ex, ey = ax, ay
    px, py = wheels.px[i], wheels.py[i]
    table[i, _A], table[i, _A + 1], table[i, _A + 2] = ax, ay, px * ay - py * ax
    table[i, _F], table[i, _F + 1], table[i, _F + 2] = -ay, ax, px * ax + py * ay
    table[i, _KAPPA] = (ax * ex + ay * ey) * wheels.radius[i]
    table[i, _SIGMA] = (ax * ey - ay * ex) * wheels.radius[i]


@njit(cache=True, error_model="numpy")
def battery(model, state, table, dt):  # type: ignore[no-untyped-def]
    """Conductances of the motors under their current limits, and the voltage [V] that the battery holds."""
    motors, last = model.motors, state[st.VOLTAGE]
    at_zero = per_volt = 0.0
    for i in range(model.n):
        duty, speed, current = state[st.DUTY + i], state[st.WHEEL_SPEED + i], state[st.CURRENT + i]
        g = conductance(
            duty * last,
            speed,
            current,
            motors.back_emf[i],
            motors.resistance[i],
            motors.reactance[i],
            motors.limit[i],
        )
        table[i, _G] = g
        at_zero += duty * g * (motors.reactance[i] * current - motors.back_emf[i] * speed)
        per_volt += duty * duty * g
    full = model.battery_voltage if state[st.CHARGE] < model.battery_capacity else 0.0
    voltage = bus_voltage(full, model.battery_resistance, at_zero, per_volt)
    state[st.VOLTAGE] = voltage
    return voltage


@njit(cache=True, error_model="numpy")
def body_step(model, state, table, voltage, vx, vy, omega):  # type: ignore[no-untyped-def]
    """New velocity of the centre of mass in the old axes (3); wheels and currents go to `state`."""
    dt, floor = model.dt, model.slip_speed * model.slip_speed
    wheels, motors = model.wheels, model.motors
    m11, m22, m33 = model.mass, model.mass, model.inertia
    b1, b2, b3 = model.mass * vx, model.mass * vy, model.inertia * omega
    m12 = m13 = m23 = 0.0
    for i in range(model.n):
        w = state[st.WHEEL_SPEED + i]
        a1, a2, a3 = table[i, _A], table[i, _A + 1], table[i, _A + 2]
        f1, f2, f3 = table[i, _F], table[i, _F + 1], table[i, _F + 2]
        kr, sr = table[i, _KAPPA], table[i, _SIGMA]
        s = a1 * vx + a2 * vy + a3 * omega - kr * w
        q = f1 * vx + f2 * vy + f3 * omega - sr * w
        if wheels.steered[i] >= 0:
            k_a = wheels.grip[i] / math.sqrt(s * s + q * q + floor)
            k_f = k_a
        else:
            k_a = wheels.grip[i] / math.sqrt(s * s + floor)
            k_f = wheels.rolling[i] / math.sqrt(q * q + floor)
        torque = motors.efficiency[i] * motors.back_emf[i] * table[i, _G]
        damping = motors.viscous[i] + dry_friction(motors.coulomb[i], w) + torque * motors.back_emf[i]
        inverse = 1.0 / (motors.inertia[i] + dt * (damping + k_a * kr * kr + k_f * sr * sr))
        push = state[st.DUTY + i] * voltage + motors.reactance[i] * state[st.CURRENT + i]
        ready = motors.inertia[i] * w + dt * torque * push
        k_a, k_f = dt * k_a, dt * k_f
        h1, h2, h3 = k_a * kr * a1 + k_f * sr * f1, k_a * kr * a2 + k_f * sr * f2, k_a * kr * a3 + k_f * sr * f3
        table[i, _N], table[i, _D] = ready, inverse
        table[i, _H], table[i, _H + 1], table[i, _H + 2] = h1, h2, h3
        m11 += k_a * a1 * a1 + k_f * f1 * f1 - h1 * h1 * inverse
        m12 += k_a * a1 * a2 + k_f * f1 * f2 - h1 * h2 * inverse
        m13 += k_a * a1 * a3 + k_f * f1 * f3 - h1 * h3 * inverse
        m22 += k_a * a2 * a2 + k_f * f2 * f2 - h2 * h2 * inverse
        m23 += k_a * a2 * a3 + k_f * f2 * f3 - h2 * h3 * inverse
        m33 += k_a * a3 * a3 + k_f * f3 * f3 - h3 * h3 * inverse
        b1, b2, b3 = b1 + h1 * ready * inverse, b2 + h2 * ready * inverse, b3 + h3 * ready * inverse
    vx, vy, omega = solve_symmetric(m11, m12, m13, m22, m23, m33, b1, b2, b3)
    spin(model, state, table, voltage, vx, vy, omega)
    return vx, vy, omega


@njit(cache=True, error_model="numpy")
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


@njit(cache=True, error_model="numpy")
def spin(model, state, table, voltage, vx, vy, omega):  # type: ignore[no-untyped-def]
    """Wheel speeds, angles, currents and what the battery gave, from the body's new velocity."""
    dt, motors = model.dt, model.motors
    drawn = 0.0
    for i in range(model.n):
        w = (table[i, _N] + table[i, _H] * vx + table[i, _H + 1] * vy + table[i, _H + 2] * omega) * table[i, _D]
        push = state[st.DUTY + i] * voltage + motors.reactance[i] * state[st.CURRENT + i]
        current = table[i, _G] * (push - motors.back_emf[i] * w)
        state[st.WHEEL_SPEED + i], state[st.CURRENT + i] = w, current
        state[st.WHEEL_ANGLE + i] += w * dt
        drawn += state[st.DUTY + i] * current
    state[st.CHARGE] += drawn * dt
    state[st.ENERGY] += voltage * drawn * dt
