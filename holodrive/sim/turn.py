"""Small turns in one physics step: sine and cosine without a call to either."""

import math

from holodrive.leaf import leaf

_SERIES = 0.05  # rad in one step: below, the series below is exact to the last bit


@leaf
def turn_factors(turn):  # type: ignore[no-untyped-def]
    """sin(t)/t and (1 - cos(t))/t of a turn t [rad]."""
    if abs(turn) < _SERIES:
        q = turn * turn
        sine = 1.0 - q * (1.0 / 6.0 - q * (1.0 / 120.0 - q * (1.0 / 5040.0 - q * (1.0 / 362880.0))))
        versine = turn * (0.5 - q * (1.0 / 24.0 - q * (1.0 / 720.0 - q * (1.0 / 40320.0 - q * (1.0 / 3628800.0)))))
        return sine, versine
    half = math.sin(0.5 * turn)
    return math.sin(turn) / turn, 2.0 * half * half / turn
