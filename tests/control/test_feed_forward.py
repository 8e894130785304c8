"""Laws of the tracker by second-order kinematics, and of the leads that it gives to actuators."""

import math
from dataclasses import replace

import numpy as np
import pytest

import holodrive as hd
from holodrive import control, layout, planning, references
from holodrive.actuators.lag import lag_factors
from holodrive.actuators.speed_loop import speed_loop_step
from holodrive.control import actuator_lead
from holodrive.control.feed_forward import FeedForward, feed_forward_kernel, steering_rate
from holodrive.kinematics import Chassis
from holodrive.kinematics import kernel as kinematics
from holodrive.robots.spec import Limits, PwmMap

DT = 0.01


@pytest.fixture(scope="module")
def swerve():
    return hd.load("swerve3")


def ready(**lags):
    """Actuators without lag, unless told otherwise."""
    return FeedForward(**{"drive_lag_s": 0.0, "steer_lag_s": 0.0, **lags})


def without_board(robot, **changes):
    """No loop around the drives: commands are duties."""
    return replace(robot, speed_loop=replace(robot.speed_loop, kp=0.0, ki=0.0), **changes)


def tick(plug, robot, pose=(0, 0, 0), twist=(0, 0, 0), reference=(0,) * 9, steer=None, last=False, memory=None):
    """Wheel speeds and steering angles of one tick."""
    n, m = len(robot.wheels), len(robot.steered)
    obs, command = np.zeros(layout.OBS_HEADER), np.zeros(layout.COMMAND_SIZE)
    obs[layout.DT], obs[layout.REF_LAST] = DT, float(last)
    obs[layout.POSE : layout.POSE + 3], obs[layout.TWIST : layout.TWIST + 3] = pose, twist
    obs[layout.REF_POSE : layout.REF_POSE + 9] = reference
    obs[layout.STEER : layout.STEER + m] = 0.0 if steer is None else steer
    memory = np.zeros(plug.memory_size(robot)) if memory is None else memory
    feed_forward_kernel(obs, memory, plug.pack(robot), command)
    return command[:n], command[layout.COMMAND_STEER : layout.COMMAND_STEER + m]


def spinning(table, turns):
    """A trajectory with a heading that turns evenly along the way, from rest to rest."""
    rows = table.rows.copy()
    speed = np.hypot(rows[:, 4], rows[:, 5])
    along = (rows[:, 4] * rows[:, 7] + rows[:, 5] * rows[:, 8]) / np.maximum(speed, 1e-9)
    way = np.concatenate([[0.0], np.cumsum(0.5 * (speed[1:] + speed[:-1]) * np.diff(rows[:, 0]))])
    share = 2.0 * math.pi * turns / way[-1]
    rows[:, 3], rows[:, 6], rows[:, 9] = share * way, share * speed, share * along
    return references.trajectory(rows[:, 0], rows[:, 1:4], rows[:, 4:7], rows[:, 7:10])


def tracked(robot, name, params, table, plant):
    out = hd.rollout(
        robot, None, name, params=params, n=1, reference=table, starts=table.rows[0, 1:4], t=table.duration_s,
        plant=plant, log_every=1, seed=1, stop_on_arrival=False,
    )  # fmt: skip
    # of what the robot believes: what odometry cannot know is no matter of the tracker
    error = np.hypot(out.column("est_x") - out.column("ref_x"), out.column("est_y") - out.column("ref_y"))[0]
    return out, error


# --- leads ---------------------------------------------------------------------------------------


@pytest.mark.parametrize("lag_s", [0.03, 0.7])
@pytest.mark.parametrize("loop", [(0.0, 0.0, 1.0), (0.5, 4.0, 1.0), (1.5, 15.0, 0.5)])
def test_the_lead_of_a_drive_undoes_its_lag_and_the_loop_of_its_board(lag_s, loop, swerve):
    """A wheel behind lag, loop and filter turns as wanted; the same command without lead leaves it behind."""
    kp, ki, ahead = loop
    robot = replace(swerve, speed_loop=replace(swerve.speed_loop, kp=kp, ki=ki, feed_forward=ahead, filter_s=0.03))
    kin, lead = kinematics.arrays(robot), actuator_lead.packed(robot, "stated", lag_s, 0.0)
    memory, out, decay = np.zeros(6), np.zeros(3), lag_factors(lag_s, DT)
    speed = shown = integral = worst = 0.0
    for k in range(600):
        t = (k + 0.5) * DT
        wanted, rate = 10.0 * (1.0 - math.cos(2.0 * t)), 20.0 * math.sin(2.0 * t)
        actuator_lead.lead_drives(kin, lead, DT, np.full(3, wanted), np.full(3, wanted + lag_s * rate), memory, out)
        duty, integral = speed_loop_step(out[0], shown, integral, 1e-3, kp, ki, DT, ahead)
        gap = speed - 1e3 * duty
        mean, speed = 1e3 * duty + gap * decay[1], 1e3 * duty + gap * decay[0]
        shown += (1.0 - lag_factors(0.03, DT)[0]) * (mean - shown)
        worst = max(worst, abs(mean - wanted))
    assert worst < 0.02  # of 20 rad/s


