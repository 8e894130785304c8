"""Keek, Loh and Chong, 'Comprehensive Development and Control of a Path-Trackable Mecanum-Wheeled Robot'."""

from holodrive.experiments.experiment import Experiment, Part
from holodrive.experiments.mecanum import (
    actuators,
    comparison,
    complex_paths,
    example,
    gains,
    localisation,
    monte_carlo,
    steps,
    straight,
    tables,
)

# what the paper's own numbers say, computed again
PRINTED = (
    Part("localisation", "Equations 1 to 7: dead reckoning with two mice", localisation.localisation),
    Part("linearization", "Equations 8 to 12: speed of a step, and four cubics", actuators.linearization),
    Part("figure-4", "Figure 4: steps of PWM", steps.figure_4),
    Part("figure-5", "Figure 5: speed over PWM", steps.figure_5),
    Part("figure-7", "Figure 7: cubics fitted to steps", steps.figure_7),
    Part("figure-9", "Figure 9 and equations 13 to 16: gains over the angle", gains.figure_9),
    Part("example", "Equations 17 to 30: the worked example, number by number", example.example),
    Part("table-i", "Table I: IAE of 32 straight paths", tables.table_i),
    Part("table-ii", "Table II: ISE of 32 straight paths", tables.table_ii),
    Part("units", "Units of Tables I and II", tables.units),
)

# what the simulated robot does on the paper's paths
DRIVEN = (
    Part("straight", "Section V.B: 32 straight paths, four runs each, beside Tables I and II", straight.straight),
    Part("steps", "Step instead of ramp reference, and what clipping each pair costs", straight.steps),
    Part("figure-16", "Figure 16: straight paths", straight.figure_16),
    Part("complex", "Section V.C: the 8 and the infinity", complex_paths.complex_paths),
    Part("figure-17", "Figure 17: complex paths", complex_paths.figure_17),
    Part("comparison", "Beyond: better trackers on the same robot", comparison.comparison),
    Part("monte-carlo", "Beyond: robots that differ in noise, dead time and battery", monte_carlo.monte_carlo),
)

EXPERIMENT = Experiment(
    "mecanum",
    "Keek, Loh and Chong: a path-trackable Mecanum robot with two ball mice",
    "Every equation, table and figure that holds numbers, beside what this software finds, with a verdict. The size of "
    "the robot, the distance of the mice, the paths and the dead times are not printed: what depends on them is "
    "computed for a stated case.",
    (*PRINTED, *DRIVEN),
)

__all__ = ["EXPERIMENT"]
