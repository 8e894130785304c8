"""Claims about odometry by ground mice: exact at any mounting, honest about its errors and about its sensors."""

import json
import math
from dataclasses import replace
from pathlib import Path

import ground
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from holodrive import estimation, geometry, robots
from holodrive.errors import InputError
from holodrive.estimation.mouse_odometry import MouseOdometry, track
from holodrive.robots.spec import Mouse, Robot
from holodrive.types import Array, Observation, Pose, WheelState

START = Pose(0.4, -1.2, 2.5)
EXACT = MouseOdometry(way_noise=0.0)
MOUNTS = st.lists(
    st.builds(Pose, st.floats(-0.15, 0.15), st.floats(-0.15, 0.15), st.floats(-3.2, 3.2)), min_size=2, max_size=4
).filter(lambda mounts: max(math.dist(a[:2], b[:2]) for a in mounts for b in mounts) > 0.02)
TWISTS = st.tuples(st.floats(-0.05, 0.05), st.floats(-0.05, 0.05), st.floats(-0.4, 0.4)).map(np.array)


@given(mounts=MOUNTS, displacement=TWISTS)
def test_a_constant_twist_moves_the_pose_by_its_exponential(mounts: list[Pose], displacement: Array) -> None:
    """Wherever the mice are mounted, and however far a tick goes."""
    result = track(mounts, ground.ways(displacement[None], tuple(mounts)), START, dt_s=1.0)
    np.testing.assert_allclose(result.pose[1], geometry.compose(START, geometry.exp(displacement)), atol=1e-12)
    assert result.slip[1] < 1e-12
    assert result.suspect[1] == 0


@given(mounts=MOUNTS, order=st.randoms(use_true_random=False))
def test_the_order_of_the_mice_does_not_matter(mounts: list[Pose], order: object) -> None:
    rng = np.random.default_rng(3)
    told = ground.counts(ground.ways(ground.motion(rng, 0.5, 0.015), tuple(mounts)), rng)
    shuffled = list(range(len(mounts)))
    order.shuffle(shuffled)  # type: ignore[attr-defined]
    one = track(mounts, told, dt_s=0.015)
    other = track([mounts[k] for k in shuffled], told[:, shuffled], dt_s=0.015)
    np.testing.assert_allclose(one.pose, other.pose, atol=1e-12)


def test_rigid_motions_of_the_reference_come_out(shared_data: Path) -> None:
    """Keek's frame: x to the right, y ahead, heading clockwise; the vectors are in mm and degrees."""
    case = json.loads((shared_data / "paper_vectors.json").read_text())["seed002"]["localisation_rigid_motion"]
    x1, y1, x2, y2 = 1e-3 * np.array(case["increments"]).T
    told = np.stack([np.stack([y1, -x1], -1), np.stack([y2, -x2], -1)], axis=1)
    pose = track([Pose(0.0, 0.0, 0.0), Pose(1e-3 * case["D"], 0.0, 0.0)], told).pose[1:]
    found = np.stack([-1e3 * pose[:, 1], 1e3 * pose[:, 0], -np.degrees(pose[:, 2])], axis=-1)
    np.testing.assert_allclose(found, case["exact"], atol=1e-9)


@pytest.mark.parametrize("dt", [0.005, 0.015])
def test_counts_of_ten_micrometres_cost_hundredths_of_a_millimetre_in_half_a_minute(dt: float) -> None:
    """And the covariance says so: NEES per degree of freedom is about one."""
    rng, ends, nees = np.random.default_rng(1), [], []
    for _ in range(12):
        moves = ground.motion(rng, 30.0, dt)
        result = track(ground.PAIR, ground.counts(ground.ways(moves, ground.PAIR), rng), dt_s=dt, params=EXACT)
        error = result.pose[-1] - ground.path(moves)[-1]
        ends.append((math.hypot(*error[:2]), abs(error[2])))
        nees.append(error @ np.linalg.solve(result.covariance[-1], error) / 3.0)
        assert not result.suspect.any()
    distance, turn = np.median(ends, axis=0)
    assert distance < 0.02e-3
    assert turn < math.radians(0.01)
    assert 0.4 < np.mean(nees) < 2.0


