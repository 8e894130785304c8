"""Parameters and memory of the odometries that weigh a table of sensors, and the least squares over it.

The memory begins with the pose (`layout.START_POSE`). Each sensor keeps, beside what it reads now, sums that forget
with a time constant (`HORIZON_S`): rows are linear in the body's displacement, so the sums obey the same rows, and
count noise, which a sum never gathers more than one count of, is small beside a way of a tenth of a second.
"""

import math

from holodrive.estimation import sensor_table as tb
from holodrive.kinematics import normal_equations as eq
from holodrive.leaf import leaf

# --- params ---------------------------------------------------------------------------------------
SENSORS, WHEELS, STEERS = 0, 1, 2  # rows of the table; wheels and steered wheels of the robot
TWIST_S = 3  # s, time constant of the twist's filter
HORIZON_S = 4  # s, of the sums
GATE = 5  # how many standard deviations are too many
TRUST_S = 6  # s of agreement in motion until a sensor is trusted again
COAST_S = 7  # s, with which motion that nobody tells dies away
STRAY_SPEED, STRAY_YAW = 8, 9  # m/s, rad/s: how wrong that may be
LENGTH = 10  # m that a radian counts
TABLE = 11

# --- memory: the pose (3) first -------------------------------------------------------------------
STARTED = 3
TWIST = 4  # 3: filtered
COVARIANCE = 7  # 9: what has been gathered, without the counts not told yet
DISPLACEMENT = 16  # 3: of this tick, base_link
WEIGHED = 19  # 3: displacement that the variances of this tick follow from
COAST = 22  # 3: twist to go on with where nobody tells
SLIP, DOUBT = 25, 26  # m/s; s for which a contradiction that nobody can lay to one sensor stays told
WINDOW = 27  # s of way that the sums hold
LAST_GYRO = 28  # rad/s
MEAN = 29  # 3: motion that explains the sums
TRIAL = 32  # 3: scratch
NORMAL = 35  # eq.SIZE
SUMS_NORMAL = NORMAL + eq.SIZE  # eq.SIZE
COUNTS = SUMS_NORMAL + eq.SIZE  # 9: covariance of what counts have not told yet, base_link
FRESH = COUNTS + 9  # 1 when other sensors than before begin to tell
SHARE = FRESH + 1  # of its way that some sensor may be wrong by while there is a doubt, else 0
TOLD, CLEARED = SHARE + 1, SHARE + 2  # 1 once the covariance has it; s of agreement in motion that would show it
STATES = CLEARED + 1

# --- state of one sensor ----------------------------------------------------------------------------
Z = 0  # 2: of this tick [m]
SUM = 2  # 2: that forgets [m]
NOISE = 4  # m^2 of the sums, without counts and tolerance
WAY = 5  # m that it told in the time of the sums
READ = 6  # 1 when this tick brought a reading
OUT = 7  # 1 while it is left out
GOOD = 8  # s for which it agreed while it moved
OLD, OLD_STEER = 9, 10  # rad
SILENT = 11  # s since it told anything but zero
DUE = 12  # m that it told or should have, whichever is more: what it may be wrong by follows from that
RELAPSES = 13  # how often it was left out, not long ago
STATE = 14

_COUNTS_S = 1.0  # for how long counts are added up before they matter
_LEAST = 1e-18  # m^2: no sensor is perfect
NOBODY, WHEELS_ALL = -1, -2  # beside the number of a sensor, as answers to who is wrong


@leaf
def variance(params, b, way, moved, dt):  # type: ignore[no-untyped-def]
    """Of one row of the sensor at params[b] in one tick [m^2], as it is worth in the long run.

    A count not told now is told later, so that counts matter less the longer one adds up. Were they weighed as noise
    of every tick, a slow robot would believe coarse noise that stays rather than fine counts that do not.
    """
    counts = params[b + tb.QUANTUM] * params[b + tb.QUANTUM] / 6.0
    return min(1.0, dt / _COUNTS_S) * counts + noise(params, b, way, moved, dt) + _LEAST


@leaf
def noise(params, b, way, moved, dt):  # type: ignore[no-untyped-def]
    """The part of it that is not counts: it gathers from tick to tick [m^2].

    Most of it goes with how far the base moved, not the sensor: rollers wander while their wheel stands, too, and
    weights that hardly change from tick to tick let counts cancel.
    """
    return params[b + tb.RELATIVE] * way * way + params[b + tb.WALK] * moved + params[b + tb.DRIFT] * dt


@leaf
def moved_by(params, memory, at):  # type: ignore[no-untyped-def]
    """How far the base moves by the displacement at memory[at], a turn counted with the length of a radian [m]."""
    return math.hypot(memory[at], memory[at + 1]) + params[LENGTH] * abs(memory[at + 2])


@leaf
def sum_variance(params, memory, s):  # type: ignore[no-untyped-def]
    """Of the sums of sensor `s` [m^2], and never nothing."""
    b, m = TABLE + s * tb.BLOCK, STATES + s * STATE
    counts, wrong = params[b + tb.QUANTUM] ** 2 / 6.0, params[b + tb.TOLERANCE] * memory[m + DUE]
    return counts + memory[m + NOISE] + wrong * wrong + _LEAST


