"""The plant of motors: laws of mechanics, the bench as second method, and what a swerve base must do on it."""

import math
from dataclasses import replace

import numpy as np
import pytest
from machines import hybrid, swerve

from holodrive import robots
from holodrive.actuators.machine import simulate
from holodrive.control.go_to_pose import GoToPose
from holodrive.control.kernel import KernelController
from holodrive.errors import InputError
from holodrive.geometry import compose, exp
from holodrive.kinematics import Chassis
from holodrive.kinematics.pipeline import CommandPipeline
from holodrive.robots.spec import Battery, Motor, SpeedLoop, Steering
from holodrive.sim import SimBase, rollout
from holodrive.sim import state as rows
from holodrive.types import DutyCommand, WheelCommand

# 24 V flat motor behind 9:1, values at the wheel (`bldc-16pole-9to1`)
BLDC = Motor(
    "flat", "bldc", 24.0, 77.7, 0.3015, 1.03,
    inductance_h=0.572e-3, viscous_friction_n_m_s_rad=7.2e-4, inertia_kg_m2=1.09e-3, gear=9.0, poles=16,
)  # fmt: skip
DRIVES = ("averaged", "six_step", "foc")
STIFF = Battery(24.0, 0.0)


def machine(drive="averaged", **changes):
    """Three modules at 0.3 m, wheels of 5 cm, 8 kg; motors on drives and steerings."""
    motor = replace(BLDC, drive=drive, emf="sine" if drive == "foc" else "trapezoid")
    robot = swerve()
    wheels = tuple(
        replace(w, motor=motor, max_speed_rad_s=70.0, steering=Steering(12.0, motor=motor, inertia_kg_m2=1e-3))
        for w in robot.wheels
    )
    loop = SpeedLoop(kp=1.5, ki=15.0, filter_s=0.0)
    return replace(robot, wheels=wheels, **({"battery": STIFF, "speed_loop": loop} | changes))


def with_steering(robot, **changes):
    wheels = tuple(replace(w, steering=replace(w.steering, **changes)) for w in robot.wheels)
    return replace(robot, wheels=wheels)


def set_spinning(base, speeds):
    """Shafts (n + m) at speeds [rad/s], with the body going along."""
    base._motor_rows()[:, rows.MOTOR_SPEED] = speeds
    base._state[rows.WHEEL_SPEED : rows.WHEEL_SPEED + base._n] = speeds[: base._n]
    still = base._state[rows.STEER : rows.STEER + base._m].copy()
    twist = unit_twists(base, still) @ np.asarray(speeds[: base._n])
    base._state[rows.CARRIED : rows.CARRIED + 3] = twist


def unit_twists(base, steer):
    """(3, n) twist of the centre of mass per wheel speed, by least squares over all contacts, written out again."""
    robot = base.robot
    contacts = [row for w in robot.wheels for row in ([1.0, 0.0, -w.y], [0.0, 1.0, w.x])]
    rolling = np.zeros((2 * len(robot.wheels), len(robot.wheels)))
    for i, w in enumerate(robot.wheels):
        rolling[2 * i : 2 * i + 2, i] = w.radius * np.array([math.cos(w.yaw + steer[i]), math.sin(w.yaw + steer[i])])
    found = np.linalg.pinv(np.array(contacts)) @ rolling
    cx, cy = robot.centre_of_mass
    return np.array([found[0] - cy * found[2], found[1] + cx * found[2], found[2]])


def kinetic(base):
    """Of the body and of all shafts [J]."""
    robot, twist, speeds = base.robot, base.true_twist, base._motor_rows()[:, rows.MOTOR_SPEED]
    cx, cy = robot.centre_of_mass
    vx, vy = twist.vx - twist.omega * cy, twist.vy + twist.omega * cx
    inertia = [w.motor.inertia_kg_m2 for w in robot.wheels]
    inertia += [w.steering.motor.inertia_kg_m2 + w.steering.inertia_kg_m2 for w in robot.wheels]
    body = 0.5 * robot.mass_kg * (vx**2 + vy**2) + 0.5 * robot.inertia_kg_m2 * twist.omega**2
    return body + 0.5 * float(np.array(inertia) @ speeds**2)


