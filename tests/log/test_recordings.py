"""Claims about reading recordings of real robots."""

import zipfile
from pathlib import Path

import numpy as np
import pytest
from logged import ticks

from holodrive import robots
from holodrive.errors import FileFaults, LogError, UnknownName
from holodrive.estimation import evaluate
from holodrive.log import Recorder, recordings

GOOD = """\
# a run in the lab, pushed by hand
# robot = "hybrid3"
# source = "our lab"
# licence = "CC0-1.0"
t,ticks.front,wheel.right,wheel.left,gyro_rad_s,x_m,y_m,theta_rad
0.0,0,0.0,0.0,0.1,1.0,2.0,3.0
0.1,16,0.1,-0.1,,,,
0.2,32,0.2,-0.2,0.1,1.1,2.1,3.1
"""


def hybrid3_wheels() -> list[str]:
    return [wheel.name for wheel in robots.load("hybrid3").wheels]


def csv(tmp_path: Path, text: str = GOOD, name: str = "lab.csv") -> Path:
    path = tmp_path / name
    path.write_text(text)
    return path


def faults(path: Path) -> list[str]:
    with pytest.raises(FileFaults) as error:
        recordings.read(path)
    return [fault.one_line().removeprefix(str(path)) for fault in error.value.faults]


# --- the package's own data ------------------------------------------------------------------------


def test_three_runs_ship_with_their_licence() -> None:
    assert [name.partition("_")[0] for name in recordings.shipped()] == ["circular", "square", "joystick"]
    assert recordings.SHIPPED.stat().st_size < 150_000
    notice = (recordings.SHIPPED.parent / "NOTICE").read_text()
    assert "MIT License" in notice
    for name in recordings.shipped():
        recording = recordings.read(name)
        assert recording.licence.startswith("MIT")
        assert recording.robot == "optiodom_omni3"


def test_the_shipped_runs_are_those_of_the_source(shared_data: Path) -> None:
    source = shared_data / "optiodom_omni3" / "runs.npz"
    for name in recordings.shipped():
        here, there = recordings.read(name), recordings.read(source, name)
        np.testing.assert_array_equal(here.position, there.position)
        np.testing.assert_array_equal(here.truth, there.truth)


def test_the_start_row_does_not_move() -> None:
    recording = recordings.read("circular_221220201701_run-03")
    assert (recording.position[0] == 0.0).all()
    assert recording.truth_at(recording.time[:1])[0].tolist() == recording.truth[0].tolist()


# --- which run ------------------------------------------------------------------------------------


def test_a_file_of_many_runs_asks_which() -> None:
    with pytest.raises(LogError, match="holds 3 runs, say which one: circular_221220201701_run-03, square"):
        recordings.read(recordings.SHIPPED)


def test_a_part_of_a_name_is_enough_when_no_other_has_it() -> None:
    assert recordings.read(recordings.SHIPPED, "square").family == "square"
    with pytest.raises(LogError, match="fits 3 runs"):
        recordings.read(recordings.SHIPPED, "run")
    with pytest.raises(UnknownName, match=r"no run in .* called 'spiral'"):
        recordings.read(recordings.SHIPPED, "spiral")


# --- other files ------------------------------------------------------------------------------------


def test_polimi_truth_is_held_before_it_begins_and_interpolated_after(shared_data: Path) -> None:
    recording = recordings.read(shared_data / "polimi_mecanum" / "bag2.npz")
    assert recording.truth_time[0] == pytest.approx(0.099, abs=1e-3)
    held = recording.truth_at(recording.time[:4])
    assert (held == held[0]).all()
    turning = recording.truth_at(recording.time)[:, 2]
    assert np.abs(np.diff(turning)).max() < 1.0  # the yaw of the file wraps


def test_a_log_of_ours_is_a_recording_of_its_wheels(tmp_path: Path) -> None:
    robot = robots.load("swerve3")
    given = ticks(robot, 30)
    with Recorder(tmp_path / "run.mcap", robot, None, {"controller": "pid"}) as recorder:
        for each in given:
            recorder.tick(each)
    recording = recordings.read(tmp_path / "run.mcap")
    np.testing.assert_array_equal(recording.position, [each.wheels.position for each in given])
    np.testing.assert_array_equal(recording.steer, [each.wheels.steer for each in given])
    np.testing.assert_array_equal(recording.truth, [each.truth for each in given])
    assert recording.spec == robot
    assert evaluate(recording).counts.jumps == 29  # random wheels


