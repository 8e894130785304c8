"""The report page: one file, nothing fetched, nothing injected, nothing missing."""

import base64
import hashlib
import json
import re
from dataclasses import replace

import numpy as np
import pytest

from holodrive.errors import InputError
from holodrive.log.words import METRICS, with_unit, words
from holodrive.reports import (
    ComparisonSection,
    RecordingSection,
    TableSection,
    TextSection,
    report,
    table,
)
from holodrive.worlds.spec import Circle, World


@pytest.fixture(scope="module")
def html(run):
    return report(run).html


@pytest.fixture(scope="module")
def page(html, parse):
    return parse(html)


def test_nothing_is_fetched(html, page):
    """No element names another file, and the page's own policy forbids every fetch."""
    for tag, attributes in page.elements:
        assert not {"src", "href", "action", "data", "poster"} & {
            k for k, v in attributes.items() if v and not v.startswith("#")
        }, tag
    assert not re.search(r"url\(|@import", html)
    assert set(re.findall(r"https?://[^\"'<> ]+", html)) <= {"http://www.w3.org/2000/svg"}
    policy = next(meta["content"] for meta in page.all("meta") if "http-equiv" in meta)
    assert policy.startswith("default-src 'none'")


def test_the_policy_allows_exactly_the_style_and_script_of_the_page(html, page):
    policy = next(meta["content"] for meta in page.all("meta") if "http-equiv" in meta)
    for tag in ("style", "script"):
        content = re.search(rf"<{tag}>(.*?)</{tag}>", html, re.S).group(1)
        assert "sha256-" + base64.b64encode(hashlib.sha256(content.encode()).digest()).decode() in policy
    assert not any("style" in attributes or "onclick" in attributes for _, attributes in page.elements)


def test_the_page_names_what_ran_and_every_metric(run, page):
    for part in ("hybrid3", "course", "go_to_pose", "7f3a90", "slip", *(wheel.name for wheel in run.robot.wheels)):
        assert part in page.text
    for name, value in run.metrics.items():
        assert words(name).label in page.text, name
        assert with_unit(name, value).split("\u00a0")[0].rstrip("°") in page.text, name
    assert "touched obstacle 2" in page.text


def test_every_picture_says_what_it_shows(page):
    pictures = [a for a in page.all("svg") if a.get("role") == "img"]
    assert len(pictures) > 10
    assert all(a["aria-label"] for a in pictures)


def test_how_to_repeat_is_shown(run, parse):
    text = parse(report(replace(run, settings={**run.settings, "command": "holodrive run hybrid3 --seed 1"})).html).text
    assert "Repeat with holodrive run hybrid3 --seed 1" in text


def test_names_cannot_inject_markup(run, parse):
    evil = '<script>alert("x")</script><img src=x onerror=y>'
    robot = replace(
        run.robot,
        name=evil,
        title=evil,
        text=evil,
        wheels=(replace(run.robot.wheels[0], name=evil), *run.robot.wheels[1:]),
    )
    world = World(evil, evil, circles=(Circle(1, 1, 0.2, evil),), text=evil)
    events = (replace(run.events[0], text=evil, kind=evil),)
    bad = replace(run, robot=robot, world=world, events=events, settings={evil: evil, "controller": evil})
    content = report([bad, bad], title=evil, lead=evil).html
    assert "<script>alert" not in content
    assert "<img" not in content
    assert len(parse(content).all("script")) == 4  # three players' data and the page's own


def test_an_ordinary_run_weighs_far_below_a_megabyte(html):
    assert len(html.encode()) < 400_000


def test_a_run_of_an_hour_weighs_hardly_more(make):
    assert len(report(make(seconds=3600.0, scans=False)).html.encode()) < 900_000


def test_a_run_of_one_tick_with_nothing_known_is_a_page(blank_run, parse):
    text = parse(report(blank_run).html).text
    assert "NaN" not in text
    assert "nan" not in text.split()
    assert "—" in text


