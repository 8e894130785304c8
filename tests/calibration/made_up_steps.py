"""Open-loop steps computed here, without the simulator: a cubic, dead time, lag, noise, and a mouse's counts."""

import math

import numpy as np

from holodrive.calibration.steps import StepRecord

PRINTED = {  # Keek et al., eq. 9 to 12, constant first; counts over mm/s
    ("W1W4", "forward"): (43.4929, 2.8629, -0.1603, 0.0056),
    ("W1W4", "backward"): (43.4521, 4.0447, -0.2702, 0.0077),
    ("W2W3", "forward"): (53.9554, 3.4245, -0.2335, 0.0061),
    ("W2W3", "backward"): (54.96069, 1.7440, -0.1041, 0.0055),
}
LEVELS = (35, 44, 46, 50, 56, 60, 65, 70, 75, 80, 100, 130, 160, 200, 230, 255)
WAY = {  # signs of x and y (REP-103) of the four elementary actuations
    ("W1W4", "forward"): (1, 1),
    ("W1W4", "backward"): (-1, -1),
    ("W2W3", "forward"): (1, -1),
    ("W2W3", "backward"): (-1, 1),
}


def speed_of(cubic: tuple[float, ...], pwm: float) -> float:
    """Speed in mm/s of a rising cubic at a PWM; 0 in its dead zone."""
    roots = np.roots([*cubic[:0:-1], cubic[0] - pwm])
    real = [float(root.real) for root in roots if abs(root.imag) < 1e-6 and root.real > 0.0]
    return min(real) if pwm > cubic[0] and real else 0.0


def step(
    group: str,
    direction: str,
    pwm: float,
    speed_m_s: float,
    *,
    dead_s: float = 0.05,
    lag_s: float = 0.06,
    noise: float = 0.0,
    rng: np.random.Generator | None = None,
    count_m: float = 1e-5,
    ticks: int = 100,
    dt_s: float = 0.015,
    command_s: float = 0.0,
) -> StepRecord:
    """One step: dead time, then a first-order lag to `speed_m_s`, told in whole counts."""
    time = dt_s * np.arange(ticks + 1)
    fine = np.arange(0.0, time[-1] + 0.5e-3, 1e-3)
    since = np.maximum(fine - dead_s, 0.0)
    speed = speed_m_s * (1.0 - np.exp(-since / lag_s))
    if rng is not None and noise:
        ticks_of = np.minimum((fine / dt_s).astype(int), ticks)
        speed = speed * (1.0 + noise * rng.normal(size=ticks + 1)[ticks_of])
    travel = np.concatenate([[0.0], np.cumsum(0.5e-3 * (speed[1:] + speed[:-1]))])
    travel = np.interp(time, fine, travel) / math.sqrt(2.0)
    sx, sy = WAY[group, direction]
    told = count_m * np.floor(travel / count_m)
    return StepRecord(group, direction, pwm, command_s + time, sx * told, sy * told, command_s)


def all_steps(cubics: dict[tuple[str, str], tuple[float, ...]] = PRINTED, **options: object) -> list[StepRecord]:
    """Steps of both groups in both directions at `LEVELS`, one after another on one clock."""
    records, clock = [], 0.0
    for (group, direction), cubic in cubics.items():
        for pwm in LEVELS:
            speed = 1e-3 * speed_of(cubic, pwm)
            records.append(step(group, direction, float(pwm), speed, command_s=clock, **options))  # type: ignore[arg-type]
            clock += 2.0
    return records