def test_a_log_without_ticks_is_told(tmp_path: Path) -> None:
    with Recorder(tmp_path / "run.mcap", robots.load("hybrid3")):
        pass
    with pytest.raises(LogError, match="no control tick"):
        recordings.read(tmp_path / "run.mcap")


def test_broken_and_foreign_files_are_told_in_one_line(tmp_path: Path) -> None:
    whole = recordings.SHIPPED.read_bytes()
    rng = np.random.default_rng(0)
    for i in range(60):
        broken = bytearray(whole)
        for place in rng.integers(0, len(whole), 20):
            broken[place] ^= 1 << int(rng.integers(8))
        data = bytes(broken) if i % 2 else whole[: int(rng.integers(1, len(whole)))]
        path = tmp_path / "broken.npz"
        path.write_bytes(data)
        try:
            recordings.read_all(path)
        except LogError as error:
            assert len(str(error).splitlines()) == 1  # noqa: PT017  many files, some of them still good
    np.savez(tmp_path / "other.npz", a=np.zeros(3))
    with pytest.raises(LogError, match="in none of the formats"):
        recordings.read(tmp_path / "other.npz")
    np.savez(tmp_path / "pickle.npz", a=np.array([{}], dtype=object))
    with pytest.raises(LogError, match="in none of the formats"):
        recordings.read(tmp_path / "pickle.npz")
    with zipfile.ZipFile(tmp_path / "plain.zip", "w") as archive:
        archive.writestr("a.txt", "hello")
    with pytest.raises(LogError, match="not a readable NumPy archive"):
        recordings.read(tmp_path / "plain.zip")
    (tmp_path / "empty").write_bytes(b"")
    with pytest.raises(LogError, match="the file is empty"):
        recordings.read(tmp_path / "empty")
    with pytest.raises(LogError, match="No such file"):
        recordings.read(tmp_path / "none.csv")
    with pytest.raises(LogError, match="Is a directory"):
        recordings.read(tmp_path)
    (tmp_path / "picture.png").write_bytes(b"\x89PNG\r\n\x1a\n" + bytes(100))
    with pytest.raises(LogError, match="in none of the formats"):
        recordings.read(tmp_path / "picture.png")


# --- CSV of your own ---------------------------------------------------------------------------------


def test_a_table_with_named_columns_is_a_recording(tmp_path: Path) -> None:
    recording = recordings.read(csv(tmp_path))
    counts = robots.load("hybrid3").wheels[0].encoder
    assert counts is not None
    assert recording.wheels == tuple(hybrid3_wheels())
    np.testing.assert_allclose(recording.position[:, 0], np.array([0, 16, 32]) * 2 * np.pi / counts.counts_per_turn)
    np.testing.assert_allclose(recording.position[:, 1:], [[0, 0], [0.1, -0.1], [0.2, -0.2]])
    assert recording.truth_time.tolist() == [0.0, 0.2]
    assert np.isnan(recording.gyro[1])
    assert (recording.source, recording.licence, recording.name) == ("our lab", "CC0-1.0", "lab")
    assert recording.truth_at(np.array([0.1])).tolist() == [[1.05, 2.05, 3.05]]


def test_counts_of_a_turn_may_be_given_for_all_or_for_each_wheel(tmp_path: Path) -> None:
    front = hybrid3_wheels()[0]
    for value in ("100", f"{{ {front} = 100 }}"):
        text = GOOD.replace('# source = "our lab"', f"# counts_per_turn = {value}")
        position = recordings.read(csv(tmp_path, text)).position
        np.testing.assert_allclose(position[:, 0], np.array([0, 16, 32]) * 2 * np.pi / 100)


def test_the_head_may_be_a_file_beside_the_table(tmp_path: Path) -> None:
    table = "\n".join(line for line in GOOD.splitlines() if not line.startswith("#"))
    (tmp_path / "lab.toml").write_text('robot = "hybrid3"\nname = "pushed by hand"\n')
    assert recordings.read(csv(tmp_path, table)).name == "pushed by hand"


def test_a_robot_of_your_own_is_found_beside_the_table(tmp_path: Path) -> None:
    (tmp_path / "mine.toml").write_text(robots.load("hybrid3").text)
    recording = recordings.read(csv(tmp_path, GOOD.replace('"hybrid3"', '"mine.toml"')))
    assert recording.robot == "mine.toml"
    assert evaluate(recording).robot == "hybrid3"


