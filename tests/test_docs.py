"""What the documents tell people to type does what they say."""

import doctest
import re
import shlex
from pathlib import Path

import pytest

from holodrive.cli import main
from holodrive.cli.verbs import VERBS

ROOT = Path(__file__).parents[1]
PAGES = [ROOT / "README.md", *sorted((ROOT / "docs").rglob("*.md")), ROOT / "CHANGELOG.md"]
BLOCK = re.compile(r"^```(\w*)\n(.*?)^```$", re.DOTALL | re.MULTILINE)


def test_the_tutorial_works_as_typed(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Every command and every Python block, in order, in an empty folder."""
    monkeypatch.chdir(tmp_path)
    done = 0
    for language, text in BLOCK.findall((ROOT / "docs" / "tutorial-your-own-base.md").read_text()):
        if language == "sh":
            for line in text.splitlines():
                words = shlex.split(line)
                assert words[0] == "holodrive"
                assert main(words[1:]) == 0, line
                done += 1
        elif language == "python":
            exec(text, {"__name__": "tutorial"})
            done += 1
    assert done >= 12
    assert {path.name for path in tmp_path.iterdir()} >= {
        *("my_base.toml", "my_base.svg", "my_base.mcap", "my_base.html", "my_base.csv"),
        *("my_world.toml", "my_controller.py", "compare.html", "again.mcap", "again.html"),
    }


def test_the_readme_examples_are_true(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Its Python is a doctest."""
    monkeypatch.chdir(tmp_path)
    result = doctest.testfile(str(ROOT / "README.md"), module_relative=False, optionflags=doctest.NORMALIZE_WHITESPACE)
    assert result.attempted >= 6
    assert result.failed == 0


def test_the_package_docstring_is_true() -> None:
    """And so is that of `import holodrive`."""
    import holodrive

    result = doctest.testmod(holodrive)
    assert result.attempted
    assert result.failed == 0


@pytest.mark.parametrize("page", PAGES, ids=lambda path: path.name)
def test_links_lead_somewhere(page: Path) -> None:
    """Every relative link of every page."""
    for target in re.findall(r"\]\(([^)#\s]+)[^)]*\)", page.read_text()):
        if "://" not in target:
            assert (page.parent / target).exists(), target


def test_every_verb_that_documents_name_exists() -> None:
    """`holodrive xyz` in a document is a verb that there is."""
    for page in PAGES:
        for verb in re.findall(r"(?:`|^|\$ |\n)holodrive ([a-z]+)\b", "\n".join(_code(page.read_text()))):
            assert verb in VERBS, f"{page.name}: {verb}"


def test_every_verb_is_documented() -> None:
    """In the page of the command line."""
    text = (ROOT / "docs" / "cli.md").read_text()
    assert all(f"| `{verb}` |" in text for verb in VERBS)


def _code(text: str) -> list[str]:
    blocks = [block for _, block in BLOCK.findall(text)]
    return blocks + re.findall(r"`[^`\n]+`", BLOCK.sub("", text))
