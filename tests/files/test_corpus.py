"""A corpus of wrong files: each says in its first lines what must be said about it, all of it and nothing else."""

from pathlib import Path

import pytest

from holodrive import robots, worlds
from holodrive.errors import FileFaults
from holodrive.files import errors_text, table_names

CORPUS = Path(__file__).parents[1] / "corpus"
MARK = "# expect: "
FILES = sorted(CORPUS.glob("*/*.toml"))
LOAD = {"robots": robots.load, "worlds": worlds.load}


def expected(text: str) -> list[str]:
    return [line.removeprefix(MARK) for line in text.splitlines() if line.startswith(MARK)]


def test_the_corpus_is_large():
    assert len(FILES) >= 100
    assert all(expected(file.read_text()) for file in FILES)


@pytest.mark.parametrize("file", FILES, ids=lambda file: f"{file.parent.name}-{file.stem}")
def test_a_wrong_file_gives_exactly_its_faults(file, monkeypatch):
    monkeypatch.chdir(file.parent)
    with pytest.raises(FileFaults) as error:
        LOAD[file.parent.name](file.name)
    assert [fault.one_line() for fault in error.value.faults] == expected(file.read_text())
    assert error.value.exit_code == 2
    assert all("\n" not in fault.one_line() for fault in error.value.faults)


@pytest.mark.parametrize("file", FILES, ids=lambda file: f"{file.parent.name}-{file.stem}")
def test_a_fault_shows_the_line_it_speaks_of(file):
    text = file.read_text()
    with pytest.raises(FileFaults) as error:
        LOAD[file.parent.name](file)
    lines = text.split("\n")
    for fault in error.value.faults:
        if fault.line:
            assert fault.source == lines[fault.line - 1][:200]
            assert 1 <= fault.column <= len(lines[fault.line - 1]) + 1
    assert errors_text(error.value).endswith("nothing was run.")


def repeated(text: str, number: int) -> str:
    return "".join(text.format(i) for i in range(number))


ROBOT, WORLD = "schema = 1\n[robot]\nname = 'x'\n", "schema = 1\n[world]\nname = 'x'\n"
HOSTILE = {
    "deep inline tables": "schema = 1\na = " + "{ a = " * 20000,
    "deep lists": "schema = 1\na = " + "[" * 100000,
    "long dotted key": "schema = 1\n" + "a." * 100000 + "a = 1",
    "long key": ROBOT + "a" * 100000 + " = 1",
    "many wheels": ROBOT + "mass = 1\n" + repeated("[wheel.w{}]\nkind = 'x'\n", 9000),
    "many unknown keys": ROBOT + repeated("key{0} = {0}\n", 15000),
    "many wrong circles": WORLD + "[[circle]]\nx = 'a'\ncolour = 1\n" * 7000,
    "many good circles": WORLD + "[[circle]]\nx = 1\ny = 1\nradius = '1 cm'\n" * 6000 + "a = 1",
    "one long text": ROBOT + "title = '" + "x" * 250000,
    "one long number": ROBOT + "mass = " + "9" * 250000,
    "quotes": '"' * 250000,
    "brackets": "[" * 250000,
    "backslashes": 'a = "' + "\\" * 250000,
    "repeated table": "schema = 1\n" + "[robot]\n" * 30000,
    "spaces": "schema = 1" + " " * 250000 + "x",
}


@pytest.mark.parametrize("name", sorted(HOSTILE))
def test_a_hostile_text_is_refused(name):
    """How long it takes is printed by `benchmarks/`; here it must only end, with faults that fit on a screen."""
    for parse in (robots.parse, worlds.parse):
        with pytest.raises(FileFaults) as error:
            parse(HOSTILE[name])
        assert 1 <= len(error.value.faults) <= 101
        assert all(len(fault.one_line()) < 1000 for fault in error.value.faults)


def test_files_that_are_no_text_are_refused(tmp_path):
    cases = {
        "binary.toml": (bytes(range(256)) * 8, "is not UTF-8 text"),
        "latin.toml": ("schema = 1\n[robot]\nname = 'Küche'\n".encode("latin-1"), "is not UTF-8 text"),
        "zeros.toml": (b"\0" * 100, "not valid TOML"),
        "empty.toml": (b"", "the file is empty"),
        "spaces.toml": (b" \n\n", "the file is empty"),
        "large.toml": (b"# x\n" * 2_621_440, "10.5 MB is too large; at most 256 KiB are read"),
    }
    for name, (data, message) in cases.items():
        (tmp_path / name).write_bytes(data)
        for load in LOAD.values():
            with pytest.raises(FileFaults, match=message) as error:
                load(tmp_path / name)
            assert len(error.value.faults) == 1


def test_what_is_no_file_is_refused(tmp_path):
    for load in LOAD.values():
        with pytest.raises(FileFaults, match="there is no such file"):
            load(tmp_path / "missing.toml")
        with pytest.raises(FileFaults, match="is a folder"):
            load(tmp_path)
        with pytest.raises(FileFaults, match="cannot be read"):
            load(tmp_path / ("x" * 5000 + ".toml"))
        with pytest.raises(FileFaults):
            load("\0.toml")


def test_a_file_of_a_similar_name_is_proposed(tmp_path):
    (tmp_path / "robot.toml").write_text("")
    with pytest.raises(FileFaults, match=r"did you mean 'robot.toml'\?"):
        robots.load(tmp_path / "robt.toml")


def test_windows_files_are_read():
    """Carriage returns and the byte-order mark of some editors change nothing."""
    text = robots.template("x")
    assert robots.parse(text.replace("\n", "\r\n")).wheels == robots.parse(text).wheels


def test_the_byte_order_mark_is_skipped(tmp_path):
    file = tmp_path / "robot.toml"
    file.write_bytes(b"\xef\xbb\xbf" + robots.template("x").encode())
    assert robots.load(file).name == "x"


def test_listing_stops_at_a_hundred_faults():
    with pytest.raises(FileFaults, match="more faults are not listed") as error:
        worlds.parse(HOSTILE["many wrong circles"])
    assert len(error.value.faults) == 101


def test_a_world_can_be_told_from_a_robot_before_it_is_read(tmp_path):
    file = tmp_path / "x.toml"
    file.write_text(worlds.template("x"))
    assert table_names(file) == {"schema", "world", "arena", "start", "goal", "circle", "box", "wall"}
    for text in HOSTILE.values():
        file.write_text(text)
        table_names(file)
    assert table_names(tmp_path / "missing.toml") == set()
