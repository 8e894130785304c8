"""The plant of measured actuators: duty to wheel speed along the curves of the robot's [pwm_map], no slip.

    steady speed = curve^-1(duty * battery voltage / measured voltage) * (1 + spread + noise)
    dw/dt = (steady speed - w) / lag

A wheel that starts out of standstill, or against its motion, first waits for the dead time of that start. Wheels and
body then move as with the first-order plant (Keek et al., eq. 9 to 12, inverted; dead time and lag are not printed).
"""

import numpy as np

from holodrive.actuators.duty_curve import speed_of
from holodrive.leaf import leaf
from holodrive.sim import model as md
from holodrive.sim import state as st
from holodrive.sim import streams
from holodrive.sim.first_order import steer, with_wheel
from holodrive.sim.roll import roll, stand

_STANDS = 0.02  # of the speed at full duty: a wheel below stands


@leaf
def pwm_map_period(model, obstacles, state, events, key):  # type: ignore[no-untyped-def]
    """One control period of physics steps with the duties and steering commands in `state`."""
    n, steered = int(model[md.N]), model[md.M] > 0.0
    aim(model, state, key, n)
    stand(state)
    for k in range(int(model[md.STEPS])):
        if steered:
            steer(model, state, n)
        vx, vy, omega = map_step(model, state, n, model[md.DT])
        roll(model, obstacles, state, events, k, vx, vy, omega)


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
