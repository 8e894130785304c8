"""MATLAB's .fis files, written."""

import math

from holodrive.control.fuzzy.files.fis import WORDS
from holodrive.control.fuzzy.files.words import cannot, number, numbers, refuse_fuzzylab, straightened
from holodrive.control.fuzzy.sets import Set
from holodrive.control.fuzzy.system import Rule, System, Variable

_SHAPES = {
    "triangle": "trimf",
    "trapezoid": "trapmf",
    "gaussian": "gaussmf",
    "bell": "gbellmf",
    "falling": "linzmf",
    "rising": "linsmf",
    "constant": "constant",
    "linear": "linear",
}


def text(system: System) -> str:
    """A .fis text that describes the system.

    Raises:
        InputError: the system has what the format cannot say.
    """
    refuse_fuzzylab(system, "fis")
    words = {}
    for key, (name, allowed) in WORDS.items():
        words[key] = getattr(system, name)
        if words[key] not in allowed:
            raise cannot(system, "fis", f"{key} {words[key]!r}", f"allowed: {', '.join(allowed)}")
    lines = [
        "[System]",
        f"Name={_quoted(system, system.name)}",
        f"Type='{system.kind}'",
        "Version=2.0",
        f"NumInputs={len(system.inputs)}",
        f"NumOutputs={len(system.outputs)}",
        f"NumRules={len(system.rules)}",
        *(f"{key}='{word}'" for key, word in words.items()),
    ]
    for kind, variables in (("Input", system.inputs), ("Output", system.outputs)):
        for place, variable in enumerate(variables, 1):
            lines += ["", f"[{kind}{place}]", *_variable(system, variable, kind == "Output")]
    lines += ["", "[Rules]", *(_rule(rule) for rule in system.rules)]
    return "\n".join(lines) + "\n"


def _quoted(system: System, name: str) -> str:
    if any(character in "'\r\n\0" for character in name):
        raise cannot(system, "fis", f"the name {name!r}", "names hold no quotes and no line breaks")
    return f"'{name}'"


def _variable(system: System, variable: Variable, is_output: bool) -> list[str]:
    lines = [f"Name={_quoted(system, variable.name)}"]
    if variable.unit:
        lines.append(f"%Unit={_quoted(system, variable.unit)}")
    if not math.isnan(variable.default):
        lines.append(f"%Default={number(variable.default)}")
    lines += [f"Range=[{numbers((variable.low, variable.high))}]", f"NumMFs={len(variable.sets)}"]
    for place, one in enumerate(variable.sets, 1):
        lines.append(f"MF{place}={_quoted(system, one.name)}:{_shape(system, variable, one, is_output)}")
    return lines


def _shape(system: System, variable: Variable, one: Set, is_output: bool) -> str:
    kind, params = straightened(one.params) if one.kind == "polyline" else (one.kind, one.params)
    if one.kind == "singleton" and not is_output:
        kind, params = "triangle", one.params * 3
    if one.kind == "gaussian":
        params = one.params[::-1]
    what = {"triangle": "trimf", **_SHAPES}.get(kind)
    if what is None:
        instead = "FCL and FML can" if one.kind == "polyline" else "FCL and FML can; or make it a narrow triangle"
        raise cannot(system, "fis", f"the {one.kind} {one.name!r} of {variable.name!r}", instead)
    return f"'{what}',[{numbers(params)}]"


def _rule(rule: Rule) -> str:
    inputs, outputs = (" ".join(map(str, part)) for part in (rule.inputs, rule.outputs))
    return f"{inputs}, {outputs} ({number(rule.weight)}) : {1 if rule.connective == 'and' else 2}"
