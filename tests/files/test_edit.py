"""A change to a file is what was asked for, and only that: comments, order and units of the rest stay to the letter."""

import copy
import os
import tomllib

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from holodrive import robots, worlds
from holodrive.errors import FileFaults, InputError
from holodrive.files.edit import Noted, edited, save

ROBOTS = {name: robots.load(name).text for name in robots.names()} | {"template": robots.template("x")}
CURVES = {
    "counts": 255,
    "speed_unit": "mm/s",
    "one": {
        "wheels": ["fl", "rr"],
        "forward": {"cubic": [44.0, 2.5, -0.1, 0.005]},
        "backward": {"points": [[45, 0.0], [255, 38.5]]},
    },
    "two": {
        "wheels": ["fr", "rl"],
        "forward": {"points": [[45, 0], [255, 38]]},
        "backward": {"points": [[4, 0], [5, 1]]},
    },
}


def lines_of(text):
    return text.split("\n")


def paths(table, prefix=()):
    """Dotted paths of all keys, of tables and of what is in them."""
    for key, value in table.items():
        yield ".".join((*prefix, key))
        if isinstance(value, dict):
            yield from paths(value, (*prefix, key))


def filled(table):
    """Without empty tables, which a removal may take with it."""
    inner = {key: filled(value) if isinstance(value, dict) else value for key, value in table.items()}
    return {key: value for key, value in inner.items() if value != {}}


def with_change(table, path, value):
    changed = node = copy.deepcopy(table)
    *way, last = path.split(".")
    for key in way:
        node = node.setdefault(key, {})
    if value is None:
        node.pop(last, None)
    else:
        node[last] = value
    return changed


VALUES = (
    st.integers(-(10**9), 10**9)
    | st.floats(allow_nan=False, allow_infinity=False)
    | st.booleans()
    | st.text(st.characters(codec="utf-8", exclude_categories=["Cs", "Cc"]), max_size=20)
    | st.lists(st.floats(-1e3, 1e3), max_size=3)
    | st.dictionaries(st.sampled_from(["x", "y", "a b"]), st.integers(0, 9), max_size=2)
    | st.fixed_dictionaries({"n": st.integers(0, 9), "inner": st.fixed_dictionaries({"v": st.integers(0, 9)})})
)


@given(st.data())
def test_any_change_to_any_robot_means_what_was_asked_for(data):
    """Of a value, a table or something new, anywhere in any shipped robot; one after another."""
    text = ROBOTS[data.draw(st.sampled_from(sorted(ROBOTS)))]
    for _ in range(data.draw(st.integers(1, 3))):
        table = tomllib.loads(text)
        known = sorted(paths(table))
        tables = [path for path in known if isinstance(value_at(table, path), dict)]
        new = st.builds("{}.{}".format, st.sampled_from(tables), st.sampled_from(["new", "x", "deep.er"]))
        path = data.draw(st.sampled_from(known) | new)
        value = data.draw(st.none() | VALUES)
        try:
            text = edited(text, {path: value})
        except InputError:  # only a way through what is no table is refused
            assert any(not isinstance(part, dict | None) for part in parents(table, path))
            return
        assert filled(tomllib.loads(text)) == filled(with_change(table, path, value))


def value_at(table, path):
    for key in path.split("."):
        table = table.get(key) if isinstance(table, dict) else None
    return table


def parents(table, path):
    keys = path.split(".")
    return [value_at(table, ".".join(keys[:n])) for n in range(1, len(keys))]


@pytest.mark.parametrize("name", sorted(ROBOTS))
def test_changing_every_value_to_itself_keeps_every_line(name):
    text = ROBOTS[name]
    table = tomllib.loads(text)
    plain = {path: value_at(table, path) for path in paths(table) if not isinstance(value_at(table, path), dict)}
    after = edited(text, plain)
    assert tomllib.loads(after) == table
    assert after == text


