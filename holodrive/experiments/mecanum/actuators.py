"""Equations 8 to 12: the speed of a pair from one step, and the four cubics of the linearizer."""

import math

import numpy as np
from numpy.typing import ArrayLike

from holodrive.experiments.claims import Claim, Verdict, claimed
from holodrive.experiments.experiment import Result, Setting
from holodrive.experiments.mecanum import mapping, printed
from holodrive.reports.sections import TableSection
from holodrive.reports.tables import Table
from holodrive.types import Array

NAMES = {
    "W1W4_F": "W1W4 forward",
    "W1W4_B": "W1W4 backward",
    "W2W3_F": "W2W3 forward",
    "W2W3_B": "W2W3 backward",
}


def linearization(setting: Setting) -> Result:
    """Claims about equations 8 to 12."""
    claims = (
        _speed_formula(),
        *(_rises(name) for name in NAMES),
        *_top_speeds(),
        _limit(),
        *_dead_zones(),
        _directions(),
        *_resolution(),
    )
    rows = [_numbers(name) for name in NAMES]
    return Result(claims, (_table(rows),), {"cubics": rows})


def speed_as_printed(x: ArrayLike, y: ArrayLike, duration: ArrayLike) -> Array:
    """Equation 8, x not 0: speed along the pair's diagonal of a displacement (x, y) in a time, batched."""
    x, y = np.asarray(x, dtype=np.float64), np.asarray(y, dtype=np.float64)
    angle = np.arctan(np.abs(y / x))
    return np.asarray(np.sqrt(y**2 + x**2) / np.asarray(duration) * np.cos(math.pi / 4.0 - angle))


def speed(x: ArrayLike, y: ArrayLike, duration: ArrayLike) -> Array:
    """What equation 8 comes to: (|x| + |y|) / (sqrt(2) t), for any displacement."""
    return np.asarray((np.abs(x) + np.abs(y)) / (math.sqrt(2.0) * np.asarray(duration)))


def pwm_at(name: str, speeds: ArrayLike) -> Array:
    """PWM counts of one of the cubics at speeds [mm/s], batched."""
    return np.asarray(np.polynomial.polynomial.polyval(np.asarray(speeds, dtype=np.float64), printed.CUBICS[name]))


def speed_at(name: str, pwm: float) -> float:
    """The cubic read the other way: speed [mm/s] at PWM counts; 0 inside the dead zone. It rises, so there is one."""
    c0, *others = printed.CUBICS[name]
    roots = np.polynomial.polynomial.polyroots((c0 - pwm, *others))
    real = roots[np.abs(roots.imag) < 1e-9].real
    return max(0.0, float(real[0]))


def least_slope(name: str) -> tuple[float, float]:
    """Least slope of a cubic [counts s/mm] at 0 mm/s or above, and the speed [mm/s] where it is."""
    _, c1, c2, c3 = printed.CUBICS[name]
    at = max(0.0, -c2 / (3.0 * c3))  # where the second derivative vanishes
    return c1 + at * (2.0 * c2 + at * 3.0 * c3), at


def _speed_formula() -> Claim:
    rng = np.random.default_rng(0)
    x, y, duration = rng.uniform(1.0, 100.0, (3, 1000)) * ([[-1.0], [1.0], [1.0]])
    long, short = speed_as_printed(x, y, duration), speed(x, y, duration)
    worst = float(np.max(np.abs(long / short - 1.0)))
    return Claim(
        "Eq. 8", "speed of a pair", "√(x² + y²) cos(45° − atan|y/x|) / t", "(|x| + |y|) / (√2 t)",
        "agrees" if worst < 1e-12 else "differs",
        note=f"the same but for rounding ({worst:.0e} of it, 1000 displacements); the short form has no 0/0 at x = 0",
    )  # fmt: skip


def _rises(name: str) -> Claim:
    slope, at = least_slope(name)
    return Claim(
        printed.EQUATIONS[name], f"{NAMES[name]} rises everywhere", "'incremental pattern'",
        f"least slope {slope:.2f}", "agrees" if slope > 0.0 else "contradicts itself",
        note=f"at {at:.1f} mm/s, where one PWM count is {1.0 / slope:.2f} mm/s",
    )  # fmt: skip


def _top_speeds() -> list[Claim]:
    tops = {name: speed_at(name, printed.PWM_TOP) for name in NAMES}
    motor = printed.MOTOR_RPM / 60.0 * math.pi * printed.WHEEL_DIAMETER / math.sqrt(2.0)
    slow = min(tops, key=lambda name: tops[name])
    return [
        Claim("Section III", f"speed of {NAMES[slow]} at full PWM", printed.SLOWEST_TOP, tops[slow],
              "contradicts itself", "mm/s",
              f"by {printed.EQUATIONS[slow]}; the text reads it off Figure 6, which is a block diagram: Figure 5"),
        Claim("Eq. 9 to 12", "speeds at full PWM, in that order", None,
              ", ".join(f"{value:.1f}" for value in tops.values()) + " mm/s", "not printed"),
        claimed("Section V.A", f"fastest pair at full PWM, motors of {printed.MOTOR_RPM:g} rpm", motor,
                max(tops.values()), "mm/s", within=0.05,
                note=f"a rim of {math.sqrt(2.0) * motor:.1f} mm/s over √2: the other pair stands"),
    ]  # fmt: skip


