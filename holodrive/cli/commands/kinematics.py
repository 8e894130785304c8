"""`holodrive kinematics`."""

from pathlib import Path

from holodrive.cli.options import checked_ending, out_option, robot_argument, set_option, split_settings, verb
from holodrive.cli.output import Output


@verb("kinematics", ["hybrid3", "mecanum4 -o mecanum4.svg --set wheel.fl.radius=30mm"])
@robot_argument
@set_option
@out_option("Draw the chassis into this SVG file.")
def command(out: Output, robot: str, settings: tuple[str, ...], path: str | None) -> None:
    """Show what ROBOT can do: Jacobian, rank, condition, redundancy, top speeds and what binds them."""
    import holodrive as hd
    from holodrive.kinematics import summary

    checked_ending(path, "--out", ".svg")
    overrides, _ = split_settings(settings)
    described = hd.load(robot, overrides)
    if path:
        from holodrive.kinematics.drawing import chassis_svg

        Path(path).write_text(chassis_svg(described), encoding="utf-8")
    if out.json:
        out.data(summary.as_dict(described) | ({"drawing": path} if path else {}))
    else:
        out.text(summary.as_text(described))
        if path:
            out.line("wrote", path)
    out.next(f"holodrive run {robot}" if path else f"holodrive kinematics {robot} -o {described.name}.svg")
