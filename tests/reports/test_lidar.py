"""A scan on a page: where its points are, what was fitted, and how far that is from what stands there."""

import math
from dataclasses import replace
from xml.etree import ElementTree

import numpy as np
import pytest

from holodrive.errors import InputError
from holodrive.geometry import compose
from holodrive.reports import report
from holodrive.reports.lidar import LidarSection, floor_svg, look, polar_svg
from holodrive.types import Pose, Scan
from holodrive.worlds.spec import Circle, World

POSE = Pose(1.5, 1.0, math.pi / 2)
PILLARS = (Circle(1.5, 2.0, 0.15, "pillar & co"), Circle(0.8, 1.9, 0.2, "left one"))


def exact_scan(world: World, pose: Pose, beams: int = 720) -> Scan:
    """Noise-free ranges to circles and walls from a pose."""
    angles = np.linspace(-np.pi, np.pi, beams, endpoint=False)
    heading = pose.theta + angles
    d = np.stack([np.cos(heading), np.sin(heading)], axis=-1)
    best = np.full(beams, np.inf)
    for circle in world.circles:
        o = np.array([circle.x - pose.x, circle.y - pose.y])
        along = d @ o
        inside = along**2 - o @ o + circle.radius**2
        hit = (inside > 0.0) & (along > 0.0)
        best = np.where(hit, np.minimum(best, along - np.sqrt(np.maximum(inside, 0.0))), best)
    return Scan(2.0, angles, best, np.zeros(beams), range_min=0.05, range_max=8.0)


@pytest.fixture(scope="module")
def standing(make):
    """A robot that stands before two pillars, and its one scan."""
    world = World("pillars", "two pillars", size=(3.0, 4.5), circles=PILLARS)
    run = make(seconds=4.0, scans=False)
    still = np.tile(POSE, (len(run.time), 1))
    zero = np.zeros_like(run.twist)
    return replace(run, world=world, pose=still, estimate=still, twist=zero, scans=(exact_scan(world, POSE),))


def test_fitted_circles_are_the_obstacles_that_stand_there(standing):
    """Without noise to the millimetre, and each by its name."""
    found = look(standing)
    assert {fit.truth.name for fit in found.fits} == {"pillar & co", "left one"}
    for fit in found.fits:
        assert fit.centre_error_m < 1e-3
        assert abs(fit.radius_error_m) < 1e-3


def test_points_lie_on_the_obstacles_when_placed_by_the_pose(standing):
    """Base to map and circle: the law that the floor picture stands on."""
    found = look(standing)
    place = compose(found.pose, np.column_stack([found.points, np.zeros(len(found.points))]))[:, :2]
    gap = np.min([np.abs(np.hypot(place[:, 0] - c.x, place[:, 1] - c.y) - c.radius) for c in PILLARS], axis=0)
    assert gap.max() < 0.02


def test_sectors_tell_the_nearest_return(standing):
    """Ahead the pillar's edge; to the left the other one's; nothing to the right."""
    dh, dl, dr = look(standing).sectors
    assert dh == pytest.approx(0.85, abs=1e-3)
    assert dl == pytest.approx(math.hypot(0.7, 0.9) - 0.2, abs=2e-3)
    assert dr == 3.0


def test_the_page_names_obstacles_and_errors(standing, parse):
    """Escaped, with both pictures."""
    page = parse(report(LidarSection(standing)).html)
    for part in ("pillar & co", "centre error, mm", "DL 0.94 m", "ahead is up", "fitted circle"):
        assert part in page.text


def test_pictures_are_well_formed(standing):
    """On their own, too."""
    found = look(standing)
    ElementTree.fromstring(polar_svg(found))
    ElementTree.fromstring(floor_svg(standing, found))


def test_the_scan_of_a_time_is_the_nearest_one(run):
    """Without a time, the one with the nearest return."""
    assert look(run, 7.02).scan.stamp == pytest.approx(7.0, abs=0.51)
    nearest = min(run.scans, key=lambda scan: np.nanmin(scan.ranges))
    assert look(run).scan is nearest


def test_an_unknown_pose_leaves_the_polar_picture(standing, parse):
    """A floor without a robot's place says nothing."""
    nothing = np.full_like(standing.pose, np.nan)
    lost = replace(standing, pose=nothing, estimate=nothing)
    page = parse(report(LidarSection(lost)).html)
    assert "ahead is up" in page.text
    assert "fitted circle" not in page.text


def test_invalid_and_empty_scans_are_drawn(standing):
    """All NaN, all without return, three beams."""
    scan = standing.scans[0]
    for ranges in (np.full(720, np.nan), np.full(720, np.inf)):
        html = LidarSection(replace(standing, scans=(replace(scan, ranges=ranges),))).html()
        assert "ahead is up" in html
    short = replace(scan, angles=scan.angles[::240], ranges=np.ones(3), offsets=np.zeros(3))
    assert "ahead is up" in LidarSection(replace(standing, scans=(short,))).html()


def test_a_run_without_scans_says_so(make):
    """In the page a line, from `look` an error."""
    blind = make(seconds=2.0, scans=False)
    assert "No scan was recorded" in LidarSection(blind).html()
    with pytest.raises(InputError, match="no scans"):
        look(blind)


def test_pages_of_runs_with_scans_have_the_scan(run, parse):
    """Where a reader of the run finds it."""
    assert "ahead is up" in parse(report(run).html).text


def test_the_floor_holds_what_a_robot_saw_that_has_not_moved(standing):
    """A short run in a large world is drawn alone, but with what it saw."""
    still = np.tile(np.array(POSE), (len(standing.time), 1))
    world = replace(standing.world, size=(12.0, 9.0))
    run = replace(standing, pose=still, estimate=still, reference=still, world=world)
    tree = ElementTree.fromstring(floor_svg(run, look(run)))
    fitted = [c for c in tree.iter() if c.tag.endswith("circle") and c.get("class") == "truth"]
    assert len(fitted) >= len(PILLARS)
    left, top, wide, high = (float(v) for v in tree.get("viewBox").split())
    for x, y, r in (tuple(float(c.get(key)) for key in ("cx", "cy", "r")) for c in fitted):
        assert r > wide or (left + r <= x <= left + wide - r and top + r <= y <= top + high - r)
