"""The plant of measured actuators: steady speeds of the printed cubics, dead zone, dead time, lag, and its noise."""

import math
from dataclasses import replace

import numpy as np
import pytest

import holodrive as hd
from holodrive import estimation, references, robots
from holodrive.control.go_to_pose import GoToPose
from holodrive.control.kernel import KernelController
from holodrive.errors import InputError
from holodrive.estimation.kernel import KernelEstimator
from holodrive.kinematics import Chassis
from holodrive.kinematics.pipeline import CommandPipeline
from holodrive.robots.spec import Encoder
from holodrive.sim import SimBase
from holodrive.types import DutyCommand, Pose, WheelCommand
from holodrive.worlds.spec import Goal, World

CUBICS = {  # Keek et al., eq. 9 to 12: (pair, way) -> c3, c2, c1, c0 of PWM over the pair's speed in mm/s
    ("w1w4", 1): (0.0056, -0.1603, 2.8629, 43.4929),
    ("w1w4", -1): (0.0077, -0.2702, 4.0447, 43.4521),
    ("w2w3", 1): (0.0061, -0.2335, 3.4245, 53.9554),
    ("w2w3", -1): (0.0055, -0.1041, 1.7440, 54.96069),
}
WHEELS = {"w1w4": (1, 2), "w2w3": (0, 3)}  # of fl, fr, rl, rr
RAD_S = 1e-3 * math.sqrt(2.0) / 0.03  # wheel speed for 1 mm/s of the pair
DT = 1e-3  # s, physics step


def quiet(**changes):
    """The paper's robot without dead time, spread and noise; one control period is one physics step."""
    robot = robots.load("mecanum4_mice")
    still = {"dead_time_s": 0.0, "dead_time_spread_s": 0.0, "speed_spread": 0.0, "speed_noise": 0.0}
    return replace(robot, control_period_s=DT, pwm_map=replace(robot.pwm_map, **(still | changes)))


def pair_duty(pair, pwm):
    return tuple(pwm / 255 if i in WHEELS[pair] else 0.0 for i in range(4))


def speeds_of(robot, duties, *, seed=0):
    """(ticks, 4) true wheel speeds after each control period of a run of duties (4,) or of one number for all."""
    base, rows = SimBase(robot, plant="pwm_map", seed=seed, dt_s=DT), []
    for duty in duties:
        base.apply(DutyCommand(tuple(np.broadcast_to(duty, 4).tolist())))
        rows.append(base.true_wheel_speeds)
    return np.array(rows)


def root(pair, way, pwm):
    """Speed of the pair [mm/s] at a PWM, by the eigenvalues of the companion matrix."""
    c3, c2, c1, c0 = CUBICS[pair, way]
    roots = np.roots([c3, c2, c1, c0 - pwm])
    return float(roots[np.abs(roots.imag) < 1e-9].real[0])


@pytest.mark.parametrize(("pair", "way"), CUBICS)
@pytest.mark.parametrize("pwm", [60, 100, 170, 255])
def test_the_steady_speed_at_a_held_duty_is_the_inverse_of_the_printed_cubic(pair, way, pwm):
    """The pair that is driven turns, the other stands, and the base moves along the pair's diagonal at that speed."""
    robot = quiet()
    base = SimBase(robot, plant="pwm_map", dt_s=DT)
    for _ in range(2000):
        base.apply(DutyCommand(pair_duty(pair, way * pwm)))
    mm_s = way * root(pair, way, pwm)
    wanted = [mm_s * RAD_S if i in WHEELS[pair] else 0.0 for i in range(4)]
    assert base.true_wheel_speeds == pytest.approx(wanted, rel=1e-9)
    left = 1.0 if pair == "w1w4" else -1.0
    assert tuple(base.true_twist) == pytest.approx(
        (1e-3 * mm_s / math.sqrt(2.0), left * 1e-3 * mm_s / math.sqrt(2.0), 0.0), abs=1e-12
    )


