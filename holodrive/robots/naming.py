"""Names of wheels and sensors: they stand in keys, plots and --set."""

import re

from holodrive.files.scan import Path
from holodrive.files.source import Source
from holodrive.files.units import shown

_NAME = re.compile(r"[\w-]{1,60}")


def check_name(name: str, path: Path, source: Source) -> None:
    """Note a fault when the name has other characters than letters, digits, - and _."""
    if not _NAME.fullmatch(name):
        source.fault(path, f"{shown(name)} is no name; use letters, digits, - and _, at most 60", at_key=True)
