"""Open-loop PWM steps of one group of wheels after another, for calibration: the schedule as a compiled controller.

For each group and both directions in turn: bisection between standing and moving, down to one count; then full PWM;
then always the middle of the two neighbouring PWM values between which the speed is least sure, by the bend of the
curve there or else by how far they are apart, until enough have moved. Directions alternate, so that the robot stays
about where it is. Before each step it waits until the robot stands. It ends with a fault when the robot strays, does
not come to rest, cannot be measured, or does not move at full PWM.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from holodrive import layout
from holodrive.errors import InputError
from holodrive.interfaces import CommandKind
from holodrive.leaf import leaf
from holodrive.robots.spec import Robot
from holodrive.types import Array

MOST = 32  # levels that may be asked for
MOST_LEVELS = 40  # that are kept: bisection may find some more

# parameters: numbers, then for each group: whether it is measured by the pose, m of its sensor's count,
# m a radian of its first wheel, how many wheels, their indices
_COUNTS, _LEVELS, _STEP_S, _STILL_S, _WAIT_S, _STRAY_M, _GROUPS, _FIRST = range(8)
_BY_POSE, _COUNT_M, _RADIUS, _MEMBERS, _MEMBER = range(5)
_GROUP = _MEMBER + layout.MAX_WHEELS

# memory
_PHASE, _SINCE, _GROUP_NOW, _SIDE, _PWM = range(5)  # of what is going on; since when [s]
_HOME, _FROM, _ANCHOR = 5, 7, 12  # 2: first place; 4: pose and wheel at the step's start; 3: last place that differed
_ANCHOR_TIME, _MID, _MID_TIME = 15, 16, 17  # s, m, s
_SIDES = 18  # two blocks: forward, backward
_LOW, _HIGH, _COUNT, _TABLE = range(4)  # last still, first moving, how many moved, their PWM and speeds by PWM
_BLOCK = _TABLE + 2 * MOST_LEVELS
MEMORY = _SIDES + 2 * _BLOCK

_FRESH, _WAITING, _STEPPING, _OVER = range(4)  # phases
_MOVED_COUNTS = 3.0  # of the sensor, as in `calibration.step_response`
_NEAR_COUNTS = 1.5  # what a standing robot's sensor may flicker
_STRAIGHT = 0.01  # of the fastest speed: a straight line between neighbours that is surer needs no step for its bend
_EVEN = 0.03  # the same: neighbours that differ by less need no step between them
_MID_AT = 0.5  # of a step: the speed that guides the schedule is measured from there

STRAYED, RESTLESS, BLIND, STUCK = 1, 2, 3, 4  # faults


@leaf
def duty_steps_kernel(obs, memory, params, command):  # type: ignore[no-untyped-def]
    """One tick of the schedule."""
    x, y = obs[layout.POSE], obs[layout.POSE + 1]
    if memory[_PHASE] == _FRESH:
        memory[_HOME], memory[_HOME + 1] = x, y
        memory[_GROUP_NOW] = -1.0
        next_group(memory, params)
        begin_waiting(memory, params, obs)
    if memory[_PHASE] == _OVER:
        command[layout.ARRIVED] = 1.0
        return
    group = _FIRST + int(memory[_GROUP_NOW]) * _GROUP
    wheel = obs[layout.WHEEL_POSITION + int(params[group + _MEMBER])]
    seen = x + y + obs[layout.POSE + 2] + (0.0 if params[group + _BY_POSE] != 0.0 else wheel)
    fault = 0
    if not math.isfinite(seen):
        fault = BLIND
    elif math.hypot(x - memory[_HOME], y - memory[_HOME + 1]) > params[_STRAY_M]:
        fault = STRAYED
    elif memory[_PHASE] == _STEPPING:
        fault = watch_step(memory, params, obs, group)
    elif memory[_PHASE] == _WAITING:
        fault = watch_rest(memory, params, obs, group)
    if fault != 0:
        memory[_PHASE] = _OVER
        command[layout.FAULT], command[layout.ARRIVED] = fault, 1.0
    elif memory[_PHASE] == _OVER:
        command[layout.ARRIVED] = 1.0
    elif memory[_PHASE] == _STEPPING:
        group = _FIRST + int(memory[_GROUP_NOW]) * _GROUP  # the step that begins may be the first of the next group
        duty = memory[_PWM] / params[_COUNTS] * (1.0 if memory[_SIDE] == 0.0 else -1.0)
        for k in range(int(params[group + _MEMBERS])):
            command[layout.VALUE + int(params[group + _MEMBER + k])] = duty


@leaf
def watch_step(memory, params, obs, group):  # type: ignore[no-untyped-def]
    """While a PWM is held: note the middle; at the end take the speed and go on to rest. Gives a fault or 0."""
    time, since = obs[layout.TIME], obs[layout.TIME] - memory[_SINCE]
    travel = travelled(memory, params, obs, group)
    if since < _MID_AT * params[_STEP_S]:
        memory[_MID], memory[_MID_TIME] = travel, time
    if since < params[_STEP_S] - 0.5 * obs[layout.DT]:
        return 0
    pwm, side = memory[_PWM], _SIDES + int(memory[_SIDE]) * _BLOCK
    if travel > _MOVED_COUNTS * params[group + _COUNT_M]:
        note(memory, side, pwm, (travel - memory[_MID]) / (time - memory[_MID_TIME]))
        memory[side + _HIGH] = min(memory[side + _HIGH], pwm)
    elif pwm >= params[_COUNTS]:
        return STUCK
    elif pwm < memory[side + _HIGH]:
        memory[side + _LOW] = max(memory[side + _LOW], pwm)
    begin_waiting(memory, params, obs)
    return 0


@leaf
def watch_rest(memory, params, obs, group):  # type: ignore[no-untyped-def]
    """Between steps: wait until nothing has moved for a while, then choose and begin the next. Gives a fault or 0."""
    time, near = obs[layout.TIME], _NEAR_COUNTS * params[group + _COUNT_M]
    wheel = params[group + _RADIUS] * obs[layout.WHEEL_POSITION + int(params[group + _MEMBER])]
    moved = math.hypot(obs[layout.POSE] - memory[_ANCHOR], obs[layout.POSE + 1] - memory[_ANCHOR + 1])
    if params[group + _BY_POSE] == 0.0:
        moved = abs(wheel - memory[_ANCHOR + 2])
    if moved > near:
        memory[_ANCHOR], memory[_ANCHOR + 1] = obs[layout.POSE], obs[layout.POSE + 1]
        memory[_ANCHOR + 2], memory[_ANCHOR_TIME] = wheel, time
    if time - memory[_ANCHOR_TIME] < params[_STILL_S]:
        return RESTLESS if time - memory[_SINCE] > params[_WAIT_S] else 0
    if not choose(memory, params):
        next_group(memory, params)
        if memory[_GROUP_NOW] >= params[_GROUPS]:
            memory[_PHASE] = _OVER
            return 0
        choose(memory, params)
        wheel = first_wheel(params, memory, obs)
    memory[_PHASE], memory[_SINCE] = _STEPPING, time
    for i in range(3):
        memory[_FROM + i] = obs[layout.POSE + i]
    memory[_FROM + 3], memory[_MID], memory[_MID_TIME] = wheel, 0.0, time
    return 0


@leaf
def first_wheel(params, memory, obs):  # type: ignore[no-untyped-def]
    """Rim travel [m] of the first wheel of the group whose turn it is."""
    group = _FIRST + int(memory[_GROUP_NOW]) * _GROUP
    return params[group + _RADIUS] * obs[layout.WHEEL_POSITION + int(params[group + _MEMBER])]


@leaf
def begin_waiting(memory, params, obs):  # type: ignore[no-untyped-def]
    """No duty from now on; the place and time from which rest is judged."""
    memory[_PHASE], memory[_SINCE] = _WAITING, obs[layout.TIME]
    memory[_ANCHOR], memory[_ANCHOR + 1] = obs[layout.POSE], obs[layout.POSE + 1]
    memory[_ANCHOR + 2], memory[_ANCHOR_TIME] = first_wheel(params, memory, obs), obs[layout.TIME]


@leaf
def travelled(memory, params, obs, group):  # type: ignore[no-untyped-def]
    """Distance [m] since the step began: along the diagonal in the robot's frame, or of the wheel's rim."""
    if params[group + _BY_POSE] == 0.0:
        wheel = obs[layout.WHEEL_POSITION + int(params[group + _MEMBER])]
        return abs(params[group + _RADIUS] * wheel - memory[_FROM + 3])
    dx, dy = obs[layout.POSE] - memory[_FROM], obs[layout.POSE + 1] - memory[_FROM + 1]
    c, s = math.cos(memory[_FROM + 2]), math.sin(memory[_FROM + 2])
    return (abs(c * dx + s * dy) + abs(c * dy - s * dx)) * math.sqrt(0.5)


@leaf
def next_group(memory, params):  # type: ignore[no-untyped-def]
    """Forget what was learnt and take the next group; backward first to begin, so that `choose` begins forward."""
    memory[_GROUP_NOW] += 1.0
    memory[_SIDE] = 1.0
    for side in range(2):
        at = _SIDES + side * _BLOCK
        memory[at + _LOW], memory[at + _HIGH], memory[at + _COUNT] = 0.0, params[_COUNTS], 0.0


@leaf
def choose(memory, params):  # type: ignore[no-untyped-def]
    """The next PWM of the other direction, or of the same where the other has all it needs; False when both have."""
    for _ in range(2):
        memory[_SIDE] = 1.0 - memory[_SIDE]
        memory[_PWM] = wanted(memory, params, _SIDES + int(memory[_SIDE]) * _BLOCK)
        if memory[_PWM] > 0.0:
            return True
    return False


@leaf
def wanted(memory, params, side):  # type: ignore[no-untyped-def]
    """The PWM that would tell most of one direction; 0 when it is known well enough."""
    low, high, count = memory[side + _LOW], memory[side + _HIGH], int(memory[side + _COUNT])
    if high - low > 1.0:
        return math.floor(0.5 * (low + high))
    table = side + _TABLE
    if count == 0 or memory[table + 2 * (count - 1)] < params[_COUNTS]:
        return params[_COUNTS]
    if count >= params[_LEVELS]:
        return 0.0
    top = memory[table + 2 * (count - 1) + 1]
    bent, gap = 0.0, 0.0
    most_bent, widest = _STRAIGHT * top, _EVEN * top
    for k in range(count):
        pwm, speed = place(memory, table, low, k - 1)
        after, faster = place(memory, table, low, k)
        if after - pwm <= 1.0:
            continue
        middle, rise = math.floor(0.5 * (after + pwm)), faster - speed
        unsure = min(rise, 0.25 * (after - pwm) * bend(memory, table, low, k, count))
        if unsure > most_bent:
            bent, most_bent = middle, unsure
        if rise > widest:
            gap, widest = middle, rise
    return bent if bent > 0.0 else gap


@leaf
def place(memory, table, low, k):  # type: ignore[no-untyped-def]
    """PWM and speed of the k-th that moved; before the first stands the last that stood."""
    if k < 0:
        return low, 0.0
    return memory[table + 2 * k], memory[table + 2 * k + 1]


@leaf
def bend(memory, table, low, k, count):  # type: ignore[no-untyped-def]
    """How much the slope changes from the stretch that ends at the k-th PWM to its neighbours [m/s a count]."""
    p0, v0 = place(memory, table, low, k - 1)
    p1, v1 = place(memory, table, low, k)
    slope, most = (v1 - v0) / (p1 - p0), 0.0
    if k > 0:
        p, v = place(memory, table, low, k - 2)
        most = abs(slope - (v0 - v) / (p0 - p))
    if k < count - 1:
        p, v = place(memory, table, low, k + 1)
        most = max(most, abs((v - v1) / (p - p1) - slope))
    return most


@leaf
def note(memory, side, pwm, speed):  # type: ignore[no-untyped-def]
    """Enter a PWM that moved, and its speed [m/s], into the table of one direction, in the order of PWM."""
    count = int(memory[side + _COUNT])
    if count >= MOST_LEVELS:
        return
    at = side + _TABLE + 2 * count
    while at > side + _TABLE and memory[at - 2] > pwm:
        memory[at], memory[at + 1] = memory[at - 2], memory[at - 1]
        at -= 2
    memory[at], memory[at + 1] = pwm, speed
    memory[side + _COUNT] = count + 1.0


@dataclass(frozen=True)
class DutySteps:
    """Open-loop steps that calibrate the actuators.

    Attributes:
        groups: wheels that are driven together: their indices, whether the robot's pose tells their travel (else the
            first wheel's encoder does), and one count of that sensor [m].
        counts: of full PWM.
        levels: PWM values to see moving in each direction.
        step_s: how long a PWM is held.
        still_s: how long nothing may move before a step.
        wait_s: how long the robot may take to come to rest after one.
        stray_m: how far from its first place it may get.
    """

    groups: tuple[tuple[tuple[int, ...], bool, float], ...]
    counts: float = 255.0
    levels: float = 20
    step_s: float = 1.5
    still_s: float = 0.2
    wait_s: float = 5.0
    stray_m: float = 0.5

    command_kind: ClassVar[CommandKind] = "duty"
    kernel: ClassVar[Any] = staticmethod(duty_steps_kernel)

    def __post_init__(self) -> None:
        checked_numbers(self)

    @property
    def faults(self) -> dict[int, str]:
        """What the fault numbers mean."""
        return {
            STRAYED: f"the robot strayed more than {self.stray_m:g} m from where it began; hold steps for less time",
            RESTLESS: f"the robot has not come to rest {self.wait_s:g} s after a step",
            BLIND: "the robot cannot tell how it moves: its position, or a wheel's, is not a number",
            STUCK: "wheels do not move at full PWM, or nothing measures that they do",
        }

    @property
    def longest_s(self) -> float:
        """No schedule takes longer than this [s]: bisection and all levels, each with the longest wait."""
        each = self.step_s + self.still_s + self.wait_s
        return 2.0 * len(self.groups) * (math.ceil(math.log2(self.counts)) + self.levels + 2.0) * each

    def memory_size(self, robot: Robot) -> int:
        """What is known of the group under way, and of the step."""
        return MEMORY

    def pack(self, robot: Robot) -> Array:
        """As the kernel's index constants say."""
        rows = [_group_row(robot, *group) for group in self.groups]
        head = (self.counts, self.levels, self.step_s, self.still_s, self.wait_s, self.stray_m, len(rows))
        return np.array([*head, *(value for row in rows for value in row)], dtype=np.float64)


