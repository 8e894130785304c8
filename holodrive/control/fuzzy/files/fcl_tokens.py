"""FCL text as words, numbers and signs, each with its place; comments apart."""

import re
from dataclasses import dataclass

from holodrive.control.fuzzy.files.draft import Draft

_TOKEN = re.compile(
    r"(?P<number>[+-]?(?:\d+\.(?!\.)\d*|\d+|\.\d+)(?:[eE][+-]?\d+)?)"
    r"|(?P<word>[^\W\d]\w*)"
    r"|(?P<sign>:=|\.\.|[:;,()])"
)
_SPACE = re.compile(r"\s+")


@dataclass(frozen=True, slots=True)
class Token:
    """A piece of the text: kind is "word", "number", "sign" or "end"; line and column count from 1."""

    kind: str
    text: str
    line: int
    column: int

    @property
    def upper(self) -> str:
        """Keywords count in any letter case."""
        return self.text.upper()


def tokens(draft: Draft) -> tuple[list[Token], dict[int, list[str]]]:
    """All tokens, the last of kind "end", and the comments that begin in each line."""
    text = draft.source.text
    found: list[Token] = []
    comments: dict[int, list[str]] = {}
    at, line, start = 0, 1, 0
    while at < len(text):
        if space := _SPACE.match(text, at):
            end = space.end()
        elif (opening := text[at : at + 2]) in ("(*", "/*", "//"):
            closing = {"(*": "*)", "/*": "*/", "//": "\n"}[opening]
            close = text.find(closing, at + 2)
            if close < 0 and opening != "//":
                draft.fault(line, f"the comment that begins here has no end {closing!r}", column=at - start + 1)
                draft.source.refuse()
            inner = text[at + 2 : close if close >= 0 else len(text)]
            comments.setdefault(line, []).append(inner.strip())
            end = len(text) if close < 0 else close + (0 if opening == "//" else 2)
        else:
            match = _TOKEN.match(text, at)
            end = match.end() if match else at + 1  # any other character is a sign that fits nowhere
            kind = str(match.lastgroup) if match else "sign"
            found.append(Token(kind, text[at:end], line, at - start + 1))
        if newlines := text.count("\n", at, end):
            line, start = line + newlines, text.rindex("\n", at, end) + 1
        at = end
    last = found[-1].line if found else 1
    found.append(Token("end", "", last, 1))
    return found, comments
