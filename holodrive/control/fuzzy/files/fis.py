"""MATLAB's .fis files, read: sections of `Key=value` lines, membership functions, rules of numbers.

What other tools write and MATLAB reads is read too: missing counts, commas in lists, double quotes, old line ends.
A line with % in its first column is a comment; two such lines are understood because nothing else in the format
holds what they say: `%Unit='mm'` and `%Default=0` in the section of a variable.
"""

import math
import re
from dataclasses import dataclass, field

from holodrive.control.fuzzy.files.draft import Draft, DraftVariable, opened
from holodrive.control.fuzzy.sets import SetKind
from holodrive.control.fuzzy.system import Rule, System

SHAPES: dict[str, SetKind] = {
    "trimf": "triangle",
    "trapmf": "trapezoid",
    "gaussmf": "gaussian",
    "gbellmf": "bell",
    "linzmf": "polyline",
    "linsmf": "polyline",
    "constant": "constant",
    "linear": "linear",
}
CURVES = ("sigmf", "dsigmf", "psigmf", "pimf", "smf", "zmf", "gauss2mf")
WORDS = {
    "AndMethod": ("conjunction", {"min": "min", "prod": "prod"}),
    "OrMethod": ("disjunction", {"max": "max", "probor": "probor"}),
    "ImpMethod": ("implication", {"min": "min", "prod": "prod"}),
    "AggMethod": ("aggregation", {"max": "max", "sum": "sum"}),
    "DefuzzMethod": (
        "defuzzification",
        {one: one for one in ("centroid", "bisector", "mom", "som", "lom", "wtaver", "wtsum")},
    ),
}
_SYSTEM_KEYS = ["Name", "Type", "Version", "NumInputs", "NumOutputs", "NumRules", *WORDS]
_HEADER = re.compile(r"\[ ?([A-Za-z]+) ?(\d*) ?\]")
_PAIR = re.compile(r"([A-Za-z]+)(\d*) *= *(.*)")
_NOTE = re.compile(r"%(Unit|Default)=(.*)")
_QUOTED = re.compile(r"'([^']*)'|\"([^\"]*)\"")
_MF = re.compile(r"(?:'([^']*)'|\"([^\"]*)\")\s*:\s*(?:'([^']*)'|\"([^\"]*)\")\s*,\s*\[([^\[\]]*)\]")
_LIST = re.compile(r"\[([^\[\]]*)\]")
_RULE = re.compile(r"([^,()]*),([^,()]*)\(([^()]*)\)\s*:\s*(\S+)")


@dataclass(slots=True)
class Section:
    """One `[Section]` of the file."""

    line: int
    lines: list[tuple[int, str]] = field(default_factory=list)


def parse(text: str, file: str) -> System:
    """The system that a .fis text describes.

    Raises:
        FileFaults: all that is wrong in it.
    """
    draft = opened(text, file)
    sections = _sections(draft)
    found = _system(draft, sections)
    if found is None:
        draft.source.refuse()
    draft.inputs = _variables(draft, sections, "Input")
    draft.outputs = _variables(draft, sections, "Output")
    counts = found or {}
    complete = _counted(draft, counts, "NumInputs", len(draft.inputs), "[Input] sections") and _counted(
        draft, counts, "NumOutputs", len(draft.outputs), "[Output] sections"
    )
    rules = sections.get(("rules", 0))
    if rules is None:
        draft.fault(0, "the file has no [Rules] section", "is it cut off?")
    elif complete:
        _rules(draft, rules)
        _counted(draft, counts, "NumRules", len([line for _, line in rules.lines if line.strip()]), "lines in [Rules]")
    return draft.system()


def _sections(draft: Draft) -> dict[tuple[str, int], Section]:
    sections: dict[tuple[str, int], Section] = {}
    current: Section | None = None
    for number, line in enumerate(draft.source.lines, 1):
        if (match := _HEADER.fullmatch(line.strip())) is not None:
            key = (match[1].casefold(), int(match[2][:6] or 0))
            if key[0] not in ("system", "input", "output", "rules"):
                draft.unknown(number, "section", match[1], ["System", "Input1", "Output1", "Rules"])
            elif key in sections:
                draft.fault(number, f"section {line.strip()} is there twice; the first is in line {sections[key].line}")
            current = Section(number)
            sections.setdefault(key, current)
        elif current is not None:
            current.lines.append((number, line))
        elif line.strip() and not line.startswith(("%", "#")):
            draft.fault(number, "this line stands before the first section", "a .fis file begins with [System]")
            return sections
    return sections