def checked_numbers(plug: DutySteps) -> None:
    """Refuse numbers that no schedule can have.

    Raises:
        InputError: naming the parameter.
    """
    for name in ("counts", "levels", "step_s", "still_s", "wait_s", "stray_m"):
        value = getattr(plug, name)
        if not (isinstance(value, int | float) and math.isfinite(value) and value > 0.0):
            raise InputError(f"DutySteps.{name} is {value!r}; it must be a number above 0")
    if plug.counts != int(plug.counts) or plug.counts < 2:
        raise InputError(f"DutySteps.counts is {plug.counts:g}; PWM has a whole number of counts, at least 2")
    if not 4 <= plug.levels <= MOST:
        raise InputError(f"DutySteps.levels is {plug.levels:g}; allowed: 4 to {MOST}")
    if not plug.groups:
        raise InputError("DutySteps.groups is empty; give at least one group of wheels")


def _group_row(robot: Robot, wheels: Sequence[int], by_pose: bool, count_m: float) -> list[float]:
    members = [*map(float, wheels), *([0.0] * (layout.MAX_WHEELS - len(wheels)))]
    return [float(by_pose), count_m, robot.wheels[wheels[0]].radius, float(len(wheels)), *members]


__all__ = ["DutySteps", "duty_steps_kernel"]
