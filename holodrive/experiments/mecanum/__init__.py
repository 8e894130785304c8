"""Keek, Loh and Chong, 'Comprehensive Development and Control of a Path-Trackable Mecanum-Wheeled Robot'."""

from holodrive.experiments.experiment import Experiment, Part
from holodrive.experiments.mecanum import actuators, example, gains, localisation, tables

# what the paper's own numbers say, computed again
PRINTED = (
    Part("localisation", "Equations 1 to 7: dead reckoning with two mice", localisation.localisation),
    Part("linearization", "Equations 8 to 12: speed of a step, and four cubics", actuators.linearization),
    Part("figure-9", "Figure 9 and equations 13 to 16: gains over the angle", gains.figure_9),
    Part("example", "Equations 17 to 30: the worked example, number by number", example.example),
    Part("table-i", "Table I: IAE of 32 straight paths", tables.table_i),
    Part("table-ii", "Table II: ISE of 32 straight paths", tables.table_ii),
    Part("units", "Units of Tables I and II", tables.units),
)

# what the simulated robot does on the paper's paths
DRIVEN: tuple[Part, ...] = ()

EXPERIMENT = Experiment(
    "mecanum",
    "Keek, Loh and Chong: a path-trackable Mecanum robot with two ball mice",
    "Every equation, table and figure that holds numbers, beside what this software finds, with a verdict. The size of "
    "the robot, the distance of the mice, the paths and the dead times are not printed: what depends on them is "
    "computed for a stated case.",
    (*PRINTED, *DRIVEN),
)

__all__ = ["EXPERIMENT"]
