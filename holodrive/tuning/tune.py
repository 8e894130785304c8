"""Better parameters by an evolution strategy over roll-outs: search, choose on other runs, judge on yet others."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from holodrive import control, robots
from holodrive.errors import InputError
from holodrive.robots.spec import Robot
from holodrive.tuning.backends import Backend, Open, backend_of
from holodrive.tuning.job import Job
from holodrive.tuning.judgement import Judgement, gain, judge
from holodrive.tuning.objective import Objective
from holodrive.tuning.search import Search
from holodrive.tuning.space import Space
from holodrive.tuning.sweep import Sweep, sweep
from holodrive.tuning.tuned import Generation, Tuned
from holodrive.types import Array

# numbers of runs, and so of random worlds: what is searched with is not what is chosen and judged with
TRAIN = range(10_000, 20_000)
VALIDATION = range(20_000, 20_200)
HELD_OUT = range(30_000, 30_500)
FINALISTS = 6  # that are run again on the validation runs


@dataclass(frozen=True)
class Problem:
    """What to tune, for what.

    Attributes:
        job: robot, worlds, controller and its parameters before; its numbers and variants are not used.
        space: the fields that may change.
        objective: what to make small.
    """

    job: Job
    space: Space
    objective: Objective


@dataclass(frozen=True)
class Step:
    """How far tuning is: a phase of "search", "validation" and "held-out", and its runs."""

    phase: str
    done: int
    total: int
    history: tuple[Generation, ...]


def tune(
    problem: Problem,
    *,
    budget: int = 20_000,
    seed: int = 0,
    runs: int = 32,
    fresh: bool = True,
    train_seeds: range = TRAIN,
    validation_seeds: range = VALIDATION,
    heldout_seeds: range = HELD_OUT,
    population: int | None = None,
    sigma: float = 0.2,
    backend: Backend | str | int | None = None,
    progress: Callable[[Step], None] | None = None,
) -> Tuned:
    """Search, choose, judge. The same arguments give the same result, on any backend.

    All candidates of a generation meet the same runs. The best of several generations, the strategy's own favourite
    and the start are then run on `validation_seeds`; the best there is chosen and set beside the start on
    `heldout_seeds`. Ctrl-C ends it with the best so far.

    Args:
        problem: what to tune, for what.
        budget: runs to simulate for the search; validation and held-out runs come on top.
        seed: of the search.
        runs: for each candidate.
        fresh: take other training runs for each generation, so that it does not learn some worlds by heart; else
            the first `runs` of `train_seeds` all the time.
        train_seeds, validation_seeds, heldout_seeds: numbers of the runs (see `Job`); they must not overlap.
        population: candidates of a generation; 4 + 3 ln p when None.
        sigma: standard deviation of the first candidates, as a share of the ranges.
        backend: as for `sweep`.
        progress: called as runs are done.

    Raises:
        InputError: what cannot be tuned, or a budget that is below one generation.
    """
    start = problem.space.start(problem.job.controller, problem.job.params)
    robot = robots.parse(problem.job.robot)
    search = Search(problem.space.unit(start), sigma, population, seed, lambda point: _allowed(problem, robot, point))
    _check(budget, runs, search.population, {"train": train_seeds, "validation": validation_seeds,
                                             "held-out": heldout_seeds})  # fmt: skip
    replace(problem.job, variants=({},)).check()
    with backend_of(backend) as runner:
        state = _State(problem, runner, progress, budget)
        ended, chosen = "interrupted", None
        judged: tuple[Judgement | None, Judgement | None, tuple[float, float, float] | None] = (None, None, None)
        try:
            why = _search(state, search, runs, fresh, train_seeds)
            chosen = _choose(state, search, validation_seeds)
            judged = _judged(state, chosen, heldout_seeds)
            ended = why
        except KeyboardInterrupt:  # what was found so far is worth keeping
            chosen = _latest(state) if chosen is None else chosen
    return Tuned(
        robot=robot.name,
        controller=problem.job.controller,
        objective=problem.objective.text,
        base=dict(problem.job.params),
        ranges=problem.space.ranges,
        start=start,
        best=chosen,
        history=tuple(state.history),
        ended=ended,
        before=judged[0],
        after=judged[1],
        gain=judged[2],
        settings={
            "budget": budget,
            "seed": seed,
            "runs": runs,
            "fresh": fresh,
            "train_seeds": [train_seeds.start, train_seeds.stop],
            "validation_seeds": [validation_seeds.start, validation_seeds.stop],
            "heldout_seeds": [heldout_seeds.start, heldout_seeds.stop],
            "population": search.population,
            "sigma": sigma,
        },
    )


class _State:
    """What the phases share: the problem, who runs it, and what has been found."""

    def __init__(self, problem: Problem, runner: Backend, progress: Callable[[Step], None] | None, budget: int) -> None:
        self.problem, self.progress, self.budget = problem, progress, budget
        self.history: list[Generation] = []
        self._runner = runner

    def run(self, candidates: list[dict[str, float]], numbers: range, phase: str, before: int = 0) -> Sweep:
        """Every candidate under the same numbers; `before` runs of the phase are done."""
        job = replace(self.problem.job, variants=tuple(candidates)).over(numbers)
        total = max(self.budget if phase == "search" else 0, before + len(candidates) * len(numbers))

        def tell(done: int, _: int) -> None:
            if self.progress:
                self.progress(Step(phase, before + done, total, tuple(self.history)))

        return sweep(job, Open(self._runner), progress=tell)


def _search(state: _State, search: Search, runs: int, fresh: bool, train: range) -> str:
    """Generations until the budget is spent or there is nothing left to find; gives why it ended."""
    done = 0
    while done + search.population * runs <= state.budget:
        points = search.ask()
        candidates = [state.problem.space.values(point) for point in points]
        turn = len(state.history) if fresh else 0
        first = train.start + (turn * runs) % (len(train) - runs + 1)
        found = state.run(candidates, range(first, first + runs), "search", done)
        costs = state.problem.objective.costs(found).mean(axis=1)
        search.tell(costs.tolist())
        done += search.population * runs
        best = int(np.argmin(costs))
        state.history.append(
            Generation(done, float(costs[best]), float(np.median(costs)), search.spread, candidates[best])
        )
        if why := search.converged:
            return f"converged ({why})"
    return "budget"


def _choose(state: _State, search: Search, numbers: range) -> dict[str, float]:
    """The best on runs that the search has not seen; no change where nothing is better than the start."""
    latest = state.history[len(state.history) // 2 :]
    ranked = sorted(latest, key=lambda generation: generation.best)
    finalists: list[dict[str, float]] = [{}, *(one.values for one in ranked)][: FINALISTS - 1]
    favourite = search.favourite
    if search.allowed(favourite):
        finalists.append(state.problem.space.values(favourite))
    costs = _costs(state, finalists, numbers, "validation")[0].mean(axis=1)
    return finalists[int(np.argmin(costs))]


def _judged(
    state: _State, best: dict[str, float], numbers: range
) -> tuple[Judgement, Judgement, tuple[float, float, float]]:
    costs, found = _costs(state, [{}, best], numbers, "held-out")
    before, after = judge(found, state.problem.objective)
    return before, after, gain(costs[0], costs[1])


def _costs(state: _State, candidates: list[dict[str, float]], numbers: range, phase: str) -> tuple[Array, Sweep]:
    found = state.run(candidates, numbers, phase)
    return state.problem.objective.costs(found), found


def _latest(state: _State) -> dict[str, float]:
    """After Ctrl-C: the best of the last generations, of which the runs differ and the costs compare in part only."""
    return min(state.history[-5:], key=lambda generation: generation.best).values if state.history else {}


def _allowed(problem: Problem, robot: Robot, point: Array) -> bool:
    """Whether the controller takes these values together."""
    values: dict[str, Any] = {**problem.job.params, **problem.space.values(point)}
    try:
        control.compiled(problem.job.controller, values).pack(robot)
    except InputError:
        return False
    return True


def _check(budget: int, runs: int, population: int, seeds: dict[str, range]) -> None:
    if runs < 1:
        raise InputError(f"a candidate takes 1 or more runs; found {runs}")
    if budget < population * runs:
        raise InputError(
            f"a budget of {budget} runs is below one generation of {population} candidates with {runs} runs each; "
            f"give {population * runs} or more, or fewer runs for each candidate"
        )
    for name, numbers in seeds.items():
        least = runs if name == "train" else 1
        if len(numbers) < least or numbers.step != 1 or numbers.start < 0:
            raise InputError(
                f"{name} seeds {numbers.start}..{numbers.stop} are too few; give {least} or more from 0 on"
            )
    names = list(seeds)
    for i, one in enumerate(names):
        for other in names[i + 1 :]:
            a, b = seeds[one], seeds[other]
            if a.start < b.stop and b.start < a.stop:
                raise InputError(f"{one} and {other} seeds overlap: {a.start}..{a.stop} and {b.start}..{b.stop}")
