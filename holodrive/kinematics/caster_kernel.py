"""Twist from wheels with casters, compiled: twin of `Chassis.forward` where the matrix changes with the angles.

The vector `kin` is that of `kinematics.kernel.arrays`. With E and N the rows of an axis' velocity along and across
its module, the least squares are over E . twist = r w and (N - (0, 0, c)) . twist = c d', three unknowns by the
normal equations: a chassis is judged when it is built, so that they lose few digits.
"""

import math

from holodrive.kinematics.kernel import (
    BLOCK,
    CASTER,
    N_ROWS,
    N_WHEELS,
    RADIUS,
    RIM,
    ROWS,
    STEER_INDEX,
    WEIGHT,
    WHEELS,
)
from holodrive.leaf import leaf


@leaf
def caster_forward_step(kin, speeds, steer, rates, ago, twist_out):  # type: ignore[no-untyped-def]
    """Least-squares twist (3,) of wheel speeds, steering angles and steering rates; or of increments of all three.

    Args:
        kin: the robot.
        speeds: (n,) of the wheels [rad/s], coupling taken out.
        steer: (m,) [rad]; rates: (m,) [rad/s].
        ago: how long ago the modules stood where the twist is asked for [s]: angles are steer - ago rates.
        twist_out: (3,) written.

    Returns:
        Slip, as `kernel.forward_step` does.
    """
    inverse = normal_inverse(kin, steer, rates, ago)
    x = y = w = 0.0
    for i in range(int(kin[N_WHEELS])):
        j, roll, sweep, angle = motion(kin, i, speeds, steer, rates, ago)
        px, py, pw = pushed(kin, WHEELS + BLOCK * i, angle, roll, sweep)
        x, y, w = x + px, y + py, w + pw
    twist_out[0], twist_out[1], twist_out[2] = symmetric(inverse, x, y, w)
    if kin[N_ROWS] == 3.0:
        return 0.0
    total = 0.0
    for i in range(int(kin[N_WHEELS])):
        b = WHEELS + BLOCK * i
        j, roll, sweep, angle = motion(kin, i, speeds, steer, rates, ago)
        e1, e2, e3, n1, n2, n3 = rows(kin, b, angle)
        total += ((roll - e1 * twist_out[0] - e2 * twist_out[1] - e3 * twist_out[2]) * kin[b + RIM]) ** 2
        if j >= 0:
            total += (sweep - n1 * twist_out[0] - n2 * twist_out[1] - n3 * twist_out[2]) ** 2
    return math.sqrt(total / kin[N_ROWS])


@leaf
def wheel_twist(kin, i, steer, rates, ago, roll, sweep):  # type: ignore[no-untyped-def]
    """Twist (3) that one wheel alone makes, the others standing: the column of the least squares.

    Args:
        kin: the robot.
        i: the wheel.
        steer, rates, ago: as above.
        roll: how fast it rolls [m/s of rim]; a fixed wheel's speed [rad/s].
        sweep: how fast its contact is swept sideways [m/s]: caster times steering rate; 0 for a fixed wheel.
    """
    j = int(kin[WHEELS + BLOCK * i + STEER_INDEX])
    angle = steer[j] - ago * rates[j] if j >= 0 else 0.0
    x, y, w = pushed(kin, WHEELS + BLOCK * i, angle, roll, sweep)
    return symmetric(normal_inverse(kin, steer, rates, ago), x, y, w)


@leaf
def motion(kin, i, speeds, steer, rates, ago):  # type: ignore[no-untyped-def]
    """Place in steering arrays, how it rolls and is swept, and the angle of one wheel."""
    b = WHEELS + BLOCK * i
    j = int(kin[b + STEER_INDEX])
    if j < 0:
        return j, speeds[i], 0.0, 0.0
    return j, speeds[i] * kin[b + RADIUS], kin[b + CASTER] * rates[j], steer[j] - ago * rates[j]


@leaf
def rows(kin, b, angle):  # type: ignore[no-untyped-def]
    """The wheel's two rows of J(d), along and across it; a fixed wheel has the first alone."""
    at = b + ROWS
    if kin[b + STEER_INDEX] < 0.0:
        return kin[at], kin[at + 1], kin[at + 2], 0.0, 0.0, 0.0
    c, s = math.cos(angle), math.sin(angle)
    return (
        c * kin[at] + s * kin[at + 3],
        c * kin[at + 1] + s * kin[at + 4],
        c * kin[at + 2] + s * kin[at + 5],
        c * kin[at + 3] - s * kin[at],
        c * kin[at + 4] - s * kin[at + 1],
        c * kin[at + 5] - s * kin[at + 2] - kin[b + CASTER],
    )


@leaf
def pushed(kin, b, angle, roll, sweep):  # type: ignore[no-untyped-def]
    """What one wheel adds to the right side (3) of the normal equations."""
    e1, e2, e3, n1, n2, n3 = rows(kin, b, angle)
    r, q = kin[b + WEIGHT] * roll, kin[b + WEIGHT] * sweep
    return r * e1 + q * n1, r * e2 + q * n2, r * e3 + q * n3


@leaf
def normal_inverse(kin, steer, rates, ago):  # type: ignore[no-untyped-def]
    """Inverse of the normal matrix (3 x 3), its upper triangle row by row."""
    a11 = a12 = a13 = a22 = a23 = a33 = 0.0
    for i in range(int(kin[N_WHEELS])):
        b = WHEELS + BLOCK * i
        j = int(kin[b + STEER_INDEX])
        angle = steer[j] - ago * rates[j] if j >= 0 else 0.0
        e1, e2, e3, n1, n2, n3 = rows(kin, b, angle)
        weight = kin[b + WEIGHT]
        a11, a12, a13 = (
            a11 + weight * (e1 * e1 + n1 * n1),
            a12 + weight * (e1 * e2 + n1 * n2),
            a13 + weight * (e1 * e3 + n1 * n3),
        )
        a22, a23, a33 = (
            a22 + weight * (e2 * e2 + n2 * n2),
            a23 + weight * (e2 * e3 + n2 * n3),
            a33 + weight * (e3 * e3 + n3 * n3),
        )
    c11, c12, c13 = a22 * a33 - a23 * a23, a13 * a23 - a12 * a33, a12 * a23 - a13 * a22
    share = 1.0 / (a11 * c11 + a12 * c12 + a13 * c13)
    return (
        share * c11,
        share * c12,
        share * c13,
        share * (a11 * a33 - a13 * a13),
        share * (a12 * a13 - a11 * a23),
        share * (a11 * a22 - a12 * a12),
    )


@leaf
def symmetric(m, x, y, w):  # type: ignore[no-untyped-def]
    """A symmetric matrix (upper triangle) times a vector (3)."""
    return (
        m[0] * x + m[1] * y + m[2] * w,
        m[1] * x + m[3] * y + m[4] * w,
        m[2] * x + m[4] * y + m[5] * w,
    )
