"""Each verb does its job, in words and as JSON, and meets wrong input with one clear line and exit code 2."""

import json
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

import holodrive as hd
from holodrive.cli import main

Cli = Callable[..., Any]  # see conftest.py


@pytest.fixture(scope="session")
def log(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A short recorded run."""
    path = tmp_path_factory.mktemp("log") / "run.mcap"
    hd.drive(hd.simulate("hybrid3", "room", seed=1), goal=(1.0, 1.0, 0.0), duration_s=1.0, log=path)
    return path


@pytest.fixture(autouse=True)
def _in_an_empty_folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)


def test_list_names_every_kind(cli: Cli) -> None:
    """With a title for each entry."""
    found = json.loads(cli("list", "--json").out)
    kinds = {"robots", "worlds", "controllers", "fuzzy", "planners", "estimators", "motors", "sensors"}
    assert set(found) == kinds
    assert all(entry["name"] and entry["title"] for kind in found.values() for entry in kind)
    assert {"hybrid3", "mecanum4", "swerve4"} <= {entry["name"] for entry in found["robots"]}


def test_list_of_one_kind(cli: Cli) -> None:
    """And a wrong kind is told the right ones."""
    assert "hybrid3" in cli("list", "robots").out
    assert cli("list", "robts").code == 2


@pytest.mark.parametrize("kind", ["robot", "world"])
def test_a_new_file_is_right_from_the_start(cli: Cli, kind: str) -> None:
    """`new`, then `check`."""
    assert cli("new", kind, "my_thing").code == 0
    answer = cli("check", "my_thing.toml")
    assert answer.code == 0, answer.err
    assert answer.out.startswith("ok")
    assert "my_thing" in answer.out


@pytest.mark.parametrize("kind", ["robot", "world"])
def test_new_writes_the_schema_for_editors(cli: Cli, kind: str) -> None:
    """By the name that the file's first line gives."""
    assert cli("new", kind, "mine", "--schema").code == 0
    name = Path("mine.toml").read_text().splitlines()[0].removeprefix("#:schema ")
    assert json.loads(Path(name).read_text())["type"] == "object"


def test_new_does_not_write_over_a_file(cli: Cli) -> None:
    """Unless told so."""
    Path("mine.toml").write_text("precious")
    answer = cli("new", "robot", "mine")
    assert answer.code == 2
    assert "--force" in answer.err
    assert Path("mine.toml").read_text() == "precious"
    assert cli("new", "robot", "mine", "--force").code == 0


@pytest.mark.parametrize("name", ["my base", "3wheels", "../x", "class", ""])
def test_new_refuses_names_that_make_no_file_or_class(cli: Cli, name: str) -> None:
    """With a right example."""
    assert cli("new", "robot", "--", name).code == 2


def test_a_new_controller_drives(cli: Cli) -> None:
    """The file that `new controller` writes is a controller."""
    assert cli("new", "controller", "mine").code == 0
    scope: dict[str, Any] = {"__name__": "mine"}
    exec(Path("mine.py").read_text(), scope)
    run = hd.drive(hd.simulate("hybrid3", seed=1), controller=scope["Controller"](), goal=(0.1, 0.05, 0.0))
    assert run.ended == "arrived"


def test_check_tells_all_faults_of_all_files(cli: Cli) -> None:
    """File, line, hint, count; exit code 2; the good file is still said to be good."""
    cli("new", "robot", "good")
    Path("bad.toml").write_text(Path("good.toml").read_text().replace("[robot]", "[robott]\nspeed = 3\n[robot]"))
    answer = cli("check", "bad.toml", "good.toml")
    assert answer.code == 2
    assert "--> bad.toml:" in answer.err
    assert "Traceback" not in answer.err
    assert answer.out.startswith("ok") and "good" in answer.out  # noqa: PT018
    results = json.loads(cli("check", "bad.toml", "good.toml", "--json").out)
    assert [result["ok"] for result in results] == [False, True]
    assert results[0]["faults"][0]["line"] > 0


def test_check_of_a_file_that_is_not_there(cli: Cli) -> None:
    """One line."""
    answer = cli("check", "nowhere.toml")
    assert answer.code == 2
    assert "nowhere.toml" in answer.err


def test_kinematics_in_words_numbers_and_a_drawing(cli: Cli) -> None:
    """Jacobian and condition; JSON with the matrix; an SVG."""
    answer = cli("kinematics", "hybrid3", "-o", "h.svg")
    assert answer.code == 0
    assert "condition" in answer.out
    assert Path("h.svg").read_text().startswith("<svg")
    data = json.loads(cli("kinematics", "hybrid3", "--json").out)
    assert data["jacobian"][0][1] == pytest.approx(19.6078, abs=1e-3)


def test_set_changes_the_robot(cli: Cli) -> None:
    """With a unit, and a wrong key is told the right one."""
    data = json.loads(cli("kinematics", "mecanum4", "--set", "wheel.fl.radius=30mm", "--json").out)
    assert abs(data["jacobian"][0][0]) == pytest.approx(1.0 / 0.030, rel=1e-9)
    answer = cli("kinematics", "mecanum4", "--set", "wheel.fl.radis=30mm")
    assert answer.code == 2
    assert "radius" in answer.err


def test_an_unknown_robot_is_told_the_nearest(cli: Cli) -> None:
    """By every verb that takes one."""
    for words in (["kinematics", "hybird3"], ["run", "hybird3"], ["compare", "hybird3", "--goal", "1,1"]):
        answer = cli(*words)
        assert answer.code == 2
        assert "Did you mean 'hybrid3'?" in answer.err


def test_run_logs_reports_and_says_how_it_went(cli: Cli) -> None:
    """One run with all its files."""
    words = ["run", "hybrid3", "--goal", "0.05,0.02", "--seed", "3", "-o", "run.mcap", "--report", "run.html"]
    answer = cli(*words)
    assert answer.code == 0, answer.err
    assert "arrived" in answer.out
    assert hd.read("run.mcap").settings["seed"] == 3
    assert "holodrive run hybrid3" in Path("run.html").read_text()
    again = json.loads(cli("run", "hybrid3", "--goal", "5cm,2cm", "--seed", 3, "--json").out)
    assert again["metrics"]["arrived"] == 1.0


@pytest.mark.parametrize(
    "words",
    [
        ["--goal", "1,1", "--path", "circle"],
        ["--goal", "1"],
        ["--via", "1,1", "--via", "1,1,1"],
        ["-c", "go_to_pse", "--goal", "1,1"],
        ["--goal", "1,1", "--set", "controller.nothing=3"],
        ["--goal", "1,1", "--duration", "-3"],
        ["--path", "circle", "--size", "3 kg"],
        ["-w", "rom"],
        [],  # the open floor has no goal
        ["--goal", "1,1", "-o", "no/such/folder/run.mcap"],
        ["--goal", "1,1", "--keys"],  # no terminal here
    ],
    ids=" ".join,
)
def test_wrong_words_for_run_are_told_in_one_line(cli: Cli, words: list[str]) -> None:
    """Exit code 2 and never a traceback."""
    answer = cli("run", "hybrid3", *words)
    assert answer.code == 2
    assert answer.err.startswith("error: ")
    assert "fault of holodrive" not in answer.err


@pytest.mark.parametrize("shape", ["circle", "infinity", "eight"])
def test_run_follows_paths(cli: Cli, shape: str) -> None:
    """From the start of the robot."""
    words = ["run", "mecanum4", "--path", shape, "--size", "5mm", "--speed", "20 mm/s", "--json"]
    metrics = json.loads(cli(*words).out)["metrics"]
    assert metrics["max_error_m"] < 0.005


def test_replay_tells_a_log_and_computes_it_again(cli: Cli, log: Path) -> None:
    """Bit for bit."""
    answer = cli("replay", log, "--rerun")
    assert answer.code == 0, answer.err
    assert "identical" in answer.out
    assert json.loads(cli("replay", log, "--rerun", "--json").out)["identical"] is True


def test_replay_of_a_log_as_a_recording(cli: Cli, log: Path) -> None:
    """Its odometry against its own truth."""
    rows = json.loads(cli("replay", log, "--odometry", "--json").out)["runs"]
    assert rows[0]["end_error_m"] < 0.05


def test_replay_of_the_shipped_recordings(cli: Cli) -> None:
    """Three real runs with figures, a page of them, a picture of one."""
    answer = cli("replay", "-o", "odometry.html")
    assert answer.code == 0, answer.err
    assert answer.out.count("_run-") == 3
    assert "Recorded: " in Path("odometry.html").read_text()
    name = json.loads(cli("replay", "--json").out)["runs"][0]["name"]
    assert cli("replay", name, "-o", "one.svg").code == 0
    assert Path("one.svg").read_text().startswith("<svg")


def test_replay_of_the_recorded_data_gives_the_known_medians(cli: Cli, shared_data: Path) -> None:
    """40 runs of optiodom: 174.8 mm; two bags of PoliMi: 0.215 and 1.217 m."""
    middle = json.loads(cli("replay", shared_data / "optiodom_omni3" / "runs.npz", "--json").out)["medians"]
    found = {row["family"]: round(1e3 * row["end_error_m"], 1) for row in middle}
    assert found["all"] == 174.8
    assert {name: round(found[name]) for name in ("circular", "square", "joystick")} == {
        "circular": 219,
        "square": 139,
        "joystick": 84,
    }
    for bag, rmse in (("bag1.npz", 0.215), ("bag2.npz", 1.217)):
        (row,) = json.loads(cli("replay", shared_data / "polimi_mecanum" / bag, "--json").out)["runs"]
        assert row["rmse_m"] == pytest.approx(rmse, abs=5e-4)


@pytest.mark.parametrize("words", [["nowhere.mcap"], ["nowhere.csv"], ["nowhere.npz", "--rerun"], ["empty.mcap"]])
def test_replay_of_nothing_is_told_in_one_line(cli: Cli, words: list[str]) -> None:
    """Exit code 2."""
    Path("empty.mcap").touch()
    answer = cli("replay", *words)
    assert answer.code == 2
    assert answer.err.startswith("error: ")


@pytest.mark.parametrize("ending", ["gif", "png", "svg", "html"])
def test_render_makes_what_the_ending_says(cli: Cli, log: Path, ending: str) -> None:
    """Something of some size."""
    answer = cli("render", log, "-o", f"run.{ending}")
    assert answer.code == 0, answer.err
    assert Path(f"run.{ending}").stat().st_size > 500


def test_render_refuses_an_ending_that_it_cannot_make(cli: Cli, log: Path) -> None:
    """And names those that it can."""
    answer = cli("render", log, "-o", "run.mp5")
    assert answer.code == 2
    assert "gif" in answer.err


@pytest.mark.parametrize("ending", ["csv", "parquet"])
def test_export_writes_a_table(cli: Cli, log: Path, ending: str) -> None:
    """One row a tick."""
    answer = cli("export", log, "-o", f"run.{ending}", "--json")
    assert answer.code == 0, answer.err
    assert json.loads(answer.out)["rows"] == len(hd.read(log).time)


def test_compare_controllers(cli: Cli) -> None:
    """The same seeds for each, a table and a page."""
    words = ["compare", "hybrid3", "-c", "go_to_pose,pid", "--goal", "0.05,0", "--runs", "2", "-o", "compare.html"]
    answer = cli(*words)
    assert answer.code == 0, answer.err
    header = answer.out.splitlines()[0]
    assert "go_to_pose" in header
    assert "pid" in header
    assert Path("compare.html").exists()


def test_compare_logs(cli: Cli, log: Path) -> None:
    """Side by side."""
    data = json.loads(cli("compare", log, log, "--json").out)
    assert "run" in data["runs"]


def test_demo_makes_a_table_a_page_and_logs(cli: Cli) -> None:
    """Four robots, each in its line; the page has a section for each."""
    answer = cli("demo", "-o", "tour")
    assert answer.code == 0, answer.err
    page = Path("tour/demo.html").read_text()
    for robot in ("hybrid3", "mecanum4", "swerve3", "optiodom_omni3"):
        assert robot in answer.out
        assert robot in page
    assert answer.out.count("arrived") == 3
    assert answer.err.splitlines()[-1].startswith("next ")
    assert hd.read("tour/swerve3.mcap").metrics["final_error_m"] < 0.05


def test_bench_gives_figures(cli: Cli, monkeypatch: pytest.MonkeyPatch) -> None:
    """Positive numbers with units; the long measures are left to people."""
    from holodrive.cli.commands import bench

    monkeypatch.setattr(bench, "MEASURES", (bench.control_tick,))
    monkeypatch.setattr(bench, "REPEATS", 1)
    figures = json.loads(cli("bench", "--json").out)
    assert figures
    assert all(figure["value"] > 0.0 and figure["unit"] for figure in figures)


def test_ctrl_c_ends_a_run_well(tmp_path: Path) -> None:
    """The run stops, its log is closed; what it holds can be computed again."""
    code = "import sys; from holodrive.cli import main; sys.exit(main(sys.argv[1:]))"
    words = ["run", "hybrid3", "--goal", "5,5", "--real-time", "-o", str(tmp_path / "run.mcap")]
    process = subprocess.Popen([sys.executable, "-c", code, *words], stdout=subprocess.PIPE, stderr=subprocess.PIPE)
    log = tmp_path / "run.mcap"
    for _ in range(600):
        if log.exists() and log.stat().st_size > 20_000:  # some chunks have been written
            break
        time.sleep(0.1)
    process.send_signal(signal.SIGINT)
    _, err = process.communicate(timeout=60)
    assert b"Traceback" not in err
    assert process.returncode == 130
    assert len(hd.read(log).time) > 10
    assert main(["replay", str(log), "--rerun"]) == 0
