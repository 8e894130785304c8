"""Fuzzy Markup Language (IEEE 1855), read: Mamdani and TSK systems of its fuzzySystem (or fuzzyController).

Two labels of our own stand where the standard lets tools have some ("custom_..."): accumulation `custom_sum` and
combination `custom_wtsum`; the shape `custom_gbell` has MATLAB's a, b, c as parameters.
"""

import math
from typing import Literal

from holodrive.control.fuzzy.files.draft import Draft, DraftVariable, opened, position
from holodrive.control.fuzzy.files.fml_terms import fuzzy_term, number, settled_domains, tsk_term
from holodrive.control.fuzzy.files.fml_tree import Element, tree
from holodrive.control.fuzzy.files.rules import Is, Joined, Norms, flat_rules
from holodrive.control.fuzzy.system import Rule, System
from holodrive.errors import InputError

AND = {"MIN": "min", "PROD": "prod", "BDIF": "bounded", "BSUM": "bounded"}  # the schema misprints BDIF as BSUM
OR = {"MAX": "max", "PROBOR": "probor", "BSUM": "bounded"}
ACTIVATION = {"MIN": "min", "PROD": "prod"}
ACCUMULATION = {"MAX": "max", "custom_sum": "sum"}
DEFUZZIFIERS = {"COG": "centroid", "COA": "bisector", "MOM": "mom", "LM": "som", "RM": "lom"}
COMBINATIONS = {"WA": "wtaver", "custom_wtsum": "wtsum"}


def parse(text: str, file: str) -> System:
    """The system that an FML text describes.

    Raises:
        FileFaults: all that is wrong in it.
    """
    draft = opened(text, file)
    root = tree(draft)
    draft.name = root.get("name")
    bases = root.all("knowledgeBase")
    if len(bases) != 1:
        draft.fault(root.line, f"the system has {len(bases)} <knowledgeBase> elements; it needs one")
    for one in (each for base in bases for each in base.children):
        _variable(draft, one)
    rule_bases = [one for one in root.children if one.tag != "knowledgeBase"]
    if len({one.tag for one in rule_bases}) > 1:
        draft.fault(rule_bases[1].line, "a system has Mamdani rules or TSK rules, not both")
    draft.source.refuse()
    _kind(draft, rule_bases)
    _rules(draft, rule_bases)
    settled_domains(draft)
    return draft.system()


def _kind(draft: Draft, rule_bases: list[Element]) -> None:
    sugeno = any(one.tag == "tskRuleBase" for one in rule_bases)
    draft.options["kind"] = "sugeno" if sugeno else "mamdani"
    weighted = draft.options.get("defuzzification") in COMBINATIONS.values()
    if draft.outputs and weighted != sugeno:
        line = rule_bases[0].line if rule_bases else draft.outputs[0].line
        draft.fault(line, "TSK rules go with <tskVariable> outputs, Mamdani rules with <fuzzyVariable> outputs")
        draft.source.refuse()


def _variable(draft: Draft, element: Element) -> None:
    variable = DraftVariable(element.get("name"), element.line)
    variable.unit = "" if element.get("scale") == "null" else element.get("scale")
    is_tsk = element.tag == "tskVariable"
    is_output = is_tsk or element.get("type", "input").lower() == "output"
    if element.get("type", "input").lower() not in ("input", "output") or (is_tsk and element.get("type") == "input"):
        draft.fault(element.line, f"type {element.get('type')!r} of <{element.tag}> is not known")
    if "name" not in element.attributes:
        draft.fault(element.line, f"the <{element.tag}> has no name")
    if not is_tsk or "domainleft" in element.attributes:
        variable.low = number(draft, element, "domainleft")
        variable.high = number(draft, element, "domainright")
    if is_output:
        _output_options(draft, element)
        if element.get("defaultValue") != "NaN":
            variable.default = number(draft, element, "defaultValue", "0")
            variable.default = math.nan if math.isnan(variable.default) else variable.default
    (draft.outputs if is_output else draft.inputs).append(variable)
    for child in element.children:
        if child.get("complement", "false").lower() != "false":
            draft.fault(child.line, "complement terms are not read", 'write modifier="not" in the clauses of the rules')
        name = child.get("name")
        draft.add_set(variable, child.line, name, (tsk_term if is_tsk else fuzzy_term)(draft, child, variable))
    if is_tsk:
        _domain_comment(variable, element)


def _domain_comment(variable: DraftVariable, element: Element) -> None:
    """TSK variables of FML have no domain; `<!-- domain: low high -->` keeps the one of other formats."""
    for comment in element.comments:
        words = comment.split()
        if len(words) == 3 and words[0] == "domain:":
            try:
                variable.low, variable.high = float(words[1]), float(words[2])
            except ValueError:
                continue


def _output_options(draft: Draft, element: Element) -> None:
    if element.tag == "tskVariable":
        _agreed(draft, element, "defuzzification", "combination", COMBINATIONS, "WA")
        draft.options.setdefault("aggregation", "sum")
    else:
        _agreed(draft, element, "defuzzification", "defuzzifier", DEFUZZIFIERS, "COG")
        _agreed(draft, element, "aggregation", "accumulation", ACCUMULATION, "MAX")


