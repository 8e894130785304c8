"""First-order lag: what follows a target with a time constant, stepped exactly."""

import math


def lag_factors(lag_s: float, dt_s: float) -> tuple[float, float]:
    """Exact step of x' = (target - x) / lag over `dt_s` with a constant target.

    Returns:
        decay: share of the gap x - target that is left at the end of the step, exp(-dt / lag).
        mean: share of the gap that is there on average over the step, (1 - decay) lag / dt.
    """
    if lag_s <= 0.0:
        return 0.0, 0.0
    a = dt_s / lag_s
    return math.exp(-a), -math.expm1(-a) / a
