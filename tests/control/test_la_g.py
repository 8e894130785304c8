"""LA-G: what its gains are, what saturation does to them, and which bases it drives."""

import json
import math
from dataclasses import replace

import numpy as np
import pytest

import holodrive as hd
from holodrive import control, geometry, planning
from holodrive.control import la_g
from holodrive.control.la_g import gains
from holodrive.errors import HolodriveError, InputError
from holodrive.kinematics import Chassis
from holodrive.types import Estimate, Observation, Pose, Reference, Twist, WheelState

ROBOT = hd.load("mecanum4")
RADIUS = ROBOT.wheels[0].radius
VARIANTS = tuple(la_g.VARIANTS)
ANGLES = np.radians(np.linspace(-400.0, 800.0, 4801))  # in steps of a quarter degree, over more than one turn
AHEAD = math.pi / 2.0  # the paper's robot looks along +Y


@pytest.fixture(scope="module")
def vectors(shared_data):
    return json.loads((shared_data / "paper_vectors.json").read_text())["seed002"]


def direction(g14, g23):
    """Travel in the paper's frame, x to the right and y ahead [rad], and its speed factor."""
    return np.arctan2(g14 + g23, g23 - g14), np.hypot(g14, g23)


def off_course(theta, variant):
    """Travel direction against the way to the target, theta + 180 deg [rad]."""
    return geometry.wrap(direction(*gains(theta, variant))[0] - theta - math.pi)


def tick(driver, pose, target, last=True):
    wheels = WheelState(np.full(4, math.nan), np.full(4, math.nan), np.zeros(0))
    estimate = Estimate(Pose(*pose), Twist(0.0, 0.0, 0.0), np.zeros((3, 3)))
    return driver.step(Reference(Pose(*target), last=last), estimate, Observation(0.0, 0.015, wheels))


def speeds(pose, target, robot=ROBOT, **params):
    """Wheel speeds [rad/s] of a fresh controller."""
    return np.array(tick(control.controller("la_g", robot, params), pose, target).command.speeds)


def kinematic_track(target, seconds=30.0, dt=0.015, **params):
    """(T, 2) positions of a robot that moves exactly as commanded, from (0, 0) with its heading along +Y."""
    driver, chassis = control.controller("la_g", ROBOT, params), Chassis.of(ROBOT)
    pose, track = np.array([0.0, 0.0, AHEAD]), []
    for _ in range(round(seconds / dt)):
        twist = chassis.forward(tick(driver, pose, target).command.speeds)
        pose = geometry.compose(pose, geometry.exp(np.asarray(twist) * dt))
        track.append(pose[:2])
    return np.array(track)


# --- the gains -----------------------------------------------------------------------------------


@pytest.mark.parametrize("variant", ["clean", "printed"])
def test_the_gains_are_those_of_the_reference_vectors(vectors, variant):
    for row in vectors["lag"]:
        expected = row[f"g14_{variant}"], row[f"g23_{variant}"]
        np.testing.assert_allclose(gains(math.radians(row["theta"]), variant), expected, atol=1e-12)


@pytest.mark.parametrize("variant", VARIANTS)
def test_the_compiled_gains_are_the_plain_ones(variant):
    compiled = [la_g.pair_gains(theta, la_g.VARIANTS[variant]) for theta in ANGLES]
    np.testing.assert_allclose(np.transpose(compiled), gains(ANGLES, variant), atol=1e-12)


@pytest.mark.parametrize("variant", VARIANTS)
def test_the_gains_repeat_after_a_turn_and_change_sign_after_half_a_one(variant):
    inside = ANGLES[~np.isclose(np.degrees(ANGLES) % 45.0, 0.0)]  # the printed ones jump there, either way
    np.testing.assert_allclose(gains(inside + 2.0 * math.pi, variant), gains(inside, variant), atol=1e-12)
    if variant != "printed":  # its pieces end at different gains
        np.testing.assert_allclose(gains(inside + math.pi, variant), np.negative(gains(inside, variant)), atol=1e-12)


def test_the_linear_gains_point_right_at_multiples_of_45_degrees_and_err_by_at_most_4_07_between():
    eighths = np.radians(45.0 * np.arange(-8, 17))
    np.testing.assert_allclose(off_course(eighths, "clean"), 0.0, atol=1e-12)
    fine = np.radians(np.linspace(0.0, 360.0, 36001))
    error = np.degrees(np.abs(off_course(fine, "clean")))
    assert error.max() == pytest.approx(4.07, abs=0.005)
    worst = np.degrees(fine[error > error.max() - 1e-6])
    from_diagonal = np.abs((worst % 90.0) - 45.0)
    np.testing.assert_allclose(from_diagonal, 21.5, atol=0.1)


