"""Which sensor contradicts the others: each is judged by what the others say, over a tenth of a second.

What a motion cannot explain beyond counts, noise and a tolerance for calibration is a contradiction. It is laid to
the one sensor without which the rest agree, or to all wheels together. Where two answers fit, or none can be tested,
the only other witness is silence: a mouse that counts nothing while there is a contradiction is dead or lifted off.
Where that does not help either, all mice are in doubt, and all sensors go on being used.

A sensor left out is trusted again once it has agreed for a while in motion: at rest a dead one agrees as well. A mouse
of which one axis is stuck agrees whenever it moves along the other, so each relapse doubles that while.
"""

import math

from holodrive.estimation import sensor_state as st
from holodrive.estimation import sensor_table as tb
from holodrive.leaf import leaf

_DOUBT_S = 0.1  # a contradiction stays told for so long
_CALM = 0.5  # part of the gate below which a sensor left out agrees again
_CLEAR = 4.0  # of two answers that both fit, one must fit so much better in chi-square
_SILENT_S = 0.04  # no count for so long, and still a contradiction
_COUNTS = 4.0  # a way of so many counts is motion
_RELAPSES = 5.0  # that count: by default 9.6 s of agreement at most
_FORGOTTEN = 100.0  # one relapse is forgotten after so many times of trust in motion: by default 30 s


@leaf
def judge(params, memory, dt):  # type: ignore[no-untyped-def]
    """Leave out who contradicts, take back who agrees.

    Returns:
        Whether the set of trusted sensors changed.
    """
    changed = False
    memory[st.DOUBT] = max(0.0, memory[st.DOUBT] - dt)
    mean = memory[st.MEAN : st.MEAN + 3]
    # each round leaves one out, so it ends
    for _ in range(int(params[st.SENSORS])):
        if not st.fit_sums(params, memory, -1, -1, mean):
            break
        freedom = st.row_count(params, memory, -1) - 3
        if freedom < 1 or explained(params, freedom, st.cost(params, memory, -1, -1, mean), 1.0):
            break
        culprit = accuse(params, memory)
        if culprit == st.NOBODY:
            memory[st.DOUBT] = _DOUBT_S
            break
        dismiss(params, memory, culprit)
        changed = True
    return pardon(params, memory, dt) or changed


@leaf
def explained(params, freedom, chi_square, part):  # type: ignore[no-untyped-def]
    """Whether counts, noise and tolerance explain what is left of the readings."""
    gate = part * params[st.GATE]
    # about as rare for many degrees of freedom as for one
    return bool(chi_square <= gate * gate + 2.0 * (freedom - 1))


@leaf
def dismiss(params, memory, culprit):  # type: ignore[no-untyped-def]
    """Leave out one sensor, or all wheels; with that the contradiction is laid to somebody."""
    memory[st.DOUBT] = memory[st.SHARE] = memory[st.TOLD] = memory[st.CLEARED] = 0.0
    for s in range(int(params[st.SENSORS])):
        if not st.left_out(params, memory, s, st.NOBODY, -1) and st.left_out(params, memory, s, culprit, -1):
            m = st.STATES + s * st.STATE
            memory[m + st.OUT], memory[m + st.GOOD] = 1.0, 0.0
            # wheels slip again and again, and are sound
            if params[st.TABLE + s * tb.BLOCK + tb.KIND] == tb.MOUSE:
                memory[m + st.RELAPSES] = min(_RELAPSES + 1.0, memory[m + st.RELAPSES] + 1.0)


@leaf
def wheels_slip(params, memory):  # type: ignore[no-untyped-def]
    """Whether the rest agrees, and can disagree, without any wheel: a base pushed, stuck, or on ice."""
    trial, all_wheels = memory[st.TRIAL : st.TRIAL + 3], st.WHEELS_ALL
    freedom = st.row_count(params, memory, all_wheels) - 3
    if freedom < 1 or not st.fit_sums(params, memory, all_wheels, -1, trial):
        return False
    return explained(params, freedom, st.cost(params, memory, all_wheels, -1, trial), 1.0)


@leaf
def wheels_left_out(params, memory):  # type: ignore[no-untyped-def]
    """How many wheels are."""
    count = 0
    for s in range(int(params[st.SENSORS])):
        kind = params[st.TABLE + s * tb.BLOCK + tb.KIND]
        if kind in (tb.WHEEL, tb.MODULE) and memory[st.STATES + s * st.STATE + st.OUT] != 0.0:
            count += 1
    return count


