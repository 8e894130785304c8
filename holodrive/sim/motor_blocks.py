"""The motors of a robot as the plant "motors" reads them: a block of numbers for each drive, then for each steering."""

import math

import numpy as np

from holodrive.actuators.bldc import INDUCTANCE, RESISTANCE, pack_motor
from holodrive.errors import InputError
from holodrive.robots.spec import Motor, Robot, Steering
from holodrive.types import Array

ELECTRIC = 0  # 16: the motor at its rotor, `actuators.bldc.pack_motor`
KIND = 16  # SERVO, or how the motor is fed
NOMINAL = 17  # V that duty 1 means to the board
KP, KD = 18, 19  # V/rad, V s/rad of a steering's loop
AHEAD = 20  # V s/rad that holds a steering rate: back-EMF and viscous friction
RATE = 21  # rad/s, fastest steering
INERTIA = 22  # kg m^2 at the output shaft: rotor, gear and module, without the robot's body
VISCOUS, COULOMB = 23, 24  # N m s/rad, N m at the output shaft
COUPLING = 25  # turns of the drive per turn of the steering
PLACE = 26  # number of the wheel
BLOCK = 27

SERVO, AVERAGED, SIX_STEP, FOC = -1, 0, 1, 2
KINDS = {"averaged": AVERAGED, "six_step": SIX_STEP, "foc": FOC}
_FINE_S, _COARSE_S = 2e-5, 1e-4  # longest sub-step with and without commutation
_STIFF = 0.5  # most that back-EMF may change a speed within one sub-step, as a part of it
_LEAST_LAG_S = 1e-7  # L / R: a winding without inductance would have no current to integrate


def pack(robot: Robot) -> Array:
    """All blocks in a row: n drives, m steerings; a steering without a motor is a `SERVO`."""
    drives = [_block(wheel.motor, i, wheel.steering) for i, wheel in enumerate(robot.wheels)]
    return np.concatenate(drives + [_steering(robot, i) for i in robot.steered])


def check(robot: Robot) -> None:
    """Refuse what the plant cannot simulate.

    Raises:
        InputError: a motor without inertia, or fed in a way that the plant does not know.
    """
    for name, motor, inertia in _motors(robot):
        drive = _drive(motor)
        if drive not in KINDS:
            raise InputError(
                f"the {name} of {robot.name} is fed by {drive!r}, which the plant motors does not simulate; "
                f"choose one of {', '.join(KINDS)}"
            )
        if not inertia > 0.0:
            raise InputError(
                f"the {name} of {robot.name} has no inertia, so that the plant motors cannot tell how it speeds up; "
                "give its motor 'inertia', or choose the plant first_order or slip"
            )


def substeps(robot: Robot, dt_s: float) -> int:
    """Sub-steps of a physics step [s]: 20 us where a motor commutates, else 100 us, and as many as are stable."""
    longest = _COARSE_S
    for _, motor, inertia in _motors(robot):
        if _drive(motor) != "averaged":
            longest = min(longest, _FINE_S)
        pull = motor.efficiency * motor.back_emf_v_s_rad**2 / motor.resistance_ohm
        if inertia > 0.0 and pull > 0.0:
            longest = min(longest, _STIFF * inertia / pull)
    return max(1, math.ceil(dt_s / longest - 1e-9))


def _motors(robot: Robot) -> list[tuple[str, Motor, float]]:
    """What it is, the motor, and the inertia at its output shaft [kg m^2]."""
    found = []
    for wheel in robot.wheels:
        found.append((f"drive of wheel {wheel.name}", wheel.motor, wheel.motor.inertia_kg_m2))
        servo = wheel.steering
        if servo and servo.motor:
            found.append(
                (f"steering of wheel {wheel.name}", servo.motor, servo.motor.inertia_kg_m2 + servo.inertia_kg_m2)
            )
    return found


def _drive(motor: Motor) -> str:
    return motor.drive if motor.kind == "bldc" else "averaged"


def _block(motor: Motor, place: int, steering: Steering | None) -> Array:
    block = np.zeros(BLOCK)
    packed = pack_motor(motor)
    packed[INDUCTANCE] = max(packed[INDUCTANCE], _LEAST_LAG_S * packed[RESISTANCE])
    block[: len(packed)] = packed
    block[KIND], block[NOMINAL], block[PLACE] = KINDS.get(_drive(motor), AVERAGED), motor.voltage_v, place
    block[INERTIA] = motor.inertia_kg_m2
    block[VISCOUS], block[COULOMB] = motor.viscous_friction_n_m_s_rad, motor.coulomb_friction_n_m
    block[COUPLING] = steering.coupling if steering else 0.0
    return block


def _steering(robot: Robot, place: int) -> Array:
    servo = robot.wheels[place].steering or Steering()
    motor = servo.motor
    if motor is None:
        block = np.zeros(BLOCK)
        block[KIND], block[PLACE] = SERVO, place
    else:
        block = _block(motor, place, servo)
        block[INERTIA] += servo.inertia_kg_m2
        pull = max(motor.efficiency * motor.back_emf_v_s_rad, 1e-12)
        block[AHEAD] = motor.back_emf_v_s_rad + motor.resistance_ohm * motor.viscous_friction_n_m_s_rad / pull
    block[KP], block[KD], block[RATE] = servo.kp_v_rad, servo.kd_v_s_rad, servo.rate_rad_s
    return block
