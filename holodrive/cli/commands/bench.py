"""`holodrive bench`: a few figures of this machine in a minute; the comparisons with others lie in benchmarks/."""

import subprocess
import sys
import time
from collections.abc import Callable
from statistics import median
from typing import Any, NamedTuple

from holodrive.cli.compiling import compiling
from holodrive.cli.options import verb
from holodrive.cli.output import Output

REPEATS = 5


class Figure(NamedTuple):
    """One measured number."""

    name: str
    value: float
    unit: str


@verb("bench", ["", "--json"])
def command(out: Output) -> None:
    """Measure start-up, a control tick, the simulation loop and compiled batches on this machine."""
    figures: list[Figure] = []
    with compiling(out), out.progress("bench", len(MEASURES), "measures") as update:
        for number, measure in enumerate(MEASURES):
            figures += measure()
            update(number + 1)
    if out.json:
        out.data([figure._asdict() for figure in figures])
    else:
        out.table(("measure", "value", "unit"), [(name, f"{value:.4g}", unit) for name, value, unit in figures])
    out.next("make bench (in a checkout: the same against other programs)")


def start_up() -> list[Figure]:
    """Time to import, in fresh interpreters, over that of doing nothing."""

    def cost(code: str) -> float:
        times = []
        for _ in range(REPEATS):
            began = time.perf_counter()
            subprocess.run([sys.executable, "-c", code], check=True)
            times.append(time.perf_counter() - began)
        return median(times)

    nothing = cost("pass")
    names = ("holodrive", "numpy")
    return [Figure(f"import {name}", 1e3 * (cost(f"import {name}") - nothing), "ms") for name in names]


def control_tick() -> list[Figure]:
    """Kinematics of one tick in plain floats."""
    import holodrive as hd
    from holodrive.kinematics.pipeline import CommandPipeline

    robot = hd.load("swerve4")
    chassis, pipeline = hd.Chassis.of(robot), CommandPipeline(robot)
    twist = hd.Twist(0.3, 0.2, 0.5)
    wheels = chassis.scalar.inverse(*twist)
    return [
        Figure("swerve4 inverse", 1e6 * _seconds(lambda: chassis.scalar.inverse(*twist)), "us"),
        Figure("swerve4 forward", 1e6 * _seconds(lambda: chassis.scalar.forward(*wheels)), "us"),
        Figure("swerve4 command step", 1e6 * _seconds(lambda: pipeline.step(twist, robot.control_period_s)), "us"),
    ]


def loop() -> list[Figure]:
    """The ordinary loop: hybrid3 with lidar in a room, log in memory."""
    import holodrive as hd

    def drive(seconds: float) -> float:
        base = hd.simulate("hybrid3", "room")
        began = time.perf_counter()
        run = hd.drive(base, goal=tuple(base.truth), duration_s=seconds, stop_on_arrival=False)
        return float(run.time[-1]) / (time.perf_counter() - began)

    drive(0.5)  # compiles
    return [Figure("loop with lidar, one robot", median(drive(10.0) for _ in range(3)), "x real time")]


def batches() -> list[Figure]:
    """Closed loops in compiled batches: 1 ms physics, 100 Hz control, lidar at its rate."""
    import holodrive as hd

    figures = []
    for plant in ("first_order", "slip"):
        for n, seconds in ((1, 30.0), (256, 5.0)):
            options: dict[str, Any] = {"n": n, "t": seconds, "plant": plant, "goals": (2.0, 2.0, 0.0)}
            hd.rollout("hybrid3", "bench", **{**options, "t": 0.1})  # compiles
            times = []
            for _ in range(3):
                began = time.perf_counter()
                hd.rollout("hybrid3", "bench", **options)
                times.append(time.perf_counter() - began)
            rate = n * seconds * 1000.0 / median(times) / 1e6
            figures.append(Figure(f"batch of {n}, {plant}", rate, "M robot-steps/s"))
    return figures


def _seconds(call: Callable[[], object], count: int = 20000) -> float:
    """Median time of one call."""
    times = []
    for _ in range(REPEATS):
        began = time.perf_counter()
        for _ in range(count):
            call()
        times.append((time.perf_counter() - began) / count)
    return median(times)


MEASURES = (start_up, control_tick, loop, batches)
