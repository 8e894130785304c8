"""Robot files: what is written is what is meant, and comes back from `dump` to the last bit."""

import json
import math
import tomllib
from dataclasses import replace

import jsonschema
import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from robot_strategies import robots as any_robot

from holodrive import robots
from holodrive.errors import FileFaults, InputError, UnknownName
from holodrive.files.json_schema import is_current
from holodrive.files.source import open_text
from holodrive.robots import files, json_schema

SCHEMA = jsonschema.Draft7Validator(robots.schema())


def plain(robot):
    return replace(robot, text="")


@settings(max_examples=60, suppress_health_check=[HealthCheck.too_slow])
@given(any_robot())
def test_any_robot_comes_back_from_its_dump_to_the_last_bit(robot):
    text = robots.dump(robot)
    assert plain(robots.parse(text)) == plain(robot)
    assert robots.dump(robots.parse(text)) == text
    SCHEMA.validate(tomllib.loads(text))


@pytest.mark.parametrize("name", robots.names())
def test_a_catalog_robot_comes_back_from_its_dump(name):
    robot = robots.load(name)
    assert robot.name == name
    assert robot.source
    assert plain(robots.parse(robots.dump(robot))) == plain(robot)
    assert plain(robots.parse(robot.text)) == plain(robot)


def jacobian(robot):
    """Rows of the one wheel equation (architecture decision 1), written out here once more."""
    rows = []
    for w in robot.wheels:
        a = np.array([math.cos(w.yaw + w.roller), math.sin(w.yaw + w.roller)])
        rows.append(np.array([a[0], a[1], w.x * a[1] - w.y * a[0]]) / (w.radius * math.cos(w.roller)))
    return np.array(rows)


def test_hybrid3_has_the_jacobian_of_its_paper():
    """Tuama and Hadi, eq. 19 with r = 51 mm and l = 23 cm."""
    expected = [[0, 1, 0.23], [1.366025404, 0.366025404, 0.23], [-1.366025404, 0.366025404, 0.23]]
    found = jacobian(robots.load("hybrid3"))
    np.testing.assert_allclose(found, np.array(expected) / 0.051, atol=1e-7)
    np.testing.assert_allclose(found[1], [26.7848, 7.1770, 4.5098], atol=1e-4)


def test_mecanum4_has_the_usual_rows():
    """[1, -1, -(lx + ly)] / r and its mirror images, in the order fl fr rl rr."""
    s = 0.35
    expected = np.array([[1, -1, -s], [1, 1, s], [1, 1, -s], [1, -1, s]]) / 0.03
    np.testing.assert_allclose(jacobian(robots.load("mecanum4")), expected, rtol=1e-12)
    assert [w.name for w in robots.load("mecanum4").wheels] == ["fl", "fr", "rl", "rr"]


def test_the_mecanum_robot_of_the_paper_measures_with_its_mice_only():
    """As mecanum4, but no encoders, and pairs of at most 37 mm/s of the base: sqrt 2 times that at the rim."""
    robot, sibling = robots.load("mecanum4_mice"), robots.load("mecanum4")
    assert {w.encoder for w in robot.wheels} == {None}
    assert len(robot.mice) == 2
    assert all(w.max_speed_rad_s * w.radius == pytest.approx(0.037 * math.sqrt(2.0), rel=1e-5) for w in robot.wheels)
    assert (robot.linearizer, robot.pwm_map, robot.mice) == (sibling.linearizer, sibling.pwm_map, sibling.mice)