def test_the_linear_gains_are_slower_off_the_diagonals():
    factor = direction(*gains(ANGLES, "clean"))[1]
    assert factor.min() == pytest.approx(math.sqrt(0.5), abs=1e-12)
    assert factor.max() == pytest.approx(1.0, abs=1e-12)


def test_the_cosine_gains_are_exact_at_constant_speed():
    np.testing.assert_allclose(off_course(ANGLES, "cosine"), 0.0, atol=1e-12)
    np.testing.assert_allclose(direction(*gains(ANGLES, "cosine"))[1], 1.0, atol=1e-12)


def test_the_printed_gains_are_the_clean_ones_but_for_0_0089_with_jumps_of_that_size():
    fine = np.radians(np.linspace(0.0, 360.0, 360001))
    clean, printed = np.array(gains(fine, "clean")), np.array(gains(fine, "printed"))
    assert np.abs(printed - clean).max() == pytest.approx(0.0089, abs=1e-4)
    for corner in (45.0, 135.0, 225.0, 315.0, 360.0):
        before, after = (np.array(gains(math.radians(corner + d), "printed")) for d in (-1e-9, 1e-9))
        np.testing.assert_allclose(np.abs(after - before), 0.0089, atol=1e-4)


def test_gains_of_a_nan_are_nan():
    for variant in VARIANTS:
        assert np.isnan(gains(math.nan, variant)).all()
        assert np.isnan(la_g.pair_gains(math.nan, la_g.VARIANTS[variant])).all()


# --- the worked example --------------------------------------------------------------------------


def test_the_worked_example_comes_out_but_for_its_misprints(vectors):
    """Equations 17 to 30: target (-14, -14), Kp 2. The gains of wheels 1 and 4 times the output are misprinted twice:
    -10.95 stands for -6.26 (its digits belong to 0.42, not 0.24) and 5.01 for 5.10; alpha at k = 2 is 26.57, not 26.7.
    """
    target = np.array([-14.0, -14.0])
    for row in vectors["example_eq17_30"]:
        away = target - row["p"]
        alpha = math.degrees(math.atan2(*(-away[::-1])))
        theta = row.get("theta_printed", row.get("theta"))
        g14, g23 = gains(math.radians(theta), "printed")
        error = math.hypot(*away)
        assert error == pytest.approx(row["e"], abs=1e-9)
        assert alpha == pytest.approx(row.get("alpha_exact", row.get("alpha")), abs=1e-9)
        if row["k"] == 0:
            assert 2.0 * error == pytest.approx(row["CO_printed"], abs=0.005)
            assert (2.0 * error * g14, 2.0 * error * g23) == pytest.approx((0.0, -39.6), abs=0.005)
            continue
        rounded = round(float(g14), 2), round(float(g23), 2)
        assert rounded == (row["g14_printed_rounded"], row["g23_printed_rounded"])
        output = round(2.0 * round(error, 2), 2)
        assert round(output * rounded[0], 2) == row["M14_correct_rounded"] != row["M14_printed_WRONG"]
        assert round(output * rounded[1], 2) == row["M23"]
        assert 2.0 * error * g14 == pytest.approx(row["M14_unrounded"], abs=1e-4)


def test_the_controller_does_the_worked_example(vectors):
    """In the loop, in millimetres: the same M at the wheels, front right and rear left being W1W4."""
    for row in vectors["example_eq17_30"]:
        pose = (*(1e-3 * np.array(row["p"])), AHEAD - math.radians(row["heading"]))
        target = (-0.014, -0.014, pose[2])  # the heading's own loop has no say in the example
        rim = 1e3 * RADIUS * speeds(pose, target, variant="printed", max_speed_m_s=0.042) / math.sqrt(2.0)
        away = np.array([-14.0, -14.0]) - row["p"]
        theta = math.atan2(*(-away[::-1])) + math.radians(row["heading"])
        g14, g23 = gains(theta, "printed")
        m14, m23 = 2.0 * row["e"] * g14, 2.0 * row["e"] * g23
        np.testing.assert_allclose(rim, (m23, m14, m14, m23), atol=1e-9)  # fl, fr, rl, rr


# --- saturation ----------------------------------------------------------------------------------