@leaf
def left_out(params, memory, s, without, back):  # type: ignore[no-untyped-def]
    """Whether sensor `s` does not count when `without` (one, or WHEELS_ALL, or NOBODY) is left out and `back` is in."""
    if s == without or (memory[STATES + s * STATE + OUT] != 0.0 and s != back):
        return True
    kind = params[TABLE + s * tb.BLOCK + tb.KIND]
    return without == WHEELS_ALL and kind in (tb.WHEEL, tb.MODULE)


@leaf
def row_count(params, memory, without):  # type: ignore[no-untyped-def]
    """Rows of the trusted sensors."""
    rows = 0
    for s in range(int(params[SENSORS])):
        if not left_out(params, memory, s, without, -1):
            rows += int(params[TABLE + s * tb.BLOCK + tb.ROWS])
    return rows


@leaf
def fit_tick(params, memory, dt):  # type: ignore[no-untyped-def]
    """The displacement of this tick by the trusted sensors that were read, into `DISPLACEMENT`.

    Twice, for the variances follow from the motion: first from that of the tick before, then from what the first
    found. By what a sensor reads itself it would weigh more whenever it happens to read less.

    Returns:
        Whether they tell all three motions; if not, what they leave open goes on as it went, and dies away.
    """
    fit_once(params, memory, dt)
    for i in range(3):
        memory[WEIGHED + i] = memory[DISPLACEMENT + i]
    return fit_once(params, memory, dt)


@leaf
def fit_once(params, memory, dt):  # type: ignore[no-untyped-def]
    """The same with the variances of the motion `WEIGHED`."""
    normal, length = memory[NORMAL : NORMAL + eq.SIZE], params[LENGTH]
    motion, out = memory[WEIGHED : WEIGHED + 3], memory[DISPLACEMENT : DISPLACEMENT + 3]
    moved = moved_by(params, memory, WEIGHED)
    eq.clear(normal)
    for s in range(int(params[SENSORS])):
        b, m = TABLE + s * tb.BLOCK, STATES + s * STATE
        if memory[m + OUT] != 0.0 or memory[m + READ] == 0.0:
            continue
        for i in range(int(params[b + tb.ROWS])):
            at = b + tb.H + 3 * i
            weight = 1.0 / variance(params, b, eq.row(params, at, motion), moved, dt)
            eq.take(normal, params, at, length, memory[m + Z + i], weight)
    if eq.solve(normal, length, out):
        return True
    # a unit row for each motion: what the readings tell outweighs it by far
    fading = math.exp(-dt / params[COAST_S])
    for i in range(3):
        for j in range(3):
            memory[TRIAL + j] = 1.0 if i == j else 0.0
        eq.take(normal, memory, TRIAL, length, fading * memory[COAST + i] * dt, 1.0 / stray_variance(params, i, dt))
    eq.solve(normal, length, out)
    return False


@leaf
def stray_variance(params, i, dt):  # type: ignore[no-untyped-def]
    """Of a displacement that nobody tells, each tick: as wrong as can be for the time in which it dies away."""
    fastest = params[STRAY_YAW] if i == 2 else params[STRAY_SPEED]
    return fastest * fastest * max(dt, 1e-6) * params[COAST_S]


@leaf
def fit_sums(params, memory, without, back, out):  # type: ignore[no-untyped-def]
    """The motion (3,) that explains the sums of the trusted sensors but `without`, and of `back`; False if open."""
    normal, length = memory[SUMS_NORMAL : SUMS_NORMAL + eq.SIZE], params[LENGTH]
    eq.clear(normal)
    for s in range(int(params[SENSORS])):
        b, m = TABLE + s * tb.BLOCK, STATES + s * STATE
        if left_out(params, memory, s, without, back):
            continue
        weight = 1.0 / sum_variance(params, memory, s)
        for i in range(int(params[b + tb.ROWS])):
            eq.take(normal, params, b + tb.H + 3 * i, length, memory[m + SUM + i], weight)
    return bool(eq.solve(normal, length, out))


@leaf
def cost(params, memory, without, back, motion):  # type: ignore[no-untyped-def]
    """Chi-square of the same sums about that motion."""
    total = 0.0
    for s in range(int(params[SENSORS])):
        if left_out(params, memory, s, without, back):
            continue
        total += square(params, memory, s, motion) / sum_variance(params, memory, s)
    return total


@leaf
def square(params, memory, s, motion):  # type: ignore[no-untyped-def]
    """Squared residual of the sums of one sensor about a motion [m^2]."""
    b, m, total = TABLE + s * tb.BLOCK, STATES + s * STATE, 0.0
    for i in range(int(params[b + tb.ROWS])):
        rest = memory[m + SUM + i] - eq.row(params, b + tb.H + 3 * i, motion)
        total += rest * rest
    return total
