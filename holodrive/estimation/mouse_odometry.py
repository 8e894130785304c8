"""Odometry by two or more ground mice at any mounting: rigid body, exact in every tick.

The displacement of the body that explains the counts of all mice best (weighted least squares, each mouse by its
counts and its noise) moves the pose by the exact SE(2) exponential. With two mice on a line this is the rigid form
of Keek et al., eq. 1 to 7: the turn is the difference of the ways across the line over the mice's distance.

Health: every mouse is judged by the others (`estimation.sensor_health`). Three mice off one line tell which of them
is wrong for most motions, four for nearly all. Two mice alone contradict each other in one number, the difference of
their ways along the line between them: a mouse that stands still in motion across that line looks like a turn, and a
mouse that loses part of its way along it is told (`Estimate.slip`, both in doubt) but not which. Only when one of the
two counts nothing while the other moves along the line is it sure which: it is left out, and until it counts again
the other tells two of three motions and the third goes on as it went, dies away, and its variance grows.

`Estimate.slip` is the root mean square of what the mice contradict each other in [m/s over the ground], over the last
tenth of a second; `Estimate.suspect` has the bit of each mouse that is left out, not read, or in doubt.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np
from numba import njit
from numpy.typing import ArrayLike

from holodrive import layout
from holodrive.errors import InputError
from holodrive.estimation import body_motion
from holodrive.estimation import sensor_state as st
from holodrive.estimation import sensor_table as tb
from holodrive.estimation.mice import mice_of
from holodrive.types import Array, Pose

if TYPE_CHECKING:
    from holodrive.robots.spec import Mouse, Robot

_ORIGIN = Pose(0.0, 0.0, 0.0)
_NEEDS = 2


@dataclass(frozen=True)
class MouseOdometry:
    """Parameters of odometry by ground mice; also an estimator plug.

    Attributes:
        way_noise: standard deviation of a mouse's way after the base moved 1 m [m], beside its counts and the relative
            noise of the robot's file; grows with the square root of the way.
        twist_s: time constant of the filter on the twist [s]; 0 for none. A count of 10 um in a tick of 15 ms is
            0.67 mm/s.
        tolerance: share of its way that a healthy mouse may be wrong by: calibration, and readings that are late.
        gate: how many standard deviations of contradiction are too many.
        horizon_s: over how long a time contradictions are judged [s].
        trust_s: how long a mouse must agree in motion until it is trusted again [s]; each relapse doubles it.
        coast_s: time constant with which motion that no mouse tells dies away [s].
        jump_factor: a reading that would need this many times the largest wheel speed over the ground is not
            believed.
    """

    way_noise: float = 1e-4
    twist_s: float = 0.01
    tolerance: float = 0.07
    gate: float = 3.0
    horizon_s: float = 0.1
    trust_s: float = 0.3
    coast_s: float = 0.2
    jump_factor: float = 2.0

    kernel: ClassVar[Any]

    def __post_init__(self) -> None:
        check("mouse odometry", self, at_least_0=("way_noise", "twist_s", "tolerance", "trust_s"))
        check("mouse odometry", self, above_0=("gate", "horizon_s", "coast_s", "jump_factor"))

    def memory_size(self, robot: "Robot") -> int:
        """How many float64 the kernel keeps between ticks."""
        return st.STATES + st.STATE * len(robot.mice)

    def pack(self, robot: "Robot") -> Array:
        """The parameters and the mice of the robot, as one vector.

        Raises:
            InputError: fewer than two mice, mice in one place, a mouse outside the footprint.
        """
        return self.pack_mice(mice_of(robot, "mouse_odometry", _NEEDS), robot)

    def pack_mice(self, mice: "Sequence[Mouse]", robot: "Robot | None" = None) -> Array:
        """The same for mice alone; without a robot no reading is too fast."""
        speed, _ = tb.stray(robot)
        reach = self.jump_factor * speed if robot else np.inf
        return header(self, tb.of_mice(mice, self.way_noise, self.tolerance, reach), robot)


def header(params: Any, table: Array, robot: "Robot | None") -> Array:
    """Packed parameters: the head of `sensor_state`, then the table."""
    head = np.zeros(st.TABLE)
    n, m = (len(robot.wheels), len(robot.steered)) if robot else (0, 0)
    head[[st.SENSORS, st.WHEELS, st.STEERS]] = len(table), n, m
    head[st.TWIST_S : st.COAST_S + 1] = (
        params.twist_s,
        params.horizon_s,
        params.gate,
        params.trust_s,
        params.coast_s,
    )
    head[[st.STRAY_SPEED, st.STRAY_YAW]] = tb.stray(robot)
    head[st.LENGTH] = tb.length_of(table)
    return np.concatenate([head, table.ravel()])


def check(who: str, params: Any, at_least_0: Sequence[str] = (), above_0: Sequence[str] = ()) -> None:
    """Refuse parameters out of range.

    Raises:
        InputError: the first that is.
    """
    for name in (*at_least_0, *above_0):
        value = float(getattr(params, name))
        if not (np.isfinite(value) and (value > 0.0 or (value == 0.0 and name in at_least_0))):
            raise InputError(f"{who}: {name} = {value} is not {'0 or more' if name in at_least_0 else 'above 0'}")


@njit(cache=True, error_model="numpy")
def kernel(obs: Array, memory: Array, params: Array, estimate: Array) -> None:
    """One tick over the arrays of `holodrive.layout`."""
    body_motion.tick(obs, memory, params, estimate)


MouseOdometry.kernel = staticmethod(kernel)


@dataclass(frozen=True)
class MouseTrack:
    """Odometry over N increments; row 0 is the start.

    Attributes:
        pose: (N + 1, 3), heading not wrapped.
        covariance: (N + 1, 3, 3) of the pose, world axes.
        slip: (N + 1,) [m/s].
        suspect: (N + 1,) bit k for mouse k.
    """

    pose: Array
    covariance: Array
    slip: Array
    suspect: Array


def track(
    mice: "Robot | Sequence[Pose]",
    increments: ArrayLike,
    start: Pose = _ORIGIN,
    *,
    dt_s: float | None = None,
    resolution_m: float = 1e-5,
    params: MouseOdometry | None = None,
) -> MouseTrack:
    """Mouse odometry over recorded increments.

    Args:
        mice: a robot with mice, or the mounts of k mice in `base_link`.
        increments: (N, k, 2) what each mouse counted from one row to the next, in its own axes [m].
        start: pose before the first.
        dt_s: between rows; the robot's control period, or 5 ms for mounts, when None.
        resolution_m: of the mice given by mounts.
        params: of the odometry.
    """
    from holodrive.robots.spec import Mouse, Robot

    chosen = params or MouseOdometry()
    if isinstance(mice, Robot):
        packed, k, dt = chosen.pack(mice), len(mice.mice), dt_s or mice.control_period_s
    else:
        known = [Mouse(f"{i + 1}", Pose(*mount), resolution_m) for i, mount in enumerate(mice)]
        if not _NEEDS <= len(known) <= layout.MAX_MICE:
            raise InputError(f"mouse odometry takes {_NEEDS} to {layout.MAX_MICE} mice, {len(known)} were given")
        packed, k, dt = chosen.pack_mice(known), len(known), dt_s or 0.005
    ways = np.ascontiguousarray(increments, dtype=np.float64)
    if ways.ndim != 3 or ways.shape[1:] != (k, 2):
        raise InputError(f"mouse odometry: increments have the shape {ways.shape}, expected (N, {k}, 2)")
    out = np.empty((len(ways) + 1, layout.ESTIMATE_SIZE))
    memory = np.zeros(st.STATES + st.STATE * k)
    memory[:3] = start
    _integrate(ways.reshape(len(ways), 2 * k), dt, memory, packed, out)
    covariance = out[:, layout.EST_COVARIANCE : layout.EST_COVARIANCE + 9].reshape(-1, 3, 3)
    return MouseTrack(
        out[:, :3].copy(), covariance.copy(), out[:, layout.EST_SLIP].copy(), out[:, layout.EST_SUSPECT].astype(int)
    )


@njit(cache=True, error_model="numpy")
def _integrate(ways: Array, dt: float, memory: Array, params: Array, out: Array) -> None:
    obs = np.zeros(layout.OBS_HEADER)
    obs[layout.DT] = dt
    body_motion.tick(obs, memory, params, out[0])
    for k in range(len(ways)):
        for i in range(ways.shape[1]):
            obs[layout.MICE + i] = ways[k, i]
        body_motion.tick(obs, memory, params, out[k + 1])
