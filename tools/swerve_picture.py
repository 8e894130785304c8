#!/usr/bin/env python3
"""Draw docs/pictures/swerve.svg, the README's picture of the swerve robot, from runs of the package itself.

Usage: .venv/bin/python tools/swerve_picture.py
"""

from pathlib import Path

import numpy as np

from holodrive.actuators.machine import simulate
from holodrive.cli.sheet import sheet
from holodrive.experiments.pictures import paths_over
from holodrive.experiments.swerve import figures, printed, robots, runs
from holodrive.reports.plots import DASHES, Chart, Line
from holodrive.robots import motors

SHOWN = (robots.BLDC, robots.DC_HENRY, robots.DC_MILLI)
SIZE = {"width": 470.0, "height": 330.0}
LOAD_N_M, SETTLED_S, SHOWN_S = 0.05, 0.5, 0.004


def main():
    """Write the picture."""
    tracks = [runs.drive(setup) for setup in SHOWN]
    ways = [(track.setup.name, track.pose) for track in tracks]
    steering = [(track.setup.name, track.time, track.steer_deg[:, 1]) for track in tracks]
    pictures = [
        ("To (10, 10) m and 180°", paths_over(figures.floor(printed.GOAL_FIGURES), ways, 420.0, 420.0)),
        ("How far it still is", over_time("Distance", "m", [(t.setup.name, t.time, t.error) for t in tracks])),
        ("Steering of one module", over_time("Angle", "°", steering)),
        ("Torque of one sinusoidal motor", over_time("Torque over its mean", "%", torques())),
    ]
    path = Path(__file__).resolve().parents[1] / "docs" / "pictures" / "swerve.svg"
    path.write_text(sheet(pictures, "The swerve robot with BLDC and DC motors"), encoding="utf-8")


def over_time(title, unit, lines):
    """A chart of lines (name, time, values)."""
    drawn = tuple(Line(name, time, values, i, dash=DASHES[i]) for i, (name, time, values) in enumerate(lines))
    return Chart(title, unit, drawn, **SIZE).svg()


def torques():
    """Torque in steady load, six-step and field-oriented, over a few milliseconds [%]."""
    motor = motors.load("bldc-sine-16pole-9to1")
    lines = []
    for drive, name in (("six_step", "six-step"), ("foc", "field-oriented")):
        found = simulate(motor, 0.5, LOAD_N_M * motor.gear, SETTLED_S + SHOWN_S, 2e-5, drive=drive)
        since = found.time >= SETTLED_S
        torque = found.torque[since]
        lines.append((name, found.time[since] - SETTLED_S, 100.0 * torque / np.mean(torque)))
    return lines


if __name__ == "__main__":
    main()