def _agreed(draft: Draft, element: Element, option: str, name: str, allowed: dict[str, str], default: str) -> None:
    """An option that all elements must give alike; what is left out is the standard's default."""
    word = element.get(name, default)
    value = {key.upper(): one for key, one in allowed.items()}.get(word.upper())
    if value is None:
        draft.unknown(element.line, name, word, list(allowed))
        return
    if draft.options.setdefault(option, value) != value:
        before = next(key for key, one in allowed.items() if one == draft.options[option])
        draft.fault(element.line, f"{name} is {word} here and {before} before; a system has one")


def _rules(draft: Draft, rule_bases: list[Element]) -> None:
    pending = [(base, rule) for base in rule_bases for rule in base.children]
    for base in rule_bases:
        _agreed(draft, base, "implication", "activationMethod", ACTIVATION, "MIN")
    for base, rule in pending:
        joins_by_or = rule.get("connector", "and").lower() == "or"
        if joins_by_or:
            _agreed(draft, rule, "disjunction", "orMethod", OR, base.get("orMethod", "MAX"))
        else:
            _agreed(draft, rule, "conjunction", "andMethod", AND, base.get("andMethod", "MIN"))
    for base in rule_bases:  # what no rule needs, as the base says it
        for option, name, allowed, default in (
            ("conjunction", "andMethod", AND, "MIN"),
            ("disjunction", "orMethod", OR, "MAX"),
        ):
            if option not in draft.options:
                _agreed(draft, base, option, name, allowed, default)
    strongest = draft.options.get("aggregation", "max") == "max" and draft.options["kind"] == "mamdani"
    norms = Norms(draft.options.get("conjunction", "min"), draft.options.get("disjunction", "max"), strongest)
    for _, rule in pending:
        _rule(draft, rule, norms)


def _rule(draft: Draft, element: Element, norms: Norms) -> None:
    weight = number(draft, element, "weight", "1")
    word = element.get("connector", "and").lower()
    if word not in ("and", "or"):
        draft.unknown(element.line, "connector", word, ["and", "or"])
        return
    connector: Literal["and", "or"] = "or" if word == "or" else "and"
    parts = {one.tag: one for one in element.children}
    antecedent, consequent = parts.get("antecedent"), parts.get("consequent") or parts.get("tskConsequent")
    if antecedent is None or consequent is None:
        missing = "antecedent" if antecedent is None else "consequent"
        draft.fault(element.line, f"the <{element.tag}> has no {missing}")
        return
    conditions = [_clause(draft, one, draft.inputs, "input") for one in antecedent.children]
    conclusions = [
        _clause(draft, one, draft.outputs, "output") for then in consequent.children for one in then.children
    ]
    if not conditions or not conclusions:
        draft.fault(element.line, f"the <{element.tag}> has no {'conclusion' if conditions else 'condition'}")
        return
    if math.isnan(weight) or None in conditions or None in conclusions:
        return
    leaves = tuple(Is(*one) for one in conditions if one is not None)
    condition = leaves[0] if len(leaves) == 1 else Joined(connector, leaves)
    try:
        flat = flat_rules(condition, norms, [one.name for one in draft.inputs])
    except InputError as error:
        draft.fault(element.line, str(error))
        return
    concluded: list[dict[int, int]] = [{}]
    for index, term in (one for one in conclusions if one is not None):
        if index in concluded[-1]:
            concluded.append({})
        concluded[-1][index] = term
    for chosen, joined in flat if len(leaves) > 1 else [(flat[0][0], connector)]:
        for row in concluded:
            inputs = tuple(chosen.get(index, 0) for index in range(len(draft.inputs)))
            outputs = tuple(row.get(index, 0) for index in range(len(draft.outputs)))
            draft.add_rule(element.line, Rule(inputs, outputs, weight, joined))


def _clause(draft: Draft, element: Element, variables: list[DraftVariable], what: str) -> tuple[int, int] | None:
    """Index of the variable from 0 and number of the set from 1, negative for NOT; None after a fault."""
    words = {one.tag: one for one in element.children}
    if "variable" not in words or "term" not in words:
        draft.fault(element.line, f"the <{element.tag}> has no {'term' if 'variable' in words else 'variable'}")
        return None
    names = [one.name for one in variables]
    index = position(names, words["variable"].text) - 1
    if index < 0:
        draft.unknown(words["variable"].line, what, words["variable"].text, names)
        return None
    term = variables[index].find(words["term"].text)
    if not term:
        draft.unknown(words["term"].line, f"term of {names[index]}", words["term"].text, variables[index].names)
        return None
    modifier = element.get("modifier").lower()
    if modifier not in ("", "norm", "not") or (modifier == "not" and what == "output"):
        allowed = "known: not" if what == "input" else "a conclusion has none"
        draft.fault(element.line, f"modifier {modifier!r} is not read here", allowed)
        return None
    return index, -term if modifier == "not" else term
