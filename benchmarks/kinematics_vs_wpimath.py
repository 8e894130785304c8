"""Kinematics against robotpy-wpimath: single calls, the swerve command step, batches. Both in this process, in turn.

    pip install 'holodrive[bench]'
    python benchmarks/kinematics_vs_wpimath.py [--rounds 41] [--save]

Each line is the median over interleaved rounds, so that other load on the machine meets both sides alike. A ratio
is our time over wpimath's; a speed-up is the inverse. The bar of the command step is on plain floats
(`chassis.scalar.command_step`); `CommandPipeline.step`, which keeps the state and gives a WheelCommand, is printed
beside it. Exit code 1 when a bar is missed.
"""

import argparse
import math
import platform
import statistics
import sys
import time
from collections.abc import Callable
from importlib.metadata import version
from pathlib import Path
from typing import NamedTuple

import numpy as np

from holodrive.kinematics import Chassis, Wheel
from holodrive.kinematics.pipeline import CommandPipeline

try:
    from wpimath.geometry import Rotation2d, Translation2d
    from wpimath.kinematics import (
        ChassisSpeeds,
        MecanumDriveKinematics,
        MecanumDriveWheelSpeeds,
        SwerveDrive4Kinematics,
        SwerveModuleState,
    )
except ImportError:
    sys.exit("this benchmark compares with robotpy-wpimath, which is not installed: pip install 'holodrive[bench]'")

HALF, LX, LY = 0.3, 0.2, 0.15  # m
TOP, DT = 4.0, 0.02  # m/s, s
CORNERS = {"fl": (1, 1), "fr": (1, -1), "rl": (-1, 1), "rr": (-1, -1)}
SIDES = {"fl": -1, "fr": 1, "rl": 1, "rr": -1}
BATCH = 5000


class Line(NamedTuple):
    """One comparison: name, our call, theirs, calls or items in each, bar on ours / theirs per item."""

    name: str
    ours: Callable[[], object]
    theirs: Callable[[], object]
    items: int
    their_items: int
    bar: float


def swerve4() -> Chassis:
    """Radius 1 m, so that wheel speeds are rim speeds as in wpimath."""
    return Chassis(
        {n: Wheel.swerve(HALF * a, HALF * b, 1.0, max_speed=TOP, steer_rate=20.0) for n, (a, b) in CORNERS.items()}
    )


def mecanum4() -> Chassis:
    return Chassis(
        {n: Wheel.mecanum(LX * a, LY * b, 0.0, 1.0, SIDES[n] * math.pi / 4) for n, (a, b) in CORNERS.items()}
    )


def wpi_swerve4() -> SwerveDrive4Kinematics:
    return SwerveDrive4Kinematics(*(Translation2d(HALF * a, HALF * b) for a, b in CORNERS.values()))


def wpi_mecanum4() -> MecanumDriveKinematics:
    return MecanumDriveKinematics(*(Translation2d(LX * a, LY * b) for a, b in CORNERS.values()))


def repeat(function: Callable[..., object], times: int, *arguments: object) -> Callable[[], None]:
    def run() -> None:
        for _ in range(times):
            function(*arguments)

    return run


# --- single calls: objects ready, as a user holds them ------------------------------------------


def single_lines() -> list[Line]:
    twist, n = (1.0, 0.5, 1.0), 400
    swerve, mecanum, wpi_swerve, wpi_mecanum = swerve4(), mecanum4(), wpi_swerve4(), wpi_mecanum4()
    speeds = ChassisSpeeds(*twist)
    states, wheels = wpi_swerve.toSwerveModuleStates(speeds), wpi_mecanum.toWheelSpeeds(speeds)
    swerve_wheels, mecanum_wheels = swerve.scalar.inverse(*twist), mecanum.scalar.inverse(*twist)
    same(swerve_wheels, [s.speed for s in states] + [s.angle.radians() for s in states])
    same(mecanum_wheels, [wheels.frontLeft, wheels.frontRight, wheels.rearLeft, wheels.rearRight])
    lines = [
        ("swerve4 inverse", swerve.scalar.inverse, twist, wpi_swerve.toSwerveModuleStates, speeds, 0.6),
        ("swerve4 forward", swerve.scalar.forward, swerve_wheels, wpi_swerve.toChassisSpeeds, states, 0.9),
        ("mecanum4 inverse", mecanum.scalar.inverse, twist, wpi_mecanum.toWheelSpeeds, speeds, 0.6),
        ("mecanum4 forward", mecanum.scalar.forward, mecanum_wheels, wpi_mecanum.toChassisSpeeds, wheels, 0.9),
    ]
    return [
        Line(f"{name}, single, plain floats", repeat(f, n, *a), repeat(g, n, b), n, n, bar)
        for name, f, a, g, b, bar in lines
    ]