def test_forward_and_backward_differ():
    """At a PWM of 100 the second pair is 3.5 mm/s slower backward."""
    forward, backward = (abs(speeds_of(quiet(), [way * 100 / 255] * 2000)[-1, 0]) / RAD_S for way in (1, -1))
    assert forward == pytest.approx(root("w2w3", 1, 100))
    assert backward == pytest.approx(root("w2w3", -1, 100))
    assert forward - backward > 3.0


@pytest.mark.parametrize(("pair", "way"), CUBICS)
def test_the_dead_zone_gives_no_motion_and_the_next_count_does(pair, way):
    first = math.ceil(CUBICS[pair, way][3])
    rests = speeds_of(quiet(), [pair_duty(pair, way * (first - 1))] * 500)
    moves = speeds_of(quiet(), [pair_duty(pair, way * first)] * 500)
    assert not rests.any()
    assert np.all(way * moves[-1, list(WHEELS[pair])] > 0.0)


def test_the_driver_takes_whole_counts():
    base = SimBase(quiet(), plant="pwm_map", dt_s=DT)
    for duty in (0.123456, -0.5, 0.999, 1.7):
        base.apply(DutyCommand((duty,) * 4))
        assert np.allclose(base.duty * 255, np.round(255 * np.clip(duty, -1, 1)), atol=1e-12)


def test_speed_follows_its_lag_exactly():
    lag = quiet().pwm_map.lag_s
    speeds = speeds_of(quiet(), [150 / 255] * 300)
    time = DT * np.arange(1, 301)
    end = np.array([root("w2w3" if i in WHEELS["w2w3"] else "w1w4", 1, 150) * RAD_S for i in range(4)])
    assert np.allclose(speeds, end * (1.0 - np.exp(-time / lag))[:, None], rtol=1e-9)


@pytest.mark.parametrize("dead", [0.02, 0.04, 0.08])
def test_a_start_out_of_standstill_waits_for_the_dead_time(dead):
    speeds = speeds_of(quiet(dead_time_s=dead), [0.0] * 30 + [150 / 255] * 300)
    free = speeds_of(quiet(), [150 / 255] * 300)
    steps = round(dead / DT)
    assert not speeds[: 30 + steps].any()
    assert np.allclose(speeds[30 + steps :], free[: 300 - steps], rtol=1e-12)


def test_a_reversal_coasts_for_the_dead_time_and_then_turns_round():
    """While it waits nothing drives the wheel: its speed dies away with the lag."""
    dead, lag = 0.04, quiet().pwm_map.lag_s
    speeds = speeds_of(quiet(dead_time_s=dead), [150 / 255] * 2000 + [-150 / 255] * 300)[:, 0]
    start, after = speeds[1999], speeds[2000:]
    coasting = start * np.exp(-DT * np.arange(1, 301) / lag)
    steps = round(dead / DT)
    assert np.allclose(after[:steps], coasting[:steps], rtol=1e-9)
    target = -root("w2w3", -1, 150) * RAD_S
    driven = target + (after[steps - 1] - target) * np.exp(-DT * np.arange(1, 301 - steps) / lag)
    assert np.allclose(after[steps:], driven, rtol=1e-9)


def test_a_change_of_speed_without_reversal_has_no_dead_time():
    """Faster, slower, and after a moment without duty in which the wheel still coasts."""
    duties = [100 / 255] * 2000 + [150 / 255] * 200 + [80 / 255] * 200 + [0.0] * 20 + [100 / 255] * 200
    waits, free = speeds_of(quiet(dead_time_s=0.08), duties), speeds_of(quiet(), duties)
    assert not waits[:80].any()
    assert np.allclose(waits[1990:], free[1990:], rtol=1e-9)


def test_a_wheel_that_stood_waits_anew():
    """The second start of a wheel that came to rest waits as long as the first."""
    duties = [100 / 255] * 500 + [0.0] * 1000 + [100 / 255] * 200
    speeds = speeds_of(quiet(dead_time_s=0.05), duties)[:, 1]
    rest = speeds[1499]
    assert abs(rest) < 1e-8
    again = speeds[1500:]
    assert np.all(np.abs(again[:50]) <= abs(rest))
    assert again[50] > 1e-3


