"""Actuator calibration by open-loop PWM steps (Keek et al., section III): dead zone, dead time, speed, linearizer."""

from holodrive.calibration.duty_fit import CurveFit, cubic_of, fit
from holodrive.calibration.groups import DIRECTIONS, Group, groups_of
from holodrive.calibration.linearizer import Calibration, calibrate, curve_values, duty_values
from holodrive.calibration.step_csv import parse_csv, read_csv, write_csv
from holodrive.calibration.step_log import records_of
from holodrive.calibration.step_record import StepRecord
from holodrive.calibration.step_response import Step, analyse, speed_eq8

__all__ = [
    "DIRECTIONS",
    "Calibration",
    "CurveFit",
    "Group",
    "Step",
    "StepRecord",
    "analyse",
    "calibrate",
    "cubic_of",
    "curve_values",
    "duty_values",
    "fit",
    "groups_of",
    "parse_csv",
    "read_csv",
    "records_of",
    "speed_eq8",
    "write_csv",
]
