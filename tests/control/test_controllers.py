"""Laws of the first controllers, and contracts that every registered controller keeps."""

import math
from dataclasses import replace

import numpy as np
import pytest

from holodrive import control, layout
from holodrive.control.go_to_pose import GoToPose
from holodrive.control.pid import Pid
from holodrive.errors import HolodriveError
from holodrive.robots.spec import Lidar, Limits, Motor, Robot, WheelSpec
from holodrive.types import Estimate, Observation, Pose, Reference, Scan, Twist, WheelState

MOTOR = Motor("test", "dc", 12.0, 10.0, 1.0, 2.0)
WHEELS = tuple(
    WheelSpec(f"w{k}", "omni", 0.2 * math.cos(a), 0.2 * math.sin(a), a + math.pi / 2, 0.05, MOTOR, 10.0)
    for k, a in enumerate((0.0, 2 * math.pi / 3, -2 * math.pi / 3))
)
BEAMS = 36
ROBOT = Robot("test", WHEELS, 3.0, 0.1, 0.25, lidar=Lidar("test", beams=BEAMS))
DIAGONALS = tuple(
    WheelSpec(f"w{k}", "mecanum", x, y, 0.0, 0.05, MOTOR, 10.0, roller=math.copysign(math.pi / 4, -x * y))
    for k, (x, y) in enumerate(((0.2, 0.15), (0.2, -0.15), (-0.2, 0.15), (-0.2, -0.15)))
)
MECANUM = replace(ROBOT, wheels=DIAGONALS)


def robot_for(name):
    """A base that the controller can drive."""
    return MECANUM if getattr(control.plug_class(name), "needs_diagonals", False) else ROBOT


def seen(dt=0.01, time=0.0, wheels=3):
    """A robot at rest that sees nothing near: some controllers drive by their lidar only."""
    angles = 2.0 * math.pi * np.arange(BEAMS) / BEAMS
    scan = Scan(time, angles, np.full(BEAMS, math.inf), np.zeros(BEAMS), range_min=0.15, range_max=12.0)
    state = WheelState(np.zeros(wheels), np.zeros(wheels), np.zeros(0))
    return Observation(time, dt, state, scan=scan, scan_is_new=True)


def believed(pose, twist=(0.0, 0.0, 0.0)):
    return Estimate(Pose(*pose), Twist(*twist), np.zeros((3, 3)))


def decide(name, reference, pose, params=None, robot=None, twist=(0.0, 0.0, 0.0)):
    robot = robot or robot_for(name)
    driver = control.controller(name, robot, params)
    return driver.step(reference, believed(pose, twist), seen(wheels=len(robot.wheels)))


def numbers(command):
    """Twist, or wheel speeds and steering angles, as one vector."""
    return np.concatenate([np.ravel(part) for part in command])


POSES = np.random.default_rng(3).uniform(-3, 3, size=(20, 3))


@pytest.mark.parametrize("name", control.names())
def test_every_controller_rests_and_says_so_where_it_shall_be(name):
    decision = decide(name, Reference(Pose(1.0, 2.0, 0.5)), (1.0, 2.0, 0.5))
    np.testing.assert_allclose(numbers(decision.command), 0.0, atol=1e-12)
    assert decision.arrived


@pytest.mark.parametrize("name", control.names())
def test_no_controller_arrives_at_a_reference_that_still_moves(name):
    assert not decide(name, Reference(Pose(1.0, 2.0, 0.5), last=False), (1.0, 2.0, 0.5)).arrived


@pytest.mark.parametrize("name", control.names())
@pytest.mark.parametrize("pose", POSES)
def test_every_controller_commands_the_same_wherever_the_world_has_its_origin(name, pose):
    """Moving and turning world, robot and goal together changes nothing in the body's twist."""
    from holodrive import geometry

    goal, shift = np.array([0.3, -0.4, 0.2]), np.array([1.0, -2.0, 0.7])
    here = decide(name, Reference(Pose(*goal)), pose).command
    there = decide(name, Reference(Pose(*geometry.compose(shift, goal))), geometry.compose(shift, pose)).command
    np.testing.assert_allclose(numbers(there), numbers(here), atol=1e-12)


@pytest.mark.parametrize("name", control.names())
def test_no_controller_turns_a_nan_into_a_motion(name):
    """NaN in, NaN out: the gate then stops; a controller must not hide it behind a number."""
    for pose in ((math.nan, 0.0, 0.0), (0.0, 0.0, math.nan)):
        decision = decide(name, Reference(Pose(1.0, 0.0, 0.5)), pose)
        assert not np.all(np.isfinite(numbers(decision.command)))
        assert not decision.arrived


@pytest.mark.parametrize("name", control.names())
def test_a_controller_forgets_on_reset(name):
    robot = robot_for(name)
    robot_controller, sight = control.controller(name, robot), seen(wheels=len(robot.wheels))
    reference = Reference(Pose(0.1, 0.05, 0.1))
    first = robot_controller.step(reference, believed((0, 0, 0)), sight)
    for _ in range(5):
        robot_controller.step(reference, believed((0, 0, 0)), sight)
    robot_controller.reset()
    assert robot_controller.step(reference, believed((0, 0, 0)), sight) == first


