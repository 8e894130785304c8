"""`holodrive explain`: a fuzzy system in words, as JSON, as pictures and in other formats; one line for wrong input."""

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import pytest

from holodrive.control import fuzzy

Cli = Callable[..., Any]  # see conftest.py


@pytest.fixture(autouse=True)
def _in_an_empty_folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)


def test_a_system_is_described_with_its_faults(cli: Cli) -> None:
    """Sets, how rules are joined, findings."""
    answer = cli("explain", "paper_viii", "--sensor-range", "120,3000")
    assert answer.code == 0, answer.err
    for part in ("27 rules", "DH  0..2500 mm", "F-GAP", "43.6 %", "rule 25 turns toward DR"):
        assert part in answer.out


def test_an_input_is_explained(cli: Cli) -> None:
    """The rules that fired and what changes without them."""
    answer = cli("explain", "repaired", "--at", "DH=420, DL=450, DR=2800")
    assert answer.code == 0, answer.err
    assert "2800 mm taken as 2500" in answer.out
    assert "IF DH is N AND DL is N AND DR is F" in answer.out


def test_json_has_the_system_the_findings_and_the_explanation(cli: Cli) -> None:
    """With the numbers that evaluate gives."""
    found = json.loads(cli("explain", "repaired", "--at", "DR=600,DL=450,DH=420", "--json").out)
    outputs = fuzzy.load("repaired").evaluate([420, 450, 600])
    assert list(found["explanation"]["outputs"].values()) == pytest.approx(outputs.tolist())
    assert {one["code"] for one in found["findings"]} >= {"F-ZERO", "F-TIE"}
    assert [one["name"] for one in found["inputs"]] == ["DH", "DL", "DR"]


def test_lint_alone_fails_when_there_is_an_error(cli: Cli) -> None:
    """For scripts: exit code 1 for the printed table, 0 for the repaired one."""
    assert cli("explain", "paper_viii", "--lint").code == 1
    assert cli("explain", "repaired", "--lint").code == 0


def test_pictures_and_pages_are_written(cli: Cli) -> None:
    """A surface of every output as one SVG, and the whole as one page."""
    assert cli("explain", "paper_viii", "--surface", "DH,DR", "-o", "surface.svg").code == 0
    text = "".join(ElementTree.fromstring(Path("surface.svg").read_text()).itertext())
    assert "L over DH and DR" in text
    assert "R over DH and DR" in text
    assert cli("explain", "paper_viii", "--at", "DH=420,DL=450,DR=600", "-o", "page.html").code == 0
    assert "F-GAP" in Path("page.html").read_text()


@pytest.mark.parametrize("ending", ["fis", "fcl", "fml"])
def test_a_system_is_converted(cli: Cli, ending: str) -> None:
    """Written, read again, the same outputs."""
    assert cli("explain", "repaired", "-o", f"copy.{ending}").code == 0
    again = fuzzy.load(f"copy.{ending}")
    places = [[420, 450, 600], [700, 300, 2400]]
    assert again.evaluate(places) == pytest.approx(fuzzy.load("repaired").evaluate(places), abs=1e-9)


def test_c_is_written(cli: Cli) -> None:
    """For a microcontroller."""
    assert cli("explain", "repaired", "-o", "flc.c").code == 0
    assert Path("flc.c").stat().st_size > 1000


@pytest.mark.parametrize(
    ("words", "why"),
    [
        (["papr_viii"], "Did you mean 'paper_viii'"),
        (["missing.fis"], "there is no such file"),
        (["repaired", "--at", "DH=1,DX=2,DR=3"], "no fuzzy input called 'DX'"),
        (["repaired", "--at", "DH=1,DL=2"], "says nothing about DR"),
        (["repaired", "--at", "DH=1,DL=2,DR=x"], "wants a number"),
        (["repaired", "--at", "DH=1,DH=2,DR=3"], "gives DH twice"),
        (["repaired", "--at", "1,2,3"], "NAME=VALUE"),
        (["repaired", "--surface", "DH,DL"], "-o surface.svg"),
        (["repaired", "--surface", "DH,DH", "-o", "x.svg"], "two different inputs"),
        (["repaired", "--sensor-range", "3000,120"], "numbers that rise"),
        (["repaired", "--sensor-range", "120"], "LOW,HIGH"),
        (["repaired", "-o", "x.txt"], "-o writes"),
        (["repaired", "-o", "nowhere/x.svg", "--surface", "DH,DL"], "nowhere"),
    ],
)
def test_wrong_input_is_one_clear_line(cli: Cli, words: list[str], why: str) -> None:
    """With what is allowed, and exit code 2."""
    answer = cli("explain", *words)
    assert answer.code == 2
    assert why in answer.err
    assert "Traceback" not in answer.err


def test_the_hint_asks_the_same_again(cli: Cli) -> None:
    """Without clamping, if that was asked."""
    assert "--no-clamp -o" in cli("explain", "repaired", "--at", "DH=700,DL=300,DR=3000", "--no-clamp").err
    assert "--no-clamp" not in cli("explain", "repaired", "--at", "DH=700,DL=300,DR=3000").err