def _pairs(draft: Draft, section: Section, keys: list[str]) -> dict[str, tuple[int, str]]:
    """Key -> (line, value); `MF1` keeps its number, other keys are spelt as in `keys`."""
    spelt = {key.casefold(): key for key in keys}
    pairs: dict[str, tuple[int, str]] = {}
    for line, text in section.lines:
        match = _PAIR.fullmatch(text.strip())
        if note := _NOTE.fullmatch(text):
            pairs["%" + note[1]] = (line, note[2].strip())
        if not text.strip() or text.startswith(("%", "#")):
            continue
        if match is None:
            draft.fault(line, f"{text.strip()[:60]!r} is no `Key=value` line")
        elif match[1].casefold() not in spelt:
            draft.unknown(line, "key", match[1] + match[2], keys)
        else:
            key = spelt[match[1].casefold()] + match[2]
            if key in pairs:
                draft.fault(line, f"{key} is there twice; the first is in line {pairs[key][0]}")
            pairs.setdefault(key, (line, match[3]))
    return pairs


def _system(draft: Draft, sections: dict[tuple[str, int], Section]) -> dict[str, tuple[int, str]] | None:
    section = sections.get(("system", 0))
    if section is None:
        draft.source.refuse()
        draft.fault(0, "the file has no [System] section", "a .fis file begins with it")
        return None
    pairs = _pairs(draft, section, _SYSTEM_KEYS)
    draft.name = _text(draft, pairs, "Name")
    kind = _word(draft, pairs, "Type", {"mamdani": "mamdani", "sugeno": "sugeno"}, "mamdani")
    draft.options["kind"] = kind
    if kind == "sugeno":
        draft.options["defuzzification"] = "wtaver"
    for key, (name, allowed) in WORDS.items():
        if key in pairs:
            draft.options[name] = _word(draft, pairs, key, allowed, next(iter(allowed)))
    weighted = draft.options.get("defuzzification") in ("wtaver", "wtsum")
    if weighted != (kind == "sugeno") and "DefuzzMethod" in pairs:
        allowed_now = "wtaver, wtsum" if kind == "sugeno" else "centroid, bisector, mom, som, lom"
        draft.fault(pairs["DefuzzMethod"][0], f"a {kind} system cannot defuzzify so", f"allowed: {allowed_now}")
        return None
    return pairs


def _text(draft: Draft, pairs: dict[str, tuple[int, str]], key: str) -> str:
    line, value = pairs.get(key, (0, "''"))
    match = _QUOTED.fullmatch(value)
    if match is None:
        draft.fault(line, f"{key} is {value[:60]!r}; it must be a text in quotes")
        return ""
    return match[1] if match[1] is not None else match[2]


def _word(draft: Draft, pairs: dict[str, tuple[int, str]], key: str, allowed: dict[str, str], default: str) -> str:
    if key not in pairs:
        return default
    word = _text(draft, pairs, key)
    if word.casefold() not in allowed:
        draft.unknown(pairs[key][0], key, word, list(allowed))
        return default
    return allowed[word.casefold()]


def _counted(draft: Draft, pairs: dict[str, tuple[int, str]], key: str, found: int, what: str) -> bool:
    """Whether a count of the file is true; one that is missing is."""
    if key not in pairs:
        return True
    line, value = pairs[key]
    if not re.fullmatch(r"\d{1,6}", value):
        draft.fault(line, f"{key} is {value[:40]!r}; it must be a whole number")
    elif int(value) != found:
        draft.fault(line, f"{key} says {value}, but counting the {what} gives {found}")
    else:
        return True
    return False


def _variables(draft: Draft, sections: dict[tuple[str, int], Section], kind: str) -> list[DraftVariable]:
    numbered = {number: one for (name, number), one in sections.items() if name == kind.casefold()}
    for place, number in enumerate(sorted(numbered), 1):
        if number != place:
            draft.fault(
                numbered[number].line, f"[{kind}{number}] follows [{kind}{place - 1}]; they count from 1 without holes"
            )
            break
    return [_variable(draft, numbered[number]) for number in sorted(numbered)]


def _variable(draft: Draft, section: Section) -> DraftVariable:
    pairs = _pairs(draft, section, ["Name", "Range", "NumMFs", "MF"])
    variable = DraftVariable(_text(draft, pairs, "Name"), pairs.get("Range", (section.line, ""))[0])
    if "Name" not in pairs:
        draft.fault(section.line, "the variable has no Name")
    if "Range" in pairs:
        variable.low, variable.high = _range(draft, *pairs["Range"])
    else:
        draft.fault(section.line, "the variable has no Range", "such as Range=[0 2500]")
    functions = {int(key[2:8] or 0): value for key, value in pairs.items() if key.startswith("MF")}
    for place, number in enumerate(sorted(functions), 1):
        line, value = functions[number]
        if number != place:
            draft.fault(line, f"MF{number} is the {place}. of the variable; they count from 1 without holes")
        _membership(draft, variable, line, value)
    _counted(draft, pairs, "NumMFs", len(functions), "MF lines")
    if match := _QUOTED.fullmatch(pairs.get("%Unit", (0, ""))[1]):
        variable.unit = match[1] or ""
    if "%Default" in pairs:
        variable.default = draft.number(pairs["%Default"][1], pairs["%Default"][0], "the default")
        variable.default = math.nan if math.isnan(variable.default) else variable.default
    return variable


