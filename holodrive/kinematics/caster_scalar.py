"""Wheels with casters for plain floats: twins of what `kinematics.caster` does on arrays."""

import math
from collections.abc import Callable
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from holodrive.kinematics.chassis import Chassis


def steady(along: float, across: float, omega: float, caster: float) -> tuple[float, float]:
    """How fast a module rolls [m/s], and its angle [rad], without side slip while the twist lasts.

    Args:
        along, across: velocity of the steering axis in the axes of the module's zero angle [m/s].
        omega: of the base [rad/s].
        caster: [m].
    """
    speed = math.sqrt(along * along + across * across)
    share = caster * omega / speed if speed > 0.0 else 0.0
    lean = math.asin(min(1.0, max(-1.0, share)))
    return speed * math.cos(lean), math.remainder(math.atan2(across, along) - lean, math.tau)


def forward_of(chassis: "Chassis") -> Callable[..., tuple[float, float, float]]:
    """A function (n wheel speeds, m steering angles, m steering rates) -> (vx, vy, omega) by least squares."""
    n, m = len(chassis.wheels), len(chassis.steered)
    blocks = [wheel.rows.tolist() for wheel in chassis.wheels]
    weights = [float(chassis.row_scale[row] ** 2) for row in chassis.row]

    def forward(*values: float) -> tuple[float, float, float]:
        normal, right = [0.0] * 6, [0.0] * 3
        for i, wheel in enumerate(chassis.wheels):
            if not wheel.steered:
                _add(normal, right, blocks[i][0], values[i], weights[i])
                continue
            j = chassis.steered.index(i)
            c, s = math.cos(values[n + j]), math.sin(values[n + j])
            first, second = blocks[i]
            e = [c * a + s * b for a, b in zip(first, second, strict=True)]
            across = [c * b - s * a for a, b in zip(first, second, strict=True)]
            across[2] -= wheel.caster
            _add(normal, right, e, values[i] * wheel.radius, weights[i])
            _add(normal, right, across, wheel.caster * values[n + m + j], weights[i])
        return _solved(normal, right)

    return forward


def _add(normal: list[float], right: list[float], row: list[float], value: float, weight: float) -> None:
    """One equation row . twist = value into the normal equations."""
    x, y, w = row
    for k, term in enumerate((x * x, x * y, x * w, y * y, y * w, w * w)):
        normal[k] += weight * term
    for k, entry in enumerate(row):
        right[k] += weight * entry * value


def _solved(normal: list[float], right: list[float]) -> tuple[float, float, float]:
    a11, a12, a13, a22, a23, a33 = normal
    x, y, w = right
    c11, c12, c13 = a22 * a33 - a23 * a23, a13 * a23 - a12 * a33, a12 * a23 - a13 * a22
    c22, c23, c33 = a11 * a33 - a13 * a13, a12 * a13 - a11 * a23, a11 * a22 - a12 * a12
    share = 1.0 / (a11 * c11 + a12 * c12 + a13 * c13)
    return (
        share * (c11 * x + c12 * y + c13 * w),
        share * (c12 * x + c22 * y + c23 * w),
        share * (c13 * x + c23 * y + c33 * w),
    )