def test_a_swerve_table_needs_its_steering_angles(tmp_path: Path) -> None:
    names = [wheel.name for wheel in robots.load("swerve3").wheels]
    head = ",".join(["t", *(f"wheel.{name}" for name in names)])
    text = f'# robot = "swerve3"\n{head}\n0,0,0,0\n1,0,0,0\n'
    assert faults(csv(tmp_path, text)) == [
        f":2: no column 'steer.{name}' (steering angle in radians)" for name in names
    ]


@pytest.mark.parametrize(
    ("old", "new", "expected"),
    [
        ('# robot = "hybrid3"\n', "", ':1: which robot was recorded? (write # robot = "NAME" above the table, '),
        ('"hybrid3"', '"hybird3"', ":2: no robot called 'hybird3'. Did you mean 'hybrid3'?"),
        ("# source =", "# sorce =", ":3: unknown key 'sorce'. Did you mean 'source'? (known: "),
        ("# source =", "# source = =", ':3: not of the form key = "value": '),
        ('"our lab"', "7", ":3: source = 7, expected a text in quotes"),
        ("ticks.front", "ticks.frnt", ":5: unknown column 'ticks.frnt'. Did you mean 'ticks.front'?"),
        ("t,ticks", "time,ticks", ":5: unknown column 'time'"),
        ("wheel.left,", "wheel.right,", ":5: column 'wheel.right' is there twice"),
        ("ticks.front", "wheel.left", ":5: column 'wheel.left' is there twice"),
        ("theta_rad", "theta", ":5: unknown column 'theta'. Did you mean 'theta_rad'?"),
        ("theta_rad", "theta", ":5: the true pose lacks theta_rad (all of x_m, y_m, theta_rad, or none)"),
        ("0.1,16,", "0.1,,", ":7: ticks.front: an empty cell, expected a number"),
        ("0.1,16,", "0.1,many,", ":7: ticks.front: 'many' is not a number"),
        ("0.1,16,", "0.1,nan,", ":7: ticks.front: nan is not finite (leave out rows without a reading)"),
        ("0.1,16,", "inf,16,", ":7: t: inf is not finite"),
        ("0.1,16,", "0.1,16,9,", ":7: 9 cells, expected 8"),
        ("0.1,16,0.1,-0.1,,,,", "0.1;16;0.1;-0.1;;;;", ":7: 1 cells, expected 8 (separate by commas)"),
        ("\n0.2,", "\n0.05,", ":8: time goes back from 0.1 to 0.05 s (sort the rows by time)"),
    ],
)
def test_a_fault_is_told_with_its_line(old: str, new: str, expected: str, tmp_path: Path) -> None:
    assert GOOD.replace(old, new, 1) != GOOD
    found = faults(csv(tmp_path, GOOD.replace(old, new, 1)))
    assert any(line.startswith(expected) for line in found), found


def test_all_faults_of_a_file_are_told_at_once(tmp_path: Path) -> None:
    text = GOOD.replace("0.1,16,", "0.1,x,").replace("0.2,32,", "y,32,") + "0.3,1\n"
    assert [line.partition(" ")[0] for line in faults(csv(tmp_path, text))] == [":7:", ":8:", ":9:"]


def test_a_table_of_the_wrong_kind_does_not_flood(tmp_path: Path) -> None:
    text = GOOD + "a,b,c,d,e,f,g,h\n" * 1000
    found = faults(csv(tmp_path, text))
    assert len(found) < 40
    assert found[-1].endswith("reading stopped after 20 faults")


@pytest.mark.parametrize(
    "text", ["", "# only = 'a head'\n", "just words\n", "t,wheel.a\n", "\x00\x01binary", "t\n" * 5]
)
def test_what_is_no_table_is_told_without_a_traceback(text: str, tmp_path: Path) -> None:
    with pytest.raises((FileFaults, LogError)):
        recordings.read(csv(tmp_path, text))


def test_text_that_is_not_utf8_is_told(tmp_path: Path) -> None:
    (tmp_path / "latin.csv").write_bytes(GOOD.replace("lab", "L\xf6bau").encode("latin-1"))
    with pytest.raises(LogError, match="cannot be read as text"):
        recordings.read(tmp_path / "latin.csv")


def test_the_example_of_the_documentation_is_a_recording(tmp_path: Path) -> None:
    page = (Path(__file__).parents[2] / "docs" / "recordings.md").read_text()
    example = page.partition("```csv\n")[2].partition("```")[0]
    recording = recordings.read(csv(tmp_path, example))
    assert len(recording.time) >= 3
    assert evaluate(recording).counts.used == len(recording.time) - 1
