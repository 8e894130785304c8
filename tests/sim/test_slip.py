"""The plant with slip: laws of mechanics, and the checks that came with its equations."""

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from machines import FREE_SPEED, SLIPPERY, hybrid, mecanum, swerve, with_motor

from holodrive.errors import InputError
from holodrive.kinematics import Chassis
from holodrive.robots.spec import Battery, Ground
from holodrive.sim import SimBase
from holodrive.sim import state as rows
from holodrive.sim.loads import GRAVITY, wheel_loads
from holodrive.types import DutyCommand, WheelCommand


def set_moving(base, twist, wheels):
    base._state[rows.TWIST : rows.TWIST + 3] = twist
    base._state[rows.WHEEL_SPEED : rows.WHEEL_SPEED + len(wheels)] = wheels


def energy(base):
    """Kinetic energy of body and wheels, and that of the currents' magnetic fields [J]."""
    robot, twist = base.robot, base.true_twist
    cx, cy = robot.centre_of_mass
    vx, vy = twist.vx - twist.omega * cy, twist.vy + twist.omega * cx
    body = 0.5 * robot.mass_kg * (vx**2 + vy**2) + 0.5 * robot.inertia_kg_m2 * twist.omega**2
    spin = 0.5 * np.array([w.motor.inertia_kg_m2 for w in robot.wheels]) @ base.true_wheel_speeds**2
    currents = base._state[rows.CURRENT : rows.CURRENT + len(robot.wheels)]
    return body + spin + 0.5 * np.array([w.motor.inductance_h for w in robot.wheels]) @ currents**2


number = st.floats(-1.0, 1.0)


@settings(max_examples=40)
@given(
    st.sampled_from([hybrid, mecanum, swerve]),
    st.booleans(),
    st.sampled_from([1e-3, 5e-3, 2e-2]),
    st.tuples(number, number, number),
    st.lists(number, min_size=4, max_size=4),
    st.tuples(number, number),
    st.floats(0.0, 1.0),
)
def test_a_passive_base_never_gains_energy(machine, braked, dt, twist, wheels, centre, friction):
    """Duty zero: braked by its shorted motors, or rolling freely with the motors unplugged and without friction."""
    robot = replace(
        machine(control_period_s=0.02),
        centre_of_mass=(0.04 * centre[0], 0.04 * centre[1]),
        ground=Ground(friction=friction, roller_resistance=0.02 * friction),
    )
    if not braked:
        robot = with_motor(robot, back_emf_v_s_rad=0.0, coulomb_friction_n_m=0.0)
    base = SimBase(robot, None, plant="slip", dt_s=dt)
    set_moving(base, (2.0 * twist[0], 2.0 * twist[1], 8.0 * twist[2]), 30.0 * np.array(wheels[: len(robot.wheels)]))
    stopped = DutyCommand((0.0,) * len(robot.wheels), (0.0,) * len(robot.steered))
    last = energy(base)
    for _ in range(50):
        base.apply(stopped)
        now = energy(base)
        assert now <= last * (1.0 + 1e-12) + 1e-15
        last = now


def test_without_ground_friction_the_centre_of_mass_goes_straight_and_keeps_its_energy():
    robot = hybrid(ground=Ground(friction=0.0, roller_resistance=0.0), centre_of_mass=(0.03, -0.02))
    robot = with_motor(robot, back_emf_v_s_rad=0.0, coulomb_friction_n_m=0.0)
    base = SimBase(robot, None, plant="slip")
    set_moving(base, (0.3, -0.1, 2.0), (1.0, -2.0, 3.0))
    before, (cx, cy) = energy(base), robot.centre_of_mass
    velocity = np.array([0.3 - 2.0 * cy, -0.1 + 2.0 * cx])
    for _ in range(200):
        base.apply(DutyCommand((0.0,) * 3))
    x, y, theta = base.truth
    centre = np.array(
        [x + cx * math.cos(theta) - cy * math.sin(theta), y + cx * math.sin(theta) + cy * math.cos(theta)]
    )
    assert energy(base) == pytest.approx(before, rel=1e-12)
    assert theta == pytest.approx(4.0, rel=1e-12)
    assert np.allclose(centre, np.array([cx, cy]) + 2.0 * velocity, atol=1e-12)


def settled(robot, duty, seconds=3.0, dt=1e-3):
    base = SimBase(robot, None, plant="slip", dt_s=dt)
    for _ in range(round(seconds / robot.control_period_s)):
        base.apply(DutyCommand(duty))
    return base


