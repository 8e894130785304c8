"""One motor on the bench: a command and a load over time give currents, torque, speed and where the energy goes."""

import math
from dataclasses import dataclass

import numpy as np

from holodrive.actuators.averaged import averaged_substep
from holodrive.actuators.bldc import (
    ANGLE,
    BACK_EMF,
    BANDWIDTH,
    COPPER_J,
    COULOMB,
    CURRENT_A,
    EFFICIENCY,
    GEAR,
    HIGH,
    INERTIA,
    INPUT_J,
    LIMITED,
    LOW,
    SHAPED,
    SINE,
    STATE_SIZE,
    THIRD,
    TURN,
    VISCOUS,
    emf_shape,
    pack_motor,
    sector_of,
    stored_energy,
)
from holodrive.actuators.dc_motor import dry_friction
from holodrive.actuators.foc import foc_substep, speed_hold, speed_step, torque_of_duty
from holodrive.actuators.six_step import six_step_substep
from holodrive.errors import InputError
from holodrive.leaf import leaf
from holodrive.robots.spec import Motor
from holodrive.types import Array

STEP_S = 1e-5  # six-step speeds are right to 0.01 % at this step, and to 0.05 % at five times as much
_AVERAGED, _SIX_STEP, _FOC = 0, 1, 2
_DRIVES = {"averaged": _AVERAGED, "six_step": _SIX_STEP, "foc": _FOC}
_DUTY, _TORQUE, _SPEED = 0, 1, 2
_MODES = {"duty": _DUTY, "torque": _TORQUE, "speed": _SPEED}

# columns of a recorded row
(
    TIME,
    I_A,
    I_B,
    I_C,
    ANGLE_E,
    TORQUE,
    SPEED,
    COPPER,
    GEARBOX,
    FRICTION,
    MECHANICAL,
    ELECTRICAL,
    MAGNETIC,
    KINETIC,
) = range(14)
_COLUMNS = 14


@dataclass(frozen=True, slots=True)
class FocLoops:
    """How a field-oriented drive is set up.

    Attributes:
        current_hz: bandwidth of the current loops; a torque demand is followed with 1 / (2 pi current_hz).
        speed_hz: bandwidth of the speed loop (mode "speed"); keep it below a tenth of the current loops'.
        shaped: whether currents take the EMF's shape and the drive feeds all of it forward; without, both are
            sinusoidal. A sinusoidal motor does not notice.
    """

    current_hz: float = 1000.0
    speed_hz: float = 30.0
    shaped: bool = False


@dataclass(frozen=True, slots=True)
class Traces:
    """What one motor did, in rows of equal length in time; speeds and torques are those of the output shaft.

    Attributes:
        time: (n,) end of each row [s].
        currents: (n, 3) into the phases at the end of the row [A]; a DC motor's current is the first.
        angle: (n,) electrical angle at the end of the row, 0 to 2 pi [rad].
        torque: (n,) electromagnetic torque through the gear's ratio, mean of the row [N m].
        speed: (n,) at the end of the row [rad/s].
        copper_w, gear_w, friction_w: (n,) losses, means of the row; a gear whose efficiency is below 1 has a loss
            below 0 while the load drives the motor, for its torque is scaled alike both ways.
        mechanical_w: (n,) what the load takes; below 0 while it drives.
        electrical_w: (n,) what the supply gives; below 0 while it is fed.
        magnetic_j, kinetic_j: (n,) stored in the phases and in what turns, at the end of the row.
        stored_start_j: both of them at the start.
    """

    time: Array
    currents: Array
    angle: Array
    torque: Array
    speed: Array
    copper_w: Array
    gear_w: Array
    friction_w: Array
    mechanical_w: Array
    electrical_w: Array
    magnetic_j: Array
    kinetic_j: Array
    stored_start_j: float

    @property
    def step_s(self) -> float:
        """Length of a row [s]."""
        return float(self.time[-1] / len(self.time))

    @property
    def stored_j(self) -> Array:
        """(n,) magnetic and kinetic energy together [J]."""
        return self.magnetic_j + self.kinetic_j

    def energy_residual(self) -> float:
        """What the energy balance misses over the whole run, as a part of the energy that went through the terminals.

        Electrical in - copper - gear - friction - mechanical out - growth of what is stored.
        """
        spent = self.copper_w + self.gear_w + self.friction_w + self.mechanical_w
        missed = float(np.sum(self.electrical_w - spent)) * self.step_s - float(self.stored_j[-1] - self.stored_start_j)
        through = max(
            float(np.sum(np.abs(self.electrical_w))) * self.step_s,
            float(np.sum(np.abs(self.mechanical_w))) * self.step_s,
            self.stored_start_j,
        )
        return missed / through if through > 0.0 else missed

    def efficiency(self) -> float:
        """Mechanical energy out over electrical energy in, over the whole run."""
        return float(np.sum(self.mechanical_w) / np.sum(self.electrical_w))


