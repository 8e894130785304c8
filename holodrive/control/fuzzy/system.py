"""A fuzzy system as it is described: variables with their sets, rules, and how they are joined.

Values only. `pack` makes the flat vector that the kernel reads (`control.fuzzy.kernel`), files become systems in
`control.fuzzy.files`. Numbers are in the system's own units (the first paper's: mm in, -300..300 out).
"""

import math
from dataclasses import dataclass, field
from functools import cache, cached_property
from types import ModuleType
from typing import TYPE_CHECKING, Literal, get_args

from numpy.typing import ArrayLike

from holodrive.control.fuzzy.sets import Set
from holodrive.errors import InputError, UnknownName
from holodrive.types import Array

if TYPE_CHECKING:
    from holodrive.control.fuzzy.explain import Explanation
    from holodrive.control.fuzzy.lint import Finding, Mirror

Kind = Literal["mamdani", "sugeno"]
Conjunction = Literal["min", "prod", "bounded"]  # AND: min(a, b), a b, max(0, a + b - 1)
Disjunction = Literal["max", "probor", "bounded"]  # OR: max(a, b), a + b - a b, min(1, a + b)
Implication = Literal["min", "prod"]  # a rule's strength cuts its conclusion, or scales it
Aggregation = Literal["max", "sum"]  # of the conclusions of all rules; "sum" is not cut at 1, as in MATLAB
# som and lom are the leftmost and the rightmost of the highest places (MATLAB: the least and greatest in magnitude)
Defuzzification = Literal["centroid", "bisector", "mom", "som", "lom", "wtaver", "wtsum"]

_CHOICES = {
    "kind": Kind,
    "conjunction": Conjunction,
    "disjunction": Disjunction,
    "implication": Implication,
    "aggregation": Aggregation,
    "defuzzification": Defuzzification,
}
WEIGHTED = ("wtaver", "wtsum")  # the two of Sugeno systems


@dataclass(frozen=True)
class Variable:
    """An input or output.

    Attributes:
        name: as rules and files call it.
        low, high: its universe.
        sets: Mamdani inputs and outputs have fuzzy sets, a Sugeno system's outputs constants or linear functions.
        default: what an output is where no rule fires, NaN when that is left to the caller.
        unit: for people, such as "mm"; no file format but FCL's comments has it.
    """

    name: str
    low: float
    high: float
    sets: tuple[Set, ...] = ()
    default: float = math.nan
    unit: str = ""

    def __post_init__(self) -> None:
        if not (math.isfinite(self.low) and math.isfinite(self.high) and self.low < self.high):
            raise InputError(
                f"variable {self.name!r} has the range {self.low:g} to {self.high:g}; it must be finite and rise"
            )
        names = [one.name for one in self.sets]
        if twice := sorted({name for name in names if names.count(name) > 1}):
            raise InputError(f"variable {self.name!r} has the set {twice[0]!r} twice; names of sets must differ")
        if math.isinf(self.default):
            raise InputError(
                f"variable {self.name!r} has the default {self.default:g}; it must be finite, or NaN for none"
            )
        if math.isnan(self.default):
            object.__setattr__(self, "default", math.nan)  # one and the same NaN, so that equal variables are equal

    def __reduce__(self) -> tuple[type["Variable"], tuple[object, ...]]:
        return Variable, (self.name, self.low, self.high, self.sets, self.default, self.unit)

    def index(self, name: str) -> int:
        """Number of a set, from 1 as rules count.

        Raises:
            UnknownName: no such set.
        """
        for number, one in enumerate(self.sets, 1):
            if one.name == name:
                return number
        raise UnknownName(f"set of {self.name}", name, [one.name for one in self.sets])


@dataclass(frozen=True)
class Rule:
    """IF inputs THEN outputs. Sets are numbered from 1; 0 is "don't care" (input) or "says nothing" (output).

    Attributes:
        inputs: one number for each input; a negative one is NOT that set.
        outputs: one number for each output, 0 or more.
        weight: in [0, 1].
        connective: how the inputs are joined.
    """

    inputs: tuple[int, ...]
    outputs: tuple[int, ...]
    weight: float = 1.0
    connective: Literal["and", "or"] = "and"


