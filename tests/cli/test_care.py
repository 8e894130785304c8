"""What a slip of the hand must not cost: files, results, minutes."""

import json
from pathlib import Path

import pytest

import holodrive as hd
from holodrive.cli import main
from holodrive.errors import InputError


@pytest.mark.parametrize(
    "words",
    [
        ["run", "hybrid3", "--goal", "0.1,0", "-o", "FILE"],
        ["run", "hybrid3", "--goal", "0.1,0", "--report", "FILE"],
        ["compare", "hybrid3", "--goal", "0.1,0", "-o", "FILE"],
        ["kinematics", "hybrid3", "-o", "FILE"],
    ],
)
def test_a_robot_file_is_not_overwritten_by_what_a_verb_writes(words, tmp_path, capsys):
    file = tmp_path / "my_base.toml"
    file.write_text("precious")
    assert main([str(file) if word == "FILE" else word for word in words]) == 2
    assert file.read_text() == "precious"
    assert "writes" in capsys.readouterr().err


@pytest.mark.parametrize("start", [(1.5, 1.5, 0.0), (-5.0, -5.0, 0.0), (0.1, 2.0, 0.0)])
def test_a_robot_that_does_not_fit_at_its_start_is_refused(start):
    with pytest.raises(InputError, match="cannot start at"):
        hd.simulate("hybrid3", "paper_course", start=start)


@pytest.mark.parametrize("text", ["[" * 100_000, "a." * 50_000 + "b = 1"])
def test_hostile_toml_is_refused_in_one_line(text, tmp_path, capsys):
    file = tmp_path / "hostile.toml"
    file.write_text("robot = " + text if text.startswith("[") else text)
    assert main(["check", str(file)]) == 2
    assert "Traceback" not in capsys.readouterr().err


def test_a_seed_that_no_computer_holds_is_refused(capsys):
    assert main(["run", "hybrid3", "--goal", "1,1", "--seed", "1" * 26]) == 2
    assert "Traceback" not in capsys.readouterr().err


def test_a_path_that_takes_years_is_refused(capsys):
    assert main(["run", "mecanum4", "--path", "circle", "--size", "1e12"]) == 2
    assert "at most" in capsys.readouterr().err


def test_ctrl_c_in_the_demo_ends_it_without_a_result(monkeypatch, tmp_path):
    def stopped(*args, **options):
        return type("Run", (), {"ended": "interrupted"})()

    monkeypatch.setattr(hd, "drive", stopped, raising=False)
    assert main(["demo", "-o", str(tmp_path / "tour")]) == 130
    assert main(["compare", "hybrid3", "--goal", "1,1"]) == 130
    assert not Path(tmp_path / "tour" / "demo.html").exists()


def test_logs_of_one_name_in_two_folders_stay_two(tmp_path, capsys):
    for folder in ("monday", "tuesday"):
        (tmp_path / folder).mkdir()
        hd.drive(hd.simulate("omni3"), goal=(0.1, 0.0), duration_s=0.2, log=tmp_path / folder / "run.mcap")
    capsys.readouterr()
    assert main(["compare", *(str(tmp_path / day / "run.mcap") for day in ("monday", "tuesday")), "--json"]) == 0
    assert len(json.loads(capsys.readouterr().out)["runs"]) == 2


@pytest.mark.parametrize(
    "words",
    [
        ["run", "hybrid3", "--goal", "0.1,0", "--report", "FILE.html"],
        ["compare", "hybrid3", "--goal", "0.1,0", "-o", "FILE.html"],
        ["tune", "hybrid3", "--goal", "0.1,0", "-o", "FILE.json"],
        ["tune", "hybrid3", "--goal", "0.1,0", "--report", "FILE.html"],
        ["reproduce", "hybrid", "--table", "X", "-o", "FILE.html"],
        ["explain", "repaired", "-o", "FILE.fis"],
    ],
)
def test_a_place_that_cannot_be_written_to_is_refused_before_the_work(words, tmp_path, capsys, monkeypatch):
    """Not after it, when it would be lost."""
    monkeypatch.setattr(hd, "drive", None)
    target = str(tmp_path / "nowhere" / "result")
    assert main([word.replace("FILE", target) for word in words]) == 2
    assert "no folder" in capsys.readouterr().err


def test_a_run_says_first_what_is_wrong_with_its_words(capsys):
    """An unknown controller before a missing goal, and the goal in the words of the command line."""
    assert main(["run", "hybrid3", "-c", "fuzzzy"]) == 2
    assert "'fuzzzy'" in capsys.readouterr().err
    assert main(["run", "hybrid3", "-c", "pid"]) == 2
    assert "--goal X,Y" in capsys.readouterr().err
