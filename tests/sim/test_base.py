"""The simulated base keeps the contract of a base."""

import math

import numpy as np
import pytest
from machines import FREE_SPEED, hybrid, swerve

from holodrive.errors import InputError, UnknownName
from holodrive.sim import SimBase
from holodrive.types import DutyCommand, Pose, WheelCommand
from holodrive.worlds.spec import World


def test_it_starts_at_rest_where_it_is_told_or_where_the_world_says():
    world = World("w", start=Pose(1.0, 2.0, 0.5))
    assert SimBase(hybrid(), world).truth == (1.0, 2.0, 0.5)
    base = SimBase(hybrid(), world, start=(0.0, 0.0, 9.0))
    assert base.truth == (0.0, 0.0, 9.0)
    seen = base.observe()
    assert (seen.time, seen.dt) == (0.0, 0.01)
    assert np.all(seen.wheels.position == 0.0)


def test_apply_gives_what_was_really_sent_with_the_direction_kept():
    base = SimBase(hybrid(), None)
    sent = base.apply(WheelCommand((0.0, 2.0 * FREE_SPEED, -FREE_SPEED)))
    assert isinstance(sent, WheelCommand)
    assert np.allclose(sent.speeds, (0.0, FREE_SPEED, -0.5 * FREE_SPEED))
    sent = base.apply(DutyCommand((0.5, 3.0, -2.0)))
    assert isinstance(sent, DutyCommand)
    assert sent.duty == (0.5, 1.0, -1.0)
    assert base.time == pytest.approx(0.02)


@pytest.mark.parametrize("bad", [math.nan, math.inf, -math.inf])
@pytest.mark.parametrize("plant", ["first_order", "slip"])
def test_a_number_that_is_not_finite_stops_for_good(bad, plant):
    base = SimBase(swerve(), None, plant=plant)
    for _ in range(50):
        base.apply(WheelCommand((1.0, 1.0, 1.0), (0.1, 0.1, 0.1)))
    assert base.apply(WheelCommand((1.0, bad, 1.0), (0.1, 0.1, 0.1))).speeds == (0.0, 0.0, 0.0)
    assert base.fault
    for _ in range(200):
        base.apply(WheelCommand((1.0, 1.0, 1.0), (0.0, bad, 0.0)))
    assert np.allclose(base.true_wheel_speeds, 0.0, atol=1e-3)
    assert [event.kind for event in base.take_events()] == ["fault"]
    base.reset()
    assert not base.fault


def test_wrong_shapes_names_and_steps_say_what_is_allowed():
    base = SimBase(hybrid(), None)
    with pytest.raises(InputError, match="takes 3 wheel values and 0 steering angles"):
        base.apply(WheelCommand((1.0, 2.0)))
    with pytest.raises(UnknownName, match="first_order"):
        SimBase(hybrid(), None, plant="slipp")
    with pytest.raises(InputError, match="divide the control period"):
        SimBase(hybrid(), None, dt_s=3e-3)
    with pytest.raises(InputError, match="start pose"):
        SimBase(hybrid(), None, start=(0.0, math.nan, 0.0))


def test_close_stops_the_wheels_and_may_be_called_twice():
    base = SimBase(hybrid(), None)
    base.apply(WheelCommand((1.0, 1.0, 1.0)))
    base.close()
    base.close()
    assert base.fault == ""


def test_the_same_seed_gives_the_same_run_and_reset_starts_it_again():
    def run(base):
        for k in range(60):
            base.apply(WheelCommand((math.sin(k), 1.0, -1.0)))
        return base.truth, base.observe().wheels.speed.tolist()

    base = SimBase(hybrid(), None, plant="slip", seed=4)
    first = run(base)
    base.reset()
    assert run(base) == first
    assert run(SimBase(hybrid(), None, plant="slip", seed=4)) == first