def test_a_spin_along_a_straight_line_needs_no_force(swerve):
    lead = actuator_lead.packed(swerve, "motors")
    vx, vy, omega = 1.0, -0.5, 2.0
    motion = np.array([vx, vy, omega, omega * vy, -omega * vx, 0.0])  # body components turn, the velocity does not
    np.testing.assert_allclose(actuator_lead.wrench(lead, motion), 0.0, atol=1e-12)


def test_the_wrench_is_that_of_the_centre_of_mass(swerve):
    robot = replace(swerve, centre_of_mass=(0.05, -0.02))
    lead = actuator_lead.packed(robot, "motors")
    turning = actuator_lead.wrench(lead, np.array([0.0, 0.0, 2.0, 0.0, 0.0, 0.0]))
    np.testing.assert_allclose(turning, (-20.0 * 4.0 * 0.05, 20.0 * 4.0 * 0.02, 0.0), atol=1e-12)
    spun = actuator_lead.wrench(lead, np.array([0.0, 0.0, 0.0, 0.0, 0.0, 3.0]))
    about = robot.inertia_kg_m2 + robot.mass_kg * (0.05**2 + 0.02**2)
    assert spun[2] == pytest.approx(3.0 * about)


def test_lags_are_the_measured_ones_then_the_librarys_then_those_of_the_motors(swerve):
    wheel = swerve.wheels[0]
    assert actuator_lead.drive_lag(swerve, wheel, "stated") == (wheel.motor.lag_s, 0.0)
    measured = replace(swerve, pwm_map=PwmMap((), lag_s=0.123))
    assert actuator_lead.drive_lag(measured, wheel, "stated") == (0.123, 0.0)
    lag, ease = actuator_lead.drive_lag(swerve, wheel, "motors")
    share = swerve.mass_kg / 3 * wheel.radius**2
    assert lag + ease * share == pytest.approx(0.768, abs=1e-3)


# --- kinematics ----------------------------------------------------------------------------------


@pytest.mark.parametrize("name", ["swerve3", "swerve4"])
def test_steering_rates_are_those_of_second_order_kinematics(name):
    robot = hd.load(name)
    chassis, kin = Chassis.of(robot), kinematics.arrays(robot)
    for motion in np.random.default_rng(1).uniform(-1.0, 1.0, size=(50, 6)):
        ours = [steering_rate(kin, kinematics.WHEELS + kinematics.BLOCK * i, motion) for i in range(len(robot.wheels))]
        theirs = chassis.inverse_acceleration(motion[:3], motion[3:]).steer
        np.testing.assert_allclose(ours, np.clip(theirs, -6.0, 6.0), rtol=1e-9, atol=1e-9)


@pytest.mark.parametrize("name", ["hybrid3", "mecanum4", "omni4"])
def test_without_lag_fixed_wheels_turn_as_the_inverse_of_the_reference_at_the_middle_of_the_tick(name):
    robot = without_board(hd.load(name))
    reference = np.array([0.0, 0.0, 0.0, 0.01, -0.005, 0.05, 0.1, 0.05, 0.2])
    speeds, _ = tick(replace(ready(), k=1e-9, k_theta=1e-9), robot, reference=reference, twist=(0.01, -0.005, 0.05))
    world = reference[3:6] + 0.5 * DT * reference[6:9]
    turn = 0.5 * DT * world[2]
    c, s = math.cos(turn), math.sin(turn)
    body = (c * world[0] + s * world[1], c * world[1] - s * world[0], world[2])
    np.testing.assert_allclose(speeds, Chassis.of(robot).inverse(body).speeds, rtol=1e-9)


def test_a_steering_is_told_its_angle_and_its_lag_times_its_rate(swerve):
    """A velocity that turns evenly: every module shall stand at d and is told d + lag d'."""
    reference = np.array([0, 0, 0, 1.0, 0.0, 0.0, 0.0, 1.5, 0.0])
    robot = without_board(swerve, limits=Limits())
    plain, lagging = (
        tick(ready(steer_lag_s=lag), robot, reference=reference, twist=(1.0, 0.0, 0.0))[1] for lag in (0.0, 0.05)
    )
    np.testing.assert_allclose(plain, 1.5 * 0.5 * DT, rtol=1e-3)
    np.testing.assert_allclose(lagging - plain, 0.05 * 1.5, rtol=1e-3)


def test_a_reversal_flips_the_drives_and_turns_no_module(swerve):
    forwards = np.array([0, 0, 0, 0.5, 0.0, 0.0, 0.0, 0.0, 0.0])
    plug, robot = ready(), without_board(swerve, limits=Limits())
    memory = np.zeros(plug.memory_size(robot))
    there, _ = tick(plug, robot, reference=forwards, twist=(0.5, 0, 0), memory=memory)
    back, steer = tick(plug, robot, reference=-forwards, twist=(-0.5, 0, 0), memory=memory)
    assert np.all(there > 0.0)
    assert np.all(back < 0.0)
    np.testing.assert_allclose(steer, 0.0, atol=1e-9)