def test_steady_motion_is_what_least_squares_says_of_the_real_wheel_speeds():
    """Within 0.12 % straight ahead (printed: 0.11 %): rollers resist, and a little slip must hold them."""
    for robot, duty in ((hybrid(), (0.0, 0.9, -0.9)), (mecanum(), (0.9,) * 4)):
        base = settled(robot, duty)
        wanted = Chassis.of(robot).forward(base.true_wheel_speeds)
        assert np.allclose(base.true_twist, wanted, atol=0.0012 * np.abs(wanted).max())


def test_without_resistance_only_the_centripetal_force_needs_slip():
    for duty in ((0.5, 0.9, -0.3), (-0.2, 0.1, 0.9)):
        base = settled(hybrid(ground=Ground(roller_resistance=0.0)), duty, 6.0)
        assert np.allclose(base.true_twist, Chassis.of(base.robot).forward(base.true_wheel_speeds), atol=1.5e-3)


# The printed checks used a 30 mm, 22 RPM Mecanum base whose other two wheels stand braked.
PAIR = (0.0, 1.0, 1.0, 0.0)  # FR and RL ahead: forward left


def held_pair(friction):
    """Diagonal pair at 22 RPM, the other pair held: wheel speeds given, as ideal motors would hold them."""
    robot = mecanum(ground=Ground(friction=friction))
    robot = with_motor(robot, inertia_kg_m2=1e6, back_emf_v_s_rad=0.0, coulomb_friction_n_m=0.0)
    base = SimBase(robot, None, plant="slip")
    set_moving(base, (0.0, 0.0, 0.0), np.array(PAIR) * FREE_SPEED)
    for _ in range(300):
        base.apply(DutyCommand((0.0,) * 4))
    return base


def test_a_diagonal_pair_with_grip_drives_along_its_diagonal_a_little_slower_than_kinematics():
    twist = held_pair(0.6).true_twist
    kinematic = FREE_SPEED * 0.03 / math.sqrt(2.0)
    assert kinematic == pytest.approx(0.0489, abs=5e-5)
    assert math.hypot(twist.vx, twist.vy) == pytest.approx(0.0482, rel=0.01)
    assert math.degrees(math.atan2(twist.vy, twist.vx)) == pytest.approx(45.0, abs=0.5)


def test_without_grip_the_direction_of_a_diagonal_pair_collapses():
    """Grip no better than the rollers' resistance (0.02 each): only the pull ahead is left (printed: 29.8 mm/s)."""
    twist = held_pair(0.02).true_twist
    assert abs(math.degrees(math.atan2(twist.vy, twist.vx))) < 1.0
    assert math.hypot(twist.vx, twist.vy) == pytest.approx(0.0298, rel=0.15)


def path(robot, dt, plan):
    base = SimBase(robot, None, plant="slip", dt_s=dt)
    for duty, seconds in plan:
        for _ in range(round(seconds / robot.control_period_s)):
            base.apply(DutyCommand(duty))
    return np.array(base.truth)


PLAN = (((0.3, 0.9, -0.9), 0.8), ((-0.8, 0.5, -0.2), 0.8))


def test_halving_the_step_halves_the_error():
    robot = hybrid(control_period_s=0.02)
    exact = path(robot, 0.02 / 32768, PLAN)
    errors = [np.linalg.norm(path(robot, 0.02 / k, PLAN) - exact) for k in (256, 512, 1024)]
    assert np.all(np.abs(np.log2(np.array(errors[:-1]) / errors[1:]) - 1.0) < 0.15)


def test_steps_up_to_20_ms_are_stable_and_near():
    robot = hybrid(control_period_s=0.02)
    exact = path(robot, 0.02 / 1024, PLAN)
    for dt, near_m in ((1e-3, 1e-3), (5e-3, 3e-3), (2e-2, 1e-2)):
        assert np.linalg.norm((path(robot, dt, PLAN) - exact)[:2]) < near_m


