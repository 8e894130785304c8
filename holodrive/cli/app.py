"""The `holodrive` command: a group that knows its verbs by a table and imports a verb when it is called."""

import io
import os
import sys
from collections.abc import Sequence
from importlib import import_module

import click

from holodrive import __version__
from holodrive.cli.output import Output
from holodrive.cli.verbs import HELP, VERBS


class VerbGroup(click.Group):
    """A click group over `VERBS`."""

    def list_commands(self, ctx: click.Context) -> list[str]:
        """The verbs, in the order of the table."""
        return list(VERBS)

    def get_command(self, ctx: click.Context, cmd_name: str) -> click.Command | None:
        """Import a verb's module and give its command."""
        if cmd_name not in VERBS:
            return None
        command = import_module(f"holodrive.cli.commands.{cmd_name}").command
        assert isinstance(command, click.Command)
        return command

    def resolve_command(
        self, ctx: click.Context, args: list[str]
    ) -> tuple[str | None, click.Command | None, list[str]]:
        """The verb that is called, or an error that names the nearest one."""
        if args and args[0] not in VERBS:
            from holodrive.errors import did_you_mean

            hint = did_you_mean(args[0], VERBS)
            raise click.UsageError(f"no verb called {args[0]!r}{hint or ' (holodrive --help lists them)'}", ctx)
        return super().resolve_command(ctx, args)

    def get_help(self, ctx: click.Context) -> str:
        """The help of the table, without importing any verb."""
        return HELP.rstrip("\n")


@click.group(cls=VerbGroup, context_settings={"help_option_names": ["-h", "--help"]}, invoke_without_command=True)
@click.version_option(__version__, "--version", message="holodrive %(version)s")
@click.option("-q", "--quiet", is_flag=True, help="No progress and no hints.")
@click.option("-v", "--verbose", is_flag=True, help="Say more; show the trace of an error.")
@click.pass_context
def app(ctx: click.Context, quiet: bool, verbose: bool) -> None:
    """The options before the verb; alone, the help."""
    ctx.obj = ctx.ensure_object(Output)
    ctx.obj.set(quiet=quiet, verbose=verbose)
    if ctx.invoked_subcommand is None:
        click.echo(ctx.get_help())


def run(arguments: Sequence[str] | None = None) -> int:
    """Run the command line and give its exit code; nothing that a user can cause leaves as a traceback."""
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper):
            stream.reconfigure(errors="replace")  # a terminal that cannot show a sign is no reason to fail
    out = Output()
    out.arguments = list(sys.argv[1:] if arguments is None else arguments)
    try:
        result = app.main(
            args=out.arguments,
            prog_name="holodrive",
            standalone_mode=False,
            obj=out,
        )
        sys.stdout.flush()
    except BrokenPipeError:  # the reader, such as `head`, has left
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return 141
    except (Exception, KeyboardInterrupt) as error:
        from holodrive.cli.faults import report_fault

        return report_fault(error, out)
    return result if isinstance(result, int) else 0
