"""One tick of an odometry over a table of sensors: read, weigh, judge, move the pose, say how sure that is."""

import math

from holodrive import layout
from holodrive.estimation import sensor_doubt as doubt
from holodrive.estimation import sensor_health as health
from holodrive.estimation import sensor_state as st
from holodrive.estimation import sensor_table as tb
from holodrive.estimation.dead_reckoning import add, advance, carry, levers, spread
from holodrive.kinematics import normal_equations as eq
from holodrive.kinematics.kernel import wrap
from holodrive.leaf import leaf, set_all

_LONGEST_S = 1.0  # of a longer gap nobody knows more than of one second
_STILL_COUNTS = 20.0  # no reading of so few counts is too fast


@leaf
def tick(obs, memory, params, estimate):  # type: ignore[no-untyped-def]
    """One tick over the arrays of `holodrive.layout`; the first only starts."""
    dt = obs[layout.DT]
    timed = math.isfinite(dt) and dt > 0.0
    dt = min(dt, _LONGEST_S) if timed else 0.0
    read(obs, memory, params, dt)
    if memory[st.STARTED] == 0.0:
        memory[st.STARTED] = memory[st.FRESH] = 1.0
        tell(memory, health.suspects(params, memory), estimate)
        return
    settled = st.fit_tick(params, memory, dt)
    fill(memory, params)
    gather(memory, params, dt)
    if health.judge(params, memory, dt):
        memory[st.FRESH] = 1.0
        settled = st.fit_tick(params, memory, dt)
    doubt.weigh_doubt(params, memory, dt)
    slip(memory, params)
    grow(memory, params, dt, settled)
    advance(memory[:3], memory[st.DISPLACEMENT : st.DISPLACEMENT + 3])
    follow(memory, params, dt)
    tell(memory, health.suspects(params, memory), estimate)


@leaf
def read(obs, memory, params, dt):  # type: ignore[no-untyped-def]
    """What every sensor tells of this tick; one that is not finite or beyond reach counts as not read."""
    for s in range(int(params[st.SENSORS])):
        b, m = st.TABLE + s * tb.BLOCK, st.STATES + s * st.STATE
        kind, index = int(params[b + tb.KIND]), int(params[b + tb.INDEX])
        x = y = 0.0
        if kind == tb.MOUSE:
            x = obs[layout.MICE + 2 * index]
            y = obs[layout.MICE + 2 * index + 1] if params[b + tb.ROWS] > 1.0 else 0.0
        elif kind == tb.GYRO:
            rate, old = obs[layout.GYRO], memory[st.LAST_GYRO]
            x = params[b + tb.RADIUS] * dt * (0.5 * (rate + old) if math.isfinite(old) else rate)
            memory[st.LAST_GYRO] = rate
        else:
            angle, old = obs[layout.WHEEL_POSITION + index], memory[m + st.OLD]
            memory[m + st.OLD] = angle
            x = params[b + tb.RADIUS] * (angle - old)
            if kind == tb.MODULE:
                steer, before = obs[layout.STEER + int(params[b + tb.STEER])], memory[m + st.OLD_STEER]
                memory[m + st.OLD_STEER] = steer
                middle = before + 0.5 * wrap(steer - before)
                x, y = x * math.cos(middle), x * math.sin(middle)
        way = math.hypot(x, y)
        reach = params[b + tb.REACH] * dt + _STILL_COUNTS * params[b + tb.QUANTUM]
        good = math.isfinite(way) and (way <= reach or dt == 0.0)
        memory[m + st.READ] = 1.0 if good else 0.0
        memory[m + st.Z], memory[m + st.Z + 1] = (x, y) if good else (0.0, 0.0)


@leaf
def fill(memory, params):  # type: ignore[no-untyped-def]
    """A sensor that was not read gets what the others say, so that its sums miss nothing."""
    motion = memory[st.DISPLACEMENT : st.DISPLACEMENT + 3]
    for s in range(int(params[st.SENSORS])):
        b, m = st.TABLE + s * tb.BLOCK, st.STATES + s * st.STATE
        if memory[m + st.READ] == 0.0:
            for i in range(int(params[b + tb.ROWS])):
                memory[m + st.Z + i] = eq.row(params, b + tb.H + 3 * i, motion)


@leaf
def gather(memory, params, dt):  # type: ignore[no-untyped-def]
    """The sums that forget, with this tick."""
    keep = math.exp(-dt / params[st.HORIZON_S])
    moved = st.moved_by(params, memory, st.DISPLACEMENT)
    memory[st.WINDOW] = keep * memory[st.WINDOW] + dt
    motion = memory[st.DISPLACEMENT : st.DISPLACEMENT + 3]
    for s in range(int(params[st.SENSORS])):
        b, m = st.TABLE + s * tb.BLOCK, st.STATES + s * st.STATE
        way = math.hypot(memory[m + st.Z], memory[m + st.Z + 1])
        due = 0.0
        for i in range(int(params[b + tb.ROWS])):
            memory[m + st.SUM + i] = keep * memory[m + st.SUM + i] + memory[m + st.Z + i]
            due = math.hypot(due, eq.row(params, b + tb.H + 3 * i, motion))
        due = max(due, way)
        memory[m + st.WAY] = keep * memory[m + st.WAY] + way
        memory[m + st.DUE] = keep * memory[m + st.DUE] + due
        memory[m + st.SILENT] = memory[m + st.SILENT] + dt if way == 0.0 else 0.0
        memory[m + st.NOISE] = keep * keep * memory[m + st.NOISE] + st.noise(params, b, due, moved, dt)


