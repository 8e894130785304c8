"""Runs with mice as CSV: what is written is read back, and every fault has its line."""

import math
from pathlib import Path

import numpy as np
import pytest
from made_up_runs import FOOTPRINT_M, MICE, MOUNTS, SCALES, counts_of, end_of, steps_of

from holodrive.calibration.mice import calibrate
from holodrive.calibration.mouse_csv import parse_csv, read_csv, write_csv
from holodrive.calibration.mouse_runs import Accuracy
from holodrive.errors import FileFaults

HEAD = "run,kind,time,dx.one,dy.one,dx.two,dy.two\n"
GOOD = (
    HEAD
    + "".join(f"turning,spin,{t},0,0,1,90\n" for t in range(9))
    + "".join(f"ahead,ahead,{t},100,0,100,1\n" for t in range(9))
)


def made_up() -> tuple[str, dict[str, tuple[float, float, float]]]:
    """A whole file, and the ends of its runs."""
    generator = np.random.default_rng(0)
    steps = {kind: steps_of(kind, generator) for kind in ("spin", "ahead", "left")}
    ends = {kind: tuple(end_of(each).tolist()) for kind, each in steps.items()}
    runs = [
        (kind, kind, 0.01 * np.arange(len(each)), counts_of(each, MOUNTS, SCALES, generator))
        for kind, each in steps.items()
    ]
    return write_csv(runs, MICE, ends, Accuracy()), ends  # type: ignore[arg-type]


def test_a_file_that_was_written_is_read_back(tmp_path: Path) -> None:
    text, ends = made_up()
    file = tmp_path / "runs.csv"
    file.write_text(text, encoding="utf-8")
    runs = read_csv(file, MICE)
    for run in runs:
        np.testing.assert_allclose(run.measured[0].value, ends[run.name], rtol=1e-6)
        assert run.measured[0].what == "end"
    result = calibrate(runs, MICE, FOOTPRINT_M)
    assert result.parameter("two", "x").value == pytest.approx(MOUNTS[1].x, abs=1e-3)
    assert result.parameter("one", "scale").value == pytest.approx(SCALES[0, 0], rel=1e-3)


def test_columns_may_stand_in_any_order_beside_others() -> None:
    """Blank lines and comments between rows do not count either."""
    text = "note,dy.two,dx.two,time,kind,run,dy.one,dx.one\n" + "\n# half way\n".join(
        f"x,4,3,{t},ahead,a,2,1" for t in range(3)
    )
    (run,) = parse_csv(text, MICE, length_m=1.0)
    np.testing.assert_array_equal(run.total, [[3.0, 6.0], [9.0, 12.0]])


def test_turns_and_length_come_from_the_caller_or_the_file() -> None:
    """The way aside that nobody measured is known to a part of the length only."""
    spin, ahead = parse_csv(GOOD, MICE, turns=2.0, length_m=1.5)
    assert spin.measured[0].value[2] == pytest.approx(4.0 * math.pi)
    assert spin.measured[0].what == "body"
    np.testing.assert_array_equal(ahead.measured[0].value, [1.5, 0.0, 0.0])
    assert ahead.measured[0].sigma[1] == pytest.approx(0.015)
    same = parse_csv('# turns = 2\n# length = "150 cm"\n' + GOOD, MICE)
    np.testing.assert_array_equal(same[1].measured[0].value, ahead.measured[0].value)


def test_accuracies_come_from_the_file_unless_said() -> None:
    text = '# tape = "2 mm"\n# angle = "1 deg"\n# turns = 1\n# length = 1\n' + GOOD
    assert parse_csv(text, MICE)[1].measured[0].sigma[0] == 0.002
    assert parse_csv(text, MICE, accuracy=Accuracy(tape_m=0.003))[1].measured[0].sigma[0] == 0.003


def test_a_run_with_a_track_needs_nothing_else() -> None:
    rows = "".join(f"d,track,{t},0,0,1,1,{0.1 * t},0,{0.2 * t}\n" for t in range(30))
    runs = parse_csv(HEAD.strip() + ",x_m,y_m,theta_rad\n" + rows, MICE)
    assert {run.name for run in runs} == {"d"}
    assert sum(len(run.counts) for run in runs) == 29


@pytest.mark.parametrize(
    ("text", "line", "words"),
    [
        ("", 0, "the file is empty"),
        ("# turns = 2\n", 0, "the file is empty"),
        ("run,kind,time,dx.one,dy.one\n", 1, "missing columns: dx.two, dy.two"),
        (HEAD, 1, "no samples below the header"),
        (HEAD.strip() + ",x_m\n", 1, "the track lacks y_m, theta_rad"),
        (HEAD + "a,ahead,0,1,1,1,1\n", 2, "run 'a' is empty"),
        (HEAD + "a,ahead,0,1,1,1,1\na,ahead,0,1,1,1,1\n", 3, "time does not rise within run 'a': 0 s after 0 s"),
        (HEAD + "a,ahead,0,1,1,1,1\na,ahead,1,1,?,1,1\n", 3, "dy.one is '?', not a number"),
        (HEAD + "a,ahead,0,1,1,1,1\na,ahead,1,1,inf,1,1\n", 3, "dy.one is 'inf', not a number"),
        (HEAD + "a,ahead,0,1,1\n", 2, "has 5 cells"),
        (HEAD + "a,aheda,0,1,1,1,1\n", 2, "Did you mean 'ahead'?"),
        (HEAD + "a,ahead,0,1,1,1,1\na,left,1,1,1,1,1\n", 3, "a run has one kind"),
        (GOOD + "turning,spin,9,1,1,1,1\n", 20, "the rows of a run stand together"),
        (GOOD, 2, "by how much did run 'turning' turn?"),
        ("# turns = 1\n" + GOOD, 12, "how far did run 'ahead' go?"),
        ("# turns = 0\n# length = 1\n" + GOOD, 4, "a spin turns by a known angle"),
        ("# turns = 1\n# length = 0\n" + GOOD, 13, "known length above 0"),
        ("# turnz = 1\n" + GOOD, 1, "Did you mean 'turns'?"),
        ("# turns = one\n" + GOOD, 1, "not of the form"),
        ('# length = "1 deg"\n' + GOOD, 1, "is not a length"),
        ('# tape = "0 mm"\n' + GOOD, 1, "above 0"),
        ("# end.ahead = 1\n" + GOOD, 1, "end.ahead is a table"),
        ("# end.ahead = { z = 1 }\n" + GOOD, 1, "unknown key 'z'"),
        ("# turns = 1\n# length = 1\n# end.left = { x = 1 }\n" + GOOD, 0, "end.left is of no run in the file"),
        (GOOD.replace("ahead,ahead", "ahead,track"), 11, "needs the columns x_m, y_m, theta_rad"),
    ],
)
def test_faults_come_with_their_line(text: str, line: int, words: str) -> None:
    with pytest.raises(FileFaults) as caught:
        parse_csv(text, MICE)
    assert any(fault.line == line and words in fault.one_line() for fault in caught.value.faults), str(caught.value)


def test_a_file_full_of_faults_is_not_told_in_full() -> None:
    text = HEAD + "".join(f"a,ahead,{k},x{k},1,1,1\n" for k in range(100))
    with pytest.raises(FileFaults) as caught:
        parse_csv(text, MICE)
    assert len(caught.value.faults) == 21
    assert "more faults are not listed" in str(caught.value)
