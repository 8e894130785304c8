"""One piece of a job: a variant over some numbers. The same function runs in a thread here and on a worker there."""

import os
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np

import holodrive
from holodrive import control, metrics, planning, robots, sim, worlds
from holodrive._numba_cache import sources_hash
from holodrive.errors import HolodriveError, InputError
from holodrive.references import Table
from holodrive.robots.spec import Robot
from holodrive.tuning.job import Job
from holodrive.types import Array
from holodrive.worlds.spec import World

# one row of a task's result: the metrics, and what else judging takes
COLUMNS = (*metrics.NAMES, "fault", "straight_m")


@dataclass(frozen=True)
class Task:
    """Runs `first` to `first + count - 1` of one variant, as a job of its own (JSON), by given sources."""

    job: str
    sources: str


@lru_cache(maxsize=1)
def sources() -> str:
    """What results depend on beside a job: this package's sources and the versions of what computes for it."""
    import numba

    folder = os.path.dirname(os.path.abspath(holodrive.__file__))
    return f"{holodrive.__version__} ({sources_hash(folder)}), numba {numba.__version__}, numpy {np.__version__}"


def run_task(task: Task) -> Array:
    """(count, len(COLUMNS)) what became of each run.

    Raises:
        InputError: the task is of other sources than this process, or its job cannot be.
    """
    if task.sources != sources():
        raise InputError(f"this worker runs {sources()}, the job is of {task.sources}; install the same on both")
    return run_job(Job.from_json(task.job))


def run_job(job: Job) -> Array:
    """(count, len(COLUMNS)) of a job with one variant, on one thread."""
    robot = _robot(job.robot)
    table = None if job.reference is None else _reference(_Recipe(job.reference))
    places = [place_of(job, number) for number in job.numbers]
    params = {**job.params, **job.variants[0]}
    known: dict[Any, Any] = {}  # worlds with the same tolerances share a plug
    plugs = []
    for place in places:
        to = place if table is None else None
        key = to and to.goal and (to.goal.tolerance_m, to.goal.tolerance_rad, to.goal.heading_matters)
        if key not in known:
            known[key] = control.compiled(job.controller, control.with_arrival(job.controller, params, to))
        plugs.append(known[key])
    result = sim.rollout(
        robot,
        places,
        plugs[0],
        estimator=job.believer(robot),
        reference=table,
        n=job.count,
        seed=job.seed,
        first=job.first,
        t=job.t,
        dt=job.dt,
        params=np.array([plug.pack(robot) for plug in plugs]) if len(known) > 1 else None,
        starts=job.start,
        plant=job.plant,
        stop_on_arrival=job.stop_on_arrival,
        workers=1,
    )
    judged = [result.metrics[name] for name in metrics.NAMES]
    return np.column_stack([*judged, result.fault, [_straight_m(job, place, table) for place in places]])


def told(task: Task) -> Array | str:
    """`run_task` for another process: a fault comes back as its words, since not every exception can be sent."""
    try:
        return run_task(task)
    except HolodriveError as error:
        return str(error)


def place_of(job: Job, number: int) -> World:
    """The world of one run."""
    places = job.places
    if places.texts:
        return _parsed(places.texts[number % len(places.texts)])
    return _generated(places.generator, places.crossers, number)


@lru_cache(maxsize=8192)
def _generated(generator: str, crossers: int, number: int) -> World:
    return worlds.course(number, crossers) if generator == "course" else worlds.generate(number)


@lru_cache(maxsize=1024)
def _parsed(text: str) -> World:
    return worlds.parse(text, "the job's world")


@lru_cache(maxsize=16)
def _robot(text: str) -> Robot:
    return robots.parse(text, "the job's robot")


class _Recipe(dict[str, Any]):
    """A recipe that a cache can keep a table by."""

    def __hash__(self) -> int:  # type: ignore[override]
        return hash(repr(sorted(self.items())))


@lru_cache(maxsize=16)
def _reference(recipe: _Recipe) -> Table:
    return planning.from_recipe(dict(recipe))


def _straight_m(job: Job, place: World, table: Table | None) -> float:
    """Distance from the start to where the run shall end [m]."""
    start = place.start if job.start is None else job.start
    if table is None:
        assert place.goal is not None  # as the job was checked
        end = (place.goal.pose.x, place.goal.pose.y)
    else:
        end = (float(table.rows[-1, 1]), float(table.rows[-1, 2]))
    return float(np.hypot(end[0] - start[0], end[1] - start[1]))
