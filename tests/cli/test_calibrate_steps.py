"""`calibrate steps`: the robot's file gets its linearizer and keeps all else; wrong input writes nothing."""

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from holodrive import robots

Cli = Callable[..., Any]  # see conftest.py
STEPS = ("calibrate", "steps", "mecanum4_mice")


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with what one calibration writes."""
    from holodrive.cli import main

    folder = tmp_path_factory.mktemp("calibrated")
    files = ("-o", folder / "mine.toml", "--csv", folder / "steps.csv", "--report", folder / "steps.html")
    assert main([*STEPS, "--seed", "3", "-q", *map(str, files)]) == 0
    return folder


def test_the_new_file_is_the_robot_with_another_linearizer(made: Path) -> None:
    """Comments of everything else stay."""
    mine, was = robots.load(made / "mine.toml"), robots.load("mecanum4_mice")
    assert mine.pwm_map == was.pwm_map
    assert mine.linearizer != was.linearizer
    text = (made / "mine.toml").read_text()
    assert "# assumed: the distance D is not printed" in text
    assert text.count("# holodrive calibrate steps: ") == 4


def test_the_table_stands_beside_what_the_file_had(cli: Cli, made: Path) -> None:
    """From the steps that were written: dead zone, dead time, R2, monotone, both speeds."""
    answer = cli(*STEPS, made / "steps.csv")
    assert answer.code == 0, answer.err
    for words in ("dead zone", "dead time", "R2", "monotone", "by eq. 8 mm/s", "before: dead zone PWM", "W1W4", "W2W3"):
        assert words in answer.out
    assert "-o mine.toml" in answer.err


def test_steps_from_csv_give_the_same_linearizer(cli: Cli, made: Path) -> None:
    """To the last digit, as JSON; nothing is written."""
    before = sorted(path.name for path in made.iterdir())
    answer = json.loads(cli(*STEPS, made / "steps.csv", "--json").out)
    assert answer["files"] == []
    assert sorted(path.name for path in made.iterdir()) == before
    table = answer["linearizer"]["w1w4"]
    assert table["wheels"] == ["fr", "rl"]
    assert str(table["forward"]["cubic"]) in (made / "mine.toml").read_text()
    assert {row["curve"] for row in answer["fits"]} == {"cubic"}
    assert all(row["top_eq8_mm_s"] < row["top_mm_s"] for row in answer["fits"])


def test_the_page_has_the_papers_figures(made: Path) -> None:
    """4, 5 and 7, with the linearizer that was there before."""
    page = (made / "steps.html").read_text()
    for words in ("Step responses", "Speed over PWM, by equation 8", "PWM over speed, W2W3 backward", "plain cubic"):
        assert words in page
    for figure in ("Figure 4", "Figure 5", "Figure 7"):
        assert figure in page


def test_write_changes_the_robots_own_file(cli: Cli, made: Path, tmp_path: Path) -> None:
    """In place, and twice the same is the same."""
    own = tmp_path / "own.toml"
    own.write_text(robots.load("mecanum4_mice").text)
    assert cli("calibrate", "steps", own, made / "steps.csv", "--write").code == 0
    first = own.read_text()
    assert robots.load(own).linearizer == robots.load(made / "mine.toml").linearizer
    assert cli("calibrate", "steps", own, made / "steps.csv", "--write").code == 0
    assert own.read_text() == first
    assert [path.name for path in tmp_path.iterdir()] == ["own.toml"]


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (("--write",), "mecanum4_mice is a robot of the catalog, and --write leaves those alone"),
        (("-o", "there.toml"), "-o there.toml: there is such a file already; choose another name"),
        (("--csv", "there.csv"), "--csv there.csv: there is such a file already"),
        (("-o", "new.toml", "--write"), "the linearizer goes to one place"),
        (("-o", "new.txt"), "--out writes .toml; found 'new.txt'"),
        (("there.csv", "--plant", "slip"), "the steps come from a file or from a simulated robot"),
        (("--step", "soon"), "--step: 'soon' is not a time"),
        (("missing.csv",), "there is no such file"),
        (("there.csv",), "missing columns: group, direction, pwm, time, x, y"),
        (("--stray", "1 mm"), "strayed more than 0.001 m"),
    ],
)
def test_wrong_input_is_one_clear_line_and_writes_nothing(
    cli: Cli, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, words: tuple[str, ...], message: str
) -> None:
    """Before any work, where it can be known before."""
    monkeypatch.chdir(tmp_path)
    Path("there.toml").write_text("# precious\n")
    Path("there.csv").write_text("precious\n")
    answer = cli(*STEPS, *words)
    assert answer.code in (2, 3)
    assert message in answer.err
    assert "Traceback" not in answer.err
    assert sorted(path.name for path in tmp_path.iterdir()) == ["there.csv", "there.toml"]
    assert Path("there.toml").read_text() == "# precious\n"
    assert Path("there.csv").read_text() == "precious\n"


def test_a_catalog_file_by_its_path_is_left_alone_too(cli: Cli) -> None:
    """Whatever way it is named."""
    path = robots.files.CATALOG / "mecanum4_mice.toml"
    before = path.read_text()
    answer = cli("calibrate", "steps", path, "--write")
    assert answer.code == 2
    assert "is a robot of the catalog" in answer.err
    assert path.read_text() == before


def test_what_cannot_be_calibrated_is_told_what_can(cli: Cli) -> None:
    """With the nearest name."""
    answer = cli("calibrate", "step")
    assert answer.code == 2
    assert "Did you mean 'steps'? Known: steps, mice" in answer.err


def test_write_with_a_name_that_is_no_file(cli: Cli, made: Path) -> None:
    """And of no catalog robot either."""
    answer = cli("calibrate", "steps", "mecanum5", made / "steps.csv", "--write")
    assert answer.code == 2
    assert "--write goes into a robot's own file, whose name ends in .toml; found mecanum5" in answer.err


def test_counts_are_those_of_the_linearizer_in_the_file(cli: Cli, tmp_path: Path) -> None:
    """Those of its last calibration hold for measured steps until --counts says others."""
    csv, own = tmp_path / "ten_bit.csv", tmp_path / "own.toml"
    assert cli("calibrate", "steps", "mecanum4", "--counts", "1023", "--csv", csv, "-o", own).code == 0
    answer = cli("calibrate", "steps", own, csv, "--json")
    assert answer.code == 0
    assert json.loads(answer.out)["counts"] == 1023


def test_a_curve_that_misses_a_step_or_ends_early_is_told(cli: Cli, made: Path, tmp_path: Path) -> None:
    """One sample of a step far off; and the upper half of PWM left out."""
    cut, half = tmp_path / "cut.csv", tmp_path / "half.csv"
    text = (made / "steps.csv").read_text()
    head, *rows = text.splitlines()
    last = sum(row.split(",")[3] == "0" for row in rows) - 1
    off = [*rows[:last], rows[last].rpartition(",")[0] + ",0", *rows[last + 1 :]]
    cut.write_text("\n".join([head, *off]))
    half.write_text("\n".join([head, *(row for row in rows if float(row.split(",")[2]) < 150.0)]))
    assert "W1W4 forward: the curve misses one step by" in cli(*STEPS, cut).err
    assert "W1W4 forward: PWM above 143 of 255 was not measured" in cli(*STEPS, half).err
