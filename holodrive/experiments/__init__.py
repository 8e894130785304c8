"""The papers' tables and figures, and the benchmarks that take their place; one folder a paper, found by scanning."""

from importlib import import_module
from pkgutil import iter_modules

from holodrive.errors import UnknownName
from holodrive.experiments.claims import Claim, ClaimSection, Verdict, claim_table, claimed
from holodrive.experiments.experiment import Experiment, Part, Result, Setting


def names() -> tuple[str, ...]:
    """The experiments that there are."""
    return tuple(sorted(module.name for module in iter_modules(__path__) if module.ispkg))


def load(name: str) -> Experiment:
    """An experiment by name.

    Raises:
        UnknownName: no such experiment.
    """
    if name not in names():
        raise UnknownName("experiment", name, names())
    found: Experiment = import_module(f"{__name__}.{name}").EXPERIMENT
    return found


__all__ = [
    "Claim",
    "ClaimSection",
    "Experiment",
    "Part",
    "Result",
    "Setting",
    "Verdict",
    "claim_table",
    "claimed",
    "load",
    "names",
]