def _range(draft: Draft, line: int, value: str) -> tuple[float, float]:
    match = _LIST.fullmatch(value)
    words = re.split(r"[\s,;]+", match[1].strip()) if match else []
    if len(words) != 2:
        draft.fault(line, f"Range is {value[:60]!r}; it must be two numbers in brackets", "such as Range=[0 2500]")
        return math.nan, math.nan
    low, high = (
        draft.number(word, line, f"the {end} end of Range") for word, end in zip(words, ("low", "high"), strict=True)
    )
    return low, high


def _membership(draft: Draft, variable: DraftVariable, line: int, value: str) -> None:
    match = _MF.fullmatch(value)
    if match is None:
        draft.fault(line, f"{value[:60]!r} is no membership function", "such as MF1='near':'trimf',[0 250 500]")
        draft.add_set(variable, line, f"\0{line}", None)
        return
    name = match[1] if match[1] is not None else match[2]
    shape = match[3] if match[3] is not None else match[4]
    words = [word for word in re.split(r"[\s,;]+", match[5].strip()) if word]
    draft.add_set(variable, line, name, _made(draft, line, name, shape, words))


def _made(draft: Draft, line: int, name: str, shape: str, words: list[str]) -> tuple[SetKind, list[float]] | None:
    """Kind and parameters of a set; shoulders that MATLAB writes with infinite feet become one-sided polylines."""
    if shape in CURVES:
        merged = _one_gaussian(words) if shape == "gauss2mf" else None
        if merged is None:
            allowed = ", ".join(SHAPES)
            draft.fault(line, f"set {name!r} is a {shape!r}, a curve that is not evaluated here", f"allowed: {allowed}")
            return None
        shape, words = "gaussmf", merged
    if shape not in SHAPES:
        draft.unknown(line, "membership function", shape, list(SHAPES))
        return None
    lower = [word.casefold() for word in words]
    if shape == "trapmf" and len(words) == 4:
        if lower[:2] == ["-inf", "-inf"]:
            shape, words = "linzmf", words[2:]
        elif [word.lstrip("+") for word in lower[2:]] == ["inf", "inf"]:
            shape, words = "linsmf", words[:2]
    params = [draft.number(word, line, f"a parameter of set {name!r}") for word in words]
    if shape in ("linzmf", "linsmf"):
        if len(params) != 2:
            draft.fault(line, f"set {name!r} ({shape}) has {len(params)} parameters; it takes 2")
            return None
        top = shape == "linzmf"
        params = [params[0], float(top), params[1], float(not top)]
    if shape == "gaussmf" and len(params) == 2:
        params.reverse()  # MATLAB: sigma, mean
    return SHAPES[shape], params


def _one_gaussian(words: list[str]) -> list[str] | None:
    """A two-sided Gaussian [sigma1 c1 sigma2 c2] whose sides are the same is a plain one."""
    return words[:2] if len(words) == 4 and words[:2] == words[2:] else None


def _rules(draft: Draft, section: Section) -> None:
    for line, text in section.lines:
        if not text.strip() or text.startswith(("%", "#")):
            continue
        match = _RULE.fullmatch(text.strip())
        if match is None:
            draft.fault(line, f"{text.strip()[:60]!r} is no rule", "inputs, outputs (weight) : 1 for AND or 2 for OR")
            continue
        inputs = _indices(draft, line, match[1], draft.inputs, "input", least=-1)
        outputs = _indices(draft, line, match[2], draft.outputs, "output", least=0)
        weight = draft.number(match[3], line, "the weight")
        if match[4] not in ("1", "2"):
            draft.fault(line, f"the rule is joined by {match[4][:20]!r}; 1 is AND, 2 is OR")
        elif inputs is not None and outputs is not None and not math.isnan(weight):
            draft.add_rule(line, Rule(inputs, outputs, weight, "and" if match[4] == "1" else "or"))


def _indices(
    draft: Draft, line: int, text: str, variables: list[DraftVariable], what: str, least: int
) -> tuple[int, ...] | None:
    words = text.split()
    if len(words) != len(variables):
        draft.fault(line, f"the rule names {len(words)} {what}s; the system has {len(variables)}")
        return None
    for word, variable in zip(words, variables, strict=True):
        count = len(variable.sets)
        if not re.fullmatch(r"[+-]?\d{1,6}", word):
            draft.fault(line, f"{word[:20]!r} is no number of a set of {variable.name!r}")
            return None
        if not least * count <= int(word) <= count:
            draft.fault(
                line, f"the rule names set {word} of {variable.name!r}, which has {count} set{'s' * (count != 1)}"
            )
            return None
    return tuple(int(word) for word in words)
