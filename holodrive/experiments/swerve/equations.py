"""Equations 6 to 34: what is printed beside finite differences of the motion, and beside the circuit it describes."""

import math
from typing import Any

import numpy as np

from holodrive.actuators.bldc import pack_motor, phase_derivatives
from holodrive.actuators.machine import simulate
from holodrive.experiments.claims import Claim
from holodrive.experiments.experiment import Result, Setting
from holodrive.experiments.swerve import printed, robots
from holodrive.reports.sections import TableSection
from holodrive.reports.tables import table
from holodrive.robots.spec import Motor
from holodrive.types import Array

STEP_S = 1e-6  # of finite differences
PLACES = ((1.0, 0.0), (-0.5, -(3.0**0.5) / 2.0), (-0.5, 3.0**0.5 / 2.0))  # wheels at 0, 240 and 120 degrees, / L

# The state at which the motor's equations are compared: currents [A], rotor speed [rad/s], electrical angle, terminal
# voltages [V], load [N m]
CURRENTS, OMEGA, ANGLE, VOLTS, LOAD = (3.0, -2.0, -1.0), 200.0, math.radians(80.0), (20.0, 0.0, 12.0), 0.01


def equations(setting: Setting) -> Result:
    """Claims about kinematics and motor model."""
    claims = (*_rigid_body(), *_wheels(), *_places(), *_steering(), *_motor(), *_state_space())
    return Result(claims, (_motor_table(),), data=_data())


# --- kinematics ----------------------------------------------------------------------------------


def velocity(point: tuple[float, float], pose: Array, world: Array) -> Array:
    """(2,) velocity, in body axes, of a point of the body [m], by central differences of where it is.

    Args:
        pose: x, y, heading [m, m, rad]; world: their rates.
    """

    def at(t: float) -> Array:
        x, y, theta = pose + t * world
        c, s = math.cos(theta), math.sin(theta)
        return np.array([x + c * point[0] - s * point[1], y + s * point[0] + c * point[1]])

    c, s = math.cos(pose[2]), math.sin(pose[2])
    return np.array([[c, s], [-s, c]]) @ (at(STEP_S) - at(-STEP_S)) / (2.0 * STEP_S)


def rows(places: tuple[tuple[float, float], ...]) -> Array:
    """(2 n, 3) rows [1 0 -y], [0 1 x] of Eq. 17."""
    return np.array([row for x, y in places for row in ((1.0, 0.0, -y), (0.0, 1.0, x))])


def chord_speed(lever_m: float, omega: float, duration_s: float) -> float:
    """|omega x chord| of Eq. 6 as printed: the chord that B runs through in that time [m/s]."""
    return omega * 2.0 * lever_m * math.sin(0.5 * omega * duration_s)


def _rigid_body() -> list[Claim]:
    lever, omega = 0.3, 2.0
    moving = velocity((lever, 0.0), np.zeros(3), np.array([0.0, 0.0, omega]))
    note = (
        f"a point {lever:g} m from A, ω = {omega:g} rad/s, chord of 0.1 s; with that of 1 ms the printed form gives "
        f"{chord_speed(lever, omega, 1e-3):.4f}: it goes to 0 with the time step. Ours: finite differences, and "
        "ω × r of B from A, as in Eq. 7"
    )
    return [
        Claim("Eq. 6", "speed of B about A", chord_speed(lever, omega, 0.1), float(np.hypot(*moving)),
              "contradicts itself", "m/s", note),
        Claim("Eq. 16", "sizes of what is added", "2-vector + 3-vector", "2-vectors", "cannot be",
              note="the zero of the third row does not belong there; Eq. 17 is right"),
    ]  # fmt: skip


def largest_miss(matrix: Array, places: tuple[tuple[float, float], ...], count: int = 200) -> float:
    """Largest difference between rows times twist and finite differences, over random poses and rates [m/s]."""
    random, worst = np.random.default_rng(4), 0.0
    for _ in range(count):
        pose, world = random.uniform(-3.0, 3.0, 3), random.uniform(-2.0, 2.0, 3)
        c, s = math.cos(pose[2]), math.sin(pose[2])
        twist = np.array([c * world[0] + s * world[1], c * world[1] - s * world[0], world[2]])
        true = np.concatenate([velocity(place, pose, world) for place in places])
        worst = max(worst, float(np.max(np.abs(matrix @ twist - true))))
    return worst


def _wheels() -> list[Claim]:
    right, as_18 = rows(PLACES), rows(PLACES)
    as_18[3, 2] = PLACES[1][1]
    note = "200 random motions, wheels 1 m from the centre"
    return [
        Claim("Eq. 8 to 17", "largest miss of finite differences", None, largest_miss(right, PLACES), "agrees", "m/s",
              note),
        Claim("Eq. 18", "row 4 at ω = 1 rad/s", as_18[3, 2], float(right[3, 2]), "contradicts itself", "m/s",
              f"[0 1 y₂] is printed for [0 1 x₂], which Eq. 17 gives; misses by {largest_miss(as_18, PLACES):.2f} m/s "
              f"over {note}"),
    ]  # fmt: skip


