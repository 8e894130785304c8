"""Equations 13 to 15 as they stand: an angle becomes two gains, quadrant by quadrant."""

from holodrive.experiments.mecanum import printed

PAIRS = ("W1W4", "W2W3")


def printed_gains(angle_deg: float) -> tuple[float, float]:
    """Gains of W1W4 and W2W3 by equation 13 with the boundaries of equations 14 and 15.

    Args:
        angle_deg: theta [degrees], any turn.
    """
    angle = angle_deg % 360.0
    low, high, first, second = max(q for q in printed.QUADRANTS if q[0] <= angle)
    return _line(angle, low, high, first), _line(angle, low, high, second)


def _line(angle: float, low: float, high: float, ends: tuple[float, float]) -> float:
    """Equation 13."""
    return (angle - low) * ((ends[1] - ends[0]) / (high - low)) + ends[0]
