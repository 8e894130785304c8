"""Via points by an artificial bee colony (D. Karaboga and B. Basturk, J. Global Optimization 39, 2007).

The planner that the first paper compares its fuzzy controller with, and does not describe. Here: n via points between
start and goal, cost f = L + W V + T, with L the polyline's length, V how deep its legs go into the inflated obstacles
and walls (each leg and obstacle: max(0, need - distance), exact), T an optional price of turning. Food sources are
positions of all via points at once; employed bees, onlookers and a scout as Karaboga and Basturk have them.
"""

import math
from dataclasses import dataclass, fields
from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import ArrayLike

from holodrive.errors import InputError
from holodrive.leaf import leaf
from holodrive.planning.free_space import penetration
from holodrive.planning.plan import Plan, planned
from holodrive.planning.route import Route, polyline
from holodrive.planning.task import Task, task
from holodrive.types import Array
from holodrive.worlds.spec import World

_MOST_BEES = 10_000_000  # food sources times cycles: some minutes
_STUCK_M = 1e-3  # deeper is no rounding of a touch but a gap that is too narrow
# what the kernel is told: start, goal, reach, need, weights, limit, whether guided
_START, _GOAL, _REACH, _NEED, _DEPTH_WEIGHT, _TURN_WEIGHT, _LIMIT, _PULL = 0, 2, 4, 5, 6, 7, 8, 9


@dataclass(frozen=True)
class _Colony:
    """The settings of a search, checked."""

    via: int
    food_sources: int
    cycles: int
    depth_weight: float
    turn_m_rad: float
    guided: float
    restarts: int

    def __post_init__(self) -> None:
        least = {"via": 1, "food_sources": 2, "cycles": 1}
        for one in fields(self):
            value, low = getattr(self, one.name), least.get(one.name, 0)
            whole = one.type is int or one.type == "int"
            number = isinstance(value, int | float) and not isinstance(value, bool)
            if not (number and math.isfinite(value) and value >= low) or (whole and value != int(value)):
                kind = "a whole number" if whole else "a number"
                raise InputError(f"{one.name} of a bee colony is {value!r}; it must be {kind} from {low} on")
        if self.food_sources * self.cycles > _MOST_BEES:
            raise InputError(
                f"a bee colony of {self.food_sources} food sources and {self.cycles} cycles is too much work; "
                f"their product may be {_MOST_BEES}"
            )


def bee_colony(
    world: World,
    footprint_m: float,
    seed: int = 0,
    *,
    start: ArrayLike | None = None,
    goal: ArrayLike | None = None,
    margin_m: float = 0.0,
    via: int = 2,
    food_sources: int = 20,
    cycles: int = 300,
    depth_weight: float = 20.0,
    turn_m_rad: float = 0.0,
    guided: float = 0.0,
    restarts: int = 4,
) -> Plan:
    """A short polyline through `via` points. Movers are not seen; the same seed gives the same plan.

    Where the world's goal is not free, the end is searched for on the circle of the goal's tolerance.

    Args:
        world: where.
        footprint_m: radius of the robot.
        seed: of the search.
        start, goal: (x, y) or (x, y, heading); the world's own when None.
        margin_m: kept free around the footprint.
        via: points between start and goal.
        food_sources: in the colony; as many employed bees and onlookers in each cycle.
        cycles: of the search. A source that `food_sources` times the number of unknowns trials do not better is
            given up for a random one.
        depth_weight: price of going into an obstacle [m of path per m of depth].
        turn_m_rad: price of a change of direction [m of path per rad].
        guided: how strongly the best source pulls; 0 is the plain colony, 1.5 the usual choice of the guided one
            (G. Zhu and S. Kwong, Applied Mathematics and Computation 217, 2010).
        restarts: so often at most the search begins anew when no way was free, or the best goes through a gap that
            is too narrow (its depth was cheaper than the way around): each time with one via point more and depth
            ten times as dear. `cost_history` holds one search after the other.

    Raises:
        InputError: no goal, start or goal not free, settings that cannot be, or no way found.
    """
    colony = _Colony(via, food_sources, cycles, depth_weight, turn_m_rad, guided, restarts)
    asked = task(world, footprint_m, start=start, goal=goal, margin_m=margin_m)
    random = np.random.Generator(np.random.Philox(key=seed % 2**64))
    low, high = asked.bounds
    if not np.all(high > low):
        raise asked.no_way()
    judged, histories = 0, []
    ways: list[Array] = []
    for again in range(restarts + 1):
        found = _searched(colony, asked, again, random)
        judged += found.judged
        histories.append(found.history)
        if found.points is not None:
            ways.append(np.concatenate([asked.start[None], found.points]))
        if ways and found.depth_m <= _STUCK_M:
            break
    if not ways:
        raise InputError(
            f"{asked.no_way()}: so says a bee colony after {restarts + 1} tries with up to {via + restarts} "
            "via points; the planner 'visibility' knows for sure"
        )
    route = min((polyline(way) for way in ways), key=lambda route: _price(route, turn_m_rad))
    ends = np.concatenate([route.pieces[:, :2], route.at(route.length_m)[0][None]])
    return planned(
        "bee_colony", asked, route, via=ends[1:-1], cost_history=np.concatenate(histories), evaluations=judged
    )


