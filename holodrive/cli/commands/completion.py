"""`holodrive completion`."""

import click

from holodrive.cli.options import verb
from holodrive.cli.output import Output

WHERE = {
    "bash": "~/.bashrc",
    "zsh": "~/.zshrc",
    "fish": "~/.config/fish/completions/holodrive.fish",
}
LINE = {
    "bash": 'eval "$(holodrive completion bash)"',
    "zsh": 'eval "$(holodrive completion zsh)"',
    "fish": "holodrive completion fish | source",
}


@verb("completion", ["bash", "fish"])
@click.argument("shell", type=click.Choice(list(WHERE)))
def command(out: Output, shell: str) -> None:
    """Print what makes SHELL complete verbs, options and robots."""
    from click.shell_completion import get_completion_class

    from holodrive.cli.app import app

    kind = get_completion_class(shell)
    assert kind is not None
    source = kind(app, {}, "holodrive", "_HOLODRIVE_COMPLETE").source()
    if out.json:
        out.data({"shell": shell, "file": WHERE[shell], "line": LINE[shell], "source": source})
        return
    out.text(source)
    out.next(f"put this line into {WHERE[shell]}: {LINE[shell]}")