def driven(robot, twist, seconds, *, plant="motors", turning=True):
    """Poses (T, 3), steering angles (T, m) and the base, driving `twist` in world axes (or the robot's own)."""
    base, pipeline = SimBase(robot, plant=plant), CommandPipeline(robot)
    poses, angles = [], []
    for k in range(round(seconds / robot.control_period_s)):
        vx, vy, omega = twist(k * robot.control_period_s) if callable(twist) else twist
        c, s = (math.cos(base.truth.theta), math.sin(base.truth.theta)) if turning else (1.0, 0.0)
        base.apply(pipeline.step((c * vx + s * vy, c * vy - s * vx, omega), robot.control_period_s))
        poses.append(tuple(base.truth))
        angles.append(base._state[rows.STEER : rows.STEER + base._m].copy())
    return np.array(poses), np.array(angles), base


@pytest.mark.parametrize("drive", DRIVES)
@pytest.mark.parametrize("way", ["straight", "on the spot"])
def test_a_wheel_carries_its_share_of_the_body(drive, way):
    """m r^2 / n in a straight line and I r^2 / sum p^2 in a turn on the spot, as one motor on the bench with that."""
    robot, duty = machine(drive), 0.4
    base = SimBase(robot, plant="motors")
    r, n = 0.05, 3
    if way == "straight":
        steer, load = (0.0, 0.0, 0.0), robot.mass_kg * r**2 / n
    else:
        steer = tuple(math.atan2(w.x, -w.y) for w in robot.wheels)
        load = robot.inertia_kg_m2 * r**2 / (n * 0.3**2)
    base._state[rows.STEER : rows.STEER + 3] = steer
    for j in range(3):  # targets of the board
        base._motor_rows()[3 + j, rows.MOTOR_TARGET] = base._motor_rows()[3 + j, rows.MOTOR_LAST] = steer[j]
    for _ in range(30):
        base.apply(DutyCommand((duty,) * 3, steer))
    bench = simulate(robot.wheels[0].motor, duty, 0.0, 0.3, 2e-5, bus_v=24.0, inertia_kg_m2=load)
    near = 1e-3 if drive != "foc" else 0.03  # on the plant a field-oriented motor knows its EMF, on the bench a speed
    if drive != "foc":
        np.testing.assert_allclose(base.true_wheel_speeds, bench.speed[-1], rtol=near)
    twist = base.true_twist
    moved = math.hypot(twist.vx, twist.vy) if way == "straight" else 0.3 * abs(twist.omega)
    assert moved == pytest.approx(r * base.true_wheel_speeds.mean(), rel=1e-9)


@pytest.mark.parametrize("drive", DRIVES)
def test_what_the_battery_gives_is_heat_or_motion(drive):
    """Electrical in = copper + friction + what the shafts got + what the windings hold; the shafts' part is motion."""
    robot = machine(drive, centre_of_mass=(0.03, -0.02))
    _, _, base = driven(robot, lambda t: (min(0.8, 2.0 * t), 0.0, min(1.0, 2.0 * t)), 1.0)
    electrical, copper, shaft = base.motor_energy_j.sum(axis=0)
    assert shaft == pytest.approx(kinetic(base), rel=1e-3)
    friction = electrical - copper - shaft
    # viscous friction of wheels at 16 rad/s for 0.8 s, the rest of it small: within what the fields hold
    assert 0.0 < friction < 0.1 * electrical
    assert base.energy_j >= electrical - 1e-9  # what braking gives back is burnt


@pytest.mark.parametrize("drive", ["averaged", "six_step"])
def test_a_base_with_shorted_motors_never_gains_energy(drive):
    base = SimBase(with_steering(machine(drive), kp_v_rad=0.0, kd_v_s_rad=0.0), plant="motors")
    set_spinning(base, np.array([20.0, -5.0, 12.0, 3.0, -4.0, 1.0]))
    before = 1e9
    for _ in range(40):
        base.apply(DutyCommand((0.0, 0.0, 0.0), (0.0, 0.0, 0.0)))
        now = kinetic(base)
        assert now <= before * (1.0 + 1e-12)
        before = now
    assert before < 0.1


