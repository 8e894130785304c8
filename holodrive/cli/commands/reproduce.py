"""`holodrive reproduce`."""

import re
import time
from typing import TYPE_CHECKING, Any

import click

from holodrive.cli.options import checked_ending, out_option, verb
from holodrive.cli.output import Output

if TYPE_CHECKING:
    from holodrive.experiments import Claim, Experiment, Part, Result

_ROMAN = {
    1: "i",
    2: "ii",
    3: "iii",
    4: "iv",
    5: "v",
    6: "vi",
    7: "vii",
    8: "viii",
    9: "ix",
    10: "x",
    11: "xi",
    12: "xii",
}


@verb(
    "reproduce",
    ["", "hybrid", "hybrid --table X", "hybrid --figure 30 -o figure.html", "hybrid --part a3 --worlds 3000"],
)
@click.argument("paper", required=False)
@click.option("--table", "tables", multiple=True, metavar="X", help="Only this table, such as X or 10.")
@click.option("--figure", "figures", multiple=True, metavar="N", help="Only this figure, such as 30.")
@click.option("--part", "parts", multiple=True, metavar="KEY", help="Only this part; without PAPER's parts see --list.")
@click.option("--list", "only_list", is_flag=True, help="List the parts and compute nothing.")
@click.option("--worlds", type=click.IntRange(1), default=300, show_default=True, help="Random worlds of a benchmark.")
@click.option("--seeds", type=click.IntRange(1), default=3, show_default=True, help="Noise seeds of a repeated run.")
@click.option("--cluster", metavar="ADDRESS", help="Dask scheduler that does the roll-outs.")
@out_option("Report to write (.html); out/reproduce/PAPER.html when everything is made.")
def command(out: Output, paper: str | None, **options: Any) -> None:
    """Every table and figure of a PAPER that holds numbers: printed value, ours, verdict; and benchmarks."""
    from holodrive import experiments

    checked_ending(options["path"], "-o", ".html")
    if paper is None:
        _list_papers(out)
        return
    experiment = experiments.load(paper)
    if options["only_list"]:
        _list_parts(out, experiment)
        return
    chosen = _chosen(experiment, options)
    setting = experiments.Setting(
        worlds=options["worlds"], seeds=options["seeds"], cluster=options["cluster"], tell=out.note
    )
    began = time.perf_counter()
    results = _made(out, chosen, setting)
    path = _page(experiment, chosen, results, options)
    if out.json:
        out.data(_data(chosen, results, path))
        return
    for part, result in zip(chosen, results, strict=True):
        _show(out, part, result)
    if path:
        out.line("page", f"{path} (one file, opens without a network)")
    out.line("time", f"{time.perf_counter() - began:.1f} s")
    out.next(f"holodrive reproduce {paper} --list" if path else f"holodrive reproduce {paper} -o {paper}.html")


def _list_papers(out: Output) -> None:
    from holodrive import experiments

    found = [(name, experiments.load(name)) for name in experiments.names()]
    if out.json:
        out.data([{"name": name, "title": one.title} for name, one in found])
        return
    for name, one in found:
        out.line(name, one.title)
    out.next(f"holodrive reproduce {found[0][0]}")


def _list_parts(out: Output, experiment: "Experiment") -> None:
    if out.json:
        out.data([{"key": part.key, "title": part.title} for part in experiment.parts])
        return
    out.table(("part", "what"), [(part.key, part.title) for part in experiment.parts], left=2)
    out.next(f"holodrive reproduce {experiment.name} --part {experiment.parts[0].key}")


def _chosen(experiment: "Experiment", options: dict[str, Any]) -> "tuple[Part, ...]":
    keys = [f"table-{_roman(name)}" for name in options["tables"]]
    keys += [f"figure-{name.strip()}" for name in options["figures"]]
    keys += [name.strip().lower() for name in options["parts"]]
    return tuple(experiment.part(key) for key in keys) or experiment.parts


def _roman(name: str) -> str:
    text = re.sub(r"^(table|t)[ -]*", "", name.strip().lower())
    return _ROMAN.get(int(text), text) if text.isdigit() else text


def _made(out: Output, parts: "tuple[Part, ...]", setting: Any) -> "list[Result]":
    results = []
    with out.progress("parts", len(parts), "parts") as update:
        for number, part in enumerate(parts):
            setting.tell(f"{part.key:<12}{part.title}")
            results.append(part.make(setting))
            update(number + 1)
    return results


def _page(
    experiment: "Experiment", parts: "tuple[Part, ...]", results: "list[Result]", options: dict[str, Any]
) -> str | None:
    from pathlib import Path

    from holodrive.experiments import ClaimSection
    from holodrive.reports.page import Report
    from holodrive.reports.sections import Section

    whole = len(parts) == len(experiment.parts)
    path = options["path"] or (f"out/reproduce/{experiment.name}.html" if whole else None)
    if path is None:
        return None
    sections: list[Section] = []
    for part, result in zip(parts, results, strict=True):
        if result.claims:
            sections.append(ClaimSection(part.title, result.claims))
        sections += result.sections
    Path(path).parent.mkdir(parents=True, exist_ok=True)
    Report(experiment.title, tuple(sections), experiment.lead).save(path)
    return str(path)


def _data(parts: "tuple[Part, ...]", results: "list[Result]", path: str | None) -> dict[str, Any]:
    from holodrive.experiments import claim_table

    made = {
        part.key: {"title": part.title, "claims": list(claim_table(result.claims).data), "data": result.data}
        for part, result in zip(parts, results, strict=True)
    }
    return {"parts": made, "page": path}


def _show(out: Output, part: "Part", result: "Result") -> None:
    from holodrive.reports.sections import TableSection

    out.text(click.style(part.title, bold=True))
    if result.claims:
        _show_claims(out, result.claims)
    for section in result.sections:
        if isinstance(section, TableSection):
            out.text(f"\n{section.title}\n{section.table.text()}")
    out.text("")


def _show_claims(out: Output, claims: "tuple[Claim, ...]") -> None:
    from holodrive.experiments import claim_table

    table = claim_table(claims)
    lines = type(table)("", table.headers[:-1], tuple(row[:-1] for row in table.cells), table.data, table.numeric[:-1])
    head, *rows = lines.text().splitlines()
    out.text(head)
    for row, claim in zip(rows, claims, strict=True):
        out.text(row)
        if claim.note:
            out.text(click.style(f"    {claim.note}", dim=True))
