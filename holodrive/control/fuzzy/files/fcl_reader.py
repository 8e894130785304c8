"""Reading FCL token by token: what comes next, what must come, and going on after a fault."""

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field

from holodrive.control.fuzzy.files.draft import Draft
from holodrive.control.fuzzy.files.fcl_tokens import Token
from holodrive.control.fuzzy.files.rules import Condition

BLOCKS = ("VAR_INPUT", "VAR_OUTPUT", "FUZZIFY", "DEFUZZIFY", "RULEBLOCK")
KEYWORDS = {
    *BLOCKS,
    *(f"END_{block}" for block in BLOCKS),
    "IF",
    "THEN",
    "IS",
    "NOT",
    "AND",
    "OR",
    "WITH",
    "TERM",
    "RULE",
}


class SyntaxFault(Exception):  # never leaves the readers
    """The text at a token is not what the language has there."""

    def __init__(self, token: Token, message: str, hint: str = "") -> None:
        super().__init__(message)
        self.line, self.column, self.hint = token.line, token.column, hint


@dataclass(slots=True)
class PendingRule:
    """A rule as it is written; it becomes a `Rule` when the norms of the system are known."""

    line: int
    condition: Condition
    conclusions: list[tuple[int, int]]  # output from 0, set from 1
    weight: float


@dataclass(slots=True)
class Reader:
    """A place in the tokens, and what the blocks said so far, by `id` of the variable where it is about one."""

    draft: Draft
    tokens: list[Token]
    comments: dict[int, list[str]]
    at: int = 0
    blocks: dict[int, int] = field(default_factory=dict)  # line of the FUZZIFY or DEFUZZIFY
    ranges: dict[int, tuple[float, float]] = field(default_factory=dict)
    methods: dict[int, Token] = field(default_factory=dict)
    norms: dict[str, Token] = field(default_factory=dict)
    rules: list[PendingRule] = field(default_factory=list)

    def peek(self) -> Token:
        """The next token."""
        return self.tokens[self.at]

    def take(self) -> Token:
        """The next token, and go on; the last one stays."""
        token = self.tokens[self.at]
        self.at = min(self.at + 1, len(self.tokens) - 1)
        return token

    def takes(self, word: str) -> bool:
        """Go on if a sign or keyword comes next, and say whether it did."""
        if self.peek().upper != word:
            return False
        self.take()
        return True

    def expect(self, word: str) -> Token:
        """The sign or keyword that must come next."""
        token = self.peek()
        if token.upper != word:
            raise SyntaxFault(token, f"{word!r} is expected {_found(token)}")
        return self.take()

    def name(self, what: str) -> Token:
        """The name that must come next."""
        token = self.peek()
        if token.kind != "word" or token.upper in KEYWORDS:
            raise SyntaxFault(token, f"the name of {what} is expected {_found(token)}")
        return self.take()

    def number(self, what: str) -> float:
        """The number that must come next."""
        token = self.peek()
        if token.kind != "number":
            raise SyntaxFault(token, f"{what} must be a finite number, {_found(token)}")
        self.take()
        return self.draft.number(token.text, token.line, what, token.column)

    def ends(self, word: str, opening: Token) -> bool:
        """Whether a block ends here; one whose end is missing is a fault."""
        token = self.peek()
        if token.kind == "end" or (token.upper.startswith("END_") and token.upper != word):
            where = f"block {opening.upper}, which begins in line {opening.line}, has no {word}"
            raise SyntaxFault(token, where, "is the file cut off?" if token.kind == "end" else "")
        if token.upper in BLOCKS:
            self.draft.fault(token.line, f"block {opening.upper}, which begins in line {opening.line}, has no {word}")
            return True
        return self.takes(word)

    @contextmanager
    def recovering(self) -> Iterator[None]:
        """A fault in here is noted, and reading goes on behind the next semicolon or before the end of the block."""
        try:
            yield
        except SyntaxFault as fault:
            if self.peek().kind == "end":
                raise
            self.draft.fault(fault.line, str(fault), fault.hint, fault.column)
            if self.tokens[self.at - 1].text != ";" or self.tokens[self.at - 1].line != fault.line:
                while self.peek().kind != "end" and not self.peek().upper.startswith("END_"):
                    if self.take().text == ";":
                        break

    def noted(self, key: str, line: int) -> str | None:
        """What a comment such as `(* unit: mm *)` of a line says."""
        for comment in self.comments.get(line, []):
            before, colon, value = comment.partition(":")
            if colon and before.strip().lower() == key:
                return value.strip()
        return None


def _found(token: Token) -> str:
    return "where the file ends" if token.kind == "end" else f"and {token.text!r} is found"