def test_a_run_full_of_gaps_is_a_page(run, parse):
    rng = np.random.default_rng(0)

    def holes(array):
        return np.where(rng.random(array.shape) < 0.3, np.nan, array)

    fields = ("pose", "estimate", "reference", "twist", "decided", "wheel_commands", "wheel_speeds", "duty", "slip")
    broken = replace(run, **{name: holes(getattr(run, name)) for name in fields})
    content = report(broken).html
    parse(content)
    assert not re.search(r'="[^"]*\bnan\b', content)


@pytest.mark.parametrize("name", ["hybrid3", "mecanum4", "swerve3"])
def test_every_kind_of_base_has_its_charts(name, make, bodies, parse):
    robot = bodies[name]()
    page = parse(report(make(robot, seconds=2.0)).html)
    charts = [a for a in page.all("svg") if a.get("class") == "chart"]
    expected = 2 + 3 + len(robot.wheels) + len(robot.steered) + 2
    assert len(charts) == expected


def test_several_runs_are_compared_first_then_shown_one_by_one(runs, parse):
    page = parse(report(runs).html)
    labels = [a["aria-label"] for a in page.all("section")]
    assert labels[0] == "Comparison"
    assert [label.split(" ")[0] for label in labels[1:]] == ["go_to_pose", "pid", "fuzzy"]
    assert "▲" in page.text


def test_runs_in_different_worlds_stand_side_by_side(runs, parse):
    elsewhere = replace(runs[1], world=World("open"))
    page = parse(ComparisonSection((runs[0], elsewhere)).html())
    assert len([a for a in page.all("svg") if a.get("class") == "scene"]) == 2
    assert not [a for a in page.all("div") if a.get("class") == "replay"]


def test_recordings_tables_and_words_are_sections_too(parse):
    time = np.linspace(0.0, 10.0, 200)
    truth = np.column_stack([np.cos(time), np.sin(time), time])
    section = RecordingSection("recorded", time, truth + 0.1, truth, {"end_error_m": 0.1748}, "note", {"robot": "real"})
    page = parse(
        report(
            [
                TableSection("sum", table([{"robot": "a", "time_s": 1.0}])),
                section,
                TextSection("Next", "Try.", (("holodrive list", "lists"),)),
            ],
            title="demo",
        ).html
    )
    assert "174.8 mm" in page.text
    assert "holodrive list" in page.text
    assert [a["href"] for a in page.all("a")] == ["#s0", "#s1", "#s2"]


def test_the_data_of_the_replay_is_json_without_nan(html, page):
    data = [json.loads(text) for attributes, text in page.scripts if attributes.get("type") == "application/json"]
    assert len(data) == 1
    assert data[0]["tracks"][0]["scans"]["beams"] == 120


def test_a_report_without_content_is_refused():
    with pytest.raises(InputError, match="at least one run"):
        report([])


def test_saving_where_there_is_no_folder_is_told(run, tmp_path):
    with pytest.raises(InputError, match="cannot be written"):
        report(run).save(tmp_path / "nowhere" / "run.html")


def test_notebooks_get_the_page_in_a_frame(run, parse):
    frame = report(run)._repr_html_()
    assert parse(frame).all("iframe")[0]["srcdoc"].startswith("<!doctype html>")


def test_every_known_metric_has_words():
    assert all(how.label and how.help for how in METRICS.values())


@pytest.mark.parametrize(("count", "side"), [(2, "side wide"), (5, "side wide below")])
def test_a_wide_table_of_metrics_stands_below_the_map(count, side, make):
    """Beside it, five runs' columns leave the map no room."""
    runs = [make(seed=seed, seconds=1.0, scans=False) for seed in range(count)]
    assert f'<div class="{side}">' in report(runs).html


@pytest.mark.parametrize("thing", [3, "run.mcap", [3], object()])
def test_what_is_neither_run_nor_section_is_refused_by_name(thing):
    with pytest.raises(InputError, match=r"shows runs and sections; found"):
        report(thing)
