"""Centroid in closed form of cut or scaled triangles and trapezoids of which only neighbours overlap."""

import math

from holodrive.control.fuzzy import packing as pk
from holodrive.leaf import leaf


@leaf
def centroid(spec, at, heights):  # type: ignore[no-untyped-def]
    """Centroid of the union: each set's area and first moment, less those of what neighbours share.

    Two neighbours share a cut triangle between the right one's left foot and the left one's right foot, whose top is
    where their sides cross or, when that is lower, the lower of the two heights. NaN when nothing has an area.
    """
    n = int(spec[at + pk.N_SETS])
    first = at + pk.TABLE + int(spec[at + pk.N_TABLE]) * (2 + 2 * n)
    scales = int(spec[pk.IMPLICATION]) == pk.PROD
    area, moment = 0.0, 0.0
    before, c0, d0 = 0.0, 0.0, 0.0  # height and falling side of the set on the left
    for k in range(n):
        row = first + 5 * k
        h = heights[int(spec[row])]
        if h > 0.0:
            a, b, c, d = spec[row + 1], spec[row + 2], spec[row + 3], spec[row + 4]
            if scales:
                p, q = b, c
            else:
                p, q = a + h * (b - a), d - h * (d - c)
            size, turn = _trapezoid(a, p, q, d, h)
            area, moment = area + size, moment + turn
            if before > 0.0 and d0 > a:
                # widths of the two sides per unit of height
                rise, fall = (b - a) / h if scales else b - a, (d0 - c0) / before if scales else d0 - c0
                top = min(before, h, (d0 - a) / (rise + fall))
                size, turn = _trapezoid(a, a + top * rise, d0 - top * fall, d0, top)
                area, moment = area - size, moment - turn
            c0, d0 = c, d
        before = h
    return moment / area if area > 0.0 else math.nan


@leaf
def _trapezoid(a, p, q, d, h):  # type: ignore[no-untyped-def]
    """Area and first moment of feet a and d, top from p to q at height h."""
    left, top, right = 0.5 * (p - a), q - p, 0.5 * (d - q)
    moment = left * (a + 2.0 * p) / 3.0 + 0.5 * top * (p + q) + right * (2.0 * q + d) / 3.0
    return h * (left + top + right), h * moment