def test_a_straight_line_costs_no_force_while_the_robot_spins():
    """Without motors' pull a body that spins goes straight on at the same speed, and its wheels with it."""
    idle = replace(BLDC, back_emf_v_s_rad=1e-9, viscous_friction_n_m_s_rad=0.0, inertia_kg_m2=1e-7)
    robot = machine(control_period_s=1e-3)
    wheels = tuple(replace(w, motor=idle) for w in robot.wheels)
    robot = replace(robot, wheels=wheels)
    base = SimBase(robot, plant="motors")
    v, w = 1.0, 0.5
    place = [(0.3 * math.cos(a), 0.3 * math.sin(a)) for a in (0.0, 2.0 * math.pi / 3.0, -2.0 * math.pi / 3.0)]

    def module(theta):
        vx, vy = v * math.cos(theta), -v * math.sin(theta)
        both = [(vx - w * y, vy + w * x) for x, y in place]
        return tuple(math.atan2(b, a) for a, b in both), tuple(math.hypot(a, b) / 0.05 for a, b in both)

    steer, speeds = module(0.0)
    base._state[rows.STEER : rows.STEER + 3] = steer
    for j in range(3):
        base._motor_rows()[3 + j, [rows.MOTOR_TARGET, rows.MOTOR_LAST]] = steer[j]
    set_spinning(base, np.array([*speeds, 0.0, 0.0, 0.0]))
    for k in range(1000):
        base.apply(DutyCommand((0.0, 0.0, 0.0), module(w * (k + 0.5) * 1e-3)[0]))
    np.testing.assert_allclose(base.true_wheel_speeds, module(base.truth.theta)[1], rtol=0.01)
    assert math.hypot(base.true_twist.vx, base.true_twist.vy) == pytest.approx(v, rel=2e-3)
    assert base.true_twist.omega == pytest.approx(w, rel=0.01)


@pytest.mark.parametrize("drive", DRIVES)
def test_a_straight_line_while_spinning_stays_straight_within_a_millimetre(drive):
    """At 1 m/s, turning at 1 rad/s, motors on: from the straight line through the path after the start."""
    poses, _, _ = driven(machine(drive), lambda t: (min(1.0, t), 0.0, min(1.0, t)), 3.5)
    x, y = poses[200:, 0], poses[200:, 1]
    assert x[-1] - x[0] > 1.4
    assert np.abs(y - np.polyval(np.polyfit(x, y, 1), x)).max() < 1e-3


def test_a_module_turns_at_most_90_degrees_for_one_change_of_direction():
    robot = machine()
    for degrees in (30.0, 89.0, 91.0, 120.0, 180.0, -135.0, -60.0):
        base, pipeline = SimBase(robot, plant="motors"), CommandPipeline(robot)
        angles = []
        for k in range(180):
            a, v = (math.radians(degrees), 0.3) if k >= 80 else (0.0, 0.3 if k < 40 else 0.0)
            base.apply(pipeline.step((v * math.cos(a), v * math.sin(a), 0.0), 0.01))
            angles.append(base._state[rows.STEER : rows.STEER + 3].copy())
        assert np.degrees(np.ptp(angles, axis=0)).max() <= 90.0 + 0.1, degrees
        motion = math.degrees(math.atan2(base.true_twist.vy, base.true_twist.vx))
        assert (motion - degrees + 180.0) % 360.0 - 180.0 == pytest.approx(0.0, abs=0.1)


@pytest.mark.parametrize("drive", DRIVES)
def test_wheels_at_rest_keep_their_angle(drive):
    _, angles, base = driven(machine(drive), lambda t: (0.3, 0.3, 0.0) if t < 0.5 else (0.0, 0.0, 0.0), 3.0)
    assert np.abs(angles[-1] - math.pi / 4).max() < 1e-3
    assert np.ptp(angles[-100:], axis=0).max() < 1e-9
    assert np.abs(base.true_wheel_speeds).max() < 1e-3


def test_a_robot_that_is_told_nothing_stays_where_it_is():
    base = SimBase(machine("six_step"), plant="motors", start=(1.0, 2.0, 0.5))
    for _ in range(20):
        base.apply(WheelCommand((0.0, 0.0, 0.0), (0.0, 0.0, 0.0)))
    assert tuple(base.truth) == (1.0, 2.0, 0.5)
    assert base.energy_j == 0.0
    assert not np.any(base.phase_currents)


