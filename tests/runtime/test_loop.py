"""The one loop, on a base made of a few lines: what goes out, what is recorded, how it ends."""

import math

import numpy as np
import pytest

import holodrive as hd
from holodrive import estimation, references
from holodrive.control import FunctionController, controller
from holodrive.errors import InputError
from holodrive.runtime import Loop
from holodrive.types import Decision, DutyCommand, Observation, Pose, Twist, WheelCommand, WheelState

ROBOT = hd.load("omni3")
START = Pose(0.0, 0.0, 0.0)


class PerfectBase:
    """Wheels that do at once what they are told."""

    def __init__(self, robot=ROBOT):
        self.robot, self.sent, self.closed = robot, [], 0
        self._position, self._tick = np.zeros(len(robot.wheels)), 0

    def observe(self):
        period = self.robot.control_period_s
        last = self.sent[-1] if self.sent else None
        speeds = np.array(last.speeds) if isinstance(last, WheelCommand) else np.zeros(len(self.robot.wheels))
        return Observation(self._tick * period, period, WheelState(self._position.copy(), speeds, np.zeros(0)))

    def apply(self, command):
        self.sent.append(command)
        if isinstance(command, WheelCommand):
            self._position += self.robot.control_period_s * np.array(command.speeds)
        self._tick += 1
        return command

    def close(self):
        self.closed += 1


class Notes:
    """A sink that keeps all it hears."""

    def __init__(self):
        self.ticks, self.events, self.scans = [], [], []

    def tick(self, tick):
        self.ticks.append(tick)

    def scan(self, scan):
        self.scans.append(scan)

    def event(self, event):
        self.events.append(event)


def loop_of(law, goal=(0.05, 0.0, 0.0), base=None, **options):
    base, notes = base or PerfectBase(), Notes()
    believer = estimation.estimator("wheel_odometry", ROBOT)
    driver = controller(law, ROBOT)
    source = references.ReferenceFollower(references.fixed_goal(goal))
    loop = Loop(base, driver, believer, source, (notes,), **options)
    loop.reset(START)
    return loop, base, notes


def test_a_run_ends_where_it_shall_with_the_base_closed():
    loop, base, notes = loop_of("go_to_pose")
    ending = loop.run(20.0)
    assert ending.why == "arrived"
    assert base.closed == 1
    assert math.hypot(notes.ticks[-1].estimate.pose.x - 0.05, notes.ticks[-1].estimate.pose.y) < 0.021
    assert [event.kind for event in notes.events] == ["arrived"]


def test_a_run_without_arrival_lasts_as_long_as_it_was_told():
    loop, _, notes = loop_of(lambda r, e, o: Twist(0.01, 0.0, 0.0))
    assert loop.run(1.0).why == "duration"
    assert len(notes.ticks) == 100


@pytest.mark.parametrize("bad", [math.nan, math.inf, -math.inf])
def test_a_twist_that_is_no_number_stops_all_wheels_and_ends_the_run(bad):
    loop, base, notes = loop_of(lambda r, e, o: Twist(0.05, bad, 0.0) if o.time > 0.1 else Twist(0.05, 0.0, 0.0))
    ending = loop.run(10.0)
    assert ending.why == "fault"
    assert ending.time < 1.0
    first = next(k for k, command in enumerate(base.sent) if not any(command.speeds))
    assert all(command.speeds == (0.0, 0.0, 0.0) for command in base.sent[first:])
    assert [event.kind for event in notes.events] == ["gate"]
    assert "all wheels are stopped" in notes.events[0].text
    assert base.closed == 1


def test_after_a_fault_a_good_command_does_not_move_the_robot_again():
    loop, base, _ = loop_of(lambda r, e, o: Twist(math.nan if o.time < 0.005 else 0.05, 0.0, 0.0))
    loop.run(5.0)
    assert all(command.speeds == (0.0, 0.0, 0.0) for command in base.sent)


