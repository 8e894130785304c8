"""`holodrive run --plan`: drive past obstacles by a plan, and one clear line for what cannot be planned."""

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from holodrive import planning

Cli = Callable[..., Any]  # see conftest.py
RUN = ("run", "hybrid3_table_x", "-w", "paper_course", "--plan")


@pytest.fixture(autouse=True)
def _in_an_empty_folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)


@pytest.mark.parametrize("planner", planning.PLANNERS)
def test_a_planned_run_arrives_and_says_what_was_planned(cli: Cli, planner: str) -> None:
    answer = cli(*RUN, planner, "-c", "pid", "-o", "run.mcap")
    assert answer.code == 0, answer.err
    assert f"{planner}: 4.1" in answer.out
    assert "arrived" in answer.out
    assert "collisions 0" in answer.out


def test_the_margin_and_the_seed_are_the_plans_too(cli: Cli) -> None:
    """And the log says the whole way."""
    one, same, wide = (
        json.loads(cli(*RUN, "bee_colony", "--duration", "0.1", "--json", *more).out)["settings"]["reference"]
        for more in ((), (), ("--margin", "10 cm"))
    )
    assert one == same
    assert one["kind"] == "route"
    assert one["pieces"] != wide["pieces"]
    assert planning.from_recipe(wide).duration_s > planning.from_recipe(one).duration_s


def test_the_help_names_every_planner(cli: Cli) -> None:
    text = " ".join(cli("run", "--help").out.split())
    assert all(name in text for name in planning.PLANNERS)


@pytest.mark.parametrize(
    ("arguments", "word"),
    [
        ((*RUN, "bee_colnoy"), "Did you mean 'bee_colony'?"),
        (("run", "hybrid3", "-w", "open", "--plan", "visibility"), "has no goal"),
        ((*RUN, "visibility", "--goal", "0.5,1.5"), "inside an obstacle"),
        ((*RUN, "visibility", "--goal", "5,1"), "no way from"),
        ((*RUN, "bee_colony", "--goal", "5,1"), "no way from"),
        ((*RUN, "visibility", "--margin", "wide"), "--margin"),
        ((*RUN, "visibility", "--margin", "-1 cm"), "must be 0 or more"),
        ((*RUN, "visibility", "--via", "1,1"), "no --via"),
        ((*RUN, "visibility", "--path", "circle"), "no --path"),
    ],
)
def test_what_cannot_be_planned_is_one_line_and_exit_code_2(cli: Cli, arguments: tuple[str, ...], word: str) -> None:
    answer = cli(*arguments)
    assert answer.code == 2
    assert word in answer.err
    assert "Traceback" not in answer.err
    assert len(answer.err.strip().splitlines()) == 1
