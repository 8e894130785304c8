"""`holodrive version`."""

import platform
from importlib.metadata import version

from holodrive import __version__
from holodrive.cli.options import verb
from holodrive.cli.output import Output

STANDS_ON = ("numpy", "scipy", "numba", "pydantic", "click", "rich", "mcap", "zstandard", "pillow")


@verb("version", ["", "--json"])
def command(out: Output) -> None:
    """Say the version, and those of what it stands on."""
    versions = {"holodrive": __version__, "python": platform.python_version()} | {
        name: version(name) for name in STANDS_ON
    }
    if out.json:
        out.data(versions)
        return
    out.text(f"holodrive {__version__}")
    if out.verbose:
        out.table(("package", "version"), list(versions.items())[1:], left=2)
    out.next("holodrive doctor")
