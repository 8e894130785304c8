"""Wheel odometry: where the wheels' angles say the robot is, how sure that is, and how much they contradict.

One step, for any chassis: angle increments of the wheels give the body displacement that explains them best (least
squares in metres of rim, `kinematics.kernel.forward_step`), a gyro may correct its turn, the exact SE(2) exponential
moves the pose, and the covariance grows with the noise of each wheel (`estimation.dead_reckoning`).

Of a wheel that trails behind its axis the turn of the module counts as well, and what a coupled steering turns the
encoder is taken out first. The covariance takes such a wheel to roll where its axis stands.
"""

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np
from numba import njit

from holodrive import layout
from holodrive.errors import InputError
from holodrive.estimation.dead_reckoning import advance, carry, levers, spread
from holodrive.kinematics import kernel as kin
from holodrive.kinematics.caster_kernel import caster_forward_step
from holodrive.kinematics.chassis import Chassis
from holodrive.types import Array

if TYPE_CHECKING:
    from holodrive.robots.spec import Robot

# --- params -------------------------------------------------------------------------------------
GYRO_WEIGHT = 0  # share of the gyro in the turn; below 0: by variances
GYRO_VARIANCE = 1  # rad^2/s
STEER_AT = 2  # which steering angle holds for an interval: 0 the old, 0.5 the middle, 1 the new
JUMP = 3  # how many times its largest speed a wheel may seem to go
N_WHEELS, N_STEER = 4, 5
NOISE = 6  # n: rad^2/rad, variance of the angle; then n: m^2/rad, variance of what a steered wheel goes sideways
# then the arrays of kinematics.kernel

# --- memory: layout.START_POSE (3) first, which is the pose all the time ------------------------
STARTED = 3
LAST_TIME = 4  # s, of the last sample that counted
LAST_GYRO = 5  # rad/s, NaN when not known
LAST_HEADING = 6  # rad, NaN when not known
TWIST = 7  # 3
COVARIANCE = 10  # 9
SLIP = 19  # m/s of rim
USED, DUPLICATES, BAD_STAMPS, BAD_VALUES, JUMPS = 20, 21, 22, 23, 24
CANDIDATE_TIME = 25  # s, of the sample that jumped, NaN when the last one did not
DISPLACEMENT = 26  # 3: scratch
ANGLES = 29  # n old angles, n increments, n of the jumped sample, then m old, m middle, m of the jumped, m increments
_SHORTEST_S = 1e-6  # samples nearer than this are the same sample twice
_CLOCK_RESTARTED_S = 1.0  # a stamp this far back is a new clock, not a late sample
_CLOCK_SET_S = 1e5  # so is one a day ahead: a clock that was set
_STILL_RAD = 0.05  # a jump is at least this much: encoders may be coarse
_BIAS_S = 60.0  # a gyro's bias counts as noise that lasts so long
_MOST_RAD = 1e6  # no wheel and no gyro turns that much between two samples