def test_common_scaling_keeps_the_direction_and_pair_clipping_does_not():
    """Distance to the path of a step of 150 mm at 22.5 deg, driven exactly as commanded."""
    target = (-0.15 * math.cos(math.pi / 8.0), -0.15 * math.sin(math.pi / 8.0), AHEAD)

    def stray(**params):
        x, y = kinematic_track(target, **params).T
        return 1e3 * np.abs(x * target[1] - y * target[0]).max() / 0.15

    assert stray(saturation="pairs") == pytest.approx(21.4, abs=0.15)
    assert stray(saturation="common") == pytest.approx(3.9, abs=0.05)
    assert stray(saturation="common", variant="cosine") == pytest.approx(0.0, abs=1e-9)


@pytest.mark.parametrize("variant", VARIANTS)
def test_no_diagonal_is_driven_faster_than_its_limit(variant):
    for theta in ANGLES[::40]:
        target = (math.cos(theta), math.sin(theta), 0.0)
        for saturation in ("common", "pairs"):
            fast = speeds((0.0, 0.0, 0.0), target, variant=variant, saturation=saturation)
            assert np.abs(fast).max() == pytest.approx(math.sqrt(2.0) * 0.037 / RADIUS, rel=0.42)
            assert np.abs(fast).max() <= math.sqrt(2.0) * 0.037 / RADIUS * (1.0 + 1e-12)


def test_a_slower_wheel_lowers_the_limit():
    slow = replace(ROBOT, wheels=(*ROBOT.wheels[:3], replace(ROBOT.wheels[3], max_speed_rad_s=0.5)))
    fast = speeds((0.0, 0.0, 0.0), (0.0, -1.0, 0.0), robot=slow, variant="cosine")
    assert np.abs(fast).max() == pytest.approx(0.5)


# --- heading first -------------------------------------------------------------------------------


def test_above_the_dead_band_only_the_heading_is_corrected():
    """Left pair against right pair, 1 mm/s of diagonal speed for each degree."""
    turning = speeds((0.0, 0.0, math.radians(-3.0)), (0.1, 0.05, 0.0))
    rim = 1e-3 * 3.0 * math.sqrt(2.0) / RADIUS
    np.testing.assert_allclose(turning, (-rim, rim, -rim, rim), rtol=1e-9)  # fl, fr, rl, rr
    twist = Chassis.of(ROBOT).forward(turning)
    np.testing.assert_allclose(twist[:2], 0.0, atol=1e-12)
    assert twist[2] > 0.0


def test_the_dead_band_has_a_hysteresis():
    driver = control.controller("la_g", ROBOT, {"dead_band_rad": 0.02, "hysteresis_rad": 0.005})

    def turns(off):
        return bool(
            abs(Chassis.of(ROBOT).forward(tick(driver, (0.0, 0.0, off), (0.1, 0.0, 0.0)).command.speeds)[2]) > 1e-9
        )

    assert [turns(off) for off in (0.016, 0.019, 0.021, 0.019, 0.016, 0.014, 0.016, -0.021)] == [
        *(False, False, True, True, True, False, False, True)
    ]


def test_without_a_dead_band_any_error_of_heading_suspends_the_position():
    """As printed: position is resumed when the heading controller's output is 0."""
    for off in (1e-6, -0.001, 0.5):
        twist = Chassis.of(ROBOT).forward(speeds((0.0, 0.0, off), (0.1, 0.0, 0.0), dead_band_rad=0.0))
        np.testing.assert_allclose(twist[:2], 0.0, atol=1e-12)
        assert twist[2] * off < 0.0
    moving = Chassis.of(ROBOT).forward(speeds((0.0, 0.0, 0.0), (0.1, 0.0, 0.0), dead_band_rad=0.0))
    assert moving[0] > 0.0


# --- frames and bases ----------------------------------------------------------------------------


@pytest.mark.parametrize("variant", VARIANTS)
def test_turning_the_world_with_robot_and_target_changes_nothing(variant):
    rng = np.random.default_rng(7)
    for _ in range(50):
        pose, shift = rng.uniform(-1.0, 1.0, (2, 3))
        target = geometry.compose(pose, [*rng.uniform(-0.05, 0.05, 2), 0.01])
        here = speeds(pose, target, variant=variant)
        there = speeds(geometry.compose(shift, pose), geometry.compose(shift, target), variant=variant)
        np.testing.assert_allclose(there, here, atol=1e-9)


