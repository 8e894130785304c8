"""Numbers from the papers and from other projects' tests. Conventions are converted here, at the edge."""

import json
import math

import numpy as np
import pytest

from holodrive import geometry as g
from holodrive.kinematics import Chassis, Wheel, limits, pose_update, swerve
from holodrive.kinematics.discretise import discretise

MECANUM_SIDES = {"fl": -1, "fr": 1, "rl": 1, "rr": -1}


@pytest.fixture(scope="module")
def peers(shared_data):
    return json.loads((shared_data / "kinematics_vectors_sample.json").read_text())


@pytest.fixture(scope="module")
def papers(shared_data):
    return json.loads((shared_data / "paper_vectors.json").read_text())


# --- bases as the sources describe them ----------------------------------------------------------


def swerve_base(geometry):
    return Chassis([Wheel.swerve(x, y, 1.0) for x, y in geometry["modules"]])


def mecanum_base(geometry):
    order = geometry.get("order", ["fl", "fr", "rl", "rr"])
    wheels = zip(order, geometry["wheels"], strict=True)
    return Chassis({name: Wheel.mecanum(x, y, 0.0, 1.0, MECANUM_SIDES[name] * math.pi / 4) for name, (x, y) in wheels})


def omni_base(geometry):
    """(base, sign of the source's positive wheel against ours, which drives counter-clockwise)."""
    if geometry["type"] == "omni_ring":
        places = [(a, a + math.pi / 2, geometry["robot_radius"]) for a in geometry["position_angle_rad"]]
        sign = -1.0 if "CLOCKWISE" in geometry["positive_wheel"] else 1.0
    else:
        places = [(w["position_angle_rad"], w["drive_dir_rad"], w["robot_radius"]) for w in geometry["wheels"]]
        sign = 1.0
    wheels = [Wheel.omni(d * math.cos(a), d * math.sin(a), yaw, geometry["wheel_radius"]) for a, yaw, d in places]
    return Chassis(wheels), sign


def twist_of(case, keys=("vx", "vy", "omega")):
    return np.array([case[key] for key in keys], dtype=float)


def centre(case):
    return case.get("centre_of_rotation", [0.0, 0.0])


# --- one function for each kind: (geometry, input) -> {expected key: value} -----------------------


def swerve_ik(geometry, case):
    command = swerve_base(geometry).inverse(twist_of(case), centre(case))
    return {"speed": command.speeds, "angle_rad": command.steer}


def swerve_fk(geometry, case):
    return dict(
        zip(("vx", "vy", "omega"), swerve_base(geometry).forward(case["speed"], case["angle_rad"]), strict=True)
    )


def swerve_twist(geometry, case):
    found = swerve_base(geometry).forward(case["distance"], case["angle_rad"])
    return dict(zip(("dx", "dy", "dtheta"), found, strict=True))


def swerve_ik_sequence(geometry, case):
    base = swerve_base(geometry)
    angle = np.zeros(len(base.steered))
    for command in case["commands"]:
        speeds, steer = base.inverse(command)
        angle = swerve.hold_angle(speeds, steer, angle)
    return {"last_speed": speeds, "last_angle_rad": angle}


def swerve_ik_accel(geometry, case):
    twist, accel = (0.0, 0.0, case["omega"]), twist_of(case, ("ax", "ay", "alpha"))
    contact = swerve_base(geometry).inverse_acceleration(twist, accel, centre(case)).contact
    return {"accel": np.hypot(*contact.T), "angle_rad": np.arctan2(contact[:, 1], contact[:, 0])}


def swerve_fk_accel(geometry, case):
    base = swerve_base(geometry)
    found = base.forward_acceleration(np.zeros(len(base.wheels)), case["accel"], case["angle_rad"])
    return dict(zip(("ax", "ay", "alpha"), found, strict=True))


def mecanum_ik(geometry, case):
    return {"wheel": mecanum_base(geometry).inverse(twist_of(case), centre(case)).speeds}


def mecanum_fk(geometry, case):
    return dict(zip(("vx", "vy", "omega"), mecanum_base(geometry).forward(case["wheel"]), strict=True))


def mecanum_twist(geometry, case):
    found = mecanum_base(geometry).forward(case["wheel_delta"])
    return dict(zip(("dx", "dy", "dtheta"), found, strict=True))


def mecanum_ik_accel(geometry, case):
    accel = twist_of(case, ("ax", "ay", "alpha"))
    return {"wheel_accel": mecanum_base(geometry).inverse_acceleration((0, 0, 0), accel, centre(case)).speeds}


def mecanum_fk_accel(geometry, case):
    found = mecanum_base(geometry).forward_acceleration(np.zeros(4), case["wheel_accel"])
    return dict(zip(("ax", "ay", "alpha"), found, strict=True))