def _places() -> list[Claim]:
    as_19, right = rows(printed.EQ_19_PLACES), rows(PLACES)
    bearings = [", ".join(f"{math.degrees(math.atan2(y, x)) % 360.0:.0f}" for x, y in places) + "°"
                for places in (printed.EQ_19_PLACES, PLACES)]  # fmt: skip
    return [
        Claim("Eq. 19", "lateral row of wheel 2 at ω = 1 rad/s, L = 1 m", as_19[3, 2], float(right[3, 2]), "differs",
              "m/s", f"wheels at {bearings[0]} are printed; evenly spread wheels stand at {bearings[1]}. On these "
              f"the printed rows miss finite differences by {largest_miss(as_19, PLACES):.2f} m/s"),
        Claim("Eq. 19", "condition of the rows", condition(as_19), condition(right), "differs",
              note="printed wheels 2 and 3 are opposite each other; AᵀA is not diagonal, and a turn is seen as motion "
              "aside"),
        Claim("Eq. 19", "sum of the lateral column, / L", float(as_19[1::2, 2].sum()), float(right[1::2, 2].sum()),
              "differs", note="0 where the body's point is the centre of the wheels"),
    ]  # fmt: skip


def condition(matrix: Array) -> float:
    """Of rows with L = 1."""
    return float(np.linalg.cond(matrix))


def driven_back(count: int = 360) -> float:
    """Share of all wheel directions that arctan and Eq. 21 together drive the other way [1]."""
    angle = (np.arange(count) + 0.5) * 2.0 * math.pi / count
    x, y = np.cos(angle), np.sin(angle)
    alpha = np.arctan(y / x)
    return float(np.mean(x * np.cos(alpha) + y * np.sin(alpha) < 0.0))


def _steering() -> list[Claim]:
    x, y = -1.0, 1.0
    return [
        Claim("Eq. 20", "steering angle for a wheel velocity (−1, 1) m/s", math.degrees(math.atan(y / x)),
              math.degrees(math.atan2(y, x)), "contradicts itself", "°",
              "arctan loses the quadrant, and Eq. 21 gives no sign: the wheel drives the other way; at ẋ = 0 it is ∞"),
        Claim("Eq. 20, 21", "directions that are driven backwards", None, 100.0 * driven_back(), "not printed", "%",
              "all with ẋ < 0; atan2 has none"),
    ]  # fmt: skip


# --- motor ---------------------------------------------------------------------------------------


def motor() -> Motor:
    """The motor at its rotor, without its gear."""
    return robots.BLDC.robot.wheels[0].motor


def constants() -> tuple[float, float]:
    """R and L of one phase [ohm, H]."""
    return 0.5 * motor().resistance_ohm, 0.5 * motor().inductance_h


def emf() -> Array:
    """(3,) back-EMF of Eq. 26 to 28 at the state compared [V]."""
    half = 0.5 * motor().back_emf_v_s_rad / motor().gear
    f = np.array([1.0, -1.0 / 3.0, -1.0])  # the trapezoid at 80, 320 and 200 degrees
    return np.asarray(half * OMEGA * f)


def by_circuit() -> Array:
    """(2,) rates of i_a and i_b out of Eq. 22 and 23 with i_c = -i_a - i_b [A/s]."""
    r, inductance = constants()
    i, e, v = np.array(CURRENTS), emf(), np.array(VOLTS)
    u = v - r * i - e
    return np.asarray(np.linalg.solve(inductance * np.array([[1.0, -1.0], [1.0, 2.0]]), [u[0] - u[1], u[1] - u[2]]))


def by_model() -> Array:
    """(4,) rates of i_a, i_b, speed and angle of the motor model that is simulated here."""
    found = phase_derivatives(pack_motor(motor()), 0, CURRENTS[0], CURRENTS[1], OMEGA, ANGLE, *VOLTS, LOAD)
    return np.array(found)


def by_equation(coefficients: tuple[float, ...], current: float) -> float:
    """Eq. 30 or 31 as printed [A/s]."""
    r, inductance = constants()
    return float(coefficients[0] * r * current + np.dot(coefficients[1:], [*emf(), *VOLTS])) / inductance


def by_state_space() -> Array:
    """(2,) rates of i_a and i_b of Eq. 34, read with a derivative on its left [A/s]."""
    r, inductance = constants()
    u = np.array(VOLTS) - emf()
    lines = np.array([u[0] - u[1], u[1] - u[2]])
    return np.asarray(
        (printed.EQ_34_RESISTIVE * r * np.array(CURRENTS[:2]) + np.array(printed.EQ_34_INPUT) @ lines) / inductance
    )


def locked_current() -> tuple[float, float]:
    """Current of two phases in series at a locked rotor: by Eq. 30 at rest, and on the simulated motor [A]."""
    r, volts = constants()[0], motor().voltage_v
    middle = 0.5 * volts  # of the open phase, so that it has no current
    as_printed = float(np.dot(printed.EQ_30[4:], [volts, 0.0, middle])) / (-printed.EQ_30[0] * r)
    held = simulate(motor(), 1.0, t_s=0.01, drive="six_step", inertia_kg_m2=1e6, every=100)
    return as_printed, float(held.currents[-1].max())


