"""Field-oriented control: two current loops in the rotor's frame, from a torque demand to a vector of voltage.

    L di_d/dt = v_d - R i_d + w_e L i_q,   L di_q/dt = v_q - R i_q - w_e L i_d - e_q,   torque = (3/2) (K/2) F1 i_q

d lies along the flux of the magnets and q a quarter turn ahead, where a sinusoidal EMF is; i_d only heats and is kept
at 0. Each loop is a PI controller whose zero cancels the pole R / L, so a current follows its demand with the time
constant 1 / bandwidth: kp = bandwidth L, ki = bandwidth R for short steps. Cross terms w_e L i and EMF are fed forward.
Everything is in discrete form, exact for a voltage that stands still in the stator over a step while the rotor turns
(as in Kim, Degner, Guerrero, Lorenz, "Discrete-time current regulator design for AC machine drives", 2010), so the
design holds at any step and speed. A voltage that the supply does not have is told to the loops, which then hold what
was really applied: no wind-up.

The drive is ideal: it knows currents, angle and speed of this instant, its PWM is averaged. R and L are of one phase.
"""

import math

from holodrive.actuators.bldc import (
    ANGLE,
    BACK_EMF,
    BANDWIDTH,
    COPPER_J,
    CURRENT_A,
    CURRENT_B,
    CURRENT_C,
    CURRENT_LIMIT,
    HELD_D,
    HELD_Q,
    INDUCTANCE,
    INPUT_J,
    LIMITED,
    PAIRS,
    RESISTANCE,
    SECTOR,
    SHAPED,
    SINE,
    SINE_PEAK,
    THIRD,
    WORK_J,
    emf_shape,
    integrals,
    wrapped,
)
from holodrive.actuators.space_vector import clarke, inverse_clarke, inverse_park, park, within_circle
from holodrive.leaf import leaf

FLUX = -2.5 * SECTOR  # rad from the electrical angle to the d axis; the crest of F_a is at 60 degrees, along q
TRAPEZOID_PEAK = 12.0 / math.pi**2  # F1, of the trapezoid's fundamental
_AT_LIMIT = 1.0 - 1e-9


@leaf
def foc_substep(state, at, params, pt, torque_demand, bus_v, omega_rotor, dt):  # type: ignore[no-untyped-def]
    """Drive one motor for one sub-step at constant rotor speed; control and currents take the same step.

    Args:
        state, at: states and where this motor's `bldc.STATE_SIZE` numbers begin; currents, angle and sums go on.
        params, pt: packed motors and where this one begins (`bldc.pack_motor`).
        torque_demand: electromagnetic, at the rotor [N m]; a demand that is not finite counts as 0. The driver's
            current limit bounds it (amplitude of a phase current), and the voltage of the supply.
        bus_v: of the supply [V].
        omega_rotor: rotor speed, of the middle of the sub-step where it is known [rad/s].
        dt: [s].

    Returns:
        Electromagnetic torque at the rotor, mean of the sub-step [N m]; before friction and gear.
    """
    v_alpha, v_beta = foc_voltage(state, at, params, pt, torque_demand, bus_v, omega_rotor, dt)
    return conduct(state, at, params, pt, v_alpha, v_beta, omega_rotor, dt)