def test_a_command_that_is_not_finite_stops_the_base_for_good():
    _, _, base = driven(machine("six_step"), (0.5, 0.0, 0.0), 0.5)
    base.apply(WheelCommand((math.nan, 1.0, 1.0), (0.0, 0.0, 0.0)))
    for _ in range(150):
        base.apply(WheelCommand((10.0, 10.0, 10.0), (1.0, 1.0, 1.0)))
    assert base.fault
    assert np.all(np.isfinite(base._state[[*range(7), *range(rows.WHEEL_SPEED, rows.CONTACT)]]))
    assert np.abs(base.true_wheel_speeds).max() < 1e-2
    assert [event.kind for event in base.take_events()] == ["fault"]


@pytest.mark.parametrize("drive", DRIVES)
def test_a_weak_battery_sags_by_its_current(drive):
    """Ohm's law once the current is there, four times over the resistance at which a delayed supply would swing."""
    robot = machine(drive, battery=Battery(24.0, 2.0), control_period_s=1e-3)
    base, volts = SimBase(robot, plant="motors"), []
    for _ in range(50):
        base.apply(DutyCommand((1.0, 1.0, 1.0), (0.0, 0.0, 0.0)))
        volts.append((base._state[rows.VOLTAGE], 24.0 - 2.0 * base._state[rows.BUS_CURRENT]))
    told, ohms = np.array(volts[5:]).T
    assert np.quantile(np.abs(told - ohms), 0.75) < 0.2  # six-step commutations are shorter than what this samples
    assert 2.0 < told[0] < told[-1] < 7.0  # recovers as the wheels speed up
    if drive != "six_step":
        assert np.all(np.diff(told) > 0.0)
    assert base.energy_j == pytest.approx(base.motor_energy_j[:, 0].sum(), rel=1e-9)


def test_powers_and_currents_tell_one_story():
    _, _, base = driven(machine(), lambda t: (min(0.8, 0.4 * t), 0.0, 0.0), 1.5)
    motors = base.motors
    assert motors.current.shape == (6,)
    np.testing.assert_allclose(motors.torque[:3], 0.3015 * motors.current[:3], rtol=1e-12)
    speeds = base.true_wheel_speeds
    np.testing.assert_allclose(motors.mechanical[:3], (motors.torque[:3] - 7.2e-4 * speeds) * speeds, rtol=0.02)
    efficiency = motors.efficiency[:3]
    assert np.all((efficiency > 0.5) & (efficiency < 1.0))
    assert np.all(np.isnan(SimBase(machine(), plant="motors").motors.efficiency))
    assert SimBase(machine(), plant="slip").motors is None


@pytest.mark.parametrize("coupling", [0.0, 0.5, -2.0])
def test_the_board_makes_up_for_steering_that_turns_the_wheel(coupling):
    """Modules turn a right angle on the spot: the wheels stay where they are."""
    robot = with_steering(machine(), coupling=coupling)
    base = SimBase(robot, plant="motors")
    for k in range(100):
        base.apply(WheelCommand((0.0, 0.0, 0.0), (min(0.5 * math.pi, 0.05 * k),) * 3))
    assert base._state[rows.STEER] == pytest.approx(0.5 * math.pi, abs=1e-3)
    turned = base._state[rows.WHEEL_ANGLE : rows.WHEEL_ANGLE + 3]
    assert np.abs(turned).max() < 0.05 * abs(coupling) + 1e-9


def test_a_base_without_steering_goes_as_its_kinematics_say():
    robot = hybrid()
    speeds = (1.0, -0.6, 0.4)
    base, simple = SimBase(robot, plant="motors"), SimBase(robot, plant="first_order")
    for _ in range(300):
        base.apply(WheelCommand(speeds, ()))
        simple.apply(WheelCommand(speeds, ()))
    np.testing.assert_allclose(base.true_wheel_speeds, speeds, rtol=0.02)
    np.testing.assert_allclose(base.true_twist, simple.true_twist, atol=2e-3)


def test_a_steering_servo_serves_beside_motors():
    robot = machine()
    servo = replace(robot, wheels=tuple(replace(w, steering=Steering(6.0, 0.05)) for w in robot.wheels))
    _, angles, base = driven(servo, (0.0, 0.4, 0.0), 1.0)
    _, simple, _ = driven(servo, (0.0, 0.4, 0.0), 1.0, plant="first_order")
    np.testing.assert_array_equal(angles, simple)
    assert np.all(np.isnan(base.motors.current[3:]))
    assert base.true_twist.vy == pytest.approx(0.4, rel=1e-3)


