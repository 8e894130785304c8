"""Quantities as text: "23 cm", "-45 deg", "25 kgf cm". Numbers alone are SI and radians.

A unit text is units multiplied by a space, `*` or `·`, divided by `/`, raised by `^2` or `²`;
everything after a `/` up to the next space divides once, as in "V s/rad".
The angle is kept as a dimension of its own, so that "5 Hz" is no yaw rate; only for motor constants,
where N m/A and V s/rad are the same thing, it does not count. All arithmetic is decimal with 40 digits and
rounded once, so that "51 mm" is the float 0.051.
"""

import math
import re
from collections.abc import Iterator
from dataclasses import dataclass
from decimal import Context, Decimal
from difflib import get_close_matches

Powers = tuple[int, int, int, int, int]  # of metre, kilogram, second, ampere, radian

_DECIMAL = Context(prec=40)
_PI = Decimal("3.141592653589793238462643383279502884197")
_NONE: Powers = (0, 0, 0, 0, 0)
_M, _KG, _S, _A, _RAD = (1, 0, 0, 0, 0), (0, 1, 0, 0, 0), (0, 0, 1, 0, 0), (0, 0, 0, 1, 0), (0, 0, 0, 0, 1)
_N, _V, _OHM, _H = (1, 1, -2, 0, 0), (2, 1, -3, -1, 0), (2, 1, -3, -2, 0), (2, 1, -2, -2, 0)
_HZ, _RAD_S, _C = (0, 0, -1, 0, 0), (0, 0, -1, 0, 1), (0, 0, 1, 1, 0)

_G0 = Decimal("9.80665")  # standard gravity, exact by definition
_INCH = Decimal("0.0254")
_POUND = Decimal("0.45359237")

UNITS: dict[str, tuple[Decimal, Powers]] = {
    "m": (Decimal(1), _M),
    "km": (Decimal(1000), _M),
    "cm": (Decimal("0.01"), _M),
    "mm": (Decimal("0.001"), _M),
    "um": (Decimal("1e-6"), _M),
    "in": (_INCH, _M),
    "ft": (12 * _INCH, _M),
    "kg": (Decimal(1), _KG),
    "g": (Decimal("0.001"), _KG),
    "lb": (_POUND, _KG),
    "s": (Decimal(1), _S),
    "ms": (Decimal("0.001"), _S),
    "us": (Decimal("1e-6"), _S),
    "min": (Decimal(60), _S),
    "h": (Decimal(3600), _S),
    "rad": (Decimal(1), _RAD),
    "mrad": (Decimal("0.001"), _RAD),
    "deg": (_PI / 180, _RAD),
    "rev": (2 * _PI, _RAD),
    "turn": (2 * _PI, _RAD),
    "rpm": (_DECIMAL.divide(2 * _PI, Decimal(60)), _RAD_S),
    "Hz": (Decimal(1), _HZ),
    "kHz": (Decimal(1000), _HZ),
    "N": (Decimal(1), _N),
    "mN": (Decimal("0.001"), _N),
    "kgf": (_G0, _N),
    "gf": (_G0 / 1000, _N),
    "lbf": (_POUND * _G0, _N),
    "ozf": (_POUND * _G0 / 16, _N),
    "V": (Decimal(1), _V),
    "mV": (Decimal("0.001"), _V),
    "A": (Decimal(1), _A),
    "mA": (Decimal("0.001"), _A),
    "ohm": (Decimal(1), _OHM),
    "mohm": (Decimal("0.001"), _OHM),
    "kohm": (Decimal(1000), _OHM),
    "H": (Decimal(1), _H),
    "mH": (Decimal("0.001"), _H),
    "uH": (Decimal("1e-6"), _H),
    "C": (Decimal(1), _C),
    "Ah": (Decimal(3600), _C),
    "mAh": (Decimal("3.6"), _C),
    "%": (Decimal("0.01"), _NONE),
}


@dataclass(frozen=True, slots=True)
class Dimension:
    """What a number measures.

    Attributes:
        phrase: "a length", as messages say it.
        si: the unit of a plain number, "" for a number without dimension.
        example: text that would be right.
        powers: of the SI base units and the radian.
        angle_counts: whether the radian must match too.
    """

    phrase: str
    si: str
    example: str
    powers: Powers
    angle_counts: bool = True

    @property
    def advice(self) -> str:
        """What to write."""
        unit = f" in {self.si}" if self.si else ""
        return f'write a number{unit} or text such as "{self.example}"'


DIMENSIONS: dict[str, Dimension] = {
    "number": Dimension("a plain number", "", "5 %", _NONE),
    "length": Dimension("a length", "m", "23 cm", _M),
    "angle": Dimension("an angle", "rad", "-45 deg", _RAD),
    "mass": Dimension("a mass", "kg", "3.26 kg", _KG),
    "time": Dimension("a time", "s", "10 ms", _S),
    "frequency": Dimension("a frequency", "Hz", "5.5 Hz", _HZ),
    "speed": Dimension("a speed", "m/s", "0.5 m/s", (1, 0, -1, 0, 0)),
    "acceleration": Dimension("an acceleration", "m/s^2", "1.5 m/s^2", (1, 0, -2, 0, 0)),
    "angular speed": Dimension("an angular speed", "rad/s", "22 rpm", _RAD_S),
    "angular acceleration": Dimension("an angular acceleration", "rad/s^2", "90 deg/s^2", (0, 0, -2, 0, 1)),
    "voltage": Dimension("a voltage", "V", "12 V", _V),
    "current": Dimension("a current", "A", "3 A", _A),
    "resistance": Dimension("a resistance", "ohm", "2.1 ohm", _OHM),
    "inductance": Dimension("an inductance", "H", "2.7 mH", _H),
    "charge": Dimension("a charge", "C", "2.3 Ah", _C),
    "torque": Dimension("a torque", "N m", "25 kgf cm", (2, 1, -2, 0, 0), False),
    "inertia": Dimension("a moment of inertia", "kg m^2", "0.086 kg m^2", (2, 1, 0, 0, 0), False),
    "motor constant": Dimension("a motor constant", "V s/rad", "33.5 mN m/A", (2, 1, -2, -1, 0), False),
    "voltage per angle": Dimension("a voltage per angle", "V/rad", "6 V/rad", (2, 1, -3, -1, -1)),
    "voltage per angular speed": Dimension(
        "a voltage per angular speed", "V s/rad", "0.3 V s/rad", (2, 1, -2, -1, 0), False
    ),
    "viscous friction": Dimension("a viscous friction", "N m s/rad", "0.002 N m s/rad", (2, 1, -1, 0, 0), False),
}


