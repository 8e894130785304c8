"""Six-step commutation: two phases at the supply, the third at its diodes.

Hall sensors tell the sector of 60 degrees; one phase is switched to the supply with a duty (averaged over the PWM
period, both switches of the leg in turn, so current flows either way), one to ground, one is open. The current that
an open phase still carries goes on through a diode, from ground (i > 0) or into the supply (i < 0), until it is 0;
an open phase whose terminal is driven beyond a rail by its back-EMF conducts likewise.

One sub-step is cut at every Hall edge and where the open phase's current ends. Inside a piece voltages are constant
and the back-EMF is that of its middle, so currents are exponentials, integrated exactly: stable at any step, and what
the supply gives equals copper loss, work and stored energy to rounding.
"""

import math

from holodrive.actuators.bldc import (
    ANGLE,
    BACK_EMF,
    COPPER_J,
    CURRENT_LIMIT,
    FLOATING,
    HIGH,
    INDUCTANCE,
    INPUT_J,
    LOW,
    PAIRS,
    RESISTANCE,
    SECTOR,
    SINE,
    SINE_PEAK,
    WORK_J,
    integrals,
    wrapped,
)
from holodrive.leaf import leaf

_PIECES = 32  # most cuts of one sub-step; the last takes what is left
_INSTANT = 1e-12  # of a sub-step: a piece that is not worth its own
_CORRECTIONS = 3  # of a voltage by the current limit; each is exact where two phases conduct


@leaf
def six_step_substep(state, at, params, pt, duty, bus_v, omega_rotor, dt):  # type: ignore[no-untyped-def]
    """Drive one motor for one sub-step (10 to 20 us) at constant rotor speed.

    Args:
        state, at: states and where this motor's `bldc.STATE_SIZE` numbers begin; currents, angle and sums go on.
        params, pt: packed motors and where this one begins (`bldc.pack_motor`).
        duty: -1 to 1; below 0 high and low change places. 0 holds both driven phases at ground: a brake.
        bus_v: of the supply [V].
        omega_rotor: rotor speed, of the middle of the sub-step where it is known [rad/s].
        dt: [s].

    Returns:
        Electromagnetic torque at the rotor, mean of the sub-step [N m]; before friction and gear.
    """
    electrical = params[pt + PAIRS] * omega_rotor / SECTOR  # sectors a second
    place = state[at + ANGLE] / SECTOR
    left, impulse = dt, 0.0
    for piece in range(_PIECES):
        h = left if piece == _PIECES - 1 else min(left, _to_edge(place, electrical))
        middle = place + 0.5 * electrical * h
        taken, gained = _piece(state, at, params, pt, duty, bus_v, omega_rotor, middle, h)
        impulse += gained
        left -= taken
        place += electrical * taken
        if left <= _INSTANT * dt:
            break
    state[at + ANGLE] = wrapped(SECTOR * place)
    state[at + WORK_J] += impulse * omega_rotor
    return impulse / dt


@leaf
def _to_edge(place, rate):  # type: ignore[no-untyped-def]
    """Time [s] until an angle that is counted in sectors and moves at `rate` passes the next Hall edge."""
    if rate > 0.0:
        return (math.floor(place) + 1.0 - place) / rate
    if rate < 0.0:
        return (math.ceil(place) - 1.0 - place) / rate
    return math.inf


