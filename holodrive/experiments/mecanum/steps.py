"""Figures 4, 5 and 7: open-loop steps of the simulated robot, their speeds, and the cubics fitted to them.

The simulated actuators are the printed cubics read backwards, so these figures do not test the cubics. They test the
way from steps to a linearizer, and show what the method makes of lag, dead time, whole counts and unequal wheels.
"""

from functools import cache
from typing import TYPE_CHECKING

import numpy as np

from holodrive import build
from holodrive.experiments.claims import Claim
from holodrive.experiments.experiment import Result, Setting
from holodrive.experiments.mecanum import printed
from holodrive.experiments.mecanum.actuators import NAMES, pwm_at, speed_at
from holodrive.reports.plots import Chart, Line
from holodrive.reports.sections import ChartSection, TableSection
from holodrive.reports.tables import Table
from holodrive.types import Array

if TYPE_CHECKING:
    from holodrive.calibration.duty_fit import CurveFit
    from holodrive.calibration.steps import Calibration

SEED = 1
DRAWN = 7  # steps of each chart of figure 4
WITHIN = 0.02  # of full scale, from 5 % to full speed
_DIRECTIONS = {"F": "forward", "B": "backward"}
_STATED = "mecanum4_mice on the plant pwm_map with dead time 40 ms ± 10 ms, lag 50 ms, wheels unequal by 1 %: assumed"


@cache
def calibration(levels: int = 16) -> "Calibration":
    """All steps of the simulated robot, and what is fitted to them; once a process.

    Args:
        levels: PWM values to see moving in each direction.
    """
    return build.calibrate_steps(build.simulate("mecanum4_mice", None, plant="pwm_map", seed=SEED), levels=levels)


def figure_4(setting: Setting) -> Result:
    """Displacements of steps at different PWM values."""
    found = calibration()
    dead = [fit_of(found, name).dead_time_s for name in NAMES]
    claims = (
        _first_values(found),
        Claim("text on Fig. 4", "dead time from command to motion", "'slightly different', no value",
              ", ".join(f"{1e3 * value:.0f}" for value in dead) + " ms", "not comparable",
              note=f"medians of the simulated steps, in the order of the figure's parts; {_STATED}"),
        Claim("text on Fig. 4", "gaps of final displacement between PWM values", "inconsistent",
              "one count is " + " to ".join(f"{v:.2f}" for v in _gaps()) + " mm/s", "not comparable",
              note="by the printed cubics: widest at low PWM, where the text has 'especially at higher PWM value'"),
    )  # fmt: skip
    section = ChartSection(
        "Figure 4, simulated: displacement after a step", tuple(_responses(found, name) for name in NAMES),
        f"Along the pair's diagonal. {_STATED}. Some of the steps of one calibration.",
    )  # fmt: skip
    return Result(claims, (section,), {"dead_time_s": dict(zip(NAMES, dead, strict=True))})


def figure_5(setting: Setting) -> Result:
    """Speeds of steps over PWM."""
    found = calibration()
    tops = {name: 1e3 * fit_of(found, name).speed_m_s[-1] for name in NAMES}
    slow = min(tops, key=lambda name: tops[name])
    mean = fit_of(found, slow).speed_eq8_m_s[-1] * 1e3
    claims = (
        Claim("text on Fig. 5", "speeds at full PWM, in the order of the figure's parts",
              f"{printed.SLOWEST_TOP:g} mm/s the least", ", ".join(f"{v:.1f}" for v in tops.values()) + " mm/s",
              "not comparable", note="simulated: the cubics' speeds with wheels that are not equal; slope of the "
              "second half of the motion"),
        Claim("Eq. 8", f"{NAMES[slow]} at full PWM by Eq. 8, {_duration(found):g} s", None, float(mean), "not printed",
              "mm/s", f"{100 * (1 - mean / tops[slow]):.1f} % less: Eq. 8 is the mean from the start of motion on, so "
              "the time in which a motor speeds up counts as slowness; how long the paper's steps last is not printed"),
    )  # fmt: skip
    section = ChartSection(
        "Figure 5, simulated: speed over PWM", tuple(_speeds(found, name) for name in NAMES),
        f"{_STATED}. The printed cubic is drawn backwards.",
    )  # fmt: skip
    return Result(claims, (section,), {"top_mm_s": {name: float(value) for name, value in tops.items()}})


def figure_7(setting: Setting) -> Result:
    """Cubics fitted to the steps, beside the printed ones."""
    found = calibration()
    section = ChartSection(
        "Figure 7, simulated: PWM over speed", tuple(_fits(found, name) for name in NAMES),
        f"{_STATED}. Fitted: least squares over all steps that moved, as the paper has it.",
    )  # fmt: skip
    return Result(tuple(_refound(found, name) for name in NAMES), (section, _table(found)), _data(found))


def fit_of(found: "Calibration", name: str) -> "CurveFit":
    """The fit of an actuation by the paper's name of it, such as "W1W4_F"."""
    pair, direction = name.split("_")
    return found.fit_of(pair, _DIRECTIONS[direction])


def _first_values(found: "Calibration") -> Claim:
    said = ", ".join(f"{printed.FIRST_PWM[name[:4]]:g}" for name in NAMES)
    ours = ", ".join(f"{fit_of(found, name).first_moving:g}" for name in NAMES)
    return Claim(
        "text on Fig. 7", "first PWM that moves, in the order of the figure's parts", said, ours, "not comparable",
        note="simulated; actuators that follow the printed cubics move from there on. Which PWM values the paper tried "
        "is not printed",
    )  # fmt: skip


