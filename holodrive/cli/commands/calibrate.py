"""`holodrive calibrate`: a group whose verbs are imported when they are called."""

from importlib import import_module

import click

from holodrive.cli.output import Output

# what can be calibrated -> what it does; the module is holodrive.cli.calibrate_<name>
KINDS = {
    "steps": "dead zone, dead time and linearizer of the motors, from open-loop PWM steps",
    "mice": "scale, angle and place of ball mice, from a spin and two straight runs",
}
EXAMPLES = """\b
Examples:
  holodrive calibrate steps mecanum4_mice -o mine.toml --report steps.html
  holodrive calibrate steps mine.toml measured.csv --write
"""


class CalibrateGroup(click.Group):
    """A click group over `KINDS`."""

    def list_commands(self, ctx: click.Context) -> list[str]:
        """What can be calibrated, in the order of the table."""
        return list(KINDS)

    def get_command(self, ctx: click.Context, cmd_name: str) -> click.Command | None:
        """Import one verb and give its command."""
        if cmd_name not in KINDS:
            return None
        found = import_module(f"holodrive.cli.calibrate_{cmd_name}").command
        assert isinstance(found, click.Command)
        return found

    def resolve_command(
        self, ctx: click.Context, args: list[str]
    ) -> tuple[str | None, click.Command | None, list[str]]:
        """The verb that is called, or an error that names the nearest one."""
        if args and args[0] not in KINDS:
            from holodrive.errors import with_known

            raise click.UsageError(f"nothing called {args[0]!r} can be calibrated{with_known(args[0], KINDS)}", ctx)
        return super().resolve_command(ctx, args)

    def format_commands(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        """The table, without importing any verb."""
        with formatter.section("Commands"):
            formatter.write_dl(list(KINDS.items()))


@click.group("calibrate", cls=CalibrateGroup, epilog=EXAMPLES, context_settings={"help_option_names": ["-h", "--help"]})
@click.option("-q", "--quiet", is_flag=True, help="No progress and no hints.")
@click.option("-v", "--verbose", is_flag=True, help="Say more; show the trace of an error.")
@click.option("--json", "as_json", is_flag=True, help="The result as JSON.")
@click.pass_context
def command(ctx: click.Context, quiet: bool, verbose: bool, as_json: bool) -> None:
    """Measure a robot and write better numbers into its file."""
    ctx.ensure_object(Output).set(quiet=quiet, verbose=verbose, json=as_json)
