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
    CURRENT_A,
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
    THIRD,
    WORK_J,
    emf_shape,
    wrapped,
)
from holodrive.leaf import leaf

_PIECES = 32  # most cuts of one sub-step; the last takes what is left
_INSTANT = 1e-12  # s, a piece that is not worth its own


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
    sector = int(math.floor(middle)) % 6
    high, low, free = HIGH[sector], LOW[sector], FLOATING[sector]
    if duty < 0.0:
        high, low = low, high
    k, r, l = 0.5 * params[pt + BACK_EMF], 0.5 * params[pt + RESISTANCE], 0.5 * params[pt + INDUCTANCE]
    angle, sine = SECTOR * middle, params[pt + SINE]
    f_h, f_l, f_f = emf_shape(angle - high * THIRD, sine), emf_shape(angle - low * THIRD, sine), 0.0
    f_f = emf_shape(angle - free * THIRD, sine)
    e_h, e_l, e_f = k * omega * f_h, k * omega * f_l, k * omega * f_f
    i_h, i_l, i_f = state[at + high], state[at + low], state[at + free]

    # the leg's voltage, lowered or raised so far that the driver's current limit holds at the end of the piece
    gone = -math.expm1(-h * r / l)  # 1 - exp(-h R / L)
    v_h = _limited(
        abs(duty) * bus_v, bus_v, i_h, i_l, e_h, e_l, e_f, i_f, gone / r, 1.0 - gone, params[pt + CURRENT_LIMIT]
    )  # fmt: skip

    # the open phase: at ground while its current flows in, at the supply while it flows out, else off
    v_open = 0.5 * (v_h - e_h - e_l) + e_f
    on_supply = i_f < 0.0 or (i_f == 0.0 and v_open > bus_v)
    conducts = i_f != 0.0 or on_supply or v_open < 0.0
    v_f = bus_v if on_supply else 0.0
    if conducts:
        neutral = (v_h + v_f - e_h - e_l - e_f) / 3.0
        u_h, u_l, u_f = v_h - e_h - neutral, -e_l - neutral, v_f - e_f - neutral
    else:
        u_h = 0.5 * (v_h - e_h + e_l)
        u_l, u_f = -u_h, 0.0

    ends = i_f != 0.0 and i_f * (i_f * (1.0 - gone) + gone / r * u_f) <= 0.0
    if ends:  # i exp(-t R / L) + (1 - exp(-t R / L)) u / R = 0
        gone = r * i_f / (r * i_f - u_f)
        h = min(h, -math.log1p(-gone) * l / r)

    rest = 1.0 - gone
    q_h, heat_h = _integrals(i_h, u_h / r, h, gone, rest, l / r)
    q_l, heat_l = _integrals(i_l, u_l / r, h, gone, rest, l / r)
    q_f, heat_f = _integrals(i_f, u_f / r, h, gone, rest, l / r)
    i_h = i_h * rest + gone / r * u_h
    i_f = 0.0 if ends or not conducts else i_f * rest + gone / r * u_f
    state[at + high], state[at + free], state[at + low] = i_h, i_f, -i_h - i_f
    state[at + INPUT_J] += v_h * q_h + v_f * q_f
    state[at + COPPER_J] += r * (heat_h + heat_l + heat_f)
    return h, k * (f_h * q_h + f_l * q_l + f_f * q_f)


@leaf
def _integrals(i, final, h, gone, rest, tau):  # type: ignore[no-untyped-def]
    """Charge [C] and integral of the square [A^2 s] of a current on its way from `i` towards `final`."""
    gap = i - final
    charge = final * h + gap * tau * gone
    return charge, final * final * h + gap * tau * gone * (2.0 * final + 0.5 * gap * (1.0 + rest))


@leaf
def _limited(v, bus_v, i_h, i_l, e_h, e_l, e_f, i_f, gain, rest, limit):  # type: ignore[no-untyped-def]
    """The high leg's voltage [V], 0 to `bus_v`, with which neither driven current ends beyond `limit` [A]."""
    if not limit < math.inf:
        return v
    if i_f != 0.0:
        others, share = (0.0 if i_f > 0.0 else bus_v) - e_l - e_f, 1.0 / 3.0
        on_h, on_l = 2.0 * share * (v - e_h) - share * others, -e_l - share * (v - e_h + others)
    else:
        share = 0.5
        on_h = share * (v - e_h + e_l)
        on_l = -on_h
    end_h, end_l = i_h * rest + gain * on_h, i_l * rest + gain * on_l
    slope_h, slope_l = gain * (1.0 - share), gain * share
    over = max(0.0, abs(end_h) - limit)
    if over > 0.0:
        change = -math.copysign(over, end_h) / slope_h
        v += change
        end_l -= slope_l * change
    over = max(0.0, abs(end_l) - limit)
    if over > 0.0:
        v += math.copysign(over, end_l) / slope_l
    return min(bus_v, max(0.0, v))