class QuantityError(ValueError):
    """A value that is not the quantity it should be; `hint` says what was perhaps meant."""

    def __init__(self, message: str, hint: str = "") -> None:
        self.hint = hint
        super().__init__(message)


# what people paste: other minus signs, other spaces, superscripts, other spellings
_SPELLINGS = str.maketrans(
    {"\u2212": "-", "\u2013": "-", "\u00a0": " ", "\u202f": " ", "\u2009": " ", "\u00b2": "^2", "\u00b3": "^3"}
    | {"\u00b7": " ", "\u22c5": " ", "*": " ", "\u00b5": "u", "\u03bc": "u", "\u03a9": "ohm", "\u2126": "ohm"}
    | {"\u00b0": "deg"}
)
_QUANTITY = re.compile(r"\s*([-+]?\s?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d{1,4}(?![\w.]))?)\s*(.*)", re.DOTALL)
_TOKEN = re.compile(r"\s*(/)?\s*([^\s/^]+)(?:\^(-?\d))?")
_LONGEST = 80  # characters: more is no quantity


def parse(value: object, dimension: str) -> float:
    """The SI number that a TOML value means.

    Args:
        value: an int or float (SI), or text with a unit.
        dimension: a key of `DIMENSIONS`.

    Raises:
        QuantityError: with one line that says what was found and what is allowed.
    """
    kind = DIMENSIONS[dimension]
    if isinstance(value, bool) or not isinstance(value, int | float | str):
        raise QuantityError(f"{shown(value)} is not {kind.phrase}; {kind.advice}")
    number = _from_text(value, kind) if isinstance(value, str) else _from_number(value)
    if not math.isfinite(number):
        raise QuantityError(f"{shown(value)} is not a finite number; {kind.advice}")
    return number


def _from_number(value: float) -> float:
    try:
        return float(value)
    except OverflowError:
        return math.inf


def _from_text(text: str, kind: Dimension) -> float:
    match = _QUANTITY.fullmatch(text.translate(_SPELLINGS)) if len(text) <= _LONGEST else None
    if match is None:
        raise QuantityError(f"{shown(text)} is not {kind.phrase}; {kind.advice}")
    digits, unit = match[1].replace(" ", ""), match[2].strip()
    if re.match(r",\d", unit):
        raise QuantityError(f"{shown(text)} has a decimal comma; write a point")
    if not unit:
        raise QuantityError(f"{shown(text)} has no unit; {kind.advice}")
    factor, powers = _unit(unit, text, kind)
    same = powers == kind.powers if kind.angle_counts else powers[:4] == kind.powers[:4]
    if not same:
        raise QuantityError(f"{shown(text)} is not {kind.phrase}; {kind.advice}")
    return float(_DECIMAL.multiply(Decimal(digits), factor))


def _unit(unit: str, text: str, kind: Dimension) -> tuple[Decimal, Powers]:
    factor, powers = Decimal(1), _NONE
    for name, power in _tokens(unit, text, kind):
        if name not in UNITS:
            near = sorted(get_close_matches(name, UNITS, n=3, cutoff=0.5), key=lambda unit: unit[0] != name[0])
            raise QuantityError(
                f"{shown(text)} has an unknown unit {shown(name)}; {kind.advice}",
                f"did you mean '{near[0]}'?" if near else "",
            )
        scale, own = UNITS[name]
        factor = _DECIMAL.multiply(factor, _DECIMAL.power(scale, power))
        m, kg, s, a, rad = (have + power * more for have, more in zip(powers, own, strict=True))
        powers = (m, kg, s, a, rad)
    return factor, powers


def _tokens(unit: str, text: str, kind: Dimension) -> Iterator[tuple[str, int]]:
    at = 0
    while at < len(unit):
        match = _TOKEN.match(unit, at)
        if match is None:
            raise QuantityError(f"{shown(text)} is not {kind.phrase}; {kind.advice}")
        power = int(match[3] or 1)
        yield match[2], -power if match[1] else power
        at = match.end()


def shown(value: object) -> str:
    """A TOML value as a message quotes it, shortened."""
    match value:
        case bool():
            text = "true" if value else "false"
        case dict():
            text = "a table"
        case list():
            text = "a list"
        case int() if abs(value) >= 10**30:
            text = "a number of too many digits"
        case str() | float():
            text = repr(value)
        case _:  # a whole number, a date or a time
            text = str(value)
    return _short(text)


def _short(text: str) -> str:
    return text if len(text) <= 60 else f"{text[:40]}...{text[-1]}"
