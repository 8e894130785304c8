"""Terms of FCL: points, singletons, named shapes; and what follows from all of them for ranges and outputs."""

import math

from holodrive.control.fuzzy.files.draft import DraftVariable
from holodrive.control.fuzzy.files.fcl_reader import Reader, SyntaxFault
from holodrive.control.fuzzy.sets import Set, SetKind

SHAPES: dict[str, tuple[SetKind, int]] = {
    "TRIAN": ("triangle", 3),
    "TRAPE": ("trapezoid", 4),
    "GAUSS": ("gaussian", 2),
    "GBELL": ("bell", 3),
}
RESERVED = {
    *("FUNCTION_BLOCK", "END_FUNCTION_BLOCK", "VAR_INPUT", "VAR_OUTPUT", "END_VAR", "FUZZIFY", "END_FUZZIFY"),
    *("DEFUZZIFY", "END_DEFUZZIFY", "RULEBLOCK", "END_RULEBLOCK", "TERM", "METHOD", "DEFAULT", "NC", "RANGE"),
    *("RULE", "IF", "THEN", "IS", "NOT", "AND", "OR", "WITH", "ACT", "ACCU", "REAL", "LREAL", "INT", *SHAPES),
    *("COG", "COGS", "COA", "LM", "RM", "MM", "MOM", "MIN", "MAX", "PROD", "ASUM", "BSUM", "BDIF", "NSUM", "SUM"),
    *("FUNCTION", "SINGLETONS", "SIGM", "DSIGM", "COSINE", "GAUSS2", "COGF", "OPTION", "END_OPTION"),
}
_METHODS = {
    "COG": "centroid",
    "COGS": "centroid",
    "COA": "bisector",
    "LM": "som",
    "RM": "lom",
    "MM": "mom",
    "MOM": "mom",
}


def term(reader: Reader, variable: DraftVariable) -> None:
    """`TERM name := ... ;`, the word TERM being read."""
    name = reader.name("a term")
    reader.expect(":=")
    made = None
    try:
        made = _made(reader)
    finally:  # a term with a fault keeps its name and number, so that no rule seems to name a stranger
        reader.draft.add_set(variable, name.line, name.text, made)
    reader.expect(";")


def _made(reader: Reader) -> tuple[SetKind, list[float]]:
    token = reader.peek()
    if token.kind == "number":
        return "singleton", [reader.number("the place of a singleton")]
    if token.text == "(":
        return _points(reader)
    if token.upper in SHAPES:
        reader.take()
        kind, count = SHAPES[token.upper]
        return kind, [reader.number(f"a parameter of {token.upper}") for _ in range(count)]
    allowed = f"allowed: points (x,y), a number, {', '.join(SHAPES)}"
    raise SyntaxFault(token, f"a term cannot be {token.text!r}", allowed)


def _points(reader: Reader) -> tuple[SetKind, list[float]]:
    """Triangles and trapezoids by their own names, anything else as a polyline: level beyond its ends."""
    params: list[float] = []
    while reader.takes("("):
        params.append(reader.number("the place of a point"))
        reader.expect(",")
        params.append(reader.number("the height of a point"))
        reader.expect(")")
    places, heights = params[::2], params[1::2]
    if heights == [1.0]:
        return "singleton", places
    if heights == [0.0, 1.0, 0.0] and places[0] <= places[1] <= places[2]:
        return "triangle", places
    if heights == [0.0, 1.0, 1.0, 0.0] and places == sorted(places) and places[0] < places[3]:
        return "trapezoid", places
    return "polyline", params


def settled_ranges(reader: Reader) -> None:
    """Every variable needs its block and a universe: its RANGE, or from the first to the last point of its terms."""
    draft = reader.draft
    for block, variables in (("FUZZIFY", draft.inputs), ("DEFUZZIFY", draft.outputs)):
        for one in variables:
            if id(one) not in reader.blocks:
                draft.fault(one.line, f"variable {one.name!r} has no {block} block")
            elif id(one) not in reader.ranges and all(one.sets.values()):
                ends = [end for each in one.sets.values() if each is not None for end in set_ends(each)]
                if len(set(ends)) < 2 or any(map(math.isnan, ends)):
                    draft.fault(
                        reader.blocks[id(one)],
                        f"the universe of {one.name!r} does not follow from its terms",
                        "write RANGE := (low .. high); in this block",
                    )
                else:
                    one.low, one.high = min(ends), max(ends)


def set_ends(one: Set) -> tuple[float, ...]:
    """The places that a term names; NaN when it is a curve, which has no ends."""
    if one.kind == "polyline":
        return one.params[::2]
    return (math.nan,) if one.kind in ("gaussian", "bell") else one.params


def settled_outputs(reader: Reader) -> None:
    """How the outputs are defuzzified, one way for all.

    COGS over summed singletons is the weighted average of a Sugeno system; over the strongest ones it is the
    centroid of singletons.
    """
    draft, options = reader.draft, reader.draft.options
    methods = [(one, reader.methods[id(one)]) for one in draft.outputs if id(one) in reader.methods]
    for one, method in methods[1:]:
        first, before = methods[0]
        if _METHODS[method.upper] != _METHODS[before.upper]:
            draft.fault(
                method.line,
                f"output {one.name!r} has METHOD {method.upper}, {first.name!r} has {before.upper}",
                "a system has one way to defuzzify; split it into one file for each output",
                method.column,
            )
            return
    cogs = []
    for one in draft.outputs:
        kinds = {each.kind == "singleton" for each in one.sets.values() if each is not None}
        named = reader.methods[id(one)].upper if id(one) in reader.methods else "COGS" if kinds == {True} else "COG"
        options["defuzzification"] = _METHODS[named]
        line = reader.blocks.get(id(one), one.line)
        cogs.append(named == "COGS")
        if len(kinds) > 1:
            draft.fault(line, f"the terms of output {one.name!r} are singletons and areas; they must be of one sort")
        elif named == "COGS" and kinds == {False}:
            draft.fault(line, f"METHOD COGS of output {one.name!r} needs singletons", "METHOD : COG; is for areas")
        elif named == "COG" and kinds == {True}:
            draft.fault(line, f"METHOD COG of output {one.name!r} needs areas", "METHOD : COGS; is for singletons")
    if all(cogs) and "ACCU" in reader.norms and reader.norms["ACCU"].upper in ("NSUM", "SUM"):
        _sugeno(reader)


def _sugeno(reader: Reader) -> None:
    reader.draft.options |= {"kind": "sugeno", "defuzzification": "wtaver"}
    for output in reader.draft.outputs:
        for name, one in output.sets.items():
            if one is not None and one.kind == "singleton":
                output.sets[name] = Set(one.name, "constant", one.params)
