"""Fuzzy systems as files: MATLAB .fis, FCL (IEC 61131-7), FML (IEEE 1855); and C for a microcontroller, written only.

A format is chosen by the file's ending. Wrong files are refused with all their faults, each with its line; a system
that a format cannot express is refused when written, and nothing is left out in silence (docs/fuzzy-files.md).
"""

from pathlib import Path

from holodrive.control.fuzzy.files import c_export, fcl, fcl_write, fis, fis_write, fml, fml_write
from holodrive.control.fuzzy.files.draft import LARGEST
from holodrive.control.fuzzy.system import System
from holodrive.errors import InputError, UnknownName
from holodrive.files.source import read as read_text

FORMATS = {".fis": "fis", ".fcl": "fcl", ".fml": "fml", ".xml": "fml"}
_PARSE = {"fis": fis.parse, "fcl": fcl.parse, "fml": fml.parse}
_TEXT = {"fis": fis_write.text, "fcl": fcl_write.text, "fml": fml_write.text}


def read(path: str | Path) -> System:
    """The system of a file.

    Raises:
        FileFaults: all that is wrong in the file, with line numbers.
        InputError: the ending is none of those known.
    """
    format = _format(Path(path), FORMATS)
    text, name = read_text(path, LARGEST)
    return parse(text, format, name)


def parse(text: str, format: str, file: str = "<text>") -> System:
    """The system of a text in the format "fis", "fcl" or "fml"; `file` is its name in messages.

    Raises:
        FileFaults: all that is wrong in the text, with line numbers.
    """
    if format not in _PARSE:
        raise UnknownName("format of fuzzy systems", format, _PARSE)
    return _PARSE[format](text, file)


def text(system: System, format: str) -> str:
    """The text of a system in the format "fis", "fcl" or "fml".

    Raises:
        InputError: the system has what the format cannot say.
    """
    if format not in _TEXT:
        raise UnknownName("format of fuzzy systems", format, _TEXT)
    return _TEXT[format](system)


def write(system: System, path: str | Path) -> None:
    """Write a system; the ending says how: .fis, .fcl, .fml, .xml, or .c and .h for the C export.

    Raises:
        InputError: the system has what the format cannot say, the ending is not known, the file cannot be written.
    """
    path = Path(path)
    format = _format(path, {**FORMATS, ".c": "c", ".h": "h"})
    content = c_export.c_source(system, header=format == "h") if format in ("c", "h") else text(system, format)
    try:
        path.write_text(content, encoding="utf-8", newline="\n")
    except (OSError, ValueError) as error:
        reason = error.strerror if isinstance(error, OSError) and error.strerror else str(error)
        raise InputError(f"{path}: cannot be written: {reason.lower()}") from None


def _format(path: Path, formats: dict[str, str]) -> str:
    if path.suffix.lower() not in formats:
        raise InputError(f"{path}: {path.suffix or 'no ending'!r} is none of the endings {', '.join(formats)}")
    return formats[path.suffix.lower()]


__all__ = ["FORMATS", "parse", "read", "text", "write"]
