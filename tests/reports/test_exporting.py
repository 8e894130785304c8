"""Tables of numbers go out and come back the same."""

import csv
import json
import sys
from dataclasses import replace

import numpy as np
import pytest

from holodrive.errors import InputError, MissingExtra
from holodrive.reports import export
from holodrive.reports.exporting import columns


def test_csv_comes_back_bit_for_bit(short_run, tmp_path):
    with export(short_run, tmp_path / "run.csv").open(newline="") as file:
        header, *rows = csv.reader(file)
    values = np.array([[float(v) if v else np.nan for v in row] for row in rows])
    assert header == list(columns(short_run))
    for j, (_, expected) in enumerate(columns(short_run).values()):
        np.testing.assert_array_equal(values[:, j], expected)


def test_columns_name_their_units_and_their_wheels(short_run):
    names = list(columns(short_run))
    assert names[:4] == ["time_s", "x_m", "y_m", "theta_rad"]
    assert {"wheel.front_rad_s", "wheel_command.left_rad_s", "duty.right", "estimate.x_m", "slip_m_s"} <= set(names)


def test_steered_bases_have_columns_of_steering(make, bodies):
    assert {"steer.front_rad", "steer_command.left_rad"} <= set(columns(make(bodies["swerve3"](), seconds=1.0)))


def test_unknown_values_are_empty_cells(blank_run, tmp_path):
    lines = export(blank_run, tmp_path / "run.csv").read_text().splitlines()
    assert len(lines) == 2
    assert set(lines[1]) == {"0", ".", ","}


def test_parquet_comes_back_with_units_and_nulls(short_run, tmp_path):
    parquet = pytest.importorskip("pyarrow.parquet", reason="Parquet needs the extra 'data'")
    holes = replace(short_run, slip=np.where(np.arange(len(short_run.time)) % 2, np.nan, short_run.slip))
    content = parquet.read_table(export(holes, tmp_path / "run.parquet"))
    assert content.schema.field("x_m").metadata[b"unit"] == b"m"
    assert content["slip_m_s"].null_count == len(short_run.time) // 2
    np.testing.assert_array_equal(content["wheel.front_rad_s"].to_numpy(), short_run.wheel_speeds[:, 0])
    assert json.loads(content.schema.metadata[b"metrics"])["turns"] == 6.0


def test_parquet_without_pyarrow_says_what_to_install(short_run, tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "pyarrow", None)
    with pytest.raises(MissingExtra, match=r"pip install 'holodrive\[data\]'"):
        export(short_run, tmp_path / "run.parquet")


def test_json_holds_metrics_settings_and_events(run, blank_run, tmp_path):
    content = json.loads(export(run, tmp_path / "run.json").read_text())
    assert content["metrics"]["path_length_m"] == run.metrics["path_length_m"]
    assert [event["kind"] for event in content["events"]] == ["collision", "arrived"]
    assert json.loads(export(blank_run, tmp_path / "blank.json").read_text())["metrics"] == {"iae_m_s": None}


@pytest.mark.parametrize(
    ("name", "said"), [("run.xlsx", r"\.csv, \.json, \.parquet"), ("run.parqet", "Did you mean"), ("run.gif", "render")]
)
def test_an_unknown_ending_is_refused_with_the_known_ones(run, tmp_path, name, said):
    with pytest.raises(InputError, match=said):
        export(run, tmp_path / name)
