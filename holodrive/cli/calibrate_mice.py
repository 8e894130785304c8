"""`holodrive calibrate mice`."""

import math
import shlex
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from holodrive.cli.compiling import compiling
from holodrive.cli.options import (
    checked_ending,
    out_option,
    quantity_of,
    robot_argument,
    seed_option,
    set_option,
    split_settings,
    verb,
)
from holodrive.cli.output import Output
from holodrive.errors import InputError

if TYPE_CHECKING:
    from holodrive.calibration.mice import MiceCalibration, Parameter
    from holodrive.calibration.mouse_runs import Accuracy
    from holodrive.robots.spec import Robot

_SHOWN = 0.05  # of a parameter: runs that tell less of it are not named


@verb(
    "calibrate mice",
    [
        "mecanum4 --set sensor.mouse.two.mount.yaw=3deg -o calibrated.toml",
        "my_robot.toml runs.csv --turns 5.5 --length 1m --write",
        "my_robot.toml drive.mcap -o calibrated.toml",
    ],
)
@robot_argument
@click.argument("runs", required=False, type=click.Path())
@click.option("--turns", type=float, help="Of the spin, counter-clockwise; 5.5 in simulation.")
@click.option("--length", metavar="LENGTH", help="Of each straight run; 1 m in simulation.")
@click.option("--tape", metavar="LENGTH", help="Accuracy of lengths (standard deviation); 1 mm.")
@click.option("--angle", metavar="ANGLE", help="Accuracy of turns (standard deviation); 0.5 deg.")
@click.option("--centre", metavar="LENGTH", help="How far beside its centre it may have turned, unmeasured; 5 mm.")
@click.option("--per-axis", is_flag=True, help="Tell the scales of a mouse's two axes apart.")
@click.option(
    "--plant",
    type=click.Choice(["first_order", "slip", "pwm_map"]),
    help="Of the simulated robot; pwm_map where its file has a [pwm_map], else first_order.",
)
@seed_option
@set_option
@click.option("--csv", "csv_path", metavar="RUNS.csv", type=click.Path(), help="Write the simulated runs as CSV.")
@click.option("--write", is_flag=True, help="Write into ROBOT's own file.")
@out_option("Write ROBOT's file with the new numbers (TOML), comments kept.")
def command(out: Output, robot: str, runs: str | None, **options: Any) -> int:
    """Find scale, mounting angle and lever arm of ROBOT's mice.

    RUNS is a CSV of a spin and two straight runs (docs/calibration.md) or a log (.mcap) with truth or wheel odometry.
    Without it the robot is simulated, drives them itself, and is measured with a tape; its file is the hidden truth.
    """
    import holodrive as hd
    from holodrive import build

    target = _target(robot, options)
    overrides, params = split_settings(options["settings"])
    if params:
        raise InputError("no controller steers a calibration: --set takes keys of the robot's file here")
    if runs and (options["csv_path"] or options["plant"] or overrides):
        raise InputError("the runs come from a file or from a simulated robot: RUNS, or --csv, --plant and --set")
    own = hd.load(robot)
    length = _length(options["length"], "--length")
    accuracy = _accuracy(options)
    used: Any = runs
    if runs is None:
        if not own.mice:
            raise InputError(f"{own.name} has no mice to calibrate; add [sensor.mouse.NAME] to its file")
        used = _driven(out, hd.load(robot, overrides), length, accuracy, options)
    found = build.calibrate_mice(
        own, used, turns=options["turns"], length_m=length, accuracy=accuracy, per_axis=options["per_axis"]
    )
    if target is not None:
        from holodrive.calibration.mouse_file import rewritten
        from holodrive.files.edit import save

        save(target, rewritten(own.text, str(target), found))
    _say(out, own, found, options, target)
    again = shlex.join(["holodrive", *out.arguments, "-o", "calibrated.toml"])
    out.next(f"holodrive check {target}" if target else again)
    return 0


def _target(robot: str, options: dict[str, Any]) -> Path | None:
    """The file to write, refused before any work when it must not be."""
    from holodrive.robots.files import CATALOG

    checked_ending(options["path"], "--out", ".toml")
    checked_ending(options["csv_path"], "--csv", ".csv")
    if options["write"] and options["path"]:
        raise InputError("--write changes ROBOT's own file, --out writes another: give one of them")
    if options["write"] and not robot.endswith(".toml"):
        raise InputError(f"{robot} is a robot of the catalog and stays as it is: write a file of your own, -o NEW.toml")
    target = Path(robot) if options["write"] else Path(options["path"]) if options["path"] else None
    if target is not None and target.resolve().parent == CATALOG.resolve():
        raise InputError(f"{target} lies in the catalog, which stays as it is: write a file of your own, -o NEW.toml")
    for option, file in (("-o", options["path"]), ("--csv", options["csv_path"])):
        if file and Path(file).exists():
            own = " (--write changes ROBOT's own file)" if option == "-o" else ""
            raise InputError(f"{option} {file}: there is such a file already; choose another name{own}")
    return target


