"""What every odometry does with a displacement of the body: move the pose exactly, let its covariance grow.

With d = (dx, dy, dtheta) the displacement of a tick in `base_link` and T the pose before it:

    T' = T exp(d),    P' = A P A^T + G Q G^T,    A = dT'/dT,  G = dT'/dd = R(theta) dexp(d)/dd

where P is the covariance of (x, y, theta) in world axes and Q that of d, a sum of variance * e e^T over the errors e
that the sensors make. A and G are the exact derivatives, not those of an Euler step.
"""

import math

from holodrive.leaf import leaf

_SERIES = 0.02  # rad
Levers = tuple[float, float, float, float, float, float]


@leaf
def advance(pose, displacement):  # type: ignore[no-untyped-def]
    """The pose (3,) after the displacement (3,), by the exact exponential; its heading keeps counting turns."""
    dx, dy, turn = displacement[0], displacement[1], displacement[2]
    sine, versine, _, _ = exp_terms(turn)
    x, y = sine * dx - versine * dy, versine * dx + sine * dy
    c, s = math.cos(pose[2]), math.sin(pose[2])
    pose[0] += c * x - s * y
    pose[1] += s * x + c * y
    pose[2] += turn


@leaf
def carry(covariance, heading, displacement):  # type: ignore[no-untyped-def]
    """P <- A P A^T, A = [[1, 0, -y], [0, 1, x], [0, 0, 1]]: an error of heading turns the way (x, y) of this step.

    Args:
        covariance: (9,) row by row.
        heading: before the step [rad].
        displacement: (3,) in `base_link`.
    """
    p, (dx, dy, turn) = covariance, (displacement[0], displacement[1], displacement[2])
    c, s = math.cos(heading), math.sin(heading)
    sine, versine, _, _ = exp_terms(turn)
    along_x, along_y = sine * dx - versine * dy, versine * dx + sine * dy
    x, y = c * along_x - s * along_y, s * along_x + c * along_y
    xt, yt, tt = p[2], p[5], p[8]
    p[0] += y * (y * tt - 2.0 * xt)
    p[4] += x * (x * tt + 2.0 * yt)
    p[1] += x * xt - y * yt - x * y * tt
    p[2] -= y * tt
    p[5] += x * tt
    p[3], p[6], p[7] = p[1], p[2], p[5]


@leaf
def levers(heading, displacement):  # type: ignore[no-untyped-def]
    """The first two rows of G = dT'/dd, row by row; the third is (0, 0, 1)."""
    dx, dy, turn = displacement[0], displacement[1], displacement[2]
    c, s = math.cos(heading), math.sin(heading)
    sine, versine, sine_slope, versine_slope = exp_terms(turn)
    u, v = sine_slope * dx - versine_slope * dy, versine_slope * dx + sine_slope * dy
    a, b = c * sine - s * versine, c * versine + s * sine
    return a, -b, c * u - s * v, b, a, s * u + c * v


@leaf
def spread(covariance, g, variance, x, y, turn):  # type: ignore[no-untyped-def]
    """P <- P + variance * (G e) (G e)^T: what an error e = (x, y, turn) of the displacement, of this variance, adds."""
    add(covariance, variance, g[0] * x + g[1] * y + g[2] * turn, g[3] * x + g[4] * y + g[5] * turn, turn)


@leaf
def add(covariance, size, x, y, turn):  # type: ignore[no-untyped-def]
    """P <- P + variance * v v^T with v = (x, y, turn) in world axes."""
    p = covariance
    p[0] += size * x * x
    p[1] += size * x * y
    p[2] += size * x * turn
    p[4] += size * y * y
    p[5] += size * y * turn
    p[8] += size * turn * turn
    p[3], p[6], p[7] = p[1], p[2], p[5]


@leaf
def exp_terms(w):  # type: ignore[no-untyped-def]
    """sin(w)/w, (1 - cos(w))/w and their derivatives; series near zero, where the quotients lose digits."""
    q = w * w
    if abs(w) < _SERIES:
        sine = 1.0 - q / 6.0 * (1.0 - q / 20.0 * (1.0 - q / 42.0))
        versine = 0.5 * w * (1.0 - q / 12.0 * (1.0 - q / 30.0 * (1.0 - q / 56.0)))
        sine_slope = -w / 3.0 * (1.0 - q / 10.0 * (1.0 - q / 28.0))
        versine_slope = 0.5 - q / 8.0 * (1.0 - q / 18.0 * (1.0 - q / 40.0))
        return sine, versine, sine_slope, versine_slope
    half = math.sin(0.5 * w)
    sine, versine = math.sin(w) / w, 2.0 * half * half / w
    return sine, versine, (math.cos(w) - sine) / w, sine - versine / w
