"""Fuzzy Control Language (IEC 61131-7), written."""

import math
import re

from holodrive.control.fuzzy.files.fcl_terms import RESERVED, set_ends
from holodrive.control.fuzzy.files.words import cannot, number, numbers, refuse_fuzzylab
from holodrive.control.fuzzy.sets import Set
from holodrive.control.fuzzy.system import Rule, System, Variable

_AND = {"min": "MIN", "prod": "PROD", "bounded": "BDIF"}
_OR = {"max": "MAX", "probor": "ASUM", "bounded": "BSUM"}
_ACCU = {"max": "MAX", "sum": "NSUM"}  # NSUM is the sum over its largest value; what defuzzifies is the same
_METHODS = {"centroid": "COG", "bisector": "COA", "som": "LM", "lom": "RM", "mom": "MM", "wtaver": "COGS"}
_NAME = re.compile(r"[A-Za-z_][A-Za-z0-9_]*")


def text(system: System) -> str:
    """An FCL text that describes the system.

    Raises:
        InputError: the system has what the format cannot say.
    """
    refuse_fuzzylab(system, "fcl")
    if system.defuzzification not in _METHODS:
        raise cannot(system, "fcl", f"defuzzification {system.defuzzification!r}", f"it has {', '.join(_METHODS)}")
    for variable in (*system.inputs, *system.outputs):
        _check_names(system, variable)
    lines = [_opening(system)]
    for block, variables in (("VAR_INPUT", system.inputs), ("VAR_OUTPUT", system.outputs)):
        lines += [block, *(f"  {one.name} : REAL;{_unit(system, one)}" for one in variables), "END_VAR"]
    for variable in system.inputs:
        lines += _fuzzify(variable)
    for variable in system.outputs:
        lines += _defuzzify(system, variable)
    lines += [
        "RULEBLOCK rules",
        f"  AND : {_AND[system.conjunction]};",
        f"  OR : {_OR[system.disjunction]};",
        f"  ACT : {_act(system)};",
        f"  ACCU : {_accumulation(system)};",
        *(f"  RULE {count} : {_rule(system, count, rule)};" for count, rule in enumerate(system.rules, 1)),
        "END_RULEBLOCK",
        "END_FUNCTION_BLOCK",
    ]
    return "\n".join(lines) + "\n"


def _comment(system: System, key: str, value: str) -> str:
    if value != value.strip() or any(mark in value for mark in ("*)", "\n", "\r", "\0")):
        raise cannot(system, "fcl", f"the {key} {value!r}", "its comment holds one line without *)")
    return f" (* {key}: {value} *)"


def _opening(system: System) -> str:
    if _NAME.fullmatch(system.name) and system.name.upper() not in RESERVED:
        return f"FUNCTION_BLOCK {system.name}"
    plain = re.sub(r"[^A-Za-z0-9_]+", "_", system.name).strip("_")
    return f"FUNCTION_BLOCK fuzzy_{plain}{_comment(system, 'name', system.name)}"


def _unit(system: System, variable: Variable) -> str:
    return _comment(system, "unit", variable.unit) if variable.unit else ""


def _check_names(system: System, variable: Variable) -> None:
    for what, name in (("variable", variable.name), *(("set", one.name) for one in variable.sets)):
        if not _NAME.fullmatch(name) or name.upper() in RESERVED:
            plain = re.sub(r"[^A-Za-z0-9_]+", "_", name).strip("_") or "x"
            raise cannot(
                system,
                "fcl",
                f"the {what} name {name!r}",
                f"names are letters, digits and _, and no keywords; rename it, to {plain + '_'!r} perhaps",
            )


def _fuzzify(variable: Variable) -> list[str]:
    lines = [f"FUZZIFY {variable.name}"]
    lines += [f"  TERM {one.name} := {_term(one)};" for one in variable.sets]
    ends = [end for one in variable.sets for end in set_ends(one)]
    if not ends or any(map(math.isnan, ends)) or (min(ends), max(ends)) != (variable.low, variable.high):
        lines.append(f"  RANGE := ({number(variable.low)} .. {number(variable.high)});")
    return [*lines, "END_FUZZIFY"]


def _defuzzify(system: System, variable: Variable) -> list[str]:
    if any(one.kind == "linear" for one in variable.sets):
        raise cannot(system, "fcl", f"the linear conclusions of {variable.name!r}", ".fis and FML can")
    singletons = {one.kind in ("singleton", "constant") for one in variable.sets}
    method = _METHODS[system.defuzzification]
    if method == "COG" and (singletons == {True} or not (singletons or _areas(system))):
        method = "COGS"
    return [
        f"DEFUZZIFY {variable.name}",
        *(f"  TERM {one.name} := {_term(one)};" for one in variable.sets),
        f"  ACCU : {_accumulation(system)};",
        f"  METHOD : {method};",
        f"  DEFAULT := {'NC' if math.isnan(variable.default) else number(variable.default)};",
        f"  RANGE := ({number(variable.low)} .. {number(variable.high)});",
        "END_DEFUZZIFY",
    ]


def _areas(system: System) -> bool:
    return any(one.kind not in ("singleton", "constant") for variable in system.outputs for one in variable.sets)


def _term(one: Set) -> str:
    match one.kind:
        case "gaussian":
            return f"GAUSS {numbers(one.params)}"
        case "bell":
            return f"GBELL {numbers(one.params)}"
        case "singleton" | "constant":
            return number(one.params[0])
        case "polyline":
            pairs = list(zip(one.params[::2], one.params[1::2], strict=True))
        case _:
            heights = (0.0, 1.0, 0.0) if one.kind == "triangle" else (0.0, 1.0, 1.0, 0.0)
            pairs = list(zip(one.params, heights, strict=True))
    return " ".join(f"({number(x)},{number(mu)})" for x, mu in pairs)


def _act(system: System) -> str:
    return system.implication.upper()


def _accumulation(system: System) -> str:
    """A Sugeno system always sums, whatever its field says."""
    return "NSUM" if system.kind == "sugeno" else _ACCU[system.aggregation]


def _rule(system: System, count: int, rule: Rule) -> str:
    conditions = [
        f"{variable.name} IS {'NOT ' * (index < 0)}{variable.sets[abs(index) - 1].name}"
        for index, variable in zip(rule.inputs, system.inputs, strict=True)
        if index
    ]
    conclusions = [
        f"{variable.name} IS {variable.sets[index - 1].name}"
        for index, variable in zip(rule.outputs, system.outputs, strict=True)
        if index
    ]
    if not conclusions:
        raise cannot(system, "fcl", f"that rule {count} concludes nothing", "leave the rule out")
    joined = f" {rule.connective.upper()} ".join(conditions)
    weight = "" if rule.weight == 1.0 else f" WITH {number(rule.weight)}"
    return f"IF {joined} THEN {', '.join(conclusions)}{weight}"
