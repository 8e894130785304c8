"""A folder of TOML files as a library: names, and which file a name or a path means."""

from functools import cache
from pathlib import Path

from holodrive.errors import InputError, UnknownName


@cache
def names(folder: Path) -> tuple[str, ...]:
    """The entries of a folder, sorted: the file names without `.toml`."""
    return tuple(sorted(file.stem for file in folder.glob("*.toml")))


def find(kind: str, folder: Path, name: str | Path) -> Path:
    """The file that a user means by a shipped name or by a path of their own."""
    text = str(name)
    if text in names(folder):
        return folder / f"{text}.toml"
    if isinstance(name, Path) or text.endswith(".toml") or "/" in text or "\\" in text:
        return Path(name)
    if text.isprintable() and len(text) < 100 and Path(f"{text}.toml").is_file():
        raise InputError(f"no {kind} called {text!r} is shipped, but there is a file {text}.toml here: write its name")
    raise UnknownName(kind, text, names(folder))