def mecanum_ik_lateral_multiplier(geometry, case):
    half = 0.5 * geometry["sum_lx_ly"]
    places = {"fl": (half, half), "fr": (half, -half), "rl": (-half, half), "rr": (-half, -half)}
    base = mecanum_base({"wheels": [places[name] for name in geometry["order"]], "order": geometry["order"]})
    twist = twist_of(case) * [1.0, geometry["lateral_multiplier"], 1.0]
    return {"wheel": base.inverse(twist).speeds}


def omni_ik(geometry, case):
    base, sign = omni_base(geometry)
    return {"wheel": sign * base.inverse(twist_of(case)).speeds}


def omni_fk(geometry, case):
    base, sign = omni_base(geometry)
    return dict(zip(("vx", "vy", "omega"), base.forward(sign * np.array(case["wheel"], dtype=float)), strict=True))


def omni_ik_raw(geometry, case):
    base, sign = omni_base(geometry)
    raw = sign * base.inverse(twist_of(case)).speeds * geometry["raw_per_rad_s"]
    return {"raw": np.round(limits.desaturate(raw, geometry["max_raw"]))}


def omni_fk_raw(geometry, case):
    base, sign = omni_base(geometry)
    speeds = sign * np.array(case["raw"]) / geometry["raw_per_rad_s"]
    return dict(zip(("vx", "vy", "omega"), base.forward(speeds), strict=True))


def desaturate(_, case):
    return {"speed": limits.desaturate(case["speed"], case["max_speed"])}


def desaturate_by_chassis_limits(_, case):
    tops = case["max_module_speed"], case["max_translation"], case["max_rotation"]
    return {"speed": limits.desaturate_by_chassis(case["speed"], case["desired"], *tops)}


def module_optimise(_, case):
    speed, angle = swerve.optimise(case["speed"], case["angle_rad"], case["current_angle_rad"])
    return {"speed": speed, "angle_rad": angle}


def module_cosine_scale(_, case):
    speed = swerve.cosine_scale(case["speed"], case["angle_rad"], case["current_angle_rad"])
    return {"speed": speed, "angle_rad": case["angle_rad"]}


def discretise_kind(_, case):
    return dict(zip(("vx", "vy", "omega"), discretise(twist_of(case), case["dt"]), strict=True))


def discretise_property(_, case):
    held, pose = discretise(twist_of(case), case["duration"]), np.zeros(3)
    for _ in range(round(case["duration"] / case["dt"])):
        pose = pose_update.exact(pose, held, case["dt"])
    return {"final_pose": pose}


def frame_change(sign):
    def change(_, case):
        found = g.rotate(sign * case["heading_rad"], twist_of(case))
        return dict(zip(("vx", "vy", "omega"), found, strict=True))

    return change


def turned(vector, about, angle):
    return np.asarray(about) + g.rotate(angle, np.asarray(vector, dtype=float) - about)


def pose_rotate_around(_, case):
    x, y = turned(case["pose"][:2], case["point"], case["angle_rad"])
    return {"pose": [x, y, case["pose"][2] + case["angle_rad"]]}


def pose_log(_, case):
    found = g.log(g.between(case["start"], case["end"]))
    return dict(zip(("dx", "dy", "dtheta"), found, strict=True))


def euler_project(_, case):
    pose, velocity, dt = case["pose"], np.array(case["velocity_fixed_frame"], dtype=float), case["dt"]
    body = g.rotate(-pose[2], velocity)
    return {
        "pose": pose_update.euler(pose, body, dt),
        "velocity_fixed_frame": g.rotate(velocity[2] * dt, velocity),
    }


def euler_rollout(_, case):
    pose, twist = np.zeros(3), twist_of(case)
    for i in range(case["columns"]):
        # the peer's first column is at rest but turns already
        moving = twist * [0, 0, 0] if i == 0 and case["first_column_zero"] else twist
        pose = pose_update.euler(pose, moving, case["dt"])
    return {"final_xy": pose[:2]}


def accel_limit_time(_, case):
    speed, ticks, a = case["v_start"], 0, case["accel_magnitude"]
    while abs(speed - case["v_target"]) > 1e-12 and ticks < 10**6:
        speed += limits.accel_share(speed, case["v_target"], a, a, case["dt"]) * (case["v_target"] - speed)
        ticks += 1
    return {"time_to_target": ticks * case["dt"]}


def direction_preserving_scale(geometry, case):
    share = limits.accel_share(
        case["v_now"], case["v_cmd"], geometry["accel"], abs(geometry["decel"]), 1.0 / geometry["rate_hz"]
    )
    return {"eta": -1.0 if share == 1.0 else share}


