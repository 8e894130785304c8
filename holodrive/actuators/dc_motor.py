"""DC gearmotor and battery for implicit stepping: everything linear in the new speed, limits as secants.

    L di/dt = u V - K w - R i,   torque = efficiency K i - b w - coulomb(w)

Over one step with the new current and speed: i' = g (u V + X i - K w') / (R + X), X = L / dt; g <= 1 brings the
current under the driver's limit. Written as a conductance times a voltage, the current brakes a shorted motor at
any step, so a passive motor never gains energy. A motor without inductance has X = 0.
"""

import math

from holodrive.leaf import leaf

COULOMB_SPEED = 0.05  # rad/s at which dry friction has 0.7 of its full torque


@leaf
def conductance(duty_v, speed, current, back_emf, resistance, reactance, limit):  # type: ignore[no-untyped-def]
    """g / (R + X) [S] of a motor at the old speed: what the driver's current limit leaves of it.

    Args:
        duty_v: u V, voltage at the terminals [V].
        speed: old shaft speed [rad/s].
        current: old current [A], matters with inductance only.
        back_emf, resistance, reactance, limit: K [V s/rad], R [ohm], X = L / dt [ohm], driver's limit [A].
    """
    total = resistance + reactance
    asked = abs(duty_v + reactance * current - back_emf * speed)
    if asked > limit * total:
        return limit / asked
    return 1.0 / total


@leaf
def dry_friction(coulomb, speed):  # type: ignore[no-untyped-def]
    """Coulomb torque per speed [N m s/rad]: a secant that is smooth through standstill."""
    return coulomb / math.sqrt(speed * speed + COULOMB_SPEED * COULOMB_SPEED)


@leaf
def bus_voltage(open_circuit, resistance, drawn_at_zero, drawn_per_volt):  # type: ignore[no-untyped-def]
    """Voltage of a battery whose motors draw `drawn_at_zero + drawn_per_volt * V` [A]: sag, solved exactly."""
    return (open_circuit - resistance * drawn_at_zero) / (1.0 + resistance * drawn_per_volt)