@dataclass(frozen=True)
class WheelOdometry:
    """Parameters of wheel odometry; also an estimator plug.

    Attributes:
        wheel_noise: standard deviation of a wheel's angle after it turned by 1 rad [rad]; grows with the square root
            of the way. One for all, or one for each wheel in the robot's order.
        side_noise: the same for how far a steered wheel slips sideways, in radians of rim [rad].
        gyro_weight: share of the gyro in the turn, 0 (ignore) to 1 (trust alone); None weighs by variances, so that
            a robot at rest does not turn with the gyro's bias.
        gyro_noise: standard deviation of the gyro's heading after 1 s [rad]; None takes the robot's IMU (0.005
            without one).
        steer_at: where between the steering angles before and after an interval its wheels pointed: 0.5 is the
            middle, 1 the newest.
        jump_factor: an increment that would need this many times the wheel's largest speed is not believed.
    """

    wheel_noise: float | tuple[float, ...] = 0.05
    side_noise: float = 0.05
    gyro_weight: float | None = None
    gyro_noise: float | None = None
    steer_at: float = 0.5
    jump_factor: float = 1.5

    kernel: ClassVar[Any]

    def __post_init__(self) -> None:
        checks = (
            ("wheel_noise", min(np.atleast_1d(self.wheel_noise)) >= 0.0, "0 or more"),
            ("side_noise", self.side_noise >= 0.0, "0 or more"),
            ("gyro_weight", self.gyro_weight is None or 0.0 <= self.gyro_weight <= 1.0, "0 to 1, or None"),
            ("gyro_noise", self.gyro_noise is None or self.gyro_noise >= 0.0, "0 or more, or None"),
            ("steer_at", 0.0 <= self.steer_at <= 1.0, "0 to 1"),
            ("jump_factor", self.jump_factor > 0.0, "above 0"),
        )
        for name, good, allowed in checks:
            if not good:
                raise InputError(f"wheel odometry: {name} = {getattr(self, name)} is not {allowed}")

    def memory_size(self, robot: "Robot | Chassis") -> int:
        """How many float64 the kernel keeps between ticks."""
        return ANGLES + 3 * len(robot.wheels) + 4 * len(robot.steered)

    def pack(self, robot: "Robot | Chassis") -> Array:
        """The parameters and the kinematics of the robot, as one vector.

        Raises:
            InputError: a wheel without an encoder, or another number of noises than of wheels.
        """
        if not isinstance(robot, Chassis):
            blind = ", ".join(wheel.name for wheel in robot.wheels if wheel.encoder is None)
            if blind:
                raise InputError(
                    f"wheel_odometry needs an encoder on every wheel, {robot.name} has none on {blind}; "
                    "give the wheels encoders or choose another estimator"
                )
        arrays, n = kin.arrays(robot), len(robot.wheels)
        noise = np.atleast_1d(np.asarray(self.wheel_noise, dtype=np.float64))
        if len(noise) not in (1, n):
            raise InputError(f"wheel odometry: wheel_noise has {len(noise)} values, the robot {n} wheels")
        weight = -1.0 if self.gyro_weight is None else self.gyro_weight
        gyro = gyro_noise(robot) if self.gyro_noise is None else self.gyro_noise
        radii = np.array([wheel.radius for wheel in robot.wheels])
        head = [weight, gyro**2, self.steer_at, self.jump_factor, n, len(robot.steered)]
        return np.concatenate([head, np.broadcast_to(noise**2, n), (self.side_noise * radii) ** 2, arrays])


def gyro_noise(robot: "Robot | Chassis") -> float:
    """Standard deviation of the gyro's heading after 1 s [rad]."""
    if isinstance(robot, Chassis) or robot.imu is None:
        return 0.005
    imu = robot.imu
    # of a faster IMU only the newest sample of each tick counts, and it counts for the whole tick
    rate_hz = min(imu.rate_hz, 1.0 / robot.control_period_s)
    return math.sqrt(imu.gyro_noise_rad_s**2 / rate_hz + imu.gyro_bias_rad_s**2 * _BIAS_S)


@njit(cache=True, error_model="numpy")
def kernel(obs: Array, memory: Array, params: Array, estimate: Array) -> None:
    """One tick over the arrays of `holodrive.layout`."""
    n, m = int(params[N_WHEELS]), int(params[N_STEER])
    position = obs[layout.WHEEL_POSITION : layout.WHEEL_POSITION + n]
    steer = obs[layout.STEER : layout.STEER + m]
    step(params, memory, obs[layout.TIME], position, steer, obs[layout.GYRO], math.nan)
    for i in range(3):
        estimate[layout.EST_POSE + i] = memory[i]
        estimate[layout.EST_TWIST + i] = memory[TWIST + i]
    for i in range(9):
        estimate[layout.EST_COVARIANCE + i] = memory[COVARIANCE + i]
    estimate[layout.EST_SLIP] = memory[SLIP]