def simulate(
    motor: Motor,
    command: float | Array,
    load_n_m: float | Array = 0.0,
    t_s: float = 0.5,
    dt_s: float = STEP_S,
    *,
    bus_v: float | None = None,
    drive: str | None = None,
    mode: str = "duty",
    loops: FocLoops | None = None,
    inertia_kg_m2: float = 0.0,
    speed_rad_s: float = 0.0,
    angle_rad: float = 0.0,
    every: int = 1,
) -> Traces:
    """Run one motor from a stiff supply.

    Args:
        motor: as described; its values are those behind the gear.
        command: what `mode` says, one number or one for each step; one that is not finite counts as 0.
        load_n_m: torque against positive rotation at the output shaft, one number or one for each step.
        t_s, dt_s: length of the run and of a step.
        bus_v: of the supply; the motor's nominal voltage when None.
        drive: "averaged", "six_step" or "foc"; the motor's own when None. A brushed motor is always "averaged".
        mode: "duty", -1 to 1 (volts / bus_v for a motor that is given a voltage; FOC gives the torque of a DC motor
            at that voltage); with FOC also "torque" [N m] or "speed" [rad/s], both of the output shaft.
        loops: bandwidths of FOC; `FocLoops()` when None.
        inertia_kg_m2: of what the motor turns, at the output shaft, beside its own.
        speed_rad_s: of the output shaft at the start.
        angle_rad: electrical angle at the start.
        every: steps in one row of the traces.

    Raises:
        InputError: a drive or a mode that does not exist here, a motor without any inertia, a run without a whole row.
    """
    packed, loops = pack_motor(motor), loops or FocLoops()
    kind, asked = _kinds(motor, drive, mode)
    packed[BANDWIDTH], packed[SHAPED] = TURN * loops.current_hz, float(loops.shaped)
    gear = packed[GEAR]
    inertia = packed[INERTIA] + inertia_kg_m2 / gear**2
    rows = round(t_s / (dt_s * every))
    if not inertia > 0.0:
        raise InputError(
            f"motor {motor.name!r} and its load have no inertia: give the motor inertia_kg_m2, or `simulate` the load's"
        )
    if rows < 1:
        raise InputError(f"a run of {t_s} s is shorter than one row of {every} steps of {dt_s} s: make t_s longer")
    commands, loads = (_samples(*given, rows * every) for given in (("command", command), ("load_n_m", load_n_m)))
    commands = np.where(np.isfinite(commands), commands, 0.0) * {_DUTY: 1.0, _TORQUE: 1.0 / gear, _SPEED: gear}[asked]
    state, out = np.zeros(STATE_SIZE), np.empty((rows, _COLUMNS))
    state[ANGLE] = angle_rad % (2.0 * math.pi)
    omega = speed_rad_s * gear
    bus, bandwidth = bus_v or motor.voltage_v, TURN * loops.speed_hz
    _run(state, packed, kind, asked, commands, loads / gear, bus, inertia, bandwidth, omega, dt_s, every, out)
    return Traces(
        time=out[:, TIME],
        currents=out[:, I_A : I_C + 1],
        angle=out[:, ANGLE_E],
        torque=gear * out[:, TORQUE],
        speed=out[:, SPEED] / gear,
        copper_w=out[:, COPPER],
        gear_w=out[:, GEARBOX],
        friction_w=out[:, FRICTION],
        mechanical_w=out[:, MECHANICAL],
        electrical_w=out[:, ELECTRICAL],
        magnetic_j=out[:, MAGNETIC],
        kinetic_j=out[:, KINETIC],
        stored_start_j=0.5 * inertia * omega**2,
    )


def _kinds(motor: Motor, drive: str | None, mode: str) -> tuple[int, int]:
    """Numbers of the drive and of the mode."""
    chosen = "averaged" if motor.kind == "dc" else drive or motor.drive
    if chosen not in _DRIVES:
        raise InputError(
            f"motor {motor.name!r}: the bench runs the drives {', '.join(_DRIVES)}, not {chosen!r}; give one as drive="
        )
    if mode not in _MODES:
        raise InputError(f"motor {motor.name!r}: a command is one of {', '.join(_MODES)}, not {mode!r}; see mode=")
    if mode != "duty" and chosen != "foc":
        advice = "a brushed motor has no other drive" if motor.kind == "dc" else "give drive='foc'"
        raise InputError(f"motor {motor.name!r}: the drive {chosen!r} takes a duty, no {mode}; {advice}")
    return _DRIVES[chosen], _MODES[mode]


def _samples(name: str, values: float | Array, steps: int) -> Array:
    given = np.asarray(values, dtype=np.float64)
    if given.ndim > 0 and given.shape != (steps,):
        raise InputError(f"{name} has the shape {given.shape}: give one number, or one for each of the {steps} steps")
    return np.array(np.broadcast_to(given, steps))


