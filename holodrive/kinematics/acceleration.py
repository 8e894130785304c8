"""Second order: how fast wheels must speed up and modules must steer for an acceleration of the body, and back.

`accel` is the rate of change of the twist's components in `base_link`, (d vx/dt, d vy/dt, d omega/dt). The base turns
under those axes, so the ground sees omega x v besides; `contact` includes it and the centripetal -omega^2 r.

With casters `inverse_acceleration` differentiates `Chassis.inverse`, so r w = e . v and c omega = n . v; for powered
casters there is `caster.powered_acceleration`.
"""

from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from holodrive.kinematics import caster
from holodrive.kinematics.shapes import common_shape
from holodrive.types import Array

if TYPE_CHECKING:
    from holodrive.kinematics.chassis import Chassis


class WheelAcceleration(NamedTuple):
    """Rates of wheel motion.

    Attributes:
        speeds: (..., n) rates of the wheel speeds [rad/s^2].
        steer: (..., m) rates of the steering angles [rad/s].
        contact: (..., n, 2) acceleration of each contact point (a caster's axis) over the ground, in `base_link`
            axes [m/s^2].
    """

    speeds: Array
    steer: Array
    contact: Array


def inverse_acceleration(chassis: "Chassis", twist: Array, accel: Array) -> WheelAcceleration:
    """Body -> wheels, for a base with `twist` (..., 3) and `accel` (..., 3).

    A module at rest is taken to point along its acceleration; its steering rate is 0 there.
    """
    common_shape(twist=twist.shape[:-1], accel=accel.shape[:-1])
    twist, accel = np.broadcast_arrays(twist, accel)
    rate = chassis.wheel_rows(accel)
    contact = _contact(chassis, twist, accel)
    if not chassis.steered:
        return WheelAcceleration(rate, np.empty((*rate.shape[:-1], 0)), contact)
    rows = chassis.wheel_rows(twist)
    along, across = rows[..., chassis.steered_rows], rows[..., chassis.steered_rows + 1]
    d_along, d_across = rate[..., chassis.steered_rows], rate[..., chassis.steered_rows + 1]
    if chassis.castered:
        return _of_casters(chassis, twist, accel, rate, contact)
    speed = np.hypot(along, across)
    rest = speed == 0.0
    safe = np.where(rest, 1.0, speed)
    change = np.where(rest, np.hypot(d_along, d_across), (along * d_along + across * d_across) / safe)
    steer = np.where(rest, 0.0, (along * d_across - across * d_along) / safe / safe)
    speeds = rate[..., chassis.row]
    index = list(chassis.steered)
    speeds[..., index] = change / chassis.radii[index]
    return WheelAcceleration(speeds, steer, contact)


def forward_acceleration(
    chassis: "Chassis",
    speeds: ArrayLike,
    rates: ArrayLike,
    steer: ArrayLike | None = None,
    steer_rates: ArrayLike | None = None,
    steer_accels: ArrayLike | None = None,
) -> Array:
    """Wheels -> body: rate (..., 3) of the twist's components, by least squares.

    Args:
        chassis: the base.
        speeds: (..., n) wheel speeds [rad/s] (they matter for steered wheels only).
        rates: (..., n) their rates [rad/s^2].
        steer: (..., m) steering angles [rad].
        steer_rates: (..., m) their rates [rad/s]; 0 when not given.
        steer_accels: (..., m) rates of those [rad/s^2]; matter with casters only, 0 when not given.
    """
    rows = chassis.rows_of(rates, steer)
    rate = None if steer_rates is None else chassis.steering(steer_rates, "rates of steering")
    if rate is not None:
        # a steering wheel turns its speed: add w r d'(-sin d, cos d)
        index = list(chassis.steered)
        turned = chassis.rows_of(speeds, np.asarray(steer, dtype=np.float64) + 0.5 * np.pi)
        rows = np.array(np.broadcast_to(rows, np.broadcast_shapes(rows.shape, turned.shape)))
        for j in range(len(index)):
            at = chassis.steered_rows[j]
            rows[..., at] += turned[..., at] * rate[..., j]
            rows[..., at + 1] += turned[..., at + 1] * rate[..., j]
    if not chassis.castered:
        return np.asarray(rows @ chassis.least_squares.T)
    angles = np.asarray(steer, dtype=np.float64)
    if rate is not None:
        # the contact is carried round its axis: c d'' along n, and -c d' (omega + d') along e
        omega = chassis.forward(speeds, steer, rate)[..., 2:]
        rows = caster.swept(chassis, rows, angles + 0.5 * np.pi, rate * (omega + rate))
    if steer_accels is not None:
        rows = caster.swept(chassis, rows, angles, np.asarray(steer_accels, dtype=np.float64))
    return np.asarray(np.einsum("...ij,...j->...i", chassis.inverse_at(chassis.matrix_at(angles)), rows))


def _of_casters(chassis: "Chassis", twist: Array, accel: Array, rate: Array, contact: Array) -> WheelAcceleration:
    """Rates of `caster.steady_inverse`: d' = (n . v' - c omega') / (e . v), r w' = e . v' + d' n . v."""
    command, index = caster.steady_inverse(chassis, twist), list(chassis.steered)
    c, s = np.cos(command.steer), np.sin(command.steer)
    d_along, d_across = rate[..., chassis.steered_rows], rate[..., chassis.steered_rows + 1]
    rolling = command.speeds[..., index] * chassis.radii[index]
    sideways = c * d_across - s * d_along - chassis.casters * accel[..., 2:]
    rest = rolling == 0.0
    steer = np.where(rest, 0.0, sideways / np.where(rest, 1.0, rolling))
    change = np.where(
        rest, np.hypot(d_along, d_across), c * d_along + s * d_across + steer * chassis.casters * twist[..., 2:]
    )
    speeds = rate[..., chassis.row]
    speeds[..., index] = change / chassis.radii[index]
    return WheelAcceleration(speeds, steer, contact)


def _contact(chassis: "Chassis", twist: Array, accel: Array) -> Array:
    """Acceleration (..., n, 2) of the contact points over the ground: d(v + omega x r)/dt + omega x (v + omega x r)."""
    x = np.array([wheel.x for wheel in chassis.wheels])
    y = np.array([wheel.y for wheel in chassis.wheels])
    omega, alpha = twist[..., 2:3], accel[..., 2:3]
    vx, vy = twist[..., 0:1] - omega * y, twist[..., 1:2] + omega * x
    return np.stack([accel[..., 0:1] - alpha * y - omega * vy, accel[..., 1:2] + alpha * x + omega * vx], axis=-1)
