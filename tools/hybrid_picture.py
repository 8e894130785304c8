#!/usr/bin/env python3
"""Draw docs/pictures/hybrid.svg, the README's picture of the hybrid robot, from runs of the package itself.

Usage: .venv/bin/python tools/hybrid_picture.py
"""

from pathlib import Path

from holodrive import worlds
from holodrive.cli.sheet import sheet
from holodrive.control import fuzzy
from holodrive.experiments.hybrid import courses, variants
from holodrive.experiments.pictures import paths_over
from holodrive.reports.lidar import look, polar_svg
from holodrive.reports.surface import surface

SHOWN = ("repaired", "Table VIII as printed", "Table VII as printed")
RANDOM = 100_026  # a random course in which the printed rules run into something


def main():
    """Write the picture."""
    course = worlds.load("paper_course")
    runs = {v.name: courses.on_course(v, course) for v in courses.ON_COURSE if v.name in SHOWN}
    world = worlds.course(RANDOM)
    random = [(v.name, variants.path(v, RANDOM)) for v in (variants.REPAIRED, variants.PRINTED_VIII)]
    system = fuzzy.load("repaired")
    pictures = [
        ("The paper's course", paths_over(course, [(name, run.pose) for name, run in runs.items()], 420.0, 520.0)),
        ("What the lidar tells", polar_svg(look(runs["repaired"]))),
        ("What the rules answer", surface(system, ("DH", "DL"), 1, (700.0, 300.0, 2000.0)).svg()),
        ("A random world", paths_over(world, random, 420.0, 520.0)),
    ]
    path = Path(__file__).resolve().parents[1] / "docs" / "pictures" / "hybrid.svg"
    path.write_text(sheet(pictures, "Fuzzy obstacle avoidance of the hybrid base"), encoding="utf-8")


if __name__ == "__main__":
    main()
