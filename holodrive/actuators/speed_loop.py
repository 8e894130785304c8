"""The wheel-speed loop of a motor board: wheel-speed command in, motor duty out, once a control tick.

duty = (feed-forward * command + kp * error + integral) / no-load speed, error = command - encoder speed (filtered);
a whole feed-forward alone is right for a motor without load at its nominal voltage.

Gains in volts per speed, as papers print them, are multiplied by no-load speed over nominal voltage: k_p [V s/rad] is
kp = k_p w_0 / V, k_i [V/rad] is ki = k_i w_0 / V. So kp = 1 is about the motor's own back-EMF constant.
"""

from holodrive.leaf import leaf


@leaf
def speed_loop_step(command, measured, integral, unit, kp, ki, period, feed_forward=1.0):  # type: ignore[no-untyped-def]
    """One tick of one wheel.

    Args:
        command: wanted speed [rad/s].
        measured: encoder speed, filtered [rad/s].
        integral: of the loop so far [rad/s]: ki times the time integral of the error.
        unit: duty per speed, 1 / no-load speed [s/rad].
        kp: [1], ki: [1/s].
        period: since the last tick [s].
        feed_forward: share of the command that becomes duty at once [1].

    Returns:
        duty in [-1, 1] and the new integral. The integral does not grow into saturation (anti-windup). A wheel that is
        told to stand is braked by its error alone, for an integral left from braking would make it creep on for most
        of a second; and once it stands it draws nothing.
    """
    if command == 0.0:
        brake = -kp * measured * unit if abs(measured) * unit >= 1e-3 else 0.0
        return min(1.0, max(-1.0, brake)), 0.0
    error = command - measured
    grown = integral + ki * error * period
    wanted = (feed_forward * command + kp * error + grown) * unit
    if abs(wanted) > 1.0 and wanted * error > 0.0:
        grown = integral
        wanted = (feed_forward * command + kp * error + grown) * unit
    return min(1.0, max(-1.0, wanted)), grown
