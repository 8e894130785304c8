"""Runs as mice with known mounts would have counted them: any motion, whole counts, and a tape that errs as stated."""

import math
from collections.abc import Sequence

import numpy as np

from holodrive import geometry
from holodrive.calibration import mouse_runs
from holodrive.calibration.mouse_runs import Accuracy, Kind, MouseRun
from holodrive.types import Array, Pose

MICE = ("one", "two")
MOUNTS = (Pose(0.004, -0.003, math.radians(4.0)), Pose(0.098, 0.006, math.radians(-5.0)))
SCALES = np.array([[10.9e-6, 10.9e-6], [9.1e-6, 9.1e-6]])  # m per count
FOOTPRINT_M = 0.29
KINDS: tuple[Kind, ...] = ("spin", "ahead", "left")


def counts_of(
    steps: Array, mounts: Sequence[Pose], scales: Array, generator: np.random.Generator, noise: float = 0.0
) -> Array:
    """(N, k, 2) whole counts over body motions (N, 3); the counters start anywhere inside a count."""
    out = []
    for (x, y, yaw), scale in zip(mounts, scales, strict=True):
        lever = np.array([[1.0, 0.0, -y], [0.0, 1.0, x]])
        ways = geometry.rotate(-yaw, steps @ lever.T) / scale
        ways = ways * (1.0 + noise * generator.normal(size=ways.shape))
        total = np.floor(np.cumsum(ways, axis=0) + generator.uniform(size=2))
        out.append(np.diff(total, axis=0, prepend=np.zeros((1, 2))))
    return np.stack(out, axis=1)


def steps_of(kind: Kind, generator: np.random.Generator, turns: float = 5.5, length_m: float = 1.0) -> Array:
    """(N, 3) body motions of a run that does not go quite as it should, at an uneven pace."""
    turn = 2.0 * math.pi * turns
    whole, n = {
        "spin": ((0.002 * turn, -0.003 * turn, turn), 2000),
        "ahead": ((length_m, 0.01, 0.01), 1000),
        "left": ((0.005, length_m, -0.02), 1000),
    }[kind]
    pace = generator.uniform(0.5, 1.5, size=(n, 3))
    return np.asarray(pace / pace.sum(axis=0) * whole)


def end_of(steps: Array) -> Array:
    """(3,) end pose, one exact arc after the other."""
    pose = np.zeros(3)
    for step in geometry.exp(steps):
        pose = geometry.compose(pose, step)
    return pose


def runs(
    seed: int,
    kinds: Sequence[Kind] = KINDS,
    *,
    mounts: Sequence[Pose] = MOUNTS,
    scales: Array = SCALES,
    turns: float = 5.5,
    length_m: float = 1.0,
    accuracy: Accuracy | None = None,
    noise: float = 0.0,
) -> list[MouseRun]:
    """Runs of these kinds, measured with a tape."""
    generator, exact = np.random.default_rng(seed), accuracy or Accuracy()
    out = []
    for kind in kinds:
        steps = steps_of(kind, generator, turns, length_m)
        read = end_of(steps) + generator.normal(size=3) * (exact.tape_m, exact.tape_m, exact.turn_rad)
        counts = counts_of(steps, mounts, scales, generator, noise)
        if kind == "spin":
            out.append(mouse_runs.spin(kind, counts, float(read[2]), read[:2], exact))
        else:
            out.append(mouse_runs.straight(kind, kind, counts, read[:2], float(read[2]), exact))
    return out