def test_wheel_commands_above_the_limit_are_scaled_together():
    limit = ROBOT.wheels[0].max_speed_rad_s
    loop, base, _ = loop_of(lambda r, e, o: WheelCommand((4.0 * limit, 2.0 * limit, -limit)))
    loop.run(0.1)
    np.testing.assert_allclose(base.sent[0].speeds, (limit, 0.5 * limit, -0.25 * limit))


def test_duty_is_refused_unless_calibrating():
    loop, base, notes = loop_of(lambda r, e, o: DutyCommand((0.1, 0.1, 0.1)))
    assert loop.run(1.0).why == "fault"
    assert "calibration" in notes.events[0].text
    loop, base, _ = loop_of(lambda r, e, o: DutyCommand((0.1, 0.1, 0.1)), calibration=True)
    assert loop.run(0.2).why == "duration"
    assert isinstance(base.sent[0], DutyCommand)


def test_ctrl_c_stops_the_robot_and_loses_nothing():
    def law(reference, estimate, observation):
        if observation.time > 0.2:
            raise KeyboardInterrupt
        return Twist(0.02, 0.0, 0.0)

    loop, base, notes = loop_of(law)
    assert loop.run(10.0).why == "interrupted"
    assert base.closed == 1
    assert len(notes.ticks) == 21
    assert notes.events[-1].kind == "stop"


def test_a_controller_that_breaks_still_stops_the_robot():
    def law(reference, estimate, observation):
        raise ZeroDivisionError("a bug of the user's")

    loop, base, _ = loop_of(law)
    with pytest.raises(ZeroDivisionError):
        loop.run(10.0)
    assert base.closed == 1


def test_a_controllers_own_fault_is_told():
    loop, _, notes = loop_of(lambda r, e, o: Decision(Twist(0, 0, 0), fault="no rule fires"))
    loop.run(0.02)
    assert notes.events[0].text == "no rule fires"


def test_the_wall_clock_is_asked_before_each_tick():
    asked = []
    loop, _, _ = loop_of(lambda r, e, o: Twist(0, 0, 0))
    loop.run(0.05, pace=asked.append)
    np.testing.assert_allclose(asked, [0.0, 0.01, 0.02, 0.03, 0.04], atol=1e-12)


@pytest.mark.parametrize("law", [lambda r, e, o: 3.0, lambda r, e, o: None, lambda r, e, o: "left"])
def test_an_answer_that_is_no_command_gets_one_clear_line(law):
    with pytest.raises(InputError, match="must give a Twist"):
        FunctionController(law).step(None, None, None)


@pytest.mark.parametrize("what", [3.0, None, object()])
def test_what_cannot_control_is_refused(what):
    with pytest.raises(InputError, match="no controller"):
        controller(what, ROBOT)


def test_a_base_may_be_driven_again_and_its_clock_need_not_begin_at_zero():
    loop, base, _ = loop_of(lambda r, e, o: Twist(0.01, 0.0, 0.0))
    loop.run(1.0)
    again, _, notes = loop_of(lambda r, e, o: Twist(0.01, 0.0, 0.0), base=base)
    assert again.run(0.5).why == "duration"
    assert len(notes.ticks) == 50
    assert notes.ticks[0].time == pytest.approx(1.0)


def test_arriving_is_told_once_even_when_the_run_goes_on():
    loop, _, notes = loop_of("go_to_pose", goal=(0.02, 0.0, 0.0))
    assert loop.run(3.0, stop_on_arrival=False).why == "duration"
    assert [event.kind for event in notes.events] == ["arrived"]
    assert len(notes.ticks) == 300


def test_modules_at_rest_stay_as_they_stand_when_a_drive_begins():
    robot = hd.load("swerve3")
    base = hd.simulate(robot, "open")
    for _ in range(100):
        base.apply(WheelCommand((0.0,) * 3, (1.2, -0.4, 0.9)))
    stood = base.observe().wheels.steer
    run = hd.drive(base, lambda r, e, o: Twist(0.0, 0.0, 0.0), goal=(0, 0, 0), duration_s=0.5, stop_on_arrival=False)
    np.testing.assert_allclose(run.steer[-1], stood, atol=1e-3)
    np.testing.assert_allclose(run.steer_commands, np.tile(stood, (len(run.time), 1)), atol=1e-3)
