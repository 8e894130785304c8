"""Steered wheels whose contact trails behind the steering axis, and whose steering turns the wheel a little.

The axis stands at p; at the module's angle d the contact is p - c e, e = (cos d, sin d), n = (-sin d, cos d), c the
caster. With v the velocity of the axis and no side slip

    r w = e . v,    c (omega + d') = n . v

so the wheel's own speed w is what it is without caster, and turning the module moves the body. In the stacked form of
`Chassis`, J(d) . twist is the velocity of the body at the contacts, c d' n what the turning adds:

    J(d) . twist = r w e + c d' n

Where nothing trails J is constant; here it is made anew for each set of angles.

Of a powered caster (c not 0) both equations can be solved for what the motors do, at any angle and for any twist:

    w = e . v / r,    d' = (n . v) / c - omega

So the base is holonomic: it starts in any direction at once, without turning its modules first (Holmberg & Khatib,
"Development and Control of a Holonomic Mobile Robot for Mobile Manipulation Tasks", IJRR 19(11), 2000).

Coupling k: while the drive's motor stands, a steering that turns by d' turns the wheel by -k d' (a bevel gear on the
steering axis). Speeds here are those of the wheel; its drive, and an encoder on it, turn with w + k d'.
"""

from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from holodrive.errors import ChassisError
from holodrive.geometry import wrap
from holodrive.kinematics.shapes import twists, wheel_values
from holodrive.types import Array, WheelCommand

if TYPE_CHECKING:
    from holodrive.kinematics.chassis import Chassis


class PoweredRates(NamedTuple):
    """What powered casters do.

    Attributes:
        speeds: (..., n) wheel speeds [rad/s].
        steer_rates: (..., m) rates of the steering angles [rad/s].
    """

    speeds: Array
    steer_rates: Array


class PoweredAcceleration(NamedTuple):
    """What powered casters do, second order.

    Attributes:
        speeds: (..., n) rates of the wheel speeds [rad/s^2].
        steer_rates: (..., m) rates of the steering angles [rad/s].
        steer_accels: (..., m) rates of those [rad/s^2].
    """

    speeds: Array
    steer_rates: Array
    steer_accels: Array


def contact_jacobian(chassis: "Chassis", steer: Array) -> Array:
    """J(d), (..., rows, 3): the velocity of the body at the contacts, at steering angles (..., m) [rad]."""
    matrix = np.array(np.broadcast_to(chassis.jacobian, (*steer.shape[:-1], *chassis.jacobian.shape)))
    matrix[..., chassis.steered_rows, 2] += chassis.casters * np.sin(steer)
    matrix[..., chassis.steered_rows + 1, 2] -= chassis.casters * np.cos(steer)
    return matrix


def contact_inverse(chassis: "Chassis", matrix: Array) -> Array:
    """Least-squares inverse (..., 3, rows) of `contact_jacobian`, in the units that `Chassis` counts rows in."""
    column = np.array([1.0, 1.0, 1.0 / chassis.verdict.length])
    inverse = np.linalg.pinv(matrix * chassis.row_scale[:, None] * column) * chassis.row_scale
    return np.asarray(column[:, None] * inverse)


def swept(chassis: "Chassis", rows: Array, steer: Array, steer_rates: Array) -> Array:
    """`rows` (..., rows) of wheels that only roll, with what turning the modules adds: c d' n."""
    sweep = chassis.casters * steer_rates
    shape = np.broadcast_shapes(rows.shape[:-1], sweep.shape[:-1], steer.shape[:-1])
    rows = np.array(np.broadcast_to(rows, (*shape, rows.shape[-1])))
    rows[..., chassis.steered_rows] -= sweep * np.sin(steer)
    rows[..., chassis.steered_rows + 1] += sweep * np.cos(steer)
    return rows


def steady_inverse(chassis: "Chassis", twist: Array) -> WheelCommand:
    """Wheels whose angles leave no side slip while the twist (..., 3) lasts: d' = 0, so n . v = c omega.

    Speeds are positive. Where the axis is nearer to the centre of the turn than its caster is long no angle does it;
    the module then stands square to the axis' velocity, with speed 0.
    """
    rows = chassis.wheel_rows(twist)
    along, across = rows[..., chassis.steered_rows], rows[..., chassis.steered_rows + 1]
    speed = np.hypot(along, across)
    share = chassis.casters * twist[..., 2:] / np.where(speed > 0.0, speed, np.inf)
    lean = np.arcsin(np.clip(share, -1.0, 1.0))
    speeds = rows[..., chassis.row]
    index = list(chassis.steered)
    speeds[..., index] = speed * np.cos(lean) / chassis.radii[index]
    return WheelCommand(speeds, wrap(np.arctan2(across, along) - lean))