def test_a_motor_without_load_runs_at_its_no_load_speed_and_stalls_at_its_limit():
    lossless = with_motor(hybrid(), coulomb_friction_n_m=0.0, back_emf_v_s_rad=12.0 / FREE_SPEED)
    free = replace(lossless, ground=Ground(friction=0.0, roller_resistance=0.0))
    base = settled(free, (1.0, 0.5, -1.0))
    assert np.allclose(base.true_wheel_speeds, np.array([1.0, 0.5, -1.0]) * FREE_SPEED, rtol=1e-6)
    blocked = with_motor(lossless, inertia_kg_m2=1e9)
    currents = settled(blocked, (1.0, 0.2, -1.0), 0.5)._state[rows.CURRENT : rows.CURRENT + 3]
    assert np.allclose(currents, (3.0, 0.2 * 12.0 / 2.1, -3.0), rtol=0.1)
    assert np.all(np.abs(currents) < 3.0 * 1.01)


def test_the_battery_sags_by_its_current():
    blocked = with_motor(hybrid(battery=Battery(12.0, 0.5)), inertia_kg_m2=1e9, current_limit_a=math.inf)
    base = settled(blocked, (1.0, 0.0, 0.0), 0.5)
    wanted = 12.0 / (1.0 + 0.5 / 2.1)
    assert base._state[rows.VOLTAGE] == pytest.approx(wanted, rel=1e-4)
    assert base.energy_j == pytest.approx(0.5 * wanted**2 / 2.1, rel=1e-3)


def test_an_empty_battery_moves_nothing():
    base = settled(hybrid(battery=Battery(12.0, 0.1, capacity_c=0.2)), (1.0, 1.0, -1.0), 3.0)
    assert np.allclose(base.true_twist, 0.0, atol=1e-5)


def test_power_in_covers_heat_and_motion():
    """The battery's energy is at least what moves: efficiency, copper, friction and slip only take."""
    base = SimBase(hybrid(), None, plant="slip")
    for _ in range(200):
        base.apply(WheelCommand((0.5, 1.5, -1.0)))
        assert base.energy_j >= energy(base)


def test_inductance_delays_the_current_by_its_time_constant():
    slow = with_motor(hybrid(), inductance_h=2.1, inertia_kg_m2=1e9, current_limit_a=math.inf)  # L/R = 1 s
    base = settled(replace(slow, battery=Battery(12.0, 0.0)), (1.0, 0.0, 0.0), 1.0)
    assert base._state[rows.CURRENT] == pytest.approx(12.0 / 2.1 * (1.0 - math.exp(-1.0)), rel=1e-3)


def test_loads_balance_the_weight():
    places = [(w.x, w.y) for w in mecanum().wheels]
    loads = wheel_loads(places, (0.02, -0.01), 20.0)
    assert loads.sum() == pytest.approx(20.0)
    assert np.allclose(loads @ np.array(places), np.array([0.02, -0.01]) * 20.0)


def test_a_wheel_that_would_be_pulled_down_lifts_off():
    loads = wheel_loads([(1.0, 1.0), (1.0, -1.0), (-1.0, 1.0), (-1.0, -1.0)], (0.8, 0.3), 10.0)
    assert loads.min() == 0.0
    assert loads.sum() == pytest.approx(10.0)


def test_a_robot_that_would_fall_over_is_refused():
    with pytest.raises(InputError, match="outside its wheels"):
        SimBase(hybrid(centre_of_mass=(0.5, 0.0)), None)


def test_on_ice_the_wheels_turn_and_the_robot_hardly_moves():
    base = SimBase(hybrid(ground=SLIPPERY), None, plant="slip")
    for _ in range(10):
        base.apply(WheelCommand((0.0, 2.0, -2.0)))
    kinematic = Chassis.of(base.robot).forward(base.true_wheel_speeds)[0]
    assert base.true_twist.vx < 0.3 * kinematic
    assert GRAVITY == 9.80665


@pytest.mark.parametrize("friction", [0.6, 0.2, 0.05])
def test_no_base_accelerates_faster_than_its_grip_allows(friction):
    """Coulomb's limit, mu g, at full duty from rest and at the ordinary step of 1 ms."""
    import holodrive as hd

    robot = hd.load("swerve3")
    robot = replace(robot, ground=replace(robot.ground, friction=friction), control_period_s=1e-3)
    base = hd.simulate(robot, "open", plant="slip")
    speeds = [0.0]
    for _ in range(60):
        base.apply(hd.DutyCommand((1.0,) * 3, (0.0,) * 3))
        speeds.append(base.true_twist.vx)
    assert np.diff(speeds).max() / 1e-3 <= 1.06 * friction * 9.81
    assert speeds[-1] == pytest.approx(friction * 9.81 * 0.06, rel=0.05)