def _gaps() -> tuple[float, float]:
    """Least and most speed of one PWM count over all four cubics [mm/s]."""
    gaps = []
    for name in NAMES:
        speeds = np.linspace(0.0, speed_at(name, printed.PWM_TOP), 500)
        gaps.append(1.0 / np.gradient(pwm_at(name, speeds), speeds))
    every = np.concatenate(gaps)
    return float(every.min()), float(every.max())


def _refound(found: "Calibration", name: str) -> Claim:
    one, top = fit_of(found, name), speed_at(name, printed.PWM_TOP)
    off = float(np.max(np.abs(_speed_errors(one, name))))
    return Claim(
        printed.EQUATIONS[name], f"{NAMES[name]}: found again from simulated steps", "the cubic",
        f"within {off:.2f} mm/s", "agrees" if off <= WITHIN * top else "differs",
        note=f"at equal PWM, from 5 % of the speed on; {100 * off / top:.1f} % of full scale, R² = {one.r2:.4f}",
    )  # fmt: skip


def _speed_errors(one: "CurveFit", name: str) -> Array:
    """Fitted minus printed speed [mm/s] at the PWM values of the printed cubic, from 5 % of its range on."""
    top = speed_at(name, printed.PWM_TOP)
    speeds = np.linspace(0.05 * top, top, 100)
    fine = np.linspace(0.0, 1.2 * top, 4001)
    return np.interp(pwm_at(name, speeds), _cubic(one, fine), fine) - speeds


def _cubic(one: "CurveFit", speeds: Array) -> Array:
    return np.asarray(np.polynomial.polynomial.polyval(speeds, one.printed))


def _responses(found: "Calibration", name: str) -> Chart:
    pair, direction = name.split("_")
    moved = sorted((s for s in found.steps_of(pair, _DIRECTIONS[direction]) if s.moved), key=lambda s: s.record.pwm)
    picked = [moved[round(i)] for i in np.linspace(0, len(moved) - 1, min(DRAWN, len(moved)))]
    lines = tuple(
        Line(f"{s.record.pwm:g}", s.record.time - s.record.command_time, 1e3 * s.record.travel(), colour)
        for colour, s in enumerate(picked)
    )
    return Chart(f"{NAMES[name]}, by PWM", "mm", lines, x_name="time after the command", low=0.0)


def _speeds(found: "Calibration", name: str) -> Chart:
    one = fit_of(found, name)
    speeds = np.linspace(0.0, speed_at(name, printed.PWM_TOP), 200)
    lines = (
        Line("printed", pwm_at(name, speeds), speeds, 2, pale=True),
        Line("slope of the tail", one.pwm, 1e3 * one.speed_m_s, 0),
        Line("Eq. 8", one.pwm, 1e3 * one.speed_eq8_m_s, 1, dash="2 3"),
    )
    return Chart(NAMES[name], "mm/s", lines, x_name="PWM", x_unit="", low=0.0)


def _fits(found: "Calibration", name: str) -> Chart:
    one = fit_of(found, name)
    speeds = np.linspace(0.0, speed_at(name, printed.PWM_TOP), 200)
    lines = (
        Line("printed", speeds, pwm_at(name, speeds), 2, pale=True),
        Line("steps", 1e3 * one.speed_m_s, one.pwm, 0),
        Line("fitted", speeds, _cubic(one, speeds), 1, dash="7 3"),
    )
    return Chart(NAMES[name], "PWM", lines, x_name="speed", x_unit="mm/s", low=0.0)


def _table(found: "Calibration") -> TableSection:
    headers = ("equation", "", "c3", "c2", "c1", "c0", "mm/s at PWM 255")
    cells = []
    for name in NAMES:
        one = fit_of(found, name)
        top = float(np.interp(printed.PWM_TOP, _cubic(one, _fine(name)), _fine(name)))
        kinds = (("printed", printed.CUBICS[name], speed_at(name, printed.PWM_TOP)), ("fitted", one.printed, top))
        for kind, c, v in kinds:
            texts = (f"{c[3]:.4f}", f"{c[2]:.4f}", f"{c[1]:.4f}", f"{c[0]:.4f}", f"{v:.2f}")
            cells.append((printed.EQUATIONS[name], kind, *(t.replace("-", "−") for t in texts)))
    rows = tuple(dict(zip(headers, row, strict=True)) for row in cells)
    numeric = (False, False, *(True,) * 5)
    note = "Coefficients of neighbouring powers trade against each other; speeds at equal PWM are what counts."
    return TableSection("Coefficients", Table("", headers, tuple(cells), rows, numeric), note)


def _fine(name: str) -> Array:
    return np.linspace(0.0, 1.2 * speed_at(name, printed.PWM_TOP), 4001)


def _duration(found: "Calibration") -> float:
    record = found.steps[0].record
    return float(round(record.time[-1] - record.command_time, 2))


def _data(found: "Calibration") -> dict[str, object]:
    return {name: {"fitted": list(fit_of(found, name).printed), "r2": fit_of(found, name).r2} for name in NAMES}


__all__ = ["calibration", "figure_4", "figure_5", "figure_7", "fit_of"]