# --- command step: limit, discretise, invert, optimise, cosine scale -----------------------------

# slow enough, too fast, and driving backwards
COMMANDS = {"within limits": (0.3, 0.1, 1.0), "saturated": (4.0, 0.5, 6.0), "saturated, backwards": (-4.0, -0.5, 6.0)}


def step_lines() -> list[Line]:
    wpi, n, lines = wpi_swerve4(), 200, []
    for name, twist in COMMANDS.items():
        pipeline = CommandPipeline(swerve4())
        pipeline.step(twist, DT)
        # wheels that have come round: both sides optimise against the angles that they now have
        for _ in range(50):
            pipeline.step(twist, DT)
        current = [Rotation2d(angle) for angle in pipeline.steer]
        theirs = repeat(wpi_step, n, wpi, *twist, current)
        plain, memory = swerve4().scalar.command_step, [0.0, 0.0, 0.0, *pipeline.steer, 0.0, 0.0, 0.0, 0.0]
        lines.append(
            Line(f"swerve4 command step, {name}, plain floats", repeat(plain, n, *twist, DT, memory), theirs, n, n, 0.6)
        )
        lines.append(
            Line(
                f"swerve4 command step, {name}, CommandPipeline.step",
                repeat(pipeline.step, n, twist, DT),
                theirs,
                n,
                n,
                math.inf,
            )
        )
    return lines


def wpi_step(wpi: SwerveDrive4Kinematics, vx: float, vy: float, omega: float, current: list[Rotation2d]) -> object:
    """The documented recipe. (It scales after discretising, which bends straight lines; ours does not.)"""
    states = wpi.toSwerveModuleStates(ChassisSpeeds.discretize(ChassisSpeeds(vx, vy, omega), DT))
    states = SwerveDrive4Kinematics.desaturateWheelSpeeds(states, TOP)
    for state, angle in zip(states, current, strict=True):
        state.optimize(angle)
        state.cosineScale(angle)
    return states


# --- batches: from arrays to arrays, making and reading wpimath's objects included ---------------


def batch_lines() -> list[Line]:
    twists = np.random.default_rng(1).normal(size=(BATCH, 3))
    swerve, mecanum, wpi_swerve, wpi_mecanum = swerve4(), mecanum4(), wpi_swerve4(), wpi_mecanum4()
    few = twists[:200]
    command, wheels = swerve.inverse(twists), mecanum.inverse(twists).speeds
    same(command.speeds[:200], wpi_swerve_inverse(wpi_swerve, few)[:, :4])
    same(wheels[:200], wpi_mecanum_inverse(wpi_mecanum, few))
    same(twists[:200], wpi_swerve_forward(wpi_swerve, command.speeds[:200], command.steer[:200]))
    same(twists[:200], wpi_mecanum_forward(wpi_mecanum, wheels[:200]))
    speeds, steer = command.speeds[:200], command.steer[:200]
    pairs = [
        ("swerve4 inverse", lambda: swerve.inverse(twists), lambda: wpi_swerve_inverse(wpi_swerve, few)),
        ("swerve4 forward", lambda: swerve.forward(*command), lambda: wpi_swerve_forward(wpi_swerve, speeds, steer)),
        ("mecanum4 inverse", lambda: mecanum.inverse(twists), lambda: wpi_mecanum_inverse(wpi_mecanum, few)),
        ("mecanum4 forward", lambda: mecanum.forward(wheels), lambda: wpi_mecanum_forward(wpi_mecanum, wheels[:200])),
    ]
    # theirs is slow: 200 items of it stand for the batch
    return [Line(f"{name}, batch of {BATCH}, per item", a, b, BATCH, len(few), 1 / 20) for name, a, b in pairs]


