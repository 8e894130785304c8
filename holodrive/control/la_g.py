"""LA-G path tracking: one angle, mapped linearly to gains of the two wheel diagonals of a Mecanum base.

J. S. Keek, S. L. Loh and S. H. Chong, "Comprehensive Development and Control of a Path-Trackable Mecanum-Wheeled
Robot", sections IV and V. With the robot at p, the target at q and both angles in degrees as in the paper,

    theta = alpha + alpha_G                      (eq. 16)
    M_j = Kp |q - p| g_j(theta)                  (eq. 18, 19)

where alpha = atan2(p - q) is the direction from the target to the robot and alpha_G the heading clockwise from +Y.
Its robot looks along its y axis, ours along x: theta = direction to the target in `base_link` minus 90 deg.
M_14 is the speed with which the base moves when the diagonal W1W4 (front right, rear left) runs alone, which is
ahead and to the left at 45 deg; M_23 belongs to W2W3 (front left, rear right), ahead and to the right. A wheel's rim
then runs at sqrt(2) M.
"""

import math
from dataclasses import dataclass
from typing import Any, ClassVar, Literal

import numpy as np
from numba import njit
from numpy.typing import ArrayLike

from holodrive import layout
from holodrive.control.parameters import checked
from holodrive.errors import InputError
from holodrive.interfaces import CommandKind
from holodrive.kinematics import Chassis
from holodrive.kinematics.kernel import wrap
from holodrive.leaf import leaf
from holodrive.robots.spec import Robot
from holodrive.types import Array

Variant = Literal["clean", "printed", "cosine"]
Saturation = Literal["common", "pairs"]

CLEAN, PRINTED, COSINE = 0, 1, 2
VARIANTS: dict[Variant, int] = {"clean": CLEAN, "printed": PRINTED, "cosine": COSINE}
_SATURATIONS: dict[Saturation, int] = {"common": 0, "pairs": 1}

_KP, _KP_HEADING, _LIMIT, _TURN_ON, _TURN_OFF, _ARRIVE_M, _ARRIVE_RAD, _VARIANT, _PAIRS, _N, _WHEELS = range(11)
_PER_WHEEL = 3  # wheel speed [rad/s] per speed of W1W4, of W2W3 and of turning [m/s]

_AXIS_14, _AXIS_23 = math.pi / 4.0, -math.pi / 4.0  # where the diagonals drive alone, `base_link` [rad]
_AXIS_TOLERANCE = 1e-3  # rad
# headings add up from whole counts of the sensors, so that an error of 0 comes back; rounding must not hide it
_NO_ERROR = 1e-9  # rad

# where to look for good values (`holodrive tune`)
BOUNDS: dict[str, tuple[float, float] | tuple[float, float, str]] = {
    "kp": (0.5, 10.0, "log"),
    "kp_heading": (0.02, 2.0, "log"),
    "dead_band_rad": (math.radians(0.1), math.radians(3.0)),
    "hysteresis_rad": (0.0, math.radians(0.5)),
}

# the pieces of eq. 14 and 15 [deg]: where a piece begins, where it ends as printed, and both gains at either end
_PIECES = (
    (0.0, 44.9, 0.50, 0.01, -0.50, -0.99),
    (45.0, 134.9, 0.0, -0.99, -1.00, -0.01),
    (135.0, 224.9, -1.00, -0.01, 0.0, 0.99),
    (225.0, 314.9, 0.0, 0.99, 1.00, 0.01),
    (315.0, 359.9, 1.00, 0.51, 0.0, -0.49),
)


def gains(theta: ArrayLike, variant: Variant = "clean") -> tuple[Array, Array]:
    """Gains (g14, g23) of the two diagonals.

    "printed" is eq. 14 and 15 with their end points, 0.1 deg short of the next piece and 0.01 short of its gain: at
    most 0.0089 beside "clean", the triangle waves that they are steps of, with jumps of that size. "cosine" is the
    exact map: the robot moves straight to its target, at the same speed in every direction.

    Args:
        theta: (...) direction from the target to the robot plus heading, eq. 16 [rad].
        variant: "clean", "printed" or "cosine".

    Raises:
        InputError: no such variant.
    """
    angle = np.asarray(theta, dtype=np.float64)
    if variant == "cosine":
        return -np.cos(angle - 0.75 * math.pi), -np.cos(angle - 0.25 * math.pi)
    degrees = np.degrees(angle)
    degrees = degrees - 360.0 * np.floor(degrees / 360.0)
    if variant == "clean":
        return _triangle(degrees - 135.0), _triangle(degrees - 45.0)
    if variant != "printed":
        raise InputError(f"LA-G gains have no variant {variant!r}; allowed: {', '.join(VARIANTS)}")
    pieces = np.array(_PIECES)
    which = np.searchsorted(pieces[1:, 0], degrees, side="right")  # a NaN sorts last and stays one
    begin, end, a14, b14, a23, b23 = np.moveaxis(pieces[which], -1, 0)
    share = (degrees - begin) / (end - begin)
    return np.asarray(a14 + share * (b14 - a14)), np.asarray(a23 + share * (b23 - a23))


