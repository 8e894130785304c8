"""The motors' data: references [28] and [29], both readings of the inductance, energy, averaged against six-step."""

import math
from functools import cache
from typing import Any

import numpy as np

from holodrive.actuators.machine import simulate
from holodrive.experiments.claims import Claim
from holodrive.experiments.experiment import Result, Setting
from holodrive.experiments.swerve import printed, robots
from holodrive.reports.sections import TableSection
from holodrive.reports.tables import table
from holodrive.robots.spec import Motor
from holodrive.types import Array

RPM = 30.0 / math.pi
LOADS = (0.0, 0.02, 0.05)  # N m at the rotor


def motors(setting: Setting) -> Result:
    """Claims about the motors."""
    claims = (*_sources(), *_transfer(), *_limits(), _energy(), *_averaged())
    return Result(claims, (_parameters(), _speeds()), data=_data())


def coefficients(inductance_h: float) -> Array:
    """(4,) numerator and denominator (s^2, s, 1) of speed over voltage, times 1000, of the motor of [29]."""
    m = printed.DC_MOTOR
    return 1e3 * np.array(
        [
            m["K"],
            inductance_h * m["J"],
            inductance_h * m["D"] + m["Ra"] * m["J"],
            m["Ra"] * m["D"] + m["K"] * m["Kb"],
        ]
    )


def gain_rpm_per_volt() -> float:
    """Of the motor of [29], at any inductance."""
    k, _, _, last = coefficients(0.0)
    return float(k / last * RPM)


def largest_position_gain(inductance_h: float) -> float:
    """Of a proportional position loop that is still stable, by Routh's test [V/rad]."""
    k, a2, a1, a0 = coefficients(inductance_h)
    return float(a1 * a0 / (k * a2))


def slowest_decay(inductance_h: float, gain_v_rad: float) -> float:
    """Largest real part of the poles of that loop [1/s]; above 0 it swings itself up."""
    k, a2, a1, a0 = coefficients(inductance_h)
    return float(np.max(np.roots([a2, a1, a0, k * gain_v_rad]).real))


@cache
def power_to_shaft() -> float:
    """Share of the DC motor's EMF power that reaches its shaft, on the simulated motor under load [1]."""
    motor = robots.DC_MILLI.robot.wheels[0].motor
    traces = simulate(motor, 0.5, 0.02, t_s=1.0, dt_s=1e-4, every=100)
    air_gap = traces.electrical_w[-10:] - traces.copper_w[-10:]
    return float(1.0 - np.mean(traces.gear_w[-10:]) / np.mean(air_gap))


@cache
def rotor_rpm(drive: str, load_n_m: float) -> float:
    """Steady speed of the BLDC rotor at full voltage [rpm]; the load is the rotor's."""
    motor = robots.BLDC.robot.wheels[0].motor
    every = 1000
    traces = simulate(motor, 1.0, load_n_m * motor.gear, t_s=0.4, drive=drive, every=every)
    return float(np.mean(traces.speed[-10:]) * motor.gear * RPM)


def _sources() -> list[Claim]:
    bldc = robots.BLDC.robot.wheels[0].motor
    return [
        Claim("reference [28]", "data of the BLDC motor", "not printed", "a published flat motor", "not comparable",
              note=f"the article was not found; ours: 16 poles, 24 V, 1.03 Ω, 0.572 mH, 33.5 mN m/A, 9:1, which turns "
              f"the free wheel at {bldc.no_load_speed_rad_s * RPM:.0f} rpm"),
        Claim("section 3", "supply, wheel radius, L, gains, time step, mass", "not printed", "assumed",
              "not comparable", note="r 0.1 m and L 0.3 m; 7 s and 700 rpm of the text belong together at about that "
              "radius. The paper's model is kinematic; here the robot has a mass of 10 g, and 20 kg in a part of its "
              "own"),
    ]  # fmt: skip


def _transfer() -> list[Claim]:
    said = (printed.DC_TRANSFER[0], *printed.DC_TRANSFER[1])
    names = ("numerator", "s²", "s", "1")
    claims = []
    for inductance in printed.DC_INDUCTANCE_H:
        found = coefficients(inductance)
        good = np.allclose(found, said, rtol=5e-3)
        text = ", ".join(f"{name} {value:.4g}" for name, value in zip(names, found, strict=True))
        claims.append(
            Claim("reference [29]", f"transfer function with La = {_inductance(inductance)}",
                  "15/(1.08 s² + 6.1 s + 1.63)", text, "agrees" if good else "contradicts itself",
                  note="only 2.7 H gives the published transfer function" if good else
                  "2.7 mH is what a later article quotes from the same table, and what a motor of that size has")
        )  # fmt: skip
    return claims