def _limit() -> Claim:
    asked = {name: float(pwm_at(name, printed.SPEED_LIMIT)) for name in NAMES}
    worst = max(asked, key=lambda name: asked[name])
    verdict: Verdict = "cannot be" if asked[worst] > printed.PWM_TOP else "agrees"
    return Claim(
        printed.EQUATIONS[worst], f"PWM of {NAMES[worst]} at {printed.SPEED_LIMIT:g} mm/s, 8 bits",
        printed.PWM_TOP, round(asked[worst], 2), verdict,
        note=f"'range of allowable velocity ... up to {printed.SPEED_LIMIT:g} mm/s' is beyond full PWM there, though "
        "by less than a count",
    )  # fmt: skip


def _dead_zones() -> list[Claim]:
    claims = []
    for name, actuation in NAMES.items():
        first, start = printed.FIRST_PWM[name[:4]], printed.CUBICS[name][0]
        claims.append(
            claimed(printed.EQUATIONS[name], f"{actuation}: end of the dead zone", first, start, "counts",
                    within=0.05, note=f"{speed_at(name, first):.2f} mm/s at {first:g}")
        )  # fmt: skip
    at = printed.SILENT_PWM["W2W3"]
    claims.append(
        Claim("text on Figures 4, 7", f"W2W3 at a PWM of {at:g}", "no response; first value that responds",
              ", ".join(f"{speed_at(name, at):.2f}" for name in ("W2W3_F", "W2W3_B")) + " mm/s", "contradicts itself",
              note=f"both is said of {at:g}; read together, the fit begins with the point ({at:g}, 0 mm/s)")
    )  # fmt: skip
    return claims


def _directions() -> Claim:
    """How much the two directions of one pair differ at equal PWM, where both move faster than `slow` [mm/s]."""
    worst, slow = (0.0, "", 0.0), 10.0
    for pair in mapping.PAIRS:
        for pwm in np.arange(60.0, 256.0):
            ahead, back = speed_at(f"{pair}_F", float(pwm)), speed_at(f"{pair}_B", float(pwm))
            if min(ahead, back) > slow:
                worst = max(worst, (abs(ahead / back - 1.0), pair, float(pwm)))
    share, pair, pwm = worst
    return Claim(
        "text on Figure 3", "forward against backward at equal PWM", "slightly different", f"up to {100 * share:.0f} %",
        "not comparable", note=f"{pair} at {pwm:g} of 255, by its two cubics; above {slow:g} mm/s",
    )  # fmt: skip


def _resolution() -> list[Claim]:
    steps = {name: 1.0 / least_slope(name)[0] for name in NAMES}
    worst = max(steps, key=lambda name: steps[name])
    angle = 90.0 * steps[worst] / printed.SPEED_LIMIT  # a gain goes from 0 to 1 in 90 degrees
    return [
        Claim("Eq. 9 to 12", "speed of one PWM count, at most", None, steps[worst], "not printed", "mm/s",
              f"{NAMES[worst]} near {least_slope(worst)[1]:.1f} mm/s"),
        Claim("Section V.A", "finest direction the robot can reach", f"{printed.ANGLE_STEP:g}°", None,
              "not comparable", note=f"given without reason; at {printed.SPEED_LIMIT:g} mm/s a pair's speed changes by "
              f"one such count in {angle:.1f}°"),
    ]  # fmt: skip


def _numbers(name: str) -> dict[str, float | str]:
    slope, at = least_slope(name)
    return {
        "equation": printed.EQUATIONS[name],
        "actuation": NAMES[name],
        "pwm_at_0": printed.CUBICS[name][0],
        "pwm_at_limit": float(pwm_at(name, printed.SPEED_LIMIT)),
        "speed_at_full_mm_s": speed_at(name, printed.PWM_TOP),
        "least_slope": slope,
        "least_slope_at_mm_s": at,
        "count_mm_s": 1.0 / slope,
    }


def _table(rows: list[dict[str, float | str]]) -> TableSection:
    headers = ("equation", "actuation", "PWM at 0 mm/s", f"PWM at {printed.SPEED_LIMIT:g} mm/s", "mm/s at PWM 255",
               "least slope, counts s/mm", "at, mm/s", "largest step of one count, mm/s")  # fmt: skip
    cells = tuple(
        (str(r["equation"]), str(r["actuation"]), *(f"{value:.2f}" for value in list(r.values())[2:])) for r in rows
    )
    return TableSection("The four cubics", Table("", headers, cells, tuple(rows), (False, False, *(True,) * 6)))
