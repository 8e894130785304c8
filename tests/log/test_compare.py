"""Claims about comparing two runs."""

import math
from dataclasses import replace

import numpy as np
import pytest
from logged import scan, ticks

from holodrive import log
from holodrive.log import Run, RunBuilder
from holodrive.robots.spec import Robot
from holodrive.types import Event, Pose


@pytest.fixture
def run(hybrid3: Robot) -> Run:
    builder = RunBuilder(hybrid3, None, {})
    for each in ticks(hybrid3, 20):
        builder.tick(each)
    builder.scan(scan(0.1, 8, Pose(0, 0, 0)))
    builder.event(Event(0.1, "arrived", "there", Pose(0, 0, 0)))
    return builder.build()


def test_a_run_equals_itself_with_its_nans(run: Run) -> None:
    blind = replace(run, pose=np.full_like(run.pose, np.nan))
    assert log.compare(run, run) == log.compare(blind, blind) == ()


def test_the_last_bit_of_one_number_is_found(run: Run) -> None:
    other = run.estimate.copy()
    other[7, 1] = np.nextafter(other[7, 1], np.inf)
    (difference,) = log.compare(run, replace(run, estimate=other))
    assert (difference.channel, difference.count, difference.first_time) == ("estimate", 1, run.time[7])
    assert 0.0 < difference.max_abs < 1e-14


def test_a_nan_on_one_side_is_an_infinite_difference(run: Run) -> None:
    other = run.slip.copy()
    other[3] = np.nan
    (difference,) = log.compare(run, replace(run, slip=other))
    assert math.isinf(difference.max_abs)


def test_missing_ticks_have_no_partner(run: Run) -> None:
    names = ("time", "pose", "slip")
    shorter = replace(run, **{name: getattr(run, name)[:15] for name in names})
    found = {difference.channel: difference for difference in log.compare(run, shorter)}
    assert {name: found[name].count for name in names} == dict.fromkeys(names, 5)
    assert found["slip"].first_time == run.time[15]
    assert "5 ticks have no partner" in found["slip"].text


def test_robots_with_other_wheels_differ_without_a_traceback(run: Run) -> None:
    other = replace(run, wheel_speeds=np.zeros((20, 4)))
    (difference,) = log.compare(run, other)
    assert "(3,) numbers a tick against (4,)" in difference.text


def test_scans_and_events_are_compared(run: Run) -> None:
    moved = replace(run.scans[0], ranges=run.scans[0].ranges + 0.5)
    found = log.compare(run, replace(run, scans=(moved,), events=()))
    assert [(each.channel, each.count) for each in found] == [("scans", 1), ("events", 1)]
    assert found[0].max_abs == pytest.approx(0.5, rel=1e-6)
    assert log.compare(run, replace(run, scans=()))[0].text.startswith("scans: 0 of 0 differ")