@leaf
def _piece(state, at, params, pt, duty, bus_v, omega, middle, h):  # type: ignore[no-untyped-def]
    """Currents over at most `h` within one sector; returns the time taken [s] and the torque's impulse [N m s]."""
    turned = math.floor(middle)
    sector = turned % 6
    high, low, free = HIGH[sector], LOW[sector], FLOATING[sector]
    f_h, f_l, f_f = _shapes(sector, middle - turned, params[pt + SINE])
    if duty < 0.0:
        high, low, f_h, f_l = low, high, f_l, f_h
    k, r, tau = 0.5 * params[pt + BACK_EMF], 0.5 * params[pt + RESISTANCE], params[pt + INDUCTANCE]
    tau /= params[pt + RESISTANCE]
    e_h, e_l, e_f = k * omega * f_h, k * omega * f_l, k * omega * f_f
    i_h, i_l, i_f = state[at + high], state[at + low], state[at + free]

    # the open phase: at ground while its current flows in, at the supply while it flows out, else off
    gone = -math.expm1(-h / tau)
    limit = params[pt + CURRENT_LIMIT]
    v = abs(duty) * bus_v
    if limit < math.inf:
        v_f = bus_v if i_f < 0.0 else 0.0
        v = _limited(v, bus_v, i_h, i_l, e_h, e_l, v_f - e_f, i_f != 0.0, gone, r, limit)
    v_open = 0.5 * (abs(v) - e_h - e_l) + e_f
    on_supply = i_f < 0.0 or (i_f == 0.0 and v_open > bus_v)
    conducts = i_f != 0.0 or on_supply or v_open < 0.0
    v_f = bus_v if on_supply else 0.0
    if limit < math.inf and conducts and i_f == 0.0:
        v = _limited(v, bus_v, i_h, i_l, e_h, e_l, v_f - e_f, True, gone, r, limit)

    v_h, v_l = max(v, 0.0), max(-v, 0.0)
    if conducts:
        neutral = (v_h + v_l + v_f - e_h - e_l - e_f) / 3.0
        u_h, u_l, u_f = v_h - e_h - neutral, v_l - e_l - neutral, v_f - e_f - neutral
        conducts = i_f != 0.0 or (u_f < 0.0) == on_supply  # a limit may have taken the diode's voltage away
    if not conducts:
        u_h = 0.5 * (v - e_h + e_l)
        u_l, u_f = -u_h, 0.0

    g = 1.0 / r
    to_h, to_l, to_f = g * u_h, g * u_l, g * u_f  # the currents that these voltages would end at [A]
    ends = i_f != 0.0 and i_f * (i_f + gone * (to_f - i_f)) <= 0.0
    if ends:  # to_f + (i_f - to_f) exp(-t / tau) = 0
        gone = i_f / (i_f - to_f)
        h = min(h, -math.log1p(-gone) * tau)

    q_h, heat_h = integrals(i_h, to_h, h, gone, tau)
    q_l, heat_l = integrals(i_l, to_l, h, gone, tau)
    q_f, heat_f = integrals(i_f, to_f, h, gone, tau)
    i_h += gone * (to_h - i_h)
    i_f = 0.0 if ends or not conducts else i_f + gone * (to_f - i_f)
    state[at + high], state[at + free], state[at + low] = i_h, i_f, -i_h - i_f
    state[at + INPUT_J] += v_h * q_h + v_l * q_l + v_f * q_f
    state[at + COPPER_J] += r * (heat_h + heat_l + heat_f)
    return h, k * (f_h * q_h + f_l * q_l + f_f * q_f)


@leaf
def _shapes(sector, part, sine):  # type: ignore[no-untyped-def]
    """F of the phases that the table calls high, low and floating, a part 0 to 1 into a sector (`bldc.emf_shape`)."""
    if sine > 0.5:
        first, second = SINE_PEAK * math.cos(SECTOR * (1.0 - part)), SINE_PEAK * math.cos(SECTOR * part)
        f_h, f_l = (first, -second) if sector % 2 == 0 else (second, -first)
        return f_h, f_l, -f_h - f_l
    falling = 1.0 - 2.0 * part
    return 1.0, -1.0, falling if sector % 2 == 0 else -falling


@leaf
def _limited(v, bus_v, i_h, i_l, e_h, e_l, u_f, three, gone, r, limit):  # type: ignore[no-untyped-def]
    """The voltage from high to low with which neither driven current ends beyond `limit` [V].

    Args:
        v: asked for, the high leg's over the low one's [V]; the answer may be below 0 (the low leg's over the high
            one's), for against its own EMF a motor draws more than the limit at 0 V.
        bus_v: of the supply [V].
        i_h, i_l: driven currents at the start [A].
        e_h, e_l: their EMFs [V].
        u_f: voltage over the open phase but for the neutral's, counts where it conducts [V].
        three: whether it does.
        gone: share of the way to the final currents.
        r: of a phase [ohm].
        limit: [A].
    """
    gain, rest = gone / r, 1.0 - gone
    for _ in range(_CORRECTIONS):
        u_h, u_l = max(v, 0.0) - e_h, max(-v, 0.0) - e_l
        neutral = (u_h + u_l + u_f) / 3.0 if three else 0.5 * (u_h + u_l)
        end_h, end_l = i_h * rest + gain * (u_h - neutral), i_l * rest + gain * (u_l - neutral)
        over_h, over_l = abs(end_h) - limit, abs(end_l) - limit
        if over_h <= 0.0 and over_l <= 0.0:
            break
        own = gain * (2.0 / 3.0 if three else 0.5)  # of the leg that is switched; the other's current moves by the rest
        other = gain * (1.0 / 3.0 if three else 0.5)
        if over_h >= over_l:
            v -= math.copysign(over_h, end_h) / (own if v > 0.0 else other)
        else:
            v += math.copysign(over_l, end_l) / (other if v > 0.0 else own)
        v = min(bus_v, max(-bus_v, v))
    return v
