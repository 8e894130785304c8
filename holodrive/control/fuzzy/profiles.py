"""The first paper's controllers as they are printed, and the two that are derived from them, in the open.

All have the inputs DH, DL, DR (distances ahead, left, right [mm]) and the outputs L, R (commands of the left and the
right side, -300..300). `repaired` mends what `lint` finds in the printed ones; `tuned` has other input sets.
"""

from collections.abc import Callable, Iterator
from dataclasses import replace
from itertools import pairwise

from holodrive.control.fuzzy.sets import Set
from holodrive.control.fuzzy.system import Rule, System, Variable
from holodrive.errors import InputError, UnknownName

# Rules 1 to 27 run through DH, DL, DR = N, M, F, the last the fastest; each is (L, R) of N, NZ, PZ, P.
TABLE_VII = """
    N N    N NZ   N NZ    NZ N   N N    N N     NZ N   N N    N N
    PZ PZ  P PZ   P PZ    PZ P   PZ PZ  PZ PZ   PZ PZ  PZ PZ  PZ PZ
    PZ PZ  P PZ   P PZ    PZ P   P P    P P     PZ P   P P    P P
"""
TABLE_VIII = """
    N N    PZ NZ  PZ N    NZ PZ  P NZ   P N     N PZ   NZ P   PZ N
    PZ PZ  PZ PZ  P PZ    PZ PZ  PZ PZ  PZ PZ   PZ P   PZ PZ  P P
    PZ PZ  PZ PZ  PZ PZ   PZ PZ  PZ PZ  PZ PZ   P PZ   PZ PZ  P P
"""
# Of Table VIII, 25 turns into a near obstacle on the right and the other five go straight past a near side; all six
# are as Table VII prints them. Alone, rule 25 makes the most of Table VIII's collisions.
FROM_TABLE_VII = (11, 13, 20, 21, 22, 25)
# n_top, n_foot, m_top, f_foot, f_top [mm], found by CMA-ES over closed-loop runs in random worlds together with the
# other numbers of the controller's profile (control/fuzzy_avoidance.py says how)
TUNED_BREAKS_MM = (323.6, 411.4, 652.6, 573.2, 1841.0)


def names() -> tuple[str, ...]:
    """Of all profiles."""
    return tuple(_PROFILES)


def profile(name: str) -> System:
    """The profile of that name.

    Raises:
        UnknownName: no such profile.
    """
    if name not in _PROFILES:
        raise UnknownName("fuzzy profile", name, _PROFILES)
    return _PROFILES[name]()


def with_breaks(system: System, n_top: float, n_foot: float, m_top: float, f_foot: float, f_top: float) -> System:
    """The system with the same three sets N, M, F on all inputs, without a gap between them.

    N is the trapezoid (low, low, n_top, n_foot), M the triangle (n_top, m_top, f_top), F the trapezoid (f_foot, f_top,
    high, high), in the system's units: M reaches from where N is still 1 to where F is 1 already.

    Raises:
        InputError: numbers that leave a gap or make no sets, or inputs whose sets are not N, M and F.
    """
    for variable in system.inputs:
        _check_breaks(variable, n_top, n_foot, m_top, f_foot, f_top)
    inputs = tuple(
        replace(
            variable,
            sets=(
                Set("N", "trapezoid", (variable.low, variable.low, n_top, n_foot)),
                Set("M", "triangle", (n_top, m_top, f_top)),
                Set("F", "trapezoid", (f_foot, f_top, variable.high, variable.high)),
            ),
        )
        for variable in system.inputs
    )
    return replace(system, inputs=inputs)


