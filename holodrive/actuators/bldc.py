"""Electronically commutated motor with three phases in star: back-EMF, torque, phase currents.

    L di_a/dt = v_a - R i_a - e_a - v_n,  v_n = (v_a + v_b + v_c - e_a - e_b - e_c) / 3,  i_a + i_b + i_c = 0
    e_k = (K / 2) w F(theta - k 120 deg),  torque = (K / 2) sum_k F(theta - k 120 deg) i_k

(Rosyidin et al., eq. 22 to 33; the resistive term of eq. 30 and 31 is R i / L, not 3 R i / L as printed.) R and L are
those of one phase: half of what is measured between two terminals. K is the constant between two terminals; torque
and back-EMF constant are one number in SI, for otherwise the air gap would make or lose energy.

Motors are packed into flat float64 vectors, states likewise, so that a loop over many motors can be compiled.
"""

import math

import numpy as np

from holodrive.leaf import leaf
from holodrive.robots.spec import Motor
from holodrive.types import Array

# A packed motor, all seen at the ROTOR (before the gear), electrical values between two terminals:
# [ohm, H, V s/rad (= N m/A), pole pairs, 1 = sine 0 = trapezoid, A, kg m^2, N m s/rad, N m, turns of rotor a turn, 1];
# the last two are the drive's and matter to FOC only: bandwidth of its current loops [rad/s], 1 = currents shaped by
# the EMF (`actuators.foc`)
(
    RESISTANCE,
    INDUCTANCE,
    BACK_EMF,
    PAIRS,
    SINE,
    CURRENT_LIMIT,
    INERTIA,
    VISCOUS,
    COULOMB,
    GEAR,
    EFFICIENCY,
    BANDWIDTH,
    SHAPED,
) = range(13)
MOTOR_SIZE = 13

# The state of one motor, whatever drives it: currents into the phases [A] (sum 0; a DC motor's current is a's, and b's
# negative), electrical angle [rad, 0 to 2 pi); then what has summed up since the caller cleared it [J]: energy drawn
# from the supply (below 0: fed back), copper loss, work of the electromagnetic torque; then what FOC remembers: what
# its loops hold along d and q [V], 1 while its demand is beyond the current limit or the supply's volts.
CURRENT_A, CURRENT_B, CURRENT_C, ANGLE, INPUT_J, COPPER_J, WORK_J, HELD_D, HELD_Q, LIMITED = range(10)
STATE_SIZE = 10

SECTOR = math.pi / 3.0  # rad of electrical angle between two edges of the Hall sensors
THIRD = 2.0 * math.pi / 3.0  # rad between two phases
TURN = 2.0 * math.pi

# Six-step commutation: phase at the supply, at ground and open in each sector of positive torque (0 = a, 1 = b, 2 = c)
HIGH = (0, 0, 1, 1, 2, 2)
LOW = (1, 2, 2, 0, 0, 1)
FLOATING = (2, 1, 0, 2, 1, 0)

# The phase amplitude of a sinusoidal EMF whose amplitude between two terminals is K w, as for the trapezoid
SINE_PEAK = 2.0 / math.sqrt(3.0)
CURRENT_BANDWIDTH = TURN * 1000.0  # rad/s, of FOC's current loops where nobody says otherwise


def pack_motor(motor: Motor) -> Array:
    """The (MOTOR_SIZE,) vector of a motor, brought from behind the gear to the rotor."""
    packed = np.zeros(MOTOR_SIZE)
    gear = motor.gear
    packed[RESISTANCE] = motor.resistance_ohm
    packed[INDUCTANCE] = motor.inductance_h
    packed[BACK_EMF] = motor.back_emf_v_s_rad / gear
    packed[PAIRS] = 0.5 * motor.poles
    packed[SINE] = 1.0 if motor.emf == "sine" else 0.0
    packed[CURRENT_LIMIT] = motor.current_limit_a
    packed[INERTIA] = motor.inertia_kg_m2 / gear**2
    packed[VISCOUS] = motor.viscous_friction_n_m_s_rad / gear**2
    packed[COULOMB] = motor.coulomb_friction_n_m / gear
    packed[GEAR] = gear
    packed[EFFICIENCY] = motor.efficiency
    packed[BANDWIDTH] = CURRENT_BANDWIDTH
    return packed


