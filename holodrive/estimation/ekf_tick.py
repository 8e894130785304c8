"""One tick of the Kalman filter: read, let the state wander, take each row if its innovation is believable, move.

Which readings are believed: rows come in the order of `ekf_rows.table`, each judged by the motion that all before it
leave likely. One sensor that contradicts is refused. If several do, the motion expected was wrong and not they: the
robot was hit, or lifted; then all are taken anew with a twist that may be anything, and whoever still contradicts
those before is refused.

Modules that turn apart contradict each other for many ticks, all the same way: no white noise, and no one wheel's
fault. What their own least squares leaves over says how much. So long all rows of modules are as uncertain as that,
and equally, and the twist is free to follow them, so that neither order, gate nor the motion before takes sides.
"""

import math

from holodrive import layout
from holodrive.estimation import ekf_rows as rw
from holodrive.estimation import ekf_state as es
from holodrive.kinematics.kernel import wrap
from holodrive.leaf import leaf

_SHORTEST_S = 1e-6  # samples nearer than this are the same sample twice
_CLOCK_RESTARTED_S, _CLOCK_SET_S = 1.0, 1e5  # a stamp so far back, or so far ahead, is a new clock
_UNEVEN = 0.02  # share of a tick's steering by which its mean is not where the timing says
_STILL_COUNTS = 20.0  # no reading of so few counts is too fast
_LEAST = 1e-16  # m^2: no sensor is perfect
_TWELFTH = 1.0 / 12.0
_APART = 9.0  # times the mean square that noise leaves: more says that modules contradict each other
_APART_S = 0.5  # in which a contradiction is forgotten
_APART_TICKS = 10.0  # for which it pushes one way
_APART_STRAYS = 100.0  # of its variance that the twist may change by, so that wheels outweigh what they told before
_SWEEP_RAD_S = 0.1  # modules that turn slower stand


@leaf
def tick(obs, memory, params, estimate):  # type: ignore[no-untyped-def]
    """One tick over the arrays of `holodrive.layout`; the first only starts."""
    n = int(params[es.SIZE])
    flags = memory[n : n + es.FLAGS]
    time = obs[layout.TIME]
    if not math.isfinite(time):
        time = flags[es.LAST_TIME] + obs[layout.DT]
    dt = time - flags[es.LAST_TIME]
    if flags[es.STARTED] == 0.0:
        start(obs, memory, params, time)
    elif dt < -_CLOCK_RESTARTED_S or dt > _CLOCK_SET_S:
        # what happened meanwhile is not known, nor how long it took
        flags[es.LAST_TIME] = time
        rebase(obs, memory, params, time)
    elif dt >= _SHORTEST_S:
        step(obs, memory, params, time, dt)
    tell(memory, params, estimate)


@leaf
def start(obs, memory, params, time):  # type: ignore[no-untyped-def]
    """The pose is known; nothing else is."""
    n, at = int(params[es.SIZE]), es.square_at(params)
    p = memory[at : at + n * n]
    flags = memory[n : n + es.FLAGS]
    flags[es.STARTED], flags[es.LAST_TIME] = 1.0, time
    es.widen(p, n, params)
    p[es.BIAS_AT * n + es.BIAS_AT] = params[es.BIAS] * params[es.BIAS]
    p[es.TIMING_AT * n + es.TIMING_AT] = params[es.TIMING] * params[es.TIMING]
    p[es.GYRO_TIMING_AT * n + es.GYRO_TIMING_AT] = params[es.GYRO_TIMING] * params[es.GYRO_TIMING]
    rebase(obs, memory, params, time)


@leaf
def rebase(obs, memory, params, time):  # type: ignore[no-untyped-def]
    """Increments count from these readings, and nothing is known of the counts that they hide."""
    n, at = int(params[es.SIZE]), es.square_at(params)
    for r in range(int(params[es.ROWS])):
        row, state = params[es.TABLE + r * rw.BLOCK :], memory[es.rows_at(params) + r * es.ROW :]
        state[es.OLD_TIME] = math.nan
        memory[n + es.GYRO_SAMPLE] = math.nan
        forget_untold(memory[:n], memory[at : at + n * n], n, row)
    read(obs, memory, params, time)


@leaf
def forget_untold(x, p, n, row):  # type: ignore[no-untyped-def]
    """What a sensor's count or sample hides may be anything again."""
    if row[rw.SLOT] >= 0.0:
        slot = int(row[rw.SLOT])
        x[slot] = 0.0
        es.set_alone(p, n, slot, own_variance(row))


