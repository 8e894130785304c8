"""The command line: arguments become calls of the same verbs that Python has.

Each command lives in a module of its own, which is imported when it is called and not before.
"""


def main(arguments: list[str] | None = None) -> int:
    """Run `holodrive ...` and give the exit code: 0 ok, 1 failed check, 2 wrong input, 3 hardware, 130 Ctrl-C."""
    import sys

    if (sys.argv[1:] if arguments is None else arguments) in ([], ["-h"], ["--help"]):
        from holodrive.cli.verbs import HELP

        sys.stdout.write(HELP)  # three times as fast as by way of click
        return 0
    from holodrive.cli.app import run

    return run(arguments)


__all__ = ["main"]