def accel_limit_step(geometry, case):
    now, wanted = case["v_now"], case["v_cmd"] * case["eta"]
    # the peer judges by the unscaled command whether it speeds up
    speeds_up = abs(case["v_cmd"]) >= abs(now) and now * case["v_cmd"] >= 0.0
    bound = case["accel"] if speeds_up else abs(case["decel"])
    share = limits.accel_share(now, wanted, bound, bound, 1.0 / geometry["rate_hz"])
    return {"v_next": now + share * (wanted - now)}


def pose_rotate_by(_, case):
    x, y = g.rotate(case["angle_rad"], case["pose"][:2])
    return {"pose": [x, y, case["pose"][2] + case["angle_rad"]]}


def just_pose(function):
    return lambda _, case: {"pose": function(case)}


KINDS = {
    "swerve_ik": swerve_ik,
    "swerve3_ik": swerve_ik,
    "swerve4_ik": swerve_ik,
    "swerve_fk": swerve_fk,
    "swerve3_fk": swerve_fk,
    "swerve4_fk": swerve_fk,
    "swerve_twist": swerve_twist,
    "swerve_ik_sequence": swerve_ik_sequence,
    "swerve_ik_accel": swerve_ik_accel,
    "swerve_fk_accel": swerve_fk_accel,
    "mecanum_ik": mecanum_ik,
    "mecanum4_ik": mecanum_ik,
    "mecanum_fk": mecanum_fk,
    "mecanum4_fk": mecanum_fk,
    "mecanum_twist": mecanum_twist,
    "mecanum_ik_accel": mecanum_ik_accel,
    "mecanum_fk_accel": mecanum_fk_accel,
    "mecanum_ik_lateral_multiplier": mecanum_ik_lateral_multiplier,
    "omni_ik": omni_ik,
    "omni_fk": omni_fk,
    "omni_ik_raw": omni_ik_raw,
    "omni_fk_raw": omni_fk_raw,
    "desaturate": desaturate,
    "desaturate_by_chassis_limits": desaturate_by_chassis_limits,
    "module_optimise": module_optimise,
    "module_cosine_scale": module_cosine_scale,
    "discretise": discretise_kind,
    "discretise_property": discretise_property,
    "to_robot_frame": frame_change(-1.0),
    "to_field_frame": frame_change(1.0),
    "pose_exp": just_pose(lambda c: g.compose(c["pose"], g.exp([c["dx"], c["dy"], c["dtheta"]]))),
    "pose_log": pose_log,
    "pose_compose": just_pose(lambda c: g.compose(c["a"], c["b"])),
    "pose_rotate_by": pose_rotate_by,
    "pose_relative_to": just_pose(lambda c: g.between(c["reference"], c["pose"])),
    "pose_rotate_around": pose_rotate_around,
    "point_rotate": lambda _, c: {"point": g.rotate(c["angle_rad"], c["point"])},
    "point_rotate_around": lambda _, c: {"point": turned(c["point"], c["about"], c["angle_rad"])},
    "point_to_frame": lambda _, c: {"point": g.between(c["frame"], [*c["point"], 0.0])[:2]},
    "twist_exp": just_pose(lambda c: g.exp([c["dx"], c["dy"], c["dtheta"]])),
    "twist_log": lambda _, c: dict(zip(("dx", "dy", "dtheta"), g.log(c["pose"]), strict=True)),
    "angle_wrap": lambda _, c: {"angle_rad": g.wrap(c["angle_rad"])},
    "angle_wrap_property": lambda _, c: {"equals_rad": g.wrap(c["angle_rad"])},
    "euler_project": euler_project,
    "euler_rollout": euler_rollout,
    "accel_limit_time": accel_limit_time,
    "accel_limit_step": accel_limit_step,
    "direction_preserving_scale": direction_preserving_scale,
}
# the estimator's tests read these
ODOMETRY = {
    "swerve_odometry", "swerve3_odometry", "swerve4_odometry", "mecanum_odometry", "mecanum4_odometry",
    "omni_odometry_step", "mecanum_odometry_delta", "odometry_guard", "odometry_accuracy_bound",
}  # fmt: skip
ANGLES = {"angle_rad", "last_angle_rad", "equals_rad"}


def check(case, tolerance):
    found = KINDS[case["kind"]](case["geometry"], case["input"])
    expected = case["expected"]
    assert set(found) == set(expected), case["id"]
    for key, value in expected.items():
        allowed = (
            tolerance
            if isinstance(tolerance, float)
            else tolerance.get(key.removeprefix("last_"), tolerance.get("abs"))
        )
        error = np.asarray(found[key], dtype=float) - np.asarray(value, dtype=float)
        if key in ANGLES:
            error = np.angle(np.exp(1j * error))
            speed = expected.get("speed", 1.0)
            if case["kind"].endswith("_ik"):
                error = np.where(np.abs(speed) < 1e-12, 0.0, error)
        if key == "pose":
            error[2] = np.angle(np.exp(1j * error[2]))
        assert np.all(np.abs(error) <= allowed), (case["id"], key, found[key], value)