def _price(route: Route, turn_m_rad: float) -> float:
    return route.length_m + turn_m_rad * float(np.sum(np.abs(route.changes_rad)))


class _Found(NamedTuple):
    """Of one search: via points and end (via + 1, 2) of the best free way, None when there is none; best cost of
    each cycle; how deep the best of all, free or not, goes into obstacles [m]; how many were judged."""

    points: Array | None
    history: Array
    depth_m: float
    judged: int


def _searched(colony: _Colony, asked: Task, again: int, random: np.random.Generator) -> _Found:
    """The search after `again` others: with as many via points more, and depth ten times as dear each time."""
    via = colony.via + again
    low, high = asked.bounds
    lower, upper = np.tile(low, via), np.tile(high, via)
    if asked.reach_m > 0.0:  # the last unknown is a direction from the goal's centre
        lower, upper = np.append(lower, -math.pi), np.append(upper, math.pi)
    told = np.array(
        [
            *asked.start,
            *asked.goal,
            asked.reach_m,
            asked.need_m,
            colony.depth_weight * 10.0**again,
            colony.turn_m_rad,
            colony.food_sources * len(lower),
            colony.guided,
        ]
    )
    history, best = np.empty(colony.cycles), np.empty(len(lower))
    free, depth, judged = _forage(asked.obstacles, told, lower, upper, colony.food_sources, random, history, best)
    if not free:
        return _Found(None, history, float(depth), int(judged))
    points = np.empty((via + 1, 2))
    points[:-1] = best[: 2 * via].reshape(via, 2)
    points[-1] = _end(told, best)
    return _Found(points, history, float(depth), int(judged))


@leaf
def _end(told, x):  # type: ignore[no-untyped-def]
    """Where the polyline ends: the goal, or a place at its tolerance from it."""
    gx, gy, reach = told[_GOAL], told[_GOAL + 1], told[_REACH]
    if reach == 0.0:
        return gx, gy
    angle = x[x.shape[0] - 1]
    return gx + reach * math.cos(angle), gy + reach * math.sin(angle)


@leaf
def _cost(obstacles, told, x):  # type: ignore[no-untyped-def]
    """Cost f and depth V of the polyline through the points in x; V is 0 when it is free."""
    gx, gy = _end(told, x)
    length, depth, turning = 0.0, 0.0, 0.0
    ax, ay, ux, uy = told[_START], told[_START + 1], 0.0, 0.0
    count = x.shape[0] // 2
    for k in range(count + 1):
        bx, by = (x[2 * k], x[2 * k + 1]) if k < count else (gx, gy)
        vx, vy = bx - ax, by - ay
        step = math.sqrt(vx * vx + vy * vy)
        length += step
        depth += penetration(obstacles, told[_NEED], ax, ay, bx, by)
        if step > 0.0:
            if ux != 0.0 or uy != 0.0:
                turning += abs(math.atan2(ux * vy - uy * vx, ux * vx + uy * vy))
            ux, uy = vx, vy
        ax, ay = bx, by
    return length + told[_DEPTH_WEIGHT] * depth + told[_TURN_WEIGHT] * turning, depth


