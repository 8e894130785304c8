"""Charts and paths: what is drawn is what was measured."""

import re
from xml.etree import ElementTree

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from holodrive import svg
from holodrive.log.shapes import text_width
from holodrive.log.view import View
from holodrive.reports.plots import Axes, Chart, Line, decimate


def points(path: str) -> np.ndarray:
    """Absolute points of the paths that `svg.path_data` writes."""
    found = []
    for piece in path.split("M")[1:]:
        start, _, rest = piece.partition("l")
        numbers = [float(n) for n in re.findall(r"-?(?:\d+\.?\d*|\.\d+)", start.replace("h0", ""))]
        steps = np.array([float(n) for n in re.findall(r"-?(?:\d+\.?\d*|\.\d+)", rest)]).reshape(-1, 2)
        found.append(np.concatenate([[numbers], numbers + np.cumsum(steps, axis=0)]))
    return np.concatenate(found)


@given(st.lists(st.tuples(st.floats(-5e3, 5e3), st.floats(-5e3, 5e3)), min_size=1, max_size=30))
def test_a_path_written_and_read_is_the_same_within_a_twentieth_of_a_pixel(pairs):
    xy = np.array(pairs)
    back = points(svg.path_data(xy))
    keep = np.concatenate([[True], np.any(np.diff(np.rint(xy * 10), axis=0) != 0, axis=1)])
    np.testing.assert_allclose(back, xy[keep], atol=0.0501)


def test_gaps_break_a_path():
    xy = np.array([[0, 0], [1, 1], [np.nan, 2], [3, 3], [4, np.inf], [5, 5], [6, 6]])
    assert svg.path_data(xy).count("M") == 3


@given(st.integers(0, 2**32 - 1), st.floats(0.05, 5.0))
def test_a_simplified_path_stays_within_its_tolerance(seed, tolerance):
    xy = np.cumsum(np.random.default_rng(seed).normal(size=(200, 2)), axis=0)
    thin = svg.simplify(xy, tolerance)
    a, b = thin[:-1], thin[1:]
    along = np.clip(((xy[:, None] - a) * (b - a)).sum(-1) / np.maximum(((b - a) ** 2).sum(-1), 1e-12), 0, 1)
    distance = np.linalg.norm(xy[:, None] - (a + along[..., None] * (b - a)), axis=-1).min(axis=1)
    assert distance.max() <= 2.0 * tolerance
    np.testing.assert_array_equal(thin[[0, -1]], xy[[0, -1]])


@given(st.floats(-1e6, 1e6), st.floats(1e-6, 1e6), st.integers(2, 12))
def test_ticks_are_round_few_and_inside(low, span, count):
    ticks, decimals = svg.ticks(low, low + span, count)
    assert len(ticks) <= 2.1 * count + 2
    slack = 1e-6 * span + 4.0 * np.spacing(abs(low) + span)  # a tick far from zero is rounded by itself
    assert ((ticks >= low - slack) & (ticks <= low + span + slack)).all()
    np.testing.assert_allclose(ticks, np.round(ticks, decimals), atol=1e-9 * max(1.0, abs(low), span))


@given(st.integers(0, 2**32 - 1), st.integers(1, 50))
def test_thinning_keeps_ends_peaks_and_gaps(seed, buckets):
    rng = np.random.default_rng(seed)
    y = rng.normal(size=3000)
    y[rng.integers(3000)] = 100.0
    y[1000:1010] = np.nan
    x = np.arange(3000.0)
    tx, ty = decimate(x, y, buckets)
    assert len(tx) <= 5 * buckets
    assert np.nanmax(ty) == np.nanmax(y)
    assert np.nanmin(ty) == np.nanmin(y)
    assert np.isnan(ty).any()
    assert (tx[0], tx[-1]) == (0.0, 2999.0)
    assert (np.diff(tx) > 0).all()


@pytest.mark.parametrize(
    "values", [[0.0], [3.0], [-2.0, 5.0], [1e-9, 2e-9], [1e6, 1e6], [np.nan, 1.0, np.nan], [0.0, 0.0]]
)
def test_every_value_lies_inside_the_axes(values):
    y = np.array(values)
    chart = Chart("c", "m", (Line("a", np.arange(len(y), dtype=float), y),))
    box = Axes.of(chart, chart.known())
    rows = box.row(y[np.isfinite(y)])
    assert ((rows >= box.top - 1e-6) & (rows <= box.top + box.height + 1e-6)).all()
    root = ElementTree.fromstring(chart.svg())
    for path in root.iter("{http://www.w3.org/2000/svg}path"):
        if "line" in path.get("class", "").split() and path.get("stroke-linecap"):
            drawn = points(path.get("d"))
            assert (drawn[:, 0] >= box.left - 0.1).all()
            assert (drawn[:, 0] <= box.left + box.width + 0.1).all()
            assert (drawn[:, 1] >= box.top - 0.1).all()
            assert (drawn[:, 1] <= box.top + box.height + 0.1).all()


def test_a_chart_names_its_unit_its_axis_and_its_lines():
    time = np.linspace(0, 3, 10)
    text = Chart("Speed", "m/s", (Line("asked", time, time), Line("true", time, 2 * time))).svg()
    assert all(part in text for part in ("Speed, m/s", "time, s", ">asked<", ">true<", "from 0 to 6 m/s"))


def test_a_chart_without_values_says_so():
    assert "not recorded" in Chart("Slip", "mm/s", (Line("", np.zeros(2), np.full(2, np.nan)),)).svg()


def test_the_same_metres_are_the_same_pixels_both_ways():
    view = View.fit((0.0, 0.0, 3.0, 5.0), 640, 560)
    assert view.x(1.0) - view.x(0.0) == pytest.approx(view.y(0.0) - view.y(1.0)) == pytest.approx(view.scale)
    wide, high = view.picture
    assert wide <= 640.001
    assert high <= 560.001


@pytest.mark.parametrize(
    ("value", "decimals", "text"), [(-0.001, 2, "0.00"), (-1.5, 1, "−1.5"), (np.nan, 2, "—"), (np.inf, 1, "∞")]
)
def test_numbers_are_written_for_reading(value, decimals, text):
    assert svg.number(value, decimals) == text


@pytest.mark.parametrize(
    "names", [("N", "M", "F"), ("FLC with goal blend", "FLC + PID", "FLC + MPC", "PID", "fuzzy-PD")]
)
def test_no_name_and_no_number_is_cut_off_at_the_edge(names):
    """Names that do not fit begin another row; the last number moves to the left."""
    x = np.array([0.0, 2500.0])
    chart = Chart("DH", "", tuple(Line(name, x, x, colour=i) for i, name in enumerate(names)), "DH", "mm", width=360.0)
    tree = ElementTree.fromstring(chart.svg())
    texts = [node for node in tree.iter() if node.tag.endswith("text") and (node.text in names or node.text == "2500")]
    assert len(texts) >= len(names) + 1
    for node in texts:
        half = node.get("text-anchor") == "middle"
        right = float(node.get("x")) + text_width(node.text) * (0.5 if half else 1.0)
        assert node.get("text-anchor") == "end" or right <= 360.0
    rows = {node.get("y") for node in texts if node.text in names}
    top = float(tree.get("data-y0"))
    assert max(float(y) for y in rows) < top
