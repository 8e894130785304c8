"""Fuzzy Markup Language (IEEE 1855), written."""

import math
import re
from xml.sax.saxutils import escape, quoteattr

from holodrive.control.fuzzy.files.words import cannot, number, refuse_fuzzylab
from holodrive.control.fuzzy.sets import Set
from holodrive.control.fuzzy.system import Rule, System, Variable

NAMESPACE = "http://www.ieee1855.org"
_AND = {"min": "MIN", "prod": "PROD", "bounded": "BDIF"}
_OR = {"max": "MAX", "probor": "PROBOR", "bounded": "BSUM"}
_ACCUMULATION = {"max": "MAX", "sum": "custom_sum"}
_DEFUZZIFIERS = {"centroid": "COG", "bisector": "COA", "mom": "MOM", "som": "LM", "lom": "RM"}
_COMBINATIONS = {"wtaver": "WA", "wtsum": "custom_wtsum"}
_SHAPES = {
    "triangle": "triangularShape",
    "trapezoid": "trapezoidShape",
    "gaussian": "gaussianShape",
    "singleton": "singletonShape",
}
_NO_XML = re.compile("[^\x20-\ud7ff\ue000-\ufffd\U00010000-\U0010ffff]")


def text(system: System) -> str:
    """An FML text that describes the system.

    Raises:
        InputError: the system has what the format cannot say.
    """
    refuse_fuzzylab(system, "fml")
    sugeno = system.kind == "sugeno"
    base = "tskRuleBase" if sugeno else "mamdaniRuleBase"
    methods = (
        f'activationMethod="{system.implication.upper()}" andMethod="{_AND[system.conjunction]}" '
        f'orMethod="{_OR[system.disjunction]}"'
    )
    lines = [
        '<?xml version="1.0" encoding="UTF-8"?>',
        f'<fuzzySystem xmlns="{NAMESPACE}" name={_attribute(system, system.name)}>',
        "  <knowledgeBase>",
    ]
    for variable in system.inputs:
        lines += _variable(system, variable, "input")
    for variable in system.outputs:
        lines += _tsk_variable(system, variable) if sugeno else _variable(system, variable, "output")
    lines += ["  </knowledgeBase>", f'  <{base} name="rules" {methods}>']
    for count, rule in enumerate(system.rules, 1):
        lines += _rule(system, count, rule)
    return "\n".join([*lines, f"  </{base}>", "</fuzzySystem>"]) + "\n"


def _checked(system: System, name: str) -> str:
    if name != " ".join(name.split()) or _NO_XML.search(name):
        raise cannot(system, "fml", f"the name {name!r}", "names hold single spaces and no control characters")
    return name


def _attribute(system: System, name: str) -> str:
    return quoteattr(_checked(system, name))


def _variable(system: System, variable: Variable, type: str) -> list[str]:
    more = ""
    if type == "output":
        more = (
            f' accumulation="{_ACCUMULATION[system.aggregation]}" '
            f'defuzzifier="{_DEFUZZIFIERS[system.defuzzification]}" defaultValue="{_default(variable)}"'
        )
    lines = [
        f"    <fuzzyVariable name={_attribute(system, variable.name)} scale={_attribute(system, variable.unit)} "
        f'domainleft="{number(variable.low)}" domainright="{number(variable.high)}" type="{type}"{more}>'
    ]
    for one in variable.sets:
        lines += [
            f'      <fuzzyTerm name={_attribute(system, one.name)} complement="false">',
            *(f"        {line}" for line in _shape(one)),
            "      </fuzzyTerm>",
        ]
    return [*lines, "    </fuzzyVariable>"]


def _default(variable: Variable) -> str:
    return "NaN" if math.isnan(variable.default) else number(variable.default)


def _shape(one: Set) -> list[str]:
    if one.kind == "polyline":
        pairs = zip(one.params[::2], one.params[1::2], strict=True)
        points = (f'  <point x="{number(x)}" y="{number(mu)}"/>' for x, mu in pairs)
        return ['<pointSetShape interpolationMethod="linear">', *points, "</pointSetShape>"]
    if one.kind == "bell":
        values = (f'  <parameter value="{number(value)}"/>' for value in one.params)
        return ['<customShape name="custom_gbell">', *values, "</customShape>"]
    params = " ".join(f'param{place}="{number(value)}"' for place, value in enumerate(one.params, 1))
    return [f"<{_SHAPES[one.kind]} {params}/>"]


def _tsk_variable(system: System, variable: Variable) -> list[str]:
    lines = [
        f"    <tskVariable name={_attribute(system, variable.name)} scale={_attribute(system, variable.unit)} "
        f'type="output" combination="{_COMBINATIONS[system.defuzzification]}" defaultValue="{_default(variable)}">',
        f"      <!-- domain: {number(variable.low)} {number(variable.high)} -->",
    ]
    for one in variable.sets:
        values = one.params if one.kind == "constant" else (one.params[-1], *one.params[:-1])
        lines.append(f'      <tskTerm name={_attribute(system, one.name)} order="{int(one.kind == "linear")}">')
        lines += [f"        <tskValue>{number(value)}</tskValue>" for value in values]
        lines.append("      </tskTerm>")
    return [*lines, "    </tskVariable>"]


def _rule(system: System, count: int, rule: Rule) -> list[str]:
    tsk = "tsk" if system.kind == "sugeno" else ""
    tags = [f"{tsk}{word.capitalize() if tsk else word}" for word in ("rule", "consequent", "then", "clause")]
    tag, consequent, then, clause = tags
    conditions = _clauses(system, "clause", system.inputs, rule.inputs)
    conclusions = _clauses(system, clause, system.outputs, rule.outputs)
    if not conclusions:
        raise cannot(system, "fml", f"that rule {count} concludes nothing", "leave the rule out")
    return [
        f'    <{tag} name="{count}" connector="{rule.connective}" weight="{number(rule.weight)}">',
        *("      <antecedent>", *(f"        {line}" for line in conditions), "      </antecedent>"),
        *(f"      <{consequent}>", f"        <{then}>", *(f"          {line}" for line in conclusions)),
        *(f"        </{then}>", f"      </{consequent}>", f"    </{tag}>"),
    ]


def _clauses(system: System, tag: str, variables: tuple[Variable, ...], chosen: tuple[int, ...]) -> list[str]:
    lines = []
    for variable, index in zip(variables, chosen, strict=True):
        if index:
            modifier = ' modifier="not"' if index < 0 else ""
            name, term = variable.name, variable.sets[abs(index) - 1].name
            words = (
                f"<variable>{escape(_checked(system, name))}</variable><term>{escape(_checked(system, term))}</term>"
            )
            lines.append(f"<{tag}{modifier}>{words}</{tag}>")
    return lines
