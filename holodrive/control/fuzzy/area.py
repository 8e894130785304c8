"""Exact defuzzification of any piecewise-linear sets: between their break points all are straight lines.

In such a cell a cut set is a line with a lid and a scaled set a line. Where lines cross lids and, for the maximum,
lines cross lines and others' lids, the aggregate bends; between these places it is straight, so that its area, first
moment, half and highest places have closed forms.

`work` begins with a list of parts: how many, then the number of the set and its height for each.
"""

import math

from holodrive.control.fuzzy import packing as pk
from holodrive.leaf import leaf

LEVEL = 1.0 - 1e-12  # of the peak: what counts as the same height, rounding allowed


@leaf
def defuzzified(spec, at, work):  # type: ignore[no-untyped-def]
    """The output by the system's method; NaN when nothing has an area."""
    total, moment, peak = _integrated(spec, at, work)
    method = int(spec[pk.DEFUZZIFICATION])
    if not total > 0.0:
        return math.nan
    if method == pk.CENTROID:
        return moment / total
    if method == pk.BISECTOR:
        return _bisector(spec, at, work, 0.5 * total)
    return _of_maxima(spec, at, work, method, peak * LEVEL)


@leaf
def points_at(spec):  # type: ignore[no-untyped-def]
    """Place in `work` of a cell's points, after the parts and the lines of those that count in the cell."""
    return 1 + 5 * max(int(spec[pk.MOST_SETS]), int(spec[pk.N_RULES]))


@leaf
def cell_points(spec, at, cell, work):  # type: ignore[no-untyped-def]
    """Places and heights of the aggregate in a cell into `work`, alternating, from left to right; how many.

    None when the aggregate is 0 in the whole cell.
    """
    n_sets = int(spec[at + pk.N_SETS])
    row = at + pk.TABLE + cell * (2 + 2 * n_sets)
    n_lines, at_lines = _lines(spec, row, n_sets, work)
    if n_lines == 0:
        return 0
    first = points_at(spec)
    # shares of the cell's width to the left of each point, and to its right: near the right end the latter is the
    # one that keeps its digits, and with them the height of a set that is cut very low
    work[first], work[first + 1], work[first + 2], work[first + 3] = 0.0, 1.0, 1.0, 0.0
    count = 2
    sums = int(spec[pk.AGGREGATION]) == pk.SUM
    for i in range(n_lines):
        p = at_lines + 3 * i
        count = _cross(work, first, count, work[p] - work[p + 2], work[p + 1] - work[p + 2])
        for j in range(0 if not sums else n_lines, n_lines):
            o = at_lines + 3 * j
            if j < i:
                count = _cross(work, first, count, work[p] - work[o], work[p + 1] - work[o + 1])
            if j != i:
                count = _cross(work, first, count, work[p] - work[o + 2], work[p + 1] - work[o + 2])
    left, right = spec[row], spec[row + 1]
    for k in range(count):
        share, rest = work[first + 2 * k], work[first + 2 * k + 1]
        work[first + 2 * k] = right if share == 1.0 else left + share * (right - left)
        work[first + 2 * k + 1] = _height(work, at_lines, n_lines, share, rest, sums)
    return count


@leaf
def _lines(spec, row, n_sets, work):  # type: ignore[no-untyped-def]
    """Height at the left end, at the right end, and lid of each part that counts in the cell; how many, where.

    Parts that are 0 do not count; nor, for the maximum, those that stay below the lower end of another.
    """
    n_parts, scales, sums = int(work[0]), int(spec[pk.IMPLICATION]) == pk.PROD, int(spec[pk.AGGREGATION]) == pk.SUM
    first = 1 + 2 * n_parts
    n, floor = 0, 0.0
    for part in range(n_parts):
        number, height = int(work[1 + 2 * part]), work[2 + 2 * part]
        y0, y1 = spec[row + 2 + number], spec[row + 2 + n_sets + number]
        scale, lid = (height, math.inf) if scales else (1.0, height)
        if min(max(y0, y1) * scale, lid) > (0.0 if sums else floor):
            work[first + 3 * n], work[first + 3 * n + 1], work[first + 3 * n + 2] = scale * y0, scale * y1, lid
            n += 1
            floor = max(floor, min(scale * y0, scale * y1, lid))
    if sums or n < 2:
        return n, first
    kept = 0
    for i in range(n):  # those that came before the highest floor
        p, q = first + 3 * i, first + 3 * kept
        if min(max(work[p], work[p + 1]), work[p + 2]) >= floor:
            work[q], work[q + 1], work[q + 2] = work[p], work[p + 1], work[p + 2]
            kept += 1
    return kept, first


