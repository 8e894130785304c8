"""What a calibration of mice could not tell, and what would tell it, in words."""

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING

from holodrive.calibration.mouse_fit import TURNED
from holodrive.calibration.mouse_runs import DIRECTIONS, MouseRun
from holodrive.robots.spec import Mouse

if TYPE_CHECKING:
    from holodrive.calibration.mice import Parameter


_FAR = 0.2  # of the footprint
_OTHER_SCALE = math.log(1.5)  # what is known of a scale before any run
_CHECKED = 0.5  # |sin| between two straight runs that check each other


def notes(parameters: Sequence["Parameter"], runs: Sequence[MouseRun], freedom: int, widened: float) -> tuple[str, ...]:
    """Lines for people: what is not told first."""
    tracked = any(run.kind == "track" for run in runs)
    lines = [*_not_told(parameters, runs, tracked)]
    if not tracked:
        lines += _straights(runs)
        lines += _centre(runs)
    mice = list(dict.fromkeys(each.mouse for each in parameters))
    if len(mice) == 1:
        lines.append(f"mouse {mice[0]} is alone and cannot tell turns: those of the runs are taken as stated")
    lines += _axes(parameters)
    if freedom == 0:
        lines.append("nothing is left over to check the runs against each other")
    if widened > 1.0:
        lines.append(
            f"the runs contradict each other {widened:.2g} times more than the stated accuracies allow: all standard "
            "deviations are that much wider"
        )
    return tuple(lines)


def moved(parameters: Sequence["Parameter"], mice: Sequence[Mouse], footprint_m: float) -> tuple[str, ...]:
    """Lines on mice that come out far from what the robot's file has: the runs cannot contradict a wrong turn."""
    lines = []
    for mouse in mice:
        told = {each.name: each.value for each in parameters if each.mouse == mouse.name and each.told}
        off = math.hypot(told.get("x", mouse.mount.x) - mouse.mount.x, told.get("y", mouse.mount.y) - mouse.mount.y)
        if off > _FAR * footprint_m:
            lines.append(
                f"mouse {mouse.name} comes out {1e3 * off:.3g} mm from its place in the file: if that was measured, "
                "look at the number and the sign of the turns"
            )
        for scale in (value for name, value in told.items() if name.startswith("scale")):
            if abs(math.log(scale / mouse.resolution_m)) > _OTHER_SCALE:
                times = scale / mouse.resolution_m
                lines.append(
                    f"a count of mouse {mouse.name} comes out {times:.3g} times that of the file: if that is "
                    "of its data sheet, look at the lengths and their units"
                )
    return tuple(lines)


def _not_told(parameters: Sequence["Parameter"], runs: Sequence[MouseRun], tracked: bool) -> list[str]:
    missing: dict[str, list[str]] = {}
    for each in parameters:
        if not each.told:
            missing.setdefault(each.mouse, []).append(each.name)
    turned = tracked or any(abs(run.turn_rad) > TURNED for run in runs)
    went = tracked or any(run.kind in DIRECTIONS for run in runs)
    lines = []
    for mouse, names in missing.items():
        what = f"not told of mouse {mouse}: {', '.join(names)}"
        if not went:
            why = (
                "a spin tells the lever arm only against the scale, and its bearing only against the mounting angle; "
                "add a straight run of known length"
            )
        elif not turned:
            why = "without a spin nothing tells the lever arm; turn by a known angle"
        else:
            why = "these runs move it too little; drive farther, turn more often"
        lines.append(f"{what}: {why}")
    return lines


def _straights(runs: Sequence[MouseRun]) -> list[str]:
    angles = [DIRECTIONS[run.kind] for run in runs if run.kind in DIRECTIONS]
    if not angles or any(abs(math.sin(a - b)) > _CHECKED for a in angles for b in angles):
        return []
    return [
        "straight runs one way only: the scale stands on that length alone and the mounting angle on that direction, "
        "and the scales of a mouse's two axes cannot be told apart; add one to the left or ahead"
    ]


def _centre(runs: Sequence[MouseRun]) -> list[str]:
    spins = [run for run in runs if run.kind == "spin"]
    if not spins or any(run.measured[0].what == "end" for run in spins):
        return []
    off_mm = min(1e3 * run.measured[0].sigma[0] / abs(run.turn_rad) for run in spins)
    return [
        f"the spin comes back to where it began, so that nothing tells the point it turned about: it is taken for the "
        f"robot's centre, {off_mm:.2g} mm; end near a half turn (5.5 turns) and measure where the robot stands"
    ]


def _axes(parameters: Sequence["Parameter"]) -> list[str]:
    lines = []
    for x in (each for each in parameters if each.name == "scale x"):
        y = next(each for each in parameters if (each.mouse, each.name) == (x.mouse, "scale y"))
        if not (x.told and y.told):
            continue
        off = 2.0 * (x.value - y.value) / (x.value + y.value)
        sigma = math.hypot(x.sigma / x.value, y.sigma / y.value)
        if abs(off) > 3.0 * sigma:
            lines.append(
                f"the axes of mouse {x.mouse} differ by {100.0 * off:.2g} % (to {100.0 * sigma:.1g} %); "
                "a robot file holds one resolution, their mean"
            )
    return lines
