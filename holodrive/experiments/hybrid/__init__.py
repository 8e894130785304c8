"""Tuama and Hadi, 'Fuzzy Logic Controller with Rplidar for Hybrid Three-Wheeled Omnidirectional Mobile Robot'."""

from holodrive.experiments.experiment import Experiment, Part
from holodrive.experiments.hybrid import courses, equations, figures, results, rules, tracks
from holodrive.experiments.hybrid.course import table_ix

EXPERIMENT = Experiment(
    "hybrid",
    "Tuama and Hadi: fuzzy controller with RPLIDAR for a hybrid three-wheeled omnidirectional robot",
    "Every table and figure that holds numbers, beside what this software finds, with a verdict; then the benchmark "
    "that takes their place, because the printed course cannot be driven (its goal lies inside an obstacle), the "
    "printed rules differ from table to table, and the printed motor is too slow for the printed times.",
    (
        Part("equations", "Equations 2, 15, 19, 23 and what follows from them", equations.equations),
        Part("table-vii", "Table VII: rules", rules.table_vii),
        Part("table-viii", "Table VIII: rules again", rules.table_viii),
        Part("table-ix", "Table IX: the course", table_ix),
        Part("table-x", "Table X: bee colony against fuzzy controller", results.table_x),
        Part("table-xi", "Table XI: mean square errors", tracks.table_xi),
        Part("table-xii", "Table XII: step response", tracks.table_xii),
        Part("figure-25", "Figure 25: sets of DH", figures.figure_25),
        Part("figure-26", "Figure 26: sets of DL and DR", figures.figure_26),
        Part("figure-27", "Figure 27: sets of L and R", figures.figure_27),
        Part("figure-28", "Figure 28: the system", figures.figure_28),
        Part("figure-29", "Figure 29: rules at work", figures.figure_29),
        Part("figure-30", "Figure 30: control surface", figures.figure_30),
        Part("figure-31", "Figure 31: the lidar", figures.figure_31),
        Part("figure-32", "Figure 32: a scan", figures.figure_32),
        Part("figure-33", "Figure 33: four obstacles", figures.figure_33),
        Part("figure-34", "Figure 34: points become obstacles", figures.figure_34),
        Part("figure-35", "Figure 35: trajectories", tracks.figure_35),
        Part("library", "The paper's library", results.library),
        Part("a1", "Benchmark A1: the course without obstacle 4", courses.a1),
        Part("a2", "Benchmark A2: the course with obstacle 4 on the goal", courses.a2),
        Part("a3", "Benchmark A3: random worlds", courses.a3),
        Part("a4", "Benchmark A4: random worlds with crossers", courses.a4),
        Part("t1", "Benchmark T1: circle", tracks.t1),
        Part("t2", "Benchmark T2: lemniscate", tracks.t2),
        Part("t3", "Benchmark T3: step", tracks.t3),
    ),
)

__all__ = ["EXPERIMENT"]
