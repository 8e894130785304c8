"""The sensor library: one TOML file a sensor, beside this one; its table's name says the kind."""

from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING

from holodrive.errors import UnknownName
from holodrive.files import library
from holodrive.files.source import Source, Table, open_text, read

if TYPE_CHECKING:
    from holodrive.robots.spec import Encoder, Imu, Lidar, Mouse

FOLDER = Path(__file__).parent
SCHEMA = 1
KINDS = ("lidar", "imu", "mouse", "encoder")


def names(kind: str | None = None) -> tuple[str, ...]:
    """The sensors of the library, all or of one kind."""
    return tuple(name for name in library.names(FOLDER) if kind is None or _entry(name)[0] == kind)


def kind(name: str) -> str:
    """ "lidar", "imu", "mouse" or "encoder"."""
    return _entry(name)[0]


def load(name: str) -> "Lidar | Imu | Mouse | Encoder":
    """A sensor of the library, mounted at the robot's centre."""
    from holodrive.robots import parts

    if name not in names():
        raise UnknownName("sensor", name, names())
    source = Source(f"{name}.toml", "")
    entry: Table = {"model": name}
    found: Lidar | Imu | Mouse | Encoder | None
    if kind(name) == "lidar":
        found = parts.lidar(entry, (), source)
    elif kind(name) == "imu":
        found = parts.imu(entry, (), source)
    elif kind(name) == "mouse":
        found = parts.mouse(name, entry, (), source)
    else:
        found = parts.encoder(name, (), source)
    source.refuse()
    if found is None:
        raise AssertionError(f"{name}: neither an entry nor a fault")
    return found


@cache
def _entry(name: str) -> tuple[str, Table]:
    text, file = read(FOLDER / f"{name}.toml")
    table = open_text(text, file, newest=SCHEMA, migrations={}).table
    (found,) = [entry for entry in KINDS if entry in table]
    return found, table[found]


def table(name: str) -> Table:
    """The keys of a library sensor as its file has them."""
    return dict(_entry(name)[1])


__all__ = ["KINDS", "kind", "load", "names", "table"]
