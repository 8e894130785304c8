"""Plain-float kinematics of one chassis, written as Python source from its matrices and compiled once.

One tick of control in plain Python is several times faster than in NumPy, whose calls cost most of a microsecond
each. So the maps of a chassis are unrolled into straight-line functions: terms that are zero are left out, products
and rows that occur twice are computed once. The matrices are those of `Chassis`; tests prove the two equal.
"""

import math
from collections.abc import Callable, Iterable, Sequence
from functools import cached_property
from typing import TYPE_CHECKING, Any

from holodrive.kinematics.caster_scalar import forward_of, steady
from holodrive.types import Array

if TYPE_CHECKING:
    from holodrive.kinematics.chassis import Chassis

_SAME = 1e-14  # coefficients this near to each other are one number with rounding


class Scalar:
    """`inverse` and `forward` of a chassis for plain floats.

    Attributes:
        inverse: (vx, vy, omega) -> tuple of n wheel speeds [rad/s], then m steering angles [rad] (polar form).
        forward: (n wheel speeds, then m steering angles; with casters then m steering rates) -> (vx, vy, omega) by
            least squares.
        source: the text of both functions; with casters `forward` has none, for its matrix changes with the angles.
    """

    def __init__(self, chassis: "Chassis") -> None:
        self._chassis = chassis
        self.source = inverse_source(chassis)
        if not chassis.castered:
            self.source += "\n\n" + forward_source(chassis)
        functions = compile_functions(self.source, "scalar kinematics", steady=steady)
        self.inverse: Callable[[float, float, float], tuple[float, ...]] = functions["inverse"]
        self.forward: Callable[..., tuple[float, float, float]] = functions.get("forward") or forward_of(chassis)

    @cached_property
    def command_step(self) -> Callable[..., Any]:
        """The whole command step, with the wheels' limits only; see `scalar_step.command_step`."""
        from holodrive.kinematics.scalar_step import command_step

        return command_step(self._chassis)


def compile_functions(source: str, name: str, **names: Any) -> dict[str, Any]:
    """The functions that a source text defines; they see the maths functions and `names`."""
    space: dict[str, Any] = {
        "sqrt": math.sqrt,
        "atan2": math.atan2,
        "cos": math.cos,
        "sin": math.sin,
        "inf": math.inf,
        **names,
    }
    exec(compile(source, f"<{name}>", "exec"), space)
    return space


def inverse_source(chassis: "Chassis") -> str:
    """`inverse` as text."""
    lines, rows = linear_maps(chassis.jacobian, ("vx", "vy", "omega"), "p")
    speeds, angles = [], []
    for wheel, row in zip(chassis.wheels, chassis.row, strict=True):
        if wheel.steered:
            a, b = _bind(lines, rows[row], f"a{row}"), _bind(lines, rows[row + 1], f"b{row}")
            if wheel.caster:
                lines.append(f"u{row}, d{row} = steady({a}, {b}, omega, {wheel.caster!r})")
                speeds.append(f"u{row}{times(1.0 / wheel.radius)}")
                angles.append(f"d{row}")
                continue
            speeds.append(f"sqrt({a} * {a} + {b} * {b}){times(1.0 / wheel.radius)}")
            angles.append(f"atan2({b}, {a})")
        else:
            speeds.append(rows[row])
    return function("inverse", ["vx", "vy", "omega"], [*lines, f"return ({', '.join(speeds + angles)},)"])


def forward_source(chassis: "Chassis") -> str:
    """`forward` as text."""
    speeds = [f"w{i}" for i in range(len(chassis.wheels))]
    angles = [f"d{j}" for j in range(len(chassis.steered))]
    lines, rows = [], []
    for i, wheel in enumerate(chassis.wheels):
        if wheel.steered:
            angle = angles[chassis.steered.index(i)]
            lines += [
                f"t{i} = w{i}{times(wheel.radius)}",
                f"a{i} = t{i} * cos({angle})",
                f"b{i} = t{i} * sin({angle})",
            ]
            rows += [f"a{i}", f"b{i}"]
        else:
            rows.append(f"w{i}")
    twist = [grouped_sum(row, rows) for row in chassis.least_squares]
    return function("forward", speeds + angles, [*lines, f"return ({', '.join(twist)})"])


def function(name: str, arguments: Iterable[str], lines: Iterable[str]) -> str:
    """A function's text."""
    return f"def {name}({', '.join(arguments)}):\n" + "\n".join(f"    {line}" for line in lines)


def linear_maps(matrix: Array, variables: Sequence[str], prefix: str) -> tuple[list[str], list[str]]:
    """Lines that prepare shared products, and one expression for each row of `matrix` . variables."""
    known: list[tuple[float, str, str]] = []  # magnitude, variable, name of the product
    lines: list[str] = []
    counts = [(abs(float(c)), v) for row in matrix for c, v in zip(row, variables, strict=True)]
    expressions = []
    for row in matrix:
        terms = []
        for value, variable in zip(row, variables, strict=True):
            size = abs(float(value))
            if size == 0.0:
                continue
            text = next((t for s, v, t in known if v == variable and _same(s, size)), "")
            if not text:
                text = f"{variable}{times(size)}"
                if size != 1.0 and sum(v == variable and _same(s, size) for s, v in counts) > 1:
                    lines.append(f"{prefix}{len(lines)} = {text}")
                    text = f"{prefix}{len(lines) - 1}"
                known.append((size, variable, text))
            terms.append((value < 0.0, text))
        expressions.append(signed_sum(terms))
    return lines, expressions


def grouped_sum(coefficients: Array, variables: Sequence[str]) -> str:
    """Sum of coefficient * variable, with equal coefficients taken out of brackets."""
    groups: list[tuple[float, list[tuple[bool, str]]]] = []
    for value, variable in zip(coefficients, variables, strict=True):
        size = abs(float(value))
        if size == 0.0:
            continue
        group = next((terms for s, terms in groups if _same(s, size)), None)
        if group is None:
            groups.append((size, group := []))
        group.append((value < 0.0, variable))
    return signed_sum([(False, f"({signed_sum(terms)}){times(size)}") for size, terms in groups])


def signed_sum(terms: Sequence[tuple[bool, str]]) -> str:
    """`a - b + c` from (is negative, text) pairs."""
    if not terms:
        return "0.0"
    ordered = sorted(terms, key=lambda term: term[0])  # a positive term first saves a negation
    first = ("-" if ordered[0][0] else "") + ordered[0][1]
    return first + "".join(f" {'-' if negative else '+'} {text}" for negative, text in ordered[1:])


def _bind(lines: list[str], expression: str, name: str) -> str:
    """A name for an expression: one that exists already where the text is the same."""
    if expression.isidentifier():
        return expression
    for line in lines:
        known, _, text = line.partition(" = ")
        if text == expression:
            return known
    lines.append(f"{name} = {expression}")
    return name


def times(value: float) -> str:
    """Text that multiplies by a number."""
    return "" if value == 1.0 else f" * {value!r}"


def _same(a: float, b: float) -> bool:
    return abs(a - b) <= _SAME * max(a, b)
