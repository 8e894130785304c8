"""Step files: what is written comes back, units in the header, and every fault with its file and line."""

from collections.abc import Callable

import numpy as np
import pytest
from made_up_steps import all_steps

from holodrive import robots
from holodrive.calibration.steps import calibrate, groups_of, parse_csv, write_csv
from holodrive.errors import FileFaults, InputError

ROBOT = robots.load("mecanum4_mice")
GROUPS = groups_of(ROBOT)
GOOD = write_csv(all_steps())


def faults(text: str) -> list[str]:
    """Each fault of a text in one line."""
    with pytest.raises(FileFaults) as caught:
        parse_csv(text, GROUPS, name="mine.csv")
    return [fault.one_line() for fault in caught.value.faults]


def changed(line: int, text: str) -> str:
    """The good file with another line (from 1)."""
    lines = GOOD.splitlines()
    lines[line - 1] = text
    return "\n".join(lines)


def test_what_is_written_is_read_back_to_the_bit() -> None:
    """Records and the calibration that follows from them."""
    made, read = all_steps(), parse_csv(GOOD, GROUPS)
    assert len(read) == len(made)
    for one, other in zip(made, read, strict=True):
        assert (one.group, one.direction, one.pwm, one.command_time) == (
            other.group,
            other.direction,
            other.pwm,
            other.command_time,
        )
        np.testing.assert_array_equal(one.x, other.x)
        np.testing.assert_array_equal(one.time, other.time)
    assert calibrate(ROBOT, read).toml_tables(ROBOT) == calibrate(ROBOT, made).toml_tables(ROBOT)


def test_units_of_the_header_and_spellings_of_directions() -> None:
    """Columns in any order, others left alone, comments skipped, groups in small letters, time that counts on."""
    rows = ["# made by hand", "Y [mm],x_mm,note,time (ms),PWM,Direction,group"]
    for group in ("w1w4", "W2W3"):
        for direction in ("F", "-1"):
            for k, pwm in enumerate((40, 60, 90, 150, 255)):
                rows += [
                    f"{v * k * t},{v * k * t},ok,{1000 + 15 * t},{pwm},{direction},{group}"  # amounts without signs
                    for t in range(40)
                    for v in (0.1,)
                ]
    records = parse_csv("\r\n".join(rows), GROUPS)
    assert len(records) == 20
    last = records[-1]
    assert (last.group, last.direction, last.pwm) == ("W2W3", "backward", 255.0)
    assert last.time[0] == last.command_time == 1.0
    assert last.x[-1] == pytest.approx(1e-3 * 0.1 * 4 * 39)


@pytest.mark.parametrize("column", ["group", "direction", "pwm", "time", "x", "y"])
def test_a_missing_column_is_named(column: str) -> None:
    """With what was found and what is needed."""
    header = ["group", "direction", "pwm", "time", "x", "y"]
    header[header.index(column)] = "other"
    (fault,) = faults(",".join(header) + "\nW1W4,forward,60,0,0,0\n")
    assert fault.startswith(f"mine.csv:1: missing columns: {column}; found ")


def test_a_file_without_a_line_or_without_a_sample_is_empty() -> None:
    """Said as such."""
    assert "the file is empty" in faults("")[0]
    assert "no samples below the header" in faults("group,direction,pwm,time,x,y\n")[0]


def test_time_that_does_not_rise_is_told_with_its_line() -> None:
    """Also where it only stands."""
    before = GOOD.splitlines()[8]
    assert faults(changed(10, before))[0].startswith("mine.csv:10: time does not rise within a step")


def test_a_repeated_step_needs_a_run() -> None:
    """Without, its time falls; with, it is two steps."""
    rows = ["group,direction,pwm,time,x,y,run"]
    rows += [f"W1W4,forward,60,{t},{t},{t},{run}" for run in (1, 2) for t in range(5)]
    text = "\n".join(rows)
    assert not any("time does not rise" in fault for fault in faults(text))  # other groups are missing
    assert any("needs a column run" in fault for fault in faults("\n".join(row.rpartition(",")[0] for row in rows)))


@pytest.mark.parametrize(
    ("cells", "words"),
    [
        ("W1W4,forward,300,0,0.3,0,0", "PWM 300 is above full PWM, 255 counts: the step is saturated"),
        ("W1W4,forward,0,0,0.3,0,0", "PWM is 0: that is no step"),
        ("W1W4,forward,x,0,0.3,0,0", "pwm is 'x', not a number"),
        ("W1W4,forward,60,0,nan,0,0", "time is 'nan', not a number"),
        ("W1W4,up,60,0,0.3,0,0", "direction is 'up'; allowed: forward, backward"),
        ("W1W5,forward,60,0,0.3,0,0", "no group of wheels called 'W1W5'; known: W1W4, W2W3"),
        ("W1W4,forward", "has 2 cells; the header has 7 or more"),
    ],
)
def test_a_bad_row_is_told_in_one_line(cells: str, words: str) -> None:
    """With its number."""
    assert faults(changed(20, cells))[0].startswith(f"mine.csv:20: {words}")


def test_a_unit_that_is_unknown_or_told_twice() -> None:
    """The header says both."""
    found = faults("group,direction,pwm,time_h,x,x_mm,y\n")
    assert "column 'time_h' has an unknown unit (allowed for time: s, ms, us)" in found[0]
    assert "two columns tell x: 'x' and 'x_mm'" in found[1]


