"""What a doubt costs: how wrong the pose may be while a contradiction can be laid to nobody.

All sensors go on being used then, and one of them is wrong by a share of its way that the contradiction tells. Such
an error does not cancel from tick to tick; it is taken to stay for half a second, for robots turn back.

A doubt does not end with the contradiction, for in many motions there is none to see: two mice that go across the line
between them read any fault as a turn. It ends when all have agreed for a while in motion in which they could not have,
had any one of them been wrong by that share.
"""

import math

from holodrive.estimation import sensor_state as st
from holodrive.estimation import sensor_table as tb
from holodrive.leaf import leaf

# s: a fault is that old when two mice tell it (median 0.1, 90 % 0.7), and a motion that it spoils lasts as long
_LASTS_S = 0.5


@leaf
def weigh_doubt(params, memory, dt):  # type: ignore[no-untyped-def]
    """After the judge: begin, keep or end the doubt; `SHARE` is 0 without one."""
    if memory[st.DOUBT] <= 0.0 and memory[st.SHARE] == 0.0:
        return
    rows = st.row_count(params, memory, -1)
    mean = memory[st.MEAN : st.MEAN + 3]
    if rows <= 3 or not st.fit_sums(params, memory, -1, -1, mean):
        # who is left cannot contradict, and the motion that nobody tells has a variance of its own
        memory[st.SHARE] = memory[st.TOLD] = memory[st.CLEARED] = 0.0
        return
    if memory[st.DOUBT] > 0.0:
        moved = max(st.moved_by(params, memory, st.MEAN), 1e-9)
        # the error of one row, of which the fit leaves (rows - 3) / rows of the square to see
        wrong = math.sqrt(squares(params, memory, mean) * rows / (rows - 3))
        memory[st.SHARE] = max(memory[st.SHARE], min(1.0, wrong / moved))
        memory[st.CLEARED] = 0.0
    elif would_show(params, memory):
        memory[st.CLEARED] += dt
        if memory[st.CLEARED] > params[st.TRUST_S]:
            memory[st.SHARE] = memory[st.TOLD] = memory[st.CLEARED] = 0.0


@leaf
def squares(params, memory, motion):  # type: ignore[no-untyped-def]
    """Sum of the squared residuals of the trusted sensors [m^2]."""
    total = 0.0
    for s in range(int(params[st.SENSORS])):
        if not st.left_out(params, memory, s, st.NOBODY, -1):
            total += st.square(params, memory, s, motion)
    return total


@leaf
def would_show(params, memory):  # type: ignore[no-untyped-def]
    """Whether the gate would be passed, were any one of the trusted mice wrong by the share in doubt."""
    trial, keep = memory[st.TRIAL : st.TRIAL + 3], 1.0 - memory[st.SHARE]
    gate = params[st.GATE] ** 2 + 2.0 * (st.row_count(params, memory, -1) - 4)
    for s in range(int(params[st.SENSORS])):
        m = st.STATES + s * st.STATE
        if params[st.TABLE + s * tb.BLOCK + tb.KIND] != tb.MOUSE or memory[m + st.OUT] != 0.0:
            continue
        x, y = memory[m + st.SUM], memory[m + st.SUM + 1]
        memory[m + st.SUM], memory[m + st.SUM + 1] = keep * x, keep * y
        shown = st.fit_sums(params, memory, -1, -1, trial) and st.cost(params, memory, -1, -1, trial) > gate
        memory[m + st.SUM], memory[m + st.SUM + 1] = x, y
        if not shown:
            return False
    return True


@leaf
def doubted(params, memory, moved, dt):  # type: ignore[no-untyped-def]
    """Variance that the doubt gives to a row of a mouse in a tick in which the base moves by `moved` [m^2].

    An error of the speed v that stays for T adds 2 v^2 T dt a tick, and (v T)^2 of the time before it was told.
    """
    if memory[st.SHARE] == 0.0 or dt <= 0.0:
        return 0.0
    wrong = memory[st.SHARE] * moved / dt
    since = 2.0 * dt if memory[st.TOLD] != 0.0 else _LASTS_S
    memory[st.TOLD] = 1.0
    # one sensor is wrong, in one direction: its square is shared by all rows
    return wrong * wrong * _LASTS_S * since / st.row_count(params, memory, -1)
