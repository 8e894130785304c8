"""The reference of robot and world files names every key that the forms know, and its examples load."""

import re
from pathlib import Path

import pytest

from holodrive import robots, worlds
from holodrive.files.edge import Form, known_keys
from holodrive.robots import form as robot_form
from holodrive.worlds import form as world_form
from holodrive.worlds.distances import reachable

DOCS = Path(__file__).parents[2] / "docs"
PAGES = {"robot-files.md": (robots, robot_form), "world-files.md": (worlds, world_form)}


def forms(module):
    found = [value for value in vars(module).values() if isinstance(value, type) and issubclass(value, Form)]
    return [form for form in found if form is not Form]


def documented(text):
    """Words in backticks."""
    return {word for span in re.findall(r"`([^`\n]+)`", text) for word in re.findall(r"\w+", span)}


@pytest.mark.parametrize("page", PAGES)
def test_every_key_is_in_the_reference(page):
    words = documented((DOCS / page).read_text(encoding="utf-8"))
    for form in forms(PAGES[page][1]):
        assert set(known_keys(form, ())) <= words, form.__name__


@pytest.mark.parametrize("page", PAGES)
def test_every_key_of_the_reference_is_known(page):
    """The first cell of each row of a table, or the second where the first names the table."""
    known = {key for form in forms(PAGES[page][1]) for key in known_keys(form, ())} | {"schema"}
    for line in (DOCS / page).read_text(encoding="utf-8").split("\n"):
        cells = [cell.strip() for cell in line.strip().strip("|").split("|")]
        if line.startswith("|"):
            cell = next((cell for cell in cells[:2] if re.fullmatch(r"(`\w+`(, )?)+", cell)), "")
            assert set(re.findall(r"\w+", cell)) <= known, line


@pytest.mark.parametrize("page", PAGES)
def test_every_whole_example_loads(page):
    module, _ = PAGES[page]
    blocks = re.findall(r"```toml\n(.*?)```", (DOCS / page).read_text(encoding="utf-8"), re.DOTALL)
    whole = [block for block in blocks if "schema = 1" in block]
    assert whole
    for block in whole:
        module.parse(block)


def test_the_motor_of_the_reference_is_a_motor():
    text = (DOCS / "robot-files.md").read_text(encoding="utf-8")
    (part,) = re.findall(r"```toml\n(\[wheel\.front\.motor\].*?)```", text, re.DOTALL)
    assert robots.parse(f"{robots.load('omni3').text}\n{part}").wheels[0].motor.current_limit_a == 3.0


def test_the_program_of_the_reference_changes_a_file(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    text = (DOCS / "robot-files.md").read_text(encoding="utf-8")
    (program,) = re.findall(r"```python\n(.*?)```", text, re.DOTALL)
    exec(program, {"__name__": "reference"})
    robot = robots.load(tmp_path / "mine.toml")
    assert robot.mass_kg == 4.2
    assert tuple(robot.mice[1].mount) == (0.1012, -0.0021, 0.031)


def test_the_curves_of_the_reference_are_curves():
    """The group of the example, and the other diagonal as it is shipped."""
    text = (DOCS / "robot-files.md").read_text(encoding="utf-8")
    (part,) = re.findall(r"```toml\n(\[linearizer\].*?)```", text, re.DOTALL)
    shipped = robots.load("mecanum4").text
    start, end = shipped.index("[linearizer]"), shipped.index("[linearizer.w2w3]")
    wheels = robots.parse(shipped[:start] + part + shipped[end:]).linearizer.wheels
    assert len(wheels[1].backward.pieces) == 4
    assert wheels[1].forward == robots.load("mecanum4").linearizer.wheels[1].forward


def test_the_example_world_has_a_way_from_start_to_goal():
    text = (DOCS / "world-files.md").read_text(encoding="utf-8")
    world = worlds.parse(re.findall(r"```toml\n(.*?)```", text, re.DOTALL)[0])
    assert reachable(world, world.start[:2], world.goal.pose[:2], 0.28)
