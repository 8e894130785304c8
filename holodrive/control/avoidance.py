"""The kernel of fuzzy avoidance: scan to points to sectors to rules, blended with a wish, held back by barriers.

At each scan: points of the odometry frame, tracks of what moves, least distances in three sectors, the rules' answer.
At each tick: how free is the way that is wanted; wish and answer blended; motions that would meet a mover exchanged
for ones that do not (`foresight`); and no faster towards any point than its barrier allows (`barrier`).
"""

import math

from holodrive import layout
from holodrive.control import foresight as fs
from holodrive.control.barrier import hold_back_ahead, nearest_allowed, point_limits
from holodrive.control.corridor import free_length, freedom, via_point
from holodrive.control.fuzzy.kernel import evaluate_into
from holodrive.kinematics.kernel import wrap
from holodrive.leaf import leaf
from holodrive.perception import changes
from holodrive.perception import tracking as tr
from holodrive.perception.scan_points import ROW, place_scan, remember, telling
from holodrive.perception.sector_ranges import sector_minima

# --- parameters ----------------------------------------------------------------------------------------------------
(HOLONOMIC, NO_RULE, BARRIER, SEEK, V_TOP, W_TOP, CRUISE, OFFSET, FAR, K_HEADING, MAX_TURN, SLOW, HALF_WIDTH, LOOK,
 BLOCKED, FREE, FOOTPRINT, MARGIN, GAIN, FASTEST, NEAR, HORIZON, EVADE_MARGIN, EVADE_SPEED, MOVERS_IN_RULES, STALE,
 HOLD_SCANS, ARRIVE_M, ARRIVE_RAD, MEDIAN, HISTORY, BEAMS, UNIT_IN, UNIT_OUT, CLAMP, DEFAULT_L, DEFAULT_R,
 LOOK_S, PATIENCE, INERTIA) = range(40)  # fmt: skip
SENSOR = 40  # 6: pose in base_link (x, y, cos, sin), range_min, range_max
EDGES = 46  # 12: of the sectors
SPEC = 58  # the packed fuzzy system
HOLD, STOP, DEFAULT, RAISE = range(4)  # policies when no rule fires

# --- memory --------------------------------------------------------------------------------------------------------
(POSES, SCANS, LAST_SCAN, FAULT, POINTS, NEARS, L, R, SILENT, SILENT_TOTAL, WEIGHT, SURPRISED) = range(12)
INPUTS = 12  # 3: DH, DL, DR in the system's units
OUTPUTS = 15  # 2: L, R in the system's units
WANT = 17  # 3: the goal behaviour's twist
CHOSEN = 20  # 2: velocity chosen among movers
REF = 22  # 2: the goal [m]
NEAREST, SINCE = 24, 25  # how near it came [m], and when [s]
VIA, VIA_UNTIL = 26, 28  # 2: via point [m], until when it is tried [s]
WEIGHED = 29  # 1.0 when the way was judged before
TRACKS = 30
CRESCENTS = TRACKS + tr.TRACKS * tr.ROW  # tracks of leading edges
MOVERS = CRESCENTS + tr.TRACKS * tr.ROW
VARIABLE = (
    MOVERS + 2 * tr.TRACKS * fs.MOVER
)  # from here on by the number of beams: poses, points, near points, earlier scans, scratch

SCAN_IS_OLD, NO_RULE_FIRED = 1, 2  # faults
PROGRESS_M = 0.10  # nearer to the goal by this is progress
VIA_REACHED_M = 0.10
SURPRISE_M = 0.02  # what comes nearer by this much between scans, and not by the robot's motion, moves
SURPRISE_NEAR_M = 0.08  # outside the barrier's margin, where that matters


def memory_size(beams: int, poses: int, work: int) -> int:
    """Numbers that the kernel keeps, for a scan of `beams`, `poses` in a scan time, `work` for the fuzzy system."""
    return VARIABLE + ROW * poses + 7 * beams + changes.memory_size(beams) + max(work, 3 * beams)


