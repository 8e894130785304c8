"""Many closed loops at once, compiled: the engine of sweeps, tuning and comparisons."""

import math
import os
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from functools import cached_property, lru_cache
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from holodrive import metrics, references
from holodrive.errors import InputError, UnknownName
from holodrive.interfaces import ControllerPlug, Plug
from holodrive.kinematics import kernel as kinematics
from holodrive.obstacles import obstacle_names, obstacles_of
from holodrive.robots.spec import Robot
from holodrive.sim import period
from holodrive.sim import rollout_kernel as compiled
from holodrive.sim import state as st
from holodrive.sim.base import event_of
from holodrive.sim.model import model_of
from holodrive.sim.streams import key_of
from holodrive.types import Array, Event, MotorState
from holodrive.worlds.spec import World

MAX_EVENTS = 16  # of one robot that are kept in full; all are counted
_LARGEST_CHUNK = 64
_ROW = ("time", "x", "y", "theta", "vx", "vy", "omega", "ax", "ay", "alpha")  # of a reference table
_COMPILED: set[Any] = set()  # kernels that are known to compile as a plug


@dataclass(frozen=True)
class Rollout:
    """What became of n robots.

    Attributes:
        metrics: name -> (n,), see `holodrive.metrics`.
        log: (n, T, k) every `log_every`-th control tick, NaN after a robot's end; T is 0 without a log.
        columns: (k) names of the log's columns.
        state: (n, ...) final states, see `holodrive.sim.state`.
        event_rows: (n, E, ...) event tables.
        worlds: of each robot.
    """

    metrics: dict[str, Array]
    log: Array
    columns: tuple[str, ...]
    state: Array
    event_rows: Array
    worlds: tuple[World | None, ...]

    def __len__(self) -> int:
        return len(self.state)

    @property
    def pose(self) -> Array:
        """(n, 3) final true poses."""
        return self.state[:, st.POSE : st.POSE + 3]

    @property
    def twist(self) -> Array:
        """(n, 3) final true twists, `base_link` axes."""
        return self.state[:, st.TWIST : st.TWIST + 3]

    @property
    def fault(self) -> Any:
        """(n,) whether a command was not finite, which stopped the robot for good."""
        return self.state[:, st.FAULT] != 0.0

    @property
    def motor_energy_j(self) -> Array | None:
        """(n, k, 3) of drives and steerings [J]: electrical, lost in copper, given to the load; plant "motors" only."""
        if self.state.shape[1] == st.SIZE:
            return None
        rows = self.state[:, st.MOTOR :].reshape(len(self.state), -1, st.MOTOR_ROW)
        return rows[:, :, st.MOTOR_INPUT_J : st.MOTOR_INPUT_J + 3]

    @cached_property
    def events(self) -> tuple[tuple[Event, ...], ...]:
        """What happened to each robot, the first `MAX_EVENTS` things."""
        counts = self.state[:, st.N_EVENTS].astype(int)
        names = {id(world): obstacle_names(world) for world in self.worlds}
        return tuple(
            tuple(event_of(row, names[id(world)]) for row in rows[:count])
            for rows, count, world in zip(self.event_rows, counts, self.worlds, strict=True)
        )

    def column(self, name: str) -> Array:
        """(n, T) one column of the log.

        Raises:
            UnknownName: no such column, or nothing was logged.
        """
        if name not in self.columns or not self.log.shape[1]:
            raise UnknownName("log column", name, self.columns if self.log.shape[1] else ("none: give log_every",))
        return np.asarray(self.log[:, :, self.columns.index(name)])


