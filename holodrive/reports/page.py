"""A report: sections put together into one HTML file that needs nothing else, no network and no server."""

import base64
import hashlib
from collections.abc import Iterable
from dataclasses import dataclass
from functools import cached_property
from html import escape
from importlib import resources
from pathlib import Path

from holodrive import __version__
from holodrive.errors import InputError
from holodrive.log.run import Run
from holodrive.reports.sections import ComparisonSection, RunSection, Section, run_names


@dataclass(frozen=True)
class Report:
    """A page of sections.

    Attributes:
        title: of the page.
        sections: in reading order.
        lead: one or two sentences under the title.
    """

    title: str
    sections: tuple[Section, ...]
    lead: str = ""

    @cached_property
    def html(self) -> str:
        """The whole file as text."""
        style, script = _asset("report.css"), _asset("replay.js")
        # the page itself forbids every fetch; only its own style and script, known by their hashes, may run
        policy = (
            f"default-src 'none'; style-src '{_hash(style)}'; script-src '{_hash(script)}'; "
            "img-src data:; base-uri 'none'; form-action 'none'"
        )
        body = "".join(
            f'<section id="s{i}" aria-label="{escape(section.title)}">'
            f"{self._heading(section)}{section.html()}</section>"
            for i, section in enumerate(self.sections)
        )
        lead = f'<p class="lead">{escape(self.lead)}</p>' if self.lead else ""
        return (
            '<!doctype html>\n<html lang="en"><head><meta charset="utf-8">'
            f'<meta http-equiv="Content-Security-Policy" content="{escape(policy)}">'
            '<meta name="viewport" content="width=device-width, initial-scale=1">'
            f"<title>{escape(self.title)}</title><style>{style}</style></head>\n<body>"
            f'<header class="masthead"><div><h1>{escape(self.title)}</h1>{lead}</div></header>{self._contents()}'
            f"<main>{body}</main><footer>Made by holodrive {__version__}. "
            "One file, no network: keep it, mail it, print it.</footer>"
            f"<script>{script}</script></body></html>\n"
        )

    def save(self, path: str | Path) -> Path:
        """Write the page; gives the path."""
        path = Path(path)
        try:
            path.write_text(self.html, encoding="utf-8")
        except OSError as error:
            raise InputError(f"the report cannot be written to {path}: {error.strerror}") from error
        return path

    def _repr_html_(self) -> str:
        """For notebooks: the page in a frame of its own."""
        return f'<iframe srcdoc="{escape(self.html)}" title="{escape(self.title)}" width="100%" height="820"></iframe>'

    def _heading(self, section: Section) -> str:
        """The section's heading; none where it would only say the page's title again."""
        return "" if section.title == self.title else f"<h2>{escape(section.title)}</h2>"

    def _contents(self) -> str:
        if len(self.sections) < 2:
            return ""
        links = "".join(f'<a href="#s{i}">{escape(section.title)}</a>' for i, section in enumerate(self.sections))
        return f'<nav aria-label="Contents"><div>{links}</div></nav>'


def report(content: Run | Section | Iterable[Run | Section], title: str = "", lead: str = "") -> Report:
    """A page about one run, several runs (compared first, then one by one) or any sections.

    Args:
        content: a run, a section, or several of either.
        title: of the page; by default what ran.
        lead: one or two sentences under the title.

    Raises:
        InputError: nothing to show, or something that is neither a run nor a section.
    """
    items = list(content) if isinstance(content, Iterable) and not isinstance(content, str) else [content]
    if not items:
        raise InputError("a report needs at least one run or section, found none")
    for item in items:
        if not isinstance(item, Run) and not hasattr(item, "html"):
            raise InputError(
                f"a report shows runs and sections; found {type(item).__name__} "
                "(a fuzzy system: holodrive.reports.fuzzy.FuzzySection(system))"
            )
    runs = [item for item in items if isinstance(item, Run)]
    names = run_names(runs) if len(runs) > 1 else ("",) * len(runs)
    sections: list[Section] = []
    if len(runs) > 1:
        sections.append(ComparisonSection(tuple(runs), names))
    name_of = iter(names)
    for item in items:
        sections.append(RunSection(item, next(name_of)) if isinstance(item, Run) else item)
    return Report(title or _title(runs, sections), tuple(sections), lead)


def _title(runs: list[Run], sections: list[Section]) -> str:
    if len(runs) > 1:
        return f"{len(runs)} runs compared"
    return sections[0].title


def _asset(name: str) -> str:
    return resources.files("holodrive.reports").joinpath(name).read_text(encoding="utf-8")


def _hash(content: str) -> str:
    return "sha256-" + base64.b64encode(hashlib.sha256(content.encode("utf-8")).digest()).decode("ascii")
