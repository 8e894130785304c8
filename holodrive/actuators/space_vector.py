"""Three phases as one vector: Clarke and Park, and which voltages three legs at one supply can make."""

import math

from holodrive.leaf import leaf

_ROOT_3 = math.sqrt(3.0)


@leaf
def clarke(a, b, c):  # type: ignore[no-untyped-def]
    """Three phases as a vector (alpha, beta), alpha along phase a; what they have in common is left out.

    Amplitude-invariant: a balanced sine of amplitude 1 is a vector of length 1, so power is 3/2 of the product of the
    vectors of voltage and current.
    """
    return (2.0 * a - b - c) / 3.0, (b - c) / _ROOT_3


@leaf
def inverse_clarke(alpha, beta):  # type: ignore[no-untyped-def]
    """The three phases, of sum 0, that `clarke` takes to (alpha, beta)."""
    half, across = -0.5 * alpha, 0.5 * _ROOT_3 * beta
    return alpha, half + across, half - across


@leaf
def park(alpha, beta, angle):  # type: ignore[no-untyped-def]
    """(d, q) of a vector (alpha, beta), with the d axis at `angle` from alpha [rad]; lengths stay."""
    c, s = math.cos(angle), math.sin(angle)
    return c * alpha + s * beta, c * beta - s * alpha


@leaf
def inverse_park(d, q, angle):  # type: ignore[no-untyped-def]
    """(alpha, beta) of a vector (d, q), with the d axis at `angle` from alpha [rad]."""
    c, s = math.cos(angle), math.sin(angle)
    return c * d - s * q, s * d + c * q


@leaf
def within_circle(first, second, radius):  # type: ignore[no-untyped-def]
    """A vector brought into a circle around 0: `first` is kept for as long as it fits, `second` gets the rest."""
    if first * first + second * second <= radius * radius:
        return first, second
    first = min(radius, max(-radius, first))
    rest = math.sqrt(max(0.0, radius * radius - first * first))
    return first, min(rest, max(-rest, second))


@leaf
def leg_duties(v_alpha, v_beta, bus_v):  # type: ignore[no-untyped-def]
    """Duties (3) of the legs, 0 to 1, with the middle between highest and lowest phase at half of the supply.

    With this zero sequence (min-max; the mean of space-vector PWM) every vector up to bus_v / sqrt(3) is made exactly:
    the circle inside the hexagon of all that three legs can do, 15 % wider than with sinusoidal legs. What lies
    outside the hexagon is cut at the rails.
    """
    a, b, c = inverse_clarke(v_alpha, v_beta)
    middle = 0.5 * (max(a, b, c) + min(a, b, c))
    per_volt = 1.0 / bus_v if bus_v > 0.0 else 0.0
    return (
        min(1.0, max(0.0, 0.5 + (a - middle) * per_volt)),
        min(1.0, max(0.0, 0.5 + (b - middle) * per_volt)),
        min(1.0, max(0.0, 0.5 + (c - middle) * per_volt)),
    )
