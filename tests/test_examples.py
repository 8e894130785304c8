"""Each example runs without a display, ends well and says something."""

import runpy
from pathlib import Path

import pytest

EXAMPLES = sorted((Path(__file__).parents[1] / "examples").glob("*.py"))


@pytest.mark.parametrize("path", EXAMPLES, ids=lambda path: path.stem)
def test_an_example_runs_and_says_something(
    path: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """As `python examples/...` does, in an empty folder."""
    monkeypatch.chdir(tmp_path)
    runpy.run_path(str(path), run_name="__main__")
    assert capsys.readouterr().out.count("\n") >= 2


def test_every_example_is_in_the_list() -> None:
    """And the list has nothing else."""
    text = (EXAMPLES[0].parent / "README.md").read_text()
    assert all(f"`{path.name}`" in text for path in EXAMPLES)