@leaf
def accuse(params, memory):  # type: ignore[no-untyped-def]
    """Who the contradiction is laid to: a sensor, WHEELS_ALL, or NOBODY when that is not clear."""
    culprit, clear, resort, helps = try_each(params, memory)
    if culprit >= 0 and clear:
        mouse = params[st.TABLE + culprit * tb.BLOCK + tb.KIND] == tb.MOUSE
        # wheels go one by one when all begin to slip; the mice that are left with the last of them are not to blame
        if mouse and wheels_left_out(params, memory) > 0 and wheels_slip(params, memory):
            return st.WHEELS_ALL
        return culprit
    if culprit < 0 and wheels_slip(params, memory):
        return st.WHEELS_ALL
    mute = silent(params, memory)
    if mute >= 0 or culprit >= 0:
        return mute
    return resort if resort >= st.NOBODY else helps


@leaf
def try_each(params, memory):  # type: ignore[no-untyped-def]
    """Leave out each trusted sensor in turn.

    Returns:
        The one without which the rest agrees best, -1 when they agree without none; whether that is clear; the only
        one without which nothing is left to contradict (-1 when there are several, -2 when there is none); the one
        whose absence helps most, for when more than one is wrong.
    """
    trial = memory[st.TRIAL : st.TRIAL + 3]
    best, second, culprit = math.inf, math.inf, -1
    resort, least, helps = -2, math.inf, -1
    for s in range(int(params[st.SENSORS])):
        if st.left_out(params, memory, s, st.NOBODY, -1) or not st.fit_sums(params, memory, s, -1, trial):
            continue
        freedom = st.row_count(params, memory, s) - 3
        rest = st.cost(params, memory, s, -1, trial)
        if freedom < 1:
            resort = s if resort == -2 else -1
        elif not explained(params, freedom, rest, 1.0):
            least, helps = (rest, s) if rest < least else (least, helps)
        elif rest < best:
            best, second, culprit = rest, best, s
        else:
            second = min(second, rest)
    return culprit, second - best > _CLEAR, resort, helps


@leaf
def silent(params, memory):  # type: ignore[no-untyped-def]
    """The one trusted mouse that has counted nothing, -1 when there is none, or more than one."""
    found = st.NOBODY
    for s in range(int(params[st.SENSORS])):
        b, m = st.TABLE + s * tb.BLOCK, st.STATES + s * st.STATE
        if params[b + tb.KIND] != tb.MOUSE or memory[m + st.OUT] != 0.0:
            continue
        if memory[m + st.SILENT] > _SILENT_S:
            if found >= 0:
                return -1
            found = s
    return found


@leaf
def pardon(params, memory, dt):  # type: ignore[no-untyped-def]
    """Trust again who has agreed in motion for long enough."""
    changed, trial = False, memory[st.TRIAL : st.TRIAL + 3]
    for s in range(int(params[st.SENSORS])):
        b, m = st.TABLE + s * tb.BLOCK, st.STATES + s * st.STATE
        if memory[m + st.READ] == 0.0:
            continue
        moves = memory[m + st.WAY] > _COUNTS * params[b + tb.QUANTUM]
        if memory[m + st.OUT] == 0.0:
            memory[m + st.GOOD] += dt if moves else 0.0
            if memory[m + st.GOOD] > _FORGOTTEN * params[st.TRUST_S]:
                memory[m + st.RELAPSES], memory[m + st.GOOD] = max(0.0, memory[m + st.RELAPSES] - 1.0), 0.0
            continue
        freedom = st.row_count(params, memory, -1) + int(params[b + tb.ROWS]) - 3
        if not st.fit_sums(params, memory, -1, s, trial) or freedom < 1:
            continue
        if not explained(params, freedom, st.cost(params, memory, -1, s, trial), _CALM):
            memory[m + st.GOOD] = 0.0
        elif moves:
            memory[m + st.GOOD] += dt
            if memory[m + st.GOOD] > params[st.TRUST_S] * 2.0 ** max(0.0, memory[m + st.RELAPSES] - 1.0):
                memory[m + st.OUT], memory[m + st.GOOD], changed = 0.0, 0.0, True
    return changed


@leaf
def suspects(params, memory):  # type: ignore[no-untyped-def]
    """The mice that are left out, not read, or in doubt, bit k for mouse k."""
    bits = 0
    for s in range(int(params[st.SENSORS])):
        b, m = st.TABLE + s * tb.BLOCK, st.STATES + s * st.STATE
        if params[b + tb.KIND] != tb.MOUSE:
            continue
        if memory[m + st.OUT] != 0.0 or memory[m + st.READ] == 0.0 or memory[st.DOUBT] > 0.0:
            bits |= 1 << int(params[b + tb.INDEX])
    return bits
