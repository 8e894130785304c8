"""Small turns in one physics step: sine and cosine without a call to either."""

import math

from numba import njit

_SERIES = 0.05  # rad in one step: below, the series below is exact to the last bit


@njit(cache=True, error_model="numpy")
def turn_factors(turn):  # type: ignore[no-untyped-def]
    """sin(t)/t and (1 - cos(t))/t of a turn t [rad]."""
    if abs(turn) < _SERIES:
        q = turn * turn
        sine = 1.0 - q / 6.0 * (1.0 - q / 20.0 * (1.0 - q / 42.0 * (1.0 - q / 72.0)))
        versine = 0.5 * turn * (1.0 - q / 12.0 * (1.0 - q / 30.0 * (1.0 - q / 56.0 * (1.0 - q / 90.0))))
        return sine, versine
    half = math.sin(0.5 * turn)
    return math.sin(turn) / turn, 2.0 * half * half / turn