WheelOdometry.kernel = staticmethod(kernel)


@njit(cache=True, error_model="numpy")
def integrate(
    params: Array, memory: Array, time: Array, position: Array, steer: Array, gyro: Array, heading: Array, out: Array
) -> None:
    """A whole recording: samples (N,), (N, n), (N, m), (N,), (N,) to (N, 16) in the layout of an estimate."""
    for k in range(len(time)):
        step(params, memory, time[k], position[k], steer[k], gyro[k], heading[k])
        for i in range(3):
            out[k, layout.EST_POSE + i] = memory[i]
            out[k, layout.EST_TWIST + i] = memory[TWIST + i]
        for i in range(9):
            out[k, layout.EST_COVARIANCE + i] = memory[COVARIANCE + i]
        out[k, layout.EST_SLIP] = memory[SLIP]


@njit(cache=True, error_model="numpy")
def step(params: Array, memory: Array, time: float, position: Array, steer: Array, gyro: float, heading: float) -> None:
    """One sample into the pose, or into the counter of what was wrong with it.

    Args:
        params, memory: as packed.
        time: [s].
        position: (n,) wheel angles [rad]; `steer`: (m,) steering angles [rad].
        gyro: yaw rate [rad/s], NaN without; `heading`: of a compass or an integrated gyro [rad], any turn, NaN without.
    """
    if not (math.isfinite(time) and all_finite(position) and all_finite(steer)):
        memory[BAD_VALUES if math.isfinite(time) else BAD_STAMPS] += 1.0
        return
    if memory[STARTED] == 0.0:
        memory[STARTED] = 1.0
        memory[CANDIDATE_TIME] = math.nan
        rebase(params, memory, time, position, steer, gyro, heading)
        return
    dt = time - memory[LAST_TIME]
    if abs(dt) < _SHORTEST_S:
        memory[DUPLICATES] += 1.0
        return
    if dt < 0.0 or dt > _CLOCK_SET_S:
        memory[BAD_STAMPS] += 1.0
        if dt < -_CLOCK_RESTARTED_S or dt > _CLOCK_SET_S:
            rebase(params, memory, time, position, steer, gyro, heading)
        return
    if jumped(params, memory, ANGLES, dt, position):
        n = int(params[N_WHEELS])
        since = time - memory[CANDIDATE_TIME]
        # NaN compares false: without a candidate this is the first jump
        if not (since >= _SHORTEST_S and not jumped(params, memory, ANGLES + 2 * n, since, position)):
            memory[JUMPS] += 1.0
            keep_candidate(params, memory, time, position, steer)
            return
        # two samples agree that the counters start anew: go on from the first of them
        take_candidate(params, memory)
        dt = since
    memory[CANDIDATE_TIME] = math.nan
    displace(params, memory, dt, position, steer, gyro, heading)
    advance(memory[:3], memory[DISPLACEMENT : DISPLACEMENT + 3])
    for i in range(3):
        memory[TWIST + i] = memory[DISPLACEMENT + i] / dt
    memory[USED] += 1.0
    rebase(params, memory, time, position, steer, gyro, heading)


@njit(cache=True, error_model="numpy")
def all_finite(values: Array) -> bool:
    """Whether no value is NaN or infinite."""
    for value in values:  # noqa: SIM110  Numba has no generators
        if not math.isfinite(value):
            return False
    return True


@njit(cache=True, error_model="numpy")
def rebase(
    params: Array, memory: Array, time: float, position: Array, steer: Array, gyro: float, heading: float
) -> None:
    """The next increment counts from this sample."""
    n, m = int(params[N_WHEELS]), int(params[N_STEER])
    memory[LAST_TIME], memory[LAST_GYRO], memory[LAST_HEADING] = time, gyro, heading
    for i in range(n):
        memory[ANGLES + i] = position[i]
    for j in range(m):
        memory[ANGLES + 3 * n + j] = steer[j]


