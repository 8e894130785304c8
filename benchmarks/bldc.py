"""Are the motor models right, how far is the averaged one from six-step, and what does a sub-step cost?

    python benchmarks/bldc.py [--save]

The motor is a flat one with 16 poles (1.03 ohm, 0.572 mH, 33.5 mN m/A between two terminals, 24 V, no gear). Its
reference speeds are from a plain explicit integration of the corrected phase equations with steps of 2 to 10 us; the
DC motor's transfer function is Hekimoglu's, 15 / (1.08 s^2 + 6.1 s + 1.63). Ripple is peak to peak over mean of the
torque with a load that holds the speed still. Exit code 1 when a bar is missed.
"""

import argparse
import math
import platform
import statistics
import sys
import time
from dataclasses import replace
from pathlib import Path

import numpy as np

from holodrive.actuators import bldc
from holodrive.actuators.averaged import coupled_step
from holodrive.actuators.machine import ideal_six_step_torque, ripple, simulate
from holodrive.robots.spec import Motor

RPM = 30.0 / math.pi
FLAT = Motor(
    "flat 16 poles", "bldc", 24.0, 711.0, 0.0335, 1.03, 0.572e-3,
    viscous_friction_n_m_s_rad=8.9e-6, inertia_kg_m2=1.35e-5, poles=16, drive="six_step",
)  # fmt: skip
SINE = replace(FLAT, name="the same, sine", emf="sine")
LOADS = (0.0, 0.02, 0.05)  # N m
REFERENCE = {"six_step": (6681.0, 6226.0, 5634.0), "averaged": (6786.0, 6612.0, 6351.0)}  # rpm
SPEED_BAR, ENERGY_BAR, IDEAL_RIPPLE = 0.01, 1e-3, 0.14
STEP_BARS = {1e-5: 1e-3, 2e-5: 1e-3, 5e-5: 2.4e-3}
POLES, GAIN = (-5.36693371, -0.28121444), 9.20245399  # 1/s, rad/s/V
SIXTH = math.pi / 6.0