def _triangle(degrees: Array) -> Array:
    """-1 at 0 deg, 1 at 180 deg, straight between."""
    away = degrees - 360.0 * np.round(degrees / 360.0)
    return np.asarray(np.abs(away) / 90.0 - 1.0)


@leaf
def pair_gains(theta, variant):  # type: ignore[no-untyped-def]
    """As `gains`, of one angle and a variant by its number."""
    if variant == COSINE:
        return -math.cos(theta - 0.75 * math.pi), -math.cos(theta - 0.25 * math.pi)
    degrees = math.degrees(theta)
    degrees -= 360.0 * math.floor(degrees / 360.0)
    if variant == CLEAN:
        return triangle(degrees - 135.0), triangle(degrees - 45.0)
    which = 4
    for k in range(4):
        if degrees < _PIECES[k + 1][0]:
            which = k
            break
    begin, end, a14, b14, a23, b23 = _PIECES[which]
    share = (degrees - begin) / (end - begin)
    return a14 + share * (b14 - a14), a23 + share * (b23 - a23)


@leaf
def triangle(degrees):  # type: ignore[no-untyped-def]
    """-1 at 0 deg, 1 at 180 deg, straight between."""
    return abs(degrees - 360.0 * np.round(degrees / 360.0)) / 90.0 - 1.0


@leaf
def saturated(m14, m23, limit, pairs):  # type: ignore[no-untyped-def]
    """Speeds of both diagonals within `limit` [m/s]: scaled by one factor, or each cut by itself (`pairs`)."""
    if pairs != 0.0:
        return min(max(m14, -limit), limit), min(max(m23, -limit), limit)
    scale = limit / max(abs(m14), abs(m23), limit)
    return scale * m14, scale * m23


@njit(cache=True)
def la_g_kernel(obs, memory, params, command):  # type: ignore[no-untyped-def]
    """Correct the heading while it is off by more than the dead band, drive to the target else.

    memory: 1.0 while turning (1).
    """
    ex = obs[layout.REF_POSE] - obs[layout.POSE]
    ey = obs[layout.REF_POSE + 1] - obs[layout.POSE + 1]
    heading = obs[layout.POSE + 2]
    off = wrap(obs[layout.REF_POSE + 2] - heading)
    away = math.hypot(ex, ey)
    # heading first (section V): it starts above the band and ends below what hysteresis leaves of it
    memory[0] = 1.0 if abs(off) > params[_TURN_OFF if memory[0] != 0.0 else _TURN_ON] else 0.0
    m14 = m23 = turn = 0.0
    if memory[0] != 0.0:
        turn = min(max(params[_KP_HEADING] * off, -params[_LIMIT]), params[_LIMIT])
        turn += 0.0 * away  # a position that is not a number stops the robot while it turns as well
    else:
        theta = math.atan2(ey, ex) - heading - 0.5 * math.pi
        g14, g23 = pair_gains(theta, params[_VARIANT])
        output = params[_KP] * away
        m14, m23 = saturated(output * g14, output * g23, params[_LIMIT], params[_PAIRS])
    for i in range(int(params[_N])):
        k = _WHEELS + _PER_WHEEL * i
        command[layout.VALUE + i] = params[k] * m14 + params[k + 1] * m23 + params[k + 2] * turn
    near = away <= params[_ARRIVE_M] and abs(off) <= params[_ARRIVE_RAD]
    command[layout.ARRIVED] = 1.0 if near and obs[layout.REF_LAST] != 0.0 else 0.0