@njit(cache=True, error_model="numpy")
def jumped(params: Array, memory: Array, at: int, dt: float, position: Array) -> bool:
    """Whether a wheel seems to have gone faster than it can since the angles at `memory[at]`."""
    arrays = NOISE + 2 * int(params[N_WHEELS])
    for i in range(int(params[N_WHEELS])):
        reach = params[JUMP] * params[arrays + kin.WHEELS + kin.BLOCK * i + kin.MAX_SPEED] * dt
        if abs(position[i] - memory[at + i]) > min(reach + _STILL_RAD, _MOST_RAD):
            return True
    return False


@njit(cache=True, error_model="numpy")
def keep_candidate(params: Array, memory: Array, time: float, position: Array, steer: Array) -> None:
    """Remember a sample that jumped: the next one tells whether it was a glitch or a new start of the counters."""
    n, m = int(params[N_WHEELS]), int(params[N_STEER])
    memory[CANDIDATE_TIME] = time
    for i in range(n):
        memory[ANGLES + 2 * n + i] = position[i]
    for j in range(m):
        memory[ANGLES + 3 * n + 2 * m + j] = steer[j]


@njit(cache=True, error_model="numpy")
def take_candidate(params: Array, memory: Array) -> None:
    """Count from the sample that jumped; what a heading did in the gap is not known to belong to it."""
    n, m = int(params[N_WHEELS]), int(params[N_STEER])
    memory[LAST_TIME], memory[LAST_GYRO], memory[LAST_HEADING] = memory[CANDIDATE_TIME], math.nan, math.nan
    for i in range(n):
        memory[ANGLES + i] = memory[ANGLES + 2 * n + i]
    for j in range(m):
        memory[ANGLES + 3 * n + j] = memory[ANGLES + 3 * n + 2 * m + j]


@njit(cache=True, error_model="numpy")
def displace(
    params: Array, memory: Array, dt: float, position: Array, steer: Array, gyro: float, heading: float
) -> None:
    """Body displacement of an interval into `memory[DISPLACEMENT]`, slip, and the covariance's growth."""
    n, m = int(params[N_WHEELS]), int(params[N_STEER])
    arrays = params[NOISE + 2 * n :]
    turns = memory[ANGLES + n : ANGLES + 2 * n]
    middle = memory[ANGLES + 3 * n + m : ANGLES + 3 * n + 2 * m]
    for i in range(n):
        turns[i] = position[i] - memory[ANGLES + i]
    for j in range(m):
        old = memory[ANGLES + 3 * n + j]
        middle[j] = old + params[STEER_AT] * kin.wrap(steer[j] - old)
    displacement = memory[DISPLACEMENT : DISPLACEMENT + 3]
    if arrays[kin.TRAILS] == 0.0:
        memory[SLIP] = kin.forward_step(arrays, turns, middle, displacement) / dt
    else:
        steered = memory[ANGLES + 3 * n + 3 * m : ANGLES + 3 * n + 4 * m]
        memory[SLIP] = trailing_displacement(params, memory, turns, steer, steered, displacement) / dt
    turn = gyro_turn(memory, dt, gyro, heading)
    share, variance = 0.0, 0.0
    if math.isfinite(turn):
        variance = params[GYRO_VARIANCE] * dt
        share = params[GYRO_WEIGHT]
        if share < 0.0:
            wheels = turn_variance(params, turns, middle)
            share = wheels / (wheels + variance) if wheels > 0.0 else 0.0
        displacement[2] += share * (turn - displacement[2])
    grow(params, memory, turns, middle, share, share * share * variance)


