"""DC motor with inductance, which is also a six-step BLDC motor without its commutation.

    L di/dt = v - K w - R i,   torque = K i

R, L and K are those between two terminals: of a BLDC motor two phases in series. Left out are the ripple and the time
that each commutation takes the current from one phase to the next, so the averaged motor runs faster under load than
the real one (docs/motors.md).
"""

import math

from holodrive.actuators.bldc import (
    BACK_EMF,
    COPPER_J,
    CURRENT_A,
    CURRENT_B,
    CURRENT_LIMIT,
    EFFICIENCY,
    INDUCTANCE,
    INPUT_J,
    RESISTANCE,
    WORK_J,
)
from holodrive.leaf import leaf


@leaf
def averaged_substep(state, at, params, pt, duty, bus_v, omega_rotor, dt):  # type: ignore[no-untyped-def]
    """Drive one motor for one sub-step at constant rotor speed; the current is integrated exactly, at any step.

    Args:
        state, at: states and where this motor's `bldc.STATE_SIZE` numbers begin; the current is phase a's.
        params, pt: packed motors and where this one begins (`bldc.pack_motor`).
        duty: -1 to 1, of a bridge that switches both ways: duty 0 is a brake.
        bus_v: of the supply [V].
        omega_rotor: rotor speed, of the middle of the sub-step where it is known [rad/s].
        dt: [s].

    Returns:
        Electromagnetic torque at the rotor, mean of the sub-step [N m]; before friction and gear.
    """
    r, tau, k = params[pt + RESISTANCE], params[pt + INDUCTANCE] / params[pt + RESISTANCE], params[pt + BACK_EMF]
    i = state[at + CURRENT_A]
    gone = -math.expm1(-dt / tau)
    v, emf, limit = duty * bus_v, k * omega_rotor, params[pt + CURRENT_LIMIT]
    end = i * (1.0 - gone) + gone / r * (v - emf)
    if abs(end) > limit:
        v += (math.copysign(limit, end) - end) * r / gone
        v = min(bus_v, max(-bus_v, v))
    final = (v - emf) / r
    gap, lag = i - final, tau * gone
    charge = final * dt + gap * lag
    end = final + gap * (1.0 - gone)
    state[at + CURRENT_A], state[at + CURRENT_B] = end, -end
    state[at + INPUT_J] += v * charge
    state[at + COPPER_J] += r * (final * final * dt + gap * lag * (2.0 * final + 0.5 * gap * (2.0 - gone)))
    state[at + WORK_J] += emf * charge
    return k * charge / dt


@leaf
def coupled_step(params, pt, current, omega, volts, load, inertia, viscous, dt):  # type: ignore[no-untyped-def]
    """Exact step of any length of current and speed together, under constant voltage and load, without limits.

    With A = [[-R/L, -K/L], [eta K/J, -b/J]] the distance to the steady state is multiplied by exp(A dt), which has a
    closed form in two dimensions. Takes an inductance above 0.

    Args:
        params, pt: packed motors and where this one begins.
        current, omega: [A], rotor speed [rad/s].
        volts: at the terminals [V].
        load: torque against the rotor [N m].
        inertia, viscous: of rotor and what it drives, seen at the rotor [kg m^2, N m s/rad].
        dt: [s].

    Returns:
        Current [A] and speed [rad/s] after `dt`.
    """
    r, tau, k = params[pt + RESISTANCE], params[pt + INDUCTANCE] / params[pt + RESISTANCE], params[pt + BACK_EMF]
    pull = params[pt + EFFICIENCY] * k
    a, b, c, d = -1.0 / tau, -k / (r * tau), pull / inertia, -viscous / inertia
    steady_omega = (pull * volts - r * load) / (r * viscous + pull * k)
    steady_current = (volts - k * steady_omega) / r
    half, det = 0.5 * (a + d), a * d - b * c
    square = half * half - det
    if square > 0.0:
        root = math.sqrt(square)
        slow, fast = math.exp((half + root) * dt), math.exp((half - root) * dt)
        even, odd = 0.5 * (slow + fast), -0.5 * slow * math.expm1(-2.0 * root * dt) / root
    elif square < 0.0:
        root = math.sqrt(-square)
        even, odd = math.exp(half * dt) * math.cos(root * dt), math.exp(half * dt) * math.sin(root * dt) / root
    else:
        even = math.exp(half * dt)
        odd = even * dt
    di, dw = current - steady_current, omega - steady_omega
    return (
        steady_current + (even + odd * (a - half)) * di + odd * b * dw,
        steady_omega + odd * c * di + (even + odd * (d - half)) * dw,
    )
