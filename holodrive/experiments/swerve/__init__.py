"""Rosyidin, Siradjuddin, Putri and Achmadiyah, 'Kinematic of 3-Wheels Swerve Drive Using BLDC Motor'."""

from holodrive.experiments.experiment import Experiment, Part
from holodrive.experiments.swerve import equations, figures, motors, runs, search, verdict

EXPERIMENT = Experiment(
    "swerve",
    "Rosyidin et al.: three-wheel swerve drive, BLDC against DC motors",
    "Equations, motors and figures of the paper beside what this software finds, with a verdict. Gains, sizes, supply "
    "and the BLDC motor's data are not printed: the robots here are settings in which the paper's pictures appear, and "
    "a search says how much of them is the motor.",
    (
        Part("equations", "Equations 6 to 34", equations.equations),
        Part("motors", "References [28] and [29]: the motors", motors.motors),
        Part("runs", "Section 3: both goals, five sets of motors", runs.runs),
        Part("figure-6", "Figure 6: pose and error with BLDC motors", figures.figure_6),
        Part("figure-7", "Figure 7: wheel speeds and steering with BLDC motors", figures.figure_7),
        Part("figure-8", "Figure 8: pose and error with DC motors", figures.figure_8),
        Part("figure-9", "Figure 9: wheel speeds and steering with DC motors", figures.figure_9),
        Part("replay", "The robots side by side", figures.replay),
        Part("search", "Is it the motor? One grid of settings for all", search.search),
        Part("mass", "Beyond: the same robots with a mass", verdict.mass),
        Part("verdict", "Verdict on the paper's claim", verdict.verdict),
    ),
)

__all__ = ["EXPERIMENT"]
