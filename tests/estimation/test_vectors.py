"""Odometry of other projects' tests and of wpimath, as their numbers say (`kinematics_vectors_sample.json`)."""

import json
import math
from collections.abc import Callable
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from holodrive import geometry
from holodrive.estimation import Odometry, WheelOdometry
from holodrive.kinematics import Chassis, Wheel
from holodrive.types import Array, Pose

# as in the sources: the gyro alone turns, modules point where the newest sample says
THEIRS = WheelOdometry(gyro_weight=1.0, steer_at=1.0, jump_factor=1e9)
ROLLERS = {"fl": -45.0, "fr": 45.0, "rl": 45.0, "rr": -45.0}


def modules(geometry_: dict[str, Any]) -> Chassis:
    """Swerve modules; radius 1, so that an angle is a distance."""
    return Chassis([Wheel.swerve(x, y, 1.0) for x, y in geometry_["modules"]])


def mecanum(geometry_: dict[str, Any]) -> Chassis:
    """Four Mecanum wheels in the order of the source; without positions any do, for nothing turns then."""
    order = geometry_.get("order", ["fl", "fr", "rl", "rr"])
    places = geometry_.get("wheels") or [
        [0.5 if name[0] == "f" else -0.5, 0.5 if name[1] == "l" else -0.5] for name in order
    ]
    radius = geometry_["wheel_radius"] if geometry_.get("wheel_unit", "").startswith("rad") else 1.0
    return Chassis(
        {
            name: Wheel.mecanum(x, y, 0.0, radius, math.radians(ROLLERS[name]))
            for name, (x, y) in zip(order, places, strict=True)
        }
    )


def omni_ring(geometry_: dict[str, Any]) -> Chassis:
    """Omni wheels on a circle."""
    clockwise = "CLOCKWISE" in geometry_["positive_wheel"] and "COUNTER" not in geometry_["positive_wheel"]
    ring, radius = geometry_["robot_radius"], geometry_["wheel_radius"]
    side = -math.pi / 2 if clockwise else math.pi / 2
    angles = geometry_["position_angle_rad"]
    return Chassis([Wheel.omni(ring * math.cos(a), ring * math.sin(a), a + side, radius) for a in angles])


def poses_with_gyro(chassis: Chassis, case: dict[str, Any]) -> list[Pose]:
    """Pose after each step."""
    given = case["input"]
    odometry = Odometry(chassis, THEIRS, Pose(*given["start_pose"]))
    samples = [(given["gyro_at_reset_rad"], given["wheels_at_reset"])]
    samples += [(step["gyro_rad"], step.get("modules", step.get("wheels"))) for step in given["steps"]]
    poses = []
    for k, (gyro, wheels) in enumerate(samples):
        position, steer = split(wheels)
        poses.append(odometry.update(position, gyro, stamp=0.02 * k, steer=steer).pose)
    return poses[1:]


def split(wheels: list[Any]) -> tuple[Array, Array]:
    """Wheel angles and steering angles of `[[distance, angle], ...]` or `[distance, ...]`."""
    values = np.array(wheels, dtype=np.float64)
    return (values[:, 0], values[:, 1]) if values.ndim == 2 else (values, np.empty(0))


def one_step(chassis: Chassis, case: dict[str, Any], increments: Array, dt: float) -> list[Pose]:
    odometry = Odometry(chassis, THEIRS, Pose(*case["input"]["start_pose"]))
    odometry.update(0.0 * increments, stamp=0.0)
    return [odometry.update(increments, stamp=dt).pose]


CASES: dict[str, Callable[[dict[str, Any]], list[Pose]]] = {
    "swerve_odometry": lambda case: poses_with_gyro(modules(case["geometry"]), case),
    "swerve3_odometry": lambda case: poses_with_gyro(modules(case["geometry"]), case),
    "swerve4_odometry": lambda case: poses_with_gyro(modules(case["geometry"]), case),
    "mecanum_odometry": lambda case: poses_with_gyro(mecanum(case["geometry"]), case),
    "mecanum4_odometry": lambda case: poses_with_gyro(mecanum(case["geometry"]), case),
    "omni_odometry_step": lambda case: one_step(
        omni_ring(case["geometry"]),
        case,
        np.array(case["input"]["wheel"], dtype=np.float64) * case["input"]["dt"],
        case["input"]["dt"],
    ),
    "mecanum_odometry_delta": lambda case: one_step(
        mecanum(case["geometry"]), case, np.array(case["input"]["wheel_delta_rad"]), 0.02
    ),
}


@pytest.fixture(scope="module")
def vectors(shared_data: Path) -> list[dict[str, Any]]:
    content = json.loads((shared_data / "kinematics_vectors_sample.json").read_text())
    return [*content["facts"], *content["random"]]


