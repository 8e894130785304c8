"""A corpus of wrong files: each gets exactly the lines that `corpus/expected.txt` says, with file and line number."""

from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from holodrive.cli import main
from holodrive.control.fuzzy import files
from holodrive.errors import FileFaults, InputError, UnknownName

CORPUS = Path(__file__).parent / "corpus"
GOOD = {format: (CORPUS / f"good.{format}").read_text() for format in ("fis", "fcl", "fml")}
WRONG = sorted(one for one in CORPUS.iterdir() if one.stem != "good" and one.suffix != ".txt")
EXPECTED = (CORPUS / "expected.txt").read_text().splitlines()


def test_the_corpus_is_large():
    assert len(WRONG) >= 120
    assert {one.suffix for one in WRONG} == {".fis", ".fcl", ".fml"}


@pytest.mark.parametrize("file", WRONG, ids=lambda file: file.name)
def test_a_wrong_file_gives_exactly_its_faults(file, monkeypatch):
    monkeypatch.chdir(CORPUS)
    with pytest.raises(FileFaults) as error:
        files.read(file.name)
    expected = [line for line in EXPECTED if line.startswith(f"{file.name}:")]
    assert [fault.one_line() for fault in error.value.faults] == expected
    assert error.value.exit_code == 2


def test_a_good_file_of_each_format_is_the_same_system():
    systems = [files.parse(text, format) for format, text in GOOD.items()]
    x = [[100.0, 200.0], [300.0, 250.0], [2000.0, 100.0]]
    for system in systems:
        assert len(system.rules) == 2
        assert (abs(system.evaluate(x) - systems[0].evaluate(x)) < 1e-12).all()


HOSTILE = {
    "one long line": "[" * 300_000,
    "quotes": "'" * 300_000,
    "spaces": "[System]\nName" + " " * 300_000 + "x",
    "comments": "(*" * 150_000,
    "parentheses": "FUNCTION_BLOCK x RULEBLOCK y RULE 1 : IF " + "(" * 100_000,
    "nots": "FUNCTION_BLOCK x RULEBLOCK y RULE 1 : IF " + "NOT " * 60_000,
    "numbers": "FUNCTION_BLOCK x " + "9" * 300_000,
    "sections": "".join(f"[Input{k}]\n" for k in range(20_000)),
    "elements": "<fuzzySystem>" + "<x/>" * 60_000,
    "depth": "<a>" * 60_000,
    "attribute": '<fuzzySystem name="' + "x" * 300_000,
    "laughs": '<!DOCTYPE l [<!ENTITY a "aaaaaaaaaa">'
    + "".join(f'<!ENTITY a{k} "&a;&a;&a;">' for k in range(99))
    + "]>",
    "zeros": "\0" * 1000,
    "surrogate": "\ud800",
}


@pytest.mark.parametrize("name", HOSTILE)
def test_a_hostile_text_is_refused(name):
    """How long it takes is not measured here; it must end, with faults that fit on a screen."""
    for format in GOOD:
        with pytest.raises(FileFaults) as error:
            files.parse(HOSTILE[name], format)
        assert 1 <= len(error.value.faults) <= 101
        assert all(len(fault.one_line()) < 1000 for fault in error.value.faults)


def test_a_rule_that_grows_when_written_out_is_refused():
    """Two to the power of thirty rules."""
    inputs = [f"x{k}" for k in range(30)]
    declared = "".join(f"{one} : REAL;\n" for one in inputs)
    terms = "".join(f"FUZZIFY {one}\nTERM a := (0,0) (1,1);\nTERM b := (0,1) (1,0);\nEND_FUZZIFY\n" for one in inputs)
    condition = " AND ".join(f"({one} IS a OR {one} IS b)" for one in inputs)
    text = (
        f"FUNCTION_BLOCK x\nVAR_INPUT\n{declared}END_VAR\nVAR_OUTPUT\ny : REAL;\nEND_VAR\n{terms}DEFUZZIFY y\n"
        f"TERM p := (0,0) (1,1) (2,0);\nEND_DEFUZZIFY\nRULEBLOCK r\nRULE 1 : IF {condition} THEN y IS p;\n"
        "END_RULEBLOCK\nEND_FUNCTION_BLOCK\n"
    )
    with pytest.raises(FileFaults, match="more than 1000 rules"):
        files.parse(text, "fcl")