def test_one_value_changes_one_line_and_its_comment_keeps_its_column():
    before = robots.load("mecanum4").text
    after = edited(before, {"robot.mass": "4.2345 kg"})
    changed = [(a, b) for a, b in zip(lines_of(before), lines_of(after), strict=True) if a != b]
    assert len(changed) == 1
    ((old, new),) = changed
    assert new.startswith('mass = "4.2345 kg"')
    assert new[new.index("#") :] == old[old.index("#") :]
    assert new.index("#") == old.index("#")


def test_a_calibrated_mouse_keeps_its_comments_and_the_units_of_the_rest():
    before = robots.load("mecanum4").text
    mount = {"x": 0.1012, "y": -0.0021, "yaw": 0.031}
    after = edited(before, {"sensor.mouse.two.mount": mount, "sensor.mouse.two.resolution": np.float64(1.02e-5)})
    robot = robots.parse(after)
    assert tuple(robot.mice[1].mount) == pytest.approx((0.1012, -0.0021, 0.031))
    assert robot.mice[1].resolution_m == 1.02e-5
    assert robot.mice[0] == robots.load("mecanum4").mice[0]
    lost = [line for line in lines_of(before) if line not in lines_of(after)]
    assert lost == ['mount = { x = "100 mm", y = 0 }    # assumed: the distance D is not printed']
    assert "mount = { x = 0.1012, y = -0.0021, yaw = 0.031 } # assumed: the distance D is not printed" in after


@pytest.mark.parametrize("name", ["mecanum4", "mecanum4_mice"])
def test_another_linearizer_replaces_the_old_one_in_its_place(name):
    before = robots.load(name).text
    after = edited(before, {"linearizer": CURVES})
    assert robots.parse(after).pwm_map == robots.load(name).pwm_map
    assert tomllib.loads(after)["linearizer"] == CURVES
    assert after.index("[linearizer.two]") < after.index("[pwm_map]")
    alone = [line for line in lines_of(before) if line.startswith("#")]
    assert [line for line in lines_of(after) if line.startswith("#")] == alone


def test_a_new_table_comes_at_the_end_with_one_empty_line_before_it():
    before = robots.load("omni4").text.rstrip("\n")
    after = edited(before, {"speed_loop": {"kp": 1.0, "ki": Noted(2.0, "by hand")}})
    assert after == f"{before}\n\n[speed_loop]\nkp = 1.0\nki = 2.0  # by hand\n"


def test_a_new_key_comes_before_the_comment_of_the_next_table():
    before = "[a]\nx = 1  # one\n\n# about b\n[b]\ny = 2\n"
    assert edited(before, {"a.z": 3}) == "[a]\nx = 1  # one\nz = 3\n\n# about b\n[b]\ny = 2\n"
    assert (
        edited(before, {"a.c": {"v": {"w": 3}}})
        == "[a]\nx = 1  # one\n\n[a.c]\nv = { w = 3 }\n\n# about b\n[b]\ny = 2\n"
    )


def test_a_note_takes_the_place_of_the_comment():
    before = "a = 1    # assumed\nb = [\n  1, # one\n  2,\n]\nc = { d = 1 } # x\n"
    after = edited(before, {"a": Noted(2, "measured\n2026"), "b": Noted([3], "three"), "c.d": Noted(5, "no place")})
    assert after == "a = 2    # measured 2026\nb = [3]  # three\nc = { d = 5 } # x\n"


@pytest.mark.parametrize(
    ("before", "change", "after"),
    [
        ("a.b = 1\n", {"a.c": 2}, "a.b = 1\na.c = 2\n"),
        ("a = { b = { c = 1 } } # x\n", {"a.b.d": 2}, "a = { b = { c = 1, d = 2 } } # x\n"),
        ("a = 'x'\n", {"a": {"b": 1}}, "a = { b = 1 }\n"),
        ("[x]\na = 1\n[y]\n[x.z]\nb = 1\n", {"x.z.b": None}, "[x]\na = 1\n[y]\n[x.z]\n"),
        ("[x.a]\nk = 1\n[y]\n[x.b]\nk = 1\n", {"x.c.k": 2}, "[x.a]\nk = 1\n[y]\n[x.b]\nk = 1\n\n[x.c]\nk = 2\n"),
        ("[x]\n", {"x.k": '"'}, '[x]\nk = "\\""\n'),
        ("# nothing\n", {"k": 1}, "k = 1\n# nothing\n"),
        ('"a b" = 1 # x', {"a b": 2}, '"a b" = 2 # x'),
        ("[[c]]\nr = 1\n[t]\nk = 1\n", {"t.k": 2}, "[[c]]\nr = 1\n[t]\nk = 2\n"),
        ("a = 1\n", {"b.c": None, "a": 2}, "a = 2\n"),
    ],
)
def test_tables_may_be_written_in_any_way(before, change, after):
    assert edited(before, change) == after


