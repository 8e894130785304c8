"""Weighted least squares for the motion of a body inside kernels: rows of wheels, mice and gyro add up one by one.

`clear`, `take` each row, `solve`; then `back` tells how an error of a row moves the solution. It is what
`kinematics.least_squares` does, by the normal equations of three unknowns. The angle counts times a length [m], else
metres and radians would set the condition.
"""

from holodrive.leaf import leaf

SIZE = 15  # 6 of H'WH (upper triangle, row by row), 3 of H'Wz, then 6 of the inverse
_INVERSE = 9
_LOST = 1e-9  # a pivot this small beside its diagonal: the rows do not tell this motion


@leaf
def clear(normal):  # type: ignore[no-untyped-def]
    """Begin: no rows."""
    for i in range(9):
        normal[i] = 0.0


@leaf
def take(normal, rows, at, length, z, weight):  # type: ignore[no-untyped-def]
    """Add the row rows[at : at + 3] . xi = z."""
    a, b, c = rows[at], rows[at + 1], rows[at + 2] / length
    normal[0] += weight * a * a
    normal[1] += weight * a * b
    normal[2] += weight * a * c
    normal[3] += weight * b * b
    normal[4] += weight * b * c
    normal[5] += weight * c * c
    normal[6] += weight * a * z
    normal[7] += weight * b * z
    normal[8] += weight * c * z


@leaf
def solve(normal, length, out):  # type: ignore[no-untyped-def]
    """The motion (3,) with the least weighted squares into `out`; keeps the inverse of the normal matrix.

    Returns:
        Whether the rows tell all three motions; if not, `out` is as it was.
    """
    # L D L' of the scaled 3 x 3 matrix
    m00, m01, m02, m11, m12, m22 = normal[0], normal[1], normal[2], normal[3], normal[4], normal[5]
    if not m00 > 0.0:
        return False
    l10, l20 = m01 / m00, m02 / m00
    d1 = m11 - l10 * m01
    if not d1 > _LOST * m11:
        return False
    l21 = (m12 - l10 * m02) / d1
    d2 = m22 - l20 * m02 - l21 * l21 * d1
    if not d2 > _LOST * m22:
        return False
    # inverse of L, then L^-T D^-1 L^-1
    k20 = l10 * l21 - l20
    i0, i1, i2 = 1.0 / m00, 1.0 / d1, 1.0 / d2
    n = normal[_INVERSE:]
    n[0] = i0 + l10 * l10 * i1 + k20 * k20 * i2
    n[1] = -l10 * i1 - k20 * l21 * i2
    n[2] = k20 * i2
    n[3] = i1 + l21 * l21 * i2
    n[4] = -l21 * i2
    n[5] = i2
    b0, b1, b2 = normal[6], normal[7], normal[8]
    out[0] = n[0] * b0 + n[1] * b1 + n[2] * b2
    out[1] = n[1] * b0 + n[3] * b1 + n[4] * b2
    out[2] = (n[2] * b0 + n[4] * b1 + n[5] * b2) / length
    return True


@leaf
def back(normal, rows, at, length, weight):  # type: ignore[no-untyped-def]
    """How an error of this row's z moves the solution: (H'WH)^-1 a w, after `solve`."""
    n, a, b, c = normal[_INVERSE:], rows[at], rows[at + 1], rows[at + 2] / length
    return (
        weight * (n[0] * a + n[1] * b + n[2] * c),
        weight * (n[1] * a + n[3] * b + n[4] * c),
        weight * (n[2] * a + n[4] * b + n[5] * c) / length,
    )


@leaf
def row(rows, at, xi):  # type: ignore[no-untyped-def]
    """rows[at : at + 3] . xi."""
    return rows[at] * xi[0] + rows[at + 1] * xi[1] + rows[at + 2] * xi[2]