def test_the_covariance_tells_relative_noise_too() -> None:
    rng, nees = np.random.default_rng(2), []
    robot = with_mice(ground.PAIR, noise=0.01)
    params = replace(EXACT, jump_factor=5.0)  # these motions are faster than that robot
    for _ in range(12):
        moves = ground.motion(rng, 10.0, 0.015)
        exact = ground.ways(moves, ground.PAIR)
        told = ground.counts(exact * (1.0 + 0.01 * rng.normal(size=exact.shape)), rng)
        result = track(robot, told, dt_s=0.015, params=params)
        assert not result.suspect.any()
        error = result.pose[-1] - ground.path(moves)[-1]
        nees.append(error @ np.linalg.solve(result.covariance[-1], error) / 3.0)
    assert 0.4 < np.mean(nees) < 2.0


def with_mice(mounts: tuple[Pose, ...], noise: float = 0.0) -> Robot:
    """The Mecanum robot with mice there."""
    mice = tuple(Mouse(f"m{k}", mount, noise_relative=noise) for k, mount in enumerate(mounts))
    return replace(robots.load("mecanum4"), mice=mice)


# --- health ---------------------------------------------------------------------------------------


def steady(mounts: tuple[Pose, ...], twist: tuple[float, float, float], seconds: float = 2.0) -> Array:
    """(N, k, 2) counts at a constant twist, every 15 ms."""
    rng = np.random.default_rng(7)
    moves = np.tile(0.015 * np.array(twist), (round(seconds / 0.015), 1))
    return ground.counts(ground.ways(moves, mounts), rng)


DIRECTIONS = [(0.03, 0.0, 0.0), (0.0, 0.03, 0.0), (-0.02, 0.02, 0.1), (0.01, 0.0, -0.3), (0.0, 0.0, 0.4)]


@pytest.mark.parametrize("twist", DIRECTIONS)
@pytest.mark.parametrize("lost", range(4))
def test_a_dead_mouse_of_four_is_left_out_within_a_fifth_of_a_second(
    twist: tuple[float, float, float], lost: int
) -> None:
    told = steady(ground.CORNERS, twist)
    told[66:, lost] = 0.0  # at 1 s
    result = track(ground.CORNERS, told, dt_s=0.015)
    assert not result.suspect[:67].any()
    assert (result.suspect[67 + 13 :] == 1 << lost).all()
    way = np.abs(result.pose[-1] - ground.path(np.tile(0.015 * np.array(twist), (len(told), 1)))[-1])
    assert math.hypot(*way[:2]) < 1e-3
    assert way[2] < 0.01


def test_a_mouse_that_comes_back_is_trusted_again_only_after_it_agreed_in_motion() -> None:
    told = steady(ground.CORNERS, (0.03, 0.01, 0.1), 4.0)
    told[66:133, 2] = 0.0
    told[133:180] = 0.0  # at rest all agree, which proves nothing
    suspect = track(ground.CORNERS, told, dt_s=0.015).suspect
    assert suspect[120] == 4
    assert (suspect[134:181] == 4).all()
    assert suspect[230] == 0


