"""`holodrive export`."""

from pathlib import Path

import click

from holodrive.cli.options import out_option, verb
from holodrive.cli.output import Output
from holodrive.cli.words import file_size


@verb("export", ["run.mcap -o run.csv", "run.mcap -o run.parquet"])
@click.argument("log", type=click.Path())
@out_option("File to write; its ending says what: .csv or .parquet.", required=True)
def command(out: Output, log: str, path: str) -> None:
    """Write the run in LOG as a table: one row a control tick, columns with units."""
    import holodrive as hd

    run = hd.read(log)
    hd.export(run, path)
    size = Path(path).stat().st_size
    written = {"file": path, "bytes": size, "rows": len(run.time)}
    if out.json:
        out.data(written)
    else:
        out.line("wrote", f"{path} ({len(run.time)} rows, {file_size(size)})")
    out.next(f"holodrive render {log} -o {Path(log).stem}.gif")
