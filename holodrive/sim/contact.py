"""Collisions: a robot's round footprint against obstacles, walls and movers.

A robot that would enter an obstacle is put back to its surface along the shortest way, and its velocity into the
surface is taken from it (it slides on); its wheels turn as they like. A mover that runs into the robot pushes it.
Each contact that begins is an event with its time, its place and who moved.
"""

import math

from holodrive.leaf import leaf
from holodrive.obstacles import nearest
from holodrive.sim import model as md
from holodrive.sim import state as st

MARGIN = 1e-9  # m: how far outside the surface a robot is put
REARM = 0.25  # s without touch after which the same obstacle counts again
STANDING = 0.01  # m/s: what is slower than this stands still
_SLOTS = 4
_ROUNDS = 32  # between a wall and a post each push shortens the way into the other by a factor


@leaf
def free_distance(model, obstacles, state, time):  # type: ignore[no-untyped-def]
    """How far [m] the robot may surely move from where it is now before it touches anything."""
    return nearest(obstacles, time, state[st.POSE], state[st.POSE + 1])[0] - model[md.FOOTPRINT]


@leaf
def keep_outside(model, obstacles, state, events, time):  # type: ignore[no-untyped-def]
    """Put the robot out of what it has entered, tell contacts that began, renew the free distance."""
    gap = math.inf
    # its own speed: what a mover's push adds below is not the robot's doing
    speed = math.hypot(state[st.TWIST], state[st.TWIST + 1])
    for _ in range(_ROUNDS):  # in a corner one push may lead into the other wall
        gap, nx, ny, vx, vy, number = nearest(obstacles, time, state[st.POSE], state[st.POSE + 1])
        gap -= model[md.FOOTPRINT]
        if gap >= 0.0:
            break
        tell(model, state, events, time, nx, ny, vx, vy, number, speed)
        push = MARGIN - gap
        state[st.POSE] += push * nx
        state[st.POSE + 1] += push * ny
        c, s = math.cos(state[st.POSE + 2]), math.sin(state[st.POSE + 2])
        state[st.PUSHED] += push * (c * nx + s * ny)
        state[st.PUSHED + 1] += push * (c * ny - s * nx)
        block(state, nx, ny, vx, vy)
        gap = MARGIN
    state[st.FREE] = gap


@leaf
def block(state, nx, ny, vx, vy):  # type: ignore[no-untyped-def]
    """Take from the robot's velocity what goes into a surface with normal n that moves with v."""
    theta = state[st.POSE + 2]
    c, s = math.cos(theta), math.sin(theta)
    bx, by = state[st.TWIST], state[st.TWIST + 1]
    into = (c * bx - s * by - vx) * nx + (s * bx + c * by - vy) * ny
    if into < 0.0:
        state[st.TWIST] = bx - into * (c * nx + s * ny)
        state[st.TWIST + 1] = by - into * (c * ny - s * nx)


@leaf
def tell(model, state, events, time, nx, ny, vx, vy, number, speed):  # type: ignore[no-untyped-def]
    """Count a touch; write an event when it is the first one of a contact."""
    oldest = st.CONTACTS
    for k in range(_SLOTS):
        slot = st.CONTACTS + 2 * k
        if state[slot] == number + 1.0:
            lasting = time - state[slot + 1] <= REARM
            state[slot + 1] = time
            if lasting:
                return
            oldest = slot
            break
        if state[slot + 1] < state[oldest + 1] or state[slot] == 0.0:
            oldest = slot
    state[oldest], state[oldest + 1] = number + 1.0, time
    state[st.COLLISIONS] += 1.0
    if speed > STANDING:
        state[st.MOVED_COLLISIONS] += 1.0
    row = write_event(state, events, time, st.COLLISION)
    if row >= 0:
        events[row, st.EVENT_PLACE] = state[st.POSE] - model[md.FOOTPRINT] * nx
        events[row, st.EVENT_PLACE + 1] = state[st.POSE + 1] - model[md.FOOTPRINT] * ny
        events[row, st.EVENT_OBSTACLE] = number
        events[row, st.EVENT_ROBOT_SPEED] = speed
        events[row, st.EVENT_MOVER_SPEED] = math.hypot(vx, vy)


@leaf
def write_event(state, events, time, kind):  # type: ignore[no-untyped-def]
    """Start a row of the event table; gives its number, -1 when the table is full."""
    row = int(state[st.N_EVENTS])
    if row >= events.shape[0]:
        return -1
    state[st.N_EVENTS] += 1.0
    for k in range(st.EVENT_SIZE):
        events[row, k] = 0.0
    events[row, st.EVENT_TIME], events[row, st.EVENT_KIND] = time, kind
    for i in range(3):
        events[row, st.EVENT_POSE + i] = state[st.POSE + i]
    return row
