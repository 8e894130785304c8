"""The page on controllers of one's own is true: its Python runs as it stands."""

import re
from pathlib import Path

PAGE = Path(__file__).parents[1] / "docs" / "own-controller.md"


def test_the_page_on_own_controllers_runs_as_it_stands(tmp_path, monkeypatch):
    """Each block, on its own, with the figures that it asserts."""
    monkeypatch.chdir(tmp_path)
    blocks = re.findall(r"^```python\n(.*?)^```$", PAGE.read_text(), re.DOTALL | re.MULTILINE)
    for number, block in enumerate(blocks):
        exec(compile(block, f"own-controller.md block {number}", "exec"), {"__name__": f"page{number}"})
    assert len(blocks) == 2
