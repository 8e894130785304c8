"""TUNE: sweeps and optimisation over roll-outs, on threads here or on a Dask cluster."""

from holodrive.tuning.backends import Backend, Open, Threads
from holodrive.tuning.job import Job, Places, job
from holodrive.tuning.judgement import Judgement, judge
from holodrive.tuning.objective import Objective
from holodrive.tuning.space import Range, Space, parse_range, space
from holodrive.tuning.statistics import interval_of_mean, wilson
from holodrive.tuning.sweep import Sweep, sweep
from holodrive.tuning.tune import HELD_OUT, TRAIN, VALIDATION, Problem, Step, tune
from holodrive.tuning.tuned import Generation, Tuned, read

__all__ = [
    "HELD_OUT",
    "TRAIN",
    "VALIDATION",
    "Backend",
    "Generation",
    "Job",
    "Judgement",
    "Objective",
    "Open",
    "Places",
    "Problem",
    "Range",
    "Space",
    "Step",
    "Sweep",
    "Threads",
    "Tuned",
    "interval_of_mean",
    "job",
    "judge",
    "parse_range",
    "read",
    "space",
    "sweep",
    "tune",
    "wilson",
]