@leaf
def slip(memory, params):  # type: ignore[no-untyped-def]
    """Root mean square over all rows of what the sensors contradict the trusted ones in [m/s]."""
    motion, total, rows = memory[st.MEAN : st.MEAN + 3], 0.0, 0.0
    if not (st.fit_sums(params, memory, -1, -1, motion) and memory[st.WINDOW] > 0.0):
        memory[st.SLIP] = 0.0
        return
    for s in range(int(params[st.SENSORS])):
        b = st.TABLE + s * tb.BLOCK
        if params[b + tb.KIND] != tb.GYRO:
            total += st.square(params, memory, s, motion)
            rows += params[b + tb.ROWS]
    memory[st.SLIP] = math.sqrt(total / rows) / memory[st.WINDOW]


@leaf
def grow(memory, params, dt, settled):  # type: ignore[no-untyped-def]
    """Covariance of the pose after this displacement, and what of it counts have not told yet."""
    heading, motion = memory[2], memory[st.DISPLACEMENT : st.DISPLACEMENT + 3]
    covariance, counts = memory[st.COVARIANCE : st.COVARIANCE + 9], memory[st.COUNTS : st.COUNTS + 9]
    normal, length = memory[st.NORMAL : st.NORMAL + eq.SIZE], params[st.LENGTH]
    carry(covariance, heading, motion)
    g = levers(heading, motion)
    set_all(counts, 0.0)
    moved, weighed = st.moved_by(params, memory, st.DISPLACEMENT), st.moved_by(params, memory, st.WEIGHED)
    # the part of a count with which the sensors in use began stays for good
    c, s = math.cos(heading), math.sin(heading)
    coarse, unsure = 0.0, doubt.doubted(params, memory, moved, dt)
    for k in range(int(params[st.SENSORS])):
        b, m = st.TABLE + k * tb.BLOCK, st.STATES + k * st.STATE
        if memory[m + st.OUT] != 0.0 or memory[m + st.READ] == 0.0:
            continue
        quantum = params[b + tb.QUANTUM]
        coarse = max(coarse, quantum)
        for i in range(int(params[b + tb.ROWS])):
            at = b + tb.H + 3 * i
            size = st.variance(params, b, eq.row(params, at, memory[st.WEIGHED : st.WEIGHED + 3]), weighed, dt)
            x, y, turn = eq.back(normal, params, at, length, 1.0 / size)
            wrong = unsure if params[b + tb.KIND] == tb.MOUSE else 0.0
            spread(covariance, g, st.noise(params, b, eq.row(params, at, motion), moved, dt) + wrong, x, y, turn)
            add(counts, quantum * quantum / 12.0, x, y, turn)
            if memory[st.FRESH] != 0.0:
                add(covariance, quantum * quantum / 12.0, c * x - s * y, s * x + c * y, turn)
    memory[st.FRESH] = 0.0
    turn_of_counts(covariance, counts[8], coarse, g, motion)
    if not settled:
        for i in range(3):
            for j in range(3):
                memory[st.TRIAL + j] = 1.0 if i == j else 0.0
            size = st.stray_variance(params, i, dt)
            x, y, turn = eq.back(normal, memory, st.TRIAL, length, 1.0 / size)
            spread(covariance, g, size, x, y, turn)


@leaf
def turn_of_counts(covariance, variance, coarse, g, motion):  # type: ignore[no-untyped-def]
    """A heading that is wrong by part of a count turns the way of this tick, for as long as that count lasts."""
    dx, dy = motion[0], motion[1]
    way = math.hypot(dx, dy)
    if way > 0.0:
        lasts = max(1.0, coarse / way)
        add(covariance, variance * lasts, -(g[3] * dx + g[4] * dy), g[0] * dx + g[1] * dy, 0.0)


@leaf
def follow(memory, params, dt):  # type: ignore[no-untyped-def]
    """The twist, filtered, for others and to go on with."""
    if dt > 0.0:
        share = 1.0 - math.exp(-dt / params[st.TWIST_S]) if params[st.TWIST_S] > 0.0 else 1.0
        slow = 1.0 - math.exp(-dt / params[st.HORIZON_S])
        for i in range(3):
            rate = memory[st.DISPLACEMENT + i] / dt
            memory[st.TWIST + i] += share * (rate - memory[st.TWIST + i])
            memory[st.COAST + i] += slow * (rate - memory[st.COAST + i])


@leaf
def tell(memory, suspects, estimate):  # type: ignore[no-untyped-def]
    """The estimate, in the layout of `holodrive.layout`."""
    c, s = math.cos(memory[2]), math.sin(memory[2])
    p, q = memory[st.COVARIANCE : st.COVARIANCE + 9], memory[st.COUNTS : st.COUNTS + 9]
    for i in range(3):
        estimate[layout.EST_POSE + i] = memory[i]
        estimate[layout.EST_TWIST + i] = memory[st.TWIST + i]
    for i in range(9):
        estimate[layout.EST_COVARIANCE + i] = p[i]
    out = estimate[layout.EST_COVARIANCE : layout.EST_COVARIANCE + 9]
    # what counts have not told yet is known in base_link
    out[0] += c * c * q[0] - 2.0 * c * s * q[1] + s * s * q[4]
    out[1] += c * s * (q[0] - q[4]) + (c * c - s * s) * q[1]
    out[4] += s * s * q[0] + 2.0 * c * s * q[1] + c * c * q[4]
    out[2] += c * q[2] - s * q[5]
    out[5] += s * q[2] + c * q[5]
    out[8] += q[8]
    out[3], out[6], out[7] = out[1], out[2], out[5]
    estimate[layout.EST_SLIP] = memory[st.SLIP]
    estimate[layout.EST_SUSPECT] = float(suspects)
