"""The search finds better values, the same ones each time, and keeps what it has when it is stopped."""

import math
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from holodrive.errors import InputError
from holodrive.tuning import Problem, Range, Space, Step, Tuned, interval_of_mean, read, tune
from holodrive.tuning.search import Search

SMALL: dict[str, Any] = {
    "budget": 7 * 2 * 8, "runs": 2, "seed": 3, "validation_seeds": range(20_000, 20_004),
    "heldout_seeds": range(30_000, 30_010),
}  # fmt: skip


def sphere(seed: int, dimensions: int, best: float) -> tuple[float, float]:
    """Where the search believes the bottom of a bowl to be, and what it would cost there."""
    search = Search(np.full(dimensions, 0.9), 0.2, None, seed)
    for _ in range(80):
        search.tell([float(((point - best) ** 2).sum()) for point in search.ask()])
    return float(search.favourite[0]), float(((search.favourite - best) ** 2).sum())


@pytest.mark.parametrize(("dimensions", "best"), [(1, 0.3), (2, 0.0), (5, 0.7)])
def test_the_search_finds_the_bottom_of_a_bowl(dimensions: int, best: float) -> None:
    """In any number of dimensions, on a bound too."""
    assert sphere(1, dimensions, best)[1] < 1e-4


def test_the_search_touches_nothing_global() -> None:
    """The same seed gives the same numbers, NumPy's global generator stays as it was."""
    before = np.random.get_state()[1].copy()  # noqa: NPY002
    assert sphere(4, 3, 0.5) == sphere(4, 3, 0.5) != sphere(5, 3, 0.5)
    assert np.array_equal(before, np.random.get_state()[1])  # noqa: NPY002


def test_candidates_that_are_not_allowed_are_drawn_again() -> None:
    """And a space without any is told."""
    search = Search(np.full(2, 0.5), 0.3, 12, 1, lambda point: bool(point[0] < point[1]))
    assert all(point[0] < point[1] for point in search.ask())
    with pytest.raises(InputError, match="hardly any"):
        Search(np.full(2, 0.5), 0.3, 12, 1, lambda point: False).ask()


def test_gains_get_better_and_the_same_each_time(problem: Problem) -> None:
    """A poor PID on a circle loses a third of its error, on runs that it was not tuned with; any backend agrees."""
    found = tune(problem, **SMALL)
    assert found.ended == "budget"
    assert found.start == {"kp": 0.4, "kp_theta": 1.5, "kd": 0.0}
    assert found.before is not None
    assert found.after is not None
    assert found.gain is not None
    assert found.after.cost.mean < 0.7 * found.before.cost.mean
    assert found.gain[0] == pytest.approx(found.after.cost.mean - found.before.cost.mean)
    assert found.gain[2] < 0.0
    assert all(one.low <= found.best[one.field] <= one.high for one in found.ranges)
    assert found.params == {**problem.job.params, **found.best}
    again = tune(problem, **SMALL, backend=1)
    assert again.to_json() == found.to_json()
    other = tune(problem, **(SMALL | {"seed": 4}))
    assert other.best != found.best


def test_a_result_survives_its_file(problem: Problem, tmp_path: Path) -> None:
    """NaN and infinite numbers too."""
    found = replace(tune(problem, **SMALL), base={"max_speed_m_s": math.inf, "kp": 1.0})
    path = found.save(tmp_path / "tuned.json")
    assert read(path).to_json() == found.to_json()
    assert "NaN" not in path.read_text()
    assert "Infinity" not in path.read_text()


@pytest.mark.parametrize("phase", ["search", "validation", "held-out"])
def test_ctrl_c_keeps_the_best_so_far(problem: Problem, phase: str) -> None:
    """In any phase."""

    def stop(step: Step) -> None:
        if step.phase == phase and len(step.history) >= 2:
            raise KeyboardInterrupt

    found = tune(problem, **SMALL, progress=stop)
    assert found.ended == "interrupted"
    assert found.after is None
    assert set(found.best) == {"kp", "kp_theta", "kd"}
    assert found.history[-1].best < found.history[0].median or phase == "search"
    assert Tuned.from_json(found.to_json()).best == found.best


def test_ctrl_c_before_anything_changes_nothing(problem: Problem) -> None:
    def stop(step: Step) -> None:
        raise KeyboardInterrupt

    assert tune(problem, **SMALL, progress=stop).best == {}


def test_nothing_better_changes_nothing(problem: Problem) -> None:
    """Where only worse values are allowed, the start stays."""
    worse = Space((Range("kp", 0.01, 0.02), Range("kp_theta", 0.01, 0.02)))
    found = tune(replace(problem, space=worse), **SMALL)
    assert found.best == {}
    assert found.gain is not None
    assert found.gain[0] == 0.0


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"budget": 0}, "below one generation of 7 candidates"),
        ({"runs": 0}, "1 or more runs"),
        ({"population": 2}, "4 or more"),
        ({"sigma": 0.0}, "above 0"),
        ({"sigma": math.nan}, "above 0"),
        ({"validation_seeds": range(10_500, 10_600)}, "train and validation seeds overlap"),
        ({"heldout_seeds": range(0)}, "too few"),
    ],
)
def test_bad_searches_are_refused(problem: Problem, change: dict[str, Any], words: str) -> None:
    """Before anything runs."""
    with pytest.raises(InputError, match=words):
        tune(problem, **(SMALL | change))


@pytest.mark.parametrize("text", ["", "{}", "[]", '{"tuned": 99}', '{"tuned": 1, "params": {}}'])
def test_files_that_are_no_result(tmp_path: Path, text: str) -> None:
    path = tmp_path / "x.json"
    path.write_text(text)
    with pytest.raises(InputError, match="no result of holodrive tune"):
        read(path)
    with pytest.raises(InputError, match="cannot be read"):
        read(tmp_path / "missing.json")


def test_paired_intervals_are_narrower() -> None:
    """The change on the same runs is surer than the difference of two means."""
    random = np.random.default_rng(1)
    worlds = random.normal(10.0, 5.0, 200)
    better = worlds - 0.5 + random.normal(0.0, 0.1, 200)
    low, high = interval_of_mean(better - worlds)
    assert low < -0.5 < high < 0.0
    assert high - low < 0.1 * np.subtract(*interval_of_mean(worlds)[::-1])
