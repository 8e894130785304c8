"""Bases of every kind, and random ones."""

import math

import numpy as np
import pytest

from holodrive.errors import ChassisError
from holodrive.kinematics import Chassis, Wheel


def hybrid3() -> Chassis:
    third = 2.0 * math.pi / 3.0
    speed = 22.0 * 2.0 * math.pi / 60.0
    wheels = {
        "front": Wheel.from_paper(0.0, 0.0, -math.pi / 2, 0.23, 0.051),
        "right": Wheel.from_paper(-third, -third, math.pi / 4, 0.23, 0.051),
        "left": Wheel.from_paper(third, third, -math.pi / 4, 0.23, 0.051),
    }
    return Chassis({name: limited(wheel, speed) for name, wheel in wheels.items()})


def limited(wheel: Wheel, speed: float) -> Wheel:
    from dataclasses import replace

    return replace(wheel, max_speed=speed)


def ring(count: int, radius: float, wheel_radius: float, start: float = 0.0) -> Chassis:
    angles = [start + 2.0 * math.pi * i / count for i in range(count)]
    return Chassis(
        [
            Wheel.omni(radius * math.cos(a), radius * math.sin(a), a + math.pi / 2, wheel_radius, max_speed=10.0)
            for a in angles
        ]
    )


def mecanum4(lx: float = 0.2, ly: float = 0.15, radius: float = 0.03) -> Chassis:
    places = {"fl": (lx, ly, -1), "fr": (lx, -ly, 1), "rl": (-lx, ly, 1), "rr": (-lx, -ly, -1)}
    return Chassis(
        {
            name: Wheel.mecanum(x, y, 0.0, radius, side * math.pi / 4, max_speed=20.0)
            for name, (x, y, side) in places.items()
        }
    )


def swerve4(half: float = 0.3, steer_rate: float = math.inf) -> Chassis:
    places = {"fl": (half, half), "fr": (half, -half), "rl": (-half, half), "rr": (-half, -half)}
    return Chassis(
        {name: Wheel.swerve(x, y, 0.05, max_speed=80.0, steer_rate=steer_rate) for name, (x, y) in places.items()}
    )


def swerve3() -> Chassis:
    angles = {"front": 0.0, "right": -2.0 * math.pi / 3.0, "left": 2.0 * math.pi / 3.0}
    return Chassis(
        {name: Wheel.swerve(0.3 * math.cos(a), 0.3 * math.sin(a), 0.1, max_speed=70.0) for name, a in angles.items()}
    )


def mixed() -> Chassis:
    """One omni, one Mecanum and one steered wheel, whose zero angle is not ahead, all of other sizes."""
    return Chassis(
        {
            "omni": Wheel.omni(0.23, 0.0, math.pi / 2, 0.051, max_speed=12.0),
            "mecanum": Wheel.mecanum(-0.115, -0.2, -math.pi / 6, 0.06, math.pi / 4, max_speed=15.0),
            "swerve": Wheel.swerve(-0.1, 0.2, 0.04, yaw=0.3, max_speed=25.0),
        }
    )


MAKERS = {
    "hybrid3": hybrid3,
    "omni3": lambda: ring(3, 0.23, 0.051),
    "omni4": lambda: ring(4, 0.2, 0.05, math.pi / 4),
    "mecanum4": mecanum4,
    "swerve3": swerve3,
    "swerve4": swerve4,
    "mixed": mixed,
}


@pytest.fixture(scope="session", params=MAKERS)
def base(request) -> Chassis:
    """Each kind of base in turn."""
    return MAKERS[request.param]()


@pytest.fixture(scope="session")
def bases() -> dict:
    """All kinds of base."""
    return {name: make() for name, make in MAKERS.items()}


def random_wheel(rng: np.random.Generator) -> Wheel:
    x, y, yaw = *rng.uniform(-0.5, 0.5, 2), rng.uniform(-math.pi, math.pi)
    radius, speed = rng.uniform(0.02, 0.2), rng.uniform(1.0, 100.0)
    match rng.integers(4):
        case 0:
            return Wheel.omni(x, y, yaw, radius, max_speed=speed)
        case 1:
            return Wheel.mecanum(x, y, yaw, radius, rng.choice([-1, 1]) * math.pi / 4, max_speed=speed)
        case 2:
            return Wheel.mecanum(x, y, yaw, radius, rng.uniform(-1.3, 1.3), max_speed=speed)
        case _:
            return Wheel.swerve(x, y, radius, yaw=yaw, max_speed=speed)


def random_chassis(seed: int) -> Chassis:
    """A sound base of three to six random wheels of any kinds."""
    rng = np.random.default_rng(seed)
    while True:
        try:
            return Chassis([random_wheel(rng) for _ in range(rng.integers(3, 7))])
        except ChassisError:
            continue


@pytest.fixture(scope="session")
def chassis_of_seed():
    """seed -> a random sound base."""
    return random_chassis