@leaf
def _cross(work, first, count, d0, d1):  # type: ignore[no-untyped-def]
    """Add the place where a difference that goes from d0 to d1 is 0, in order; gives the new count."""
    if not (d0 < 0.0 < d1 or d1 < 0.0 < d0):
        return count
    share, rest = d0 / (d0 - d1), d1 / (d1 - d0)
    k = count
    while work[first + 2 * k - 2] > share or (work[first + 2 * k - 2] == share and work[first + 2 * k - 1] < rest):
        work[first + 2 * k], work[first + 2 * k + 1] = work[first + 2 * k - 2], work[first + 2 * k - 1]
        k -= 1  # ends at the left end, which is 0 and 1
    work[first + 2 * k], work[first + 2 * k + 1] = share, rest
    return count + 1


@leaf
def _height(work, at_lines, n_lines, share, rest, sums):  # type: ignore[no-untyped-def]
    """Of the aggregate, with a share of the cell to the left and the rest to the right."""
    total = 0.0
    for i in range(n_lines):
        p = at_lines + 3 * i
        y = min(work[p] * rest + work[p + 1] * share, work[p + 2])
        total = total + y if sums else max(total, y)
    return total


@leaf
def _integrated(spec, at, work):  # type: ignore[no-untyped-def]
    """Area, first moment and greatest height."""
    first = points_at(spec)
    total, moment, peak = 0.0, 0.0, 0.0
    for cell in range(int(spec[at + pk.N_TABLE])):
        count = cell_points(spec, at, cell, work)
        for k in range(count - 1):
            p = first + 2 * k
            u, y0, y1, width = work[p], work[p + 1], work[p + 3], work[p + 2] - work[p]
            size = 0.5 * width * (y0 + y1)
            total += size
            moment += u * size + width * width * (y0 + 2.0 * y1) / 6.0
            peak = max(peak, y0, y1)
    return total, moment, peak


@leaf
def _bisector(spec, at, work, half):  # type: ignore[no-untyped-def]
    """Where the area to the left is half of all."""
    first = points_at(spec)
    done = 0.0
    u = math.nan
    for cell in range(int(spec[at + pk.N_TABLE])):
        count = cell_points(spec, at, cell, work)
        for k in range(count - 1):
            p = first + 2 * k
            u, y0, y1, width = work[p], work[p + 1], work[p + 3], work[p + 2] - work[p]
            size = 0.5 * width * (y0 + y1)
            if done + size >= half:
                # y0 s + (y1 - y0) s^2 / (2 width) = rest, solved without cancellation; in shares of the higher end,
                # since squares of very low heights vanish
                top = max(y0, y1)
                if top == 0.0:
                    return u
                rest, y0, slope = (half - done) / top, y0 / top, (y1 - y0) / top / width
                root = y0 + math.sqrt(max(y0 * y0 + 2.0 * slope * rest, 0.0))
                return u + (min(2.0 * rest / root, width) if root > 0.0 else 0.0)
            done += size
            u += width
    return u


@leaf
def _of_maxima(spec, at, work, method, level):  # type: ignore[no-untyped-def]
    """Mean, leftmost or rightmost of the places where the aggregate is highest.

    The mean is over the level tops; over single places when there is no level top.
    """
    first = points_at(spec)
    low, high, length, turn = math.inf, -math.inf, 0.0, 0.0
    count_single, sum_single = 0, 0.0
    for cell in range(int(spec[at + pk.N_TABLE])):
        count = cell_points(spec, at, cell, work)
        for k in range(count):
            u = work[first + 2 * k]
            if work[first + 2 * k + 1] >= level:
                if u != high:
                    count_single, sum_single = count_single + 1, sum_single + u
                low, high = min(low, u), max(high, u)
                if k + 1 < count and work[first + 2 * k + 3] >= level:
                    width = work[first + 2 * k + 2] - u
                    length, turn = length + width, turn + width * (u + 0.5 * width)
    if method == pk.SOM:
        return low
    if method == pk.LOM:
        return high
    return turn / length if length > 0.0 else sum_single / count_single