def test_modules_keep_their_angles_at_a_reference_that_rests_and_turn_ahead_of_one_that_starts(swerve):
    steer = np.array([0.3, -0.4, 0.5])
    _, resting = tick(ready(), swerve, steer=steer, last=True)
    np.testing.assert_array_equal(resting, steer)
    starting = np.array([0, 0, 0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0])
    speeds, turned = tick(ready(), swerve, steer=steer, reference=starting)
    # towards +y, or -y, whichever is nearer, at the steering's rate
    np.testing.assert_allclose(turned - steer, np.array([1.0, -1.0, 1.0]) * 6.0 * DT, rtol=1e-9)
    assert np.abs(speeds).max() * 0.1 <= 1e-2 + 1e-9


def test_commands_stay_inside_the_wheels_limits_and_keep_the_direction(swerve):
    robot = without_board(swerve, limits=Limits())
    steer = tuple(Chassis.of(robot).inverse((30.0, 20.0, 5.0)).steer)
    for lags in ({}, {"drive_lag_s": 0.5}):
        reference = np.array([0, 0, 0, 30.0, 20.0, 5.0, 5.0, 0.0, 0.0])
        speeds, _ = tick(ready(**lags), robot, reference=reference, twist=(30, 20, 5), steer=steer)
        assert np.abs(speeds).max() <= robot.wheels[0].max_speed_rad_s * (1.0 + 1e-9)
    far = np.array([0, 0, 0, 30.0, 20.0, 5.0, 0.0, 0.0, 0.0])
    speeds, angles = tick(ready(), robot, reference=far, twist=(30, 20, 5), steer=steer)
    twist = Chassis.of(robot).forward(speeds, angles)
    turn = 5.0 * 0.5 * DT
    wanted = np.array([30.0 * math.cos(turn) + 20.0 * math.sin(turn), 20.0 * math.cos(turn) - 30.0 * math.sin(turn), 5])
    np.testing.assert_allclose(twist / np.linalg.norm(twist), wanted / np.linalg.norm(wanted), atol=5e-3)


def test_a_command_speeds_up_no_faster_than_the_base_may(swerve):
    speeds, _ = tick(ready(), without_board(swerve), reference=np.array([5.0, 0, 0, 0, 0, 0, 0, 0, 0]), last=True)
    assert speeds.max() * 0.1 == pytest.approx(3.0 * DT, rel=1e-6)


# --- runs ----------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("name", "plant", "params", "width_m", "speed_m_s"),
    [
        ("swerve3", "first_order", {}, 1.0, 0.8),
        ("swerve3", "slip", {"lags": "motors"}, 1.0, 0.8),
        ("swerve4", "first_order", {}, 1.0, 0.8),
        ("hybrid3_table_x", "first_order", {}, 0.2, 0.15),
        ("omni4", "first_order", {}, 0.1, 0.03),
    ],
)
def test_it_follows_a_lemniscate_while_spinning_far_closer_than_feedback_does(name, plant, params, width_m, speed_m_s):
    table = spinning(planning.follow(planning.lemniscate(width_m), speed_m_s, speed_m_s), 1)
    _, ours = tracked(name, "feed_forward", params, table, plant)
    _, theirs = tracked(name, "go_to_pose", {"k_xy": 4.0, "k_theta": 4.0}, table, plant)
    assert np.sqrt(np.mean(ours**2)) < 0.5 * np.sqrt(np.mean(theirs**2))


@pytest.mark.parametrize(("caster_m", "coupling"), [(0.005, 0.0), (0.03, 0.0), (0.03, 0.3)])
def test_trailing_modules_follow_as_closely(caster_m, coupling, swerve):
    """Short casters lean, long ones are powered: they go on from any angle."""
    wheels = tuple(
        replace(wheel, steering=replace(wheel.steering, caster_m=caster_m, coupling=coupling))
        for wheel in swerve.wheels
    )
    table = spinning(planning.follow(planning.lemniscate(1.0), 0.7, 0.7), 1)
    _, error = tracked(replace(swerve, wheels=wheels, text=""), "feed_forward", {}, table, "first_order")
    assert np.sqrt(np.mean(error**2)) < 2e-3


def test_a_straight_line_at_1_m_s_while_spinning_stays_within_1_mm_with_motor_dynamics_on():
    robot = hd.load("swerve3_motors")
    table = spinning(planning.follow(planning.line((0.0, 0.0), (4.0, 0.0)), 1.0, 1.0), 1.0)
    out, _ = tracked(robot, "feed_forward", {"lags": "motors"}, table, "motors")
    assert np.abs(out.column("y")).max() < 1e-3
    for wheel in robot.wheels:
        assert np.abs(out.column(f"command:{wheel.name}")).max() < wheel.max_speed_rad_s


def test_a_goal_is_reached_and_arrival_said():
    out = hd.rollout("swerve3", None, "feed_forward", n=1, goals=(2.0, -1.0, 2.0), t=15.0, seed=1)
    assert out.metrics["arrived"][0] == 1.0


def test_a_lag_below_zero_is_refused():
    with pytest.raises(hd.HolodriveError, match="drive_lag_s is"):
        control.plug("feed_forward", {"drive_lag_s": -0.1})
