"""Quantities as text mean what a person means, to the last bit; everything else is refused in one line."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from holodrive.files.units import DIMENSIONS, UNITS, QuantityError, parse

TABLE = [
    ("23 cm", "length", 0.23),
    ("51 mm", "length", 0.051),
    ("102mm", "length", 0.102),
    ("-0.5 m", "length", -0.5),
    ("+1.5e-1 m", "length", 0.15),
    (".5 m", "length", 0.5),
    ("10 um", "length", 1e-5),
    ("10 µm", "length", 1e-5),
    ("1 in", "length", 0.0254),
    ("2 ft", "length", 0.6096),
    ("-45 deg", "angle", -math.pi / 4),
    ("−45 deg", "angle", -math.pi / 4),
    ("90°", "angle", math.pi / 2),
    ("1 rev", "angle", 2.0 * math.pi),
    ("100 mrad", "angle", 0.1),
    ("22 rpm", "angular speed", 22.0 * math.pi / 30.0),
    ("3 rev/s", "angular speed", 6.0 * math.pi),
    ("0.05 deg/s", "angular speed", math.radians(0.05)),
    ("90 deg/s^2", "angular acceleration", math.pi / 2),
    ("12 V", "voltage", 12.0),
    ("250 mA", "current", 0.25),
    ("2.1 Ω", "resistance", 2.1),
    ("2.1 ohm", "resistance", 2.1),
    ("2.7 mH", "inductance", 0.0027),
    ("2.7 H", "inductance", 2.7),
    ("3.26 kg", "mass", 3.26),
    ("300 g", "mass", 0.3),
    ("1 lb", "mass", 0.45359237),
    ("25 kgf cm", "torque", 2.4516625),
    ("25 kgf·cm", "torque", 2.4516625),
    ("25 kgf*cm", "torque", 2.4516625),
    ("33.5 mN m/A", "motor constant", 0.0335),
    ("5.2 V s/rad", "motor constant", 5.2),
    ("0.086 kg m^2", "inertia", 0.086),
    ("0.086 kg m²", "inertia", 0.086),
    ("5 g cm^2", "inertia", 5e-7),
    ("2.2e-3 N m s/rad", "viscous friction", 0.0022),
    ("2.2e-3 N m s", "viscous friction", 0.0022),
    ("5.5 Hz", "frequency", 5.5),
    ("10 ms", "time", 0.01),
    ("2 min", "time", 120.0),
    ("2.3 Ah", "charge", 8280.0),
    ("0.5 m/s", "speed", 0.5),
    ("1.8 km/h", "speed", 0.5),
    ("1.5 m/s²", "acceleration", 1.5),
    ("60 %", "number", 0.6),
    (0.23, "length", 0.23),
    (2, "length", 2.0),
]


@pytest.mark.parametrize(("text", "dimension", "expected"), TABLE)
def test_a_quantity_means_its_si_number(text, dimension, expected):
    """Correctly rounded where the unit is decimal, to one part in 1e15 where pi comes in."""
    assert parse(text, dimension) == pytest.approx(expected, rel=2e-16, abs=0.0)


@pytest.mark.parametrize("text", ["51 mm", "102 mm", "23 cm", "0.1 mm", "39.75 mm", "3 mm"])
def test_decimal_units_round_once(text):
    """ "51 mm" is the float that one gets by writing 0.051."""
    number, unit = text.split()
    shift = {"mm": "e-3", "cm": "e-2"}[unit]
    assert parse(text, "length") == float(number + shift)


@pytest.mark.parametrize(
    "text",
    ["51 kg", "5", "", " ", "five cm", "5 cmm", "5,1 cm", "nan m", "inf m", "1e999 m", "2 ft 3 in", "5 cm^2", "5 m/",
     "m", "5 5 m", "0x10 m", "5 m^", "1__0 m", "5 cm\x00", "٣ cmm", "5 m" + " " * 100, "1e-99999999999 m"],
)  # fmt: skip
def test_what_is_no_length_is_refused(text):
    with pytest.raises(QuantityError) as error:
        parse(text, "length")
    assert "\n" not in str(error.value)


@pytest.mark.parametrize("value", [True, False, None, [1], {"x": 1}, math.nan, math.inf, -math.inf, 10**400])
def test_other_values_are_refused(value):
    with pytest.raises(QuantityError):
        parse(value, "length")


def test_hertz_is_no_yaw_rate_and_a_yaw_rate_no_frequency():
    with pytest.raises(QuantityError):
        parse("5 Hz", "angular speed")
    with pytest.raises(QuantityError):
        parse("5 rad/s", "frequency")


def test_the_message_says_what_is_allowed():
    with pytest.raises(QuantityError, match="'51 kg' is not a length; write a number in m or text such as \"23 cm\""):
        parse("51 kg", "length")


@pytest.mark.parametrize("name", sorted(DIMENSIONS))
def test_every_example_is_right(name):
    """What a message tells people to write can be written."""
    assert math.isfinite(parse(DIMENSIONS[name].example, name))


@given(st.floats(-1e6, 1e6), st.sampled_from(sorted(UNITS)))
def test_any_number_with_any_unit_is_read_or_refused_in_one_line(number, unit):
    for dimension in DIMENSIONS:
        try:
            assert math.isfinite(parse(f"{number!r} {unit}", dimension))
        except QuantityError as error:
            said = str(error)
        else:
            said = ""
        assert "\n" not in said


@given(st.one_of(st.text(max_size=100), st.integers(), st.floats(), st.dates()))
def test_no_value_whatsoever_is_a_traceback(value):
    for dimension in ("length", "angle", "number"):
        try:
            assert math.isfinite(parse(value, dimension))
        except QuantityError:
            continue
