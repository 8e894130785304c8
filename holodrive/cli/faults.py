"""From an exception to words and an exit code, in the style of a good compiler."""

import traceback

import click

from holodrive.cli.output import Output, colour
from holodrive.errors import FileFaults, HolodriveError

INTERRUPTED = 130


def report_fault(error: BaseException, out: Output) -> int:
    """Say on standard error what went wrong; give the exit code. The trace comes with -v only."""
    if isinstance(error, (KeyboardInterrupt, click.Abort)):
        out.note("\ninterrupted")
        return INTERRUPTED
    if out.verbose and not isinstance(error, click.ClickException):
        traceback.print_exception(error)
    if isinstance(error, click.ClickException):
        return _usage(error)
    if isinstance(error, HolodriveError):
        _holodrive(error)
        return error.exit_code
    if isinstance(error, OSError):
        _say(f"{error.filename}: {error.strerror}" if error.filename else str(error.strerror or error))
        return 2
    _say(f"{type(error).__name__}: {error}")
    click.echo("     = this is a fault of holodrive, not of your input; -v shows where it happened", err=True)
    return 1


def _holodrive(error: HolodriveError) -> None:
    if isinstance(error, FileFaults):
        from holodrive.files.pretty import errors_text

        click.echo(errors_text(error), err=True)
    else:
        _say(str(error))


def _usage(error: click.ClickException) -> int:
    if isinstance(error, click.exceptions.NoArgsIsHelpError):
        click.echo(error.format_message(), err=True)
        return error.exit_code
    _say(error.format_message())
    context = getattr(error, "ctx", None)
    if context is not None:
        click.echo(f"     = see: {context.command_path} --help", err=True)
    return error.exit_code


def _say(message: str) -> None:
    click.echo(click.style("error: ", fg="red", bold=True) + message, err=True, color=colour())