@dataclass(frozen=True)
class LaG:
    """The paper's tracker: two P controllers, of which the one for the heading goes first.

    It takes a target that stands (a step) or one that moves (a ramp); its heading reference is the target's. It knows
    no velocities: behind a ramp of speed V it stays V / (kp |g|), |g| = 0.71 to 1. Wheels are found by where they
    drive, whatever their names and order.

    Attributes:
        variant: of the gains: "printed", "clean" or "cosine".
        saturation: "common" scales both diagonals by one factor and keeps the direction; "pairs" cuts each by
            itself, as the paper's equations do, and loses it.
        kp: of the position [1/s].
        kp_heading: [m/s of diagonal speed per rad]; the paper's 1.0 is 1 mm/s per degree.
        max_speed_m_s: of a diagonal (the paper's 37 mm/s); at most what the slowest wheel can do.
        dead_band_rad: heading error above which only the heading is corrected; 0 as printed.
        hysteresis_rad: how far below the dead band the error must fall for the position to be resumed; while the
            heading is corrected the target of a ramp moves on, so a wide one costs more than it saves.
        arrive_m, arrive_rad: how near is there.
    """

    variant: Variant = "clean"
    saturation: Saturation = "common"
    kp: float = 2.0
    kp_heading: float = 1e-3 / math.radians(1.0)
    max_speed_m_s: float = 0.037
    dead_band_rad: float = math.radians(1.0)
    hysteresis_rad: float = math.radians(0.1)
    arrive_m: float = 0.002
    arrive_rad: float = math.radians(2.0)

    command_kind: ClassVar[CommandKind] = "wheels"
    kernel: ClassVar[Any] = staticmethod(la_g_kernel)
    needs_diagonals: ClassVar[bool] = True

    def __post_init__(self) -> None:
        checked(
            self,
            positive=("kp", "kp_heading", "max_speed_m_s", "arrive_m", "arrive_rad"),
            not_negative=("dead_band_rad", "hysteresis_rad"),
        )

    def memory_size(self, robot: Robot) -> int:
        """Whether it turns."""
        return 1

    def pack(self, robot: Robot) -> Array:
        """As the kernel's index constants say.

        Raises:
            InputError: the robot's wheels are not the two diagonals of a Mecanum base.
        """
        wheels = wheel_speeds(robot)
        fastest = [wheel.max_speed_rad_s for wheel in robot.wheels] / np.abs(wheels[:, :2]).max(axis=1)
        numbers = [
            self.kp,
            self.kp_heading,
            min(self.max_speed_m_s, fastest.min()),
            max(self.dead_band_rad, _NO_ERROR),
            max(self.dead_band_rad - self.hysteresis_rad, _NO_ERROR),
            self.arrive_m,
            self.arrive_rad,
            VARIANTS[self.variant],
            _SATURATIONS[self.saturation],
            len(wheels),
        ]
        return np.array([*numbers, *wheels.ravel()], dtype=np.float64)


def wheel_speeds(robot: Robot) -> Array:
    """Wheel speeds (4, 3) [rad/s] per speed of the diagonals W1W4 and W2W3 and of turning [m/s].

    The last column turns on the spot: left wheels against right ones (figure 14), all rims at sqrt(2) times the speed
    on a symmetric base, the one farthest out on another.

    Raises:
        InputError: the wheels are not four Mecanum wheels that push along two diagonals at +-45 deg.
    """
    axes = [wheel.yaw + wheel.roller for wheel in robot.wheels]
    diagonals = [sum(_along(axis, wanted) for axis in axes) for wanted in (_AXIS_14, _AXIS_23)]
    if {wheel.kind for wheel in robot.wheels} != {"mecanum"} or diagonals != [2, 2]:
        found = ", ".join(
            f"{wheel.name} ({wheel.kind}"
            + (f" {math.degrees(0.5 * wrap(2.0 * axis)):+.3g} deg)" if wheel.kind == "mecanum" else ")")
            for wheel, axis in zip(robot.wheels, axes, strict=True)
        )
        raise InputError(
            f"la_g drives four Mecanum wheels, two that push along +45 deg and two along -45 deg; robot {robot.name} "
            f"has {found}; use go_to_pose or pid"
        )
    jacobian, c = Chassis.of(robot).jacobian, math.sqrt(0.5)
    farthest = np.abs(jacobian[:, 2] * [wheel.radius for wheel in robot.wheels]).max()
    columns = (jacobian @ (c, c, 0.0), jacobian @ (c, -c, 0.0), math.sqrt(2.0) / farthest * jacobian[:, 2])
    return np.column_stack(columns)


def _along(direction: float, axis: float) -> bool:
    return abs(math.sin(direction - axis)) <= _AXIS_TOLERANCE