def rollout(
    robot: Robot,
    world: World | Sequence[World] | None,
    controller: ControllerPlug,
    *,
    estimator: Plug | None = None,
    reference: references.Table | Sequence[references.Table] | None = None,
    n: int | None = None,
    seed: int = 0,
    first: int = 0,
    t: float = 30.0,
    dt: float = 1e-3,
    params: ArrayLike | None = None,
    starts: ArrayLike | None = None,
    goals: ArrayLike | None = None,
    plant: str = "first_order",
    log_every: int | None = None,
    stop_on_arrival: bool = False,
    workers: int | None = None,
) -> Rollout:
    """Run n robots closed-loop; the same numbers for any number of workers and any cut into calls.

    Args:
        robot: all of them.
        world: one for all, or n.
        controller: plug with a compiled kernel; twists go through the limit - discretise - invert pipeline.
        estimator: plug with a compiled kernel; None lets the controller know the truth.
        reference: where they shall be, one for all or n of one kind; the world's goal when None and no `goals`.
        n: how many; as many as there are references, else 1, when None.
        seed: of all noise. `first` is the number of the first robot: robots 512 to 1023 of a seed are the same
            whether they run together with the others or, with first=512, elsewhere.
        t: simulated time [s]; dt: physics step [s].
        params: of the controller, packed, (p,) or (n, p); the plug's own when None.
        starts: (3,) or (n, 3) poses; the world's own when None.
        goals: (3,) or (n, 3) poses, instead of `reference`.
        plant: "first_order", "slip", "pwm_map" or "motors".
        log_every: control ticks from one row of the log to the next; None logs nothing.
        stop_on_arrival: end a robot's run when its controller says that it is there.
        workers: threads; all cores when None.

    Raises:
        InputError: shapes or numbers that cannot be.
        UnknownName: no such plant.
    """
    number = period.plant_number(robot, plant)
    if n is None:
        n = 1 if reference is None or isinstance(reference, references.Table) else len(reference)
    model, kin = model_of(robot, dt), _kinematics(robot)
    if n < 1 or not (t > 0.0 and math.isfinite(t)) or (log_every is not None and log_every < 1):
        raise InputError(
            f"a roll-out takes n >= 1, t > 0 and log_every >= 1; found n={n}, t={t}, log_every={log_every}"
        )
    places = _worlds(world, n)
    ticks = max(1, round(t / robot.control_period_s))
    rows = -(-ticks // log_every) if log_every else 0
    columns = log_columns(robot, plant)
    begin = _starts(starts, places, n)
    kind, table, bounds = _references(reference, goals, places, begin, n)
    plugs = (compile_plug(controller), compile_plug(estimator) if estimator else compiled.no_plug)
    sizes = (
        controller.memory_size(robot),
        estimator.memory_size(robot) if estimator else 0,
        kinematics.memory_size(kin),
    )
    log = np.full((n, rows, len(columns)), math.nan)
    accs, states = np.zeros((n, metrics.SIZE)), np.zeros((n, period.state_size(number, model)))
    events = np.zeros((n, MAX_EVENTS, st.EVENT_SIZE))
    default = _packed(controller, robot)
    own = default if params is None else params
    shared = (
        begin,
        np.array([key_of(seed, first + i) for i in range(n)], dtype=np.uint64),
        _rows(own, n, "params", len(default)),
        _packed(estimator, robot) if estimator else np.zeros(1),
        np.array(sizes, dtype=np.int64),
        table,
        bounds,
        log,
        accs,
        events,
        states,
    )

    switches = (
        int(estimator is None),
        number,
        compiled.KINDS[controller.command_kind],
        kind,
        ticks,
        int(stop_on_arrival),
        log_every or 1,
    )

    def run(job: tuple[World | None, Any]) -> None:
        place, robots = job
        compiled.run_robots(*plugs, switches, model, _obstacles(place), kin, robots, *shared)

    _in_threads(run, _jobs(places, n, workers or _cores()), workers or _cores())
    return Rollout(
        metrics={name: accs[:, k].copy() for k, name in enumerate(metrics.NAMES)},
        log=log,
        columns=columns,
        state=states,
        event_rows=events,
        worlds=tuple(places),
    )


def log_columns(robot: Robot, plant: str = "first_order") -> tuple[str, ...]:
    """Names of a log's columns; wheels by their names. The plant "motors" adds what `types.MotorState` tells."""
    names = ["time", "x", "y", "theta", "est_x", "est_y", "est_theta", "ref_x", "ref_y", "ref_theta"]
    names += ["vx", "vy", "omega"]
    for what in ("command", "speed", "duty"):
        names += [f"{what}:{wheel.name}" for wheel in robot.wheels]
    names += [f"steer:{robot.wheels[i].name}" for i in robot.steered]
    if plant == "motors":
        drives = [*(wheel.name for wheel in robot.wheels), *(f"{robot.wheels[i].name}.steering" for i in robot.steered)]
        names += [f"{what}:{name}" for name in drives for what in MotorState._fields]
    return tuple(names)


def compile_plug(plug: Plug) -> Any:
    """The plug's kernel, compiled for the one signature of plugs.

    Raises:
        InputError: it is not a Numba function, or Numba cannot compile it.
    """
    kernel = plug.kernel
    if kernel in _COMPILED:
        return kernel
    if not hasattr(kernel, "compile"):
        raise InputError(f"the kernel of {type(plug).__name__} is not compiled; put @numba.njit on {kernel!r}")
    try:
        kernel.compile(compiled.PLUG.signature)
    except Exception as error:  # Numba's errors have no common root; all mean the same to the user
        text = str(error).strip().splitlines()
        raise InputError(
            f"the kernel of {type(plug).__name__} does not compile as void(obs, memory, params, out): {text[-1]}"
        ) from error
    _COMPILED.add(kernel)
    return kernel


def _worlds(world: World | Sequence[World] | None, n: int) -> list[World | None]:
    if world is None or isinstance(world, World):
        return [world] * n
    if len(world) != n:
        raise InputError(f"a roll-out of {n} robots takes one world or {n}; found {len(world)}")
    return list(world)


def _jobs(places: list[World | None], n: int, workers: int) -> list[tuple[World | None, Any]]:
    """Robots of one world together, cut so that threads end at about the same time."""
    groups: dict[int, list[int]] = {}
    for i, place in enumerate(places):
        groups.setdefault(id(place), []).append(i)
    size = max(1, min(_LARGEST_CHUNK, n // (4 * workers)))
    return [
        (places[group[0]], np.array(group[k : k + size], dtype=np.int64))
        for group in groups.values()
        for k in range(0, len(group), size)
    ]


def _in_threads(run: Any, jobs: list[Any], workers: int) -> None:
    if workers == 1 or len(jobs) == 1:
        for job in jobs:
            run(job)
        return
    with ThreadPoolExecutor(min(workers, len(jobs))) as pool:
        list(pool.map(run, jobs))  # list: so that an exception comes out


def _references(
    reference: references.Table | Sequence[references.Table] | None,
    goals: ArrayLike | None,
    places: list[World | None],
    starts: Array,
    n: int,
) -> tuple[int, Array, Any]:
    """Kind, rows of all robots, and which rows are whose."""
    if reference is not None and goals is not None:
        raise InputError("a roll-out has a reference or goals, not both")
    if isinstance(reference, references.Table):
        bounds = np.tile(np.array([0, len(reference.rows)], dtype=np.int64), (n, 1))
        return reference.kind, np.ascontiguousarray(reference.rows), bounds
    if reference is not None:
        return _many_references(reference, n)
    if goals is None:
        if missing := [place.name if place else "the open floor" for place in places if not (place and place.goal)]:
            raise InputError(f"{missing[0]} has no goal; give reference=... or goals=(x, y, theta)")
        goals = np.array([place.goal.pose for place in places if place and place.goal])
        free = np.array([not place.goal.heading_matters for place in places if place and place.goal])
        goals[free, 2] = starts[free, 2]  # a goal that asks for no heading leaves the robot its own
    rows = np.zeros((n, len(_ROW)))
    rows[:, 1:4] = _finite(_rows(goals, n, "goals", 3), "goals")
    firsts = np.arange(n, dtype=np.int64)
    return references.FIXED, rows, np.ascontiguousarray(np.stack([firsts, firsts + 1], axis=1))


def _many_references(tables: Sequence[references.Table], n: int) -> tuple[int, Array, Any]:
    """n tables one after another; a table that several robots share stands there once."""
    kinds = sorted({table.kind for table in tables})
    if len(tables) != n or len(kinds) != 1:
        raise InputError(
            f"a roll-out of {n} robots takes one reference or {n} of one kind; "
            f"found {len(tables)} of {len(kinds)} kinds"
        )
    unique = list({id(table): table for table in tables}.values())
    ends = np.cumsum([len(table.rows) for table in unique])
    place = {id(table): (end - len(table.rows), end) for table, end in zip(unique, ends.tolist(), strict=True)}
    bounds = np.array([place[id(table)] for table in tables], dtype=np.int64)
    return kinds[0], np.ascontiguousarray(np.concatenate([table.rows for table in unique])), bounds


def _starts(starts: ArrayLike | None, places: list[World | None], n: int) -> Array:
    if starts is None:
        return np.array([place.start if place else (0.0, 0.0, 0.0) for place in places], dtype=np.float64)
    return _finite(_rows(starts, n, "starts", 3), "starts")


def _finite(poses: Array, what: str) -> Array:
    if not np.all(np.isfinite(poses)):
        raise InputError(f"{what} must be finite (x, y, theta); found {poses[~np.isfinite(poses).all(axis=1)][0]}")
    return poses


def _rows(value: ArrayLike, n: int, what: str, width: int | None = None) -> Array:
    """(n, width) from (width,) or (n, width)."""
    array = np.asarray(value, dtype=np.float64)
    if array.ndim == 1:
        array = np.tile(array, (n, 1))
    if array.ndim != 2 or len(array) != n or (width is not None and array.shape[1] != width):
        shape = f"({width or 'p'},) or ({n}, {width or 'p'})"
        raise InputError(f"{what} has shape {np.shape(value)}; expected {shape}")
    return np.ascontiguousarray(array)


def _packed(plug: Plug, robot: Robot) -> Array:
    """The plug's parameters; those of a frozen dataclass cannot change and are kept."""
    parameters: Any = getattr(plug, "__dataclass_params__", None)
    if parameters is None or not parameters.frozen:
        return _pack(plug, robot)
    try:
        return _kept_pack((plug, robot))
    except TypeError:  # a field without a hash, such as an array
        return _pack(plug, robot)


def _pack(plug: Plug, robot: Robot) -> Array:
    return np.ascontiguousarray(plug.pack(robot), dtype=np.float64)


@lru_cache(maxsize=64)
def _kept_pack(both: tuple[Plug, Robot]) -> Array:
    return _pack(*both)


def _obstacles(world: World | None) -> Array:
    try:
        return _kept_obstacles(world)
    except TypeError:  # a world made in code with lists in it has no hash to be kept by
        return obstacles_of(world)


@lru_cache(maxsize=64)
def _kept_obstacles(world: World | None) -> Array:
    return obstacles_of(world)


@lru_cache(maxsize=64)
def _kinematics(robot: Robot) -> Array:
    return kinematics.arrays(robot)


def _cores() -> int:
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
