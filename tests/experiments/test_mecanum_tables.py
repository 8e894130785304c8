"""What is found wrong in Tables I and II of the second paper, found by computing."""

import json
from dataclasses import replace

import numpy as np
import pytest

from holodrive.experiments import Setting
from holodrive.experiments.mecanum import printed, statistics, tables


def claim(result, part):
    found = [c for c in result.claims if part in f"{c.where} {c.what}"]
    assert found, part
    return found[0]


@pytest.mark.parametrize(("name", "rows"), [("table_IAE", printed.TABLE_I), ("table_ISE", printed.TABLE_II)])
def test_all_rows_and_their_statistics_are_those_of_the_vectors(shared_data, name, rows):
    vectors = json.loads((shared_data / "paper_vectors.json").read_text())["seed002"][name]
    columns = statistics.Columns.of(rows)
    assert len(rows) == len(vectors) == 32
    for i, (row, vector) in enumerate(zip(rows, vectors, strict=True)):
        assert (row.angle_deg, list(row.runs)) == (vector["alpha0"], vector["runs"])
        assert (row.deviation, row.variation) == (vector["printed_SD"], vector["printed_COV"])
        assert columns.population[i] == pytest.approx(vector["sd_pop"], abs=1e-9)
        assert columns.sample[i] / columns.mean[i] == pytest.approx(vector["cov_sample"], abs=1e-9)


def test_table_i_mixes_its_conventions_in_31_rows_and_table_ii_does_not_in_32():
    first, second = tables.table_i(Setting()), tables.table_ii(Setting())
    assert claim(first, "SD with n, of the population").ours == "31 of 32 rows"
    assert claim(first, "COV with").ours == "31 of 32 rows"
    assert claim(second, "SD with n − 1").ours == "32 of 32 rows"
    assert claim(second, "COV with").ours == "32 of 32 rows"


def test_one_wrong_digit_explains_the_row_that_does_not_fit_and_only_one_does():
    tried, found = statistics.misprints(printed.TABLE_I[15])
    assert (tried, found) == (252, [(4, 485.6138)])
    runs = np.array([*printed.TABLE_I[15].runs[:3], 485.6138])
    assert runs.std() == pytest.approx(123.3795, abs=1e-4)
    assert runs.std(ddof=1) / runs.mean() == pytest.approx(0.5022, abs=1e-4)


@pytest.mark.parametrize(("row", "run", "wrong"), [(0, 2, 54.3559), (7, 1, 98.3929), (31, 4, 692.9796)])
def test_a_digit_changed_in_a_row_that_fits_is_found_again(row, run, wrong):
    right = printed.TABLE_I[row]
    spoilt = replace(right, runs=(*right.runs[: run - 1], wrong, *right.runs[run:]))
    _, found = statistics.misprints(spoilt)
    assert (run, right.runs[run - 1]) in found


def test_copied_runs_are_found_and_the_copy_is_told_from_the_original():
    twins = statistics.twins(printed.TABLE_I)
    angles = {(printed.TABLE_I[t.first[0]].angle_deg, printed.TABLE_I[t.second[0]].angle_deg) for t in twins}
    assert angles == {(33.75, 213.75), (241.875, 241.875)}
    assert len(twins) == 5
    result = tables.table_i(Setting())
    assert "213.75° holds the copy" in claim(result, "runs of 33.75°").note
    assert "both tables" in claim(result, "241.875°").ours


def test_cauchy_and_schwarz_bound_samples_whatever_the_errors():
    rng = np.random.default_rng(1)
    for n in (1, 7, 400):
        errors = np.abs(rng.normal(size=n))
        assert statistics.least_samples(np.array(errors.sum()), np.array((errors**2).sum())) <= n * (1 + 1e-12)
        assert statistics.weighted_error(np.array(errors.sum()), np.array((errors**2).sum())) <= errors.max() + 1e-12


def test_units_cannot_be_decided_and_the_bounds_say_how_far_one_comes():
    result = tables.units(Setting())
    assert claim(result, "samples a run needs").ours == "243, 627"
    assert claim(result, "as sums: a run lasts").ours == "3.6, 9.4 s"
    assert claim(result, "sums or integrals").ours == "cannot be decided"
    assert claim(result, "Table I mean of all runs").ours == pytest.approx(118.03, abs=0.005)
    assert claim(result, "Table II mean of all runs").ours == pytest.approx(100.12, abs=0.005)
    assert claim(result, "ISE / IAE").ours == "0.32, 1.84 mm"


def test_the_error_grows_towards_90_and_270_degrees_as_the_text_says():
    result = tables.table_i(Setting())
    assert claim(result, "grows").verdict == "agrees"
    assert claim(result, "mean at 0°").ours == "44, 259, 53, 511 mm"


def test_tables_on_the_page_have_all_rows_and_say_which_one_does_not_fit():
    for make, misfits in ((tables.table_i, [84.375]), (tables.table_ii, [])):
        data = make(Setting()).data["rows"]
        assert len(data) == 32
        assert [row["angle_deg"] for row in data if not row["fits"]] == misfits
