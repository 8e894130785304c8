"""Peers of the roll-out benchmark, in a process of their own: `python _peers.py`, then one line for each request.

A request is `NAME SECONDS` on standard input; the answer is one JSON line with the wall time that NAME took to
simulate SECONDS, or with why it cannot. Worlds come from `world.json` in the folder given as the first argument.
"""

import json
import math
import os
import sys
import time
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path

FOLDER = Path(sys.argv[1])
WORLD = json.loads((FOLDER / "world.json").read_text())
RADIUS, BEAMS, RANGE = 0.28, 360, 12.0


class IrSim:
    """ir-sim's kinematic omni robot with a 360-beam lidar, one step for each scan (10 Hz)."""

    package, dt = "ir-sim", 0.1

    def __init__(self):
        import irsim
        import numpy as np

        self.np = np
        circles = "".join(
            f"  - {{shape: {{name: circle, radius: {r}}}, state: [{x}, {y}, 0]}}\n" for x, y, r in WORLD["circles"]
        )
        lines = "".join(
            f"  - {{shape: {{name: linestring, vertices: [[{a}, {b}], [{c}, {d}]]}}, state: [0, 0, 0]}}\n"
            for a, b, c, d in WORLD["segments"]
        )
        x, y, theta = WORLD["start"]
        gx, gy, gt = WORLD["goal"]
        path = FOLDER / "irsim.yaml"
        path.write_text(
            f"world: {{height: 6, width: 8, step_time: {self.dt}}}\n"
            f"robot:\n  - kinematics: {{name: omni}}\n    shape: {{name: circle, radius: {RADIUS}}}\n"
            f"    state: [{x}, {y}, {theta}]\n    goal: [{gx}, {gy}, {gt}]\n    vel_max: [0.1, 0.1]\n"
            f"    vel_min: [-0.1, -0.1]\n    sensors:\n      - {{type: lidar2d, range_min: 0.15, range_max: {RANGE}, "
            f"angle_range: {2.0 * math.pi}, number: {BEAMS}, noise: true, std: 0.01}}\n"
            f"obstacle:\n{circles}{lines}"
        )
        self.env = irsim.make(str(path), display=False, log_level="ERROR")
        self.goal = gx, gy

    def run(self, seconds):
        """Go to the goal with a proportional law, reading each scan."""
        env = self.env
        env.reset()
        for _ in range(round(seconds / self.dt)):
            x, y, theta = env.robot.state[:3, 0]
            dx, dy = self.goal[0] - x, self.goal[1] - y
            scale, c, s = 0.086 / max(math.hypot(dx, dy), 0.086), math.cos(theta), math.sin(theta)
            env.step(self.np.array([[scale * (c * dx + s * dy)], [scale * (c * dy - s * dx)]]))  # body axes
            env.get_lidar_scan()


class MuJoCo:
    """A 4-wheel base in MuJoCo at 1 kHz, 360 rays at 10 Hz: 3-D contacts, wheels without rollers."""

    package = "mujoco"

    def __init__(self):
        import mujoco
        import numpy as np

        wheels = "".join(
            f'<body pos="{x} {y} 0"><joint name="w{i}" axis="0 1 0" damping="0.01"/>'
            f'<geom type="ellipsoid" size=".051 .02 .051" friction="0.6"/></body>'
            for i, (x, y) in enumerate(((0.16, 0.16), (0.16, -0.16), (-0.16, 0.16), (-0.16, -0.16)))
        )
        posts = "".join(f'<geom type="cylinder" pos="{x} {y} .25" size="{r} .25"/>' for x, y, r in WORLD["circles"])
        walls = "".join(
            f'<geom type="box" pos="{(a + c) / 2} {(b + d) / 2} .25" size="{math.hypot(c - a, d - b) / 2} .005 .25" '
            f'euler="0 0 {math.degrees(math.atan2(d - b, c - a))}"/>'
            for a, b, c, d in WORLD["segments"]
        )
        motors = "".join(f'<velocity joint="w{i}" kv="0.5"/>' for i in range(4))
        x, y, _ = WORLD["start"]
        self.mujoco, self.np = mujoco, np
        self.model = mujoco.MjModel.from_xml_string(
            f'<mujoco><option timestep="0.001" integrator="implicitfast"/><worldbody>'
            f'<geom type="plane" size="20 20 1"/><body name="base" pos="{x} {y} 0.052"><freejoint/>'
            f'<geom type="cylinder" size=".2 .03" pos="0 0 .05" mass="3"/>{wheels}</body>{posts}{walls}</worldbody>'
            f"<actuator>{motors}</actuator></mujoco>"
        )
        self.data = mujoco.MjData(self.model)
        angles = np.arange(BEAMS) * 2.0 * np.pi / BEAMS
        self.rays = np.column_stack([np.cos(angles), np.sin(angles), np.zeros(BEAMS)])
        self.body = self.model.body("base").id

    def run(self, seconds):
        """Constant wheel speeds, a new command each 10 ms, rays each 100 ms."""
        mujoco, np, model, data = self.mujoco, self.np, self.model, self.data
        geom, distance = np.zeros(BEAMS, dtype=np.int32), np.zeros(BEAMS)
        for k in range(round(seconds * 100)):
            data.ctrl[:] = 1.0, 1.2, 1.0, 1.2
            if k % 10 == 0:
                origin = data.xpos[self.body] + (0.0, 0.0, 0.1)
                turned = (self.rays @ data.xmat[self.body].reshape(3, 3).T).ravel()
                mujoco.mj_multiRay(model, data, origin, turned, None, 1, self.body, geom, distance, None, BEAMS, RANGE)
            mujoco.mj_step(model, data, 10)


def answer(made, name, seconds):
    kind = {"irsim": IrSim, "mujoco": MuJoCo}[name]
    if name not in made:
        made[name] = kind()
        made[name].run(1.0)  # first calls compile and cache
    start = time.perf_counter()
    made[name].run(seconds)
    return {"wall_s": time.perf_counter() - start, "version": version(kind.package)}


def main():
    made = {}
    # what the peers print must not come between the answers
    channel, sys.stdout = os.fdopen(os.dup(1), "w"), sys.stderr
    for line in sys.stdin:
        name, seconds = line.split()
        try:
            reply = answer(made, name, float(seconds))
        except (ImportError, PackageNotFoundError) as error:
            reply = {"error": f"not installed ({error})"}
        channel.write(json.dumps(reply) + "\n")
        channel.flush()


main()
