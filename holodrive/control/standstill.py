"""Wheels that shall stand or crawl are let stand: each start and each reversal costs an actuator its dead time.

A wheel that stands begins to turn when its command exceeds a threshold; one that turns keeps turning down to half of
it. A command that would turn a wheel the other way first lets it stand. So a wheel does not dither about zero.
"""

from holodrive.kinematics.kernel import BLOCK, N_WHEELS, RADIUS, WHEELS
from holodrive.leaf import leaf

_KEEPS = 0.5  # of the threshold


@leaf
def hold_still(kin, still_m_s, ways, speeds):  # type: ignore[no-untyped-def]
    """Make commands below the threshold nothing.

    Args:
        kin: the robot (`kinematics.kernel.arrays`).
        still_m_s: threshold, rim speed; 0 lets all pass.
        ways: (n,) which way each wheel turns: -1, 0 or 1; kept from tick to tick.
        speeds: (n,) commands [rad/s]; NaN stays NaN.
    """
    for i in range(int(kin[N_WHEELS])):
        way = 1.0 if speeds[i] > 0.0 else -1.0
        threshold = still_m_s / kin[WHEELS + BLOCK * i + RADIUS]
        if way == ways[i]:
            threshold *= _KEEPS
        ways[i] = way
        if abs(speeds[i]) < threshold:
            speeds[i] = ways[i] = 0.0


__all__ = ["hold_still"]
