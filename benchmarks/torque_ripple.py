"""How smooth is the torque, what does it cost in copper, and does field-oriented control answer as designed?

    python benchmarks/torque_ripple.py [--save]

The motor is a flat one with 16 poles (1.03 ohm, 0.572 mH, 33.5 mN m/A between two terminals, 24 V, no gear), with a
sinusoidal and with a trapezoidal EMF of the same K. Rows of the first table hold a speed and a mean torque; ripple is
peak to peak over mean of the torque every microsecond, copper loss is over that of a DC motor, R T^2 / K^2. FOC
controls every 20 us and holds its voltage in between; PWM is averaged, so its own ripple is not in any number. The
model in d and q of the last part is integrated apart, with continuous controllers and no step above 0.2 us. Exit code
1 when a bar is missed.
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

from holodrive.actuators import bldc, foc
from holodrive.actuators.machine import FocLoops, ideal_six_step_torque, ripple, simulate
from holodrive.actuators.space_vector import clarke, park
from holodrive.leaf import leaf
from holodrive.robots.spec import Motor

RPM = 30.0 / math.pi
TRAPEZOID = Motor(
    "flat 16 poles", "bldc", 24.0, 711.0, 0.0335, 1.03, 0.572e-3,
    viscous_friction_n_m_s_rad=8.9e-6, inertia_kg_m2=1.35e-5, poles=16, drive="foc",
)  # fmt: skip
SINE = replace(TRAPEZOID, name="the same, sine", emf="sine")
TORQUE, CONTROL, FINE = 0.05, 2e-5, 1e-6  # N m, s, s
DC_LOSS = TRAPEZOID.resistance_ohm * (TORQUE / TRAPEZOID.back_emf_v_s_rad) ** 2  # W
SPEEDS = (300.0, 1500.0, 4000.0)  # rpm
FOC_BAR, IDEAL_RIPPLE, IDEAL_BAR, MODEL_BAR = 0.02, (1.0 - math.cos(math.pi / 6.0)) * math.pi / 3.0, 1e-3, 0.01
SIX_STEP_LOSS = (math.pi / 3.0) ** 2  # on a sine: its mean torque per ampere is 3 / pi of the peak
FOC_LOSS = {"sine": 1.0, "trapezoid": 4.0 / (3.0 * foc.TRAPEZOID_PEAK**2)}  # currents are sines
SHAPED_LOSS = {"sine": 1.0, "trapezoid": math.pi * math.sqrt(3.0) / 6.0}


@leaf
def _held(state, params, demand, bus_v, omega, control, parts, torque):
    """FOC every `control` seconds, phases in `parts` steps of it."""
    for n in range(torque.shape[0] // parts):
        v_alpha, v_beta = foc.foc_voltage(state, 0, params, 0, demand, bus_v, omega, control)
        for k in range(parts):
            h = control / parts
            torque[n * parts + k] = foc.conduct(state, 0, params, 0, v_alpha, v_beta, omega, h)


def field_oriented(motor, rpm, shaped, control=CONTROL, bandwidth_hz=1000.0):
    """Torques (n,) [N m] and mean copper loss [W], settled."""
    params, state = bldc.pack_motor(motor), np.zeros(bldc.STATE_SIZE)
    params[bldc.SHAPED], params[bldc.BANDWIDTH] = shaped, 2.0 * math.pi * bandwidth_hz
    parts, omega = round(control / FINE), rpm / RPM
    torque = np.empty(parts * round(0.1 / control))
    _held(state, params, TORQUE, motor.voltage_v, omega, control, parts, torque)
    state[bldc.COPPER_J] = 0.0
    _held(state, params, TORQUE, motor.voltage_v, omega, control, parts, torque)
    return torque, state[bldc.COPPER_J] / (FINE * len(torque))


def six_step(motor, rpm):
    """The same of real six-step, with the duty that gives the mean torque; and that duty."""

    def run(duty, dt, seconds):
        return simulate(motor, duty, 0.0, seconds, dt, drive="six_step", speed_rad_s=rpm / RPM, inertia_kg_m2=1e4)

    low, high = 0.0, 1.0
    for _ in range(16):
        duty = 0.5 * (low + high)
        torque = run(duty, 5e-6, 0.15).torque[10_000:].mean()
        low, high = (duty, high) if torque < TORQUE else (low, duty)
    traces = run(duty, FINE, 0.15)
    settled = slice(50_000, None)
    return traces.torque[settled], traces.copper_w[settled].mean(), duty


def row(say, name, torque, copper, note=""):
    mean = torque.mean()
    loss = copper / DC_LOSS * (TORQUE / mean) ** 2
    say(f"  {name}", f"ripple {100 * ripple(torque):6.2f} %, copper loss {loss:.4f}{note}")
    return ripple(torque), loss


def ripples(say, motor):
    missed = []
    turn = np.linspace(0.0, 2.0 * math.pi, 36_000, endpoint=False)
    ideal = ideal_six_step_torque(motor, 1.0, turn)
    sine = motor.emf == "sine"
    theory = (IDEAL_RIPPLE, SIX_STEP_LOSS) if sine else (0.0, 1.0)
    ampere = TORQUE / ideal.mean()
    say(f"EMF {motor.emf}: {TORQUE} N m held, copper loss over {DC_LOSS:.3f} W of a DC motor", "")
    note = f" (theory {100 * theory[0]:.2f} %, {theory[1]:.4f})"
    found = row(say, "ideal six-step currents", ampere * ideal, motor.resistance_ohm * ampere**2, note)
    missed += [f"ideal, {motor.emf}"] if np.abs(np.subtract(found, theory)).max() > IDEAL_BAR else []
    along_q = np.array([park(*foc.shape_vector(a, float(sine)), a + foc.FLUX)[1] for a in turn])
    row(say, "ideal sinusoidal currents", TORQUE * along_q / along_q.mean(), DC_LOSS * FOC_LOSS[motor.emf])
    for rpm in SPEEDS:
        *found, duty = six_step(motor, rpm)
        row(say, f"real six-step, {rpm:4.0f} rpm", *found, f", duty {duty:.3f}")
        for shaped, losses in ((False, FOC_LOSS), (True, SHAPED_LOSS)):
            if shaped and sine:
                continue
            note = f" (theory {losses[motor.emf]:.4f})"
            name = f"FOC{', shaped by the EMF' if shaped else ''}, {rpm:4.0f} rpm"
            worst, _ = row(say, name, *field_oriented(motor, rpm, shaped), note)
            missed += [name] if sine and worst > FOC_BAR else []
    return missed


def control_rates(say):
    say("FOC at other control rates and bandwidths, 1500 rpm", "")
    for motor, shaped in ((SINE, False), (TRAPEZOID, False), (TRAPEZOID, True)):
        for control, hz in ((1e-5, 1000.0), (2e-5, 3000.0), (2e-5, 300.0), (5e-5, 1000.0), (1e-4, 1000.0)):
            torque, _ = field_oriented(motor, 1500.0, shaped, control, hz)
            name = f"{motor.emf}{', shaped' if shaped else ''}, every {1e6 * control:3.0f} us, {hz:4.0f} Hz"
            say(f"  {name}", f"ripple {100 * ripple(torque):6.2f} %")


@leaf
def _in_rotor_frame(motor, inertia, loops, wanted, loads, omega, dt, parts, trace):
    """Currents along d and q and speed, with continuous PI controllers: rows (i_q, omega, i_d).

    motor: R, L of a phase, flux linkage [V s], pole pairs, viscous friction; loops: bandwidths of current and speed,
    or 0 for a held speed and `wanted` as torque.
    """
    r, inductance, flux, pairs, viscous = motor
    fast, slow = loops
    i_d = i_q = held_d = held_q = held = 0.0
    for n in range(trace.shape[0]):
        for _ in range(parts):
            torque_wanted, damping = wanted[n], inertia * slow - viscous
            if slow > 0.0:
                error = wanted[n] - omega
                torque_wanted = inertia * slow * error + held - damping * omega
                held += dt * inertia * slow * slow * error
            e_d, e_q, electrical = -i_d, torque_wanted / (1.5 * pairs * flux) - i_q, pairs * omega
            v_d = fast * inductance * e_d + held_d - electrical * inductance * i_q
            v_q = fast * inductance * e_q + held_q + electrical * (inductance * i_d + flux)
            held_d, held_q = held_d + dt * fast * r * e_d, held_q + dt * fast * r * e_q
            d = (v_d - r * i_d + electrical * inductance * i_q) / inductance
            q = (v_q - r * i_q - electrical * (inductance * i_d + flux)) / inductance
            if slow > 0.0:
                omega += dt * (1.5 * pairs * flux * i_q - loads[n] - viscous * omega) / inertia
            i_d, i_q = i_d + dt * d, i_q + dt * q
        trace[n, 0], trace[n, 1], trace[n, 2] = i_q, omega, i_d


def flux_current(traces):
    """(n, 2) currents along d and q [A] of a run."""
    return np.array(
        [park(*clarke(*i), angle + foc.FLUX) for i, angle in zip(traces.currents, traces.angle, strict=True)]
    )


def responses(say):
    """Three phases in steps of 20 us against the continuous model in d and q, sinusoidal motor."""
    k, pairs, parts = SINE.back_emf_v_s_rad, 8.0, 100
    motor = (0.5 * SINE.resistance_ohm, 0.5 * SINE.inductance_h, 0.5 * k * bldc.SINE_PEAK / pairs, pairs, 8.9e-6)
    fast, missed = 2.0 * math.pi * 1000.0, []
    say("answers of the sinusoidal motor, every 20 us, against a continuous model in d and q (bar 1 %)", "")
    for rpm in (0.0, 1500.0, 4000.0):
        steps, heavy = 100, 1e4
        traces = simulate(
            SINE, TORQUE, 0.0, steps * CONTROL, CONTROL, mode="torque", speed_rad_s=rpm / RPM, inertia_kg_m2=heavy
        )
        model = np.empty((steps, 3))
        _in_rotor_frame(
            motor, heavy, (fast, 0.0), np.full(steps, TORQUE), np.zeros(steps), rpm / RPM, CONTROL / parts, parts, model
        )
        ours = flux_current(traces)
        final = TORQUE / (0.75 * k * bldc.SINE_PEAK)
        error = np.hypot(ours[:, 1] - model[:, 0], ours[:, 0] - model[:, 2]).max() / final
        crossed = [1e3 * np.interp(share * final, ours[:, 1], traces.time) for share in (0.1, 0.9)]
        say(
            f"  current step at {rpm:4.0f} rpm",
            f"apart {100 * error:.3f} %; {final:.2f} A, 10 to 90 % in {crossed[1] - crossed[0]:.3f} ms"
            f" (design {2197.2 / fast:.3f}), overshoot {100 * max(0.0, ours[:, 1].max() / final - 1.0):.2f} %,"
            f" |i_d| below {np.abs(ours[:, 0]).max():.0e} A",
        )
        missed += [f"current step, {rpm} rpm"] if error > MODEL_BAR else []
    inertia, seconds, wanted = 1e-4, 0.12, 10.0
    steps = round(seconds / CONTROL)
    loads = np.where(np.arange(steps) < steps // 2, 0.0, 0.03)
    for hz in (10.0, 30.0):
        slow = 2.0 * math.pi * hz
        traces = simulate(
            SINE, wanted, loads, seconds, CONTROL, mode="speed", loops=FocLoops(speed_hz=hz),
            inertia_kg_m2=inertia - SINE.inertia_kg_m2,
        )  # fmt: skip
        model = np.empty((steps, 3))
        _in_rotor_frame(motor, inertia, (fast, slow), np.full(steps, wanted), loads, 0.0, CONTROL / parts, parts, model)
        speed = np.abs(traces.speed - model[:, 1]).max() / wanted
        current = np.abs(flux_current(traces)[:, 1] - model[:, 0]).max() / np.abs(model[:, 0]).max()
        rise = 1e3 * np.interp(0.9 * wanted, traces.speed[: steps // 2], traces.time[: steps // 2])
        dip = wanted - traces.speed[steps // 2 :].min()
        say(
            f"  speed step of 10 rad/s, loop {hz:2.0f} Hz",
            f"apart {100 * speed:.3f} % in speed, {100 * current:.3f} % in current; 90 % in {rise:.1f} ms"
            f" (design {2302.6 / slow:.1f}), overshoot {100 * max(0.0, traces.speed.max() / wanted - 1.0):.2f} %,"
            f" dips {dip:.2f} rad/s under 0.03 N m, ends {traces.speed[-1]:.3f}",
        )
        missed += [f"speed step, {hz} Hz"] if max(speed, current) > MODEL_BAR else []
    limited = replace(SINE, current_limit_a=6.0)
    traces = simulate(limited, 600.0, 0.03, 1.0, CONTROL, mode="speed", inertia_kg_m2=inertia)
    say(
        "  speed step of 600 rad/s, limit 6 A",
        f"90 % in {1e3 * np.interp(540.0, traces.speed, traces.time):.0f} ms, most of it at the limit; overshoot"
        f" {100 * max(0.0, traces.speed.max() / 600.0 - 1.0):.3f} %, at most {np.abs(traces.currents).max():.2f} A",
    )
    return missed


def energy(say):
    missed, duties = [], np.repeat([1.0, 0.2, 0.0, -0.7, 0.5], 6000)
    say("energy of FOC over starting, coasting, braking, reversing: missed over throughput (bar 0.1 %)", "")
    for motor in (SINE, TRAPEZOID):
        for shaped in (False, True):
            traces = simulate(motor, duties, 0.02, 0.6, CONTROL, loops=FocLoops(shaped=shaped), every=10)
            residual = traces.energy_residual()
            say(f"  {motor.emf}{', shaped' if shaped else ''}", f"{residual:9.1e}")
            missed += [f"energy, {motor.emf}"] if abs(residual) > 1e-3 else []
    return missed


def drives(say):
    say("speed at full duty [rpm] at 0, 0.02, 0.05 N m: what the circle of voltage leaves", "")
    for motor in (SINE, TRAPEZOID):
        for drive in ("averaged", "six_step", "foc"):
            found = [simulate(motor, 1.0, load, 0.6, CONTROL, drive=drive, every=10) for load in (0.0, 0.02, 0.05)]
            say(f"  {motor.emf}, {drive}", "  ".join(f"{RPM * run.speed[-500:].mean():5.0f}" for run in found))


def cost(say):
    """Processor time, the least loaded of several."""
    for motor, shaped in ((SINE, False), (TRAPEZOID, False), (TRAPEZOID, True)):
        times = []
        for _ in range(7):
            begin = time.thread_time()
            simulate(motor, 0.02, 0.02, 2.0, CONTROL, mode="torque", loops=FocLoops(shaped=shaped), every=200)
            times.append(time.thread_time() - begin)
        one = statistics.median(times) / 100_000
        say(f"  FOC, {motor.emf}{', shaped' if shaped else ''}", f"{1e9 * one:4.0f} ns a step of 20 us on the bench")


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--save", action="store_true", help="write the table into results/")
    arguments, lines = parser.parse_args(), []

    def say(name, text):
        lines.append(f"{name:44s} {text}".rstrip())
        print(lines[-1], flush=True)

    say(f"{platform.machine()}, Python {platform.python_version()}", "")
    missed = [*ripples(say, SINE), *ripples(say, TRAPEZOID)]
    control_rates(say)
    missed += [*responses(say), *energy(say)]
    drives(say)
    say("cost", "")
    cost(say)
    say("all bars held" if not missed else f"missed: {', '.join(missed)}", "")
    if arguments.save:
        target = Path(__file__).parent / "results" / "torque_ripple.txt"
        target.write_text("\n".join(lines) + "\n", encoding="utf-8")
    sys.exit(1 if missed else 0)


if __name__ == "__main__":
    main()
