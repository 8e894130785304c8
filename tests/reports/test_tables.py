"""Tables: one truth, five faces."""

import json
from dataclasses import replace

import numpy as np
import pytest
from rich.console import Console

from holodrive.log.words import told, with_unit, words
from holodrive.reports import metric_table, table

ROWS = [
    {"robot": "hybrid3", "arrived": True, "time_s": 25.38, "final_error_m": 0.0123},
    {"robot": "a|b", "arrived": False, "time_s": np.nan, "final_error_m": 0.5, "note": "<b>"},
]


def test_columns_share_unit_and_decimals():
    shown = table(ROWS)
    assert shown.headers == ("robot", "arrived", "time, s", "end error, mm", "note")
    assert shown.cells[0] == ("hybrid3", "yes", "25.38", "12.3", "")
    assert shown.cells[1] == ("a|b", "no", "—", "500.0", "<b>")


def test_json_keeps_the_values_and_knows_no_nan():
    assert json.loads(table(ROWS).json())[1]["time_s"] is None
    assert json.loads(table(ROWS).json())[0]["final_error_m"] == 0.0123


def test_text_and_markdown_are_aligned_and_escaped():
    assert "a\\|b" in table(ROWS).markdown()
    lines = table(ROWS, title="T").text().splitlines()
    assert lines[0] == "T"
    assert lines[1].index("time, s") + len("time, s") == lines[2].index("25.38") + len("25.38")


def test_html_is_escaped(parse):
    assert "<b>" not in table(ROWS).html()
    assert parse(table(ROWS).html()).text.count("<b>") == 1


def test_rich_shows_the_same_words():
    console = Console(width=120, no_color=True, force_terminal=False, record=True, file=open("/dev/null", "w"))  # noqa: SIM115
    console.print(table(ROWS).rich())
    console.file.close()
    assert "hybrid3" in console.export_text()


def test_the_best_value_of_each_metric_is_marked_and_differences_are_to_the_first(runs):
    shown = metric_table(runs, ["a", "b", "c"])
    rows = {row[0]: (i, row) for i, row in enumerate(shown.cells)}
    i, row = rows["time"]
    assert row[1:] == ("10.00\u00a0s", "9.00\u00a0s (−10 %)", "8.00\u00a0s (−20 %)")
    assert (i, 3) in shown.best
    assert (rows["nearest obstacle"][0], 3) in shown.best  # farther is better
    assert not {j for k, j in shown.best if k == rows["turns"][0]}  # all alike: none is best


@pytest.mark.parametrize(
    ("name", "value", "text"),
    [
        ("path_length_m", 5.4123, "5.412\u00a0m"),
        ("rms_error_m", 0.0312, "31.2\u00a0mm"),
        ("rms_error_m", 1.2174, "1.217\u00a0m"),
        ("final_heading_error_rad", np.radians(12.4), "12.4°"),
        ("saturated_share", 0.125, "12.5\u00a0%"),
        ("arrived", 1.0, "yes"),
        ("collisions", 2.0, "2"),
        ("min_clearance_m", np.inf, "none"),
        ("iae_m_s", 0.0063, "6.30\u00a0mm·s"),
        ("final_heading_error_rad", 1e-9, "0.000°"),
        ("energy_j", np.nan, "—"),
        ("brand_new_rad_s", 0.5, "0.5000\u00a0rad/s"),
    ],
)
def test_numbers_are_told_with_sensible_digits_and_units(name, value, text):
    assert with_unit(name, value) == text


def test_an_unknown_metric_is_read_from_its_name():
    assert (words("top_slip_m_s").label, words("top_slip_m_s").unit) == ("top slip", "m/s")
    assert told("odd", [1.0, 2.0]) == ("", ["1", "2"])


def test_a_run_that_is_soon_at_its_end_because_it_hit_something_is_not_the_best(make):
    """Nor one that did not arrive; where no run arrived unharmed, all compete."""
    first, second, third = (make(seed=seed, seconds=2.0, scans=False) for seed in range(3))
    ends = ((30.0, 1.0, 0.0), (20.0, 1.0, 0.0), (5.0, 1.0, 1.0))
    runs = [
        replace(run, metrics={"time_s": time, "arrived": arrived, "moved_collisions": hits})
        for run, (time, arrived, hits) in zip((first, second, third), ends, strict=True)
    ]
    shown = metric_table(runs, ("slow", "quick", "crash"))
    row = [cells[0] for cells in shown.cells].index("time")
    assert {column for i, column in shown.best if i == row} == {2}
    crashed = [replace(run, metrics=run.metrics | {"moved_collisions": 1.0}) for run in runs]
    shown = metric_table(crashed, ("slow", "quick", "crash"))
    assert {column for i, column in shown.best if i == row} == {3}
