"""Claims: a verdict is what the numbers say, and nothing of a claim is lost on its way to a table."""

import pytest

from holodrive import experiments
from holodrive.errors import UnknownName
from holodrive.experiments import Claim, claim_table, claimed


@pytest.mark.parametrize(("ours", "verdict"), [(100.9, "agrees"), (101.1, "differs"), (99.1, "agrees")])
def test_a_number_agrees_within_its_tolerance_and_differs_beyond_it(ours, verdict):
    assert claimed("Table X", "time", 100.0, ours, within=0.01).verdict == verdict


def test_the_difference_is_told_in_percent_of_what_is_printed():
    assert claimed("Table X", "path", 574.7, 410.2, "cm").difference == "−28.6 %"
    assert claimed("Eq. 19", "entry", 19.6, 19.6).difference == "0 %"
    assert Claim("text", "states", "seventeen", "27", "contradicts itself").difference == ""
    assert Claim("Table X", "error", 0.0, 1.0, "differs").difference == ""


def test_a_claim_table_has_a_row_for_each_claim_and_the_plain_numbers_beside_it():
    claims = [
        claimed("Table X", "path", 574.7, 410.2, "cm", note="why"),
        Claim("Fig. 31", "lidar", None, None, "no number"),
    ]
    table = claim_table(claims)
    assert table.cells[0] == ("Table X", "path", "574.7 cm", "410.2 cm", "−28.6 %", "differs", "why")
    assert table.cells[1][2:4] == ("—", "—")
    assert table.data[0]["printed"] == 574.7
    assert "differs" in table.text()


def test_experiments_are_found_by_their_folders_and_unknown_ones_are_named():
    assert "hybrid" in experiments.names()
    with pytest.raises(UnknownName, match="hybrid"):
        experiments.load("hybird")
    with pytest.raises(UnknownName, match="table-x"):
        experiments.load("hybrid").part("table-xx")
