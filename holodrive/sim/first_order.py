"""The plant without slip: wheel speeds follow duty with a lag, the body moves as the wheels say.

    dw/dt = (duty * no-load speed - w) / lag,   twist = J^+ w,   pose <- pose exp(twist dt)

Both the lag and the SE(2) step are exact for a duty held over the step: wheels have no step error at all, the pose
one of second order, where the twist changes direction within a step.
"""

import math

from numba import njit

from holodrive.sim import state as st
from holodrive.sim.contact import keep_outside
from holodrive.sim.turn import turn_factors


@njit(cache=True, error_model="numpy")
def first_order_period(model, obstacles, state, events):  # type: ignore[no-untyped-def]
    """One control period of `model.steps` physics steps with the duties and steering commands in `state`."""
    dt, fastest = model.dt, obstacles.fastest * model.dt
    tick, x, y, theta = state[st.TICK], state[st.POSE], state[st.POSE + 1], state[st.POSE + 2]
    c, s, free = math.cos(theta), math.sin(theta), state[st.FREE]
    moved_x = moved_y = moved_turn = 0.0
    for k in range(model.steps):
        if model.m > 0:
            steer(model.wheels, state, model.m)
        vx, vy, omega = wheels_and_twist(model.wheels, state, model.n, dt)
        dx, dy, turn = vx * dt, vy * dt, omega * dt
        sine, versine = turn_factors(turn)
        ux, uy = sine * dx - versine * dy, versine * dx + sine * dy
        x, y, theta = x + c * ux - s * uy, y + s * ux + c * uy, theta + turn
        ds, dc = sine * turn, versine * turn
        c, s = c - (dc * c + ds * s), s - (dc * s - ds * c)
        moved_x, moved_y, moved_turn = moved_x + dx, moved_y + dy, moved_turn + turn
        free -= abs(dx) + abs(dy) + fastest
        if free < 0.0 or k == model.steps - 1:
            state[st.POSE], state[st.POSE + 1], state[st.POSE + 2] = x, y, theta
            end_twist(model.wheels, state, model.n)
            if free < 0.0:
                keep_outside(model, obstacles, state, events, (tick * model.steps + k + 1) * dt)
                x, y, free = state[st.POSE], state[st.POSE + 1], state[st.FREE]
    state[st.FREE] = free
    state[st.MOVED], state[st.MOVED + 1], state[st.MOVED + 2] = moved_x, moved_y, moved_turn


@njit(cache=True, error_model="numpy")
def steer(wheels, state, m):  # type: ignore[no-untyped-def]
    """One step of the steering servos: lag inside a rate limit."""
    for j in range(m):
        step = (state[st.STEER_COMMAND + j] - state[st.STEER + j]) * wheels.turn[j]
        state[st.STEER + j] += min(wheels.turn_limit[j], max(-wheels.turn_limit[j], step))


@njit(cache=True, error_model="numpy")
def wheels_and_twist(wheels, state, n, dt):  # type: ignore[no-untyped-def]
    """Step the wheel speeds; the body's mean twist over the step."""
    vx = vy = omega = 0.0
    forward = wheels.forward
    for i in range(n):
        target = state[st.DUTY + i] * wheels.no_load[i]
        gap = state[st.WHEEL_SPEED + i] - target
        speed = target + gap * wheels.mean[i]
        state[st.WHEEL_SPEED + i] = target + gap * wheels.decay[i]
        state[st.WHEEL_ANGLE + i] += speed * dt
        row, j = wheels.row[i], wheels.steered[i]
        if j >= 0:
            rim, angle = speed * wheels.radius[i], state[st.STEER + j]
            speed, across = rim * math.cos(angle), rim * math.sin(angle)
            vx += forward[0, row + 1] * across
            vy += forward[1, row + 1] * across
            omega += forward[2, row + 1] * across
        vx += forward[0, row] * speed
        vy += forward[1, row] * speed
        omega += forward[2, row] * speed
    return vx, vy, omega


@njit(cache=True, error_model="numpy")
def end_twist(wheels, state, n):  # type: ignore[no-untyped-def]
    """Write the twist that the wheels ask for now."""
    vx = vy = omega = 0.0
    forward = wheels.forward
    for i in range(n):
        speed, row, j = state[st.WHEEL_SPEED + i], wheels.row[i], wheels.steered[i]
        if j >= 0:
            rim, angle = speed * wheels.radius[i], state[st.STEER + j]
            speed, across = rim * math.cos(angle), rim * math.sin(angle)
            vx += forward[0, row + 1] * across
            vy += forward[1, row + 1] * across
            omega += forward[2, row + 1] * across
        vx += forward[0, row] * speed
        vy += forward[1, row] * speed
        omega += forward[2, row] * speed
    state[st.TWIST], state[st.TWIST + 1], state[st.TWIST + 2] = vx, vy, omega