def test_a_step_of_one_sample_is_empty() -> None:
    """It has no duration."""
    assert "the step W1W4 forward at PWM 99 is empty" in faults(GOOD + "W1W4,forward,99,999,500.0,0,0\n")[0]


def test_a_step_that_never_moves_although_a_weaker_one_does() -> None:
    """Its first line is told; steps in the dead zone are welcome."""
    rows = [f"W1W4,forward,210,999,{500 + 0.015 * t},0,0" for t in range(50)]
    line = len(GOOD.splitlines()) + 1
    text = "the step W1W4 forward at PWM 210 never moves, although PWM 44 does"
    assert faults(GOOD + "\n".join(rows))[0].startswith(f"mine.csv:{line}: {text}")


def test_a_group_that_never_moves_and_one_that_is_missing() -> None:
    """Both directions of all groups are needed."""
    still = [row for row in GOOD.splitlines() if not row.startswith("W2W3,backward") or ",35," in row]
    assert any("no step of W2W3 backward ever moves, up to PWM 35" in fault for fault in faults("\n".join(still)))
    without = [row for row in still if not row.startswith("W2W3,backward")]
    assert faults("\n".join(without)) == [
        "mine.csv: there are no steps of W2W3 backward; every group needs both directions"
    ]


def test_a_saturated_sensor_is_told() -> None:
    """A reading that stops while the PWM is on; a crawl that pauses between counts is none."""
    rows = GOOD.splitlines()
    held = next(row for row in rows if row.startswith("W1W4,forward,200,") and float(row.split(",")[5]) > 0.02)
    x, y = held.split(",")[5:]
    cut = [
        ",".join([*row.split(",")[:5], x, y])
        if row.startswith("W1W4,forward,200,") and float(row.split(",")[5]) > float(x)
        else row
        for row in rows
    ]
    (fault,) = faults("\n".join(cut))
    assert "the sensor is saturated in the step W1W4 forward at PWM 200: its reading stands still from" in fault
    parse_csv(GOOD, GROUPS)


def test_many_faults_are_counted_after_the_twentieth() -> None:
    """Nobody reads four thousand lines."""
    head, *rows = GOOD.splitlines()
    found = faults("\n".join([head, *(row.replace("ward", f"ward{k}") for k, row in enumerate(rows))]))
    assert len(found) == 21
    assert "more faults are not listed" in found[-1]


def columns(change: Callable[[list[str]], None]) -> str:
    """The good file with its cells changed row by row: group, direction, pwm, run, time, x, y."""
    head, *rows = [line.split(",") for line in GOOD.splitlines()]
    for cells in rows:
        change(cells)
    return "\n".join(",".join(cells) for cells in [head, *rows])


def test_the_same_fault_of_many_rows_is_told_once() -> None:
    """With the first line and how many more."""
    text = GOOD.replace("W2W3", "W2W4")
    (fault,) = faults(text)
    assert "no group of wheels called 'W2W4'; known: W1W4, W2W3 (and in " in fault
    assert f"(and in {text.count('W2W4') - 1} more lines)" in fault


@pytest.mark.parametrize(("sign", "word"), [(";", "semicolons"), ("\t", "tabs")])
def test_another_separator_is_named(sign: str, word: str) -> None:
    """As spreadsheets of many countries write it."""
    (fault,) = faults(GOOD.replace(",", sign))
    assert f"{word} stand between the cells: write commas there" in fault


def exchanged(cells: list[str]) -> None:
    cells[1] = {"forward": "backward", "backward": "forward"}[cells[1]]


def without_x(cells: list[str]) -> None:
    cells[5] = "0"


def amounts_without_x(cells: list[str]) -> None:
    cells[5], cells[6] = "0", repr(abs(float(cells[6])))


def mirrored(cells: list[str]) -> None:
    cells[6] = repr(-float(cells[6]))


@pytest.mark.parametrize("change", [exchanged, without_x, amounts_without_x, mirrored])
def test_steps_that_go_beside_their_diagonal_are_refused(change: Callable[[list[str]], None]) -> None:
    """One fault for each group and direction, with where they went and where they should."""
    found = faults(columns(change))
    assert len(found) in (2, 4)
    assert all(" deg and not to " in fault and "more of W" in fault for fault in found)


def test_amounts_without_signs_are_taken() -> None:
    """The paper's equation 8 has no use for the signs either."""

    def amounts(cells: list[str]) -> None:
        cells[5:] = [repr(abs(float(cell))) for cell in cells[5:]]

    assert len(parse_csv(columns(amounts), GROUPS)) == len(parse_csv(GOOD, GROUPS))


def test_parts_of_full_duty_are_no_counts() -> None:
    """0 to 1 instead of 0 to 255."""

    def parts(cells: list[str]) -> None:
        cells[2] = repr(float(cells[2]) / 255.0)

    (fault,) = faults(columns(parts))
    assert "no PWM is above 1 of 255 counts (pwm is in counts: multiply parts of full duty by 255)" in fault


@pytest.mark.parametrize(("name", "other"), [("time_s", "time_ms"), ("x_m,y_m", "x_cm,y_cm")])
def test_speeds_that_the_motors_cannot_make_are_refused(name: str, other: str) -> None:
    """A wrong unit in the header is ten times or more."""
    records = parse_csv(GOOD.replace(name, other, 1), GROUPS)
    with pytest.raises(InputError, match="are time, x and y in the units that the header names"):
        calibrate(ROBOT, records)
