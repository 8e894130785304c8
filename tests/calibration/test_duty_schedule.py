"""The schedule of open-loop steps: in the loop and in roll-outs alike, it stays, waits, and stops by itself."""

import math
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest

import holodrive as hd
from holodrive import build, references, robots
from holodrive.calibration.step_log import StepLog
from holodrive.calibration.steps import Calibration, calibrate, curve_values, groups_of, records_of
from holodrive.control.duty_steps import DutySteps
from holodrive.errors import HardwareFault, InputError
from holodrive.runtime import GateLimits, GateState, gate
from holodrive.types import DutyCommand

ROBOT = robots.load("mecanum4_mice")
GROUPS = groups_of(ROBOT)
WHEELS = tuple((group.wheels, group.diagonal, group.resolution_m) for group in GROUPS)
STILL = references.fixed_goal((0.0, 0.0, 0.0))


def rolled(robot=ROBOT, plug=None, seconds=400.0, seed=0):
    """A roll-out of the schedule: the rows of its log, and the names of its columns."""
    roll = hd.rollout(
        robot, None, plug or DutySteps(WHEELS), estimator="mouse_odometry", n=1, reference=STILL, t=seconds, seed=seed,
        plant="pwm_map", log_every=1, stop_on_arrival=True, workers=1,
    )  # fmt: skip
    log = roll.log[0][np.isfinite(roll.log[0][:, 0])]
    return roll, {name: log[:, k] for k, name in enumerate(roll.columns)}


def of_log(columns, robot=ROBOT) -> Calibration:
    """The calibration of a log."""
    pose = np.column_stack([columns[name] for name in ("est_x", "est_y", "est_theta")])
    duty = np.column_stack([columns[f"command:{wheel.name}"] for wheel in robot.wheels])
    return calibrate(robot, records_of(robot, GROUPS, columns["time"], pose, duty))


@pytest.fixture(scope="module")
def run():
    """One whole schedule."""
    return rolled()


@pytest.fixture(scope="module")
def found(run) -> Calibration:
    """And what it tells."""
    return of_log(run[1])


def test_the_schedule_arrives_without_a_fault_and_hardly_leaves_its_place(run) -> None:
    """Within 30 cm, in less than four minutes."""
    roll, columns = run
    assert roll.metrics["arrived"][0] == 1.0
    assert columns["time"][-1] < 240.0
    assert np.hypot(columns["x"], columns["y"]).max() < 0.3


def test_only_one_group_has_duty_and_all_its_wheels_have_the_same(run) -> None:
    """In every tick, the first of a step included."""
    duty = np.column_stack([run[1][f"command:{wheel.name}"] for wheel in ROBOT.wheels])
    for row in np.unique(duty, axis=0):
        driven = tuple(np.flatnonzero(row))
        assert driven == () or driven in {tuple(sorted(group.wheels)) for group in GROUPS}
        assert len(set(row[list(driven)])) <= 1


def test_directions_alternate_and_steps_are_held_for_their_time(found: Calibration) -> None:
    """The last of one direction may follow each other, where the other has all it needs."""
    steps = [step.record for step in found.steps]
    assert all(record.time[-1] - record.time[0] == pytest.approx(1.5) for record in steps)
    turns = np.mean([one.direction != other.direction for one, other in pairwise(steps)])
    assert turns > 0.85


def test_the_robot_stands_when_a_step_begins(run) -> None:
    """The truth, not only what the mice tell: slower than 0.2 mm/s."""
    columns = run[1]
    duty = np.column_stack([columns[f"command:{wheel.name}"] for wheel in ROBOT.wheels])
    moving = np.any(duty != 0.0, axis=1)
    begins = np.flatnonzero(moving[1:] & ~moving[:-1]) + 1
    assert np.hypot(columns["vx"], columns["vy"])[begins - 1].max() < 2e-4


def test_the_dead_zone_is_found_to_one_count(found: Calibration) -> None:
    """By bisection: neighbours, and the printed offset lies between them but for what is too slow to see."""
    offsets = {("W1W4", "forward"): 43.4929, ("W1W4", "backward"): 43.4521,
               ("W2W3", "forward"): 53.9554, ("W2W3", "backward"): 54.96069}  # fmt: skip
    for one in found.fits:
        assert one.first_moving - one.last_still == 1.0
        assert one.dead_zone == pytest.approx(offsets[one.group, one.direction], abs=0.5)
        assert len(one.pwm) >= 20
        assert one.pwm[-1] == 255.0
        assert one.dead_time_s == pytest.approx(0.04, abs=0.015)
        assert one.lag_s == pytest.approx(0.05, abs=0.01)