@njit(cache=True, error_model="numpy")
def trailing_displacement(
    params: Array, memory: Array, turns: Array, steer: Array, steered: Array, displacement: Array
) -> float:
    """`forward_step` where wheels trail or are coupled: takes the coupling out of `turns`, counts the steering in."""
    n = int(params[N_WHEELS])
    arrays = params[NOISE + 2 * n :]
    for i in range(n):
        b = kin.WHEELS + kin.BLOCK * i
        j = int(arrays[b + kin.STEER_INDEX])
        if j >= 0:
            steered[j] = kin.wrap(steer[j] - memory[ANGLES + 3 * n + j])
            turns[i] -= arrays[b + kin.COUPLING] * steered[j]
    # modules stand where the interval is judged: (1 - steer_at) of their turn before the newest angles
    return float(caster_forward_step(arrays, turns, steer, steered, 1.0 - params[STEER_AT], displacement))


@njit(cache=True, error_model="numpy")
def gyro_turn(memory: Array, dt: float, gyro: float, heading: float) -> float:
    """Turn [rad] since the last sample by the heading, else by the gyro's mean rate; NaN when neither is known."""
    turn = heading - memory[LAST_HEADING]
    if abs(turn) < _MOST_RAD:
        return float(kin.wrap(turn))
    turn = gyro * dt
    if math.isfinite(memory[LAST_GYRO]):
        turn = 0.5 * (gyro + memory[LAST_GYRO]) * dt
    return turn if abs(turn) < _MOST_RAD else math.nan


@njit(cache=True, error_model="numpy")
def turn_variance(params: Array, turns: Array, steer: Array) -> float:
    """Variance of the turn that the wheels tell [rad^2]."""
    total = 0.0
    for i in range(int(params[N_WHEELS])):
        along, across, roll, side = wheel_noise(params, i, abs(turns[i]), steer)
        total += roll * along[2] * along[2] + side * across[2] * across[2]
    return total


@njit(cache=True, error_model="numpy")
def wheel_noise(
    params: Array, i: int, way: float, steer: Array
) -> tuple[tuple[float, float, float], tuple[float, float, float], float, float]:
    """How a wheel's error along and across its direction moves the body, and the variances of the two errors."""
    n = int(params[N_WHEELS])
    b = NOISE + 2 * n + kin.WHEELS + kin.BLOCK * i
    x = params[b + kin.BACK], params[b + kin.BACK + 1], params[b + kin.BACK + 2]
    j = int(params[b + kin.STEER_INDEX])
    if j < 0:
        return x, (0.0, 0.0, 0.0), params[NOISE + i] * way, 0.0
    y = params[b + kin.BACK + 3], params[b + kin.BACK + 4], params[b + kin.BACK + 5]
    c, s = math.cos(steer[j]), math.sin(steer[j])
    along = (c * x[0] + s * y[0], c * x[1] + s * y[1], c * x[2] + s * y[2])
    across = (c * y[0] - s * x[0], c * y[1] - s * x[1], c * y[2] - s * x[2])
    rim = params[b + kin.RADIUS] ** 2
    return along, across, params[NOISE + i] * rim * way, params[NOISE + n + i] * way


@njit(cache=True, error_model="numpy")
def grow(params: Array, memory: Array, turns: Array, steer: Array, share: float, variance: float) -> None:
    """Covariance of the pose after the displacement, from the noise of each wheel and of the gyro."""
    heading, displacement = memory[2], memory[DISPLACEMENT : DISPLACEMENT + 3]
    covariance = memory[COVARIANCE : COVARIANCE + 9]
    carry(covariance, heading, displacement)
    g = levers(heading, displacement)
    for i in range(int(params[N_WHEELS])):
        along, across, roll, side = wheel_noise(params, i, abs(turns[i]), steer)
        for error, size in ((along, roll), (across, side)):
            if size > 0.0:
                # the gyro's share of the turn is not the wheels'
                spread(covariance, g, size, error[0], error[1], (1.0 - share) * error[2])
    if variance > 0.0:
        spread(covariance, g, variance, 0.0, 0.0, 1.0)