def test_the_diagonals_of_mecanum4_have_the_curves_of_their_pair(shared_data):
    """Keek et al., eq. 9 to 12: W1W4 is fr and rl, W2W3 is fl and rr; full duty where the vectors say."""
    vectors = json.loads((shared_data / "paper_vectors.json").read_text())["seed002"]["eq9_12"]
    robot = robots.load("mecanum4")
    assert robot.linearizer.wheels == robot.pwm_map.wheels
    by_name = dict(zip([w.name for w in robot.wheels], robot.linearizer.wheels, strict=True))
    for pair, members in (("W1W4", ("fr", "rl")), ("W2W3", ("fl", "rr"))):
        for member in members:
            for way, curve in (("F", by_name[member].forward), ("B", by_name[member].backward)):
                pair_mm_s = curve.knots[-1] * 30.0 / math.sqrt(2.0)
                assert pair_mm_s == pytest.approx(vectors[f"{pair}_{way}"]["v_at_255"], rel=1e-12)
                assert curve.pieces[0][0] * 255 == pytest.approx(vectors[f"{pair}_{way}"]["coeff"][3], rel=1e-14)


def test_swerve3_stands_on_an_equilateral_triangle():
    """Rosyidin et al., eq. 19 corrected, with L = 0.3 m; 700 rpm can be commanded."""
    robot = robots.load("swerve3")
    half, far = 0.15, 0.15 * math.sqrt(3.0)
    np.testing.assert_allclose([(w.x, w.y) for w in robot.wheels], [(0.3, 0), (-half, -far), (-half, far)], atol=1e-15)
    assert all(w.max_speed_rad_s == pytest.approx(700 * math.pi / 30) for w in robot.wheels)
    assert all(w.motor.no_load_speed_rad_s > w.max_speed_rad_s for w in robot.wheels)


def test_the_recorded_omni_robot_counts_clockwise_drive_as_positive():
    """Rim speeds of the data's README: [-sqrt3/2, -1/2, -L], [sqrt3/2, -1/2, -L], [0, 1, -L]."""
    h, length = math.sqrt(3.0) / 2.0, 0.195
    expected = [[-h, -0.5, -length], [h, -0.5, -length], [0, 1, -length]]
    robot = robots.load("optiodom_omni3")
    np.testing.assert_allclose(jacobian(robot) * 0.051, expected, atol=1e-15)
    assert not any(w.inverted for w in robot.wheels)
    assert {w.encoder.counts_per_turn for w in robot.wheels} == {12288.0}


def test_the_recorded_mecanum_robot_has_the_nominal_numbers():
    """data/README: r 0.07 m, l + w = 0.369 m, 210 counts a wheel turn."""
    s = 0.369
    expected = np.array([[1, -1, -s], [1, 1, s], [1, 1, -s], [1, -1, s]]) / 0.07
    robot = robots.load("polimi_mecanum4")
    np.testing.assert_allclose(jacobian(robot), expected, rtol=1e-12)
    assert {w.encoder.counts_per_turn for w in robot.wheels} == {210.0}


def test_the_motor_of_hybrid3_is_behind_its_gear():
    """22 rpm at 12 V, K_G between 5.1 and 5.21 V s/rad."""
    motor = robots.motors.load("jgb37-545b-22rpm")
    assert motor.no_load_speed_rad_s == pytest.approx(22 * math.pi / 30)
    assert 5.1 < motor.back_emf_v_s_rad < 5.21
    assert motor.resistance_ohm / motor.efficiency == pytest.approx(3.5, rel=0.01)


def test_values_before_the_gear_are_brought_behind_it():
    """A 9:1 gear: speed over 9, constant times 9, inertia and viscous friction times 81."""
    motor = robots.motors.load("bldc-16pole-9to1")
    assert motor.no_load_speed_rad_s == pytest.approx(6681 / 9 * math.pi / 30)
    assert motor.back_emf_v_s_rad == pytest.approx(0.0335 * 9)
    assert motor.inertia_kg_m2 == pytest.approx(1.35e-5 * 81)
    assert motor.viscous_friction_n_m_s_rad == pytest.approx(8.9e-6 * 81)


def test_both_readings_of_the_dc_motor_differ_in_inductance_only():
    henry, milli = robots.motors.load("dc-hekimoglu-2.7h"), robots.motors.load("dc-hekimoglu-2.7mh")
    assert (henry.inductance_h, milli.inductance_h) == (2.7, 0.0027)
    same = {"inductance_h": 0.0, "name": "", "source": "", "lag_s": 0.0}
    assert replace(henry, **same) == replace(milli, **same)


