"""The motor library: one TOML file a motor, beside this one."""

from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING

from holodrive.errors import UnknownName
from holodrive.files import library
from holodrive.files.source import Table, open_text, read

if TYPE_CHECKING:
    from holodrive.robots.spec import Motor

FOLDER = Path(__file__).parent
SCHEMA = 1


def names() -> tuple[str, ...]:
    """The motors of the library."""
    return library.names(FOLDER)


def load(name: str) -> "Motor":
    """A motor of the library, all values behind its gear."""
    from holodrive.files.source import Source
    from holodrive.robots.parts import motor

    if name not in names():
        raise UnknownName("motor", name, names())
    source = Source(f"{name}.toml", "")
    found = motor(name, (), source)
    source.refuse()
    if found is None:
        raise AssertionError(f"{name}: neither an entry nor a fault")
    return found


@cache
def _table(name: str) -> Table:
    text, file = read(FOLDER / f"{name}.toml")
    source = open_text(text, file, newest=SCHEMA, migrations={})
    entry: Table = source.table["motor"]
    return entry


def table(name: str) -> Table:
    """The keys of a library motor as its file has them."""
    return dict(_table(name))


__all__ = ["load", "names", "table"]