def wpi_swerve_inverse(wpi: SwerveDrive4Kinematics, twists: np.ndarray) -> np.ndarray:
    out = []
    for vx, vy, omega in twists.tolist():
        states = wpi.toSwerveModuleStates(ChassisSpeeds(vx, vy, omega))
        out.append([s.speed for s in states] + [s.angle.radians() for s in states])
    return np.array(out)


def wpi_swerve_forward(wpi: SwerveDrive4Kinematics, speeds: np.ndarray, steer: np.ndarray) -> np.ndarray:
    out = []
    for row, angles in zip(speeds.tolist(), steer.tolist(), strict=True):
        states = [SwerveModuleState(speed, Rotation2d(angle)) for speed, angle in zip(row, angles, strict=True)]
        found = wpi.toChassisSpeeds(states)
        out.append((found.vx, found.vy, found.omega))
    return np.array(out)


def wpi_mecanum_inverse(wpi: MecanumDriveKinematics, twists: np.ndarray) -> np.ndarray:
    out = []
    for vx, vy, omega in twists.tolist():
        wheels = wpi.toWheelSpeeds(ChassisSpeeds(vx, vy, omega))
        out.append((wheels.frontLeft, wheels.frontRight, wheels.rearLeft, wheels.rearRight))
    return np.array(out)


def wpi_mecanum_forward(wpi: MecanumDriveKinematics, speeds: np.ndarray) -> np.ndarray:
    out = []
    for row in speeds.tolist():
        found = wpi.toChassisSpeeds(MecanumDriveWheelSpeeds(*row))
        out.append((found.vx, found.vy, found.omega))
    return np.array(out)


# --- measuring ----------------------------------------------------------------------------------


def same(a: object, b: object) -> None:
    """Both sides compute the same thing."""
    np.testing.assert_allclose(np.asarray(a, dtype=float), np.asarray(b, dtype=float), atol=1e-9)


def measure(lines: list[Line], rounds: int) -> list[tuple[Line, float, float]]:
    """Median seconds per item of both sides of each line, all lines in turn in every round."""
    ours: list[list[float]] = [[] for _ in lines]
    theirs: list[list[float]] = [[] for _ in lines]
    for _ in range(rounds):
        for i, line in enumerate(lines):
            for function, into in ((line.ours, ours[i]), (line.theirs, theirs[i])):
                start = time.perf_counter()
                function()
                into.append(time.perf_counter() - start)
    results = []
    for line, a, b in zip(lines, ours, theirs, strict=True):
        results.append((line, statistics.median(a) / line.items, statistics.median(b) / line.their_items))
    return results


def report(results: list[tuple[Line, float, float]], rounds: int) -> tuple[str, bool]:
    """The table, and whether all bars are met."""
    head = (
        f"holodrive {version('holodrive')} against robotpy-wpimath {version('robotpy-wpimath')}; "
        f"Python {platform.python_version()}, NumPy {np.__version__}, {platform.machine()}; "
        f"medians of {rounds} interleaved rounds"
    )
    rows = [head, "", f"{'':<66}{'ours':>9}{'wpimath':>10}{'ratio':>8}{'bar':>7}{'speed-up':>10}"]
    good = True
    for line, ours, theirs in results:
        ratio, met = ours / theirs, ours / theirs <= line.bar
        good &= met
        bar = f"{line.bar:>7.2f}" if math.isfinite(line.bar) else f"{'-':>7}"
        times = f"{ours * 1e9:>6.0f} ns{theirs * 1e9:>7.0f} ns{ratio:>8.3f}"
        rows.append(f"{line.name:<66}{times}{bar}{1 / ratio:>9.1f}x{'' if met else '  MISSED'}")
    return "\n".join([*rows, "", "all bars met" if good else "a bar is missed"]), good


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--rounds", type=int, default=41)
    parser.add_argument("--save", action="store_true", help="keep the result beside this script")
    options = parser.parse_args()
    lines = single_lines() + step_lines() + batch_lines()
    measure(lines, 3)
    text, good = report(measure(lines, options.rounds), options.rounds)
    print(text)
    if options.save:
        folder = Path(__file__).parent / "results"
        folder.mkdir(exist_ok=True)
        (folder / "kinematics_vs_wpimath.txt").write_text(text + "\n", encoding="utf-8")
    sys.exit(0 if good else 1)


if __name__ == "__main__":
    main()