@leaf
def fuzzy_avoidance_kernel(obs, memory, params, command):  # type: ignore[no-untyped-def]
    """To the reference, round what the lidar sees."""
    want = memory[WANT : WANT + 3]
    dx, dy = obs[layout.REF_POSE] - obs[layout.POSE], obs[layout.REF_POSE + 1] - obs[layout.POSE + 1]
    to_go, turn = math.hypot(dx, dy), wrap(obs[layout.REF_POSE + 2] - obs[layout.POSE + 2])
    if detour(obs, memory, params, to_go):
        dx, dy = memory[VIA] - obs[layout.POSE], memory[VIA + 1] - obs[layout.POSE + 1]
    distance = math.hypot(dx, dy)
    seek(obs, params, distance, math.atan2(dy, dx), turn, want)
    ux, uy = (dx / distance, dy / distance) if distance > 0.0 else (1.0, 0.0)
    avoid(obs, memory, params, want, ux, uy, min(distance - params[ARRIVE_M], params[LOOK]), command)
    there = to_go <= params[ARRIVE_M] and abs(turn) <= params[ARRIVE_RAD]
    command[layout.ARRIVED] = 1.0 if there and obs[layout.REF_LAST] != 0.0 else 0.0


@leaf
def detour(obs, memory, params, to_go):  # type: ignore[no-untyped-def]
    """Whether to go by a via point: one is chosen when the goal has come no nearer for some time."""
    now, x, y = obs[layout.TIME], obs[layout.POSE], obs[layout.POSE + 1]
    moved = abs(memory[REF] - obs[layout.REF_POSE]) + abs(memory[REF + 1] - obs[layout.REF_POSE + 1]) > 0.01
    nearer = to_go < memory[NEAREST] - PROGRESS_M
    if moved or nearer or memory[SCANS] == 0.0:
        memory[REF], memory[REF + 1] = obs[layout.REF_POSE], obs[layout.REF_POSE + 1]
        memory[NEAREST], memory[SINCE] = to_go, now
    if moved:
        memory[VIA_UNTIL] = 0.0
    if now < memory[VIA_UNTIL]:
        if math.hypot(memory[VIA] - x, memory[VIA + 1] - y) > VIA_REACHED_M:
            return True
        memory[VIA_UNTIL], memory[NEAREST], memory[SINCE] = 0.0, to_go, now
    if params[SEEK] == 0.0 or now - memory[SINCE] <= params[PATIENCE] or to_go <= params[ARRIVE_M]:
        return False
    at, beams = VARIABLE + ROW * int(params[HISTORY]), int(params[BEAMS])
    xs, ys = memory[at : at + beams], memory[at + beams : at + 2 * beams]
    via = memory[VIA : VIA + 2]
    length = via_point(
        xs, ys, int(memory[POINTS]), x, y, obs[layout.REF_POSE], obs[layout.REF_POSE + 1], params[HALF_WIDTH], via
    )
    memory[NEAREST], memory[SINCE] = to_go, now
    memory[VIA_UNTIL] = now + 2.0 * length / params[CRUISE]
    return length > 0.0


@leaf
def seek(obs, params, distance, bearing, turn, want):  # type: ignore[no-untyped-def]
    """The goal behaviour: a body twist (3,) straight to the goal, nose first; at the goal it turns as asked."""
    set_heading = distance <= params[ARRIVE_M] and params[ARRIVE_RAD] < math.pi
    towards = wrap(bearing - obs[layout.POSE + 2])
    error = turn if set_heading else towards
    speed = params[CRUISE] * min(1.0, distance / params[SLOW])
    if params[HOLONOMIC] != 0.0:
        want[0], want[1] = speed * math.cos(towards), speed * math.sin(towards)
    else:
        want[0], want[1] = (0.0 if set_heading else speed * max(0.0, math.cos(error)) ** 3), 0.0
    want[2] = min(params[MAX_TURN], max(-params[MAX_TURN], params[K_HEADING] * error))


@leaf
def guided(obs, memory, params, want, command):  # type: ignore[no-untyped-def]
    """As the whole controller, but a body twist `want` (3,) stands in for the goal behaviour, and nothing arrives."""
    theta = obs[layout.POSE + 2]
    c, s = math.cos(theta), math.sin(theta)
    speed = math.hypot(want[0], want[1])
    ux, uy = (c * want[0] - s * want[1]) / max(speed, 1e-12), (s * want[0] + c * want[1]) / max(speed, 1e-12)
    avoid(obs, memory, params, want, ux, uy, min(params[LOOK], params[LOOK_S] * speed), command)


