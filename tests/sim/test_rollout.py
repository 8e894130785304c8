"""The compiled roll-out: the ordinary loop's numbers, whatever the threads, the chunks, the controller."""

import math
from dataclasses import dataclass, replace
from typing import ClassVar

import numpy as np
import pytest
from machines import hybrid, mecanum, swerve
from numba import njit

from holodrive import layout, metrics, references
from holodrive.control.go_to_pose import GoToPose
from holodrive.control.kernel import KernelController
from holodrive.errors import InputError, UnknownName
from holodrive.estimation import WheelOdometry
from holodrive.estimation.kernel import KernelEstimator
from holodrive.kinematics.pipeline import CommandPipeline
from holodrive.obstacles import clearance
from holodrive.robots.spec import Imu, Lidar, Mouse
from holodrive.sim import SimBase, rollout
from holodrive.types import Pose, Twist
from holodrive.worlds.spec import Circle, Goal, KeyFrame, Mover, World

COURSE = World(
    "course",
    size=(4.0, 3.0),
    corner=(-1.0, -1.5),
    goal=Goal(Pose(2.0, 0.6, 1.0), heading_matters=True),
    circles=(Circle(1.0, -0.9, 0.3), Circle(1.2, 0.9, 0.2)),
    movers=(Mover(0.15, (KeyFrame(0.0, 1.5, -1.0), KeyFrame(8.0, 1.5, 1.0)), loop=True),),
)
NOISY = {
    "lidar": Lidar("noisy", rate_hz=5.5, beams=90, noise_m=0.01, dropout=0.02),
    "imu": Imu("imu", gyro_noise_rad_s=0.01, gyro_bias_walk_rad_s=0.01, accel_noise_m_s2=0.1),
    "mice": (Mouse("m", noise_relative=0.01),),
}


@njit(cache=True)
def wall_follower(obs, memory, params, command):
    """Reacts to everything: beams, gyro, mice, wheels, the reference, its own memory."""
    near = 10.0
    for i in range(int(obs[layout.N_BEAMS])):
        d = obs[layout.BEAMS + i]
        if d < near:
            near = d
    memory[0] += obs[layout.MICE] + obs[layout.SCAN_IS_NEW]
    turn = 0.0 if math.isnan(obs[layout.GYRO]) else -0.1 * obs[layout.GYRO]
    command[0] = params[0] * (obs[layout.REF_POSE] - obs[layout.POSE])
    command[1] = params[0] * (obs[layout.REF_POSE + 1] - obs[layout.POSE + 1]) + 0.01 * near
    command[2] = turn + 0.02 * math.sin(memory[0]) + 0.01 * obs[layout.WHEEL_SPEED]


@dataclass(frozen=True)
class WallFollower:
    gain: float = 0.3
    command_kind: ClassVar[str] = "twist"
    kernel: ClassVar[object] = staticmethod(wall_follower)

    def memory_size(self, robot):
        return 1

    def pack(self, robot):
        return np.array([self.gain])


@njit
def wheel_kernel(obs, memory, params, command):
    for i in range(3):
        command[i] = params[i]
    command[layout.ARRIVED] = 1.0 if obs[layout.TIME] >= 0.5 else 0.0


@dataclass(frozen=True)
class WheelSpeeds:
    speeds: tuple[float, ...] = (0.5, 1.0, -1.0)
    command_kind: ClassVar[str] = "wheels"
    kernel: ClassVar[object] = staticmethod(wheel_kernel)

    def memory_size(self, robot):
        return 0

    def pack(self, robot):
        return np.array(self.speeds)


class DutyPlug(WheelSpeeds):
    command_kind: ClassVar[str] = "duty"


def ordinary_loop(robot, world, plug, estimator, ticks, plant, seed):
    """What `runtime.Loop` does, in ten lines."""
    base = SimBase(robot, world, plant=plant, seed=seed)
    controller, believer = KernelController(plug, robot), KernelEstimator(estimator, robot)
    pipeline, follower = CommandPipeline(robot), references.ReferenceFollower(references.fixed_goal(world.goal.pose))
    believer.reset(base.truth)
    rows = []
    for _ in range(ticks):
        seen = base.observe()
        belief = believer.step(seen)
        command = controller.step(follower.step(seen.time, belief.pose), belief, seen).command
        rows.append((*base.truth, *belief.pose))
        base.apply(pipeline.step(command, seen.dt) if isinstance(command, Twist) else command)
    return np.array(rows), base


