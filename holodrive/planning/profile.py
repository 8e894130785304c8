"""Speed along a path: the trapezoid of speed with limited acceleration."""

import math
from typing import NamedTuple

import numpy as np

from holodrive.errors import InputError
from holodrive.types import Array

MOST_ROWS = 2_000_000  # of a table: five hours at 10 ms and some hundred megabytes


class Profile(NamedTuple):
    """Distance (K,) [m], speed [m/s] and acceleration [m/s^2] at times (K,) [s]."""

    time: Array
    distance: Array
    speed: Array
    accel: Array


def trapezoid(length_m: float, speed_m_s: float, accel_m_s2: float, step_s: float = 0.01) -> Profile:
    """From rest to rest over `length_m`, at most `speed_m_s`, changing speed by at most `accel_m_s2`.

    A path too short for the full speed gets a triangle.
    """
    for name, value in (("length", length_m), ("speed", speed_m_s), ("acceleration", accel_m_s2), ("step", step_s)):
        if not (value > 0.0 and math.isfinite(value)):
            raise InputError(f"a speed profile needs a {name} above 0; found {value}")
    ramp = min(speed_m_s / accel_m_s2, math.sqrt(length_m / accel_m_s2))
    top = ramp * accel_m_s2
    cruise = max(0.0, length_m / top - ramp)
    total = 2.0 * ramp + cruise
    # the corners of the trapezoid are rows, so that no step hides a jump of acceleration
    corners = [0.0, ramp, ramp + cruise, total]
    if not total / step_s <= MOST_ROWS:
        raise InputError(
            f"{length_m:g} m at {speed_m_s:g} m/s take {total:g} s; at most {MOST_ROWS * step_s:g} s are planned"
        )
    grid = np.linspace(0.0, total, max(2, math.ceil(total / step_s) + 1))
    time = np.unique(np.concatenate([grid, corners]))
    time = time[np.concatenate([[True], np.diff(time) > 1e-9])]
    rising, falling = np.minimum(time, ramp), np.maximum(time - ramp - cruise, 0.0)
    flat = np.clip(time - ramp, 0.0, cruise)
    distance = 0.5 * accel_m_s2 * rising**2 + top * flat + top * falling - 0.5 * accel_m_s2 * falling**2
    speed = np.minimum(accel_m_s2 * rising, top) - accel_m_s2 * falling
    accel = np.where(time < ramp, accel_m_s2, np.where(time >= ramp + cruise, -accel_m_s2, 0.0))
    return Profile(time, np.minimum(distance, length_m), np.maximum(speed, 0.0), accel)
