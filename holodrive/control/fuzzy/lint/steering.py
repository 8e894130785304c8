"""Lint of steering: rules of a system that reads ranges to the left and right and commands a left and a right wheel.

The wheels' conclusions say which way a rule turns: right minus left above zero turns left. A conclusion counts with
the mean of what it is worth on both wheels, so that output sets that differ a little do not count as turning.
"""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from holodrive.control.fuzzy.lint.finding import Finding, numbers
from holodrive.control.fuzzy.lint.mirror import Sides
from holodrive.control.fuzzy.lint.outputs import conclusion
from holodrive.control.fuzzy.shape import breaks, shapes
from holodrive.control.fuzzy.system import System, Variable

_BEHIND = ("back", "rear", "behind", "aft", "tail")


@dataclass(frozen=True)
class _Move:
    """What one rule makes the robot do, and what it knows of both sides (ranks of nearness, 0 is the nearest)."""

    number: int
    left: int
    right: int
    left_wheel: float
    right_wheel: float

    @property
    def turn(self) -> float:
        """Above zero turns left (counter-clockwise seen from above)."""
        return self.right_wheel - self.left_wheel

    @property
    def backs(self) -> bool:
        """Both wheels run backward."""
        return self.left_wheel < 0.0 and self.right_wheel < 0.0

    @property
    def toward(self) -> bool:
        """The nose turns to the side that is nearer."""
        return (self.right - self.left) * self.turn > 0.0


def check_steering(system: System, sides: Sides) -> Iterator[Finding]:
    """Rules that turn toward the nearer side, pass a near side straight, back straight, or back blindly."""
    if not sides.drives or (system.kind == "sugeno" and _moving(system)):
        return
    moves = list(_moves(system, sides))
    left, right = (system.inputs[i].name for i in sides.inputs[0])
    for move in moves:
        if move.toward and not move.backs:
            yield _toward(move, left if move.turn > 0.0 else right)
    back = tuple(m.number for m in moves if m.toward and m.backs)
    if back:
        # rolling back while yawing left bends the way to the right, clear of the near side on the left; but the
        # nose comes to point at it, and whatever drives forward next goes there
        yield Finding(
            "F-TOWARD-BACK", "warning",
            f"{numbers(back)} back up and yaw{'s' * (len(back) == 1)} the nose toward the nearer side, where the next "
            "forward motion will head",
            rules=back,
        )  # fmt: skip
    straight = tuple(m.number for m in moves if _passes_straight(m))
    if straight:
        goes = "goes" if len(straight) == 1 else "go"
        text = f"{numbers(straight)} {goes} straight past a side that is near although the other is farther"
        yield Finding("F-STRAIGHT", "warning", text, rules=straight)
    open_side = tuple(m.number for m in moves if m.backs and m.turn == 0.0 and max(m.left, m.right) > 0)
    if open_side:
        backs = "backs" if len(open_side) == 1 else "back"
        text = f"{numbers(open_side)} {backs} straight although a side is not near, so the same obstacle comes again"
        yield Finding("F-BACK", "warning", text, rules=open_side)
    blind = tuple(m.number for m in moves if m.backs)
    if blind and not any(word in v.name.lower() for v in system.inputs for word in _BEHIND):
        text = f"{numbers(blind)} run{'s' * (len(blind) == 1)} both wheels backward, and no input looks behind"
        yield Finding("F-BLIND", "info", text, rules=blind)


def _toward(move: _Move, side: str) -> Finding:
    text = f"rule {move.number} turns toward {side}, the nearer side"
    return Finding("F-TOWARD", "error", text, variable=side, rules=(move.number,))


def _passes_straight(move: _Move) -> bool:
    near = min(move.left, move.right) == 0 and move.left != move.right
    return near and move.turn == 0.0 and move.left_wheel > 0.0


def _moves(system: System, sides: Sides) -> Iterator[_Move]:
    """Those of rules that name both sides and both wheels and join them by AND."""
    (left, right), (wheel_left, wheel_right) = sides.inputs[0], sides.outputs[0]
    ranks = {i: nearness(system.inputs[i]) for i in (left, right)}
    worth = _worth(system, wheel_left, wheel_right)
    for number, rule in enumerate(system.rules, 1):
        a, b, u, v = rule.inputs[left], rule.inputs[right], rule.outputs[wheel_left], rule.outputs[wheel_right]
        if rule.connective == "and" and rule.weight > 0.0 and a > 0 and b > 0 and u and v:
            yield _Move(number, ranks[left][a - 1], ranks[right][b - 1], worth[0][u - 1], worth[1][v - 1])


def _worth(system: System, left: int, right: int) -> tuple[list[float], list[float]]:
    """What each conclusion is worth on the left and on the right; sets of one name share the mean of both."""
    outputs = system.outputs[left], system.outputs[right]
    full = [
        [conclusion(system, k, i)[1] for i in range(1, len(v.sets) + 1)]
        for k, v in zip((left, right), outputs, strict=True)
    ]
    names = [[one.name for one in v.sets] for v in outputs]
    for i, name in enumerate(names[0]):
        if name in names[1]:
            j = names[1].index(name)
            full[0][i] = full[1][j] = 0.5 * (full[0][i] + full[1][j])
    return full[0], full[1]


def nearness(variable: Variable) -> list[int]:
    """Rank of each set of a range by its centre, 0 for the nearest."""
    centres = []
    for curve in shapes(variable):
        places = breaks([curve], variable.low, variable.high)
        a, b, width = curve.after(places[:-1]), curve.before(places[1:]), np.diff(places)
        area = np.sum(0.5 * (a + b) * width)
        moment = np.sum(width * (places[:-1] * (2.0 * a + b) + places[1:] * (a + 2.0 * b)) / 6.0)
        centres.append(float(moment / area) if area > 0.0 else float(curve.x[0]))
    order = np.argsort(centres, kind="stable")
    ranks = [0] * len(centres)
    for rank, index in enumerate(order.tolist()):
        ranks[index] = rank
    return ranks


def _moving(system: System) -> bool:
    """Whether conclusions move with the inputs, so that no rule has one way to turn."""
    return any(one.kind == "linear" for v in system.outputs for one in v.sets)
