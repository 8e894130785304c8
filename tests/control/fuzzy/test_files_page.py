"""The examples of docs/fuzzy-files.md are one system in three formats, written as the writers write them."""

import re
from pathlib import Path

from holodrive.control.fuzzy import files

PAGE = (Path(__file__).parents[3] / "docs" / "fuzzy-files.md").read_text()
BLOCKS = dict(re.findall(r"^```(\w+)\n(.*?)^```$", PAGE, re.DOTALL | re.MULTILINE))


def test_the_three_examples_are_one_system():
    fis, fcl, fml = (files.parse(BLOCKS[name], form) for name, form in (("fis", "fis"), ("fcl", "fcl"), ("xml", "fml")))
    assert fis.rules == fcl.rules == fml.rules
    assert fis.inputs == fcl.inputs == fml.inputs
    assert fis.outputs == fcl.outputs == fml.outputs
    assert files.text(fis, "fis") == BLOCKS["fis"]
    assert files.text(fis, "fcl") == BLOCKS["fcl"]
    assert files.text(fis, "fml") == BLOCKS["xml"]


def test_the_python_example_runs(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    exec(BLOCKS["python"], {})
    assert {one.name for one in tmp_path.iterdir()} == {"repaired.fcl", "repaired.c"}