@dataclass(frozen=True)
class System:
    """A Mamdani or Sugeno system.

    Attributes:
        name: for people and files.
        inputs, outputs: in the order of `evaluate`.
        rules: in the order of the file; people count them from 1.
        kind, conjunction, disjunction, implication, aggregation, defuzzification: how rules are joined.
        fuzzylab: behave as the library of the first paper does (fuzzylab 0.13): centroid over 101 samples, the two
            outputs swapped (of more, the first comes last), no clamping, NaN where no rule fires.
        source: where it comes from.
    """

    name: str
    inputs: tuple[Variable, ...]
    outputs: tuple[Variable, ...]
    rules: tuple[Rule, ...]
    kind: Kind = "mamdani"
    conjunction: Conjunction = "min"
    disjunction: Disjunction = "max"
    implication: Implication = "min"
    aggregation: Aggregation = "max"
    defuzzification: Defuzzification = "centroid"
    fuzzylab: bool = False
    source: str = field(default="", compare=False)

    def __post_init__(self) -> None:
        for name, choices in _CHOICES.items():
            if getattr(self, name) not in get_args(choices):
                raise UnknownName(f"{name} of a fuzzy system", str(getattr(self, name)), get_args(choices))
        if not (self.inputs and self.outputs and self.rules):
            raise InputError(f"fuzzy system {self.name!r} needs inputs, outputs and rules; one of them is missing")
        if (self.kind == "sugeno") != (self.defuzzification in WEIGHTED):
            raise InputError(
                f"fuzzy system {self.name!r} is {self.kind} and cannot defuzzify by {self.defuzzification!r}; "
                f"sugeno: {', '.join(WEIGHTED)}; mamdani: {', '.join(set(get_args(Defuzzification)) - set(WEIGHTED))}"
            )
        if self.fuzzylab and not self._fuzzylab_can():
            raise InputError(
                f"fuzzy system {self.name!r} cannot behave as fuzzylab does, which knows min, max, prod, cut sets, "
                "their maximum, centroid and weighted mean only, and neither NOT nor conclusions left out"
            )
        self._check_names()
        self._check_sets()
        for number, rule in enumerate(self.rules, 1):
            self._check_rule(number, rule)

    def _fuzzylab_can(self) -> bool:
        joins = self.conjunction != "bounded" and self.disjunction == "max" and self.implication == "min"
        return (
            joins
            and self.aggregation == "max"
            and self.defuzzification in ("centroid", "wtaver")
            and all(number >= 0 for rule in self.rules for number in rule.inputs)
            and all(number > 0 for rule in self.rules for number in rule.outputs)
            and not any(one.kind in ("bell", "polyline", "singleton", "linear") for one in self._all_sets())
        )

    def _all_sets(self) -> list[Set]:
        return [one for variable in (*self.inputs, *self.outputs) for one in variable.sets]

    def _check_names(self) -> None:
        for what, variables in (("inputs", self.inputs), ("outputs", self.outputs)):
            names = [one.name for one in variables]
            if twice := sorted({name for name in names if names.count(name) > 1}):
                raise InputError(f"fuzzy system {self.name!r} has two {what} called {twice[0]!r}; names must differ")

    def _check_sets(self) -> None:
        for variable in self.outputs:
            singletons = [one.kind == "singleton" for one in variable.sets]
            if any(singletons) and not all(singletons):
                raise InputError(
                    f"output {variable.name!r} has singletons and sets with an area, which have no common centroid; "
                    "make all of them singletons or none"
                )
        for variable, is_output in [(one, False) for one in self.inputs] + [(one, True) for one in self.outputs]:
            sugeno = self.kind == "sugeno"
            for one in variable.sets:
                if one.is_conclusion != (is_output and sugeno):
                    raise InputError(
                        f"set {one.name!r} of {variable.name!r} is {one.kind!r}, which does not belong "
                        f"into {'an output' if is_output else 'an input'} of a {self.kind} system"
                    )
                if one.kind == "linear" and len(one.params) != len(self.inputs) + 1:
                    raise InputError(
                        f"set {one.name!r} of {variable.name!r} has {len(one.params)} coefficients; a linear "
                        f"conclusion of {len(self.inputs)} inputs has {len(self.inputs) + 1}, the constant last"
                    )

    def _check_rule(self, number: int, rule: Rule) -> None:
        for what, found, variables, least in (
            ("inputs", rule.inputs, self.inputs, -1),
            ("outputs", rule.outputs, self.outputs, 0),
        ):
            if len(found) != len(variables):
                raise InputError(f"rule {number} names {len(found)} {what}; the system has {len(variables)}")
            for index, variable in zip(found, variables, strict=True):
                if not least * len(variable.sets) <= index <= len(variable.sets):
                    raise InputError(
                        f"rule {number} names set {index} of {variable.name!r}, which has {len(variable.sets)} sets"
                    )
        if not 0.0 <= rule.weight <= 1.0:
            raise InputError(f"rule {number} has the weight {rule.weight:g}; it must be from 0 to 1")
        if not any(rule.inputs):
            raise InputError(f"rule {number} has no condition; at least one input must be named")

    def evaluate(self, x: ArrayLike, clamp: bool = True) -> Array:
        """Outputs (..., n_out) for inputs x (..., n_in); NaN where no rule fires or an input is NaN.

        Args:
            x: in the system's units.
            clamp: bring inputs into their universe first (one beyond its range is taken for its nearest end).
        """
        outputs: Array = _engine().evaluate(self, x, clamp)
        return outputs

    def explain(self, x: ArrayLike, clamp: bool = True) -> "Explanation":
        """Which rules fire at x (n_in,), how strongly, their share of each output, and what changes without them."""
        from holodrive.control.fuzzy.explain import explain

        return explain(self, x, clamp)

    def lint(
        self, sensor_range: tuple[float, float] | None = None, mirror: "Mirror | None" = None
    ) -> "tuple[Finding, ...]":
        """What is wrong or doubtful in the system, found by its break points; see `control.fuzzy.lint`.

        Args:
            sensor_range: smallest and largest number that the inputs' sensor can tell, in the system's units.
            mirror: pairs of a left and a right variable; found by their names when None, () for no such check.
        """
        from holodrive.control.fuzzy.lint import lint

        return lint(self, sensor_range, mirror)

    @cached_property
    def packed(self) -> Array:
        """The flat vector that the kernel reads; see `control.fuzzy.kernel`."""
        from holodrive.control.fuzzy.packing import pack

        packed = pack(self)
        packed.flags.writeable = False
        return packed

    def __getstate__(self) -> dict[str, object]:
        """Without what is made again when needed."""
        return {name: value for name, value in self.__dict__.items() if name != "packed"}

    def input_index(self, name: str) -> int:
        """Place of an input.

        Raises:
            UnknownName: no such input.
        """
        names = [one.name for one in self.inputs]
        if name not in names:
            raise UnknownName("fuzzy input", name, names)
        return names.index(name)


@cache
def _engine() -> ModuleType:
    """Loaded at the first call: it brings Numba, which a described system does not need."""
    from holodrive.control.fuzzy import evaluation

    return evaluation