@leaf
def own_variance(row):  # type: ignore[no-untyped-def]
    """Of u [m^2], evenly spread over a count; of a gyro's sample [rad^2/s^2]."""
    share = 1.0 if row[rw.KIND] == rw.GYRO else _TWELFTH
    return share * row[rw.QUANTUM] * row[rw.QUANTUM]


@leaf
def sample_at(params, time):  # type: ignore[no-untyped-def]
    """Number of the gyro's newest sample."""
    return math.floor(time / params[es.GYRO_PERIOD] + 1e-9)


@leaf
def step(obs, memory, params, time, dt):  # type: ignore[no-untyped-def]
    """Predict, update, move."""
    n, at = int(params[es.SIZE]), es.square_at(params)
    x, flags, p = memory[:n], memory[n : n + es.FLAGS], memory[at : at + n * n]
    read(obs, memory, params, time)
    es.wander(p, n, params, dt)
    now = contradiction(memory, params, dt)
    flags[es.APART] = max(now, flags[es.APART] * math.exp(-dt / _APART_S))
    es.loosen(p, n, params, _APART_STRAYS * flags[es.APART])
    if update_twice(memory, params, dt) > 1:
        es.come_back(memory, params)
        es.widen(p, n, params)
        flags[es.HITS] += 1.0
        update_twice(memory, params, dt)
    settle(memory, params, dt)
    scratch = es.square_at(params) + n * n
    es.move(x, p, n, dt, memory[scratch : scratch + n])
    flags[es.LAST_TIME] = time


@leaf
def read(obs, memory, params, time):  # type: ignore[no-untyped-def]
    """What every row tells of the time since it last did; one that is not finite or beyond reach is not read."""
    for r in range(int(params[es.ROWS])):
        row, state = params[es.TABLE + r * rw.BLOCK :], memory[es.rows_at(params) + r * es.ROW :]
        state[es.READ] = state[es.OUT] = 0.0
        if row[rw.KIND] == rw.GYRO:
            read_gyro(obs, memory, params, state, time)
        elif row[rw.KIND] == rw.MOUSE:
            at = int(row[rw.INDEX])
            state[es.Z], state[es.SPAN] = obs[layout.MICE + at], time - memory[int(params[es.SIZE]) + es.LAST_TIME]
            state[es.READ] = 1.0 if at < 2.0 * obs[layout.N_MICE] else 0.0
        else:
            read_wheel(obs, row, state, time)
        reach = row[rw.REACH] * state[es.SPAN] + _STILL_COUNTS * row[rw.QUANTUM]
        if not abs(state[es.Z]) <= reach:
            state[es.READ] = 0.0


@leaf
def read_gyro(obs, memory, params, state, time):  # type: ignore[no-untyped-def]
    """The mean of the samples at both ends, or the newest alone; nothing while the IMU holds its sample."""
    n = int(params[es.SIZE])
    rate, sample = obs[layout.GYRO], sample_at(params, time)
    state[es.SPAN] = 1.0
    if not math.isfinite(rate) or sample == memory[n + es.GYRO_SAMPLE]:
        state[es.FRESH] = 0.0
        return
    state[es.MIDDLE] = state[es.FRESH]
    state[es.Z], state[es.SWEPT] = rate, 0.0
    if state[es.FRESH] != 0.0:
        state[es.Z] = 0.5 * (rate + memory[n + es.LAST_GYRO])
        state[es.SWEPT] = rate - memory[n + es.LAST_GYRO]
    state[es.READ] = state[es.FRESH] = 1.0
    memory[n + es.LAST_GYRO], memory[n + es.GYRO_SAMPLE] = rate, sample


@leaf
def read_wheel(obs, row, state, time):  # type: ignore[no-untyped-def]
    """The way of a wheel's rim since its last reading, and where the wheel pointed meanwhile."""
    angle, steer = obs[layout.WHEEL_POSITION + int(row[rw.INDEX])], 0.0
    if row[rw.STEER] >= 0.0:
        steer = obs[layout.STEER + int(row[rw.STEER])]
    if not math.isfinite(angle + steer):
        return
    state[es.SPAN] = time - state[es.OLD_TIME]
    if state[es.SPAN] > 0.0:
        state[es.SWEPT] = wrap(steer - state[es.OLD_STEER])
        state[es.Z] = row[rw.UNIT] * (angle - state[es.OLD] - row[rw.COUPLING] * state[es.SWEPT])
        state[es.MIDDLE] = state[es.OLD_STEER] + 0.5 * state[es.SWEPT]
        state[es.READ] = 1.0
    state[es.OLD], state[es.OLD_STEER], state[es.OLD_TIME] = angle, steer, time