def test_the_dead_time_has_its_mean_and_spread_from_start_to_start():
    robot = quiet(dead_time_s=0.04, dead_time_spread_s=0.01)
    waits = [(speeds_of(robot, [150 / 255] * 120, seed=seed) == 0.0).sum(axis=0) * DT for seed in range(100)]
    assert np.mean(waits) == pytest.approx(0.04, abs=0.002)  # 400 starts: standard error 0.5 ms
    assert np.std(waits) == pytest.approx(0.01, abs=0.002)


@pytest.mark.parametrize("volts", [10.2, 11.0, 12.2, 14.2])
def test_duty_counts_in_proportion_to_the_voltage_of_the_battery(volts):
    """Keek et al.: 12.2 +- 2 V. A lower battery is a lower duty, and a wider dead zone."""
    robot = quiet()
    other = replace(robot, battery=replace(robot.battery, voltage_v=volts))
    found = speeds_of(other, [150 / 255] * 2000)[-1, 1]
    assert found == pytest.approx(root("w1w4", 1, 150 * volts / 12.2) * RAD_S, rel=1e-9)
    first = math.ceil(43.4929 * 12.2 / volts)
    assert speeds_of(other, [(first - 1) / 255] * 100)[-1, 1] == 0.0
    assert speeds_of(other, [first / 255] * 100)[-1, 1] > 0.0


@pytest.mark.parametrize("mm_s", [-36.0, -20.0, -5.0, -0.5, 0.5, 5.0, 20.0, 36.0])
def test_the_linearizer_before_the_plant_is_the_identity_up_to_one_count(mm_s):
    """Without encoders: the wheel speed that is commanded comes out, as far as whole counts allow."""
    robot = quiet()
    base = SimBase(robot, plant="pwm_map", dt_s=DT)
    for _ in range(2000):
        base.apply(WheelCommand((mm_s * RAD_S,) * 4))
    for pair, members in WHEELS.items():
        c3, c2, c1, c0 = CUBICS[pair, 1 if mm_s > 0 else -1]

        def pwm(v, c=(c3, c2, c1, c0)):
            return np.polyval(c, v)

        for i in members:
            found = abs(base.true_wheel_speeds[i]) / RAD_S
            assert math.copysign(1.0, mm_s) * base.true_wheel_speeds[i] >= 0.0
            if found == 0.0:  # the count below the dead zone
                assert pwm(abs(mm_s)) - c0 < 0.5 + 1e-9
            else:
                assert abs(pwm(found) - pwm(abs(mm_s))) <= 0.5 + 1e-9


def test_without_a_linearizer_the_board_takes_duty_as_proportional_to_speed():
    robot = replace(quiet(), linearizer=None)
    base = SimBase(robot, plant="pwm_map", dt_s=DT)
    base.apply(WheelCommand((1.0,) * 4))
    no_load = robot.wheels[0].motor.no_load_speed_rad_s
    assert np.allclose(base.duty, np.round(255 / no_load) / 255)


def test_encoders_take_away_what_the_linearizer_does_not_know():
    """A battery at 11 V: feed-forward alone is slow, the speed loop of a robot with encoders brings the speed."""
    robot = quiet()
    low = replace(robot, battery=replace(robot.battery, voltage_v=11.0), control_period_s=0.015)
    fine = Encoder(1e6)
    looped = replace(low, wheels=tuple(replace(w, encoder=fine) for w in low.wheels))
    ends = []
    for each in (low, looped):
        base = SimBase(each, plant="pwm_map", dt_s=DT)
        for _ in range(400):
            base.apply(WheelCommand((25.0 * RAD_S,) * 4))
        ends.append(base.true_wheel_speeds / RAD_S)
    assert np.all(ends[0] < 24.0)
    assert np.all(np.abs(ends[1] - 25.0) < 0.6)  # one count


def test_wheels_do_not_slip():
    """The body's twist is that of its wheels, turned by however much they are."""
    robot = quiet()
    base = SimBase(robot, plant="pwm_map", dt_s=DT)
    for _ in range(500):
        base.apply(DutyCommand((0.9, -0.5, 0.4, 0.7)))
    twist = Chassis.of(robot).forward(base.true_wheel_speeds)
    assert tuple(base.true_twist) == pytest.approx(tuple(twist), abs=1e-12)