def _limits() -> list[Claim]:
    volts = printed.DC_PEAK_RPM / gain_rpm_per_volt()
    supply = robots.DC_HENRY.robot.wheels[0].motor.voltage_v
    henry, milli = (largest_position_gain(inductance) for inductance in printed.DC_INDUCTANCE_H)
    return [
        Claim("conclusion", "fastest DC motor", printed.DC_PEAK_RPM, supply * gain_rpm_per_volt(), "not comparable",
              "rpm", f"ours at {supply:g} V, assumed. The motor turns {gain_rpm_per_volt():.1f} rpm per volt: 450 rpm "
              f"are {volts:.2f} V, or a limit that somebody sets; here it is one that we set"),
        Claim("reference [29]", "stiffest steering (P) that is stable, 2.7 H", None, henry, "not printed", "V/rad",
              f"the poles cross at that gain: {_crossing(printed.DC_INDUCTANCE_H[0], henry)}"),
        Claim("reference [29]", "the same, 2.7 mH", None, milli, "not printed", "V/rad",
              f"{milli / henry:.0f} times as stiff; {_crossing(printed.DC_INDUCTANCE_H[1], milli)}"),
    ]  # fmt: skip


def _crossing(inductance_h: float, gain: float) -> str:
    below, above = (slowest_decay(inductance_h, share * gain) for share in (0.99, 1.01))
    return f"largest real part {below:.2g} 1/s at 1 % less, {above:+.2g} at 1 % more".replace("-", "−")


def _energy() -> Claim:
    m = printed.DC_MOTOR
    return Claim(
        "reference [29]", "EMF power that reaches the shaft", 100.0, 100.0 * power_to_shaft(), "cannot be", "%",
        f"K = {m['K']:g} N m/A and Kb = {m['Kb']:g} V s are one constant in SI; K below Kb loses the rest without "
        "heat. Ours: simulated under load, the loss in the gear's efficiency",
    )  # fmt: skip


def _averaged() -> list[Claim]:
    claims = []
    for load in LOADS:
        averaged, stepped = rotor_rpm("averaged", load), rotor_rpm("six_step", load)
        claims.append(
            Claim("section 2.3", f"rotor at 24 V and {1e3 * load:g} mN m: averaged, six-step", "not printed",
                  f"{averaged:.0f}, {stepped:.0f} rpm", "not printed",
                  note=f"a DC motor of 2R, 2L and K is {100.0 * (averaged / stepped - 1.0):.1f} % too fast: while a "
                  "current passes from one phase to the next, torque is lost")
        )  # fmt: skip
    return claims


def _parameters() -> TableSection:
    found = [_row(setup.name, setup.robot.wheels[0].motor) for setup in robots.PAPER]
    return TableSection("Motors", table(found), "Seen at the rotor; R, L and K between two terminals.")


def _row(name: str, motor: Motor) -> dict[str, Any]:
    g = motor.gear
    return {
        "motor": name,
        "fed": motor.drive if motor.kind == "bldc" else "brushes",
        "V": motor.voltage_v,
        "R, Ω": f"{motor.resistance_ohm:.3g}",
        "L, mH": f"{1e3 * motor.inductance_h:.3g}" if motor.inductance_h < 1.0 else f"{1e3 * motor.inductance_h:.0f}",
        "L/R, ms": f"{1e3 * motor.inductance_h / motor.resistance_ohm:.4g}",
        "Kb, V s": f"{motor.back_emf_v_s_rad / g:.3g}",
        "K, N m/A": f"{motor.efficiency * motor.back_emf_v_s_rad / g:.3g}",
        "J, kg m²": f"{motor.inertia_kg_m2 / g**2:.3g}",
        "gear": g,
    }


def _speeds() -> TableSection:
    found = []
    for load in LOADS:
        averaged, stepped = rotor_rpm("averaged", load), rotor_rpm("six_step", load)
        found.append({"load, mN m": 1e3 * load, "averaged, rpm": averaged, "six-step, rpm": stepped,
                      "too fast, %": 100.0 * (averaged / stepped - 1.0)})  # fmt: skip
    return TableSection("BLDC motor at full voltage: averaged against six-step", table(found))


def _data() -> dict[str, Any]:
    return {
        "transfer": {_inductance(value): coefficients(value).tolist() for value in printed.DC_INDUCTANCE_H},
        "rpm_per_volt": gain_rpm_per_volt(),
        "position_gain_v_rad": [largest_position_gain(value) for value in printed.DC_INDUCTANCE_H],
        "power_to_shaft": power_to_shaft(),
    }


def _inductance(henry: float) -> str:
    return f"{henry:g} H" if henry >= 1.0 else f"{1e3 * henry:g} mH"