@leaf
def avoid(obs, memory, params, want, ux, uy, look, command):  # type: ignore[no-untyped-def]
    """Blend a wanted twist with the fuzzy reaction and hold it back before obstacles.

    Args:
        want: (3,) body twist.
        ux, uy: unit vector of the way that must be free, world axes; look: how far [m].
    """
    command[0] = command[1] = command[2] = 0.0
    x, y, theta = obs[layout.POSE], obs[layout.POSE + 1], obs[layout.POSE + 2]
    if not math.isfinite(x + y + theta + want[0] + want[1] + want[2]):
        command[0] = math.nan
        return
    c, s = math.cos(theta), math.sin(theta)
    beams = int(params[BEAMS])
    at = VARIABLE + ROW * int(params[HISTORY])
    poses, scratch = memory[VARIABLE:at], memory[at + 7 * beams + changes.SCANS * (changes.HEAD + beams) :]
    xs, ys, ts = memory[at : at + beams], memory[at + beams : at + 2 * beams], memory[at + 2 * beams : at + 3 * beams]
    near = memory[at + 3 * beams : at + 7 * beams]
    tables = memory[at + 7 * beams : at + 7 * beams + changes.SCANS * (changes.HEAD + beams)]
    remember(poses, int(memory[POSES]), obs[layout.TIME], x, y, theta)
    memory[POSES] += 1.0
    if obs[layout.SCAN_IS_NEW] != 0.0:
        # a lidar that is covered or broken still sends scans: one of which most beams tell nothing counts as none
        count = min(int(obs[layout.N_BEAMS]), beams)
        if 2 * telling(obs, layout.BEAMS, count, params[SENSOR + 4]) >= max(1, count):
            take_scan(obs, memory, params, poses, xs, ys, ts, near, tables)
            react(memory, params, xs, ys, x, y, c, s, scratch)
    if not ready(obs, memory, params, command):
        return
    points = int(memory[POINTS])
    weight = 0.0
    if params[SEEK] != 0.0:
        length = free_length(xs, ys, points, x, y, ux, uy, params[HALF_WIDTH])
        free = freedom(length, look, params[BLOCKED], params[FREE])
        # with some inertia: noise at the edge of the corridor shall not make the robot waver
        share = min(1.0, obs[layout.DT] / params[INERTIA]) if memory[WEIGHED] != 0.0 else 1.0
        weight = memory[WEIGHT] + (free - memory[WEIGHT]) * share
        memory[WEIGHED] = 1.0
    memory[WEIGHT] = weight
    v_a = 0.5 * params[V_TOP] * (memory[R] + memory[L])
    w_a = 0.5 * params[W_TOP] * (memory[R] - memory[L])
    command[0], command[1] = weight * want[0] + (1.0 - weight) * v_a, weight * want[1]
    command[2] = weight * want[2] + (1.0 - weight) * w_a
    if params[BARRIER] != 0.0:
        give_way(obs, memory, params, xs, ys, points, x, y, c, s, command)
        hold_back(obs, memory, params, near, x, y, c, s, scratch, command)


@leaf
def give_way(obs, memory, params, xs, ys, points, x, y, c, s, command):  # type: ignore[no-untyped-def]
    """Exchange the commanded motion for one that stays clear of what moves, where it would not."""
    tracks, movers = memory[TRACKS:MOVERS], memory[MOVERS:VARIABLE]
    chosen = memory[CHOSEN : CHOSEN + 2]
    count = 0
    for at in range(0, tracks.shape[0], tr.ROW):
        if tr.is_moving(tracks, at):
            k, late = fs.MOVER * count, obs[layout.TIME] - tracks[at + tr.TIME]
            vx, vy = tracks[at + tr.VX], tracks[at + tr.VY]
            movers[k], movers[k + 1] = tracks[at + tr.X] + late * vx, tracks[at + tr.Y] + late * vy
            movers[k + 2], movers[k + 3], movers[k + 4] = vx, vy, tracks[at + tr.RADIUS]
            movers[k + 5] = tracks[at + tr.BACK] - obs[layout.TIME]
            count += 1
    if count == 0:
        chosen[0] = chosen[1] = 0.0
        return
    vx, vy = c * command[0] - s * command[1], s * command[0] + c * command[1]
    holonomic = params[HOLONOMIC] != 0.0
    angle, ways = (math.atan2(vy, vx), fs.WAYS) if holonomic else (obs[layout.POSE + 2], 2)  # else ahead and back
    fs.evade(
        vx, vy, x, y, xs, ys, points, movers, count, params[FOOTPRINT], params[EVADE_MARGIN], params[MARGIN],
        params[HORIZON], params[EVADE_SPEED], angle, ways, chosen,
    )  # fmt: skip
    if chosen[0] != vx or chosen[1] != vy:
        command[0], command[1] = c * chosen[0] + s * chosen[1], c * chosen[1] - s * chosen[0]
        if chosen[0] == 0.0 and chosen[1] == 0.0:
            command[2] = 0.0


