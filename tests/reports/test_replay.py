"""The replay: what is packed comes back, and the page's script runs in a browser."""

import base64
import json
import re
import shutil
import subprocess

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from holodrive.geometry import compose
from holodrive.log.drawing import bounds_of
from holodrive.log.view import View
from holodrive.reports import report
from holodrive.reports.replay import frames, pack, pose_at, scan_hits
from holodrive.reports.scene import HEIGHT, WIDTH
from holodrive.types import Pose, Scan

CHROMIUM = shutil.which("chromium") or shutil.which("chromium-browser") or shutil.which("google-chrome")
needs_browser = pytest.mark.skipif(CHROMIUM is None, reason="no chromium on this machine: the page's script is not run")


def unpack(packed):
    numbers = np.frombuffer(base64.b64decode(packed["data"]), "<u2").reshape(-1, packed["k"]).astype(float)
    numbers[numbers == 65535] = np.nan
    return np.array(packed["low"]) + np.array(packed["step"]) * numbers


@given(st.integers(0, 2**32 - 1), st.integers(1, 40), st.integers(1, 5))
def test_packed_arrays_come_back_within_a_step(seed, n, k):
    rng = np.random.default_rng(seed)
    values = rng.normal(scale=10.0 ** rng.integers(-4, 5), size=(n, k))
    values[rng.random((n, k)) < 0.2] = np.nan
    packed = pack(values)
    back = unpack(packed)
    np.testing.assert_array_equal(np.isnan(back), np.isnan(values))
    assert np.nanmax(np.abs(back - values) / np.array(packed["step"]), initial=0.0) <= 0.5 + 1e-3


def test_frames_are_as_many_as_a_screen_shows_with_both_ends():
    time = np.arange(1, 3001) * 0.01
    index = frames(time)
    assert (index[0], index[-1]) == (0, 2999)
    assert len(index) <= 900
    assert np.diff(time[index]).max() < 0.06
    assert len(frames(np.arange(360_000) * 0.01)) <= 900


def test_beams_end_on_the_wall_that_they_saw_while_the_robot_moved():
    """Each beam is placed by the pose at its own time: a wall stays straight though the robot turns."""
    time = np.linspace(0.0, 1.0, 101)
    pose = np.column_stack([0.5 * time, 0.2 * time, 2.0 * time])
    angles, offsets, mount = np.linspace(-0.5, 0.5, 50), np.linspace(-0.1, 0.0, 50), Pose(0.1, 0.0, 0.0)
    at = compose(pose_at(0.8 + offsets, time, pose), mount)
    ranges = (5.0 - at[:, 0]) / np.cos(at[:, 2] + angles)
    ranges = np.where(np.cos(at[:, 2] + angles) > 0.1, ranges, np.inf)
    hits = scan_hits(Scan(0.8, angles, ranges, offsets, mount), time, pose, 50)
    np.testing.assert_allclose(hits[np.isfinite(ranges), 0], 5.0, atol=1e-9)
    assert np.isnan(hits[~np.isfinite(ranges)]).all()


def browse(path, folder):
    """The page as a browser leaves it, and what the browser complained about."""
    command = [
        CHROMIUM, "--headless", "--no-sandbox", "--disable-gpu", "--enable-logging=stderr",
        "--virtual-time-budget=3000",
        f"--user-data-dir={folder / 'profile'}", "--dump-dom", f"file://{path}",
    ]  # fmt: skip
    done = subprocess.run(command, capture_output=True, text=True, timeout=120, check=True)
    return done.stdout, [line for line in done.stderr.splitlines() if "CONSOLE" in line]


@needs_browser
def test_the_script_runs_under_the_pages_own_policy(run, runs, tmp_path):
    page = report([run, *runs]).save(tmp_path / "run.html")
    dom, complaints = browse(page, tmp_path)
    assert complaints == []
    assert 'data-replay="ready" data-players="5"' in dom
    assert re.search(r'class="clock">12\.0\d / 30\.00 s<', dom)


@needs_browser
def test_seeking_moves_the_robot_to_where_it_was(run, tmp_path):
    """A probe is added to the page, for which its policy is taken out."""
    probe = "<script>holodrive.players[0].seek(20); document.title = 'probed'</script></body>"
    html = re.sub(r'<meta http-equiv="Content-Security-Policy"[^>]*>', "", report(run).html).replace("</body>", probe)
    path = tmp_path / "run.html"
    path.write_text(html)
    dom, complaints = browse(path, tmp_path)
    assert complaints == []
    assert "20.00 / 30.00 s" in dom
    place = re.search(r'class="live-robot r0" transform="translate\(([-\d.]+) ([-\d.]+)\)', dom)
    view = View.fit(bounds_of([run]), WIDTH, HEIGHT, header=26.0)
    expected = view.pixels(run.pose[np.searchsorted(run.time, 20.0)])
    np.testing.assert_allclose([float(v) for v in place.groups()], expected, atol=0.6)


def test_tracks_hold_what_the_close_up_shows(run):
    text = re.search(r'<script type="application/json">(.*?)</script>', report(run).html, re.S).group(1)
    track = json.loads(text)["tracks"][0]
    speeds = unpack(track["speeds"])
    np.testing.assert_allclose(speeds, run.wheel_speeds[frames(run.time)], atol=1e-3)
    assert [wheel["steered"] for wheel in track["wheels"]] == [False, False, False]
