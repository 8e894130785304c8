"""`holodrive calibrate steps`."""

import shlex
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from holodrive.cli.compiling import compiling
from holodrive.cli.options import checked_ending, out_option, quantity_of, robot_argument, seed_option, verb
from holodrive.cli.output import Output
from holodrive.errors import InputError

if TYPE_CHECKING:
    from holodrive.calibration.steps import Calibration
    from holodrive.robots.spec import Robot

_MISSED = 0.03  # of the top speed: a step that a curve misses by more was measured wrong
_STRONG = 0.8  # of full PWM


@verb(
    "calibrate steps",
    [
        "mecanum4_mice -o mine.toml --report steps.html --csv steps.csv",
        "mecanum4_mice steps.csv -o mine.toml",
        "mine.toml measured.csv --write",
    ],
)
@robot_argument
@click.argument("steps", required=False, type=click.Path(), metavar="[STEPS.csv]")
@click.option("--plant", type=click.Choice(["pwm_map", "first_order", "slip"]), help="Physics of the simulated robot; "
              "pwm_map where its file has one.")  # fmt: skip
@seed_option
@click.option("--counts", type=click.IntRange(2), help="PWM counts of full duty; those of the file, or 255.")
@click.option("--levels", type=click.IntRange(4, 32), default=20, show_default=True, help="PWM values to see moving.")
@click.option("--step", "step", metavar="TIME", default="1.5 s", show_default=True, help="How long each is held.")
@click.option("--stray", metavar="LENGTH", default="0.5 m", show_default=True, help="How far it may get.")
@click.option("--write", is_flag=True, help="Write the linearizer into ROBOT's own file.")
@click.option("--report", "report_path", type=click.Path(), help="Write a one-file HTML report.")
@click.option("--csv", "csv_path", type=click.Path(), help="Write the steps as CSV, for this command again.")
@out_option("Write ROBOT's file with the linearizer as a new file (TOML).")
def command(out: Output, robot: str, steps: str | None, **options: Any) -> None:
    """Find the dead zone and the linearizer of ROBOT's motors from open-loop PWM steps.

    The steps are read from STEPS.csv, or commanded to a simulated robot. A Mecanum base is stepped by its two
    diagonals, any other base wheel by wheel.
    """
    from holodrive import robots
    from holodrive.files.edit import save

    target = _target(robot, steps, options)
    described = robots.load(robot)
    found = _found(out, described, steps, options)
    written = []
    if target:
        from holodrive.calibration.step_file import text_with

        text = text_with(described, found, str(target))
        save(target, text)
        written.append(str(target))
    command_line = shlex.join(["holodrive", *out.arguments])
    written += _documents(found, described, command_line, options)
    _say(out, found, described, written)
    if target:
        out.next(f"holodrive check {shlex.quote(str(target))}")
    else:
        source = shlex.join([robot, steps] if steps else [robot])
        out.next(f"holodrive calibrate steps {source} -o mine.toml")


def _target(robot: str, steps: str | None, options: dict[str, Any]) -> Path | None:
    """The file that gets the linearizer; whatever forbids to write it is said before any work.

    Raises:
        InputError: two places, a catalog robot, a file that is there already, or no folder.
    """
    path, csv_path = options["path"], options["csv_path"]
    checked_ending(path, "--out", ".toml")
    checked_ending(options["report_path"], "--report", ".html", ".htm")
    checked_ending(csv_path, "--csv", ".csv")
    if path and options["write"]:
        raise InputError("the linearizer goes to one place: -o FILE for a new file, or --write for ROBOT's own")
    if steps and options["plant"]:
        raise InputError("the steps come from a file or from a simulated robot: STEPS.csv or --plant")
    for option, file in (("-o", path), ("--csv", csv_path)):
        if file and Path(file).exists():
            own = " (--write changes ROBOT's own file)" if option == "-o" else ""
            raise InputError(f"{option} {file}: there is such a file already; choose another name{own}")
    if options["write"]:
        return _own_file(robot)
    return Path(path) if path else None


