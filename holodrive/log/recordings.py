"""Recordings of real robots, whatever they are written in: the format is told by a file's content.

A new format is one module with `fits(head)`, `runs(path)` and `read(path, key, robot)`, and one line in `FORMATS`.
"""

from importlib import import_module
from pathlib import Path
from typing import Protocol, cast

from holodrive.errors import LogError, UnknownName
from holodrive.log.recording import Recording

SHIPPED = Path(__file__).parent / "data" / "optiodom_omni3.npz"


class Format(Protocol):
    """A module that reads one file format."""

    def fits(self, path: Path, head: bytes) -> bool:
        """Whether the file, which begins with `head`, has this format."""
        ...

    def runs(self, path: Path) -> list[str]:
        """Names of the runs in the file."""
        ...

    def read(self, path: Path, run: str, robot: str | None) -> Recording:
        """One run; `robot` replaces what the file says of its robot."""
        ...


# name -> module; tried in this order, the last takes any text
FORMATS: dict[str, str] = {
    "holodrive log (MCAP)": "holodrive.log.recordings_mcap",
    "optiodom (npz)": "holodrive.log.recordings_optiodom",
    "PoliMi Mecanum (npz)": "holodrive.log.recordings_polimi",
    "CSV": "holodrive.log.recordings_csv",
}


def format_of(path: Path) -> Format:
    """The reader of a file.

    Raises:
        LogError: no such file, or no format that fits.
    """
    head = read_head(path)
    for module in FORMATS.values():
        reader = cast(Format, import_module(module))
        if reader.fits(path, head):
            return reader
    raise LogError(f"{path}: in none of the formats that can be replayed: {', '.join(FORMATS)}")


def read_head(path: Path) -> bytes:
    """The first bytes of a file, or one line about why not."""
    try:
        with path.open("rb") as file:
            head = file.read(4096)
    except OSError as error:
        raise LogError(f"cannot read {path}: {error.strerror}") from None
    if not head:
        raise LogError(f"{path}: the file is empty")
    return head


def shipped() -> list[str]:
    """Names of the recordings that come with the package."""
    return runs(SHIPPED)


def runs(path: str | Path) -> list[str]:
    """Names of the runs in a file."""
    where = Path(path)
    return format_of(where).runs(where)


def read(path: str | Path, run: str | None = None, *, robot: str | None = None) -> Recording:
    """One recorded run.

    Args:
        path: of a file, or the name of a shipped recording.
        run: which of the file's runs: its name or a part of it that no other has; not needed where there is one.
        robot: name or file of the robot, over what the file says.

    Raises:
        LogError: the file cannot be read, or holds several runs and `run` does not say which.
        FileFaults: all that is wrong with a CSV file.
        UnknownName: no such run.
    """
    where = Path(path)
    if not where.exists() and str(path) in shipped():
        where, run = SHIPPED, str(path)
    reader = format_of(where)
    return reader.read(where, _which(where, reader.runs(where), run), robot)


def read_all(path: str | Path, *, robot: str | None = None) -> list[Recording]:
    """All the runs of a file."""
    where = Path(path)
    if not where.exists() and str(path) in shipped():
        return [read(path, robot=robot)]
    reader = format_of(where)
    return [reader.read(where, run, robot) for run in reader.runs(where)]


def _which(path: Path, names: list[str], run: str | None) -> str:
    if run is None:
        if len(names) == 1:
            return names[0]
        shown = ", ".join(names[:4]) + (", ..." if len(names) > 4 else "")
        raise LogError(f"{path} holds {len(names)} runs, say which one: {shown}")
    fitting = [run] if run in names else [name for name in names if run in name]
    if not fitting:
        raise UnknownName(f"run in {path}", run, names)
    if len(fitting) > 1:
        raise LogError(f"{run!r} fits {len(fitting)} runs of {path}: {', '.join(fitting[:4])}")
    return fitting[0]


__all__ = ["FORMATS", "SHIPPED", "Format", "Recording", "format_of", "read", "read_all", "runs", "shipped"]