@pytest.mark.parametrize("drive", DRIVES)
def test_the_roll_out_gives_the_bits_of_the_ordinary_loop(drive):
    robot, law = machine(drive), GoToPose()
    goal = np.array([0.4, 0.3, 0.6])
    many = rollout(robot, None, law, n=2, t=0.6, goals=goal, plant="motors", log_every=1)
    base, pipeline = SimBase(robot, plant="motors"), CommandPipeline(robot)
    controller = KernelController(law, robot)
    from holodrive.types import Estimate, Pose, Reference

    for _ in range(60):
        observation = base.observe()
        estimate = Estimate(base.truth, base.true_twist, np.zeros((3, 3)))
        decision = controller.step(Reference(Pose(*goal), last=True), estimate, observation)
        base.apply(pipeline.step(decision.command, 0.01))
    np.testing.assert_array_equal(many.state[0], many.state[1])
    np.testing.assert_allclose(many.pose[0], np.array(base.truth), atol=1e-12)
    np.testing.assert_allclose(many.column("current:s0")[0, -1], base.motors.current[0], rtol=1e-9)
    np.testing.assert_allclose(many.motor_energy_j[0], base.motor_energy_j, rtol=1e-9, atol=1e-15)
    assert many.metrics["energy_j"][0] == pytest.approx(base.energy_j, rel=1e-9)


def test_a_motor_without_inertia_is_refused_by_name():
    robot = machine()
    light = replace(robot, wheels=tuple(replace(w, motor=replace(BLDC, inertia_kg_m2=0.0)) for w in robot.wheels))
    with pytest.raises(InputError, match="drive of wheel s0 of swerve has no inertia"):
        SimBase(light, plant="motors")
    assert SimBase(light, plant="first_order").plant == "first_order"


@pytest.mark.parametrize("name", robots.names())
def test_every_catalog_robot_runs_on_it(name):
    robot = robots.load(name)
    base = SimBase(robot, plant="motors", dt_s=1e-3)
    n, m = len(robot.wheels), len(robot.steered)
    for _ in range(20):
        base.apply(WheelCommand((0.2 * robot.wheels[0].max_speed_rad_s,) * n, (0.0,) * m))
    assert np.all(np.isfinite(base.true_wheel_speeds))
    assert base.energy_j > 0.0


@pytest.mark.parametrize("caster", [0.03, -0.02])
def test_with_casters_the_body_moves_as_wheels_and_steering_rates_say(caster):
    """Against the kinematics of the chassis, with a coupling, while modules turn and wheels roll."""
    robot = with_steering(machine(control_period_s=1e-3), caster_m=caster, coupling=0.4)
    base, chassis, pose = SimBase(robot, plant="motors"), Chassis.of(robot), np.zeros(3)
    for k in range(400):
        angles = base._state[rows.STEER : rows.STEER + 3].copy()
        turned = base._state[rows.WHEEL_ANGLE : rows.WHEEL_ANGLE + 3].copy()
        base.apply(WheelCommand((6.0, 7.0, 8.0), (0.002 * k, -0.001 * k, 0.3)))
        now = base._state[rows.STEER : rows.STEER + 3]
        speeds = (base._state[rows.WHEEL_ANGLE : rows.WHEEL_ANGLE + 3] - turned) / 1e-3
        twist = chassis.forward(speeds, 0.5 * (angles + now), (now - angles) / 1e-3)
        pose = compose(pose, exp(twist * 1e-3))
    np.testing.assert_allclose(base.truth, pose, atol=2e-5)
    assert math.hypot(*base.truth[:2]) > 0.1


def test_a_body_that_casters_carry_is_felt_by_the_steering():
    """Steering motors that move the body by their casters turn slower than those that do not."""
    robot = machine()
    light, heavy = (
        driven(with_steering(replace(robot, mass_kg=60.0), caster_m=c), (0.0, 0.0, 0.0), 0.01)[2] for c in (0.0, 0.05)
    )
    for base in (light, heavy):
        for _ in range(4):
            base.apply(WheelCommand((0.0, 0.0, 0.0), (1.0, 1.0, 1.0)))
    assert heavy._state[rows.STEER] < 0.9 * light._state[rows.STEER]
