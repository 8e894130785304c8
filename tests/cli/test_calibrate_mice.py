"""`holodrive calibrate mice`: drives, measures, writes the robot's file; one clear line for what cannot be."""

import json
import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from holodrive import build, robots

Cli = Callable[..., Any]  # see conftest.py
CALIBRATE = ("calibrate", "mice")
HIDDEN = {
    "sensor.mouse.one.mount.yaw": "4 deg",
    "sensor.mouse.one.mount.x": "6 mm",
    "sensor.mouse.two.mount.y": "-8 mm",
    "sensor.mouse.two.resolution": "9.2 um",
}
SET = tuple(word for key, value in HIDDEN.items() for word in ("--set", f"{key}={value}"))
SHORT = ("--turns", "1.5", "--length", "20cm", "--plant", "first_order")


@pytest.fixture(autouse=True)
def _in_an_empty_folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)


@pytest.mark.parametrize("plant", ["first_order", "pwm_map", "slip"])
def test_a_simulated_robot_is_found_as_it_is(plant: str) -> None:
    """On every plant, wheels that slip or answer unevenly included: nothing but tape and mice is believed."""
    robot = robots.load("mecanum4", HIDDEN)
    found = build.calibrate_mice(robot, plant=plant, seed=3)  # type: ignore[arg-type]
    for mouse in robot.mice:
        true = {"yaw": mouse.mount.theta, "scale": mouse.resolution_m, "x": mouse.mount.x, "y": mouse.mount.y}
        for name, value in true.items():
            each = found.parameter(mouse.name, name)
            assert abs(each.value - value) < 4.0 * each.sigma
    assert found.complete
    assert found.widened == 1.0


def test_it_does_not_look_at_the_mounts() -> None:
    """The same runs give the same numbers, whatever the file believes of its mice."""
    robot = robots.load("mecanum4", HIDDEN)
    runs = [build_run for build_run in _runs(robot)]
    own, other = (build.calibrate_mice(each, runs) for each in (robot, robots.load("mecanum4")))
    assert [p.value for p in own.parameters] == pytest.approx([p.value for p in other.parameters], rel=1e-5, abs=1e-8)


def _runs(robot: Any) -> Any:
    from holodrive.calibration import mouse_moves
    from holodrive.calibration.mouse_runs import Accuracy

    driven = build.drive_mice(robot, turns=1.5, length_m=0.2, seed=1)
    return [mouse_moves.run_of(each, Accuracy()) for each in driven]


def test_it_writes_a_new_file_and_says_how_well(cli: Cli) -> None:
    answer = cli(*CALIBRATE, "mecanum4", *SET, *SHORT, "-o", "new.toml")
    assert answer.code == 0, answer.err
    assert "two scale 10.0000 um 9.2" in " ".join(answer.out.split())
    assert "told by" in answer.out
    assert re.search(r"spin (100|9\d) %!", answer.out)
    assert "degrees of freedom" in answer.out
    robot = robots.load("new.toml")
    assert robot.mice[0].mount.x == pytest.approx(0.006, abs=0.003)
    assert robot.mice[1].resolution_m == pytest.approx(9.2e-6, rel=0.02)
    assert cli("check", "new.toml").code == 0


def test_runs_from_a_file_give_what_the_simulation_gave(cli: Cli) -> None:
    here = json.loads(cli(*CALIBRATE, "mecanum4", *SET, *SHORT, "--csv", "runs.csv", "--json").out)
    Path("mine.toml").write_text(robots.load("mecanum4").text, encoding="utf-8")
    there = json.loads(cli(*CALIBRATE, "mine.toml", "runs.csv", "--write", "--json").out)
    for one, two in zip(here["parameters"], there["parameters"], strict=True):
        assert two["value"] == pytest.approx(one["value"], rel=1e-4, abs=1e-6)
    assert there["file"] == "mine.toml"
    assert robots.load("mine.toml").mice[1].resolution_m == pytest.approx(9.2e-6, rel=0.02)


def test_a_log_of_any_drive_will_do(cli: Cli) -> None:
    """By the truth in it, or by wheel odometry."""
    drive = ("run", "mecanum4", "--path", "infinity", "--size", "20cm", "--speed", "30 mm/s", "--duration", "30")
    assert cli(*drive, "--set", "sensor.mouse.two.mount.yaw=3 deg", "-o", "log.mcap").code == 0
    answer = cli(*CALIBRATE, "mecanum4", "log.mcap", "--json")
    assert answer.code == 0, answer.err
    yaw = next(p for p in json.loads(answer.out)["parameters"] if (p["mouse"], p["parameter"]) == ("two", "yaw"))
    assert yaw["value"] == pytest.approx(0.05236, abs=0.002)


RUNS = "run,kind,time,dx.one,dy.one,dx.two,dy.two\n"
DEAD = RUNS + "".join(f"a,ahead,{t},100,0,0,0\n" for t in range(9))
FAR = (
    RUNS
    + "".join(f"s,spin,{t},0,0,0,40000\n" for t in range(9))
    + "".join(f"a,ahead,{t},10000,0,10000,0\n" for t in range(10))
    + "".join(f"l,left,{t},0,10000,0,10000\n" for t in range(10))
)


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (("hybrid3",), "hybrid3 has no mice to calibrate"),
        (("mecanum4", "--write"), "stays as it is"),
        (("mecanum4", "-o", "there.toml"), "there is such a file already"),
        (("mecanum4", "-o", "new.txt"), "writes .toml"),
        (("mecanum4", "-o", "nowhere/new.toml"), "no folder"),
        (("mecanum4", "-o", "new.toml", "--write"), "give one of them"),
        (("mecanum4", "--csv", "dead.csv"), "there is such a file already"),
        (("mecanum4", "dead.csv", "--set", "robot.mass=1kg"), "from a file or from a simulated robot"),
        (("mecanum4", "--set", "controller.k=1"), "no controller steers"),
        (("mecanum4", "--turns", "0"), "--turns is a number from 0.25"),
        (("mecanum4", "--length", "1 mm"), "--length is 5 cm to 100 m"),
        (("mecanum4", "--length", "1 kg"), "--length"),
        (("mecanum4", "--tape", "0 mm"), "above 0"),
        (("mecanum4", "none.csv"), "no such file"),
        (("mecanum4", "none.mcap"), "none.mcap"),
        (("mecanum4", "few.csv", "-o", "new.toml"), "missing columns: dx.two, dy.two"),
        (("mecanum4", "dead.csv", "--length", "1", "-o", "new.toml"), "mouse two counted 0 in run 'a'"),
        (("mecanum4", "far.csv", "--turns", "1", "--length", "1", "-o", "new.toml"), "outside its footprint"),
    ],
)
def test_what_cannot_be_takes_one_line_and_writes_nothing(cli: Cli, arguments: tuple[str, ...], words: str) -> None:
    Path("there.toml").write_text("mine", encoding="utf-8")
    Path("few.csv").write_text("run,kind,time,dx.one,dy.one\n", encoding="utf-8")
    Path("dead.csv").write_text(DEAD, encoding="utf-8")
    Path("far.csv").write_text(FAR, encoding="utf-8")
    before = {file.name: file.read_bytes() for file in Path().iterdir()}
    answer = cli(*CALIBRATE, *arguments)
    assert answer.code == 2
    assert words in answer.err
    assert "Traceback" not in answer.err
    assert {file.name: file.read_bytes() for file in Path().iterdir()} == before