def _motor() -> list[Claim]:
    circuit, model = by_circuit(), by_model()
    said = by_equation(printed.EQ_30, CURRENTS[0]), by_equation(printed.EQ_31, CURRENTS[1])
    locked = locked_current()
    off = float(np.max(np.abs(model[:2] / circuit - 1.0)))
    note = f"−3R i/L is printed for −R i/L; ours from Eq. 22 and 23, and the simulated model equals it to {off:.0e}"
    return [
        Claim("Eq. 30", "di_a/dt at the state below", said[0], float(circuit[0]), "contradicts itself", "A/s", note),
        Claim("Eq. 31", "di_b/dt", said[1], float(circuit[1]), "contradicts itself", "A/s"),
        Claim("Eq. 30", "current at a locked rotor, 24 V across two phases", *locked, "contradicts itself", "A",
              "ours: simulated, 24 V / 1.03 Ω"),
        Claim("Eq. 22 to 24", "independent equations", 3.0, float(np.linalg.matrix_rank(
            [[1.0, -1.0, 0.0], [0.0, 1.0, -1.0], [-1.0, 0.0, 1.0]])), "contradicts itself",
              note="their sum is 0 = 0; the third is i_a + i_b + i_c = 0, which is not printed"),
    ]  # fmt: skip


def _state_space() -> list[Claim]:
    circuit, said = by_circuit(), by_state_space()
    accelerations = friction_readings()
    return [
        Claim("Eq. 34", "di_a/dt", float(said[0]), float(circuit[0]), "contradicts itself", "A/s",
              "inputs are multiplied by [2 2; −2 2]/3L; right is [2 1; −1 1]/3L"),
        Claim("Eq. 34", "di_b/dt", float(said[1]), float(circuit[1]), "contradicts itself", "A/s"),
        Claim("Eq. 34", "resistive term, / (R i/L)", printed.EQ_30[0], printed.EQ_34_RESISTIVE, "contradicts itself",
              note="−3 in Eq. 30 and 31, −1 in Eq. 34, which is said to follow from them; −1 is right"),
        Claim("Eq. 34", "left side", "x", "dx/dt", "cannot be", note="the derivative is missing; T_e and E at the "
              "right depend on the state, so that it is no linear system either"),
        Claim("Eq. 25, 32, 34", "names of viscous friction", ", ".join(printed.FRICTION), "one constant",
              "contradicts itself",
              note=f"read as one, all three give dω/dt = {accelerations[0]:.1f} rad/s²; no value is printed"),
    ]  # fmt: skip


def friction_readings() -> tuple[float, float, float]:
    """Acceleration of the rotor by Eq. 25, 32 and 34 when their frictions are one constant [rad/s^2]."""
    packed, e = motor(), emf()
    torque = float(np.dot(e, CURRENTS)) / OMEGA
    inertia = packed.inertia_kg_m2 / packed.gear**2
    b = packed.viscous_friction_n_m_s_rad / packed.gear**2
    return (
        (torque - LOAD - b * OMEGA) / inertia,
        -b * OMEGA / inertia + (torque - LOAD) / inertia,
        float(np.dot([-b / inertia, 1.0 / inertia], [OMEGA, torque - LOAD])),
    )


def _motor_table() -> TableSection:
    circuit, model, said = by_circuit(), by_model(), by_state_space()
    found: list[dict[str, Any]] = [
        {"from": "Eq. 22, 23 and i_a + i_b + i_c = 0", "rate of a, A/s": circuit[0], "rate of b, A/s": circuit[1]},
        {"from": "simulated model", "rate of a, A/s": model[0], "rate of b, A/s": model[1]},
        {"from": "Eq. 30, 31 as printed", "rate of a, A/s": by_equation(printed.EQ_30, CURRENTS[0]),
         "rate of b, A/s": by_equation(printed.EQ_31, CURRENTS[1])},
        {"from": "Eq. 34 as printed", "rate of a, A/s": said[0], "rate of b, A/s": said[1]},
    ]  # fmt: skip
    r, inductance = constants()
    note = (
        f"i = {_three(CURRENTS)} A, e = {_three(emf())} V, v = {_three(VOLTS)} V, R = {r:g} Ω, "
        f"L = {1e3 * inductance:g} mH of one phase."
    )
    return TableSection("The motor's equations at one state", table(found), note)


def _three(values: Any) -> str:
    return ", ".join(f"{value:.3g}" for value in values).replace("-", "−")


def _data() -> dict[str, Any]:
    return {
        "circuit": by_circuit().tolist(),
        "model": by_model().tolist(),
        "eq_34": by_state_space().tolist(),
        "locked_a": list(locked_current()),
        "condition": [condition(rows(printed.EQ_19_PLACES)), condition(rows(PLACES))],
    }
