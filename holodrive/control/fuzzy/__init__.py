"""Fuzzy systems: described by values or files, evaluated exactly by one kernel, explained and linted."""

from dataclasses import replace
from pathlib import Path

from holodrive.control.fuzzy.profiles import names, profile
from holodrive.control.fuzzy.sets import Set
from holodrive.control.fuzzy.system import Rule, System, Variable
from holodrive.errors import UnknownName

__all__ = ["Rule", "Set", "System", "Variable", "load", "names"]


def load(name_or_path: str | Path, fuzzylab_compat: bool = False) -> System:
    """A profile by its name, or a system from a .fis, .fcl, .fml or .xml file.

    Args:
        name_or_path: see `names` for the profiles.
        fuzzylab_compat: behave as the library that the first paper used does (fuzzylab 0.13), faults included:
            centroid over 101 samples, the outputs exchanged, inputs not clamped.

    Raises:
        UnknownName: neither a profile nor a file.
        FileFaults: the file is no fuzzy system.
        InputError: fuzzylab cannot evaluate such a system.
    """
    system = profile(str(name_or_path)) if str(name_or_path) in names() else _from_file(Path(name_or_path))
    return replace(system, fuzzylab=True) if fuzzylab_compat else system


def _from_file(path: Path) -> System:
    if not path.suffix and not path.exists():  # meant as a name
        raise UnknownName("fuzzy profile", str(path), names())
    from holodrive.control.fuzzy.files import read

    return read(path)
