#!/usr/bin/env python3
"""Draw docs/pictures/mecanum.svg, the README's picture of the Mecanum robot, from runs of the package itself.

Usage: .venv/bin/python tools/mecanum_picture.py
"""

from dataclasses import replace
from pathlib import Path

import numpy as np

from holodrive import planning
from holodrive.cli.sheet import sheet
from holodrive.experiments.experiment import Setting
from holodrive.experiments.mecanum import actuators, comparison, floor, gains, paths, printed, tracking
from holodrive.experiments.mecanum.tracking import Variant
from holodrive.reports.plots import DASHES, Chart, Line

SHOWN = (tracking.PRINTED, tracking.COSINE, Variant("disturbance observer", controller="dob"))
SIZE = {"width": 470.0, "height": 330.0}


def main():
    """Write the picture."""
    path = paths.infinity()
    runs = {variant.name: comparison.driven(variant, path, 1) for variant in SHOWN}
    gain_chart = replace(gains.figure_9(Setting()).sections[0].charts[0], **SIZE)
    pictures = [
        ("Its motors: PWM over speed", curves().svg()),
        ("The paper's gains", gain_chart.svg()),
        ("The infinity, 10 times the error", floor.picture("∞", magnified(path, runs))),
        ("Distance from the path", distances(path, runs).svg()),
    ]
    target = Path(__file__).resolve().parents[1] / "docs" / "pictures" / "mecanum.svg"
    target.write_text(sheet(pictures, "Path tracking of the Mecanum robot"), encoding="utf-8")


def curves():
    """The four printed cubics up to full PWM."""
    lines = []
    for i, name in enumerate(printed.CUBICS):
        speeds = np.linspace(0.0, actuators.speed_at(name, printed.PWM_TOP), 200)
        lines.append(Line(name.replace("_", " "), speeds, actuators.pwm_at(name, speeds), i, dash=DASHES[i]))
    return Chart("PWM", "of 255", tuple(lines), x_name="speed", x_unit="mm/s", low=0.0, **SIZE)


def magnified(path, runs):
    """Paths on which the robot is ten times as far from its nearest place of the path as it was."""
    places = path.rows[:, 1:3]
    ways = [("path", places)]
    for name, run in runs.items():
        nearest = places[np.argmin(np.hypot(*(run.pose[:, None, :2] - places[None]).T).T, axis=1)]
        ways.append((name, nearest + 10.0 * (run.pose[:, :2] - nearest)))
    return ways


def distances(path, runs):
    """Distance from the path over time."""
    lines = [
        Line(name, run.time, 1e3 * planning.distance_to_path(path, run.pose), i, dash=DASHES[i])
        for i, (name, run) in enumerate(runs.items())
    ]
    return Chart("Distance", "mm", tuple(lines), low=0.0, **SIZE)


if __name__ == "__main__":
    main()