def powered_inverse(chassis: "Chassis", twist: ArrayLike, steer: ArrayLike) -> PoweredRates:
    """Wheel speeds and steering rates that give a twist (..., 3) at once, from any steering angles (..., m) [rad].

    Raises:
        ChassisError: a steered wheel has no caster, so that turning it moves nothing.
    """
    twist, steer = twists(twist), _angles(chassis, steer)
    rows = chassis.wheel_rows(twist)
    rolling, across = _turned(chassis, rows, steer)
    shape = np.broadcast_shapes(rows.shape[:-1], rolling.shape[:-1])
    speeds = np.array(np.broadcast_to(rows[..., chassis.row], (*shape, len(chassis.wheels))))
    index = list(chassis.steered)
    speeds[..., index] = rolling / chassis.radii[index]
    return PoweredRates(speeds, across / chassis.casters - twist[..., 2:])


def powered_acceleration(
    chassis: "Chassis", twist: ArrayLike, accel: ArrayLike, steer: ArrayLike
) -> PoweredAcceleration:
    """`powered_inverse` differentiated, for a base with `twist` and `accel` (..., 3), the twist's rate."""
    twist, accel, steer = twists(twist), twists(accel, "the rate of a twist"), _angles(chassis, steer)
    rates = powered_inverse(chassis, twist, steer).steer_rates
    rolling, across = _turned(chassis, chassis.wheel_rows(twist), steer)
    change = chassis.wheel_rows(accel)
    d_rolling, d_across = _turned(chassis, change, steer)
    shape = np.broadcast_shapes(rates.shape[:-1], d_rolling.shape[:-1])
    speeds = np.array(np.broadcast_to(change[..., chassis.row], (*shape, len(chassis.wheels))))
    index = list(chassis.steered)
    speeds[..., index] = (d_rolling + rates * across) / chassis.radii[index]
    accels = (d_across - rates * rolling) / chassis.casters - accel[..., 2:]
    return PoweredAcceleration(speeds, rates, accels)


def drive_speeds(chassis: "Chassis", speeds: ArrayLike, steer_rates: ArrayLike) -> Array:
    """Speeds (..., n) [rad/s] of the drives, and of encoders on them, while wheels turn with `speeds`: w + k d'."""
    return _coupled(chassis, speeds, steer_rates, 1.0)


def wheel_speeds(chassis: "Chassis", drive_speeds: ArrayLike, steer_rates: ArrayLike) -> Array:
    """Speeds (..., n) [rad/s] of the wheels whose drives turn with `drive_speeds`; increments [rad] do as well."""
    return _coupled(chassis, drive_speeds, steer_rates, -1.0)


def _coupled(chassis: "Chassis", speeds: ArrayLike, steer_rates: ArrayLike, sign: float) -> Array:
    speeds = wheel_values(speeds, chassis.names, "wheel speeds")
    rates = chassis.steering(steer_rates, "rates of steering")
    if rates is None:
        return speeds
    shape = np.broadcast_shapes(speeds.shape[:-1], rates.shape[:-1])
    result = np.array(np.broadcast_to(speeds, (*shape, speeds.shape[-1])))
    result[..., list(chassis.steered)] += sign * chassis.couplings * rates
    return result


def _turned(chassis: "Chassis", rows: Array, steer: Array) -> tuple[Array, Array]:
    """Velocities (..., m) of the steering axes along and across their modules."""
    along, across = rows[..., chassis.steered_rows], rows[..., chassis.steered_rows + 1]
    c, s = np.cos(steer), np.sin(steer)
    return c * along + s * across, c * across - s * along


def _angles(chassis: "Chassis", steer: ArrayLike) -> Array:
    angles = chassis.steering(steer, "steering angles")
    if angles is None or np.any(chassis.casters == 0.0):
        raise ChassisError(
            "powered casters need every steered wheel to trail behind its axis; give each a caster, "
            "or use `inverse`, which points the wheels"
        )
    return angles