def test_every_kind_is_either_ours_or_the_estimators(peers):
    kinds = {case["kind"] for case in peers["facts"] + peers["random"]}
    assert kinds <= set(KINDS) | ODOMETRY


def test_facts_from_other_projects_tests(peers):
    ours = [case for case in peers["facts"] if case["kind"] in KINDS]
    assert len(ours) > 35
    for case in ours:
        check(case, case["tol"])


def test_random_cases_computed_with_wpimath(peers):
    tolerance = peers["tolerance"]
    ours = [case for case in peers["random"] if case["kind"] in KINDS]
    assert len(ours) >= 140
    for case in ours:
        check(case, float(tolerance.get(case["kind"], tolerance["default_abs"])))


# --- the papers ---------------------------------------------------------------------------------


def near(found, expected, where=""):
    np.testing.assert_allclose(found, expected, rtol=1e-9, atol=1e-9, err_msg=str(where))


@pytest.mark.parametrize("key", ["hybrid_r0.05", "hybrid_r0.051"])
def test_paper_000_hybrid(papers, key):
    v = papers["seed000"][key]
    wheels = [Wheel.from_paper(*angles, v["l"], v["r"]) for angles in v["alpha_beta_gamma"]]
    chassis = Chassis(wheels)
    near(chassis.jacobian, v["J_inverse"])
    near(chassis.least_squares, v["J_forward"])
    assert chassis.condition == pytest.approx(v["cond_l_scaled"], rel=1e-9)
    for wheel, (x, y, eps, rho) in zip(wheels, v["wheels_xy_eps_rho"], strict=True):
        near([wheel.x, wheel.y], [x, y])
        near(np.exp(1j * wheel.yaw), np.exp(1j * eps))
        # the roller axis counts modulo 180 degrees
        near(np.exp(2j * wheel.push_axis), np.exp(2j * rho))
    for case in v["cases"]:
        near(chassis.inverse(case["twist"]).speeds, case["omega"])
        near([wheel.roller_speed(case["twist"]) for wheel in wheels], case["roller_surface_speed"])


def test_paper_000_equations_14_and_16_on_random_wheels(papers):
    for v in papers["seed000"]["eq16_random_wheels"]:
        wheel = Wheel.from_paper(v["alpha"], v["beta"], v["gamma"], v["l"], v["r"])
        near(wheel.rows[0], v["T_omega"])
        near(wheel.roller_speed(np.eye(3)), v["T_vir"])
        both = np.array([wheel.rows[0], wheel.roller_speed(np.eye(3))])
        near(np.linalg.pinv(both), v["T_pinv_eq15"])


def test_paper_000_equations_28_to_30(papers):
    v = papers["seed000"]["eq28_30_pose_update"]
    arguments = v["pose"], v["twist"], v["dt"]
    near(pose_update.euler(*arguments), v["euler"])
    near(pose_update.midpoint(*arguments), v["midpoint"])
    near(pose_update.exact(*arguments), v["exact_exp"])


def test_paper_004_swerve(papers):
    v = papers["seed004"]
    angles = (0.0, -2.0 * math.pi / 3.0, 2.0 * math.pi / 3.0)

    def base(length, radius):
        return Chassis([Wheel.swerve(length * math.cos(a), length * math.sin(a), radius) for a in angles])

    near(base(1.0, 0.1).jacobian, v["eq19_corrected_L1"])
    for case in v["ik"]:
        chassis = base(case["L"], case["r"])
        twist = g.rotate(-math.radians(case["theta_deg"]), np.array(case["world_velocity"], dtype=float))
        near(twist, case["body_twist"])
        near(chassis.wheel_rows(twist), case["wheel_xy"])
        command = chassis.inverse(twist)
        near(command.speeds, case["wheel_rad_s"])
        near(np.exp(1j * command.steer), np.exp(1j * np.radians(case["steer_deg"])))
        near(chassis.forward(command.speeds, command.steer), twist)


def test_unified_formulation(papers, bases):
    v = papers["unified"]
    near(bases["mecanum4"].jacobian, v["mecanum4_lx.2_ly.15_r.03_FL_FR_RL_RR"])
    near(bases["omni3"].jacobian, v["omni3_R.23_r.051"])
    near(bases["omni4"].jacobian, v["omni4_R.2_r.05"])
    cond = v["cond_l_scaled"]
    assert bases["mecanum4"].condition == pytest.approx(cond["mecanum4_Lc_lx_plus_ly"])
    assert bases["swerve3"].condition == pytest.approx(cond["swerve3"])
    assert bases["hybrid3"].condition == pytest.approx(cond["hybrid"], abs=1e-6)
