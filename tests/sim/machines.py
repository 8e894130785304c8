"""Robots made in code for the simulator's tests: small numbers that a reader can check."""

import math
from dataclasses import replace
from typing import Any

from holodrive.robots.spec import Encoder, Ground, Lidar, Motor, Robot, Steering, WheelSpec

FREE_SPEED = 22.0 * 2.0 * math.pi / 60.0  # rad/s

GEARMOTOR = Motor(
    "jgb37", "dc", 12.0, FREE_SPEED, 5.2, 2.1,
    efficiency=0.6, coulomb_friction_n_m=0.05, inertia_kg_m2=5e-3, current_limit_a=3.0, lag_s=0.05,
)  # fmt: skip


def wheel(name: str, kind: Any, x: float, y: float, yaw: float, radius: float, roller_deg: float = 0.0) -> WheelSpec:
    return WheelSpec(
        name, kind, x, y, yaw, radius, GEARMOTOR, FREE_SPEED,
        roller=math.radians(roller_deg), encoder=Encoder(1600.0), steering=Steering() if kind == "swerve" else None,
    )  # fmt: skip


def hybrid(**changes: Any) -> Robot:
    """The first paper's base: one omni wheel in front, two Mecanum wheels behind."""
    wheels = []
    for name, kind, angle, roller in (("front", "omni", 0.0, 0.0), ("right", "mecanum", -120.0, 45.0), ("left", "mecanum", 120.0, -45.0)):  # fmt: skip  # noqa: E501
        a = math.radians(angle)
        wheels.append(wheel(name, kind, 0.23 * math.cos(a), 0.23 * math.sin(a), a + 0.5 * math.pi, 0.051, roller))
    return replace(Robot("hybrid", tuple(wheels), 3.26, 0.086, 0.28), **changes)


def mecanum(**changes: Any) -> Robot:
    """Four Mecanum wheels of 30 mm radius, 20 x 15 cm."""
    places = (("fl", 0.1, 0.075, -45.0), ("fr", 0.1, -0.075, 45.0), ("rl", -0.1, 0.075, 45.0), ("rr", -0.1, -0.075, -45.0))  # fmt: skip  # noqa: E501
    wheels = tuple(wheel(name, "mecanum", x, y, 0.0, 0.03, roller) for name, x, y, roller in places)
    return replace(Robot("mecanum", wheels, 2.0, 0.02, 0.15), **changes)


def swerve(**changes: Any) -> Robot:
    """Three steered wheels on a triangle."""
    wheels = tuple(
        wheel(f"s{i}", "swerve", 0.3 * math.cos(a), 0.3 * math.sin(a), 0.0, 0.05)
        for i, a in enumerate((0.0, 2.0 * math.pi / 3.0, -2.0 * math.pi / 3.0))
    )
    return replace(Robot("swerve", wheels, 8.0, 0.3, 0.4), **changes)


def with_motor(robot: Robot, **changes: Any) -> Robot:
    """The robot with other motors."""
    wheels = tuple(replace(w, motor=replace(w.motor, **changes)) for w in robot.wheels)
    return replace(robot, wheels=wheels)


def ideal_lidar(**changes: Any) -> Lidar:
    """No noise, whole scans at once."""
    return replace(Lidar("ideal", motion_distortion=False, range_min=0.0, range_max=100.0), **changes)


SLIPPERY = Ground(friction=0.02)