def _driven(
    out: Output, robot: "Robot", length_m: float | None, accuracy: "Accuracy | None", options: dict[str, Any]
) -> Any:
    """The runs of the simulated robot."""
    from holodrive import build
    from holodrive.calibration import mouse_csv, mouse_moves
    from holodrive.calibration.mouse_runs import Accuracy

    exact = accuracy or Accuracy()
    turns = options["turns"]
    moves = mouse_moves.moves(robot, 5.5 if turns is None else turns, 1.0 if length_m is None else length_m)
    length = sum(move.duration_s + mouse_moves.SETTLE_S for move in moves)
    with compiling(out) as ready, out.progress("drive", length, "s simulated") as update:

        def progress(done: float) -> None:
            ready()
            update(done)

        driven = build.drive_mice(
            robot,
            turns=turns,
            length_m=length_m,
            accuracy=exact,
            plant=options["plant"] or ("pwm_map" if robot.pwm_map else "first_order"),
            seed=options["seed"],
            progress=progress,
        )
    if options["csv_path"]:
        rows = [(each.move.name, each.move.kind, each.time, each.counts) for each in driven]
        ends: dict[str, tuple[float, float, float]] = {each.move.name: each.stand for each in driven}
        from holodrive.files.edit import save

        save(options["csv_path"], mouse_csv.write_csv(rows, [mouse.name for mouse in robot.mice], ends, exact))
    return [mouse_moves.run_of(each, exact) for each in driven]


def _length(text: str | None, option: str) -> float | None:
    return quantity_of(text, option, "length") if text else None


def _accuracy(options: dict[str, Any]) -> "Accuracy | None":
    """What the options say, None when they say nothing (a CSV file may)."""
    from holodrive.calibration.mouse_runs import Accuracy

    given: dict[str, float] = {}
    for option, name, dimension in (
        ("tape", "tape_m", "length"),
        ("angle", "turn_rad", "angle"),
        ("centre", "centre_m", "length"),
    ):
        if options[option]:
            given[name] = quantity_of(options[option], f"--{option}", dimension)
            if not given[name] > 0.0:
                raise InputError(f"--{option} is an accuracy, above 0; found {options[option]!r}")
    return Accuracy(**given) if given else None


def _say(out: Output, own: "Robot", found: "MiceCalibration", options: dict[str, Any], target: Path | None) -> None:
    from holodrive.calibration.mice import as_dict
    from holodrive.calibration.mouse_notes import moved

    far = moved(found.parameters, own.mice, own.footprint_radius_m)
    if out.json:
        data = as_dict(found)
        data["notes"] += far
        out.data({"robot": own.name, **data, "file": str(target) if target else None})
        return
    rows = [_row(own, each) for each in found.parameters]
    out.table(["mouse", "number", "in the file", "found", "std dev", "told by"], rows, left=2)
    out.text("")
    condition = f"{found.condition:.3g}" if math.isfinite(found.condition) else "infinite"
    run, off = found.worst
    out.line("fit", f"chi2 {found.chi2:.3g} on {found.freedom} degrees of freedom, condition {condition}")
    out.line("worst", f"run {run}: {1e3 * off:.3g} mm off")
    if any(excitation.needed for each in found.parameters for excitation in each.excited_by):
        out.line("!", "not told without this run")
    for note in (*found.notes, *far):
        out.line("note", note)
    if options["csv_path"]:
        out.line("runs", options["csv_path"])
    if target is not None:
        out.line("file", str(target))


def _row(own: "Robot", each: "Parameter") -> list[str]:
    mouse = next(mouse for mouse in own.mice if mouse.name == each.mouse)
    if each.name == "yaw":
        unit, factor, digits, old = "deg", math.degrees(1.0), 3, mouse.mount.theta
    elif each.name.startswith("scale"):
        unit, factor, digits, old = "um", 1e6, 4, mouse.resolution_m
    else:
        unit, factor, digits, old = "mm", 1e3, 2, mouse.mount.x if each.name == "x" else mouse.mount.y
    file = f"{factor * old:.{digits}f} {unit}"
    if not each.told:
        return [each.mouse, each.name, file, "not told", "", ""]
    runs = ", ".join(
        f"{run} {100.0 * share:.0f} %{'!' if needed else ''}"
        for run, share, needed in each.excited_by
        if share > _SHOWN
    )
    return [
        each.mouse, each.name, file, f"{factor * each.value:.{digits}f} {unit}", f"{factor * each.sigma:.{digits}f}",
        runs,
    ]  # fmt: skip