@leaf
def hold_back(obs, memory, params, near, x, y, c, s, limits, command):  # type: ignore[no-untyped-def]
    """Bring the commanded twist to the nearest one that keeps off all points; stand where something came by itself."""
    if memory[SURPRISED] != 0.0:
        command[0] = command[1] = 0.0
        return
    beams, late = near.shape[0] // 4, obs[layout.TIME] - memory[LAST_SCAN]
    count = point_limits(
        near[:beams], near[beams : 2 * beams], near[2 * beams : 3 * beams], near[3 * beams :], int(memory[NEARS]), late,
        x, y, params[FOOTPRINT] + params[MARGIN], params[GAIN], params[FASTEST], limits,
    )  # fmt: skip
    if count == 0:
        return
    if params[HOLONOMIC] != 0.0:
        vx, vy = nearest_allowed(c * command[0] - s * command[1], s * command[0] + c * command[1], limits, count)
        command[0], command[1] = c * vx + s * vy, c * vy - s * vx
    else:
        command[0] = hold_back_ahead(command[0], c, s, limits, count)


@leaf
def take_scan(obs, memory, params, poses, xs, ys, ts, near, tables):  # type: ignore[no-untyped-def]
    """Place a new scan's points in the odometry frame and find what moves.

    Args:
        xs, ys, ts: (b,) points and times for corridor and sectors are written.
        near: (4 b,) x, y, vx, vy of the points near enough for the barrier is written, as of the scan's stamp.
    """
    most, stamp = xs.shape[0], obs[layout.SCAN_TIME]
    sensor, tracks = params[SENSOR:EDGES], memory[TRACKS:MOVERS]
    count = place_scan(
        obs, layout.BEAMS, min(int(obs[layout.N_BEAMS]), most), obs[layout.BEAM_FIRST], obs[layout.BEAM_STEP], stamp,
        obs[layout.BEAM_PERIOD], sensor, poses, int(memory[POSES]), math.inf, params[MEDIAN] != 0.0, xs, ys, ts,
    )  # fmt: skip
    x, y, theta = obs[layout.POSE], obs[layout.POSE + 1], obs[layout.POSE + 2]
    c, s = math.cos(theta), math.sin(theta)
    sx, sy = x + c * sensor[0] - s * sensor[1], y + s * sensor[0] + c * sensor[1]
    tr.follow(xs, ys, ts, count, sx, sy, memory[TRACKS:CRESCENTS])
    changes.find(
        xs, ys, ts, count, sx, sy, int(memory[SCANS]), most, tables, memory[TRACKS:CRESCENTS], memory[CRESCENTS:MOVERS]
    )
    tr.forget(stamp, tr.LOST_MOVING_S, memory[TRACKS:CRESCENTS])
    tr.forget(stamp, changes.LOST_S, memory[CRESCENTS:MOVERS])
    memory[SURPRISED] = 1.0 if came_by_itself(memory, params, near, xs, ys, ts, count, x, y) else 0.0
    memory[NEARS] = keep_near(obs, params, poses, int(memory[POSES]), stamp, x, y, tracks, near)
    moving, kept = tr.any_moving(tracks), 0
    for i in range(count):
        if not moving or params[MOVERS_IN_RULES] != 0.0 or tr.mover_of(xs[i], ys[i], ts[i], 1.0, tracks) < 0:
            xs[kept], ys[kept] = xs[i], ys[i]
            kept += 1
    memory[POINTS] = kept
    memory[LAST_SCAN] = stamp
    memory[SCANS] += 1.0
    if moving:
        tr.expect_back(xs, ys, kept, tracks)


