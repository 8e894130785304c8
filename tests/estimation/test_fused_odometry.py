"""Claims about odometry by wheels and mice together: exact where they agree, and who is left out where they do not."""

import math
from dataclasses import replace

import ground
import numpy as np
import pytest

from holodrive import estimation, geometry, robots
from holodrive.errors import InputError
from holodrive.estimation.fused_odometry import FusedOdometry
from holodrive.estimation.kernel import KernelEstimator
from holodrive.kinematics import Chassis
from holodrive.robots.spec import Encoder, Mouse, Robot
from holodrive.types import Array, Estimate, Observation, Pose, WheelState

DT = 0.015
START = Pose(1.0, 2.0, -0.5)
FAULT = 66  # row at which something breaks
TWISTS = [(0.03, 0.0, 0.0), (0.0, 0.03, 0.0), (-0.02, 0.02, 0.05), (0.0, 0.0, 0.1)]


def drive(
    robot: Robot,
    displacements: Array,
    *,
    spin: Array | None = None,
    mice: Array | None = None,
    params: FusedOdometry | None = None,
) -> list[Estimate]:
    """Beliefs on that way; `spin` (N, n) [rad] adds to the wheels' turns, `mice` (N, k, 2) are told instead."""
    commands = [Chassis.of(robot).inverse(move) for move in displacements]
    turns = np.array([command.speeds for command in commands])
    steer = np.array([command.steer for command in commands]).reshape(len(commands), -1)
    position = np.cumsum(turns + (0.0 if spin is None else spin), axis=0)
    told = ground.ways(displacements, tuple(mouse.mount for mouse in robot.mice)) if mice is None else mice
    estimator, nothing = KernelEstimator(params or FusedOdometry(), robot), np.zeros(len(robot.wheels))
    estimator.reset(START)
    beliefs = [estimator.step(Observation(0.0, DT, WheelState(nothing, nothing, steer[0]), mice=0.0 * told[0]))]
    for k in range(len(displacements)):
        wheels = WheelState(position[k], nothing, steer[k])
        beliefs.append(estimator.step(Observation(DT * (k + 1), DT, wheels, mice=told[k])))
    return beliefs


def with_mice(name: str) -> Robot:
    """A robot of the catalog, without gyro, with fine encoders and two mice."""
    robot = robots.load(name)
    wheels = tuple(replace(wheel, encoder=Encoder(1e7)) for wheel in robot.wheels)
    mice = (Mouse("one", Pose(0.05, 0.01, 0.4)), Mouse("two", Pose(-0.04, 0.03, -1.0)))
    return replace(robot, wheels=wheels, mice=mice, imu=None)


def constant(twist: tuple[float, float, float]) -> Array:
    return np.tile(DT * np.array(twist), (200, 1))


def off(beliefs: list[Estimate], displacements: Array) -> tuple[float, float]:
    """Distance [m] and angle [rad] of the last belief from where the robot is."""
    end = geometry.compose(np.array(START), ground.path(displacements)[-1])
    error = np.array(beliefs[-1].pose) - end
    return math.hypot(*error[:2]), abs(float(error[2]))


@pytest.mark.parametrize("name", ["mecanum4", "omni3", "omni4", "swerve4", "hybrid3"])
@pytest.mark.parametrize("twist", TWISTS)
def test_sensors_that_agree_give_the_exact_pose(name: str, twist: tuple[float, float, float]) -> None:
    robot, moves = with_mice(name), constant(twist)
    beliefs = drive(robot, moves)
    assert off(beliefs, moves) == pytest.approx((0.0, 0.0), abs=1e-9)
    assert max(belief.slip for belief in beliefs) < 1e-9
    assert not any(belief.suspect for belief in beliefs)


@pytest.mark.parametrize("twist", TWISTS)
@pytest.mark.parametrize("wheel", range(4))
def test_a_wheel_that_spins_costs_next_to_nothing(twist: tuple[float, float, float], wheel: int) -> None:
    """29 mm of rim in one second, which wheels alone would take for 7 mm of way or 20 mrad of turn."""
    robot, moves = with_mice("mecanum4"), constant(twist)
    spin = np.zeros((200, 4))
    spin[FAULT:130, wheel] = DT
    beliefs = drive(robot, moves, spin=spin)
    distance, turn = off(beliefs, moves)
    assert distance < 0.2e-3
    assert turn < 3e-3
    assert beliefs[100].slip > 10.0 * beliefs[FAULT].slip
    assert not any(belief.suspect for belief in beliefs)