@pytest.mark.parametrize("name", robots.sensors.names())
def test_every_sensor_of_the_library_loads(name):
    sensor = robots.sensors.load(name)
    assert type(sensor).__name__.lower() == robots.sensors.kind(name)
    assert sensor.source


@pytest.mark.parametrize("library", [robots.motors, robots.sensors])
def test_an_unknown_part_is_named_with_the_known_ones(library):
    with pytest.raises(UnknownName, match="known: "):
        library.load("nonesuch")


def test_an_unknown_robot_is_named_with_a_guess():
    with pytest.raises(UnknownName, match=r"no robot called 'mecanm4'\. Did you mean 'mecanum4'\?"):
        robots.load("mecanm4")


def test_a_file_of_that_name_is_pointed_out(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "mine.toml").write_text(robots.template("mine"))
    with pytest.raises(InputError, match=r"there is a file mine\.toml here"):
        robots.load("mine")
    assert robots.load("mine.toml").name == "mine"


def test_an_override_is_what_the_file_would_have_said():
    robot = robots.load("hybrid3", {"wheel.front.radius": "50 mm", "robot.mass": "4 kg", "sensor.lidar.rate": 10})
    assert robot.wheels[0].radius == 0.05
    assert robot.wheels[1].radius == 0.051
    assert (robot.mass_kg, robot.lidar.rate_hz) == (4.0, 10.0)
    assert plain(robots.parse(robot.text)) == plain(robot)


def test_an_override_of_text_is_read_as_toml_where_it_is_toml():
    robot = robots.load("hybrid3", {"wheel.front.inverted": "true", "robot.mass": "4", "robot.title": "4 wheels"})
    assert (robot.wheels[0].inverted, robot.mass_kg, robot.title) == (True, 4.0, "4 wheels")


def test_a_shared_default_can_be_overridden():
    robot = robots.load("omni3", {"defaults.wheel.radius": "6 cm"})
    assert {w.radius for w in robot.wheels} == {0.06}


def test_an_override_below_a_name_of_the_library_changes_that_entry():
    plain = robots.load("swerve3_motors")
    all_of_them = robots.load("swerve3_motors", {"defaults.wheel.motor.drive": "foc"})
    assert [w.motor for w in all_of_them.wheels] == [replace(w.motor, drive="foc") for w in plain.wheels]
    one = robots.load("swerve3_motors", {"wheel.left.motor.drive": "foc", "wheel.left.steering.motor.drive": "foc"})
    front, *_, left = one.wheels
    assert front == plain.wheels[0]
    assert left.motor == replace(front.motor, drive="foc") == left.steering.motor
    with pytest.raises(FileFaults) as error:
        robots.load("swerve3_motors", {"defaults.wheel.motor.poles": 7})
    assert "the poles of a rotor come in pairs, found 7; did you mean 14?" in error.value.faults[0].one_line()


@pytest.mark.parametrize(
    ("key", "value", "expected"),
    [
        ("wheel.front.radius", "51 kg", "--set wheel.front.radius: '51 kg' is not a length; write a number in m or "
         'text such as "23 cm"'),
        ("wheel.frnt.radius", 0.05, "--set wheel.frnt.radius: there is no wheel 'frnt' (did you mean 'front'?)"),
        ("wheel.front.radus", 0.05, "--set wheel.front.radus: unknown key 'radus' in [wheel.front] "
         "(did you mean 'radius'?)"),
        ("robot.mass.value", 5, "--set robot.mass.value: robot.mass is '3.26 kg' and holds no keys"),
        ("", 5, "--set : '' is not a key; write it as wheel.front.radius"),
        ("wheel..radius", 5, "--set wheel..radius: 'wheel..radius' is not a key; write it as wheel.front.radius"),
        ("robot.mass", math.nan, "--set robot.mass: nan is not a finite number; write a number in kg or text such as "
         '"3.26 kg"'),
        ("robot.mass", None, "--set robot.mass: None is not a mass; write a number in kg or text such as \"3.26 kg\""),
        ("schema", 2, "--set schema: the schema of a file cannot be set"),
    ],
)  # fmt: skip
def test_a_wrong_override_is_a_fault_at_its_place(key, value, expected):
    with pytest.raises(FileFaults) as error:
        robots.load("hybrid3", {key: value})
    assert [fault.one_line() for fault in error.value.faults] == [expected]


