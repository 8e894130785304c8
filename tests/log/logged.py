"""Random runs for the tests of the log."""

import numpy as np

from holodrive.log import Tick
from holodrive.robots.spec import Robot
from holodrive.types import (
    Array,
    Command,
    DutyCommand,
    Estimate,
    Pose,
    Reference,
    Scan,
    Twist,
    WheelCommand,
    WheelState,
)


def tick(
    robot: Robot,
    time: float,
    rng: np.random.Generator,
    *,
    command: str = "twist",
    truth: bool = True,
    sensors: bool = True,
) -> Tick:
    """One tick of random numbers, of the sensors that the robot has."""
    n, m = len(robot.wheels), len(robot.steered)
    decided: Command = Twist(*rng.normal(size=3))
    if command == "wheels":
        decided = WheelCommand(rng.normal(size=n), rng.normal(size=m))
    elif command == "duty":
        decided = DutyCommand(rng.uniform(-1, 1, size=n), rng.normal(size=m))
    return Tick(
        time=time,
        estimate=Estimate(Pose(*rng.normal(size=3) * 10), Twist(*rng.normal(size=3)), rng.normal(size=(3, 3)), 0.1),
        reference=Reference(Pose(*rng.normal(size=3)), last=bool(rng.integers(2))),
        decided=decided,
        applied=WheelCommand(rng.normal(size=n), rng.normal(size=m)),
        wheels=WheelState(rng.normal(size=n) * 100, rng.normal(size=n), rng.normal(size=m)),
        truth=Pose(*rng.normal(size=3)) if truth else None,
        true_twist=Twist(*rng.normal(size=3)) if truth else None,
        duty=rng.uniform(-1, 1, size=n) if truth else None,
        gyro=float(rng.normal()) if sensors and robot.imu else None,
        accel=rng.normal(size=2) if sensors and robot.imu else None,
        mice=rng.normal(size=(len(robot.mice), 2)) if sensors and robot.mice else None,
    )


def ticks(robot: Robot, count: int, seed: int = 0, **options: object) -> list[Tick]:
    """`count` ticks of 10 ms."""
    rng = np.random.default_rng(seed)
    return [tick(robot, 0.01 * i, rng, **options) for i in range(count)]  # type: ignore[arg-type]


def scan(stamp: float, beams: int, mount: Pose, *, even: bool = True, seed: int = 0) -> Scan:
    """A clockwise scan with no-returns and invalid beams."""
    rng = np.random.default_rng(seed)
    ranges: Array = rng.uniform(0.2, 12.0, beams)
    ranges[0], ranges[1] = np.inf, np.nan
    angles = -2.0 * np.pi * np.arange(beams) / beams
    if not even:
        angles = angles + rng.uniform(0, 1e-3, beams)
    return Scan(stamp, angles, ranges, np.linspace(-0.18, 0.0, beams), mount, 0.15, 12.0)