@pytest.mark.parametrize("twist", TWISTS)
def test_wheels_that_all_slip_are_outvoted_by_two_mice(twist: tuple[float, float, float]) -> None:
    robot, moves = with_mice("mecanum4"), constant(twist)
    spin = np.zeros((200, 4))
    spin[FAULT:] = DT
    distance, turn = off(drive(robot, moves, spin=spin), moves)
    assert distance < 1e-3
    assert turn < 0.02


@pytest.mark.parametrize("twist", TWISTS)
@pytest.mark.parametrize("mouse", range(2))
def test_a_dead_mouse_is_left_out_within_a_fifth_of_a_second(twist: tuple[float, float, float], mouse: int) -> None:
    robot, moves = with_mice("mecanum4"), constant(twist)
    mice = ground.ways(moves, tuple(mouse.mount for mouse in robot.mice))
    mice[FAULT:, mouse] = 0.0
    beliefs = drive(robot, moves, mice=mice)
    assert all(belief.suspect == 1 << mouse for belief in beliefs[FAULT + 14 :])
    distance, turn = off(beliefs, moves)
    assert distance < 2e-3
    assert turn < 0.02


def test_without_trust_in_one_side_it_is_the_odometry_of_the_other() -> None:
    robot, rng = with_mice("mecanum4"), np.random.default_rng(3)
    moves = 0.3 * ground.motion(rng, 3.0, DT)
    exact = ground.ways(moves, tuple(mouse.mount for mouse in robot.mice))
    # both sides are a little wrong, each in its own way, and no one is left out for it
    spin, mice = 1e-4 * rng.normal(size=(200, 4)), exact * 1.01
    blunt = FusedOdometry(wheel_noise=1e4, gate=1e6)
    poses = [belief.pose for belief in drive(robot, moves, spin=spin, mice=mice, params=blunt)]
    alone = KernelEstimator(estimation.plug("mouse_odometry"), robot)
    alone.reset(START)
    still = WheelState(np.zeros(4), np.zeros(4), np.zeros(0))
    told = np.concatenate([0.0 * mice[:1], mice])
    wanted = [alone.step(Observation(DT * k, DT, still, mice=row)).pose for k, row in enumerate(told)]
    np.testing.assert_allclose(poses, wanted, atol=1e-8)


def test_a_gyro_holds_the_heading_when_wheels_and_mice_cannot_tell_it() -> None:
    """One mouse in the centre is left, and one wheel: nothing but the gyro knows the turn."""
    robot = robots.load("mecanum4")
    robot = replace(robot, imu=robots.load("hybrid3").imu)
    estimator = KernelEstimator(FusedOdometry(), robot)
    estimator.reset(Pose(0.0, 0.0, 0.0))
    nan, mice = np.full(4, np.nan), np.array([[3e-4, 0.0], [np.nan, np.nan]])
    for k in range(100):
        estimate = estimator.step(Observation(DT * k, DT, WheelState(nan, nan, np.zeros(0)), gyro=0.2, mice=mice))
    assert estimate.pose.theta == pytest.approx(0.2 * DT * 99, rel=1e-3)
    assert estimate.suspect == 2


def test_robots_that_lack_a_side_are_refused_in_one_line() -> None:
    whole = robots.load("mecanum4")
    blind = tuple(replace(wheel, encoder=None) for wheel in whole.wheels)
    one = (*blind[:3], whole.wheels[3])
    for robot, words in (
        (replace(whole, mice=()), "needs 1 mouse, mecanum4 has 0"),
        (replace(whole, wheels=blind), "needs encoders, mecanum4 has none"),
        (replace(whole, mice=(Mouse("far", Pose(0.5, 0.0, 0.0)),)), "outside its footprint"),
    ):
        with pytest.raises(InputError, match=words) as refused:
            FusedOdometry().pack(robot)
        assert "\n" not in str(refused.value)
    # one mouse tells two motions, a wheel the third, unless it rolls through the mouse
    assert len(FusedOdometry().pack(replace(whole, wheels=one, mice=whole.mice[:1])))


def test_parameters_out_of_range_are_refused() -> None:
    with pytest.raises(InputError, match="wheel_noise = -1"):
        FusedOdometry(wheel_noise=-1.0)
