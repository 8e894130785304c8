"""Fuzzy Control Language (IEC 61131-7), read: one FUNCTION_BLOCK, in any letter case.

Beyond the standard, what jFuzzyLogic and fuzzylite write is read: RANGE of inputs, TRIAN, TRAPE, GAUSS and GBELL
terms, METHOD MM, ACCU SUM, C comments. `(* unit: mm *)` behind the declaration of a variable is its unit.
"""

import math

from holodrive.control.fuzzy.files.draft import DraftVariable, opened, position
from holodrive.control.fuzzy.files.fcl_reader import Reader, SyntaxFault
from holodrive.control.fuzzy.files.fcl_rules import NORMS, rule, settled_rules
from holodrive.control.fuzzy.files.fcl_terms import RESERVED, settled_outputs, settled_ranges, term
from holodrive.control.fuzzy.files.fcl_tokens import Token, tokens
from holodrive.control.fuzzy.system import System

_BLOCKS = ["VAR_INPUT", "VAR_OUTPUT", "FUZZIFY", "DEFUZZIFY", "RULEBLOCK", "END_FUNCTION_BLOCK"]
_TYPES = ("REAL", "LREAL", "INT")
_METHODS = ["COG", "COGS", "COA", "LM", "RM", "MM", "MOM"]


def parse(text: str, file: str) -> System:
    """The system that an FCL text describes.

    Raises:
        FileFaults: all that is wrong in it.
    """
    draft = opened(text, file)
    found, comments = tokens(draft)
    reader = Reader(draft, found, comments)
    try:
        _function_block(reader)
    except SyntaxFault as fault:
        draft.fault(fault.line, str(fault), fault.hint, fault.column)
        draft.source.refuse()
    settled_ranges(reader)
    settled_outputs(reader)
    settled_rules(reader)
    return draft.system()


def _function_block(reader: Reader) -> None:
    opening = reader.expect("FUNCTION_BLOCK")
    reader.draft.name = _block_name(reader, opening)
    while (token := reader.take()).upper != "END_FUNCTION_BLOCK":
        match token.upper:
            case "VAR_INPUT":
                _declarations(reader, reader.draft.inputs, token)
            case "VAR_OUTPUT":
                _declarations(reader, reader.draft.outputs, token)
            case "FUZZIFY":
                _fuzzify(reader, token)
            case "DEFUZZIFY":
                _defuzzify(reader, token)
            case "RULEBLOCK":
                _rule_block(reader, token)
            case _ if token.kind == "end":
                raise SyntaxFault(token, "the file ends without END_FUNCTION_BLOCK", "is it cut off?")
            case _:
                reader.draft.unknown(token.line, "block", token.text, _BLOCKS, token.column)
                reader.draft.source.refuse()
    after = reader.peek()
    if after.upper == "FUNCTION_BLOCK":
        raise SyntaxFault(after, "a second function block begins; one file is one system", "give it a file of its own")
    if after.kind != "end":
        raise SyntaxFault(after, f"{after.text!r} stands behind END_FUNCTION_BLOCK")


def _block_name(reader: Reader, opening: Token) -> str:
    """The words on the line of FUNCTION_BLOCK (tools write names such as tipper-MAMDANI), or a `name:` comment."""
    words: list[Token] = []
    while (token := reader.peek()).line == opening.line and token.upper not in RESERVED and token.kind != "end":
        words.append(reader.take())
    noted = reader.noted("name", opening.line)
    if noted is not None:
        return noted
    if not words:
        return ""
    line = reader.draft.source.lines[opening.line - 1]
    return line[words[0].column - 1 : words[-1].column - 1 + len(words[-1].text)]


def _declarations(reader: Reader, variables: list[DraftVariable], opening: Token) -> None:
    while not reader.ends("END_VAR", opening):
        with reader.recovering():
            names = [reader.name("a variable")]
            while reader.takes(","):
                names.append(reader.name("a variable"))
            reader.expect(":")
            kind = reader.take()
            if kind.upper not in _TYPES:
                allowed = f"allowed: {', '.join(_TYPES)}"
                reader.draft.fault(kind.line, f"{kind.text!r} is no type of a variable", allowed, kind.column)
            end = reader.expect(";")
            new = [DraftVariable(one.text, one.line) for one in names if _is_new(reader, one)]
            for one in new:
                one.unit = reader.noted("unit", end.line) or ""
            variables += new
            if reader.peek().upper == "RANGE":
                reader.take()
                for one in new:
                    reader.ranges[id(one)] = one.low, one.high = _range(reader)