def test_the_template_loads_and_is_valid():
    text = robots.template("my-base")
    assert robots.parse(text).name == "my-base"
    SCHEMA.validate(tomllib.loads(text))
    quoted = robots.template('odd "name"')
    assert robots.parse(quoted).name == 'odd "name"'


@pytest.mark.parametrize("name", sorted(json_schema.SHIPPED))
def test_a_shipped_schema_is_up_to_date(name):
    """If not: python -m holodrive.robots.json_schema."""
    assert is_current(json_schema.SHIPPED[name](), json_schema.FOLDER / name)


FOLDERS = {"catalog": json_schema.robot, "motors": json_schema.motor, "sensors": json_schema.sensor}
SHIPPED = [file for folder in FOLDERS for file in sorted((json_schema.FOLDER / folder).glob("*.toml"))]


@pytest.mark.parametrize("file", SHIPPED, ids=lambda file: file.stem)
def test_a_shipped_file_is_valid_against_its_schema_and_names_it(file):
    text = file.read_text(encoding="utf-8")
    schema = FOLDERS[file.parent.name]()
    jsonschema.Draft7Validator.check_schema(schema)
    jsonschema.Draft7Validator(schema).validate(tomllib.loads(text))
    first = text.split("\n", 1)[0]
    assert first.startswith("#:schema ")
    assert (file.parent / first.removeprefix("#:schema ")).resolve().is_file()


@pytest.mark.parametrize("file", SHIPPED, ids=lambda file: file.stem)
def test_every_physical_number_has_a_source(file):
    """A comment on the line of each quantity says where it comes from."""
    words = ("Tuama", "Keek", "Rosyidin", "Hekimoglu", "published", "data s", "recordings", "vendor", "assumed")
    words += ("derived", "vectors", "from its name", "tangent", "positive", "as swerve3", "usual", "La as quoted")
    for number, line in enumerate(file.read_text(encoding="utf-8").split("\n"), 1):
        code, _, comment = line.partition("#")
        key, equals, value = code.partition("=")
        if equals and any(digit in value for digit in "0123456789") and key.strip() not in ("schema", "title", "name",
                                                                                           "source"):  # fmt: skip
            named = key.strip() in ("motor", "encoder", "model")
            assert named or any(word in comment for word in words), f"{file.name}:{number}: {line}"


def test_an_older_file_passes_through_the_migrations():
    """A migration takes the table of schema n and gives that of n + 1; the newest is what the rest reads."""

    def rename(table):
        return {**table, "robot": {**table["robot"], "mass": table["robot"]["weight"]}}

    source = open_text(
        'schema = 1\n[robot]\nweight = "5 kg"\n', "old.toml", newest=3, migrations={1: rename, 2: lambda table: table}
    )
    assert source.table["robot"]["mass"] == "5 kg"
    assert source.table["schema"] == 3
    assert files.SCHEMA == 1


def test_derived_values_are_those_of_the_reference():
    """No inertia: 1/2 m R^2 to the farthest wheel; no footprint: its farthest corner; no battery: the motors'."""
    text = "\n".join(
        line
        for line in robots.load("omni4").text.split("\n")
        if not line.startswith(("footprint_radius", "[battery]", "voltage", "resistance"))
    )
    robot = robots.parse(text)
    assert robot.inertia_kg_m2 == pytest.approx(0.5 * 4.0 * 0.2**2)
    assert robot.footprint_radius_m == pytest.approx(math.hypot(0.2 + 0.0175, 0.05))
    assert robot.battery.voltage_v == 12.0
