"""Runs of any length: bounded memory, the same metrics."""

import numpy as np
import pytest

import holodrive as hd
from holodrive import planning


def drive(keep_s=None, log=None):
    base = hd.simulate("hybrid3", "crossing", seed=2)
    path = planning.follow(planning.lemniscate(0.4, (1.5, 2.0)), 0.08)
    return hd.drive(base, trajectory=path, keep_s=keep_s, duration_s=30.0, log=log, stop_on_arrival=False)


@pytest.fixture(scope="module")
def whole():
    return drive()


def test_a_run_that_forgets_its_beginning_has_the_same_metrics(whole):
    short = drive(keep_s=2.0)
    assert 200 <= len(short.time) <= 400
    assert short.time[-1] == whole.time[-1]
    assert set(short.metrics) == set(whole.metrics)
    for name, value in whole.metrics.items():
        assert short.metrics[name] == pytest.approx(value, rel=1e-12, nan_ok=True), name


def test_what_stays_is_the_end_with_its_scans_and_events(whole):
    short = drive(keep_s=2.0)
    np.testing.assert_array_equal(short.pose, whole.pose[-len(short.time) :])
    assert min(scan.stamp for scan in short.scans) >= short.time[0]
    assert len(short.scans) < len(whole.scans)


def test_the_log_has_all_of_a_run_that_memory_forgot(whole, tmp_path):
    drive(keep_s=1.0, log=tmp_path / "run.mcap")
    np.testing.assert_array_equal(hd.read(tmp_path / "run.mcap").pose, whole.pose)