@leaf
def foc_voltage(state, at, params, pt, torque_demand, bus_v, omega_rotor, dt):  # type: ignore[no-untyped-def]
    """The controller alone: the vector (alpha, beta) of voltage to hold for `dt` [V], never beyond bus_v / sqrt(3).

    Arguments as in `foc_substep`. Only what the loops remember changes in `state`.
    """
    r, tau = 0.5 * params[pt + RESISTANCE], params[pt + INDUCTANCE] / params[pt + RESISTANCE]
    gone = -math.expm1(-dt / tau)
    ohms = r / gone  # volts per ampere that a current changes in one step; L / dt for short ones
    here, turn = state[at + ANGLE], params[pt + PAIRS] * omega_rotor * dt
    now, then, middle = here + FLUX, here + FLUX + turn, here + 0.5 * turn
    i_alpha, i_beta = clarke(state[at + CURRENT_A], state[at + CURRENT_B], state[at + CURRENT_C])
    i_d, i_q = park(i_alpha, i_beta, now)
    d, q, next_d, next_q = _demand(params, pt, torque_demand, here, turn)

    # the change of current to make in this step: a share of the error, and as far as the demand itself moves
    share = -math.expm1(-params[pt + BANDWIDTH] * dt)
    step_d, step_q = share * (d - i_d) + next_d - d, share * (q - i_q) + next_q - q
    u_d, u_q = state[at + HELD_D] + ohms * step_d, state[at + HELD_Q] + ohms * step_q

    # EMF, and what carries the present current along with the rotor, so that u alone moves it in the rotor's frame
    e_alpha, e_beta = _known_emf(params, pt, omega_rotor, middle)
    carried = ohms * (1.0 - gone)
    turned_alpha, turned_beta = inverse_park(u_d + carried * i_d, u_q + carried * i_q, then)
    v_alpha, v_beta = e_alpha + turned_alpha - carried * i_alpha, e_beta + turned_beta - carried * i_beta

    most, limit = bus_v / math.sqrt(3.0), params[pt + CURRENT_LIMIT]
    state[at + LIMITED] = 1.0 if d * d + q * q > _AT_LIMIT * limit * limit else 0.0
    if v_alpha * v_alpha + v_beta * v_beta > most * most:
        # seen from where the rotor will be, each volt moves its own current: i_d stays 0 and torque yields; but while
        # the rotor feeds the supply i_d yields, below 0, for that weakens an EMF which may be beyond the supply
        asked_d, asked_q = park(v_alpha, v_beta, then)
        if i_q * omega_rotor < 0.0:
            asked_q, asked_d = within_circle(asked_q, asked_d, most)
        else:
            asked_d, asked_q = within_circle(asked_d, asked_q, most)
        v_alpha, v_beta = inverse_park(asked_d, asked_q, then)
        made_d, made_q = park(v_alpha - e_alpha + carried * i_alpha, v_beta - e_beta + carried * i_beta, then)
        u_d, u_q = made_d - carried * i_d, made_q - carried * i_q
        state[at + LIMITED] = 1.0
    # = held + R step without a limit, the integral of ki error; with one it ends at what was applied
    state[at + HELD_D] += gone * (u_d - state[at + HELD_D])
    state[at + HELD_Q] += gone * (u_q - state[at + HELD_Q])
    return v_alpha, v_beta


@leaf
def conduct(state, at, params, pt, v_alpha, v_beta, omega_rotor, dt):  # type: ignore[no-untyped-def]
    """Currents of a motor with all three terminals held at a voltage for a step; the mean torque [N m].

    The EMF is that of the step's middle, so currents are exponentials, integrated exactly: what the supply gives
    equals copper loss, work and stored energy to rounding.
    """
    r, tau = 0.5 * params[pt + RESISTANCE], params[pt + INDUCTANCE] / params[pt + RESISTANCE]
    k, turn = 0.5 * params[pt + BACK_EMF], params[pt + PAIRS] * omega_rotor * dt
    i_alpha, i_beta = clarke(state[at + CURRENT_A], state[at + CURRENT_B], state[at + CURRENT_C])
    f_alpha, f_beta = shape_vector(state[at + ANGLE] + 0.5 * turn, params[pt + SINE])
    gone = -math.expm1(-dt / tau)
    to_alpha, to_beta = (v_alpha - k * omega_rotor * f_alpha) / r, (v_beta - k * omega_rotor * f_beta) / r
    q_alpha, heat_alpha = integrals(i_alpha, to_alpha, dt, gone, tau)
    q_beta, heat_beta = integrals(i_beta, to_beta, dt, gone, tau)
    i_alpha, i_beta = i_alpha + gone * (to_alpha - i_alpha), i_beta + gone * (to_beta - i_beta)
    state[at + CURRENT_A], state[at + CURRENT_B], state[at + CURRENT_C] = inverse_clarke(i_alpha, i_beta)
    impulse = 1.5 * k * (f_alpha * q_alpha + f_beta * q_beta)
    state[at + ANGLE] = wrapped(state[at + ANGLE] + turn)
    state[at + INPUT_J] += 1.5 * (v_alpha * q_alpha + v_beta * q_beta)
    state[at + COPPER_J] += 1.5 * r * (heat_alpha + heat_beta)
    state[at + WORK_J] += impulse * omega_rotor
    return impulse / dt


