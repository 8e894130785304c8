"""The plant of measured actuators: duty to wheel speed along the curves of the robot's [pwm_map], no slip.

    steady speed = curve^-1(duty * battery voltage / measured voltage) * (1 + spread + noise)
    dw/dt = (steady speed - w) / lag

A wheel that starts out of standstill, or against its motion, first waits for the dead time of that start. Wheels and
body then move as with the first-order plant (Keek et al., eq. 9 to 12, inverted; dead time and lag are not printed).
"""

import math

import numpy as np

from holodrive import obstacles as ob
from holodrive.actuators.duty_curve import speed_of
from holodrive.leaf import leaf
from holodrive.sim import model as md
from holodrive.sim import state as st
from holodrive.sim import streams
from holodrive.sim.contact import keep_outside
from holodrive.sim.first_order import steer, twist_of_wheels, with_wheel
from holodrive.sim.turn import turn_factors

_STANDS = 0.02  # of the speed at full duty: a wheel below stands


@leaf
def pwm_map_period(model, obstacles, state, events, key):  # type: ignore[no-untyped-def]
    """One control period of physics steps with the duties and steering commands in `state`."""
    n, steps, dt = int(model[md.N]), int(model[md.STEPS]), model[md.DT]
    steered, fastest = model[md.M] > 0.0, obstacles[ob.FASTEST] * dt
    aim(model, state, key, n)
    moved_x = moved_y = moved_turn = 0.0
    for k in range(steps):
        if steered:
            steer(model, state, n)
        vx, vy, omega = map_step(model, state, n, dt)
        dx, dy, turn = vx * dt, vy * dt, omega * dt
        moved_x, moved_y, moved_turn = moved_x + dx, moved_y + dy, moved_turn + turn
        sine, versine = turn_factors(turn)
        ux, uy = sine * dx - versine * dy, versine * dx + sine * dy
        c, s = math.cos(state[st.POSE + 2]), math.sin(state[st.POSE + 2])
        state[st.POSE] += c * ux - s * uy
        state[st.POSE + 1] += s * ux + c * uy
        state[st.POSE + 2] += turn
        state[st.FREE] -= abs(dx) + abs(dy) + fastest
        if state[st.FREE] < 0.0 or k == steps - 1:
            twist_of_wheels(model, state, n)
        if state[st.FREE] < 0.0:
            keep_outside(model, obstacles, state, events, (state[st.TICK] * steps + k + 1) * dt)
    state[st.MOVED], state[st.MOVED + 1], state[st.MOVED + 2] = moved_x, moved_y, moved_turn


@leaf
def aim(model, state, key, n):  # type: ignore[no-untyped-def]
    """Steady speed that each wheel's duty leads to, and the dead time of a wheel that starts or reverses."""
    at, tick = int(model[md.MAP_AT]), int(state[st.TICK])
    volts = model[md.BATTERY_V] / model[at + md.MAP_VOLTAGE]
    for i in range(n):
        w = np.uint64(i)
        aimed = speed_of(model, at + md.MAP_CURVES, i, state[st.DUTY + i] * volts)
        spread = streams.gauss(streams.draw_index(streams.draw(key, streams.SPEED_SPREAD, 0), w))
        noise = streams.gauss(streams.draw_index(streams.draw(key, streams.SPEED_NOISE, tick), w))
        deviation = model[at + md.MAP_SPREAD] * spread + model[at + md.MAP_NOISE] * noise
        state[st.AIM + i] = aimed * max(0.0, 1.0 + deviation)
        way = 1.0 if aimed > 0.0 else (-1.0 if aimed < 0.0 else 0.0)
        still = abs(state[st.WHEEL_SPEED + i]) < _STANDS * model[md.WHEELS + i * md.BLOCK + md.NO_LOAD]
        if way == 0.0:
            state[st.HEADED + i] = 0.0 if still else state[st.HEADED + i]
            state[st.WAIT + i] = 0.0
        elif way != state[st.HEADED + i]:
            starts = streams.draw_index(streams.draw(key, streams.DEAD_TIME, tick), w)
            dead = model[at + md.MAP_DEAD_TIME] + model[at + md.MAP_DEAD_SPREAD] * streams.gauss(starts)
            state[st.HEADED + i], state[st.WAIT + i] = way, max(0.0, dead)


@leaf
def map_step(model, state, n, dt):  # type: ignore[no-untyped-def]
    """Step the wheel speeds; the body's mean twist over the step. A wheel that waits is driven by nothing."""
    vx = vy = omega = 0.0
    at = int(model[md.MAP_AT])
    decay, mean = model[at + md.MAP_DECAY], model[at + md.MAP_MEAN]
    for i in range(n):
        target = state[st.AIM + i]
        if state[st.WAIT + i] > 0.5 * dt:
            state[st.WAIT + i] -= dt
            target = 0.0
        gap = state[st.WHEEL_SPEED + i] - target
        speed = target + gap * mean
        state[st.WHEEL_SPEED + i] = target + gap * decay
        state[st.WHEEL_ANGLE + i] += speed * dt
        vx, vy, omega = with_wheel(model, state, md.WHEELS + i * md.BLOCK, speed, vx, vy, omega)
    return vx, vy, omega
