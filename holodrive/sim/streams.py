"""Counter-based random numbers: a pure function of (seed, robot, stream, step, index), no state anywhere.

The finaliser of splitmix64 (Steele, Lea, Flood 2014) mixes each part before the next one enters, so that no two
different tuples are neighbours of one another, and results cannot depend on threads, chunks or order.
"""

import math

import numpy as np

from holodrive.leaf import leaf

# streams: which sensor or actuator draws
LIDAR, GYRO, GYRO_WALK, ACCEL, MICE, DROPOUT, SPEED_SPREAD, SPEED_NOISE, DEAD_TIME = range(9)

_A = np.uint64(0xBF58476D1CE4E5B9)
_B = np.uint64(0x94D049BB133111EB)
_GOLDEN = np.uint64(0x9E3779B97F4A7C15)
_S30, _S27, _S31 = np.uint64(30), np.uint64(27), np.uint64(31)
_S16, _S32, _S48, _S11 = np.uint64(16), np.uint64(32), np.uint64(48), np.uint64(11)
_LOW = np.uint64(0xFFFF)

# Four uniforms of 16 bit: mean of the sum and 1 / its standard deviation, sqrt(4 (2^32 - 1) / 12).
_MEAN = 2.0 * 65535.0
_SCALE = math.sqrt(3.0 / (2.0**32 - 1.0))
# Their sum has a kurtosis of 2.7; z + c (z^3 - 3 z) with this c has 3 exactly (the sum's next
# moments are 153/14, 55.8 ...) and the variance 1 / _UNIT^2.
_TAIL = 0.018549499722796705
_UNIT = 1.0049600395825111


@leaf
def mix(z):  # type: ignore[no-untyped-def]
    """Finaliser of splitmix64: uint64 -> uint64, one to one."""
    z = (z ^ (z >> _S30)) * _A
    z = (z ^ (z >> _S27)) * _B
    return z ^ (z >> _S31)


@leaf
def key_of(seed, robot):  # type: ignore[no-untyped-def]
    """Key of one robot of one run."""
    return mix(mix(np.uint64(seed) + _GOLDEN) ^ mix(np.uint64(robot) * _A + _GOLDEN))


@leaf
def draw(key, stream, step):  # type: ignore[no-untyped-def]
    """64 random bits of a stream's step; a key itself for numbers within the step (`draw_index`)."""
    return mix(mix(key ^ mix(np.uint64(stream) * _B + _GOLDEN)) ^ mix(np.uint64(step) + _GOLDEN))


@leaf
def draw_index(bits, index):  # type: ignore[no-untyped-def]
    """64 random bits of an index (uint64) within a step. The odd factor spreads indices over all 64 bits."""
    return mix(bits ^ (index * _A + _GOLDEN))


@leaf
def gauss(bits):  # type: ignore[no-untyped-def]
    """Standard normal number of 64 random bits: mean 0, variance 1, kurtosis 3, at most 4.1 away from 0."""
    total = np.float64(np.int64((bits & _LOW) + ((bits >> _S16) & _LOW) + ((bits >> _S32) & _LOW) + (bits >> _S48)))
    z = (total - _MEAN) * _SCALE
    return _UNIT * z * (1.0 + _TAIL * (z * z - 3.0))


@leaf
def uniform(bits):  # type: ignore[no-untyped-def]
    """Even number in [0, 1) of 64 random bits."""
    return np.float64(np.int64(bits >> _S11)) * (1.0 / 9007199254740992.0)