def test_what_is_no_text_file_is_refused(tmp_path):
    for format in GOOD:
        cases = {
            "binary": (bytes(range(256)) * 8, "is not UTF-8 text"),
            "latin": ("[System]\nName='Küche'\n".encode("latin-1"), "is not UTF-8 text"),
            "large": (b"% x\n" * 700_000, "is too large; at most 2048 KiB are read"),
            "empty": (b"", "the file is empty"),
        }
        for name, (data, message) in cases.items():
            file = tmp_path / f"{name}.{format}"
            file.write_bytes(data)
            with pytest.raises(FileFaults, match=message) as error:
                files.read(file)
            assert len(error.value.faults) == 1
        with pytest.raises(FileFaults, match="there is no such file"):
            files.read(tmp_path / f"missing.{format}")
    with pytest.raises(InputError, match=r"\.fis, \.fcl, \.fml, \.xml"):
        files.read(tmp_path / "x.txt")
    with pytest.raises(UnknownName, match="format"):
        files.parse("", "json")


@st.composite
def mutated(draw):
    """A good file, changed in a few places."""
    format = draw(st.sampled_from(sorted(GOOD)))
    text = GOOD[format]
    lines = text.split("\n")
    words = sorted(
        {*text.split(), "-1", "NaN", "1e999", "''", "(", ")", "[", "]", "<x>", "&amp;", "9" * 400, "\0", "*)"}
    )
    for _ in range(draw(st.integers(1, 4))):
        at = draw(st.integers(0, len(lines) - 1))
        match draw(st.integers(0, 5)):
            case 0:
                lines[at] = ""
            case 1:
                lines.insert(at, lines[draw(st.integers(0, len(lines) - 1))])
            case 2:
                cut = draw(st.integers(0, len(lines[at])))
                lines[at] = lines[at][:cut] + draw(st.text(max_size=3)) + lines[at][cut + 1 :]
            case 3 | 4:
                parts = lines[at].split(" ")
                parts[draw(st.integers(0, len(parts) - 1))] = draw(st.sampled_from(words))
                lines[at] = " ".join(parts)
            case _:
                lines = lines[: at + 1]
    return format, "\n".join(lines)


@given(mutated())
def test_a_mutated_file_is_read_or_refused(case):
    format, text = case
    try:
        system = files.parse(text, format)
    except FileFaults as error:
        found = error.faults
    else:
        found = ()
        again = files.parse(_said(system, format) or text, format)
        assert len(again.rules) == len(system.rules)
    assert all(fault.message and "\n" not in fault.one_line() for fault in found)


def _said(system, format):
    try:
        return files.text(system, format)
    except InputError:
        return None


@given(st.text(max_size=200), st.sampled_from(sorted(GOOD)))
def test_any_text_is_refused(text, format):
    with pytest.raises(FileFaults):
        files.parse(text, format)


def test_check_knows_fuzzy_systems(monkeypatch, capsys):
    monkeypatch.chdir(CORPUS)
    assert main(["check", "good.fis", "good.fcl", "good.fml"]) == 0
    captured = capsys.readouterr()
    assert captured.out.count("fuzzy system small, 2 inputs, 1 output, 2 rules") == 3
    assert "explain" in captured.err
    assert main(["check", "rule_missing_input.fis"]) == 2
    captured = capsys.readouterr()
    assert "rule_missing_input.fis:35" in captured.err
    assert "Traceback" not in captured.err
