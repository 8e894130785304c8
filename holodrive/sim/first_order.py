"""The plant without slip: wheel speeds follow duty with a lag, the body moves as the wheels say.

    dw/dt = (duty * no-load speed - w) / lag,   twist = J^+ w,   pose <- pose exp(twist dt)

With casters the twist is that of `sim.caster`. Both the lag and the SE(2) step are exact for a duty held over the
step: wheels have no step error at all, the pose one of second order, where the twist changes direction within a step.
"""

import math

from holodrive import obstacles as ob
from holodrive.leaf import leaf
from holodrive.sim import model as md
from holodrive.sim import state as st
from holodrive.sim.caster import steering_turned, trailing_step, twist_into
from holodrive.sim.contact import keep_outside
from holodrive.sim.turn import turn_factors


@leaf
def first_order_period(model, obstacles, state, events):  # type: ignore[no-untyped-def]
    """One control period of physics steps with the duties and steering commands in `state`."""
    n, steps, dt = int(model[md.N]), int(model[md.STEPS]), model[md.DT]
    steered, alike, fastest = model[md.M] > 0.0, model[md.ALIKE] > 0.0, obstacles[ob.FASTEST] * dt
    x, y, theta, free = state[st.POSE], state[st.POSE + 1], state[st.POSE + 2], state[st.FREE]
    c, s = math.cos(theta), math.sin(theta)
    vx = vy = omega = gx = gy = gw = moved_x = moved_y = moved_turn = 0.0
    left, passed, decay, mean = 1.0, 0.0, model[md.WHEELS + md.DECAY], model[md.WHEELS + md.MEAN]
    if alike:
        ix, iy, iw, gx, gy, gw = final_twist(model, state, n)
    for k in range(steps):
        if alike:
            # wheels of one lag: the twist itself goes the way that each wheel goes
            share = left * mean
            vx, vy, omega = ix + gx * share, iy + gy * share, iw + gw * share
            left *= decay
            passed += share
        else:
            if steered:
                steer(model, state, n)
            vx, vy, omega = wheels_step(model, state, n, dt)
            moved_x, moved_y, moved_turn = moved_x + vx * dt, moved_y + vy * dt, moved_turn + omega * dt
        dx, dy, turn = vx * dt, vy * dt, omega * dt
        sine, versine = turn_factors(turn)
        ux, uy = sine * dx - versine * dy, versine * dx + sine * dy
        x, y, theta = x + c * ux - s * uy, y + s * ux + c * uy, theta + turn
        ds, dc = sine * turn, versine * turn
        c, s = c - (dc * c + ds * s), s - (dc * s - ds * c)
        free -= abs(dx) + abs(dy) + fastest
        if free < 0.0 or k == steps - 1:
            if alike:
                state[st.TWIST], state[st.TWIST + 1], state[st.TWIST + 2] = (
                    ix + gx * left,
                    iy + gy * left,
                    iw + gw * left,
                )
            else:
                twist_of_wheels(model, state, n)
        if free < 0.0:
            state[st.POSE], state[st.POSE + 1], state[st.POSE + 2] = x, y, theta
            keep_outside(model, obstacles, state, events, (state[st.TICK] * steps + k + 1) * dt)
            x, y, free = state[st.POSE], state[st.POSE + 1], state[st.FREE]
    if alike:
        time, gap_time = steps * dt, passed * dt
        moved_x, moved_y, moved_turn = ix * time + gx * gap_time, iy * time + gy * gap_time, iw * time + gw * gap_time
        settle_wheels(model, state, n, left, gap_time)
    state[st.POSE], state[st.POSE + 1], state[st.POSE + 2], state[st.FREE] = x, y, theta, free
    state[st.MOVED], state[st.MOVED + 1], state[st.MOVED + 2] = moved_x, moved_y, moved_turn


@leaf
def final_twist(model, state, n):  # type: ignore[no-untyped-def]
    """Twist (3) that the duties lead to, and how far (3) the wheels' twist is from it; fixed wheels."""
    ix = iy = iw = gx = gy = gw = 0.0
    for i in range(n):
        w = md.WHEELS + i * md.BLOCK
        target = state[st.DUTY + i] * model[w + md.NO_LOAD]
        gap = state[st.WHEEL_SPEED + i] - target
        bx, by, bw = model[w + md.BACK], model[w + md.BACK + 1], model[w + md.BACK + 2]
        ix, iy, iw = ix + bx * target, iy + by * target, iw + bw * target
        gx, gy, gw = gx + bx * gap, gy + by * gap, gw + bw * gap
    return ix, iy, iw, gx, gy, gw