def steady(motor, load, dt=2e-5, duty=1.0, **options):
    """Means of the last fifth of a run of 0.6 s: rpm, efficiency."""
    traces = simulate(motor, duty, load, 0.6, dt, every=10, **options)
    last = slice(-len(traces.time) // 5, None)
    efficiency = traces.mechanical_w[last].sum() / traces.electrical_w[last].sum()
    return traces.speed[last].mean() * RPM, efficiency


def speeds(say):
    say("speed at 24 V [rpm]; reference in brackets", "")
    worst = 0.0
    for load, *expected in zip(LOADS, *REFERENCE.values(), strict=True):
        (six, used), (average, used_average) = (steady(FLAT, load, drive=drive) for drive in REFERENCE)
        sine, _ = steady(SINE, load)
        worst = max(worst, abs(six / expected[0] - 1.0), abs(average / expected[1] - 1.0))
        say(
            f"  load {load:4.2f} N m",
            f"six-step {six:6.0f} ({expected[0]:.0f}), averaged {average:6.0f} ({expected[1]:.0f}), averaged is"
            f" {100 * (average / six - 1):4.1f} % fast; efficiency {used:.3f} and {used_average:.3f};"
            f" six-step on a sine {sine:6.0f}",
        )
    return [] if worst <= SPEED_BAR else ["speeds"]


def steps(say):
    say("step of six-step: worst error of speed over the loads, against 2 us", "")
    fine, missed = [steady(FLAT, load, 2e-6)[0] for load in LOADS], []
    for dt, bar in STEP_BARS.items():
        error = max(abs(steady(FLAT, load, dt)[0] / right - 1.0) for load, right in zip(LOADS, fine, strict=True))
        say(f"  {1e6 * dt:3.0f} us", f"{100 * error:.4f} % (bar {100 * bar:.2f} %)")
        missed += [f"step {dt}"] if error > bar else []
    return missed


def corner(say):
    """Fast rotor, little inductance: 10 000 rpm with 8 pole pairs, 9.6 degrees of electrical angle in 20 us."""
    say("10 000 rpm held, 48 V: mean torque at 20 us against 1 us", "")
    missed = []
    for constant in (1e-4, 2e-5, 5e-6):
        motor = replace(FLAT, inductance_h=constant * FLAT.resistance_ohm)
        means = []
        for dt in (1e-6, 2e-5):
            held = simulate(motor, 1.0, 0.0, 0.06, dt, bus_v=48.0, speed_rad_s=10_000 / RPM, inertia_kg_m2=1e3)
            means.append(held.torque[len(held.torque) // 3 :].mean())
        error = abs(means[1] / means[0] - 1.0)
        say(f"  L / R {1e3 * constant:.3f} ms", f"{means[1]:.4f} N m, error {100 * error:.3f} %")
        missed += [f"corner {constant}"] if error > 0.01 else []
    return missed


def energy(say):
    say("energy: electrical in - copper - friction - mechanical out - growth of stored, over the throughput", "")
    duties = np.repeat([1.0, 0.2, 0.0, -0.7, 0.5], 6000)
    runs = {
        "start and load": (1.0, 0.05),
        "start, coast down, brake, reverse": (duties, 0.02),
        "the same, driven by the load": (duties, -0.1),
    }
    missed = []
    for name, (duty, load) in runs.items():
        for motor, drive in ((FLAT, "six_step"), (SINE, "six_step"), (FLAT, "averaged")):
            traces = simulate(motor, duty, load, 0.6, 2e-5, drive=drive, every=10)
            residual, back = traces.energy_residual(), -np.minimum(traces.electrical_w, 0.0).sum() * traces.step_s
            say(f"  {name}", f"{drive:8s} {motor.emf:9s} missed {residual:9.1e}, fed back {abs(back):5.2f} J")
            missed += [f"energy, {name}, {drive}"] if abs(residual) > ENERGY_BAR else []
    return missed


def ripples(say):
    say("torque ripple, peak to peak over mean", "")
    turn, missed = np.linspace(0.0, 2.0 * math.pi, 36_000, endpoint=False), []
    for motor, expected in ((SINE, (1.0 - math.cos(SIXTH)) * math.pi / 3.0), (FLAT, 0.0)):
        ideal = ripple(ideal_six_step_torque(motor, 1.0, turn))
        say(f"  ideal six-step currents, {motor.emf}", f"{100 * ideal:5.2f} % (theory {100 * expected:.2f} %)")
        missed += [f"ideal ripple, {motor.emf}"] if abs(ideal - expected) > 1e-3 else []
        for duty, load in ((1.0, 0.02), (1.0, 0.05), (0.3, 0.02), (0.3, 0.05)):
            speed, _ = steady(motor, load, 1e-5, duty)
            held = simulate(motor, duty, load, 0.1, 2e-6, speed_rad_s=speed / RPM, inertia_kg_m2=1.0)
            say(
                f"  real six-step, {motor.emf}",
                f"{100 * ripple(held.torque[len(held.torque) // 2 :]):5.1f} % at duty {duty:.1f}, {load:.2f} N m,"
                f" {speed:5.0f} rpm",
            )
    return missed


def brushed(say):
    motor = bldc.pack_motor(Motor("Hekimoglu", "dc", 12.0, 46.0, 0.05, 0.4, 2.7, efficiency=0.3))
    j, d, dt = 4e-4, 2.2e-3, 0.1
    phi = np.array([coupled_step(motor, 0, *unit, 0.0, 0.0, j, d, dt) for unit in np.eye(2)]).T
    poles = np.sort(np.log(np.linalg.eigvals(phi)) / dt)
    gain = coupled_step(motor, 0, 0.0, 0.0, 1.0, 0.0, j, d, 1e3)[1]
    say("DC motor with 2.7 H", f"poles {poles[0]:.6f}, {poles[1]:.6f} 1/s, gain {gain:.6f} rad/s/V")
    say("  as published", f"poles {POLES[0]:.6f}, {POLES[1]:.6f} 1/s, gain {GAIN:.6f} rad/s/V")
    return [] if np.allclose((*poles, gain), (*POLES, GAIN), rtol=1e-6) else ["DC motor"]


def printed(say):
    """The printed eq. 30, 31 and 34 beside the corrected ones, at one state and with a locked rotor."""
    r, inductance, k, omega, i = 0.515, 0.286e-3, 0.0335, 200.0, np.array([3.0, -2.0, -1.0])
    volts, angle = np.array([20.0, 0.0, 12.0]), math.radians(80.0)
    e = 0.5 * k * omega * np.array([bldc.trapezoid(angle - n * bldc.THIRD) for n in range(3)])
    mean = np.mean(volts - e)
    right = (volts - e - mean - r * i) / inductance
    model = bldc.phase_derivatives(bldc.pack_motor(FLAT), 0, i[0], i[1], omega, angle, *volts, 0.0)
    thrice = (volts - e - mean - 3.0 * r * i) / inductance
    lines = np.array([volts[0] - volts[1] - e[0] + e[1], volts[1] - volts[2] - e[1] + e[2]])
    matrix = -r * i[:2] / inductance + 2.0 / (3.0 * inductance) * np.array([[1.0, 1.0], [-1.0, 1.0]]) @ lines
    for name, rates in (("corrected", right), ("our kernel", model), ("printed (30), (31)", thrice), ("(34)", matrix)):
        say(f"  {name}", f"di_a/dt {rates[0]:9.0f}, di_b/dt {rates[1]:9.0f} A/s at 200 rad/s, 80 deg")
    locked, wrong = 24.0 / (2.0 * r), 24.0 / (2.0 * 3.0 * r)
    ours = simulate(FLAT, 1.0, 0.0, 0.02, inertia_kg_m2=1e9, angle_rad=0.5).currents[-1, 0]
    say("  locked rotor at 24 V", f"{locked:.2f} A by Ohm's law, {ours:.2f} A ours, {wrong:.2f} A by printed (30)")
    return [] if np.allclose(model[:2], right[:2], rtol=1e-9) and math.isclose(ours, locked, rel_tol=1e-6) else ["eq."]


def cost(say):
    """Processor time, the least loaded of several."""
    missed = []
    for motor, drive in ((FLAT, "six_step"), (SINE, "six_step"), (FLAT, "averaged")):
        times = []
        for _ in range(7):
            begin = time.thread_time()
            simulate(motor, 0.9, 0.02, 4.0, 2e-5, drive=drive, every=200)
            times.append(time.thread_time() - begin)
        one = statistics.median(times) / 200_000
        say(
            f"  {drive}, {motor.emf}",
            f"{1e9 * one:4.0f} ns a step of 20 us on the bench: {2e-5 / one:4.0f} x real time",
        )
    return missed


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--save", action="store_true", help="write the table into results/")
    arguments, lines = parser.parse_args(), []

    def say(name, text):
        lines.append(f"{name:44s} {text}".rstrip())
        print(lines[-1], flush=True)

    say(f"{platform.machine()}, Python {platform.python_version()}", "")
    missed = [*speeds(say), *steps(say), *corner(say), *energy(say), *ripples(say), *brushed(say)]
    say("printed equations", "")
    missed += printed(say)
    say("cost", "")
    cost(say)
    say("all bars held" if not missed else f"missed: {', '.join(missed)}", "")
    if arguments.save:
        target = Path(__file__).parent / "results" / "bldc.txt"
        target.write_text("\n".join(lines) + "\n", encoding="utf-8")
    sys.exit(1 if missed else 0)


if __name__ == "__main__":
    main()