@leaf
def update_twice(memory, params, dt):  # type: ignore[no-untyped-def]
    """Noise follows from the way, so once with the ways that the readings tell, then with those that this gives.

    By what a sensor tells itself it would weigh more whenever it happens to tell less. Gives what `update` gives.
    """
    es.keep(memory, params)
    for r in range(int(params[es.ROWS])):
        row, state = params[es.TABLE + r * rw.BLOCK :], memory[es.rows_at(params) + r * es.ROW :]
        # a count that does not change has not told that nothing moves
        state[es.WAY] = abs(state[es.Z]) + row[rw.QUANTUM]
    update(memory, params, dt)
    for r in range(int(params[es.ROWS])):
        way(memory, params, params[es.TABLE + r * rw.BLOCK :], memory[es.rows_at(params) + r * es.ROW :])
    es.come_back(memory, params)
    return update(memory, params, dt)


@leaf
def contradiction(memory, params, dt):  # type: ignore[no-untyped-def]
    """Mean square [m^2/s^2] that the modules' own least squares leaves; 0 where noise explains it, or none turns."""
    n, first = int(params[es.SIZE]), es.rows_at(params)
    x = memory[:n]
    # the normal equations, upper half, and their right side
    xx = xy = xt = yy = yt = tt = x1 = y1 = t1 = square = noise = count = sweep = 0.0
    for r in range(int(params[es.ROWS])):
        row, state = params[es.TABLE + r * rw.BLOCK :], memory[first + r * es.ROW :]
        if row[rw.KIND] < rw.ALONG or state[es.READ] == 0.0 or state[es.SPAN] > 1.5 * dt:
            continue
        a, b, c = direction(row, state, x)
        state[es.WAY] = abs(state[es.Z]) + row[rw.QUANTUM]
        sweep = max(sweep, abs(state[es.SWEPT]))
        noise += noise_of(params, row, state, dt, 0.0, a, b, c) + 2.0 * own_variance(row)
        z = row[rw.CASTER] * state[es.SWEPT] if row[rw.KIND] == rw.ACROSS else state[es.Z]
        xx, xy, xt, yy, yt, tt = xx + a * a, xy + a * b, xt + a * c, yy + b * b, yt + b * c, tt + c * c
        x1, y1, t1, square, count = x1 + a * z, y1 + b * z, t1 + c * z, square + z * z, count + 1.0
    if count < 4.0 or sweep < _SWEEP_RAD_S * dt:
        return 0.0
    # Cramer's rule
    u, v, w = yy * tt - yt * yt, xt * yt - xy * tt, xy * yt - xt * yy
    det = xx * u + xy * v + xt * w
    if det <= 1e-9 * xx * yy * tt:
        return 0.0
    at_x = u * x1 + v * y1 + w * t1
    at_y = v * x1 + (xx * tt - xt * xt) * y1 + (xy * xt - xx * yt) * t1
    at_t = w * x1 + (xy * xt - xx * yt) * y1 + (xx * yy - xy * xy) * t1
    left = (square - (at_x * x1 + at_y * y1 + at_t * t1) / det) / (count - 3.0)
    return left / (dt * dt) if left > _APART * noise / count else 0.0


@leaf
def way(memory, params, row, state):  # type: ignore[no-untyped-def]
    """How far a sensor likely goes over the ground by the state's twist; a module along and across together."""
    n, at = int(params[es.SIZE]), es.square_at(params)
    x, p, square = memory[:n], memory[at : at + n * n], 0.0
    for side in range(2 if row[rw.KIND] >= rw.ALONG else 1):
        h = rw.H_SIDE if side else rw.H
        a, b, c = row[h], row[h + 1], row[h + 2]
        square += (a * x[es.VX] + b * x[es.VX + 1] + c * x[es.VX + 2]) ** 2 + along(p, n, a, b, c)
    state[es.WAY] = state[es.SPAN] * math.sqrt(square)


