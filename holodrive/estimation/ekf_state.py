"""Parameters and memory of the Kalman filter, and the steps that every such filter has, on flat arrays.

The state is x = (pose 3, twist 3, gyro bias, timing of steering and of gyro, one for each sensor that counts or
samples, one fresh). Its first three numbers are the pose, as `layout.START_POSE` wants it. The covariance is a full
square, row by row, kept symmetric to the last bit.
"""

from holodrive.estimation.dead_reckoning import advance, levers
from holodrive.leaf import leaf

_TIMING_WALK = 0.04  # 1/s: part of its variance that a timing gains in a second

# --- params ---------------------------------------------------------------------------------------
SIZE = 0  # N of the state, with the fresh one at its end
ROWS = 1  # of the table
GATE = 2  # standard deviations, squared
SURGE, YAW_SURGE = 3, 4  # m^2/s^3, rad^2/s^3: variance by which the twist strays in a second
STRAY, YAW_STRAY = 5, 6  # m/s, rad/s: how fast the robot may be when nobody knows
BIAS, BIAS_WALK = 7, 8  # rad/s, rad^2/s^3: of the start, gained in a second
GYRO_PERIOD = 9  # s
STEER_NOISE = 10  # rad
TIMING, GYRO_TIMING = 11, 12  # shares of a tick by which steering angles, the gyro may be told too late or too early
TABLE = 13

# --- state ----------------------------------------------------------------------------------------
POSE, VX, BIAS_AT = 0, 3, 6  # m, m, rad; m/s, m/s, rad/s; rad/s
TIMING_AT, GYRO_TIMING_AT = 7, 8  # shares of a tick

# --- memory: the state (N) first, then these, then the covariance, a copy of both, and the rows' -------------
STARTED = 0
LAST_TIME = 1  # s
LAST_GYRO = 2  # rad/s
GYRO_SAMPLE = 3  # number of the sample that LAST_GYRO is
SUSPECT = 4  # bits
SLIP = 5  # m/s
NIS, NIS_ROWS = 6, 7  # sum of squared innovations over their variances since the start, and how many
REFUSED = 8  # rows that the gate refused, since the start
HITS = 9  # ticks at which more than one sensor contradicted the motion expected
TICK_NIS, TICK_ROWS = 10, 11  # of the last tick
APART = 12  # m^2/s^2: mean square by which modules contradict each other
FLAGS = 13

# --- memory of one row ------------------------------------------------------------------------------
Z = 0  # m since OLD_TIME; rad/s of a gyro
READ = 1  # 1 when this tick brought a reading
OUT = 2  # 1 when the gate refused it
SPAN = 3  # s that Z is of
OLD, OLD_STEER, OLD_TIME = 4, 5, 6  # rad, rad, s: of the last reading
MIDDLE = 7  # rad, steering angle of a module over the span; 1 where a gyro's Z is the mean of two samples
SWEPT = 8  # rad that the module has turned in it; rad/s between a gyro's two samples
FRESH = 9  # 1 when a gyro's last sample was of the tick before
WAY = 10  # m that the sensor, or the contact of its wheel, goes over the ground in Z
ROW = 11


@leaf
def square_at(params):  # type: ignore[no-untyped-def]
    """Where the covariance begins in the memory."""
    return int(params[SIZE]) + FLAGS


@leaf
def rows_at(params):  # type: ignore[no-untyped-def]
    """Where the rows' memory begins."""
    n = int(params[SIZE])
    return n + FLAGS + n * n + n + n * n


@leaf
def keep(memory, params):  # type: ignore[no-untyped-def]
    """Copy state and covariance, to come back to."""
    n, at = int(params[SIZE]), square_at(params)
    to = at + n * n
    for i in range(n):
        memory[to + i] = memory[i]
    for i in range(n * n):
        memory[to + n + i] = memory[at + i]


@leaf
def come_back(memory, params):  # type: ignore[no-untyped-def]
    """State and covariance as they were kept."""
    n, at = int(params[SIZE]), square_at(params)
    source = at + n * n
    for i in range(n):
        memory[i] = memory[source + i]
    for i in range(n * n):
        memory[at + i] = memory[source + n + i]


