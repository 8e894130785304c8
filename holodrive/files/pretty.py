"""Faults as a compiler prints them: what, where, the line, a mark under the word, and what to do."""

import re

from holodrive.errors import Fault, FileFaults

_WORD = re.compile(r"\"[^\"]*\"|'[^']*'|[^\s=,#\[\]{}]+|\S")


def errors_text(error: FileFaults) -> str:
    """All faults of a file, each with its source line, and a count at the end."""
    count = len(error.faults)
    blocks = [fault_text(fault) for fault in error.faults]
    return "\n\n".join([*blocks, f"{count} problem{'s' if count > 1 else ''} in {error.file}; nothing was run."])


def fault_text(fault: Fault) -> str:
    """One fault in four to six lines."""
    place = f"{fault.file}:{fault.line}:{fault.column}" if fault.line else fault.file
    lines = [f"error: {fault.message}", f"  --> {place}"]
    if fault.source:
        number = str(fault.line) if fault.line else " "
        gap = " " * len(number)
        source = fault.source.expandtabs(1).rstrip()
        lines.append(f"   {number} | {source}")
        if fault.line:
            word = _WORD.match(source, fault.column - 1)
            width = len(word[0]) if word else 1
            lines.append(f"   {gap} | {' ' * (fault.column - 1)}{'^' * width}")
    if fault.hint:
        lines.append(f"     = {fault.hint}")
    return "\n".join(lines)