def test_a_wheel_keeps_its_deviation_and_another_seed_gives_another():
    """Spread: the same at every speed of one run, zero on average, of the size that is said."""
    robot = quiet(speed_spread=0.02)
    clean = speeds_of(quiet(), [150 / 255] * 600)[-1]

    def deviation(seed, pwm=150, nominal=clean):
        return speeds_of(robot, [pwm / 255] * 600, seed=seed)[-1] / nominal - 1.0

    other = speeds_of(quiet(), [200 / 255] * 600)[-1]
    assert np.allclose(deviation(1), deviation(1, 200, other), rtol=1e-6)
    all_of_them = np.array([deviation(seed) for seed in range(60)])
    assert abs(all_of_them.mean()) < 0.005  # 240 wheels: standard error 0.0013
    assert all_of_them.std() == pytest.approx(0.02, abs=0.003)


def test_noise_is_new_in_every_control_period_and_the_same_for_the_same_seed():
    robot = quiet(speed_noise=0.02, lag_s=0.0)
    one, again, other = (speeds_of(robot, [150 / 255] * 1000, seed=seed) for seed in (3, 3, 4))
    assert np.array_equal(one, again)
    assert not np.any(one == other)
    nominal = speeds_of(quiet(lag_s=0.0), [150 / 255] * 2)[-1]
    part = one / nominal - 1.0
    assert part.std(axis=0) == pytest.approx([0.02] * 4, abs=0.0025)
    lagged = np.corrcoef(part[:-1, 0], part[1:, 0])[0, 1]
    assert abs(lagged) < 0.1
    assert abs(np.corrcoef(part[:, 0], part[:, 1])[0, 1]) < 0.1


AWAY = World("away", goal=Goal(Pose(0.06, 0.03, 0.2), heading_matters=True))


@pytest.mark.parametrize(("name", "estimator"), [("mecanum4", "wheel_odometry"), ("mecanum4_mice", "mouse_odometry")])
def test_the_ordinary_loop_and_the_roll_out_are_one_trajectory(name, estimator):
    """Through pauses, starts and reversals: to a goal, with all noise on."""
    robot, ticks = robots.load(name), 200
    base = SimBase(robot, AWAY, plant="pwm_map", seed=9)
    controller, believer = KernelController(GoToPose(), robot), KernelEstimator(estimation.plug(estimator), robot)
    pipeline, follower = CommandPipeline(robot), references.ReferenceFollower(references.fixed_goal(AWAY.goal.pose))
    believer.reset(base.truth)
    rows = []
    for _ in range(ticks):
        seen = base.observe()
        belief = believer.step(seen)
        rows.append((*base.truth, *belief.pose))
        command = controller.step(follower.step(seen.time, belief.pose), belief, seen).command
        base.apply(pipeline.step(command, seen.dt))
    seconds = ticks * robot.control_period_s
    out = hd.rollout(robot, AWAY, GoToPose(), estimator=estimator, t=seconds, plant="pwm_map", seed=9, log_every=1)
    assert np.allclose(out.log[0, :, 1:7], rows, atol=1e-9)
    assert np.allclose(out.pose[0], base.truth, atol=1e-9)
    assert np.hypot(*out.pose[0][:2]) > 0.03  # it went there


def test_a_batch_does_not_depend_on_its_workers_or_its_cuts():
    robot = robots.load("mecanum4_mice")

    def run(**options):
        return hd.rollout(robot, AWAY, estimator=None, plant="pwm_map", seed=5, t=1.0, **options)

    one = run(n=8, workers=1)
    assert np.array_equal(run(n=8, workers=3).state, one.state, equal_nan=True)
    assert np.array_equal(run(n=3, first=4).state, one.state[4:7], equal_nan=True)
    assert len(np.unique(one.pose[:, 0])) == 8  # each robot has its own noise


def test_a_robot_whose_actuators_nobody_measured_is_refused():
    with pytest.raises(InputError, match=r"omni3 has no \[pwm_map\].*add one to its file"):
        SimBase(robots.load("omni3"), plant="pwm_map")