@pytest.mark.parametrize("plant", ["first_order", "slip"])
@pytest.mark.parametrize("machine", [hybrid, mecanum, swerve])
@pytest.mark.parametrize("plug", [GoToPose(), WallFollower()], ids=["go_to_pose", "wall_follower"])
def test_the_ordinary_loop_and_the_roll_out_are_one_trajectory(machine, plant, plug):
    robot = machine(**NOISY)
    rows, base = ordinary_loop(robot, COURSE, plug, WheelOdometry(), 300, plant, 11)
    out = rollout(robot, COURSE, plug, estimator=WheelOdometry(), t=3.0, plant=plant, seed=11, log_every=1)
    assert np.allclose(out.log[0, :, 1:7], rows, atol=1e-9)
    assert np.allclose(out.pose[0], base.truth, atol=1e-9)


def test_wheel_commands_give_the_same_bits_in_both():
    robot = hybrid(**NOISY)
    rows, base = ordinary_loop(robot, COURSE, WheelSpeeds(), WheelOdometry(), 100, "slip", 2)
    out = rollout(robot, COURSE, WheelSpeeds(), estimator=WheelOdometry(), t=1.0, plant="slip", seed=2, log_every=1)
    assert np.array_equal(out.log[0, :, 1:4], rows[:, :3])
    assert np.array_equal(out.pose[0], base.truth)


def batch(**options):
    rng = np.random.default_rng(0)
    starts = rng.uniform((-0.6, -0.8, -3.0), (0.3, 0.8, 3.0), (23, 3))
    params = rng.uniform(0.1, 0.9, (23, 1))
    part = options.pop("part", slice(None))
    how = {"plant": "slip", "seed": 5, "t": 2.0, "log_every": 7, "estimator": WheelOdometry()} | options
    return rollout(
        hybrid(**NOISY), how.pop("world", COURSE), WallFollower(), n=len(starts[part]), starts=starts[part],
        params=params[part], first=part.start or 0, **how,
    )  # fmt: skip


def same(a, b, part=slice(None)):
    return (
        np.array_equal(a.state[part], b.state, equal_nan=True)
        and np.array_equal(a.log[part], b.log, equal_nan=True)
        and np.array_equal(a.event_rows[part], b.event_rows)
        and all(np.array_equal(a.metrics[k][part], b.metrics[k], equal_nan=True) for k in metrics.NAMES)
    )


def test_any_number_of_threads_gives_the_same_bits():
    one = batch(workers=1)
    assert all(same(one, batch(workers=k)) for k in (2, 3, 8))


def test_any_cut_into_chunks_gives_the_same_bits():
    whole = batch(workers=1)
    for part in (slice(0, 1), slice(1, 9), slice(9, 23)):
        assert same(whole, batch(part=part, workers=2), part)


def test_a_world_for_each_robot_gives_what_each_world_gives_alone():
    other = replace(COURSE, name="other", circles=())
    mixed = batch(world=[COURSE if i % 3 else other for i in range(23)], workers=2)
    alone, elsewhere = batch(workers=1), batch(world=other, workers=1)
    for i in range(23):
        assert np.array_equal(mixed.state[i], (alone if i % 3 else elsewhere).state[i], equal_nan=True)


def test_robots_of_one_seed_differ_in_noise_only():
    out = rollout(hybrid(**NOISY), COURSE, WallFollower(), n=3, t=1.0, plant="slip")
    assert len({tuple(pose) for pose in out.pose.tolist()}) == 3
    quiet = rollout(hybrid(), COURSE, GoToPose(), n=3, t=1.0)
    assert len({tuple(pose) for pose in quiet.pose.tolist()}) == 1


def test_metrics_in_the_kernel_are_those_of_the_arrays():
    out = rollout(hybrid(), COURSE, GoToPose(k_xy=0.4), n=1, t=20.0, log_every=1, estimator=WheelOdometry())
    pose = np.stack([out.column(name)[0] for name in ("x", "y", "theta")], axis=1)
    reference = np.stack([out.column(name)[0] for name in ("ref_x", "ref_y", "ref_theta")], axis=1)
    time = out.column("time")[0]
    names = ("duty:front", "duty:right", "duty:left")
    again = metrics.of_arrays(
        time,
        pose,
        reference,
        np.stack([out.column(name)[0] for name in names], axis=1),
        clearance_m=clearance(COURSE, time, pose, hybrid().footprint_radius_m),
        arrived=bool(out.metrics["arrived"][0]),
        collisions=int(out.metrics["collisions"][0]),
        moved_collisions=int(out.metrics["moved_collisions"][0]),
    )
    for name, value in again.items():
        assert out.metrics[name][0] == pytest.approx(value, rel=1e-12, nan_ok=True), name


