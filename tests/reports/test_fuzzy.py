"""A fuzzy system on a page: what is drawn is what the engine says."""

from xml.etree import ElementTree

import numpy as np
import pytest

from holodrive.control import fuzzy
from holodrive.control.fuzzy import Rule, Set, System, Variable
from holodrive.errors import InputError, UnknownName
from holodrive.reports import report
from holodrive.reports.fuzzy import FuzzySection, aggregated_chart, membership_chart, surfaces_svg
from holodrive.reports.surface import surface

AT = (420.0, 450.0, 600.0)


def test_the_page_has_sets_rules_findings_explanation_and_surfaces(parse):
    """Of the paper's second table, with the gap drawn as a hole."""
    page = parse(report(FuzzySection(fuzzy.load("paper_viii"), AT, ("DH", "DL"), (120, 3000))).html)
    for part in (
        "Sets of the inputs",
        "F-GAP",
        "43.6 %",
        "L over DH and DL",
        "no rule fires",
        "All 27 rules",
        "DL = 450",
    ):
        assert part in page.text
    assert "PZ" in page.text


def test_membership_charts_hold_the_sets_over_the_universe():
    """And mark the value."""
    variable = fuzzy.load("paper_viii").inputs[0]
    chart = membership_chart(variable, 420.0)
    assert [line.name for line in chart.lines] == ["N", "M", "F"]
    assert all((line.x[0], line.x[-1]) == (0.0, 2500.0) for line in chart.lines)
    assert chart.lines[0].y[0] == 1.0
    assert chart.lines[2].y[-1] == 1.0  # a shoulder stays up at the end of the universe
    assert chart.marks == (420.0,)


def test_the_aggregated_set_has_the_centroid_that_is_marked():
    """Integrated anew from the polyline that is drawn."""
    chart = aggregated_chart(fuzzy.load("paper_viii"), AT, 1)
    (line,) = [one for one in chart.lines if one.name == "aggregated"]
    width = np.diff(line.x)
    area = 0.5 * (line.y[1:] + line.y[:-1]) * width
    moment = width * (line.x[:-1] * (2 * line.y[:-1] + line.y[1:]) + line.x[1:] * (line.y[:-1] + 2 * line.y[1:])) / 6
    assert chart.marks[0] == pytest.approx(moment.sum() / area.sum(), abs=1e-9)


def test_nothing_fired_is_drawn_as_nothing():
    """At the gap."""
    chart = aggregated_chart(fuzzy.load("paper_viii"), (700, 500, 700), 0)
    assert chart.marks == ()
    assert "no rule fires" in chart.svg()


def test_a_surface_is_what_evaluate_gives_with_the_others_held():
    """At every point of its mesh."""
    system = fuzzy.load("paper_viii")
    shown = surface(system, ("DR", "DL"), 1, AT)
    assert shown.held == "DH = 420 mm"
    for i in range(0, len(shown.x), 7):
        for j in range(0, len(shown.y), 7):
            np.testing.assert_array_equal(shown.z[i, j], system.evaluate((420.0, shown.y[j], shown.x[i]))[1])


def test_a_gap_of_no_width_is_a_hole_in_the_surface():
    """No even grid would meet it; the repaired profile has none."""
    assert np.isnan(surface(fuzzy.load("paper_viii"), ("DH", "DL")).z).any()
    assert not np.isnan(surface(fuzzy.load("repaired"), ("DH", "DL")).z).any()
    assert "no rule fires" in surface(fuzzy.load("paper_viii"), ("DH", "DL")).svg()


def test_pictures_are_well_formed_and_escape_names():
    """Names come from files."""
    x = Variable("a<b", 0.0, 1.0, (Set("&", "gaussian", (0.5, 0.2)),))
    y = Variable("y", 0.0, 1.0, (Set("s", "singleton", (0.5,)),))
    ElementTree.fromstring(membership_chart(x).svg())
    one = System("<i>", (x, Variable("z", 0.0, 1.0)), (y,), (Rule((1, 0), (1,)),))
    ElementTree.fromstring(surfaces_svg(one, ("a<b", "z")))
    ElementTree.fromstring(aggregated_chart(one, (0.4, 0.2), 0).svg())


def test_sugeno_systems_and_single_inputs_have_a_page_too(parse):
    """Stems instead of areas; no surface."""
    x = Variable("x", 0.0, 1.0, (Set("low", "triangle", (0, 0, 1)), Set("high", "triangle", (0, 1, 1))))
    y = Variable("y", 0.0, 3.0, (Set("a", "constant", (1.0,)), Set("b", "constant", (3.0,))))
    system = System("line", (x,), (y,), (Rule((1,), (1,)), Rule((2,), (2,))), "sugeno", defuzzification="wtaver")
    page = parse(report(FuzzySection(system, (0.25,))).html)
    assert "y = 1.5" in page.text
    assert "Control surface" not in page.text


def test_a_section_shows_itself_in_a_notebook():
    """As a page in a frame."""
    assert FuzzySection(fuzzy.load("repaired"))._repr_html_().startswith("<iframe")


def test_a_wrong_surface_is_one_clear_line():
    """An unknown input, the same twice, only one."""
    system = fuzzy.load("repaired")
    with pytest.raises(UnknownName):
        surface(system, ("DH", "DX"))
    with pytest.raises(InputError, match="twice"):
        surface(system, ("DH", "DH"))


@pytest.mark.parametrize("at", [(420.0, 450.0), (1.0, 2.0, 3.0, 4.0), 420.0])
def test_a_point_that_is_not_one_number_for_each_input_is_refused(at):
    with pytest.raises(InputError, match="at is one number for each of DH, DL, DR"):
        FuzzySection(fuzzy.load("repaired"), at)


def test_a_name_is_no_system():
    with pytest.raises(InputError, match=r"fuzzy.load\('repaired'\); found 'repaired'"):
        FuzzySection("repaired")
