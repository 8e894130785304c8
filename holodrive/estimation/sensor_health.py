"""Which sensor contradicts the others: each is judged by what the others say, over a tenth of a second.

What a motion cannot explain beyond counts, noise and a tolerance for calibration is a contradiction. It is laid to
the one sensor without which the rest agree. Where two answers fit, or none can be tested, the only other witness is
silence: a sensor that counts nothing at all, while the others cannot both be right and still, is dead or lifted off.
Where that does not help either, all that may be meant are in doubt, and all go on being used.

A sensor left out is trusted again once it has agreed for a while in motion: at rest a dead one agrees as well.
"""

from holodrive.estimation import sensor_state as st
from holodrive.estimation import sensor_table as tb
from holodrive.leaf import leaf

_DOUBT_S = 0.1  # a contradiction stays told for so long
_CALM = 0.5  # part of the gate below which a sensor left out agrees again
_COUNTS = 4.0  # a way of so many counts is motion


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
        if culprit < 0:
            memory[st.DOUBT] = _DOUBT_S
            break
        m = st.STATES + culprit * st.STATE
        memory[m + st.OUT], memory[m + st.GOOD], changed = 1.0, 0.0, True
    return pardon(params, memory, dt) or changed


@leaf
def explained(params, freedom, chi_square, part):  # type: ignore[no-untyped-def]
    """Whether counts, noise and tolerance explain what is left of the readings."""
    gate = part * params[st.GATE]
    return bool(chi_square <= gate * gate + freedom)


@leaf
def accuse(params, memory):  # type: ignore[no-untyped-def]
    """The sensor that the contradiction is laid to, -1 when that is not clear."""
    trial = memory[st.TRIAL : st.TRIAL + 3]
    best, second, culprit = -1.0, -1.0, -1
    last_resort, resorts, least, worst = -1, 0, -1.0, -1
    for s in range(int(params[st.SENSORS])):
        if memory[st.STATES + s * st.STATE + st.OUT] != 0.0:
            continue
        if not st.fit_sums(params, memory, s, -1, trial):
            continue
        freedom = st.row_count(params, memory, s) - 3
        rest = st.cost(params, memory, s, -1, trial)
        if freedom < 1:
            # nothing is left to contradict, which proves nothing, unless all others are proved not to be it
            last_resort, resorts = s, resorts + 1
        elif explained(params, freedom, rest, 1.0):
            if culprit < 0 or rest < best:
                best, second, culprit = rest, best, s
            elif second < 0.0 or rest < second:
                second = rest
        elif worst < 0 or rest < least:
            least, worst = rest, s
    if culprit >= 0 and second < 0.0:
        return culprit
    mute = silent(params, memory)
    if mute >= 0:
        return mute
    if culprit >= 0:
        return -1
    if resorts > 0:
        return last_resort if resorts == 1 else -1
    # more than one is wrong: begin with the one whose absence helps most
    return worst


@leaf
def silent(params, memory):  # type: ignore[no-untyped-def]
    """The one trusted mouse that has counted nothing, -1 when there is none, or more than one."""
    found = -1
    for s in range(int(params[st.SENSORS])):
        b, m = st.TABLE + s * tb.BLOCK, st.STATES + s * st.STATE
        if params[b + tb.KIND] != tb.MOUSE or memory[m + st.OUT] != 0.0:
            continue
        if memory[m + st.WAY] < params[b + tb.QUANTUM]:
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
        if memory[m + st.OUT] == 0.0 or memory[m + st.READ] == 0.0:
            continue
        freedom = st.row_count(params, memory, -1) + int(params[b + tb.ROWS]) - 3
        if not st.fit_sums(params, memory, -1, s, trial) or freedom < 1:
            continue
        if not explained(params, freedom, st.cost(params, memory, -1, s, trial), _CALM):
            memory[m + st.GOOD] = 0.0
        elif memory[m + st.WAY] > _COUNTS * params[b + tb.QUANTUM]:
            memory[m + st.GOOD] += dt
            if memory[m + st.GOOD] > params[st.TRUST_S]:
                memory[m + st.OUT], changed = 0.0, True
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
