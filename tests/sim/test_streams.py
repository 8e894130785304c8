"""Counter-based streams: as random as they must be, and pure functions of their counters."""

import numpy as np
from numba import njit

from holodrive.sim.streams import draw, draw_index, gauss, key_of, uniform


@njit
def table(seed, robots, steps, indices):
    """Bits (robots, steps, indices) of one stream."""
    out = np.empty((robots, steps, indices), dtype=np.uint64)
    for r in range(robots):
        key = key_of(seed, r)
        for s in range(steps):
            bits = draw(key, 0, s)
            for i in range(indices):
                out[r, s, i] = draw_index(bits, np.uint64(i))
    return out


def numbers(bits, function):
    return np.array([function(b) for b in bits.ravel()]).reshape(bits.shape)


def test_no_two_counters_share_their_bits():
    bits = table(7, 20, 100, 100)
    assert len(np.unique(bits)) == bits.size


def test_gauss_has_the_moments_of_a_normal_number():
    z = numbers(table(1, 5, 200, 200), gauss)
    assert abs(z.mean()) < 4.0 / np.sqrt(z.size)
    assert abs(z.var() - 1.0) < 4.0 * np.sqrt(2.0 / z.size)
    assert abs((z**3).mean()) < 4.0 * np.sqrt(15.0 / z.size)
    assert abs((z**4).mean() - 3.0) < 0.06
    assert 3.5 < np.abs(z).max() < 4.1


def test_gauss_has_the_share_of_a_normal_number_at_each_distance():
    z = np.abs(numbers(table(2, 5, 200, 200), gauss))
    for distance, share in ((0.6745, 0.5), (1.0, 0.31731), (2.0, 0.0455), (3.0, 0.0027)):
        assert abs((z > distance).mean() - share) < 0.006


def test_uniform_is_even():
    counts, _ = np.histogram(numbers(table(3, 5, 200, 200), uniform), bins=64, range=(0.0, 1.0))
    expected = counts.sum() / 64
    assert ((counts - expected) ** 2 / expected).sum() < 63 + 5 * np.sqrt(2 * 63)


def test_neighbours_in_every_counter_do_not_know_of_each_other():
    z = numbers(table(4, 60, 60, 60), gauss)
    for axis in range(3):
        a, b = np.split(z, [1], axis=axis)[1], np.split(z, [z.shape[axis] - 1], axis=axis)[0]
        assert abs((a * b).mean()) < 4.5 / np.sqrt(a.size)


def test_seeds_and_robots_are_not_interchangeable():
    keys = {int(key_of(seed, robot)) for seed in range(100) for robot in range(100)}
    assert len(keys) == 10_000