def test_arrival_ends_a_run_early_only_when_asked():
    short = rollout(hybrid(), COURSE, WheelSpeeds(), t=2.0, stop_on_arrival=True, log_every=1)
    assert short.metrics["arrived"][0] == 1.0
    assert short.metrics["time_s"][0] == pytest.approx(0.5)
    assert np.isnan(short.column("x")[0, 60:]).all()
    long = rollout(hybrid(), COURSE, WheelSpeeds(), t=2.0)
    assert long.metrics["time_s"][0] == pytest.approx(1.99)


def test_a_duty_controller_goes_past_the_speed_loop():
    out = rollout(hybrid(), COURSE, DutyPlug((0.1, 0.4, -0.4)), t=1.0, log_every=1)
    assert np.all(out.column("duty:right")[0] == 0.4)


@pytest.mark.parametrize(
    "plug", [WallFollower(math.nan), WheelSpeeds((0.1, math.inf, 0.0)), DutyPlug((math.nan, 0.0, 0.0))]
)
def test_a_command_that_is_not_finite_stops_the_robot_and_is_told(plug):
    out = rollout(hybrid(), COURSE, plug, t=1.0)
    assert out.fault[0]
    assert [event.kind for event in out.events[0]] == ["fault"]
    assert np.allclose(out.twist, 0.0)


def test_each_robot_can_have_its_own_reference_and_those_with_one_share_it():
    tables = [references.fixed_goal((0.0, 1.0, 0.5)), references.fixed_goal((0.4, 1.2, 0.0))]
    mixed = rollout(hybrid(), COURSE, GoToPose(), n=3, t=2.0, reference=[tables[0], tables[1], tables[0]])
    for robot, table in ((0, tables[0]), (1, tables[1]), (2, tables[0])):
        alone = rollout(hybrid(), COURSE, GoToPose(), first=robot, t=2.0, reference=table)
        assert np.array_equal(mixed.pose[robot], alone.pose[0])


def test_goals_and_references_mean_the_same_place():
    goals = rollout(hybrid(), COURSE, GoToPose(), n=2, t=2.0, goals=[(1.0, 0.0, 0.0), (0.0, 1.0, 0.5)])
    fixed = rollout(hybrid(), COURSE, GoToPose(), t=2.0, reference=references.fixed_goal((0.0, 1.0, 0.5)))
    assert np.array_equal(goals.pose[1], fixed.pose[0])


def test_faults_of_the_call_say_what_is_allowed():
    robot = hybrid()
    for fragment, options in (
        ("has no goal", {"world": World("bare")}),
        ("n >= 1", {"n": 0}),
        ("one world or 3", {"n": 3, "world": [COURSE, COURSE]}),
        (r"expected \(10,\) or \(2, 10\)", {"n": 2, "params": np.zeros((3, 1))}),
        (r"expected \(3,\) or \(2, 3\)", {"n": 2, "starts": np.zeros((2, 2))}),
        ("one reference or 2", {"n": 2, "reference": [references.fixed_goal((0.0, 0.0, 0.0))]}),
        ("not both", {"goals": (0.0, 0.0, 0.0), "reference": references.fixed_goal((0.0, 0.0, 0.0))}),
        ("divide the control period", {"dt": 0.003}),
    ):
        with pytest.raises(InputError, match=fragment):
            rollout(robot, options.pop("world", COURSE), GoToPose(), t=0.1, **options)
    with pytest.raises(UnknownName, match="Did you mean"):
        rollout(robot, COURSE, GoToPose(), plant="slipp")
    with pytest.raises(UnknownName, match="log_every"):
        rollout(robot, COURSE, GoToPose(), t=0.1).column("x")


def plain(obs, memory, params, command):
    pass


@njit
def broken(obs, memory, params, command):
    command.no_such_thing()


def test_a_kernel_that_is_not_one_is_named_without_a_traceback_of_numba():
    for kernel, fragment in ((plain, "not compiled"), (broken, "does not compile")):
        kind = type("Bad", (WheelSpeeds,), {"kernel": staticmethod(kernel)})
        with pytest.raises(InputError, match=fragment):
            rollout(hybrid(), COURSE, kind(), t=0.1)
