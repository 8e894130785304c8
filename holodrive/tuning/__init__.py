"""TUNE: sweeps and optimisation over roll-outs, on threads here or on a Dask cluster."""

from holodrive.tuning.backends import Backend, Threads
from holodrive.tuning.job import Job, Places, job
from holodrive.tuning.statistics import interval_of_mean, wilson
from holodrive.tuning.sweep import Sweep, sweep

__all__ = ["Backend", "Job", "Places", "Sweep", "Threads", "interval_of_mean", "job", "sweep", "wilson"]
