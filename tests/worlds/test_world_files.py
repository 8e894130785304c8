"""World files: what is written is what is meant, and comes back from `dump` to the last bit."""

import math
import tomllib
from dataclasses import replace
from xml.etree import ElementTree

import jsonschema
import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from holodrive import worlds
from holodrive.errors import FileFaults, UnknownName
from holodrive.files.json_schema import is_current
from holodrive.types import Pose
from holodrive.worlds import json_schema
from holodrive.worlds.distances import covering, position, reachable
from holodrive.worlds.spec import Box, Circle, Goal, KeyFrame, Mover, Segment, World

SCHEMA = jsonschema.Draft7Validator(worlds.schema())
TEXT = st.text(st.characters(codec="utf-8", exclude_categories=["Cs"]), max_size=20)
AT = st.floats(-50.0, 50.0)
ANGLE = st.floats(-2.0 * math.pi, 2.0 * math.pi)
SIZE = st.floats(0.01, 3.0)
FRAMES = st.lists(st.floats(0.0, 100.0), min_size=1, max_size=4, unique=True).map(sorted)


def plain(world):
    return replace(world, text="")


@st.composite
def any_world(draw):
    world = World(
        name=draw(TEXT),
        title=draw(TEXT),
        source=draw(TEXT),
        size=draw(st.none() | st.just((200.0, 150.5))),
        corner=draw(st.sampled_from([(0.0, 0.0), (-99.0, -75.1)])),
        walls=draw(st.booleans()),
        start=Pose(draw(AT), draw(AT), draw(ANGLE)),
        circles=tuple(Circle(draw(AT), draw(AT), draw(SIZE)) for _ in range(draw(st.integers(0, 3)))),
        segments=tuple(Segment(draw(AT), draw(AT), draw(AT), draw(AT)) for _ in range(draw(st.integers(0, 3)))),
        boxes=tuple(
            Box(draw(AT), draw(AT), draw(SIZE), draw(SIZE), draw(ANGLE), name)
            for name in draw(st.lists(TEXT, max_size=3, unique=True))
        ),
        movers=tuple(
            Mover(draw(SIZE), tuple(KeyFrame(t, draw(AT), draw(AT)) for t in draw(FRAMES)), draw(st.booleans()))
            for _ in range(draw(st.integers(0, 2)))
        ),
    )
    pose = Pose(draw(AT), draw(AT), draw(ANGLE))
    goal = Goal(pose, draw(st.floats(0.01, 1.0)), draw(st.floats(0.01, 3.0)), draw(st.booleans()))
    world = replace(world, goal=draw(st.none() | st.just(goal)))
    inside = [depth for _, depth in covering(world)]
    assume(all(depth < goal.tolerance_m for depth in inside))
    assume(float(worlds.clearance(world, *world.start[:2])) > 0.0)
    assume(all((s.x1, s.y1) != (s.x2, s.y2) for s in world.segments))
    if world.size is not None:
        for place in (world.start, pose):
            assume(all(0.0 <= place[i] - world.corner[i] <= world.size[i] for i in (0, 1)))
    return world


@given(any_world())
def test_any_world_comes_back_from_its_dump_to_the_last_bit(world):
    text = worlds.dump(world)
    assert plain(worlds.parse(text)) == plain(world)
    assert worlds.dump(worlds.parse(text)) == text
    SCHEMA.validate(tomllib.loads(text))


@pytest.mark.parametrize("name", worlds.names())
def test_a_catalog_world_comes_back_from_its_dump(name):
    world = worlds.load(name)
    assert (world.name, bool(world.title), bool(world.source)) == (name, True, True)
    assert plain(worlds.parse(worlds.dump(world))) == plain(world)
    assert plain(worlds.parse(world.text)) == plain(world)
    SCHEMA.validate(tomllib.loads(world.text))
    first = world.text.split("\n", 1)[0]
    assert first == "#:schema ../world.schema.json"