@leaf
def settle_wheels(model, state, n, left, time):  # type: ignore[no-untyped-def]
    """Wheels after a period: `left` of each gap remains, and gap * `time` [s] is what it turned the wheel."""
    for i in range(n):
        target = state[st.DUTY + i] * model[md.WHEELS + i * md.BLOCK + md.NO_LOAD]
        gap = state[st.WHEEL_SPEED + i] - target
        state[st.WHEEL_SPEED + i] = target + gap * left
        state[st.WHEEL_ANGLE + i] += target * model[md.PERIOD] + gap * time


@leaf
def steer(model, state, n):  # type: ignore[no-untyped-def]
    """One step of the steering servos: lag inside a rate limit."""
    trails = model[md.CASTER_AT] > 0.0
    for i in range(n):
        w = md.WHEELS + i * md.BLOCK
        if model[w + md.STEERED] >= 0.0:
            angle = state[st.STEER + int(model[w + md.STEERED])]
            servo_step(model, state, w)
            if trails:
                steering_turned(model, state, i, angle, model[md.DT])


@leaf
def servo_step(model, state, w):  # type: ignore[no-untyped-def]
    """One step of the steering servo of the wheel whose block begins at `w`."""
    j, limit = int(model[w + md.STEERED]), model[w + md.TURN_LIMIT]
    step = (state[st.STEER_COMMAND + j] - state[st.STEER + j]) * model[w + md.TURN]
    state[st.STEER + j] += min(limit, max(-limit, step))


@leaf
def wheels_step(model, state, n, dt):  # type: ignore[no-untyped-def]
    """Step the wheel speeds; the body's mean twist over the step."""
    if model[md.CASTER_AT] > 0.0:
        return trailing_step(model, state, n, dt)
    vx = vy = omega = 0.0
    for i in range(n):
        w = md.WHEELS + i * md.BLOCK
        target = state[st.DUTY + i] * model[w + md.NO_LOAD]
        gap = state[st.WHEEL_SPEED + i] - target
        speed = target + gap * model[w + md.MEAN]
        state[st.WHEEL_SPEED + i] = target + gap * model[w + md.DECAY]
        state[st.WHEEL_ANGLE + i] += speed * dt
        vx, vy, omega = with_wheel(model, state, w, speed, vx, vy, omega)
    return vx, vy, omega


@leaf
def with_wheel(model, state, w, speed, vx, vy, omega):  # type: ignore[no-untyped-def]
    """The twist (3) with what one wheel at `speed` [rad/s] adds to it by least squares."""
    if model[w + md.STEERED] >= 0.0:
        speed, across = steered_rim(model, state, w, speed)
        vx += model[w + md.BACK_ACROSS] * across
        vy += model[w + md.BACK_ACROSS + 1] * across
        omega += model[w + md.BACK_ACROSS + 2] * across
    return vx + model[w + md.BACK] * speed, vy + model[w + md.BACK + 1] * speed, omega + model[w + md.BACK + 2] * speed


@leaf
def twist_of_wheels(model, state, n):  # type: ignore[no-untyped-def]
    """Write the twist that the wheels ask for now."""
    if model[md.CASTER_AT] > 0.0:
        twist_into(model, state, st.WHEEL_SPEED, 0.0, st.TWIST)
        return
    vx = vy = omega = 0.0
    for i in range(n):
        w, speed = md.WHEELS + i * md.BLOCK, state[st.WHEEL_SPEED + i]
        vx, vy, omega = with_wheel(model, state, w, speed, vx, vy, omega)
    state[st.TWIST], state[st.TWIST + 1], state[st.TWIST + 2] = vx, vy, omega


@leaf
def steered_rim(model, state, w, speed):  # type: ignore[no-untyped-def]
    """Contact velocity [m/s] of a steered wheel along and across its zero direction."""
    rim, angle = speed * model[w + md.RADIUS], state[st.STEER + int(model[w + md.STEERED])]
    return rim * math.cos(angle), rim * math.sin(angle)