def test_a_mouse_with_a_stuck_axis_is_pardoned_ever_more_rarely() -> None:
    """Half a second along the sound axis is agreement, too: each relapse doubles how much of it is asked for."""
    leg = np.array([[0.03, 0.0, 0.0]] * 34 + [[0.0, 0.03, 0.0]] * 34)
    moves = 0.015 * np.tile(leg, (24, 1))
    exact = ground.ways(moves, ground.SQUARE)
    exact[:, 1, 0] = 0.0
    suspect = track(ground.SQUARE, ground.counts(exact, np.random.default_rng(0)), dt_s=0.015).suspect
    back = np.flatnonzero((suspect[:-1] == 2) & (suspect[1:] == 0))
    assert len(back) <= 5  # of 24 legs; one and the same time of trust gives 24
    assert np.mean(suspect[len(suspect) // 2 :] == 2) > 0.9


def test_a_mouse_that_was_sound_for_long_is_trusted_as_soon_as_ever() -> None:
    """One relapse is forgotten after half a minute of trust in motion."""
    told = steady(ground.SQUARE, (0.03, 0.01, 0.0), 75.0)
    for start in (100, 4700):
        told[start : start + 30, 2] = 0.0
    suspect = track(ground.SQUARE, told, dt_s=0.015).suspect
    first, second = (int(np.sum(suspect[start : start + 200] == 4)) for start in (100, 4700))
    assert first > 30
    assert abs(second - first) < 5


@pytest.mark.parametrize("twist", [(0.03, 0.01, 0.0), (0.02, 0.03, 0.1)])
def test_of_two_mice_in_doubt_the_covariance_says_how_wrong_the_pose_may_be(twist: tuple[float, float, float]) -> None:
    """And while the motion shows nothing, the doubt stays; it ends when both have agreed where they need not have."""
    told = np.concatenate([steady(ground.PAIR, twist, 4.0), steady(ground.PAIR, (0.0, 0.03, 0.0), 1.0)])
    sound, moves = told.copy(), np.tile(0.015 * np.array(twist), (266, 1))
    told[66:267, 1] = ground.counts(0.5 * told[66:267, 1:2], np.random.default_rng(0))[:, 0]
    one, other = track(ground.PAIR, told, dt_s=0.015), track(ground.PAIR, sound, dt_s=0.015)
    assert (one.suspect[80:266] == 3).any()
    error, said = one.pose[266] - ground.path(moves)[-1], np.sqrt(np.diag(one.covariance[266]))
    assert 0.1 < math.hypot(*error[:2]) / math.hypot(*said[:2]) < 5.0
    assert 0.1 < abs(error[2]) / said[2] < 5.0
    across = one.covariance[-1, 2, 2] - one.covariance[280, 2, 2]
    assert across > 100.0 * (other.covariance[-1, 2, 2] - other.covariance[280, 2, 2])
    agreed = np.concatenate([told, steady(ground.PAIR, (0.03, 0.0, 0.0), 2.0)])
    last = track(ground.PAIR, agreed, dt_s=0.015).covariance[:, 2, 2]
    assert last[-1] - last[-30] < 1e-6


@pytest.mark.parametrize("share", [0.3, 0.6])
def test_a_slipping_mouse_of_four_is_left_out(share: float) -> None:
    told = steady(ground.CORNERS, (0.03, 0.02, 0.1))
    told[66:, 1] = ground.counts(share * told[66:, 1:2], np.random.default_rng(0))[:, 0]
    suspect = track(ground.CORNERS, told, dt_s=0.015).suspect
    assert (suspect[66 + 27 :] == 2).all()


def test_one_reading_beyond_all_speed_of_the_robot_is_not_believed() -> None:
    robot = with_mice(ground.PAIR)
    told = steady(ground.PAIR, (0.03, 0.0, 0.0))
    told[60, 1, 1] += 0.02
    result = track(robot, told, dt_s=0.015)
    assert result.suspect[61] == 2
    assert abs(result.pose[-1, 2]) < 0.01


def test_two_mice_know_which_is_dead_only_in_motion_along_their_line() -> None:
    """Across the line a dead mouse looks like a turn; half a slip is told but nobody knows whose."""
    dead = steady(ground.PAIR, (0.03, 0.0, 0.0))
    dead[66:, 1] = 0.0
    assert (track(ground.PAIR, dead, dt_s=0.015).suspect[66 + 14 :] == 2).all()
    sideways = steady(ground.PAIR, (0.0, 0.03, 0.0))
    sideways[66:, 1] = 0.0
    result = track(ground.PAIR, sideways, dt_s=0.015)
    assert not result.suspect.any()
    assert abs(result.pose[-1, 2]) > 0.1
    half = steady(ground.PAIR, (0.03, 0.0, 0.0))
    half[66:, 1] *= 0.5
    result = track(ground.PAIR, half, dt_s=0.015)
    assert (result.suspect[66 + 14 :] == 3).all()
    # 30 and 15 mm/s along the line: two of four rows are some 7.5 mm/s from what both say
    assert result.slip[-1] == pytest.approx(0.0075 / math.sqrt(2.0), rel=0.1)


def test_one_mouse_alone_goes_on_with_a_growing_variance() -> None:
    told = steady(ground.PAIR, (0.03, 0.0, 0.0))
    told[66:, 1] = np.nan
    result = track(ground.PAIR, told, dt_s=0.015)
    assert result.suspect[-1] == 2
    assert np.isfinite(result.pose).all()
    assert result.pose[-1, 0] == pytest.approx(0.06, rel=0.05)
    assert result.covariance[-1, 2, 2] > 100.0 * result.covariance[66, 2, 2]


def test_a_mouse_that_is_not_read_does_not_disturb_three_that_are() -> None:
    rng = np.random.default_rng(5)
    moves = ground.motion(rng, 3.0, 0.015)
    told = ground.ways(moves, ground.CORNERS)
    told[50:90, 3] = np.nan
    result = track(ground.CORNERS, told, dt_s=0.015)
    np.testing.assert_allclose(result.pose, ground.path(moves), atol=1e-9)
    assert (result.suspect[51:91] == 8).all()
    assert not result.suspect[91:].any()


def test_mountings_that_are_a_little_wrong_raise_no_alarm() -> None:
    """1 degree, 1 mm and 1 % is what an uncalibrated robot has."""
    rng = np.random.default_rng(11)
    for mounts in (ground.PAIR, ground.CORNERS):
        real = tuple(Pose(*(np.array(m) + rng.normal(size=3) * [1e-3, 1e-3, math.radians(1.0)])) for m in mounts)
        exact = ground.ways(ground.motion(rng, 20.0, 0.015), real) * (1.0 + 0.01 * rng.normal(size=(len(mounts), 1)))
        assert not track(mounts, ground.counts(exact, rng), dt_s=0.015).suspect.any()


# --- in the loop ------------------------------------------------------------------------------------


def test_the_loop_and_a_recording_believe_the_same_to_the_last_bit() -> None:
    robot, rng = robots.load("mecanum4"), np.random.default_rng(2)
    told = ground.counts(ground.ways(ground.motion(rng, 1.0, 0.015), ground.PAIR), rng)
    whole = track(robot, told, START, dt_s=0.015)
    loop = estimation.estimator("mouse_odometry", robot)
    loop.reset(START)
    still = WheelState(np.full(4, np.nan), np.full(4, np.nan), np.zeros(0))
    for k in range(len(told) + 1):
        mice = told[k - 1] if k else np.zeros((2, 2))
        estimate = loop.step(Observation(0.015 * k, 0.015, still, mice=mice))
        assert tuple(estimate.pose) == tuple(whole.pose[k])
        assert estimate.suspect == whole.suspect[k]


def test_the_twist_is_filtered_with_the_time_constant_asked_for() -> None:
    robot = robots.load("mecanum4")
    for twist_s, share in ((0.0, 1.0), (0.03, 1.0 - math.exp(-0.5))):
        loop = estimation.KernelEstimator(MouseOdometry(twist_s=twist_s), robot)
        loop.reset(Pose(0.0, 0.0, 0.0))
        still = WheelState(np.full(4, np.nan), np.full(4, np.nan), np.zeros(0))
        for k in range(2):
            seen = Observation(0.015 * k, 0.015, still, mice=np.array([[3e-4, 0.0], [3e-4, 0.0]]))
            twist = loop.step(seen).twist
        assert twist.vx == pytest.approx(share * 0.02, rel=1e-9)


# --- what cannot be ---------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("mounts", "words"),
    [
        ((), "needs 2 mice, mecanum4 has 0"),
        ((Pose(0.0, 0.0, 0.0),), "needs 2 mice, mecanum4 has 1"),
        ((Pose(0.0, 0.0, 0.0), Pose(0.4, 0.0, 0.0)), "mouse m1 of mecanum4 lies 0.4 m .* outside its footprint"),
        ((Pose(0.05, 0.0, 0.0), Pose(0.05, 0.0, 1.0)), "in one place"),
    ],
)
@pytest.mark.parametrize("name", ["mouse_odometry", "mouse_printed", "mouse_corrected"])
def test_mice_that_cannot_be_right_are_refused_in_one_line(name: str, mounts: tuple[Pose, ...], words: str) -> None:
    with pytest.raises(InputError, match=words) as refused:
        estimation.plug(name).pack(with_mice(mounts))
    assert "\n" not in str(refused.value)


def test_parameters_and_increments_out_of_form_are_refused() -> None:
    with pytest.raises(InputError, match="twist_s = -1"):
        MouseOdometry(twist_s=-1.0)
    with pytest.raises(InputError, match=r"horizon_s = 0\.0 is not above 0"):
        MouseOdometry(horizon_s=0.0)
    with pytest.raises(InputError, match=r"shape \(5, 4\), expected \(N, 2, 2\)"):
        track(ground.PAIR, np.zeros((5, 4)))
    with pytest.raises(InputError, match="2 to 4 mice, 1 were given"):
        track([Pose(0.0, 0.0, 0.0)], np.zeros((5, 1, 2)))