def _is_new(reader: Reader, name: Token) -> bool:
    twin = next((one for one in (*reader.draft.inputs, *reader.draft.outputs) if one.name == name.text), None)
    if twin is not None:
        message = f"variable {twin.name!r} is there twice; the first is in line {twin.line}"
        reader.draft.fault(name.line, message, column=name.column)
    return twin is None


def _range(reader: Reader) -> tuple[float, float]:
    reader.takes(":=")
    reader.expect("(")
    low = reader.number("the low end of RANGE")
    reader.expect("..")
    high = reader.number("the high end of RANGE")
    reader.expect(")")
    reader.expect(";")
    return low, high


def _variable(reader: Reader, variables: list[DraftVariable], block: str) -> DraftVariable:
    """The variable that a block is about; a stranger is noted, and its block is read all the same."""
    token = reader.name("a variable")
    number = position([one.name for one in variables], token.text)
    if not number:
        kind = "input" if block == "FUZZIFY" else "output"
        reader.draft.unknown(token.line, kind, token.text, [one.name for one in variables], token.column)
        return DraftVariable(token.text, token.line)
    variable = variables[number - 1]
    if id(variable) in reader.blocks:
        reader.draft.fault(
            token.line, f"{block} {variable.name} is there twice; the first is in line {reader.blocks[id(variable)]}"
        )
        return DraftVariable(token.text, token.line)
    reader.blocks.setdefault(id(variable), token.line)
    return variable


def _fuzzify(reader: Reader, opening: Token) -> None:
    variable = _variable(reader, reader.draft.inputs, "FUZZIFY")
    while not reader.ends("END_FUZZIFY", opening):
        with reader.recovering():
            item = reader.take()
            if item.upper == "TERM":
                term(reader, variable)
            elif item.upper == "RANGE":
                reader.ranges[id(variable)] = variable.low, variable.high = _range(reader)
            else:
                raise SyntaxFault(item, f"{item.text!r} has no place in FUZZIFY", "allowed: TERM, RANGE, END_FUZZIFY")


def _defuzzify(reader: Reader, opening: Token) -> None:
    variable = _variable(reader, reader.draft.outputs, "DEFUZZIFY")
    while not reader.ends("END_DEFUZZIFY", opening):
        with reader.recovering():
            item = reader.take()
            match item.upper:
                case "TERM":
                    term(reader, variable)
                case "RANGE":
                    reader.ranges[id(variable)] = variable.low, variable.high = _range(reader)
                case "METHOD":
                    reader.expect(":")
                    reader.methods[id(variable)] = _choice(reader, "METHOD", _METHODS)
                case "ACCU":
                    _norm(reader, item)
                case "DEFAULT":
                    reader.expect(":=")
                    variable.default = math.nan if reader.takes("NC") else reader.number("DEFAULT")
                    reader.expect(";")
                case _:
                    allowed = "allowed: TERM, METHOD, ACCU, DEFAULT, RANGE, END_DEFUZZIFY"
                    raise SyntaxFault(item, f"{item.text!r} has no place in DEFUZZIFY", allowed)


def _choice(reader: Reader, what: str, allowed: list[str]) -> Token:
    word = reader.take()
    if word.upper not in allowed:
        raise SyntaxFault(word, f"no {what} called {word.text!r}", f"allowed: {', '.join(allowed)}")
    reader.expect(";")
    return word


def _norm(reader: Reader, item: Token) -> None:
    """AND, OR, ACT or ACCU; a system has one of each, whichever block says it."""
    reader.expect(":")
    _, allowed = NORMS[item.upper]
    word = _choice(reader, item.upper, list(allowed))
    before = reader.norms.setdefault(item.upper, word)
    if allowed[before.upper] != allowed[word.upper]:
        raise SyntaxFault(
            word, f"{item.upper} is {word.upper} here and {before.upper} in line {before.line}; a system has one"
        )


def _rule_block(reader: Reader, opening: Token) -> None:
    if reader.peek().line == opening.line and reader.peek().kind in ("word", "number"):
        reader.take()  # its name says nothing
    while not reader.ends("END_RULEBLOCK", opening):
        with reader.recovering():
            item = reader.take()
            if item.upper == "RULE":
                rule(reader, item)
            elif item.upper in NORMS:
                _norm(reader, item)
            else:
                allowed = "allowed: AND, OR, ACT, ACCU, RULE, END_RULEBLOCK"
                raise SyntaxFault(item, f"{item.text!r} has no place in RULEBLOCK", allowed)