@leaf
def update(memory, params, dt):  # type: ignore[no-untyped-def]
    """Take every row that was read; give how many sensors the gate refused."""
    n, first = int(params[es.SIZE]), es.rows_at(params)
    refused, last = 0, -1.0
    memory[n + es.TICK_NIS] = memory[n + es.TICK_ROWS] = 0.0
    for r in range(int(params[es.ROWS])):
        row, state = params[es.TABLE + r * rw.BLOCK :], memory[first + r * es.ROW :]
        if state[es.READ] == 0.0:
            forget_untold(memory[:n], memory[es.square_at(params) : first], n, row)
            continue
        state[es.OUT] = 0.0 if measure(memory, params, row, state, dt) else 1.0
        who = 1000.0 * min(row[rw.KIND], rw.WHEEL) + row[rw.INDEX]
        if state[es.OUT] != 0.0 and who != last:
            refused, last = refused + 1, who
    return refused


@leaf
def measure(memory, params, row, state, dt):  # type: ignore[no-untyped-def]
    """One row into the state; False if its innovation is beyond the gate, and the state stays as it was."""
    n, at = int(params[es.SIZE]), es.square_at(params)
    x, p, gain = memory[:n], memory[at : at + n * n], memory[first_scratch(params) :]
    kind, slot, fresh = row[rw.KIND], int(row[rw.SLOT]), n - 1
    span = 1.0 if kind == rw.GYRO else state[es.SPAN]
    a, b, c = direction(row, state, x)
    told = a * x[es.VX] + b * x[es.VX + 1] + c * x[es.VX + 2]
    noise = noise_of(params, row, state, dt, memory[n + es.APART], a, b, c)
    # factors of the bias, the timing, what is untold now, what was untold before
    bias = timing = now = before = late = 0.0
    timing_at = es.GYRO_TIMING_AT if kind == rw.GYRO else es.TIMING_AT
    if kind == rw.GYRO:
        bias, now = 1.0, 1.0
        if state[es.MIDDLE] != 0.0:
            now = before = 0.5
        timing = state[es.SWEPT]
        late = timing * x[timing_at]
        es.copy_to(x, p, n, slot, fresh, 0.0, own_variance(row))
    elif kind == rw.ACROSS:
        timing = -state[es.SWEPT] * state[es.Z]
    else:
        now, before = 1.0, -1.0
        # a count's error is forgotten within a part of a count: the slope of 1 - 6 d (1 - d) at its beginning
        memory_left = math.exp(-6.0 * state[es.WAY] / row[rw.QUANTUM])
        own = own_variance(row) * (1.0 - memory_left * memory_left)
        es.copy_to(x, p, n, slot, fresh, memory_left, own)
    z = row[rw.CASTER] * state[es.SWEPT] if kind == rw.ACROSS else state[es.Z]
    # the timing of a module is already in its row's direction
    innovation = z - span * told - bias * x[es.BIAS_AT] - late
    variance = noise
    before_at = slot if slot >= 0 else fresh
    innovation -= now * x[fresh] + before * x[before_at]
    for i in range(n):
        gain[i] = span * (a * p[i * n + es.VX] + b * p[i * n + es.VX + 1] + c * p[i * n + es.VX + 2])
        gain[i] += bias * p[i * n + es.BIAS_AT] + timing * p[i * n + timing_at]
        gain[i] += now * p[i * n + fresh] + before * p[i * n + before_at]
    variance += span * (a * gain[es.VX] + b * gain[es.VX + 1] + c * gain[es.VX + 2])
    variance += bias * gain[es.BIAS_AT] + timing * gain[timing_at] + now * gain[fresh] + before * gain[before_at]
    square = innovation * innovation / variance
    believed = square <= params[es.GATE]
    if believed:
        es.take(x, p, n, gain, innovation, variance)
        if slot >= 0:
            es.copy_to(x, p, n, fresh, slot, 1.0, 0.0)
        memory[n + es.TICK_NIS] += square
        memory[n + es.TICK_ROWS] += 1.0
    else:
        forget_untold(x, p, n, row)
    x[fresh] = 0.0
    es.set_alone(p, n, fresh, 0.0)
    return believed


@leaf
def first_scratch(params):  # type: ignore[no-untyped-def]
    """Where the rows' memory ends and the gain begins."""
    return es.rows_at(params) + int(params[es.ROWS]) * es.ROW


