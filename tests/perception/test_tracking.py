"""What moves is found with its velocity, also where it comes out from behind something; what stands is not."""

import math

import numpy as np
import pytest
from scans import scan_of

from holodrive import perception
from holodrive.perception import changes, tracking

SCAN_S = 1.0 / 5.5
ROOM = (-1.5, 1.5, -2.0, 2.0)


class Watcher:
    """Both kinds of tracks over a sequence of scans from a robot that stands at the origin."""

    def __init__(self):
        self.discs = np.zeros(tracking.TRACKS * tracking.ROW)
        self.edges = np.zeros(tracking.TRACKS * tracking.ROW)
        self.tables = np.zeros(changes.memory_size(360))
        self.scans = 0

    def see(self, circles, noise=0.01):
        points = perception.points(scan_of(circles, ROOM, noise=noise, seed=self.scans))
        xs, ys = (np.ascontiguousarray(points[:, k]) for k in range(2))
        ts, time = np.full(len(xs), self.scans * SCAN_S), self.scans * SCAN_S
        tracking.follow(xs, ys, ts, len(xs), 0.0, 0.0, self.discs)
        changes.find(xs, ys, ts, len(xs), 0.0, 0.0, self.scans, 360, self.tables, self.discs, self.edges)
        tracking.forget(time, tracking.LOST_MOVING_S, self.discs)
        tracking.forget(time, changes.LOST_S, self.edges)
        self.scans += 1

    def moving(self):
        rows = np.concatenate([self.discs, self.edges]).reshape(-1, tracking.ROW)
        return rows[(rows[:, tracking.SEEN] > 0) & (rows[:, tracking.MOVES] > 0)]


@pytest.mark.parametrize("velocity", [(0.3, 0.0), (-0.1, 0.0), (0.0, -0.2)])
def test_a_crosser_is_tracked_with_its_velocity(velocity):
    watcher = Watcher()
    for k in range(10):
        watcher.see([(0.9 + velocity[0] * (k - 5) * SCAN_S, 0.3 + velocity[1] * (k - 5) * SCAN_S, 0.15)])
    discs = [row for row in watcher.moving() if row[tracking.RADIUS] > 0.1]
    assert discs
    assert np.allclose(discs[0][[tracking.VX, tracking.VY]], velocity, atol=0.06)
    assert discs[0][tracking.RADIUS] == pytest.approx(0.15, abs=0.03)


def test_what_stands_does_not_move_in_spite_of_noise():
    watcher, false = Watcher(), 0
    for _ in range(60):
        watcher.see([(0.9, 0.3, 0.15), (-0.8, -0.9, 0.15), (0.2, -1.4, 0.15), (0.25, -1.25, 0.15)])
        false += len(watcher.moving())
    assert false <= 6  # of 240 chances


def test_one_that_turns_back_is_believed_within_two_scans():
    watcher = Watcher()
    places = [1.2 - 0.3 * k * SCAN_S for k in range(10)]
    for x in places + [places[-1] + 0.3 * k * SCAN_S for k in range(1, 4)]:
        watcher.see([(0.9, x, 0.15)])
    speeds = [row[tracking.VY] for row in watcher.moving() if row[tracking.RADIUS] > 0.1]
    assert speeds
    assert speeds[0] > 0.1


def test_one_that_comes_out_of_a_standing_one_is_seen_before_it_has_parted_from_it():
    """Its leading edge lies where an earlier beam went on; a disc of its own it is only 0.4 m later."""
    watcher, post = Watcher(), (1.0, 0.0, 0.15)
    for _ in range(8):
        watcher.see([post, post])
    for k in range(6):
        watcher.see([post, (1.0, 0.3 * k * SCAN_S, 0.15)])
    edges = watcher.moving()
    assert len(edges)
    assert edges[:, tracking.VY].max() == pytest.approx(0.3, abs=0.15)
    assert 0.3 * 5 * SCAN_S < 0.3  # they still touch


def test_an_ended_track_leaves_its_place():
    watcher = Watcher()
    for k in range(8):
        watcher.see([(0.9, 0.3 * k * SCAN_S, 0.15)])
    assert len(watcher.moving())
    for _ in range(math.ceil(tracking.LOST_MOVING_S / SCAN_S) + 2):
        watcher.see([])
    assert not len(watcher.moving())
