"""The gate: what may reach the motors."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from holodrive.runtime.gate import GateLimits, GateState, gate, rearm
from holodrive.types import DutyCommand, Twist, WheelCommand

LIMITS = GateLimits(("front", "right", "left"), (2.0, 2.0, 3.0), steered=1)
CALIBRATION = GateLimits(("front", "right", "left"), (2.0, 2.0, 3.0), steered=1, calibration=True)
ANY = st.one_of(
    st.floats(allow_nan=True, allow_infinity=True), st.integers(), st.none(), st.text(max_size=3), st.booleans()
)


def good(*speeds):
    return WheelCommand(speeds, (0.25,))


def test_a_command_inside_the_limits_passes_unchanged():
    command = good(2.0, -2.0, 3.0)
    verdict = gate(command, GateState(), LIMITS)
    assert verdict.command is command
    assert verdict.reason == ""


def test_rounding_at_the_limit_passes_and_more_does_not():
    assert not gate(good(2.0 * (1 + 5e-10), 0, 0), GateState(), LIMITS).reason
    assert "limit is 2" in gate(good(2.0 * (1 + 1e-8), 0, 0), GateState(), LIMITS).reason


@pytest.mark.parametrize("bad", [math.nan, math.inf, -math.inf, 1e308])
@pytest.mark.parametrize("wheel", [0, 1, 2])
def test_one_bad_number_stops_all_wheels(bad, wheel):
    speeds = [1.0, 1.0, 1.0]
    speeds[wheel] = bad
    verdict = gate(WheelCommand(speeds, (0.25,)), GateState(), LIMITS)
    assert verdict.command.speeds == (0.0, 0.0, 0.0)
    assert LIMITS.wheels[wheel] in verdict.reason


def test_a_bad_steering_angle_stops_and_keeps_the_last_good_angle():
    state = gate(good(1.0, 1.0, 1.0), GateState(), LIMITS).state
    verdict = gate(WheelCommand((1.0, 1.0, 1.0), (math.nan,)), state, LIMITS)
    assert verdict.command == WheelCommand((0.0, 0.0, 0.0), (0.25,))


def test_a_fault_latches_until_somebody_rearms():
    state = gate(good(math.nan, 0, 0), GateState(), LIMITS).state
    later = gate(good(1.0, 1.0, 1.0), state, LIMITS)
    assert later.command.speeds == (0.0, 0.0, 0.0)
    assert not gate(good(1.0, 1.0, 1.0), rearm(later.state), LIMITS).reason


def test_duty_passes_in_calibration_only_and_never_above_one():
    duty = DutyCommand((0.5, 0.5, -1.0), (0.0,))
    assert "calibration" in gate(duty, GateState(), LIMITS).reason
    assert gate(duty, GateState(), CALIBRATION).command is duty
    assert gate(DutyCommand((1.01, 0, 0), (0.0,)), GateState(), CALIBRATION).reason


def test_a_twist_is_no_command_for_motors():
    assert "Twist" in gate(Twist(0.0, 0.0, 0.0), GateState(), LIMITS).reason


@given(st.lists(ANY, max_size=5), st.lists(ANY, max_size=2))
def test_nothing_that_is_not_a_finite_command_within_limits_ever_passes(speeds, steer):
    """Whatever comes in, what goes out is finite, within the limits and for all wheels."""
    out = gate(WheelCommand(speeds, steer), GateState(), LIMITS).command
    values = np.array(out.speeds, dtype=float)
    assert values.shape == (3,)
    assert np.all(np.abs(values) <= np.array(LIMITS.speeds_rad_s) * (1 + 1e-9))
    assert np.all(np.isfinite(np.array(out.steer, dtype=float)))