@leaf
def wrapped(angle):  # type: ignore[no-untyped-def]
    """An angle [rad] brought into 0 (inclusive) to 2 pi (exclusive)."""
    turned = angle - TURN * math.floor(angle / TURN)
    return 0.0 if turned >= TURN else turned


@leaf
def trapezoid(angle):  # type: ignore[no-untyped-def]
    """F of a trapezoidal back-EMF at an electrical angle [rad]: flat for 120 degrees from 0, and again from 180."""
    sectors = wrapped(angle) / SECTOR
    if sectors < 2.0:
        return 1.0
    if sectors < 3.0:
        return 1.0 - 2.0 * (sectors - 2.0)
    if sectors < 5.0:
        return -1.0
    return -1.0 + 2.0 * (sectors - 5.0)


@leaf
def emf_shape(angle, sine):  # type: ignore[no-untyped-def]
    """F at an electrical angle [rad]; a sine has its crest in the middle of the trapezoid's flat and is `SINE_PEAK`
    high, so that both motors have the same constant between two terminals."""
    return SINE_PEAK * math.cos(angle - SECTOR) if sine > 0.5 else trapezoid(angle)


@leaf
def sector_of(angle):  # type: ignore[no-untyped-def]
    """Sector 0 to 5 that the Hall sensors tell at an electrical angle [rad]."""
    return min(5, int(wrapped(angle) / SECTOR))


@leaf
def phase_derivatives(params, pt, i_a, i_b, omega, angle, v_a, v_b, v_c, load):  # type: ignore[no-untyped-def]
    """Rates of the corrected eq. 30 to 33 with all three terminals held at a voltage.

    Args:
        params, pt: packed motors, where this one begins.
        i_a, i_b: phase currents [A].
        omega: rotor speed [rad/s].
        angle: electrical angle [rad].
        v_a, v_b, v_c: of the terminals against any common point [V].
        load: torque against the rotor [N m].

    Returns:
        di_a/dt, di_b/dt [A/s], domega/dt [rad/s^2] (viscous friction only), dangle/dt [rad/s].
    """
    r, k, per_henry = 0.5 * params[pt + RESISTANCE], 0.5 * params[pt + BACK_EMF], 2.0 / params[pt + INDUCTANCE]
    f_a = emf_shape(angle, params[pt + SINE])
    f_b = emf_shape(angle - THIRD, params[pt + SINE])
    f_c = emf_shape(angle - 2.0 * THIRD, params[pt + SINE])
    u_a, u_b, u_c = v_a - k * omega * f_a, v_b - k * omega * f_b, v_c - k * omega * f_c
    neutral = (u_a + u_b + u_c) / 3.0
    torque = k * (f_a * i_a + f_b * i_b - f_c * (i_a + i_b))
    return (
        (u_a - neutral - r * i_a) * per_henry,
        (u_b - neutral - r * i_b) * per_henry,
        (torque - load - params[pt + VISCOUS] * omega) / params[pt + INERTIA],
        params[pt + PAIRS] * omega,
    )


@leaf
def stored_energy(state, at, params, pt):  # type: ignore[no-untyped-def]
    """Magnetic energy [J] of a motor's currents; right for DC motors as well."""
    squares = state[at + CURRENT_A] ** 2 + state[at + CURRENT_B] ** 2 + state[at + CURRENT_C] ** 2
    return 0.25 * params[pt + INDUCTANCE] * squares


@leaf
def integrals(i, final, h, gone, tau):  # type: ignore[no-untyped-def]
    """Charge [C] and integral of the square [A^2 s] of a current on its way from `i` towards `final`.

    Args:
        i, final: [A].
        h: time on the way [s].
        gone: 1 - exp(-h / tau), the share of the way.
        tau: L / R [s].
    """
    gap = i - final
    lag = gap * tau * gone
    return final * h + lag, final * final * h + lag * (2.0 * final + gap * (1.0 - 0.5 * gone))
