"""What one module with a caster does in a tick, for plain floats; the compiled pipeline uses the same text.

A powered caster obeys c d' = n(d) . v - c omega while the twist is held over a tick. With p = sin(D/2), q = cos(D/2)
of the angle D turned so far, up to a common factor, this is linear,

    p' = -a p + (b - omega/2) q,   q' = (b + omega/2) p + a q,   a = v_along / 2c,  b = v_across / 2c

so D is exact for a tick of any length, and so is the way that the wheel rolls: c ln(p^2 + q^2), which has e . v as its
rate. Twists scaled by f do in a tick what the twist does in f ticks.
"""

import math

from holodrive.kinematics.settings import HOLD_SPEED, NEW_WAY


def follow(along: float, across: float, omega: float, caster: float, dt: float) -> tuple[float, float]:
    """Angle [rad] that a powered caster turns in a tick, and way [m] that its wheel rolls.

    Args:
        along, across: velocity of the steering axis, held over the tick, in the module's axes at its start [m/s].
        omega: of the base [rad/s].
        caster: [m], not 0.
        dt: [s].
    """
    a, b = 0.5 * along / caster, 0.5 * across / caster
    square = a * a + b * b - 0.25 * omega * omega
    root = math.sqrt(abs(square))
    x = root * dt
    if square > 0.0 and x > 1e-9:
        share, log_scale = math.tanh(x) / root, x + math.log1p(math.exp(-2.0 * x)) - math.log(2.0)
        p, q = share * (b - 0.5 * omega), 1.0 + share * a
    else:
        share, log_scale = (math.sin(x) / root, 0.0) if x > 1e-9 else (dt, 0.0)
        p, q = share * (b - 0.5 * omega), (math.cos(x) if x > 1e-9 else 1.0) + share * a
    size = p * p + q * q
    if size < 1e-200:  # straight backwards so fast that only rounding is left of q
        return 0.0, along * dt
    return 2.0 * math.atan2(p, q), caster * (2.0 * log_scale + math.log(size))


def time_of_turn(
    along: float, across: float, omega: float, caster: float, turn: float, reach: float, dt: float
) -> float:
    """Time [s] that `follow` takes to turn by `reach` [rad] of all that it turns in `dt`; `reach` below half a turn."""
    a, b = 0.5 * along / caster, 0.5 * across / caster
    square = a * a + b * b - 0.25 * omega * omega
    root, tangent = math.sqrt(abs(square)), math.tan(math.copysign(0.5 * reach, turn))
    slope = b - 0.5 * omega - tangent * a
    time = -1.0
    if slope != 0.0:
        x = root * tangent / slope
        if abs(x) < 1e-9:
            time = tangent / slope
        elif square > 0.0:
            time = 0.5 * math.log((1.0 + x) / (1.0 - x)) / root if abs(x) < 1.0 else -1.0
        else:
            time = (math.atan(x) if x > 0.0 else math.atan(x) + math.pi) / root
    # at the edge of rounding: as if it turned evenly
    return time if 0.0 < time < dt else dt * reach / abs(turn)


def lean(
    along: float, across: float, before_along: float, before_across: float, omega: float, caster: float, dt: float
) -> float:
    """How far a short caster points off the velocity of its axis so as not to slip sideways [rad].

    n . v = c (omega + d'), where omega + d' is how fast that velocity turns over the ground: 0 on a straight line,
    also of a base that spins, and omega on an arc. A change by more than `NEW_WAY` is a new command, not a motion.

    Args:
        along, across: velocity of the axis [m/s], in any axes that turn with the base.
        before_along, before_across: that of the tick before, in those axes as they stood then.
        omega: of the base [rad/s].
        caster: [m].
        dt: [s].
    """
    speed = math.sqrt(along * along + across * across)
    before = math.sqrt(before_along * before_along + before_across * before_across)
    if speed < HOLD_SPEED:
        return 0.0
    rate = omega
    if before >= HOLD_SPEED:
        cross = before_along * across - before_across * along
        dot = before_along * along + before_across * across
        if abs(cross) < math.tan(NEW_WAY) * abs(dot):
            rate += math.atan(cross / dot) / dt
    return math.asin(min(1.0, max(-1.0, caster * rate / speed)))


def headroom(speed: float, carried: float, limit: float) -> float:
    """Share at most 1 of a wheel's speed that its drive has left, which turns `carried` faster, all [rad/s]."""
    if abs(speed + carried) <= limit or speed == 0.0:
        return 1.0
    return max(0.0, limit - (carried if speed > 0.0 else -carried)) / abs(speed)