def test_other_names_orders_and_signs_of_the_wheels_drive_the_same_way():
    fl, fr, rl, rr = ROBOT.wheels
    backwards = replace(fl, name="d", yaw=math.pi)  # positive speed drives it back; the same roller on the ground
    other = replace(ROBOT, wheels=(replace(rr, name="a"), replace(fr, name="b"), replace(rl, name="c"), backwards))
    for target in ((0.01, 0.004, 0.0), (-0.01, 0.02, 0.0), (0.0, -0.01, 0.0), (0.0, 0.0, 0.1)):
        usual = speeds((0.0, 0.0, 0.0), target)
        s_rr, s_fr, s_rl, s_fl = speeds((0.0, 0.0, 0.0), target, robot=other)
        np.testing.assert_allclose((-s_fl, s_fr, s_rl, s_rr), usual, atol=1e-12)


@pytest.mark.parametrize("name", ["mecanum4", "polimi_mecanum4"])
def test_the_catalogs_mecanum_bases_are_driven(name):
    chassis = Chassis.of(hd.load(name))
    twist = chassis.forward(speeds((0.0, 0.0, 0.0), (0.0, 0.01, 0.0), robot=hd.load(name), variant="cosine"))
    np.testing.assert_allclose(twist, (0.0, 0.02, 0.0), atol=1e-9)


@pytest.mark.parametrize("name", ["hybrid3", "omni4", "swerve4", "omni3"])
def test_other_bases_are_refused_in_one_line(name):
    """The line names the robot, what its wheels are, and what to drive it with."""
    with pytest.raises(InputError, match="four Mecanum wheels") as caught:
        control.controller("la_g", hd.load(name))
    assert "\n" not in str(caught.value)
    assert name in str(caught.value)
    assert "go_to_pose" in str(caught.value)


@pytest.mark.parametrize(
    ("params", "message"),
    [
        ({"variant": "linear"}, "allowed: clean, printed, cosine"),
        ({"saturation": "none"}, "allowed: common, pairs"),
        ({"kp": 0.0}, "above 0"),
        ({"dead_band_rad": -1.0}, "0 or more"),
        ({"max_speed_m_s": math.nan}, "NaN"),
        ({"dead_band": 1.0}, "no parameter"),
    ],
)
def test_parameters_that_cannot_be_are_refused(params, message):
    with pytest.raises(HolodriveError, match=message):
        control.controller("la_g", ROBOT, params)
    with pytest.raises(InputError, match="allowed: clean"):
        gains(0.0, "linear")


# --- driving -------------------------------------------------------------------------------------


@pytest.mark.parametrize("variant", VARIANTS)
def test_a_step_is_reached_from_every_side(variant):
    for angle in np.radians((0.0, 40.0, 100.0, 200.0, 300.0)):
        goal = (0.1 * math.cos(angle), 0.1 * math.sin(angle), 0.0)
        run = hd.drive(hd.simulate(ROBOT, seed=1), "la_g", goal=goal, params={"variant": variant}, duration_s=20.0)
        assert run.ended == "arrived"
        assert run.metrics["final_error_m"] < 0.003


def test_a_ramp_is_followed_at_the_distance_that_its_gain_says():
    """V / (kp |g|) behind the target: 14.1 mm ahead with the linear gains, 10 mm with the exact ones."""
    reference = planning.follow(planning.line((0.0, 0.0), (0.3, 0.0)), 0.02)
    for variant, factor in (("clean", math.sqrt(0.5)), ("cosine", 1.0)):
        run = hd.drive(hd.simulate(ROBOT, seed=1), "la_g", trajectory=reference, params={"variant": variant})
        late = np.hypot(*(run.reference - run.pose)[np.searchsorted(run.time, 12.0), :2])
        assert late == pytest.approx(0.02 / (2.0 * factor), rel=0.05)


@pytest.mark.parametrize(("name", "plant"), [("mecanum4", "first_order"), ("mecanum4_mice", "pwm_map")])
def test_the_roll_out_drives_the_same_ramp(name, plant):
    """With encoders, and with measured actuators and two mice; the start asks for a turn first."""
    reference = planning.follow(planning.line((0.0, 0.0), (-0.03, -0.06)), 0.02, heading_rad=AHEAD)
    params, start, robot = {"variant": "printed"}, (0.0, 0.0, AHEAD - 0.03), hd.load(name)
    base = hd.simulate(robot, seed=4, start=start, plant=plant)
    run = hd.drive(base, "la_g", trajectory=reference, params=params, duration_s=4.0, stop_on_arrival=False)
    rolled = hd.rollout(
        robot, None, "la_g", params=params, reference=reference, starts=start, seed=4, t=4.0, log_every=1, plant=plant
    )
    np.testing.assert_allclose(rolled.log[0, : len(run.time), 1:4], run.pose, atol=1e-9)
    assert abs(run.pose[-1, 2] - AHEAD) < 0.02