@pytest.mark.parametrize("name", [n for n in worlds.names() if n not in ("open", "paper_course_printed")])
def test_a_catalog_world_has_a_way_for_hybrid3(name):
    """A footprint radius of 28 cm gets from start to goal."""
    world = worlds.load(name)
    assert reachable(world, world.start[:2], world.goal.pose[:2], 0.28)


def test_the_printed_course_can_be_reached_within_its_tolerance():
    """Obstacle 4 stands on the goal; a robot of 28 cm comes as near as 43 cm."""
    world = worlds.load("paper_course_printed")
    assert world.size == (3.0, 4.5)
    assert [depth for _, depth in covering(world)] == [0.15]
    near = (0.5, 4.5 - world.goal.tolerance_m)
    assert float(worlds.clearance(world, *near)) > 0.28
    assert reachable(world, world.start[:2], near, 0.28)


def test_the_printed_course_needs_its_acceptance():
    text = worlds.load("paper_course_printed").text
    lines = [line for line in text.split("\n") if not line.startswith("accept")]
    with pytest.raises(FileFaults, match="is inside circle obstacle_4"):
        worlds.parse("\n".join(lines))


def test_the_bench_is_the_benchmark_s_workload():
    """12 circles and 8 segments."""
    world = worlds.load("bench")
    assert (len(world.circles), len(world.segments) + len(world.border())) == (12, 8)


def test_the_repaired_course_leaves_out_the_obstacle_on_the_goal():
    world = worlds.load("paper_course")
    assert world.size == (3.0, 5.0)
    assert (world.start[:2], world.goal.pose[:2]) == ((0.5, 0.5), (0.5, 4.5))
    assert [(c.x, c.y, c.radius) for c in world.circles] == [(0.5, 1.5, 0.15), (1.5, 1.5, 0.15), (1.5, 2.5, 0.15)]


def test_every_physical_number_of_a_world_has_a_source():
    for file in sorted((json_schema.FOLDER / "catalog").glob("*.toml")):
        inside_path = False
        for number, line in enumerate(file.read_text(encoding="utf-8").split("\n"), 1):
            code, _, comment = line.partition("#")
            key, equals, value = (part.strip() for part in code.partition("="))
            if key not in ("schema", "name", "title", "source") and equals and any(c.isdigit() for c in value):
                sourced = any(word in comment for word in ("Tuama", "chosen", "assumed", "derived", "repaired"))
                assert sourced or inside_path, f"{file.name}:{number}: {line}"
            inside_path = (inside_path or (key == "path" and "chosen" in comment)) and code.strip() != "]"


def test_the_schema_is_up_to_date():
    """If not: python -m holodrive.worlds.json_schema."""
    assert is_current(json_schema.world(), json_schema.FOLDER / "world.schema.json")


def test_the_template_loads_and_is_valid():
    text = worlds.template("lab")
    world = worlds.parse(text)
    assert world.name == "lab"
    assert reachable(world, world.start[:2], world.goal.pose[:2], 0.25)
    SCHEMA.validate(tomllib.loads(text))


def test_an_override_reaches_obstacles_by_name_and_by_number():
    world = worlds.load("paper_course", {"circle.obstacle_2.radius": "20 cm", "circle.3.x": 2, "goal.tolerance": 0.1})
    assert (world.circles[1].radius, world.circles[2].x, world.goal.tolerance_m) == (0.2, 2.0, 0.1)


@pytest.mark.parametrize(
    ("key", "value", "expected"),
    [
        ("circle.obstcle_1.x", 1, "--set circle.obstcle_1.x: there is no circle 'obstcle_1' "
         "(did you mean 'obstacle_1'?)"),
        ("circle.7.x", 1, "--set circle.7.x: there is no circle '7' (known: obstacle_1, obstacle_2, obstacle_3)"),
        ("goal.x", "5 s", "--set goal.x: '5 s' is not a length; write a number in m or text such as \"23 cm\""),
        ("goal.x", "9 m", "--set goal.x: goal (9, 4.5) is outside the arena, x 0 to 3 m, y 0 to 5 m"),
    ],
)  # fmt: skip
def test_a_wrong_override_is_a_fault_at_its_place(key, value, expected):
    with pytest.raises(FileFaults) as error:
        worlds.load("paper_course", {key: value})
    (line,) = [fault.one_line() for fault in error.value.faults]
    assert line.endswith(expected)


