"""Broken in any way, a file gives a robot or world, or faults; never anything else."""

from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from holodrive import robots, worlds
from holodrive.errors import FileFaults

MODULES = {"robots": robots, "worlds": worlds}
TEXTS = [(kind, module.load(name).text) for kind, module in MODULES.items() for name in module.names()]
TEXTS += [(kind, module.dump(module.load(name))) for kind, module in MODULES.items() for name in module.names()]
TEXTS += [(kind, module.template("x")) for kind, module in MODULES.items()]
VALUES = ["nan", "-inf", "true", "[]", "{}", '""', "1e308", "-1", "0", "1979-05-27", '"5 kg"', "[[1]]", "9" * 400]
VALUES += ['"', "{ x = 1 }", '{ model = "rplidar-a1" }', '"rplidar-a1"']
KEYS = ["radius", "kind", "at", "motor", "schema", "x", "path", "model", "wheel", "robot", '"a b"', "a.b.c", ""]


@st.composite
def broken(draw):
    kind, text = draw(st.sampled_from(TEXTS))
    lines = text.split("\n")
    for _ in range(draw(st.integers(1, 4))):
        at = draw(st.integers(0, len(lines) - 1))
        key = lines[at].partition("=")[0]
        match draw(st.integers(0, 6)):
            case 0:
                lines[at] = f"{key}= {draw(st.sampled_from(VALUES))}"
            case 1:
                lines[at] = f"{draw(st.sampled_from(KEYS))} ={lines[at].partition('=')[2]}"
            case 2:
                lines[at] = ""
            case 3:
                lines.insert(at, lines[draw(st.integers(0, len(lines) - 1))])
            case 4:
                cut = draw(st.integers(0, len(lines[at])))
                lines[at] = lines[at][:cut] + draw(st.text(max_size=3)) + lines[at][cut + 1 :]
            case 5:
                lines[at] = lines[at].replace("[", "[[", 1).replace("]", "]]", 1)
            case _:
                lines = lines[: at + 1]
    return kind, "\n".join(lines)


def outcome(module, text):
    """What the text describes, or its faults."""
    try:
        return module.parse(text)
    except FileFaults as error:
        return error


@given(broken())
def test_a_broken_file_is_read_or_refused(case):
    kind, text = case
    module = MODULES[kind]
    found = outcome(module, text)
    if isinstance(found, FileFaults):
        assert found.faults
        assert all(fault.message and "\n" not in fault.one_line() for fault in found.faults)
    else:
        assert module.parse(module.dump(found)).name == found.name


@given(st.text(max_size=200))
def test_any_text_is_refused(text):
    for module in MODULES.values():
        assert isinstance(outcome(module, text), FileFaults)


@pytest.mark.parametrize("module", MODULES.values(), ids=list(MODULES))
def test_no_submodule_hides_a_function_of_its_package(module):
    """Importing `robots.dump` as a module would overwrite `robots.dump` the function."""
    folder = Path(module.__file__).parent
    submodules = {file.stem for file in folder.glob("*.py")}
    functions = {name for name in module.__all__ if callable(getattr(module, name))}
    assert not submodules & functions