@njit(cache=True, error_model="numpy")
def _forage(obstacles, told, lower, upper, sources, random, history, best):  # type: ignore[no-untyped-def]
    """The search; `best` gets the best free source, `history` the best cost after each cycle.

    Returns:
        whether a free way was found, how deep the best of all goes, and how many sources were judged.
    """
    size = lower.shape[0]
    food, costs, trials = np.empty((sources, size)), np.empty(sources), np.zeros(sources)
    trial, leader, fitness = np.empty(size), np.empty(size), np.empty(sources)
    # lowest cost of all, lowest cost of a free one (`leader` and `best` are theirs), depth of the leader
    record = np.array([math.inf, math.inf, math.inf])
    for i in range(sources):
        _scatter(lower, upper, random, food[i])
        costs[i] = _judge(obstacles, told, food[i], record, leader, best)
    judged = sources
    for cycle in range(history.shape[0]):
        for i in range(sources):
            _visit(obstacles, told, lower, upper, random, food, costs, trials, i, trial, record, leader, best)
        total = 0.0
        for i in range(sources):
            fitness[i] = 1.0 / (1.0 + costs[i])
            total += fitness[i]
        for _ in range(sources):
            share, i = random.random() * total, 0
            while i < sources - 1 and share >= fitness[i]:
                share -= fitness[i]
                i += 1
            _visit(obstacles, told, lower, upper, random, food, costs, trials, i, trial, record, leader, best)
        judged += 2 * sources
        worst = np.argmax(trials)
        if trials[worst] > told[_LIMIT]:
            _scatter(lower, upper, random, food[worst])
            costs[worst] = _judge(obstacles, told, food[worst], record, leader, best)
            trials[worst] = 0.0
            judged += 1
        history[cycle] = record[0]
    return record[1] < math.inf, record[2], judged


@njit(cache=True, error_model="numpy")
def _visit(  # type: ignore[no-untyped-def]
    obstacles, told, lower, upper, random, food, costs, trials, i, trial, record, leader, best
):  # fmt: skip
    """A bee tries a neighbour of source i, one unknown changed, and keeps the better of the two."""
    sources, size = food.shape
    k = min(int(random.random() * (sources - 1)), sources - 2)
    k += 1 if k >= i else 0
    j = min(int(random.random() * size), size - 1)
    for at in range(size):
        trial[at] = food[i, at]
    step = (2.0 * random.random() - 1.0) * (food[i, j] - food[k, j])
    if told[_PULL] > 0.0:
        step += told[_PULL] * random.random() * (leader[j] - food[i, j])
    trial[j] = min(max(food[i, j] + step, lower[j]), upper[j])
    cost = _judge(obstacles, told, trial, record, leader, best)
    if cost < costs[i]:
        costs[i], trials[i] = cost, 0.0
        food[i, j] = trial[j]
    else:
        trials[i] += 1.0


@njit(cache=True, error_model="numpy")
def _judge(obstacles, told, x, record, leader, best):  # type: ignore[no-untyped-def]
    cost, depth = _cost(obstacles, told, x)
    if cost < record[0]:
        record[0], record[2] = cost, depth
        leader[:] = x
    if depth == 0.0 and cost < record[1]:
        record[1] = cost
        best[:] = x
    return cost


@njit(cache=True, error_model="numpy")
def _scatter(lower, upper, random, x):  # type: ignore[no-untyped-def]
    for j in range(x.shape[0]):
        x[j] = lower[j] + random.random() * (upper[j] - lower[j])
