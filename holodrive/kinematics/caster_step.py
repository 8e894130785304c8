"""The command step of modules with casters for plain floats: twin of `kernel.fit_casters` and `drive_casters`."""

import math
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from holodrive.kinematics.caster_motion import follow, lean, time_of_turn
from holodrive.kinematics.settings import CASTER_ROUNDS, GOAL

if TYPE_CHECKING:
    from holodrive.kinematics.chassis import Chassis


def powered(chassis: "Chassis") -> Callable[..., tuple[Any, ...]]:
    """A function (vx, vy, omega, dt, angles) -> (factor, number of the wheel that bound, speeds, angles, signs).

    `factor` is what limits of steering and drives take of the twist, which is inside the wheels' own; angles are
    those at the tick's start and at its end [rad]; signs tell forwards from backwards.
    """
    rows, modules = _rows(chassis), _modules(chassis)

    def step(vx: float, vy: float, omega: float, dt: float, angles: tuple[float, ...]) -> tuple[Any, ...]:
        factor, worst = 1.0, -1
        for left in range(CASTER_ROUNDS, -1, -1):
            speeds, motions = discrete(rows, modules, factor * vx, factor * vy, factor * omega, dt, angles)
            shares = [
                _share(module, motion, factor * omega, dt) for module, motion in zip(modules, motions, strict=True)
            ]
            share = min(shares)
            if share >= 1.0 or not left:
                break
            factor, worst = factor * GOAL * share, modules[shares.index(share)][0]
        ends = tuple(angle + motion[2] for angle, motion in zip(angles, motions, strict=True))
        for module, (_, _, _, way) in zip(modules, motions, strict=True):
            speeds[module[0]] = way / (module[3] * dt)
        signs = tuple(math.copysign(1.0, motion[3]) if motion[3] else 0.0 for motion in motions)
        return factor, worst, tuple(speeds), ends, signs

    return step


def leans(chassis: "Chassis") -> Callable[..., tuple[float, ...]]:
    """A function (vx, vy, omega, the same of the tick before, dt) -> how far each short caster leans (m) [rad]."""
    rows, modules = _rows(chassis), _modules(chassis)

    def step(vx: float, vy: float, omega: float, lx: float, ly: float, lw: float, dt: float) -> tuple[float, ...]:
        c, s = math.cos(lw * dt), math.sin(lw * dt)  # back into the axes of the tick before
        lx, ly = c * lx - s * ly, s * lx + c * ly
        found = []
        for i, caster, *_ in modules:
            (along, across), (before_along, before_across) = _at(rows[i], vx, vy, omega), _at(rows[i], lx, ly, lw)
            found.append(lean(along, across, before_along, before_across, omega, caster, dt) if caster else 0.0)
        return tuple(found)

    return step


def discrete(
    rows: list[list[list[float]]],
    modules: list[tuple[Any, ...]],
    vx: float,
    vy: float,
    omega: float,
    dt: float,
    angles: tuple[float, ...],
) -> tuple[list[float], list[tuple[float, float, float, float]]]:
    """Speeds of the fixed wheels; of each module its axis' velocity (along, across), its turn [rad] and way [m]."""
    half = 0.5 * omega * dt
    k = half / math.tan(half) if half else 1.0
    ux, uy = k * vx + half * vy, k * vy - half * vx
    speeds, motions = [_at(block, ux, uy, omega)[0] for block in rows], []
    for (i, caster, *_), angle in zip(modules, angles, strict=True):
        first, second = _at(rows[i], ux, uy, omega)
        c, s = math.cos(angle), math.sin(angle)
        along, across = c * first + s * second, c * second - s * first
        motions.append((along, across, *follow(along, across, omega, caster, dt)))
    return speeds, motions


def _share(module: tuple[Any, ...], motion: tuple[float, ...], omega: float, dt: float) -> float:
    """Share at most 1 of the twist that lets a powered caster keep to its limits."""
    _, caster, coupling, radius, steer_rate, max_speed = module
    along, across, turn, way = motion
    share, reach = 1.0, steer_rate * dt
    if abs(turn) > reach:
        share = time_of_turn(along, across, omega, caster, turn, reach, dt) / dt
    drive = abs(way / radius + coupling * turn) / dt
    return min(share, max_speed / drive) if drive > max_speed else share


def _rows(chassis: "Chassis") -> list[list[list[float]]]:
    return [wheel.rows.tolist() for wheel in chassis.wheels]


def _modules(chassis: "Chassis") -> list[tuple[Any, ...]]:
    """Number, caster, coupling, radius, steering rate and speed limit of each steered wheel."""
    wheels = [(i, chassis.wheels[i]) for i in chassis.steered]
    return [(i, w.caster, w.coupling, w.radius, w.steer_rate, w.max_speed) for i, w in wheels]


def _at(block: list[list[float]], vx: float, vy: float, omega: float) -> tuple[float, ...]:
    return tuple(row[0] * vx + row[1] * vy + row[2] * omega for row in block)
