"""What the wheels can do: the set of twists that no wheel speed limit forbids, and scaling into it.

For fixed wheels the set is the polytope |J v| <= w_max; a steered wheel adds the cone |contact velocity| <= r w_max.
Both are convex and contain rest, so scaling a twist down keeps its direction and has an exact answer.
"""

from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from holodrive.kinematics.shapes import twists
from holodrive.types import Array

if TYPE_CHECKING:
    from holodrive.kinematics.chassis import Chassis


class Applied(NamedTuple):
    """What became of a wanted twist.

    Attributes:
        twist: (..., 3) that is applied.
        scale: (...) factor that speed limits and wheels took from the wanted one, 1 when they took nothing.
        binding: name of the wheel (or of the limit) that bound, "" when none did; an array of names for a batch. The
            last that bound: a wheel before "acceleration", that before "speed" and "yaw rate".
        share: how far from the last twist towards the wanted one acceleration limits let go, 1 when they took
            nothing; below 1 they bound, whatever `scale` and `binding` say.
    """

    twist: Array
    scale: Any
    binding: Any
    share: Any = 1.0


def loads(chassis: "Chassis", twist: ArrayLike) -> Array:
    """(..., n) speed of each wheel relative to its limit."""
    rows = chassis.wheel_rows(twist)
    speeds = np.abs(rows[..., chassis.row])
    if chassis.steered:
        index = list(chassis.steered)
        rim = np.hypot(rows[..., chassis.steered_rows], rows[..., chassis.steered_rows + 1])
        speeds[..., index] = rim / chassis.radii[index]
    return np.asarray(speeds / chassis.max_speeds)


def saturate(chassis: "Chassis", twist: ArrayLike) -> Applied:
    """Scale twists (..., 3) by one factor each into what the wheels can do; direction and shape of motion stay."""
    twist = twists(twist)
    load = loads(chassis, twist)
    worst = np.argmax(load, axis=-1)
    scale = 1.0 / np.maximum(1.0, np.max(load, axis=-1))
    names = np.where(scale < 1.0, np.asarray(chassis.names, dtype=object)[worst], "")
    if twist.ndim == 1:
        return Applied(twist * scale, float(scale), str(names))
    return Applied(twist * scale[..., None], scale, names)


def max_speed(chassis: "Chassis", direction: ArrayLike, omega: ArrayLike = 0.0) -> Array:
    """Largest speed (...) [m/s] towards `direction` (...) [rad, base_link] while turning with `omega` (...) [rad/s].

    NaN where the wheels cannot turn that fast while moving that way at all; infinite without wheel limits.
    """
    direction, omega = np.broadcast_arrays(np.asarray(direction, dtype=np.float64), np.asarray(omega, dtype=np.float64))
    low, high = speed_interval(chassis, direction, omega)
    return np.asarray(np.where((high >= low) & (high >= 0.0), high, np.nan))


def speed_interval(chassis: "Chassis", direction: Array, omega: Array) -> tuple[Array, Array]:
    """Speeds [m/s] along a direction that every wheel allows while turning: (lowest, highest); empty if reversed.

    A fixed wheel allows |p s + q omega| <= w_max, a steered one |s d + omega (-y, x)| <= r w_max.
    """
    unit = np.stack([np.cos(direction), np.sin(direction), np.zeros_like(direction)], axis=-1)
    turn = np.stack([np.zeros_like(omega), np.zeros_like(omega), omega], axis=-1)
    along, offset = chassis.wheel_rows(unit), chassis.wheel_rows(turn)
    low, high = np.full(direction.shape, -np.inf), np.full(direction.shape, np.inf)
    for i, (wheel, row) in enumerate(zip(chassis.wheels, chassis.row, strict=True)):
        if wheel.steered:
            b = along[..., row] * offset[..., row] + along[..., row + 1] * offset[..., row + 1]
            c = offset[..., row] ** 2 + offset[..., row + 1] ** 2 - wheel.max_rim_speed**2
            root = b * b - c
            reach = np.sqrt(np.where(root >= 0.0, root, np.nan))
            first, last = -b - reach, -b + reach
        else:
            first, last = _fixed_interval(along[..., row], offset[..., row], chassis.max_speeds[i])
        # an impossible turn rate gives NaN, which must win
        low, high = np.maximum(low, first), np.minimum(high, last)
    return low, high


def _fixed_interval(p: Array, q: Array, bound: float) -> tuple[Array, Array]:
    """Speeds s with |p s + q| <= bound."""
    free = np.abs(p) < 1e-300
    slope = np.where(free, 1.0, np.abs(p))
    sign = np.where(p < 0.0, -1.0, 1.0)
    low, high = (-bound - q * sign) / slope, (bound - q * sign) / slope
    inside = np.where(np.abs(q) <= bound, np.inf, np.nan)
    return np.where(free, -inside, low), np.where(free, inside, high)


def desaturate(speeds: ArrayLike, max_speed: ArrayLike) -> Array:
    """Wheel speeds (..., n) scaled by one common factor so that none exceeds `max_speed` (one or (n,), same unit)."""
    speeds = np.asarray(speeds, dtype=np.float64)
    worst = np.max(np.abs(speeds) / max_speed, axis=-1, keepdims=True)
    return np.asarray(speeds / np.maximum(1.0, worst))


def desaturate_by_chassis(
    speeds: ArrayLike, wanted: ArrayLike, max_wheel: float, max_translation: float, max_rotation: float
) -> Array:
    """Wheel speeds (..., n) scaled as WPILib does it when the stick, not the wheel, shall have the whole range.

    The wanted twist (..., 3) fills some share of the base's own limits; wheels get at most that share of theirs.
    """
    speeds, wanted = np.asarray(speeds, dtype=np.float64), np.asarray(wanted, dtype=np.float64)
    fastest = np.max(np.abs(speeds), axis=-1)
    moving = np.hypot(wanted[..., 0], wanted[..., 1]) / max_translation
    share = np.maximum(moving, np.abs(wanted[..., 2]) / max_rotation)
    scale = np.minimum(1.0, share * max_wheel / np.where(fastest > 0.0, fastest, np.inf))
    return np.asarray(speeds * np.where(fastest > 0.0, scale, 1.0)[..., None])


def accel_share(now: ArrayLike, wanted: ArrayLike, accel: ArrayLike, decel: ArrayLike, dt_s: float) -> Array:
    """How much of the change from `now` to `wanted` (...) one tick allows, in (0, 1].

    Speeding up (further from 0 on the same side) is bounded by `accel`, everything else, crossing 0 included, by
    `decel` [unit/s, both positive]. The smallest share over all axes of a twist keeps its direction.
    """
    now, wanted = np.asarray(now, dtype=np.float64), np.asarray(wanted, dtype=np.float64)
    change = np.abs(wanted - now)
    speeds_up = (np.abs(wanted) >= np.abs(now)) & (now * wanted >= 0.0)
    bound = np.where(speeds_up, accel, decel) * dt_s
    return np.asarray(np.where(change > bound, bound / np.where(change > bound, change, 1.0), 1.0))
