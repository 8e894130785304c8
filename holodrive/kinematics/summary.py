"""What a base can do, as numbers, text and LaTeX: the content of `holodrive kinematics ROBOT`."""

import math
from dataclasses import asdict, dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from holodrive.kinematics.chassis import Chassis

if TYPE_CHECKING:
    from holodrive.robots.spec import Robot


@dataclass(frozen=True, slots=True)
class TopSpeed:
    """The most that a base can do in one way, and the wheels that allow no more.

    Attributes:
        what: "ahead", "left", "turn in place", "slowest direction", "fastest direction".
        twist: that motion (vx, vy, omega) [m/s, m/s, rad/s].
        value: its speed [m/s], or yaw rate [rad/s] for turning in place.
        direction_deg: of travel, None for turning in place.
        binding: names of the wheels at their limit.
    """

    what: str
    twist: tuple[float, float, float]
    value: float
    direction_deg: float | None
    binding: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class Summary:
    """The kinematics of one base.

    Attributes:
        name: of the robot, "" for a bare chassis.
        wheels: names, in order; kinds: theirs.
        rows: what each row of the Jacobian is.
        jacobian: (rows, 3) wheel motion per twist; forward: (3, rows) its least-squares inverse.
        rank, condition, characteristic_length_m, redundancy: as in `Chassis`.
        warnings: sentences about a poor layout.
        top_speeds: empty when a wheel has no speed limit.
        polytope: corners, volume, largest yaw rate; empty when a wheel has no speed limit.
    """

    name: str
    wheels: tuple[str, ...]
    kinds: tuple[str, ...]
    rows: tuple[str, ...]
    jacobian: tuple[tuple[float, ...], ...]
    forward: tuple[tuple[float, ...], ...]
    rank: int
    condition: float
    characteristic_length_m: float
    redundancy: int
    warnings: tuple[str, ...]
    top_speeds: tuple[TopSpeed, ...]
    polytope: dict[str, Any]


def summarise(robot: "Robot | Chassis") -> Summary:
    """Everything about the kinematics of a robot or a chassis."""
    chassis = robot if isinstance(robot, Chassis) else Chassis.of(robot)
    limited = bool(np.all(np.isfinite(chassis.max_speeds)))
    return Summary(
        name="" if isinstance(robot, Chassis) else robot.name,
        wheels=chassis.names,
        kinds=tuple(wheel.kind for wheel in chassis.wheels),
        rows=_row_names(chassis),
        jacobian=_rows(chassis.jacobian),
        forward=_rows(chassis.least_squares),
        rank=chassis.rank,
        condition=chassis.condition,
        characteristic_length_m=chassis.characteristic_length,
        redundancy=chassis.redundancy,
        warnings=chassis.warnings,
        top_speeds=_top_speeds(chassis) if limited else (),
        polytope=_polytope(chassis) if limited else {},
    )


def as_dict(robot: "Robot | Chassis") -> dict[str, Any]:
    """The summary as JSON-able values."""
    return asdict(summarise(robot))


def as_text(robot: "Robot | Chassis") -> str:
    """The summary for a terminal."""
    s = summarise(robot)
    kinds = ", ".join(f"{name} ({kind})" for name, kind in zip(s.wheels, s.kinds, strict=True))
    spare = f"{s.redundancy} to spare" if s.redundancy else "none to spare: wheels cannot contradict each other"
    lines = [
        *([s.name] if s.name else []),
        f"wheels     {kinds}",
        f"rank       {s.rank} of 3, {len(s.rows)} equations ({spare})",
        f"condition  {s.condition:.4g} (1 is perfect, above 10 is poor), L_c {s.characteristic_length_m:.4g} m",
        *(f"warning    {text}" for text in s.warnings),
        "",
        *_matrix_text("Jacobian: wheel = J . (vx, vy, omega)", s.rows, s.jacobian, ("vx", "vy", "omega")),
        "",
        *_matrix_text("forward: (vx, vy, omega) = F . wheel", ("vx", "vy", "omega"), s.forward, None),
    ]
    if s.top_speeds:
        lines += ["", "top speeds", *(_speed_text(top) for top in s.top_speeds), "", _polytope_text(s.polytope)]
    else:
        lines += ["", "no top speeds: not every wheel has a max_speed"]
    return "\n".join(lines)


