"""Pictures and films: sizes, lengths, and clear refusals."""

from dataclasses import replace
from xml.etree import ElementTree

import numpy as np
import pytest
from PIL import Image

from holodrive.errors import InputError
from holodrive.reports import render
from holodrive.reports.film import Pace


def test_a_png_decodes_at_the_asked_size_and_is_not_blank(short_run, tmp_path):
    with Image.open(render(short_run, tmp_path / "run.png", size=500)) as image:
        assert max(image.size) == 500
        assert len(image.convert("RGB").getcolors(maxcolors=1 << 20)) > 50


def test_a_gif_has_a_frame_each_tenth_of_a_second_and_rests_at_the_end(short_run, tmp_path):
    shares = []
    with Image.open(render(short_run, tmp_path / "run.gif", size=300, progress=shares.append)) as film:
        assert max(film.size) == 300
        assert film.n_frames == 21
        assert film.info["duration"] == 100
        film.seek(20)
        assert film.info["duration"] == 2000
        assert film.info.get("loop", 0) == 0
    assert shares[-1] == 1.0
    assert shares == sorted(shares)


def test_a_film_of_half_a_minute_is_small(run, tmp_path):
    assert render(run, tmp_path / "run.gif").stat().st_size < 1_500_000


def test_a_long_film_runs_faster_instead_of_growing(make):
    pace = Pace.of(make(seconds=600.0, scans=False))
    assert pace.speed == 20.0
    assert len(pace.times) <= 301
    assert pace.times[-1] == pytest.approx(600.0)


def test_speed_and_rate_are_the_users(short_run):
    pace = Pace.of(short_run, fps=25.0, speed=2.0)
    assert pace.frame_s == 0.04
    assert len(pace.times) == 26


def test_an_svg_is_xml_and_an_animated_one_moves_the_robot(short_run, tmp_path):
    still = ElementTree.parse(render(short_run, tmp_path / "run.svg"))
    moving = ElementTree.parse(render(short_run, tmp_path / "film.svg", animate=True))
    name = "{http://www.w3.org/2000/svg}animateTransform"
    assert not list(still.iter(name))
    for animation in moving.iter(name):
        times = [float(t) for t in animation.get("keyTimes").split(";")]
        assert (times[0], times[-1]) == (0.0, 1.0)
        assert len(times) == len(animation.get("values").split(";"))
    assert len(list(moving.iter(name))) == 3  # the cart, and the robot's place and heading


def test_html_is_the_report(short_run, tmp_path):
    assert render(short_run, tmp_path / "run.html").read_text().startswith("<!doctype html>")


@pytest.mark.parametrize(
    ("name", "said"),
    [
        ("run.gfi", r"Did you mean '\.gif'"),
        ("run.mp3", r"\.gif, \.html, \.png, \.svg"),
        ("run", "no ending"),
        ("run.csv", "export"),
    ],
)
def test_an_unknown_ending_is_refused_with_the_known_ones(run, tmp_path, name, said):
    with pytest.raises(InputError, match=said):
        render(run, tmp_path / name)


@pytest.mark.parametrize("options", [{"size": 5}, {"fps": 0.0}, {"fps": 200.0}, {"speed": 0.0}])
def test_sizes_and_rates_that_cannot_be_are_refused(run, tmp_path, options):
    with pytest.raises(InputError, match="choose"):
        render(run, tmp_path / "run.gif", **options)


def test_a_folder_that_is_not_there_is_told(run, tmp_path):
    with pytest.raises(InputError, match="cannot be written"):
        render(run, tmp_path / "nowhere" / "run.png")


@pytest.mark.parametrize("name", ["a.gif", "a.png", "a.svg", "a.html"])
def test_a_run_of_one_tick_with_nothing_known_is_drawn(blank_run, tmp_path, name):
    assert render(blank_run, tmp_path / name).stat().st_size > 100


def test_a_run_without_ticks_is_refused(blank_run, tmp_path):
    empty = replace(blank_run, time=np.zeros(0))
    with pytest.raises(InputError, match="no ticks"):
        render(empty, tmp_path / "a.png")


@pytest.mark.parametrize("name", ["mecanum4", "swerve3"])
def test_every_kind_of_base_is_drawn(name, make, bodies, tmp_path):
    run = make(bodies[name](), seconds=1.0)
    assert render(run, tmp_path / "a.png").stat().st_size > 1000
    assert render(run, tmp_path / "a.svg").stat().st_size > 1000
