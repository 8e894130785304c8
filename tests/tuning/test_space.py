"""Fields that may change, and how far."""

from importlib import import_module

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from holodrive import control
from holodrive.errors import InputError, UnknownName
from holodrive.tuning import Range, Space, parse_range, space


@given(unit=st.floats(0.0, 1.0), low=st.floats(1e-3, 10.0), ratio=st.floats(1.01, 1e4), log=st.booleans())
def test_unit_and_value_are_inverse(unit: float, low: float, ratio: float, log: bool) -> None:
    """And the value never leaves the bounds."""
    one = Range("k", low, low * ratio, log)
    assert one.low <= one.value(unit) <= one.high
    assert one.unit(one.value(unit)) == pytest.approx(unit, abs=1e-9)


def test_a_value_outside_goes_to_the_nearer_end() -> None:
    assert Range("k", 1.0, 2.0).unit(-5.0) == 0.0
    assert Range("k", 1.0, 2.0).unit(5.0) == 1.0


def test_log_steps_are_ratios() -> None:
    assert Range("k", 0.1, 10.0, log=True).value(0.5) == pytest.approx(1.0)


@pytest.mark.parametrize("name", [name for name in control.CONTROLLERS if hasattr(control.plug_class(name), "kernel")])
def test_bounds_of_our_controllers_hold_their_defaults(name: str) -> None:
    """Where a controller says how far its fields may go, its own values lie inside and its corners are allowed."""
    if not hasattr(import_module(control.plug_class(name).__module__), "BOUNDS"):
        with pytest.raises(InputError, match="--field"):
            space(name)
        return
    found = space(name)
    start = found.start(name, {})
    for one in found.ranges:
        assert one.low <= start[one.field] <= one.high, one.field
        assert found.values(found.unit(start))[one.field] == pytest.approx(start[one.field])


def test_own_ranges_take_the_place_of_bounds() -> None:
    """Named fields keep their bounds; a range for one of them wins."""
    found = space("pid", ranges=[parse_range("kp=0.5:2")])
    assert found.ranges == (Range("kp", 0.5, 2.0),)
    assert found.values(np.array([0.5])) == {"kp": 1.25}


def test_what_cannot_be_tuned_is_told() -> None:
    """One clear line each."""
    with pytest.raises(UnknownName, match="Did you mean 'kp'"):
        space("pid", ranges=[parse_range("kpp=1:2")])
    with pytest.raises(UnknownName, match="controller"):
        space("pidd")
    with pytest.raises(InputError, match="low < high"):
        parse_range("kp=5:1")
    with pytest.raises(InputError, match="low > 0"):
        parse_range("kp=0:1:log")
    with pytest.raises(InputError, match="tuned once"):
        Space((Range("kp", 1, 2), Range("kp", 1, 3)))
    with pytest.raises(InputError, match="no bounds for 'arrive_m'"):
        space("pid", ["arrive_m"])
    with pytest.raises(InputError, match="only numbers"):
        space("go_to_pose", ranges=[parse_range("law=0:1")]).start("go_to_pose", {})


@pytest.mark.parametrize("text", ["kp", "kp=", "kp=1", "kp=a:b", "kp=1:2:lin", "=1:2", "kp=1:2:log:3", "kp=nan:2"])
def test_ranges_that_cannot_be_read(text: str) -> None:
    with pytest.raises(InputError, match="NAME=LOW:HIGH"):
        parse_range(text)
