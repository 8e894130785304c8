"""What becomes of the paper's claim that BLDC motors drive a swerve robot better than DC motors."""

from dataclasses import replace

from holodrive.experiments.claims import Claim
from holodrive.experiments.experiment import Result, Setting
from holodrive.experiments.swerve import motors, printed, robots
from holodrive.experiments.swerve.runs import drive
from holodrive.experiments.swerve.search import searched
from holodrive.reports.sections import TableSection, TextSection
from holodrive.reports.tables import table

SOFT = replace(robots.DC_MILLI, name="DC 2.7 mH, softer", k=0.6, kp=2.0, ki=0.33, ks=6.0, kvs=2.4)
HEAVY = tuple(replace(setup, mass_kg=robots.MASS_KG) for setup in (*robots.PAPER, SOFT))


def verdict(setting: Setting) -> Result:
    """The claims of abstract and conclusion, one by one."""
    bldc, henry, milli = (drive(setup) for setup in (robots.BLDC, robots.DC_HENRY, robots.DC_MILLI))
    shared = drive(replace(robots.BLDC, motor=robots.DC_MILLI.motor))
    counts = [searched(setup, setting.workers) for setup in (robots.AVERAGED, robots.DC_MILLI, robots.DC_HENRY)]
    claims = (
        Claim("conclusion", "BLDC is more stable in steering", "yes", "yes with 2.7 H, no with 2.7 mH", "differs",
              note=f"there and back: BLDC {bldc.swing_deg:.1f}°, DC {henry.swing_deg:.0f}° with 2.7 H and "
              f"{milli.swing_deg:.1f}° with 2.7 mH. It hangs on the inductance that was put in: L/R = "
              f"{_lags()}; brushes have no part in it"),
        Claim("conclusion", "settings that are fast and steady: BLDC, DC 2.7 mH, DC 2.7 H", None,
              ", ".join(f"{len(one.steady)}" for one in counts) + f" of {counts[0].tried}", "not printed"),
        Claim("conclusion", "BLDC is faster than DC", "yes", "no", "contradicts itself",
              note=f"figures: error 0 in the 4th second with DC, in 7 s with BLDC; here {henry.arrival_s:.2f} s and "
              f"{bldc.arrival_s:.2f} s. Both come from the gain K. With the BLDC robot's controller and limit the DC "
              f"robot (2.7 mH) needs {shared.arrival_s:.2f} s: the motors hardly matter"),
        Claim("section 3.1, conclusion", "time of the BLDC robot", f"{printed.BLDC_ARRIVAL_S:g} s",
              f"{printed.CONCLUSION_S:g} s", "contradicts itself",
              note="section 3.1 has 7 seconds, the conclusion 'an error value of 0 within 5 seconds'"),
        _limit(),
        Claim("abstract", "BLDC is more efficient", "yes", f"{milli.energy_j:.0f} J against {bldc.energy_j:.0f} J",
              "not comparable", note="losses over 15 s, DC (2.7 mH) against BLDC; the data of [29] let "
              f"{100.0 * motors.power_to_shaft():.0f} % of the EMF power reach the shaft, which no real motor does. "
              "The paper measures no power"),
        Claim("section 3.2", "DC wheels cannot come to rest", "yes", f"{milli.end_rpm:.2f} rpm with 2.7 mH", "differs",
              note=f"{henry.end_rpm:.1f} rpm with 2.7 H after 15 s, in the setting of the figures"),
        _foc(),
    )  # fmt: skip
    return Result(claims, (TextSection("Verdict", _TEXT),))


def _lags() -> str:
    return " or ".join(f"{1e3 * value / printed.DC_MOTOR['Ra']:.4g} ms" for value in printed.DC_INDUCTANCE_H)


_TEXT = (
    "The pictures can be had: there are settings in which the BLDC robot glides to the goal with 700 rpm at the start, "
    "and the DC robot is there sooner with modules that swing. The conclusion cannot: the swinging is that of a motor "
    "with an inductance of 2.7 H, a thousand times what such a motor has. With 2.7 mH the DC robot is fast and "
    "steady in as many settings as the BLDC robot, and under the same limit and controller about as fast.\n\n"
    "That DC motors reach 450 rpm and BLDC motors 700 rpm is no property of either: with the data given both are "
    "limits that supply, gear or programmer set. Here 450 rpm is imposed."
)


def _limit() -> Claim:
    free = robots.DC_MILLI.robot.wheels[0].motor.no_load_speed_rad_s * motors.RPM
    faster = drive(replace(robots.DC_MILLI, limit_rpm=free))
    return Claim(
        "conclusion", "fastest wheel: DC, BLDC", f"{printed.DC_PEAK_RPM:g}, {printed.BLDC_PEAK_RPM:g} rpm",
        f"{faster.peak_rpm:.0f}, {drive(robots.BLDC).peak_rpm:.0f} rpm", "not comparable",
        note=f"ours without the limit of 450 rpm that the other runs impose (2.7 mH, 12 V): there in "
        f"{faster.arrival_s:.2f} s, {faster.swing_deg:.1f}° there and back",
    )  # fmt: skip


def _foc() -> Claim:
    stepped, foc = (drive(replace(setup, mass_kg=robots.MASS_KG)) for setup in (robots.BLDC, robots.FOC))
    change = 100.0 * (1.0 - foc.energy_j / stepped.energy_j)
    return Claim(
        "future work", "FOC makes the BLDC motors optimal", "hoped", f"{change:.0f} % less energy at 20 kg",
        "not comparable", note=f"sinusoidal motor with FOC {foc.energy_j:.0f} J, {foc.arrival_s:.2f} s; six-step "
        f"{stepped.energy_j:.0f} J, {stepped.arrival_s:.2f} s. The path is the same",
    )  # fmt: skip


def mass(setting: Setting) -> Result:
    """The same robots with a mass, which the paper leaves out."""
    rows = [{"motors": setup.name, **drive(setup).row()} for setup in HEAVY]
    dc = robots.DC_MILLI.robot.wheels[0].motor
    stall = dc.efficiency * dc.back_emf_v_s_rad * dc.voltage_v / dc.resistance_ohm
    push = 3.0 * stall / robots.DC_MILLI.robot.wheels[0].radius
    claim = Claim(
        "section 1", "mass and forces", "left out", f"{push:.1f} N of three stalled DC wheels", "not comparable",
        note=f"so a robot of {robots.MASS_KG:g} kg speeds up by {push / robots.MASS_KG:.2f} m/s² at most, and a law "
        "without a model of that overshoots; the DC motors of [29] need a gear, which the paper does not have",
    )  # fmt: skip
    note = (
        f"{robots.MASS_KG:g} kg, all else as above; goal of the figures. Softer: {SOFT.gains}. No wheel slips on this "
        "plant: where modules swing, the body's momentum turns wheels faster than their motors could."
    )
    return Result((claim,), (TableSection("With a mass", table(rows), note),), {"rows": rows})