def test_windows_lines_stay_windows_lines():
    text = "a = 1 # x\r\n[b]\r\nc = 2\r\n"
    assert edited(text, {"b.d": 3, "a": 10}) == "a = 10 # x\r\n[b]\r\nc = 2\r\nd = 3\r\n"


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"robot.mass.value": 1}, "robot.mass is '4 kg' and holds no keys"),
        ({"robot..mass": 1}, "'robot..mass' is no path of a key"),
        ({"": 1}, "'' is no path of a key"),
        ({"robot.mass": float("nan")}, "nan is not a finite number"),
        ({"robot.mass": np.inf}, "inf is not a finite number"),
        ({"robot.mass": object()}, "has no place in a TOML file"),
        ({"robot.mass": [1, None]}, "None has no place in a TOML file"),
    ],
)
def test_what_cannot_be_written_is_refused(change, message):
    with pytest.raises(InputError, match=message):
        edited(robots.load("mecanum4").text, change)


def test_what_is_no_toml_is_refused():
    for text in ("a =", "[a\nb = 1", "a = 1\na = 2", "a = " + "[" * 5000):
        with pytest.raises(InputError, match="no TOML"):
            edited(text, {"a": 1})


def test_a_list_of_tables_is_no_way():
    with pytest.raises(InputError, match="circle is a list and holds no keys"):
        edited(worlds.template("x"), {"circle.1.radius": 1})


def test_a_change_that_makes_the_robot_faulty_is_found_before_it_is_saved(tmp_path):
    """The caller parses what `edited` gives; the file is as it was."""
    file = tmp_path / "robot.toml"
    file.write_text(robots.load("mecanum4").text)
    text = edited(file.read_text(), {"linearizer": {**CURVES, "two": {**CURVES["two"], "wheels": ["fr"]}}})
    with pytest.raises(FileFaults, match=r"wheel rl is in no group of \[linearizer\]"):
        robots.parse(text, str(file))
    assert file.read_text() == robots.load("mecanum4").text


def test_a_file_is_written_whole_with_its_permissions_and_its_link(tmp_path):
    file, link = tmp_path / "robot.toml", tmp_path / "link.toml"
    file.write_text("old")
    file.chmod(0o640)
    link.symlink_to(file)
    save(link, "new\r\nλ")
    assert file.read_bytes() == "new\r\nλ".encode()
    assert link.is_symlink()
    assert file.stat().st_mode & 0o777 == 0o640
    save(tmp_path / "other.toml", "x")
    assert sorted(each.name for each in tmp_path.iterdir()) == ["link.toml", "other.toml", "robot.toml"]


def test_a_write_that_fails_half_way_leaves_the_old_text_and_no_rest(tmp_path, monkeypatch):
    file = tmp_path / "robot.toml"
    file.write_text("old")

    def full(descriptor):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(os, "fsync", full)
    with pytest.raises(
        InputError, match=r"robot\.toml cannot be written: no space left on device; nothing was changed"
    ):
        save(file, "new")
    assert file.read_text() == "old"
    assert [each.name for each in tmp_path.iterdir()] == ["robot.toml"]


def test_a_place_that_is_none_is_refused(tmp_path):
    for place in (tmp_path / "none" / "robot.toml", tmp_path, "\0.toml"):
        with pytest.raises(InputError, match="cannot be written"):
            save(place, "x")
    assert list(tmp_path.iterdir()) == []
    with pytest.raises(InputError, match="cannot be written"):
        save(tmp_path / "robot.toml", "\ud800")
    assert list(tmp_path.iterdir()) == []