def tolerances(case: dict[str, Any]) -> tuple[float, float]:
    """Of position and heading."""
    tol = case.get("tol", {})
    return tol.get("xy", tol.get("abs", 1e-9)), tol.get("theta_rad", tol.get("abs", 1e-9))


@pytest.mark.parametrize("kind", CASES)
def test_poses_are_those_of_the_source(kind: str, vectors: list[dict[str, Any]]) -> None:
    cases = [case for case in vectors if case["kind"] == kind]
    assert cases
    for case in cases:
        expected = case["expected"].get("poses") or [case["expected"]["pose"]]
        found = np.array(CASES[kind](case))[-len(expected) :]
        xy, theta = tolerances(case)
        np.testing.assert_allclose(found[:, :2], np.array(expected)[:, :2], atol=xy, err_msg=case["id"])
        turn = geometry.wrap(found[:, 2] - np.array(expected)[:, 2])
        np.testing.assert_allclose(turn, 0.0, atol=theta, err_msg=case["id"])


def test_a_step_of_almost_no_time_is_refused_as_in_the_source(vectors: list[dict[str, Any]]) -> None:
    for case in (case for case in vectors if case["kind"] == "odometry_guard"):
        chassis = omni_ring(case["geometry"])
        wheels, dt = np.array(case["input"]["wheel"], dtype=np.float64), case["input"]["dt"]
        odometry = Odometry(chassis, THEIRS)
        odometry.update(0.0 * wheels, stamp=0.0)
        odometry.update(wheels * dt, stamp=dt)
        assert bool(odometry.counts.used) is case["expected"]["updated"], case["id"]


def test_noise_of_the_gyro_stays_within_the_bounds_of_the_source(vectors: list[dict[str, Any]]) -> None:
    """A spline through the source's way points, wheels exact, its noise on the gyro."""
    for case in (case for case in vectors if case["kind"] == "odometry_accuracy_bound"):
        given, rng = case["input"], np.random.default_rng(0)
        path = spline(np.array(given["waypoints_xy_deg"], dtype=np.float64))
        way, time = profile(path, given["max_speed"], given["max_accel"], given["dt"])
        x, y, theta = (np.interp(way, path[:, 0], path[:, i]) for i in (1, 2, 3))
        truth = np.stack([x, y, theta], axis=-1)
        chassis = modules(case["geometry"])
        odometry = Odometry(chassis, THEIRS, Pose(*truth[0]))
        position, errors = np.zeros(4), []
        for k in range(len(time)):
            steps = geometry.log(geometry.between(truth[k - 1], truth[k])) if k else np.zeros(3)
            command = chassis.inverse(steps)
            position = position + np.asarray(command.speeds)
            gyro = truth[k, 2] + rng.normal() * given["gyro_noise_sigma_rad"]
            pose = odometry.update(position, gyro, stamp=float(time[k]), steer=command.steer).pose
            errors.append(math.hypot(pose.x - x[k], pose.y - y[k]))
        assert np.mean(errors) < case["expected"]["mean_position_error_below"], case["id"]
        assert np.max(errors) < case["expected"]["max_position_error_below"], case["id"]


def spline(points: Array) -> Array:
    """Quintic Hermite curve through (x, y, heading in degrees): rows of way, x, y, direction [m, m, m, rad]."""
    s = np.linspace(0.0, 1.0, 400)[:, None]
    start = 1 - 10 * s**3 + 15 * s**4 - 6 * s**5
    leave, arrive = s - 6 * s**3 + 8 * s**4 - 3 * s**5, -4 * s**3 + 7 * s**4 - 3 * s**5
    pieces = []
    for a, b in pairwise(points):
        reach = 1.2 * math.hypot(*(b - a)[:2])
        out, into = (reach * np.array([math.cos(math.radians(p[2])), math.sin(math.radians(p[2]))]) for p in (a, b))
        pieces.append(start * a[:2] + leave * out + arrive * into + (1 - start) * b[:2])
    xy = np.concatenate(pieces)
    xy = xy[np.append(True, np.hypot(*np.diff(xy, axis=0).T) > 1e-9)]
    way = np.append(0.0, np.cumsum(np.hypot(*np.diff(xy, axis=0).T)))
    slope = np.gradient(xy, way, axis=0)
    return np.column_stack([way, xy, np.unwrap(np.arctan2(slope[:, 1], slope[:, 0]))])


def profile(path: Array, speed: float, accel: float, dt: float) -> tuple[Array, Array]:
    """Way [m] at each time [s] of a trapezoid of speed."""
    length = path[-1, 0]
    ramp = min(speed / accel, math.sqrt(length / accel))
    top = accel * ramp
    total = 2 * ramp + (length - top * ramp) / top
    time = np.arange(0.0, total, dt)
    rest = np.minimum(time, total - time)
    ramped = 0.5 * accel * np.minimum(rest, ramp) ** 2 + top * np.maximum(rest - ramp, 0.0)
    return np.where(time < total / 2, ramped, length - ramped), time