def latex(robot: "Robot | Chassis", digits: int = 5) -> str:
    """The inverse kinematics as a LaTeX equation."""
    s = summarise(robot)
    left = r" \\ ".join(_latex_name(name) for name in s.rows)
    rows = r" \\ ".join(" & ".join(f"{value:.{digits}g}" for value in row) for row in s.jacobian)
    return (
        rf"\begin{{bmatrix}} {left} \end{{bmatrix}} = \begin{{bmatrix}} {rows} \end{{bmatrix}} "
        r"\begin{bmatrix} v_x \\ v_y \\ \omega \end{bmatrix}"
    )


def _row_names(chassis: Chassis) -> tuple[str, ...]:
    """`front [rad/s]`, or `fl along [m/s]` and `fl across [m/s]`."""
    names: list[str] = []
    for wheel in chassis.wheels:
        names += [f"{wheel.name} along [m/s]", f"{wheel.name} across [m/s]"] if wheel.steered else []
        names += [] if wheel.steered else [f"{wheel.name} [rad/s]"]
    return tuple(names)


def _top_speeds(chassis: Chassis) -> tuple[TopSpeed, ...]:
    polytope = chassis.polytope
    turn = polytope.turn_in_place
    ways = [("ahead", float(chassis.max_speed(0.0)), 0.0), ("left", float(chassis.max_speed(math.pi / 2)), math.pi / 2)]
    ways += [("slowest direction", *polytope.slowest), ("fastest direction", *polytope.fastest)]
    tops = [
        TopSpeed(what, twist, speed, math.degrees(angle), _binding(chassis, twist))
        for what, speed, angle in ways
        for twist in [(speed * math.cos(angle), speed * math.sin(angle), 0.0)]
    ]
    return (
        *tops[:2],
        TopSpeed("turn in place", (0.0, 0.0, turn), turn, None, _binding(chassis, (0, 0, turn))),
        *tops[2:],
    )


def _binding(chassis: Chassis, twist: tuple[float, float, float]) -> tuple[str, ...]:
    from holodrive.kinematics.limits import loads

    load = loads(chassis, twist)
    return tuple(name for name, value in zip(chassis.names, load, strict=True) if value > 1.0 - 1e-9)


def _polytope(chassis: Chassis) -> dict[str, Any]:
    polytope = chassis.polytope
    return {
        "exact": polytope.exact,
        "corners": len(polytope.vertices) if polytope.exact else None,
        "vertices": _rows(polytope.vertices) if polytope.exact else None,
        "section": _rows(polytope.section(0.0)),
        "max_omega_rad_s": polytope.max_omega,
        "volume_m2_rad_s3": polytope.volume,
    }


def _polytope_text(polytope: dict[str, Any]) -> str:
    shape = f"{polytope['corners']} corners" if polytope["exact"] else "smooth sides (steered wheels)"
    return (
        f"speed polytope: {shape}, volume {polytope['volume_m2_rad_s3']:.4g} m^2 rad/s^3, "
        f"largest yaw rate {polytope['max_omega_rad_s']:.4g} rad/s"
    )


def _speed_text(top: TopSpeed) -> str:
    value = f"{top.value:.4g} rad/s" if top.direction_deg is None else f"{top.value:.4g} m/s"
    towards = "" if top.direction_deg is None else f"at {top.direction_deg:.4g} deg"
    return f"  {top.what:<18} {value:<14} {towards:<14} bound by {', '.join(top.binding)}"


def _matrix_text(
    title: str, names: tuple[str, ...], matrix: tuple[tuple[float, ...], ...], columns: tuple[str, ...] | None
) -> list[str]:
    width = max(len(name) for name in names)
    head = [f"  {'':<{width}} {''.join(f'{column:>11}' for column in columns)}"] if columns else []
    body = [
        f"  {name:<{width}} " + "".join(f"{value + 0.0:>11.5g}" for value in row)
        for name, row in zip(names, matrix, strict=True)
    ]
    return [title, *head, *body]


def _rows(matrix: Any) -> tuple[tuple[float, ...], ...]:
    return tuple(tuple(float(value) for value in row) for row in matrix)


def _latex_name(row: str) -> str:
    name, _, rest = row.partition(" ")
    symbol, name = ("v" if rest.startswith("a") else r"\omega"), name.replace("_", r"\_")
    part = {"along": r",\parallel", "across": r",\perp"}.get(rest.split()[0], "")
    return rf"{symbol}_{{\mathrm{{{name}}}{part}}}"