def _check_breaks(variable: Variable, n_top: float, n_foot: float, m_top: float, f_foot: float, f_top: float) -> None:
    if [one.name for one in variable.sets] != ["N", "M", "F"]:
        found = ", ".join(one.name for one in variable.sets)
        raise InputError(f"input {variable.name!r} has the sets {found}; break points are for N, M, F in this order")
    low, high = variable.low, variable.high
    for rising in ((low, n_top, m_top, f_top, high), (n_top, n_foot), (f_foot, f_top)):
        if not all(a < b for a, b in pairwise(rising)):
            raise InputError(
                f"break points n_top {n_top:g}, n_foot {n_foot:g}, m_top {m_top:g}, f_foot {f_foot:g}, f_top {f_top:g} "
                f"leave a gap or make no sets; they need {low:g} < n_top < m_top < f_top < {high:g}, n_top < n_foot "
                "and f_foot < f_top"
            )
    if f_foot < low or n_foot > high:
        raise InputError(f"n_foot {n_foot:g} and f_foot {f_foot:g} must be within {low:g}..{high:g}")


def _input(name: str, middle: tuple[float, float, float], far: tuple[float, float]) -> Variable:
    sets = (
        Set("N", "trapezoid", (0.0, 0.0, 250.0, 500.0)),
        Set("M", "triangle", middle),
        Set("F", "trapezoid", (*far, 2500.0, 2500.0)),
    )
    return Variable(name, 0.0, 2500.0, sets, unit="mm")


def _output(name: str, *triangles: tuple[float, float, float]) -> Variable:
    sets = (Set(mark, "triangle", one) for mark, one in zip(("N", "NZ", "PZ", "P"), triangles, strict=True))
    return Variable(name, -300.0, 300.0, tuple(sets))


def _rules(table: str) -> Iterator[Rule]:
    numbers = [("N", "NZ", "PZ", "P").index(mark) + 1 for mark in table.split()]
    for k, outputs in enumerate(zip(numbers[::2], numbers[1::2], strict=True)):
        yield Rule((k // 9 + 1, k // 3 % 3 + 1, k % 3 + 1), outputs)


def _printed(name: str, table: str, source: str) -> System:
    return System(
        name=name,
        inputs=(
            _input("DH", (250.0, 750.0, 1500.0), (1000.0, 1500.0)),
            _input("DL", (500.0, 750.0, 1000.0), (750.0, 1000.0)),
            _input("DR", (250.0, 750.0, 1500.0), (500.0, 1500.0)),
        ),
        outputs=(
            _output("L", (-300, -200, -175), (-200, -150, -100), (100, 150, 250), (150, 200, 300)),
            _output("R", (-300, -200, -150), (-200, -150, -50), (100, 150, 200), (150, 200, 300)),
        ),
        rules=tuple(_rules(table)),
        source=source,
    )


def _paper_vii() -> System:
    return _printed("paper_vii", TABLE_VII, "first paper, section VI and Table VII, as printed")


def _paper_viii() -> System:
    return _printed("paper_viii", TABLE_VIII, "first paper, section VI and Table VIII, as printed")


def _repaired() -> System:
    """Table VIII with six rules of VII; DL hears as DR does (no hole at 500 mm), R speaks as L does (no drift)."""
    seven, eight = _paper_vii(), _paper_viii()
    dh, dl, dr = eight.inputs
    left, right = eight.outputs
    return replace(
        eight,
        name="repaired",
        inputs=(dh, replace(dl, sets=dr.sets), dr),
        outputs=(left, replace(right, sets=left.sets)),
        rules=tuple(
            seven.rules[number - 1] if number in FROM_TABLE_VII else rule for number, rule in enumerate(eight.rules, 1)
        ),
        source="first paper, Table VIII with rules 11, 13, 20, 21, 22, 25 of Table VII, DL's sets as DR's, R's as L's",
    )


def _tuned() -> System:
    return replace(
        with_breaks(_repaired(), *TUNED_BREAKS_MM), name="tuned", source="`repaired` with input sets found by CMA-ES"
    )


_PROFILES: dict[str, Callable[[], System]] = {
    "paper_vii": _paper_vii,
    "paper_viii": _paper_viii,
    "repaired": _repaired,
    "tuned": _tuned,
}
