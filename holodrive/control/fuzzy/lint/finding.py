"""What a linter says: one fault or doubt of a fuzzy system, with a code that stays; and how rules are told."""

import math
from dataclasses import dataclass
from typing import Literal

from holodrive.control.fuzzy.system import Rule, System

Severity = Literal["error", "warning", "info"]

# code -> what it means, in the order in which findings are told; docs/fuzzy.md has the same table
CODES: dict[str, str] = {
    "F-GAP": "an input has a place where none of its sets holds",
    "F-MISSING": "a combination of sets that no rule names, or none that speaks about some output",
    "F-CONTRADICT": "two rules with the same condition and different conclusions",
    "F-TOWARD": "a rule turns the robot toward the nearer side",
    "F-RANGE": "the sensor tells numbers beyond the universe, and nothing fires there without clamping",
    "F-JUMP": "an output jumps where an input moves by nothing",
    "F-DEAD": "a rule that can never fire, or that concludes what lies outside the output's range",
    "F-MASKED": "a rule that another one always hides",
    "F-DUPLICATE": "a rule that is there twice",
    "F-TOWARD-BACK": "a rule backs up and yaws the nose toward the nearer side",
    "F-BACK": "a rule backs straight although a side is open",
    "F-STRAIGHT": "a rule drives straight past a near side although the other is farther",
    "F-MIRROR-IN": "the sets of a left and a right input differ",
    "F-MIRROR-OUT": "the sets of a left and a right output differ",
    "F-MIRROR-RULE": "swapping left and right in a rule's condition does not swap its outputs, or changes its weight",
    "F-ZERO": "no set of an output holds zero, though its range does",
    "F-TIE": "a rule turns where left and right are alike",
    "F-REACH": "an end of an output's range cannot be reached",
    "F-COVER": "an input is weakly covered: at some place its greatest membership is below one half",
    "F-SUM": "the memberships of an input do not sum to one everywhere",
    "F-STEPS": "the way of defuzzification jumps by nature, so jumps were not looked for",
    "F-BLIND": "rules back up, and no input looks behind",
    "F-UNUSED": "an input or a set that no rule names",
    "F-LARGE": "too many combinations to look at; a check was left out",
}


@dataclass(frozen=True)
class Finding:
    """One fault or doubt.

    Attributes:
        code: one of `CODES`.
        severity: "error" does harm, "warning" is most likely not meant, "info" is good to know.
        text: one line with the numbers.
        variable: the input or output concerned, "" when it is the whole system.
        rules: numbers of the rules concerned, from 1.
        at: where, in the units of `variable` [its own]; NaN when it is nowhere in particular.
        value: how much, as the text says; NaN when there is no such number.
    """

    code: str
    severity: Severity
    text: str
    variable: str = ""
    rules: tuple[int, ...] = ()
    at: float = math.nan
    value: float = math.nan

    def __str__(self) -> str:
        """`F-GAP error: text`."""
        return f"{self.code:<13} {self.severity:<7} {self.text}"


def rule_words(system: System, rule: Rule) -> str:
    """`IF DH is N AND DL is not M THEN L is PZ AND R is P`, with the weight where it is not 1."""
    condition = [
        f"{variable.name} is {'not ' * (index < 0)}{variable.sets[abs(index) - 1].name}"
        for variable, index in zip(system.inputs, rule.inputs, strict=True)
        if index
    ]
    conclusion = [
        f"{variable.name} is {variable.sets[index - 1].name}"
        for variable, index in zip(system.outputs, rule.outputs, strict=True)
        if index
    ]
    weight = f" WITH {rule.weight:g}" if rule.weight != 1.0 else ""
    joined = f" {rule.connective.upper()} ".join(condition)
    return f"IF {joined} THEN {' AND '.join(conclusion) or 'nothing'}{weight}"


def numbers(rules: tuple[int, ...]) -> str:
    """`rule 4`, `rules 4 and 7`, `rules 1 to 9 and 11`."""
    runs: list[list[int]] = []
    for rule in rules:
        if runs and rule == runs[-1][-1] + 1:
            runs[-1].append(rule)
        else:
            runs.append([rule])
    parts: list[str] = []
    for run in runs:
        parts += [f"{run[0]} to {run[-1]}"] if len(run) > 2 else [str(one) for one in run]
    joined = parts[0] if len(parts) == 1 else f"{', '.join(parts[:-1])} and {parts[-1]}"
    return f"rule{'s' * (len(rules) > 1)} {joined}"


def with_unit(value: float, unit: str) -> str:
    """A number as people write it, with its unit."""
    return f"{value + 0.0:.6g}{' ' + unit if unit else ''}"
