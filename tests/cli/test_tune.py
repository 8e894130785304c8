"""`holodrive tune` says what it found, writes what `run` can use, and meets wrong input with one clear line."""

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

Cli = Callable[..., Any]  # see conftest.py

PATH = ("--path", "circle", "--size", "0.2 m", "--speed", "0.3 m/s")
SMALL = (
    "--budget",
    28,
    "--runs",
    2,
    "--validate",
    4,
    "--held-out",
    6,
    "--field",
    "kp=0.2:10:log",
    "--field",
    "kd=0:0.3",
)
TUNE = ("tune", "hybrid3_table_x", "-c", "pid", *PATH, "--set", "controller.kp=0.4", *SMALL)


@pytest.fixture(autouse=True)
def _in_an_empty_folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)


def test_tune_then_run(cli: Cli) -> None:
    """The file goes into `run`; the table, the options and the page say the same."""
    answer = cli(*TUNE, "-o", "tuned.json", "--report", "tuned.html")
    assert answer.code == 0, answer.err
    values = json.loads(Path("tuned.json").read_text())
    assert values["controller"] == "pid"
    assert set(values["best"]) == {"kp", "kd"}
    assert "RMS error" in answer.out
    assert f"--set controller.kp={values['best']['kp']!r}" in answer.out
    assert "better: cost -" in answer.out
    assert "--params tuned.json" in answer.err
    page = Path("tuned.html").read_text()
    assert all(words in page for words in ("Before and after", "Search", "kp", "holodrive tune"))
    run = cli("run", "hybrid3_table_x", *PATH, "--params", "tuned.json", "--json")
    assert run.code == 0, run.err
    settings = json.loads(run.out)["settings"]
    assert settings["controller"] == "pid"
    assert settings["params"] == values["params"]
    over = cli("run", "hybrid3_table_x", *PATH, "--params", "tuned.json", "--set", "controller.kp=2", "--json")
    assert json.loads(over.out)["settings"]["params"]["kp"] == 2


def test_the_same_again(cli: Cli) -> None:
    """As JSON, on one thread and on two."""
    one, two = (json.loads(cli(*TUNE, "--json", "--workers", n).out) for n in (1, 2))
    one["settings"].pop("command")
    two["settings"].pop("command")
    assert one == two


def test_random_courses_are_judged_by_success(cli: Cli) -> None:
    """With the rate and its interval."""
    answer = cli("tune", "hybrid3_table_x", "--worlds", "course", "--duration", 2, *SMALL[:8])
    assert answer.code == 0, answer.err
    assert "success" in answer.out
    assert "ran into something" in answer.out


@pytest.mark.parametrize(
    ("words", "told"),
    [
        (("--metric", "rms_eror_m"), "Did you mean 'rms_error_m'"),
        (("--metric", "energy_j"), "energy_j is not known"),
        (("--field", "kq=1:2"), "no parameter of pid called 'kq'"),
        (("--field", "ki=2:1"), "low < high"),
        (("--field", "ki"), "NAME=LOW:HIGH"),
        (("--fields", "arrive_m"), "says no bounds for 'arrive_m'"),
        (("--budget", 0), "0 is not in the range"),
        (("--budget", 3), "below one generation"),
        (("--sigma", 3), "at most 1"),
        (("--goal", "1,1"), "--goal or --path"),
        (("--worlds", "course", "-w", "room"), "-w or --worlds"),
        (("--worlds", "course"), "--path goes with one world"),
        (("--crossers", 2), "--worlds course"),
        (("--workers", 2, "--cluster", "tcp://127.0.0.1:9"), "--workers or --cluster"),
        (("-o", "tuned.toml"), ".json"),
        (("--validate", 20_000), "10000"),
        (("--set", "controller.kpp=1"), "Did you mean 'kp"),
        (("-c", "nobody"), "no controller called 'nobody'"),
    ],
)
def test_wrong_input_is_told_in_one_line(cli: Cli, words: tuple[Any, ...], told: str) -> None:
    """With exit code 2 and no trace."""
    answer = cli(*TUNE, *words)
    assert answer.code == 2
    assert told in answer.err
    assert "Traceback" not in answer.err


def test_a_cluster_that_is_not_there(cli: Cli, monkeypatch: pytest.MonkeyPatch) -> None:
    """One line, soon."""
    pytest.importorskip("distributed")
    monkeypatch.setattr("holodrive.tuning.cluster.TIMEOUT_S", 0.3)
    answer = cli(*TUNE, "--cluster", "tcp://127.0.0.1:9")
    assert answer.code == 2
    assert "no Dask scheduler answers at 'tcp://127.0.0.1:9'" in answer.err


@pytest.mark.parametrize(
    ("text", "told"),
    [(None, "cannot be read"), ("{", "no JSON"), ("[]", 'no "params"'), ('{"params": 3}', 'no "params"'),
     ('{"controller": "pid", "params": {"kpp": 1}}', "no parameter 'kpp'")],
)  # fmt: skip
def test_files_that_hold_no_parameters(cli: Cli, text: str | None, told: str) -> None:
    """One line each."""
    if text is not None:
        Path("x.json").write_text(text)
    answer = cli("run", "hybrid3", "--goal", "1,1", "--params", "x.json")
    assert answer.code == 2
    assert told in answer.err


def test_a_file_of_another_controller(cli: Cli) -> None:
    """-c and the file must agree."""
    Path("x.json").write_text('{"controller": "pid", "params": {"kp": 1.0}}')
    answer = cli("run", "hybrid3", "-c", "go_to_pose", "--goal", "1,1", "--params", "x.json")
    assert answer.code == 2
    assert "for controller 'pid', and -c says 'go_to_pose'" in answer.err
