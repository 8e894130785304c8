"""A fuzzy system while its file is read: the parts, the lines in which they stand, and the faults found so far."""

import math
import re
from dataclasses import dataclass, field
from typing import Any

from holodrive.control.fuzzy.sets import Set, SetKind
from holodrive.control.fuzzy.system import Rule, System, Variable
from holodrive.errors import InputError, did_you_mean
from holodrive.files.source import Source

LARGEST = 2 * 1024 * 1024  # bytes of a file; some two thousand rules in FML, the longest of the formats
MOST_RULES = 5000

_NUMBER = re.compile(r"[+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?")


@dataclass(slots=True)
class DraftVariable:
    """An input or output of the file; `sets` holds None for a set that has a fault, so that numbers stay right."""

    name: str
    line: int
    low: float = math.nan
    high: float = math.nan
    default: float = math.nan
    unit: str = ""
    sets: dict[str, Set | None] = field(default_factory=dict)
    lines: dict[str, int] = field(default_factory=dict)

    @property
    def names(self) -> list[str]:
        """Of the sets; one that is there twice counts once."""
        return [name for name in self.sets if "\0" not in name]

    def find(self, name: str) -> int:
        """Number of a set, from 1; letter case counts only where two names differ in nothing else; 0 = none."""
        return position(list(self.sets), name)


@dataclass(slots=True)
class Draft:
    """What a file said so far. `system` gives the finished system, or raises all faults."""

    source: Source
    name: str = ""
    inputs: list[DraftVariable] = field(default_factory=list)
    outputs: list[DraftVariable] = field(default_factory=list)
    rules: list[Rule] = field(default_factory=list)
    options: dict[str, Any] = field(default_factory=dict)  # the other fields of System

    def fault(self, line: int, message: str, hint: str = "", column: int = 1) -> None:
        """Note a fault; line breaks in names become spaces, so that a fault stays one line."""
        self.source.fault_at(line, column, " ".join(message.split()), " ".join(hint.split()))

    def unknown(self, line: int, what: str, found: str, known: list[str], column: int = 1) -> None:
        """Note a name that there is not: the nearest one, and all those that there are."""
        known = list(dict.fromkeys(known))
        allowed = f"known: {', '.join(known)}" if known else f"there is no {what} at all"
        self.fault(line, f"no {what} called {found!r}{did_you_mean(found, known)}", allowed, column)

    def number(self, text: str, line: int, what: str, column: int = 1) -> float:
        """A finite number, or NaN and a fault."""
        value = float(text) if _NUMBER.fullmatch(text.strip()) else math.nan
        if not math.isfinite(value):
            self.fault(line, f"{what} is {text.strip()[:40]!r}; it must be a finite number", column=column)
            return math.nan
        return value

    def add_set(self, variable: DraftVariable, line: int, name: str, made: tuple[SetKind, list[float]] | None) -> None:
        """Append a set to a variable; `made` is its kind and parameters, None when a fault of them is noted already."""
        if name in variable.sets:
            variable.sets[f"{name}\0{line}"] = None  # so that the sets behind it keep their numbers
            self.fault(
                line,
                f"variable {variable.name!r} has the set {name!r} twice; the first is in line {variable.lines[name]}",
            )
            return
        variable.sets[name], variable.lines[name] = None, line
        if made is None or not all(math.isfinite(value) for value in made[1]):
            return
        kind, params = made
        if kind == "triangle" and len(params) == 3 and params[0] == params[2]:
            kind, params = "singleton", params[:1]  # how formats without singletons write them
        try:
            variable.sets[name] = Set(name, kind, tuple(params))
        except InputError as error:
            self.fault(line, str(error))

    def add_rule(self, line: int, rule: Rule) -> None:
        """Append a rule whose numbers are right."""
        if not 0.0 <= rule.weight <= 1.0:
            self.fault(line, f"the weight is {rule.weight:g}; it must be from 0 to 1")
        elif not any(rule.inputs):
            self.fault(line, "the rule has no condition; at least one input must be named")
        else:
            self.rules.append(rule)
            if len(self.rules) == MOST_RULES + 1:
                self.fault(line, f"more than {MOST_RULES} rules are not read")

    def system(self) -> System:
        """The finished system.

        Raises:
            FileFaults: all faults, with their lines.
        """
        for variable in (*self.inputs, *self.outputs):
            twin = next(one for one in (*self.inputs, *self.outputs) if one.name == variable.name)
            if twin is not variable:
                self.fault(
                    variable.line, f"variable {variable.name!r} is there twice; the first is in line {twin.line}"
                )
        self._check_kinds()
        inputs, outputs = self._finished(self.inputs), self._finished(self.outputs)
        for what, there in (("inputs", self.inputs), ("outputs", self.outputs), ("rules", self.rules)):
            if not there and not self.source.faults:
                self.fault(0, f"the file has no {what}", "a system has inputs, outputs and rules")
        self.source.refuse()
        try:
            return System(self.name, inputs, outputs, tuple(self.rules), source=self.source.file, **self.options)
        except InputError as error:
            self.fault(0, str(error))
            self.source.refuse()
            raise

    def _check_kinds(self) -> None:
        """Fuzzy sets and Sugeno conclusions in their places."""
        kind = self.options.get("kind", "mamdani")
        places = [(one, "an input", False) for one in self.inputs]
        places += [(one, "an output", kind == "sugeno") for one in self.outputs]
        for variable, where, conclusions in places:
            for name, one in variable.sets.items():
                if one is not None and one.is_conclusion != conclusions:
                    message = (
                        f"set {name!r} of {variable.name!r} is {one.kind!r}, which has no place in {where} of a {kind}"
                    )
                    self.fault(variable.lines[name], f"{message} system")

    def _finished(self, variables: list[DraftVariable]) -> tuple[Variable, ...]:
        done: list[Variable] = []
        for one in variables:
            sets = tuple(each for each in one.sets.values() if each is not None)
            try:
                done.append(Variable(one.name, one.low, one.high, sets, one.default, one.unit))
            except InputError as error:
                if not self.source.faults or math.isfinite(one.low + one.high):
                    self.fault(one.line, str(error))
        return tuple(done)


def position(names: list[str], name: str) -> int:
    """Place of a name, from 1; letter case counts only where two names differ in nothing else; 0 = none."""
    if name in names:
        return names.index(name) + 1
    alike = [number for number, one in enumerate(names, 1) if one.casefold() == name.casefold()]
    return alike[0] if len(alike) == 1 else 0


def opened(text: str, file: str) -> Draft:
    """A draft of a text.

    Raises:
        FileFaults: the text is empty or too large.
    """
    draft = Draft(Source(file, text.replace("\r\n", "\n").replace("\r", "\n")))
    if len(text) > LARGEST:
        draft.fault(0, f"{len(text) / 1e6:.3g} MB is too large; at most {LARGEST // 1024} KiB are read")
    elif not text.strip():
        draft.fault(0, "the file is empty")
    elif "\0" in text:
        draft.fault(text[: text.index("\0")].count("\n") + 1, "the file holds zero bytes; it is no text")
    draft.source.refuse()
    return draft
