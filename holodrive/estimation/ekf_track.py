"""The Kalman filter over a whole recording at once, with what the loop does not need: bias, innovations, refusals."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numba import njit
from numpy.typing import ArrayLike

from holodrive import layout
from holodrive.errors import InputError
from holodrive.estimation import ekf_state as es
from holodrive.estimation import ekf_tick
from holodrive.estimation.ekf import Ekf
from holodrive.observation_array import empty_observation, fill_observation
from holodrive.types import Array, Observation, Pose

if TYPE_CHECKING:
    from holodrive.robots.spec import Robot

_ORIGIN = Pose(0.0, 0.0, 0.0)
_EXTRA = 6  # bias, its variance, innovations, their number, refused rows, hits


@dataclass(frozen=True)
class FilterTrack:
    """The filter's belief, one row a tick.

    Attributes:
        pose: (T, 3) in the frame of the start pose, heading not wrapped.
        twist: (T, 3) in `base_link`.
        covariance: (T, 3, 3) of the pose, world axes.
        slip: (T,) [m/s].
        suspect: (T,) bits of ground sensors that were refused or not read.
        bias: (T,) of the gyro [rad/s]; `bias_deviation`: (T,) its standard deviation.
        nis: (T,) sum of the squared innovations of a tick, each over its variance; chi-square of `nis_rows` (T,)
            degrees of freedom when the filter is right.
        refused: rows that the gate refused; `hits`: ticks at which several sensors contradicted the motion expected.
    """

    pose: Array
    twist: Array
    covariance: Array
    slip: Array
    suspect: Array
    bias: Array
    bias_deviation: Array
    nis: Array
    nis_rows: Array
    refused: int
    hits: int


def rows_of(observations: Sequence[Observation]) -> Array:
    """(T, ...) observations in the layout of `holodrive.layout`, without their scans."""
    out = np.zeros((len(observations), layout.OBS_HEADER))
    flat = empty_observation()
    for row, seen in zip(out, observations, strict=True):
        fill_observation(
            flat, Observation(seen.time, seen.dt, seen.wheels, seen.gyro, seen.accel, seen.mice)
        )  # a scan would need room for its beams
        row[:] = flat
    return out


def track(
    robot: "Robot", observations: "Sequence[Observation] | Array", params: Ekf | None = None, start: ArrayLike = _ORIGIN
) -> FilterTrack:
    """The filter over a recording: observations, or (T, ...) rows as `rows_of` makes them."""
    rows = observations if isinstance(observations, np.ndarray) else rows_of(observations)
    if rows.ndim != 2 or rows.shape[1] < layout.OBS_HEADER:
        raise InputError(f"ekf: observations have the shape {rows.shape}, expected (T, {layout.OBS_HEADER})")
    chosen = params or Ekf()
    memory = np.zeros(chosen.memory_size(robot))
    memory[layout.START_POSE : layout.START_POSE + 3] = start
    out, extra = np.empty((len(rows), layout.ESTIMATE_SIZE)), np.empty((len(rows), _EXTRA))
    _run(np.ascontiguousarray(rows, dtype=np.float64), memory, chosen.pack(robot), out, extra)
    return FilterTrack(
        pose=out[:, layout.EST_POSE : layout.EST_POSE + 3].copy(),
        twist=out[:, layout.EST_TWIST : layout.EST_TWIST + 3].copy(),
        covariance=out[:, layout.EST_COVARIANCE : layout.EST_COVARIANCE + 9].reshape(-1, 3, 3).copy(),
        slip=out[:, layout.EST_SLIP].copy(),
        suspect=out[:, layout.EST_SUSPECT].astype(np.int64),
        bias=extra[:, 0].copy(),
        bias_deviation=np.sqrt(np.maximum(extra[:, 1], 0.0)),
        nis=extra[:, 2].copy(),
        nis_rows=extra[:, 3].copy(),
        refused=int(extra[-1, 4]) if len(rows) else 0,
        hits=int(extra[-1, 5]) if len(rows) else 0,
    )


@njit(cache=True, error_model="numpy")
def _run(rows: Array, memory: Array, params: Array, out: Array, extra: Array) -> None:
    n, at, i = int(params[es.SIZE]), es.square_at(params), es.BIAS_AT
    for k in range(len(rows)):
        ekf_tick.tick(rows[k], memory, params, out[k])
        extra[k, 0], extra[k, 1] = memory[i], memory[at + i * n + i]
        extra[k, 2], extra[k, 3] = memory[n + es.TICK_NIS], memory[n + es.TICK_ROWS]
        extra[k, 4], extra[k, 5] = memory[n + es.REFUSED], memory[n + es.HITS]
