"""The worked example, equations 17 to 30: every printed number beside what the paper's own equations give.

A number is computed twice: from the rounded numbers that the paper puts into the equation, and from the positions and
headings alone with nothing rounded on the way. It agrees when either of them rounds to it.
"""

import math
from dataclasses import dataclass
from itertools import pairwise

from holodrive.experiments.claims import Claim, Verdict
from holodrive.experiments.experiment import Result, Setting
from holodrive.experiments.mecanum import mapping, printed
from holodrive.experiments.mecanum.printed import EXAMPLE, Moment


@dataclass(frozen=True)
class Number:
    """A number of the example.

    Attributes:
        where, what: equation and quantity.
        printed: as it stands there, with `digits` after the point.
        stepwise: by the equation from the printed numbers before it.
        exact: from positions and headings alone.
        unit: of all.
        note: why a misprint is one.
    """

    where: str
    what: str
    printed: float
    stepwise: float
    exact: float
    digits: int
    unit: str = ""
    note: str = ""

    @property
    def agrees(self) -> bool:
        """Whether one of the two computed values rounds to the printed one."""
        return any(abs(self.printed - value) <= 0.5001 * 10.0**-self.digits for value in (self.stepwise, self.exact))

    @property
    def verdict(self) -> Verdict:
        """A number that fits neither way of computing contradicts its own equation."""
        return "agrees" if self.agrees else "contradicts itself"


def example(setting: Setting) -> Result:
    """Claims about the worked example."""
    listed = numbers()
    claims = tuple(
        Claim(n.where, n.what, n.printed, n.exact, n.verdict, n.unit, n.note or _rounding(n)) for n in listed
    )
    wrong = [n for n in listed if not n.agrees]
    data = {
        "numbers": [
            {"where": n.where, "what": n.what, "printed": n.printed, "stepwise": n.stepwise, "exact": n.exact}
            for n in listed
        ],
        "misprints": [{"where": n.where, "printed": n.printed, "by_equation": n.stepwise} for n in wrong],
    }
    return Result((*claims, _limit(), _shrinking()), data=data)


def numbers() -> list[Number]:
    """All numbers of the example in reading order."""
    return [number for moment in EXAMPLE for number in _moment(moment)]


def _moment(m: Moment) -> list[Number]:
    """The numbers of one time step, each from those before it."""
    k = m.number
    away = (m.position[0] - printed.TARGET[0], m.position[1] - printed.TARGET[1])
    bearing, distance = math.degrees(math.atan2(away[1], away[0])), math.hypot(*away)
    exact_angle = bearing + m.heading_deg
    exact_gains = mapping.printed_gains(exact_angle)
    found = [
        Number("text", f"α at k = {k}", m.bearing_deg, bearing, bearing, 1, "°",
               _bearing_note(m, away, bearing)),
        Number(m.equations[0], f"θ at k = {k}", m.angle_deg, m.bearing_deg + m.heading_deg, exact_angle, 1, "°"),
    ]  # fmt: skip
    step_gains = mapping.printed_gains(m.angle_deg)
    for j, pair in enumerate(mapping.PAIRS):
        found.append(Number(m.equations[1], f"gain of {pair} at k = {k}", m.gains[j], step_gains[j], exact_gains[j], 2))
    found.append(Number(m.equations[2], f"error at k = {k}", m.error, distance, distance, 2 if k else 1, "units"))
    output, exact_output = printed.POSITION_KP * m.error, printed.POSITION_KP * distance
    found.append(Number(m.equations[3], f"output at k = {k}", m.output, output, exact_output, 2 if k else 1))
    for j, pair in enumerate(mapping.PAIRS):
        stepwise, exact = m.output * m.gains[j], exact_output * exact_gains[j]
        one = Number(m.equations[4], f"input of {pair} at k = {k}", m.inputs[j], stepwise, exact, 2 if k else 1, "mm/s")
        found.append(one if one.agrees else _misprint(one, m.output, m.gains[j]))
    return found


def _bearing_note(m: Moment, away: tuple[float, float], bearing: float) -> str:
    if abs(m.bearing_deg - bearing) <= 0.05:
        return ""
    return f"atan({away[1]:g}/{away[0]:g}) = {bearing:.2f}°; with it θ is {bearing + m.heading_deg:.2f}°"


def _misprint(number: Number, output: float, gain: float) -> Number:
    """The same number with its own equation worked out, and the swapped digits that explain it."""
    note = f"{_product(output, gain)} = {number.stepwise:.2f}; unrounded {number.exact:.2f}".replace("-", "−")
    swapped = math.copysign(float(f"0.{f'{abs(gain):.2f}'[:1:-1]}"), gain)
    if abs(output * swapped - number.printed) <= 0.005:
        note += f"; the printed value is {_product(output, swapped)}: digits of the gain swapped".replace("-", "−")
    elif sorted(f"{abs(number.printed):.2f}") == sorted(f"{abs(number.stepwise):.2f}"):
        note += "; digits of the result swapped"
    return Number(number.where, number.what, number.printed, number.stepwise, number.exact, number.digits,
                  number.unit, note)  # fmt: skip


def _product(output: float, gain: float) -> str:
    return f"{output:g} × ({gain:g})" if gain < 0.0 else f"{output:g} × {gain:g}"


def _rounding(n: Number) -> str:
    if abs(n.printed - n.exact) <= 0.5001 * 10.0**-n.digits:
        return ""
    return f"{_shown(n.stepwise, n.digits)} from the rounded numbers before it"


def _limit() -> Claim:
    """The first command of the example is one that the robot cannot follow."""
    return Claim(
        "Eq. 20, Section III", "speed asked of W2W3 backward", EXAMPLE[0].output, printed.SPEED_LIMIT, "cannot be",
        "mm/s", f"the paper allows {printed.SPEED_LIMIT:g} mm/s, and does not say what it does beyond that; here both "
        "pairs are scaled by one factor, which keeps the direction",
    )  # fmt: skip


def _shrinking() -> Claim:
    """'The inputs for motor driver (velocity) decreases as the MWR approaches desired position'."""
    largest = [max(abs(value) for value in m.inputs) for m in EXAMPLE]
    falls = all(later < earlier for earlier, later in pairwise(largest))
    first = ", ".join(f"{abs(m.output * m.gains[0]):.2f}" for m in EXAMPLE)
    found = ", ".join(f"{value:g}" for value in largest)
    return Claim(
        "text on Eq. 30", "inputs fall as the robot comes nearer", "yes", f"{found} mm/s",
        "agrees" if falls else "contradicts itself",
        note=f"of the faster pair; that of W1W4 goes {first} mm/s, because the direction changes",
    )  # fmt: skip


def _shown(value: float, digits: int) -> str:
    return f"{value + 0.0:.{digits}f}".replace("-", "−")
