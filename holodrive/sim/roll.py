"""One physics step of a body that moves as its wheels say, by the exact exponential, and past what stands."""

import math

from holodrive import obstacles as ob
from holodrive.leaf import leaf
from holodrive.sim import model as md
from holodrive.sim import state as st
from holodrive.sim.contact import keep_outside
from holodrive.sim.first_order import twist_of_wheels
from holodrive.sim.turn import turn_factors


@leaf
def stand(state):  # type: ignore[no-untyped-def]
    """The way of the control period begins at nothing."""
    state[st.MOVED] = state[st.MOVED + 1] = state[st.MOVED + 2] = 0.0


@leaf
def roll(model, obstacles, state, events, k, vx, vy, omega):  # type: ignore[no-untyped-def]
    """Move by the mean body twist [m/s, m/s, rad/s] of step k of the control period.

    The twist that the wheels ask for is written where it is needed: at contacts, and at the period's end.
    """
    steps, dt = int(model[md.STEPS]), model[md.DT]
    dx, dy, turn = vx * dt, vy * dt, omega * dt
    state[st.MOVED] += dx
    state[st.MOVED + 1] += dy
    state[st.MOVED + 2] += turn
    sine, versine = turn_factors(turn)
    ux, uy = sine * dx - versine * dy, versine * dx + sine * dy
    c, s = math.cos(state[st.POSE + 2]), math.sin(state[st.POSE + 2])
    state[st.POSE] += c * ux - s * uy
    state[st.POSE + 1] += s * ux + c * uy
    state[st.POSE + 2] += turn
    state[st.FREE] -= abs(dx) + abs(dy) + obstacles[ob.FASTEST] * dt
    if state[st.FREE] < 0.0 or k == steps - 1:
        twist_of_wheels(model, state, int(model[md.N]))
    if state[st.FREE] < 0.0:
        keep_outside(model, obstacles, state, events, (state[st.TICK] * steps + k + 1) * dt)