@leaf
def _run(state, params, kind, mode, commands, loads, bus_v, inertia, bandwidth, omega, dt, every, out):  # type: ignore[no-untyped-def]
    """All steps of a run, at the rotor. The drive is given the speed that the middle of the step will have."""
    torque, held, step = 0.0, 0.0, 0
    for row in range(out.shape[0]):
        state[INPUT_J] = state[COPPER_J] = 0.0
        mean = gearbox = friction = mechanical = 0.0
        for _ in range(every):
            shaft = params[EFFICIENCY] * torque - loads[step]
            drag = _drag(params, omega)
            middle = omega + 0.5 * dt * (shaft - drag * omega) / (inertia + 0.5 * dt * drag)
            if kind == _SIX_STEP:
                torque = six_step_substep(state, 0, params, 0, commands[step], bus_v, middle, dt)
            elif kind == _FOC and mode == _SPEED:
                torque, held = _at_speed(state, params, commands[step], held, bus_v, inertia, bandwidth, middle, dt)
            elif kind == _FOC:
                wanted = commands[step]
                if mode == _DUTY:
                    wanted = torque_of_duty(params, 0, wanted, bus_v, middle)
                torque = foc_substep(state, 0, params, 0, wanted, bus_v, middle, dt)
            else:
                torque = averaged_substep(state, 0, params, 0, commands[step], bus_v, middle, dt)
            shaft = params[EFFICIENCY] * torque - loads[step]
            drag = _drag(params, middle)
            new = omega + dt * (shaft - drag * omega) / (inertia + 0.5 * dt * drag)
            middle = 0.5 * (omega + new)
            mean += torque / every
            gearbox += (1.0 - params[EFFICIENCY]) * torque * middle / every
            friction += drag * middle * middle / every
            mechanical += loads[step] * middle / every
            omega = new
            step += 1
        seconds = every * dt
        out[row, TIME], out[row, ANGLE_E], out[row, TORQUE], out[row, SPEED] = step * dt, state[ANGLE], mean, omega
        out[row, I_A], out[row, I_B], out[row, I_C] = state[CURRENT_A], state[CURRENT_A + 1], state[CURRENT_A + 2]
        out[row, COPPER], out[row, GEARBOX] = state[COPPER_J] / seconds, gearbox
        out[row, FRICTION], out[row, MECHANICAL] = friction, mechanical
        out[row, ELECTRICAL] = state[INPUT_J] / seconds
        out[row, MAGNETIC], out[row, KINETIC] = stored_energy(state, 0, params, 0), 0.5 * inertia * omega * omega


@leaf
def _at_speed(state, params, wanted, held, bus_v, inertia, bandwidth, omega, dt):  # type: ignore[no-untyped-def]
    """A step of FOC below a speed loop that knows what it turns: torque and the loop's integral, at the rotor [N m]."""
    j, b = inertia / params[EFFICIENCY], params[VISCOUS] / params[EFFICIENCY]
    demand = speed_step(wanted, omega, held, j, b, bandwidth)
    torque = foc_substep(state, 0, params, 0, demand, bus_v, omega, dt)
    given = torque if state[LIMITED] > 0.5 else demand
    return torque, speed_hold(given, omega, held, j, b, bandwidth, dt)


@leaf
def _drag(params, omega):  # type: ignore[no-untyped-def]
    """Viscous and dry friction as one torque per speed at the rotor [N m s/rad]."""
    gear = params[GEAR]
    return params[VISCOUS] + dry_friction(params[COULOMB], omega / gear) / gear


def ripple(torque: Array) -> float:
    """Peak to peak over mean of a torque in steady load; give whole electrical turns, or many."""
    return float((np.max(torque) - np.min(torque)) / abs(np.mean(torque)))


def ideal_six_step_torque(motor: Motor, current_a: float, angle: Array) -> Array:
    """Torque at the output shaft with rectangular currents [N m], as if no phase had inductance.

    The current goes into the phase at the supply and out of the one at ground, sector by sector. A trapezoidal EMF
    gives one torque, K i; a sinusoidal one falls by 1 - cos 30 deg towards each edge: 14 % peak to peak over mean.

    Args:
        motor: any.
        current_a: in the two phases [A].
        angle: (...) electrical [rad].
    """
    packed, flat = pack_motor(motor), np.ravel(np.asarray(angle, dtype=np.float64))
    torque = np.empty_like(flat)
    _ideal(packed, flat, torque)
    return motor.gear * current_a * torque.reshape(np.shape(angle))


@leaf
def _ideal(params, angles, torque):  # type: ignore[no-untyped-def]
    """Torque of 1 A in the two phases of each angle's sector [N m], at the rotor."""
    for n in range(len(angles)):
        sector = sector_of(angles[n])
        f_high = emf_shape(angles[n] - HIGH[sector] * THIRD, params[SINE])
        f_low = emf_shape(angles[n] - LOW[sector] * THIRD, params[SINE])
        torque[n] = 0.5 * params[BACK_EMF] * (f_high - f_low)
