"""How true a condition is: membership of one set, and its joining with others by AND or OR."""

import math

from holodrive.control.fuzzy import packing as pk
from holodrive.leaf import leaf


@leaf
def degree(spec, at, x):  # type: ignore[no-untyped-def]
    """Membership of x in the input set whose record begins at `at`."""
    kind, first = int(spec[at]), at + 2
    if kind == pk.TRAPEZOID:
        return _trapezoid(spec[first], spec[first + 1], spec[first + 2], spec[first + 3], x)
    if kind == pk.GAUSSIAN:
        z = (x - spec[first]) / spec[first + 1]
        return math.exp(-0.5 * z * z)
    if kind == pk.BELL:
        return 1.0 / (1.0 + abs((x - spec[first + 2]) / spec[first]) ** (2.0 * spec[first + 1]))
    if kind == pk.SINGLETON:
        return 1.0 if x == spec[first] else 0.0
    return _polyline(spec, first, int(spec[at + 1]) // 2, x)


@leaf
def _trapezoid(a, b, c, d, x):  # type: ignore[no-untyped-def]
    """Feet a and d, top from b to c; an upright side belongs to the set."""
    if x < a or x > d:
        return 0.0
    if x < b:
        return (x - a) / (b - a)
    return 1.0 if x <= c else (d - x) / (d - c)


@leaf
def _polyline(spec, first, n, x):  # type: ignore[no-untyped-def]
    """Straight between the points, level beyond; where it jumps, the greatest height counts."""
    last = first + 2 * (n - 1)
    if x < spec[first]:
        return spec[first + 1]
    if x > spec[last]:
        return spec[last + 1]
    mu = 0.0
    for k in range(n - 1):
        at = first + 2 * k
        u0, u1 = spec[at], spec[at + 2]
        if u0 < x < u1:
            return spec[at + 1] + (spec[at + 3] - spec[at + 1]) * ((x - u0) / (u1 - u0))
        if x == u0:
            mu = max(mu, spec[at + 1])
        if x == u1:
            mu = max(mu, spec[at + 3])
    return mu


@leaf
def joined(spec, is_or, so_far, mu):  # type: ignore[no-untyped-def]
    """`so_far` AND or OR `mu`; a negative `so_far` stands for nothing yet."""
    if so_far < 0.0:
        return mu
    if is_or == 0.0:
        how = int(spec[pk.AND])
        if how == pk.MIN:
            return min(so_far, mu)
        return so_far * mu if how == pk.PROD else max(0.0, so_far + mu - 1.0)
    how = int(spec[pk.OR])
    if how == pk.MAX:
        return max(so_far, mu)
    return so_far + mu - so_far * mu if how == pk.PROBOR else min(1.0, so_far + mu)
