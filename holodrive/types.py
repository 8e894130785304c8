"""The values that move between modules: what is seen, believed, wanted and commanded.

Values only, no behaviour. SI and radians, x forward, y left, counter-clockwise positive (REP-103).
Frames are REP-105's: `base_link` moves with the robot, `odom` is where odometry starts, `map` is the world.
"""

from dataclasses import dataclass, field
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


class Pose(NamedTuple):
    """Position [m] and heading [rad] in a named frame; heading is not wrapped unless said."""

    x: float
    y: float
    theta: float


class Twist(NamedTuple):
    """Velocity of `base_link` in `base_link` axes [m/s, m/s, rad/s]."""

    vx: float
    vy: float
    omega: float


class WheelCommand(NamedTuple):
    """Wheel speeds (..., n) [rad/s] and steering angles (..., m) [rad], in the order of the robot's wheels.

    Positive speed drives along the wheel's `yaw` (or steering) direction.
    m counts the steered wheels only; it is 0 for omni and Mecanum bases.
    """

    speeds: Any
    steer: Any = ()


class DutyCommand(NamedTuple):
    """Open-loop motor duty (n,) in [-1, 1] and steering angles (m,) [rad]; passes the gate in calibration only."""

    duty: Any
    steer: Any = ()


Command = Twist | WheelCommand | DutyCommand


@dataclass(frozen=True, slots=True)
class WheelState:
    """What encoders tell: angle since start (n,) [rad], speed (n,) [rad/s], steering angle (m,) [rad]."""

    position: Array
    speed: Array
    steer: Array


class MotorState(NamedTuple):
    """What the motors do: k = n drives, then m steerings in the order of the steered wheels; NaN where unknown.

    Attributes:
        current: (..., k) that makes torque [A]: of the equivalent DC motor.
        torque: (..., k) behind gear and its losses [N m].
        electrical: (..., k) power from the driver [W]; below 0 while the motor brakes.
        mechanical: (..., k) power that the shaft gives to its load [W].
    """

    current: Array
    torque: Array
    electrical: Array
    mechanical: Array

    @property
    def efficiency(self) -> Array:
        """(..., k) mechanical over electrical power where the motor drives, NaN where it does not.

        NaN, too, where it gives more than it takes, which is what its coils had stored.
        """
        drives = (self.electrical > 0.0) & (self.mechanical >= 0.0) & (self.mechanical <= self.electrical)
        return np.divide(self.mechanical, self.electrical, out=np.full_like(self.electrical, np.nan), where=drives)


@dataclass(frozen=True, slots=True)
class Scan:
    """One revolution of a range sensor, in the sensor's frame.

    Attributes:
        stamp: time of the last beam [s].
        angles: (b,) beam directions [rad], counter-clockwise from the sensor's x axis.
        ranges: (b,) distances [m]; infinite = no return, NaN = invalid.
        offsets: (b,) time of each beam relative to `stamp` [s], at most 0; all 0 for an instantaneous scan.
        mount: pose of the sensor in `base_link`.
        range_min, range_max: what the sensor can tell [m].
    """

    stamp: float
    angles: Array
    ranges: Array
    offsets: Array
    mount: Pose = Pose(0.0, 0.0, 0.0)
    range_min: float = 0.0
    range_max: float = float("inf")


@dataclass(frozen=True, slots=True)
class Observation:
    """All that the robot can know at one control tick. What a robot has no sensor for is None or empty.

    Attributes:
        time: monotonic seconds since start.
        dt: seconds since the previous tick (the control period on the first).
        wheels: encoder readings.
        gyro: yaw rate [rad/s].
        accel: (2,) specific force along x and y [m/s^2].
        mice: (k, 2) displacement of each ground sensor since the last tick, in its own axes [m].
        scan: newest range scan; `scan_is_new` when it arrived since the last tick.
    """

    time: float
    dt: float
    wheels: WheelState
    gyro: float | None = None
    accel: Array | None = None
    mice: Array | None = None
    scan: Scan | None = None
    scan_is_new: bool = False


@dataclass(frozen=True, slots=True)
class Estimate:
    """What the robot believes of itself.

    Attributes:
        pose: in `odom`, heading not wrapped.
        twist: in `base_link`.
        covariance: (3, 3) of the pose [m^2, m rad, rad^2], world axes.
        slip: root mean square of what the wheels (or ground sensors) contradict each other in [m/s of rim]; 0 with
            three wheels.
        suspect: ground sensors that are not trusted at this tick, bit k for sensor k: lifted off, slipping or dead.
    """

    pose: Pose
    twist: Twist
    covariance: Array
    slip: float = 0.0
    suspect: int = 0


class Reference(NamedTuple):
    """Where the robot shall be now and how that place moves.

    `pose`, `twist` and `accel` are in the world frame (twist is the time derivative of pose).
    `last` is True when this place will not move any more: reaching it is arriving.
    """

    pose: Pose
    twist: Twist = Twist(0.0, 0.0, 0.0)
    accel: Twist = Twist(0.0, 0.0, 0.0)
    last: bool = True


class Decision(NamedTuple):
    """A controller's answer: the command, and whether it is done or in trouble (`fault` is for people).

    `no_rule` is True while a fuzzy controller has no rule to fire and acts by its policy for that.
    """

    command: Command
    arrived: bool = False
    fault: str = ""
    no_rule: bool = False


@dataclass(frozen=True, slots=True)
class Event:
    """Something that happened once: a collision, a refused command, an arrival.

    Attributes:
        time: [s].
        kind: "collision", "gate", "arrived", "fault", "no_rule", "sensor", "stop".
        text: for people.
        pose: of the robot, in the world.
        data: numbers that belong to it, such as place of contact [m] and who moved.
    """

    time: float
    kind: str
    text: str
    pose: Pose
    data: dict[str, Any] = field(default_factory=dict)