def test_an_unknown_world_is_named_with_a_guess():
    with pytest.raises(UnknownName, match=r"Did you mean 'room'\?"):
        worlds.load("rom")


@given(st.integers(0, 2**64 - 1))
def test_a_generated_world_is_a_pure_function_of_its_seed(seed):
    world = worlds.generate(seed)
    assert worlds.generate(seed) == world
    assert worlds.parse(world.text) == world


def test_a_generated_world_keeps_its_gaps_and_its_way():
    """Between all surfaces at least the gap, so that a robot just under half of it always gets through."""
    for seed in range(10):
        world = worlds.generate(seed, gap=0.7)
        for i, a in enumerate(world.circles):
            assert min(a.x, a.y, 6 - a.x, 6 - a.y) - a.radius >= 0.7 - 1e-12
            assert all(math.hypot(a.x - b.x, a.y - b.y) - a.radius - b.radius >= 0.7 for b in world.circles[:i])
        assert reachable(world, world.start[:2], world.goal.pose[:2], 0.33)


def test_the_generator_s_streams_do_not_change():
    """Seeds are quoted in results: the same seed gives this world for ever."""
    world = worlds.generate(1)
    found = [world.circles[0].x, world.circles[0].radius, world.start.x, world.goal.pose.y]
    assert found == pytest.approx(STREAM, rel=1e-12)


STREAM = [1.1903974365410754, 0.2800536906224837, 1.9589105818258208, 0.5148641158581932]


@pytest.mark.parametrize("wrong", [{"size": (1.0, 1.0)}, {"circles": 500}, {"gap": math.nan}, {"radius": (0.3, 0.1)}])
def test_a_world_that_cannot_be_is_refused(wrong):
    from holodrive.errors import InputError

    with pytest.raises(InputError, match=r"found|fit"):
        worlds.generate(0, **wrong)


def test_clearance_is_the_distance_to_the_nearest_surface():
    world = World("x", size=(4.0, 3.0), circles=(Circle(2, 1.5, 0.5),), boxes=(Box(1, 2, 0.4, 0.2, math.pi / 2),))
    assert worlds.clearance(world, 2.0, 1.5) == -0.5
    assert worlds.clearance(world, 0.2, 0.5) == pytest.approx(0.2)
    assert worlds.clearance(world, 1.0, 2.0) == pytest.approx(-0.1)
    assert worlds.clearance(world, 1.2, 2.0) == pytest.approx(0.1)
    assert worlds.clearance(World("open"), 0.0, 0.0) == math.inf
    many = worlds.clearance(world, np.linspace(0, 4, 9)[:, None], np.linspace(0, 3, 7)[None, :])
    assert many.shape == (9, 7)


def test_a_mover_waits_at_its_ends_or_begins_again():
    path = (KeyFrame(1.0, 0.0, 0.0), KeyFrame(3.0, 2.0, 0.0))
    once, again = Mover(0.1, path), Mover(0.1, path, loop=True)
    assert [position(once, t)[0] for t in (0.0, 2.0, 9.0)] == [0.0, 1.0, 2.0]
    assert [position(again, t)[0] for t in (0.0, 2.0, 4.0)] == [0.0, 1.0, 1.0]


@pytest.mark.parametrize("name", worlds.names())
def test_a_catalog_world_draws_itself(name):
    world = worlds.load(name)
    root = ElementTree.fromstring(world._repr_html_())
    circles = [node for node in root.iter() if node.tag.endswith("circle")]
    assert len(circles) == len(world.circles) + len(world.movers) + (world.goal is not None)
