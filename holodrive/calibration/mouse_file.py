"""What a calibration of mice has found, in the robot's file: `mount` and `resolution`, everything else as it was."""

import math

from holodrive import robots
from holodrive.calibration.mice import MiceCalibration, Parameter, resolution
from holodrive.errors import InputError
from holodrive.files.edit import Noted, edited
from holodrive.robots.spec import Mouse
from holodrive.types import Pose


def rewritten(text: str, file: str, found: MiceCalibration) -> str:
    """The robot's file with the numbers that were told; those that were not stay what they are.

    Args:
        text: of the file; comments and order stay.
        file: its name in messages.
        found: by the same mice.

    Raises:
        InputError: nothing was told, the file has no such mice, or it would not be right any more.
    """
    own = {mouse.name: mouse for mouse in robots.parse(text, file).mice}
    changes: dict[str, object] = {}
    for i, name in enumerate(found.mice):
        if name not in own:
            raise InputError(f"{file} has no mouse {name!r}; it has {', '.join(own) or 'none'}")
        changes |= _changes(own[name], found, i)
    if not changes:
        raise InputError(f"the runs tell nothing that could be written into {file}: {'; '.join(found.notes)}")
    new = edited(text, changes)
    robots.parse(new, file)
    return new


def _changes(mouse: Mouse, found: MiceCalibration, i: int) -> dict[str, object]:
    told = {each.name: each for each in found.parameters if each.mouse == mouse.name and each.told}
    old, new = mouse.mount, found.mounts[i]
    mount = Pose(
        new.x if "x" in told else old.x, new.y if "y" in told else old.y, new.theta if "yaw" in told else old.theta
    )
    out: dict[str, object] = {}
    if mount != old:
        yaw = f"{math.degrees(mount.theta):.4f} deg"
        place = {"x": f"{1e3 * mount.x:.3f} mm", "y": f"{1e3 * mount.y:.3f} mm", "yaw": yaw}
        out[f"sensor.mouse.{mouse.name}.mount"] = Noted(place, _mount_note(told))
    scales = [each for name, each in told.items() if name.startswith("scale")]
    if scales and len(scales) == sum(each.name.startswith("scale") for each in found.parameters) // len(found.mice):
        sigma = max(each.sigma for each in scales)
        note = f"calibrated, standard deviation {1e6 * sigma:.2g} um"
        out[f"sensor.mouse.{mouse.name}.resolution"] = Noted(f"{1e6 * resolution(found.scales_m[i]):.5f} um", note)
    return out


def _mount_note(told: dict[str, Parameter]) -> str:
    """Which numbers of a mount were calibrated, and how well."""
    parts = [f"{name} {1e3 * told[name].sigma:.2g} mm" for name in ("x", "y") if name in told]
    if "yaw" in told:
        parts.append(f"yaw {math.degrees(told['yaw'].sigma):.2g} deg")
    return f"calibrated, standard deviations {', '.join(parts)}"