@leaf
def shape_vector(angle, sine):  # type: ignore[no-untyped-def]
    """(alpha, beta) of F in the three phases at an electrical angle [rad]; what they have in common drives nothing."""
    if sine > 0.5:
        return SINE_PEAK * math.cos(angle - SECTOR), SINE_PEAK * math.sin(angle - SECTOR)
    return clarke(emf_shape(angle, sine), emf_shape(angle - THIRD, sine), emf_shape(angle - 2.0 * THIRD, sine))


@leaf
def fundamental(sine):  # type: ignore[no-untyped-def]
    """F1, amplitude of the first harmonic of F."""
    return SINE_PEAK if sine > 0.5 else TRAPEZOID_PEAK


@leaf
def torque_of_duty(params, pt, duty, bus_v, omega_rotor):  # type: ignore[no-untyped-def]
    """The torque demand [N m] of a board that thinks in duties: what a DC motor of the same R and K would give.

    So the loops of a board serve any drive, and the last word, how much current for how much slack, is the same. A
    duty that is not finite counts as 0, which brakes.
    """
    volts = duty * bus_v if math.isfinite(duty) else 0.0
    k = params[pt + BACK_EMF]
    return k * (volts - k * omega_rotor) / params[pt + RESISTANCE]


@leaf
def _demand(params, pt, torque, angle, turn):  # type: ignore[no-untyped-def]
    """Currents (d, q) that a torque takes now, and (d, q) after the rotor has gone on by `turn` [A]."""
    if not math.isfinite(torque):
        torque = 0.0
    limit, sine, k = params[pt + CURRENT_LIMIT], params[pt + SINE], params[pt + BACK_EMF]
    per_k = torque / (0.75 * k) if k > 0.0 else 0.0
    if params[pt + SHAPED] < 0.5 or sine > 0.5:
        q = min(limit, max(-limit, per_k / fundamental(sine)))
        return 0.0, q, 0.0, q
    d, q = _shaped(per_k, limit, angle, sine)
    next_d, next_q = _shaped(per_k, limit, angle + turn, sine)
    return d, q, next_d, next_q


@leaf
def _shaped(per_k, limit, angle, sine):  # type: ignore[no-untyped-def]
    """(d, q) of the smallest currents with exactly one torque at one angle: along the EMF's own vector [A]."""
    f_alpha, f_beta = shape_vector(angle, sine)
    length = math.sqrt(f_alpha * f_alpha + f_beta * f_beta)
    current = min(limit, max(-limit, per_k / length)) / length
    return park(current * f_alpha, current * f_beta, angle + FLUX)


@leaf
def _known_emf(params, pt, omega, angle):  # type: ignore[no-untyped-def]
    """The EMF (alpha, beta) that is fed forward [V]: the fundamental, or all of it where its shape is known."""
    peak, sine = 0.5 * params[pt + BACK_EMF] * omega, params[pt + SINE]
    if params[pt + SHAPED] > 0.5:
        f_alpha, f_beta = shape_vector(angle, sine)
        return peak * f_alpha, peak * f_beta
    peak *= fundamental(sine)
    return peak * math.cos(angle - SECTOR), peak * math.sin(angle - SECTOR)


@leaf
def speed_step(wanted, omega, held, inertia, viscous, bandwidth):  # type: ignore[no-untyped-def]
    """Torque demand [N m] of a speed loop whose speed follows `wanted` with the time constant 1 / bandwidth.

    A PI controller around a motor that is damped by the loop itself, zero on the damped pole: no overshoot, and a
    load that stays is made up for (Harnefors, Saarakkala, Hinkkanen, "Speed control of electrical drives using
    classical control methods", 2013). `speed_hold` takes the integral on.

    Args:
        wanted: speed [rad/s]; one that is not finite counts as 0.
        omega: speed now [rad/s].
        held: the integral so far [N m].
        inertia, viscous: of all that turns [kg m^2, N m s/rad].
        bandwidth: [rad/s].
    """
    error = (wanted if math.isfinite(wanted) else 0.0) - omega
    return inertia * bandwidth * error + held - (inertia * bandwidth - viscous) * omega


@leaf
def speed_hold(torque, omega, held, inertia, viscous, bandwidth, dt):  # type: ignore[no-untyped-def]
    """The integral [N m] after `dt` [s] with a torque that the drive could really give; arguments of `speed_step`."""
    return held - math.expm1(-bandwidth * dt) * (torque + (inertia * bandwidth - viscous) * omega - held)
