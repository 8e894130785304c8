"""`lint`: what is wrong or doubtful in a fuzzy system, found by its break points and its rules, never by a grid.

Exact for sets with straight sides; Gaussian and bell sets are taken as polylines within 1e-5. Which checks there are is
told by `CODES`. A clean system (symmetric, sets that sum to one, every combination ruled once, zero and both ends of
each output reachable) gives nothing.
"""

import math

from holodrive.control.fuzzy.lint.finding import CODES, Finding, Severity
from holodrive.control.fuzzy.lint.inputs import check_inputs, check_range
from holodrive.control.fuzzy.lint.mirror import Mirror, check_mirror, sides_of
from holodrive.control.fuzzy.lint.outputs import check_outputs
from holodrive.control.fuzzy.lint.rules import check_rules
from holodrive.control.fuzzy.lint.steering import check_steering
from holodrive.control.fuzzy.system import System
from holodrive.errors import InputError

_SEVERITIES = ("error", "warning", "info")


def lint(
    system: System, sensor_range: tuple[float, float] | None = None, mirror: Mirror | None = None
) -> tuple[Finding, ...]:
    """Findings, errors first.

    Args:
        system: any.
        sensor_range: smallest and largest number that the inputs' sensor can tell, in the inputs' units.
        mirror: pairs of variables that are left and right of the same thing, the left one first, such as
            (("DL", "DR"), ("L", "R")). None finds them by their names; () turns these checks off. With exactly one
            pair of inputs and one of outputs, the inputs count as ranges to both sides and the outputs as wheels.

    Raises:
        InputError: a range that does not rise, or a pair that is not there.
    """
    if sensor_range is not None and not -math.inf < sensor_range[0] < sensor_range[1] < math.inf:
        raise InputError(f"the sensor's range is {sensor_range}; it must be two finite numbers that rise")
    sides = sides_of(system, mirror)
    found = [
        *check_inputs(system),
        *(check_range(system, sensor_range) if sensor_range else ()),
        *check_rules(system),
        *check_outputs(system),
        *check_mirror(system, sides),
        *check_steering(system, sides),
    ]
    codes = list(CODES)
    return tuple(sorted(found, key=lambda f: (_SEVERITIES.index(f.severity), codes.index(f.code))))


__all__ = ["CODES", "Finding", "Mirror", "Severity", "lint"]