@leaf
def set_alone(p, n, i, variance):  # type: ignore[no-untyped-def]
    """State `i` has this variance and nothing to do with the others."""
    for j in range(n):
        p[i * n + j] = p[j * n + i] = 0.0
    p[i * n + i] = variance


@leaf
def copy_to(x, p, n, source, to, share, more):  # type: ignore[no-untyped-def]
    """State `to` becomes `share` times state `source`, and of `more` variance of its own."""
    own = share * share * p[source * n + source] + more
    x[to] = share * x[source]
    for j in range(n):
        p[to * n + j] = share * p[source * n + j]
    for j in range(n):
        p[j * n + to] = p[to * n + j]
    p[to * n + to] = own


@leaf
def wander(p, n, params, dt):  # type: ignore[no-untyped-def]
    """What the twist, the bias and the timing may have changed in `dt` [s]."""
    for i in range(3):
        surge = params[YAW_SURGE] if i == 2 else params[SURGE]
        p[(VX + i) * n + VX + i] += surge * dt
    p[BIAS_AT * n + BIAS_AT] += params[BIAS_WALK] * dt
    for i, timing in ((TIMING_AT, params[TIMING]), (GYRO_TIMING_AT, params[GYRO_TIMING])):
        p[i * n + i] += _TIMING_WALK * timing * timing * dt


@leaf
def widen(p, n, params):  # type: ignore[no-untyped-def]
    """The twist may be anything: the robot was hit, or set down."""
    for i in range(3):
        stray = params[YAW_STRAY] if i == 2 else params[STRAY]
        p[(VX + i) * n + VX + i] += stray * stray


@leaf
def take(x, p, n, gain, innovation, variance):  # type: ignore[no-untyped-def]
    """One scalar measurement: x <- x + K nu, P <- P - K S K'.

    Args:
        x, p, n: state, covariance, size.
        gain: (n,) holds P h, becomes K.
        innovation, variance: of the measurement, S = h P h + R.
    """
    for i in range(n):
        gain[i] /= variance
        x[i] += gain[i] * innovation
    for i in range(n):
        for j in range(i, n):
            value = p[i * n + j] - gain[i] * variance * gain[j]
            p[i * n + j] = p[j * n + i] = value


@leaf
def move(x, p, n, dt, scratch):  # type: ignore[no-untyped-def]
    """The pose by the exact exponential of twist times dt, its covariance by the exact derivatives.

    T <- T exp(xi dt), P <- F P F' with the pose's rows of F = (A over the pose, G dt over the twist).

    Args:
        scratch: (n,) of which six are used.
    """
    for i in range(3):
        scratch[3 + i] = x[VX + i] * dt
    motion, heading = scratch[3:6], x[2]
    a, b, u, d, e, v = levers(heading, motion)
    x0, y0 = x[0], x[1]
    advance(x[:3], motion)
    way_x, way_y = x[0] - x0, x[1] - y0
    for j in range(n):
        theta, f, g, h = p[2 * n + j], dt * p[VX * n + j], dt * p[(VX + 1) * n + j], dt * p[(VX + 2) * n + j]
        p[j] += -way_y * theta + a * f + b * g + u * h
        p[n + j] += way_x * theta + d * f + e * g + v * h
        p[2 * n + j] += h
    for j in range(n):
        r = j * n
        theta, f, g, h = p[r + 2], dt * p[r + VX], dt * p[r + VX + 1], dt * p[r + VX + 2]
        p[r] += -way_y * theta + a * f + b * g + u * h
        p[r + 1] += way_x * theta + d * f + e * g + v * h
        p[r + 2] += h
    for i in range(3):
        for j in range(i + 1, n):
            p[i * n + j] = p[j * n + i]


@leaf
def loosen(p, n, params, apart):  # type: ignore[no-untyped-def]
    """What the twist was tells little while modules contradict each other: `apart` [m^2/s^2] more variance."""
    for i in range(3):
        share = params[YAW_STRAY] / params[STRAY] if i == 2 else 1.0
        p[(VX + i) * n + VX + i] += apart * share * share