def _own_file(robot: str) -> Path:
    from holodrive.robots.files import CATALOG

    own = Path(robot)
    if not own.name.endswith(".toml") and not (CATALOG / f"{robot}.toml").exists():
        raise InputError(f"--write goes into a robot's own file, whose name ends in .toml; found {robot}")
    if not own.name.endswith(".toml") or (own.exists() and own.resolve().parent == CATALOG.resolve()):
        raise InputError(
            f"{robot} is a robot of the catalog, and --write leaves those alone; -o FILE.toml writes another"
        )
    return own


def _found(out: Output, robot: "Robot", steps: str | None, options: dict[str, Any]) -> "Calibration":
    counts = options["counts"] or _counts(robot, simulated=not steps)
    if steps:
        from holodrive.calibration import steps as calibration

        groups = calibration.groups_of(robot, measured_elsewhere=True)
        return calibration.calibrate(robot, calibration.read_csv(steps, groups, counts), counts)
    from holodrive import build

    step_s = quantity_of(options["step"], "--step", "time")
    stray_m = quantity_of(options["stray"], "--stray", "length")
    plant: Any = options["plant"] or ("pwm_map" if robot.pwm_map else "first_order")
    with compiling(out) as ready:
        base = build.simulate(robot, plant=plant, seed=options["seed"])

        def progress(time: float) -> None:
            ready()

        return build.calibrate_steps(
            base, counts=counts, levels=options["levels"], step_s=step_s, stray_m=stray_m, progress=progress
        )


def _counts(robot: "Robot", *, simulated: bool) -> int:
    """Of full PWM: what the file says of the actuators that are stepped, of the other ones, or 255."""
    import tomllib

    said = tomllib.loads(robot.text).get("linearizer", {}) if robot.text else {}
    own = int(said["counts"]) if "counts" in said else None
    simulation = robot.pwm_map.counts if robot.pwm_map else None
    return (simulation or own or 255) if simulated else (own or simulation or 255)


def _documents(found: "Calibration", robot: "Robot", command_line: str, options: dict[str, Any]) -> list[str]:
    """Write page and CSV; their names."""
    from holodrive.files.edit import save

    written = []
    if options["csv_path"]:
        from holodrive.calibration.steps import write_csv

        save(options["csv_path"], write_csv(step.record for step in found.steps))
        written.append(options["csv_path"])
    if options["report_path"]:
        from holodrive.cli import calibration_page

        calibration_page.page(found, robot, command_line).save(options["report_path"])
        written.append(options["report_path"])
    return written


def _say(out: Output, found: "Calibration", robot: "Robot", written: list[str]) -> None:
    from holodrive.cli import calibration_page

    rows = calibration_page.rows_of(found, robot)
    for one in found.fits:
        if one.unsettled:
            values = ", ".join(f"{pwm:g}" for pwm in one.unsettled[:6])
            out.warn(f"{one.group} {one.direction}: speed still changes at the end of PWM {values}; hold steps longer")
        if one.max_error_m_s > _MISSED * one.top_m_s:
            out.warn(
                f"{one.group} {one.direction}: the curve misses one step by {1e3 * one.max_error_m_s:.3g} mm/s; look "
                "at --report, and measure that step again"
            )
        if one.pwm[-1] < _STRONG * found.counts:
            out.warn(
                f"{one.group} {one.direction}: PWM above {one.pwm[-1]:g} of {found.counts:g} was not measured; the "
                "curve is a guess there (--counts says how many are full)"
            )
    if out.json:
        out.data({"robot": found.robot, "counts": found.counts, "fits": rows,
                  "linearizer": found.toml_tables(robot), "files": written})  # fmt: skip
        return
    out.line("robot", f"{found.robot}, {len(found.steps)} steps, {found.counts:g} PWM counts")
    out.text(calibration_page.table_of(rows).text())
    for file in written:
        out.line("wrote", file)