@leaf
def keep_near(obs, params, poses, pose_count, stamp, x, y, tracks, near):  # type: ignore[no-untyped-def]
    """Write the points that matter to the barrier; gives how many.

    All returns count, those that the median takes for outliers too: a thin rod is one beam wide.
    """
    most = near.shape[0] // 4
    xs, ys, ts = near[:most], near[most : 2 * most], near[2 * most : 3 * most]
    count = place_scan(
        obs, layout.BEAMS, min(int(obs[layout.N_BEAMS]), most), obs[layout.BEAM_FIRST], obs[layout.BEAM_STEP], stamp,
        obs[layout.BEAM_PERIOD], params[SENSOR:EDGES], poses, pose_count, math.inf, False, xs, ys, ts,
    )  # fmt: skip
    moving, square, kept = tr.any_moving(tracks), params[NEAR] ** 2, 0
    for i in range(count):  # in place: kept never overtakes i
        px, py, late = xs[i], ys[i], stamp - ts[i]
        if (px - x) ** 2 + (py - y) ** 2 < square:
            track = tr.mover_of(px, py, ts[i], 1.0, tracks) if moving else -1
            vx, vy = (tracks[track + tr.VX], tracks[track + tr.VY]) if track >= 0 else (0.0, 0.0)
            near[kept], near[most + kept] = px + late * vx, py + late * vy
            near[2 * most + kept], near[3 * most + kept] = vx, vy
            kept += 1
    return kept


@leaf
def came_by_itself(memory, params, near, xs, ys, ts, count, x, y):  # type: ignore[no-untyped-def]
    """Whether a new scan's nearest point is nearer than all of the old scan's are from here, and no known mover's."""
    most, before, now, nearest = near.shape[0] // 4, math.inf, math.inf, 0
    for i in range(int(memory[NEARS])):
        before = min(before, (near[i] - x) ** 2 + (near[most + i] - y) ** 2)
    for i in range(count):
        square = (xs[i] - x) ** 2 + (ys[i] - y) ** 2
        if square < now:
            now, nearest = square, i
    before, now = math.sqrt(before), math.sqrt(now)
    is_near = now < params[FOOTPRINT] + params[MARGIN] + SURPRISE_NEAR_M
    if memory[SCANS] == 0.0 or not is_near or before - now <= SURPRISE_M:
        return False
    return tr.mover_of(xs[nearest], ys[nearest], ts[nearest], 1.0, memory[TRACKS:MOVERS]) < 0


@leaf
def react(memory, params, xs, ys, x, y, c, s, work):  # type: ignore[no-untyped-def]
    """Sectors to fuzzy inputs to what the rules answer: L and R as shares of full wheel speed."""
    inputs, outputs = memory[INPUTS:OUTPUTS], memory[OUTPUTS:WANT]
    edges = params[EDGES:SPEC]
    sector_minima(xs, ys, int(memory[POINTS]), x, y, c, s, edges, params[OFFSET], params[FAR], inputs)
    for i in range(3):
        inputs[i] *= params[UNIT_IN]
    evaluate_into(params[SPEC:], inputs, params[CLAMP], outputs, work)
    if not math.isnan(outputs[0] + outputs[1]):
        memory[L], memory[R], memory[SILENT] = outputs[0] * params[UNIT_OUT], outputs[1] * params[UNIT_OUT], 0.0
        return
    memory[SILENT] += 1.0
    memory[SILENT_TOTAL] += 1.0
    policy = params[NO_RULE]
    if policy == DEFAULT:
        memory[L], memory[R] = params[DEFAULT_L], params[DEFAULT_R]
    elif policy != HOLD or memory[SILENT] > params[HOLD_SCANS]:
        memory[L] = memory[R] = 0.0


@leaf
def ready(obs, memory, params, command):  # type: ignore[no-untyped-def]
    """Whether there is a scan to drive by; writes what is wrong, the fault number only when it begins."""
    fault = 0.0
    if memory[SCANS] > 0.0 and not -obs[layout.DT] <= obs[layout.TIME] - memory[LAST_SCAN] <= params[STALE]:
        fault = SCAN_IS_OLD
    if memory[SILENT] > 0.0:
        command[layout.NO_RULE] = 1.0
        if params[NO_RULE] == RAISE:
            fault = NO_RULE_FIRED
            command[0] = math.nan
    if fault != memory[FAULT]:
        command[layout.FAULT] = fault
    memory[FAULT] = fault
    return memory[SCANS] > 0.0 and fault == 0.0