@pytest.mark.parametrize("name", [name for name in control.names() if hasattr(control.plug_class(name), "kernel")])
def test_memory_and_parameters_fit_what_the_kernel_uses(name):
    plug = control.plug(name)
    assert plug.memory_size(robot_for(name)) >= 0
    params = plug.pack(robot_for(name))
    assert params.dtype == np.float64
    assert params.flags.c_contiguous
    assert layout.COMMAND_SIZE > layout.FAULT


@pytest.mark.parametrize("pose", POSES)
def test_world_law_pulls_straight_to_the_goal(pose):
    twist = np.array(decide("go_to_pose", Reference(Pose(0.5, 0.5, 0.0)), pose, {"k_xy": 0.7}).command)
    c, s = math.cos(pose[2]), math.sin(pose[2])
    world = np.array([c * twist[0] - s * twist[1], s * twist[0] + c * twist[1]])
    np.testing.assert_allclose(world, 0.7 * (np.array([0.5, 0.5]) - pose[:2]), atol=1e-12)


@pytest.mark.parametrize("pose", POSES)
def test_screw_law_is_the_logarithm_of_the_way_to_go(pose):
    from holodrive import geometry

    goal = np.array([0.5, -0.2, 0.3])
    twist = decide("go_to_pose", Reference(Pose(*goal)), pose, {"law": "screw", "k_xy": 0.8}).command
    np.testing.assert_allclose(twist, 0.8 * geometry.log(geometry.between(pose, goal)), atol=1e-9)


def test_a_goal_straight_behind_turns_counter_clockwise():
    for heading in (math.pi, -math.pi):
        assert decide("go_to_pose", Reference(Pose(0, 0, heading)), (0, 0, 0)).command.omega > 0


def test_a_speed_limit_slows_the_motion_and_keeps_its_shape():
    free = np.array(decide("go_to_pose", Reference(Pose(2, 1, 1)), (0, 0, 0)).command)
    slow = np.array(decide("go_to_pose", Reference(Pose(2, 1, 1)), (0, 0, 0), {"max_speed_m_s": 0.1}).command)
    assert math.isclose(math.hypot(*slow[:2]), 0.1)
    np.testing.assert_allclose(slow / slow[0], free / free[0], rtol=1e-12)


def test_the_robots_own_limits_count_as_well():
    robot = replace(ROBOT, limits=Limits(speed_m_s=0.2, yaw_rate_rad_s=0.3))
    for name in ("go_to_pose", "pid"):
        twist = decide(name, Reference(Pose(5, 0, 3)), (0, 0, 0), robot=robot).command
        assert math.hypot(twist.vx, twist.vy) <= 0.2 + 1e-12
        assert abs(twist.omega) <= 0.3 + 1e-12


@pytest.mark.parametrize("distance", [0.01, 0.5, 5.0, 50.0])
def test_a_goal_is_neared_no_faster_than_the_base_can_brake(distance):
    robot = replace(ROBOT, limits=Limits(accel_m_s2=2.0, yaw_accel_rad_s2=3.0))
    twist = decide("go_to_pose", Reference(Pose(distance, 0, 2.0)), (0, 0, 0), {"k_xy": 3.0}, robot=robot).command
    assert twist.vx <= math.sqrt(2.0 * 2.0 * distance)
    assert twist.omega <= math.sqrt(2.0 * 3.0 * 2.0)
    assert twist.vy == 0.0


def test_pid_is_proportional_plus_integral_plus_derivative():
    params = {"kp": 2.0, "ki": 3.0, "kd": 0.5, "kp_theta": 1.0, "ki_theta": 0.0, "kd_theta": 0.0, "feed_forward": 0.0}
    pid = control.controller("pid", ROBOT, params)
    answers = [
        pid.step(Reference(Pose(0.01, 0, 0)), believed((0, 0, 0), (0.02, 0, 0)), seen()).command.vx for _ in (0, 1)
    ]
    np.testing.assert_allclose(answers, [0.02 - 0.01, 0.02 - 0.01 + 3.0 * 0.01 * 0.01], atol=1e-12)


def test_a_saturated_pid_does_not_wind_up():
    pid = control.controller("pid", ROBOT, {"ki": 5.0, "max_speed_m_s": 0.1})
    for _ in range(1000):
        pid.step(Reference(Pose(10.0, 0, 0)), believed((0, 0, 0)), seen())
    beyond = pid.step(Reference(Pose(10.0, 0, 0)), believed((10.05, 0, 0)), seen()).command
    assert beyond.vx < 0.0


@pytest.mark.parametrize(
    ("make", "word"),
    [
        (lambda: control.plug("go_to_pos"), "Did you mean 'go_to_pose'"),
        (lambda: control.plug("pid", {"kpp": 1}), "Did you mean 'kp'"),
        (lambda: control.plug("pid", {"kp": "fast"}), "number"),
        (lambda: control.plug("pid", {"kp": math.nan}), "NaN"),
        (lambda: Pid(ki=-1.0), "0 or more"),
        (lambda: GoToPose(k_xy=0.0), "above 0"),
        (lambda: GoToPose(law="strait"), "allowed: world, screw"),  # type: ignore[arg-type]
    ],
)
def test_a_bad_parameter_gets_one_clear_line(make, word):
    with pytest.raises(HolodriveError, match=word) as caught:
        make()
    assert "\n" not in str(caught.value)
