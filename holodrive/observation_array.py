"""From an `Observation` to the flat float64 vector of `holodrive.layout` that compiled controllers and estimators read.

One packing for both kinds of plug, so that they cannot come to see different robots.
"""

import math

import numpy as np

from holodrive import layout
from holodrive.errors import InputError
from holodrive.types import Array, Estimate, Observation, Reference, Scan

_NAN = math.nan


def observation_size(beams: int) -> int:
    """How many float64 an observation with up to `beams` beams has."""
    return layout.OBS_HEADER + beams


def empty_observation(beams: int = 0) -> Array:
    """(OBS_HEADER + beams,) vector for `fill_observation` to write into, all zeros."""
    return np.zeros(observation_size(beams))


def fill_observation(
    out: Array, observation: Observation, estimate: Estimate | None = None, reference: Reference | None = None
) -> None:
    """Write what is observed, believed and wanted into `out`; what is None or not measured becomes NaN.

    Before the first scan, and on a robot without a lidar, `N_BEAMS` is 0 and `SCAN_TIME` NaN.

    Args:
        out: (OBS_HEADER + b,) contiguous float64, b at least the number of beams; made by `empty_observation`.
        observation: of this tick.
        estimate: belief at this tick, for controllers; an estimator packs without.
        reference: wanted place, for controllers; an estimator packs without.

    Raises:
        InputError: more wheels, ground sensors or beams than the vector has room for.
    """
    out[layout.TIME], out[layout.DT] = observation.time, observation.dt
    if estimate is None:
        out[layout.POSE : layout.REF_POSE] = _NAN
    else:
        out[layout.POSE : layout.REF_POSE] = (*estimate.pose, *estimate.twist)
    if reference is None:
        out[layout.REF_POSE : layout.REF_LAST + 1] = _NAN
    else:
        out[layout.REF_POSE : layout.REF_LAST + 1] = (
            *reference.pose,
            *reference.twist,
            *reference.accel,
            1.0 if reference.last else 0.0,
        )
    out[layout.GYRO] = _NAN if observation.gyro is None else observation.gyro
    out[layout.ACCEL : layout.ACCEL + 2] = _NAN if observation.accel is None else observation.accel
    _fill_wheels(out, observation)
    _fill_mice(out, observation.mice)
    _fill_scan(out, observation.scan, observation.scan_is_new)


def _fill_wheels(out: Array, observation: Observation) -> None:
    wheels = observation.wheels
    n, m = len(wheels.position), len(wheels.steer)
    if n > layout.MAX_WHEELS or m > layout.MAX_WHEELS:
        raise InputError(
            f"an observation has {n} wheels and {m} steering angles, at most {layout.MAX_WHEELS} are possible"
        )
    out[layout.N_WHEELS], out[layout.N_STEER] = n, m
    out[layout.WHEEL_POSITION : layout.WHEEL_POSITION + n] = wheels.position
    out[layout.WHEEL_SPEED : layout.WHEEL_SPEED + n] = wheels.speed
    if m:
        out[layout.STEER : layout.STEER + m] = wheels.steer


def _fill_mice(out: Array, mice: Array | None) -> None:
    count = 0 if mice is None else len(mice)
    if count > layout.MAX_MICE:
        raise InputError(f"an observation has {count} ground sensors, at most {layout.MAX_MICE} are possible")
    out[layout.N_MICE] = count
    if mice is not None:
        out[layout.MICE : layout.MICE + 2 * count] = np.ravel(mice)


def _fill_scan(out: Array, scan: Scan | None, is_new: bool) -> None:
    if scan is None:
        out[layout.SCAN_IS_NEW], out[layout.SCAN_TIME], out[layout.N_BEAMS] = 0.0, _NAN, 0.0
        out[layout.BEAM_FIRST], out[layout.BEAM_STEP], out[layout.BEAM_PERIOD] = 0.0, 0.0, 0.0
        return
    beams = len(scan.ranges)
    if layout.BEAMS + beams > len(out):
        raise InputError(f"a scan has {beams} beams, the observation has room for {len(out) - layout.BEAMS}")
    out[layout.SCAN_IS_NEW], out[layout.SCAN_TIME], out[layout.N_BEAMS] = float(is_new), scan.stamp, beams
    out[layout.BEAM_FIRST] = scan.angles[0] if beams else 0.0
    if beams > 1:
        # angles may jump by a turn where they wrap; the step between neighbours does not
        out[layout.BEAM_STEP] = math.remainder(scan.angles[1] - scan.angles[0], 2.0 * math.pi)
        out[layout.BEAM_PERIOD] = (scan.offsets[-1] - scan.offsets[0]) / (beams - 1)
    else:
        out[layout.BEAM_STEP], out[layout.BEAM_PERIOD] = 0.0, 0.0
    out[layout.BEAMS : layout.BEAMS + beams] = scan.ranges
