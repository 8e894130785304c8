"""How far from the truth does odometry by two ball mice end: printed, corrected, and as a rigid body?

    python benchmarks/mouse_odometry.py [--motions 20] [--save]

Random smooth motions of 30 s: each component of the body twist is a sum of five sines of 0.02 to 0.5 Hz, at most
37 mm/s (the paper's fastest) and 0.5 rad/s. Mouse 1 is the robot's centre, mouse 2 lies D = 100 mm ahead; what they see
is the exact integral of their velocity in their own axes over each sample, counted in whole 10 um with the rest
carried on, or not counted at all. The truth is the pose at the end, integrated in steps of 0.5 ms. Printed and
corrected are the recursions of Keek et al., eq. 1 to 7 (`holodrive.estimation.mouse_recursion`), rigid is
`holodrive.estimation.mouse_odometry`. The table has medians of the end errors over the motions; `lost` are motions in
which the printed recursion has put mouse 2 on mouse 1, so that it knows no heading any more.
Exit code 1 when the bar is missed: rigid at 5 ms with counts below 0.05 mm and 0.02 deg.
"""

import argparse
import math
import platform
import sys
from pathlib import Path

import numpy as np

from holodrive import geometry
from holodrive.estimation import mouse_odometry, mouse_recursion
from holodrive.types import Pose

BASELINE_M, COUNT_M, LENGTH_S = 0.1, 1e-5, 30.0
FASTEST = np.array([0.037, 0.037, 0.5])  # m/s, m/s, rad/s
SINES, LOWEST_HZ, HIGHEST_HZ = 5, 0.02, 0.5
FINE_S = 5e-4
SAMPLES_S = (0.005, 0.015)
BAR_MM, BAR_DEG = 0.05, 0.02
MOUNTS = (Pose(0.0, 0.0, 0.0), Pose(BASELINE_M, 0.0, 0.0))


class Motion:
    """A body twist over time whose integral is known in closed form."""

    def __init__(self, seed):
        generator = np.random.default_rng(seed)
        self.size = generator.uniform(0.2, 1.0, size=(3, SINES))
        self.size *= FASTEST[:, None] / self.size.sum(axis=1, keepdims=True)
        self.rate = 2.0 * np.pi * np.exp(generator.uniform(np.log(LOWEST_HZ), np.log(HIGHEST_HZ), size=(3, SINES)))
        self.phase = generator.uniform(0.0, 2.0 * np.pi, size=(3, SINES))

    def increments(self, dt_s):
        """(N, 3) integrals of the body twist over each sample."""
        time = np.linspace(0.0, LENGTH_S, round(LENGTH_S / dt_s) + 1)
        whole = -self.size / self.rate * np.cos(self.rate * time[:, None, None] + self.phase)
        return np.diff(whole.sum(axis=2), axis=0)

    def end(self):
        """True pose at the end: chords of exact arcs, so short that the change of the twist within one is nothing."""
        x, y, turn = self.increments(FINE_S).T
        heading = np.cumsum(turn) - 0.5 * turn
        place = np.sum(np.sinc(0.5 * turn / np.pi) * np.exp(1j * heading) * (x + 1j * y))
        return np.array([place.real, place.imag, turn.sum()])


def seen(steps, count_m):
    """(N, 2, 2) what both mice tell of body motions (N, 3): x ahead, y to the left."""
    ways = np.stack([steps[:, :2], steps[:, :2] + np.outer(steps[:, 2], (0.0, BASELINE_M))], axis=1)
    if not count_m:
        return ways
    counts = np.floor(np.cumsum(ways, axis=0) / count_m + 1e-9)
    return count_m * np.diff(counts, axis=0, prepend=np.zeros((1, 2, 2)))


def by_recursion(rule, ways):
    """End pose (x ahead, y left, counter-clockwise) by a recursion in the paper's axes: x right, y ahead, clockwise."""
    right_ahead = np.stack([-ways[..., 1], ways[..., 0]], axis=-1).reshape(len(ways), 4)
    x, y, alpha = rule(right_ahead, BASELINE_M)[-1]
    return np.array([y, -x, -alpha])


def by_rigid_body(ways, dt_s):
    """End pose by the exact rigid form."""
    return mouse_odometry.track(MOUNTS, ways, dt_s=dt_s, resolution_m=COUNT_M).pose[-1]


def errors(motion, dt_s, count_m):
    """Method -> (end error [mm], heading error [deg])."""
    ways, truth = seen(motion.increments(dt_s), count_m), motion.end()
    ends = {
        "printed": by_recursion(mouse_recursion.printed, ways),
        "corrected": by_recursion(mouse_recursion.corrected, ways),
        "rigid": by_rigid_body(ways, dt_s),
    }
    return {name: off(end, truth) for name, end in ends.items()}


def off(end, truth):
    """(mm, deg); infinite where the recursion has put mouse 2 on mouse 1 and knows no heading any more."""
    if not np.isfinite(end).all():
        return math.inf, math.inf
    return 1e3 * math.dist(end[:2], truth[:2]), math.degrees(abs(float(geometry.wrap(end[2] - truth[2]))))


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--motions", type=int, default=20)
    parser.add_argument("--save", action="store_true", help="write the table into results/")
    arguments = parser.parse_args()
    motions = [Motion(seed) for seed in range(arguments.motions)]
    lines = [
        f"{platform.machine()}, Python {platform.python_version()}, {arguments.motions} motions of {LENGTH_S:g} s, "
        f"D = {1e3 * BASELINE_M:g} mm; median end error in mm and deg",
        f"{'sample':8s} {'counts':8s} {'printed':>18s} {'corrected':>18s} {'rigid':>18s}  lost",
    ]
    reached = True
    for dt_s in SAMPLES_S:
        for count_m in (COUNT_M, 0.0):
            rows = [errors(motion, dt_s, count_m) for motion in motions]
            found = {name: np.median([row[name] for row in rows], axis=0) for name in rows[0]}
            lost = sum(math.isinf(row["printed"][0]) for row in rows)
            cells = " ".join(f"{mm:9.4f} {deg:8.4f}" for mm, deg in found.values()) + f" {lost:5d}"
            lines.append(f"{1e3 * dt_s:3.0f} ms   {'10 um' if count_m else 'none':8s} {cells}")
            if dt_s == SAMPLES_S[0] and count_m:
                reached = found["rigid"][0] < BAR_MM and found["rigid"][1] < BAR_DEG
    lines.append(
        f"bar: rigid at 5 ms with counts below {BAR_MM} mm and {BAR_DEG} deg: {'reached' if reached else 'missed'}"
    )
    text = "\n".join(lines)
    print(text)
    if arguments.save:
        path = Path(__file__).parent / "results" / "mouse_odometry.txt"
        path.write_text(text + "\n", encoding="utf-8")
    return 0 if reached else 1


if __name__ == "__main__":
    sys.exit(main())