def test_the_linearizer_is_the_inverse_of_the_plant(found: Calibration) -> None:
    """Within one per cent of the top speed and the spread of single wheels."""
    v = np.linspace(0.05, 1.0, 20) * 0.0369
    for group in found.groups:
        for direction in ("forward", "backward"):
            ours = curve_values(ROBOT, found.linearizer(ROBOT), group, direction, 255, v)
            hidden = hd.robots.spec.Linearizer(ROBOT.pwm_map.wheels, math.sqrt(2.0))
            slope = np.gradient(curve_values(ROBOT, hidden, group, direction, 255, v), v)
            true = curve_values(ROBOT, hidden, group, direction, 255, v)
            assert np.abs((ours - true) / slope).max() < 0.02 * 0.037


def test_the_loop_and_the_roll_out_run_the_same_schedule(found: Calibration) -> None:
    """The same kernel, the same noise: the same steps."""
    base = hd.simulate(ROBOT, plant="pwm_map", seed=0)
    looped = build.calibrate_steps(base)
    assert looped.toml_tables(ROBOT) == found.toml_tables(ROBOT)
    assert [step.record.pwm for step in looped.steps] == [step.record.pwm for step in found.steps]


def test_two_seeds_agree(found: Calibration) -> None:
    """As far as their wheels do: each seed has its own one per cent."""
    other = of_log(rolled(seed=3)[1])
    for one, again in zip(found.fits, other.fits, strict=True):
        assert again.dead_zone == pytest.approx(one.dead_zone, abs=0.6)
        assert again.top_m_s == pytest.approx(one.top_m_s, rel=0.05)


def test_any_other_base_goes_wheel_by_wheel() -> None:
    """By its encoders, with no dead zone where there is none."""
    omni = build.calibrate_steps(hd.simulate("omni3"), levels=6)
    robot = hd.load("omni3")
    assert [one.group for one in omni.fits[::2]] == [wheel.name for wheel in robot.wheels]
    for one in omni.fits:
        wheel = next(wheel for wheel in robot.wheels if wheel.name == one.group)
        assert one.top_m_s == pytest.approx(wheel.motor.no_load_speed_rad_s * wheel.radius, rel=0.01)
        assert one.dead_zone < 1.0


def test_it_stops_by_itself_when_it_strays() -> None:
    """With a fault that says so, and exit code 3."""
    with pytest.raises(HardwareFault, match=r"strayed more than 0\.01 m from where it began") as caught:
        build.calibrate_steps(hd.simulate(ROBOT, plant="pwm_map"), stray_m=0.01)
    assert caught.value.exit_code == 3


def test_it_stops_when_nothing_moves_at_full_pwm() -> None:
    """A curve whose dead zone ends above full PWM, or a wire that is loose."""
    flat = replace(ROBOT, pwm_map=replace(ROBOT.pwm_map, voltage_v=1000.0))
    with pytest.raises(HardwareFault, match="do not move at full PWM"):
        build.calibrate_steps(hd.simulate(flat, plant="pwm_map"))


def test_it_stops_when_the_robot_does_not_come_to_rest() -> None:
    """Wheels with a lag of a minute."""
    slow = replace(ROBOT, pwm_map=replace(ROBOT.pwm_map, lag_s=60.0))
    with pytest.raises(HardwareFault, match="has not come to rest"):
        build.calibrate_steps(hd.simulate(slow, plant="pwm_map"))


def test_the_base_is_closed_whatever_happens() -> None:
    """Also where it cannot even begin."""
    base = hd.simulate(replace(ROBOT, mice=()), plant="pwm_map")
    base.apply(DutyCommand((1.0,) * 4))
    with pytest.raises(InputError, match="neither two mice nor encoders"):
        build.calibrate_steps(base)
    command = base._state[hd.sim.state.COMMAND : hd.sim.state.COMMAND + 4]
    assert not command.any()


def test_duties_pass_the_gate_in_calibration_only() -> None:
    """The schedule is no way around it."""
    command = DutyCommand((0.5, 0.0, 0.0, 0.5))
    assert gate(command, GateState(), GateLimits.of(ROBOT)).reason
    assert not gate(command, GateState(), GateLimits.of(ROBOT, calibration=True)).reason


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"levels": 3}, "levels is 3; allowed: 4 to 32"),
        ({"counts": 0}, "counts is 0; it must be a number above 0"),
        ({"counts": 99.5}, "a whole number of counts"),
        ({"step_s": math.nan}, "step_s is nan"),
        ({"groups": ()}, "groups is empty"),
    ],
)
def test_numbers_that_cannot_be_are_refused(change, words) -> None:
    """By name."""
    with pytest.raises(InputError, match=words):
        replace(DutySteps(WHEELS), **change)


def test_a_log_without_a_step_has_none() -> None:
    """Nothing recorded, nothing found."""
    assert StepLog().records(ROBOT, GROUPS, 255.0) == ()
