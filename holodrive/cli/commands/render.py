"""`holodrive render`."""

from pathlib import Path

import click

from holodrive.cli.options import out_option, verb
from holodrive.cli.output import Output
from holodrive.cli.words import file_size


@verb("render", ["run.mcap -o run.gif", "run.mcap -o run.svg"])
@click.argument("log", type=click.Path())
@out_option("File to write; its ending says what: .gif, .png, .svg or .html.", required=True)
def command(out: Output, log: str, path: str) -> None:
    """Make a picture, an animation or a page of the run in LOG."""
    import holodrive as hd

    run = hd.read(log)
    out.note(f"reading {len(run.time)} ticks, {len(run.scans)} scans")
    hd.render(run, path)
    size = Path(path).stat().st_size
    written = {"file": path, "bytes": size}
    if out.json:
        out.data(written)
    else:
        out.line("wrote", f"{path} ({file_size(size)})")
    out.next(f"holodrive export {log} -o {Path(log).stem}.csv")