@leaf
def direction(row, state, x):  # type: ignore[no-untyped-def]
    """The row (3) over the twist; of a module along or across where it pointed."""
    kind = row[rw.KIND]
    if kind < rw.ALONG:
        return row[rw.H], row[rw.H + 1], row[rw.H + 2]
    angle = state[es.MIDDLE] + x[es.TIMING_AT] * state[es.SWEPT]
    c, s = math.cos(angle), math.sin(angle)
    lever = 0.0
    if kind == rw.ACROSS:
        c, s, lever = -s, c, row[rw.CASTER]
    h, g = row[rw.H : rw.H + 3], row[rw.H_SIDE : rw.H_SIDE + 3]
    return c * h[0] + s * g[0], c * h[1] + s * g[1], c * h[2] + s * g[2] - lever


@leaf
def along(p, n, a, b, c):  # type: ignore[no-untyped-def]
    """Variance of the row (a, b, c) over the twist."""
    i, j, k = es.VX, es.VX + 1, es.VX + 2
    value = a * a * p[i * n + i] + b * b * p[j * n + j] + c * c * p[k * n + k]
    value += 2.0 * (a * b * p[i * n + j] + a * c * p[i * n + k] + b * c * p[j * n + k])
    return max(value, 0.0)


@leaf
def noise_of(params, row, state, dt, apart, a, b, c):  # type: ignore[no-untyped-def]
    """Variance of a row's noise that gathers [m^2]."""
    if row[rw.KIND] == rw.GYRO:
        return _LEAST
    value = _LEAST + row[rw.RELATIVE] * state[es.WAY] ** 2 + row[rw.WALK] * state[es.WAY]
    if row[rw.KIND] >= rw.ALONG:
        value += _APART_TICKS * apart * state[es.SPAN] ** 2
    if row[rw.KIND] == rw.ACROSS:
        wrong = params[es.STEER_NOISE] ** 2 + (_UNEVEN * state[es.SWEPT]) ** 2
        value += wrong * state[es.WAY] ** 2
    if state[es.SPAN] > 1.5 * dt:
        # the mean over a gap is not the twist of its last tick
        surge = params[es.SURGE] * (a * a + b * b) + params[es.YAW_SURGE] * c * c
        value += surge * state[es.SPAN] ** 3 / 3.0
    return value


@leaf
def settle(memory, params, dt):  # type: ignore[no-untyped-def]
    """Sums about innovations, which ground sensors are doubted, and slip, after all rows."""
    n, first = int(params[es.SIZE]), es.rows_at(params)
    x, flags = memory[:n], memory[n : n + es.FLAGS]
    flags[es.NIS] += flags[es.TICK_NIS]
    flags[es.NIS_ROWS] += flags[es.TICK_ROWS]
    total, count, suspect = 0.0, 0.0, 0
    for r in range(int(params[es.ROWS])):
        row, state = params[es.TABLE + r * rw.BLOCK :], memory[first + r * es.ROW :]
        flags[es.REFUSED] += state[es.OUT]
        if row[rw.KIND] == rw.MOUSE and (state[es.READ] == 0.0 or state[es.OUT] != 0.0):
            suspect |= 1 << (int(row[rw.INDEX]) // 2)
        if row[rw.KIND] != rw.GYRO and state[es.READ] != 0.0 and state[es.SPAN] < 1.5 * dt:
            a, b, c = direction(row, state, x)
            z = row[rw.CASTER] * state[es.SWEPT] if row[rw.KIND] == rw.ACROSS else state[es.Z]
            total += (z - dt * (a * x[es.VX] + b * x[es.VX + 1] + c * x[es.VX + 2])) ** 2
            count += 1.0
    flags[es.SLIP] = math.sqrt(total / count) / dt if count > 3.0 else 0.0
    flags[es.SUSPECT] = suspect


@leaf
def tell(memory, params, estimate):  # type: ignore[no-untyped-def]
    """The estimate, in the layout of `holodrive.layout`."""
    n, at = int(params[es.SIZE]), es.square_at(params)
    for i in range(3):
        estimate[layout.EST_POSE + i] = memory[i]
        estimate[layout.EST_TWIST + i] = memory[es.VX + i]
        for j in range(3):
            estimate[layout.EST_COVARIANCE + 3 * i + j] = memory[at + i * n + j]
    estimate[layout.EST_SLIP], estimate[layout.EST_SUSPECT] = memory[n + es.SLIP], memory[n + es.SUSPECT]
