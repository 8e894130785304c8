"""A wheel, and the one wheel equation that serves omni, Mecanum, any roller angle and steered wheels.

A wheel touches the ground at (x, y), drives along `yaw`, and pushes along the axis of the roller on the ground,
`yaw + roller`. With a = (cos, sin) of the push direction and e = (cos, sin) of the rolling direction,

    speed = [a_x, a_y, x a_y - y a_x] . twist / (r a.e)                     (paper 000 eq. 16, any wheel)

A steered wheel sees its whole contact velocity v = [[1, 0, -y], [0, 1, x]] . twist, turned into its own axes.
Where its contact trails behind the steering axis, (x, y) is that axis and `kinematics.caster` has the rest.
"""

import math
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Literal

import numpy as np
from numpy.typing import ArrayLike

from holodrive.errors import ChassisError
from holodrive.kinematics.shapes import twists
from holodrive.types import Array

if TYPE_CHECKING:
    from holodrive.robots.spec import WheelSpec

Kind = Literal["omni", "mecanum", "swerve"]

MIN_PUSH = 1e-6  # |a.e| below this: the rollers run free along the rolling direction, the wheel drives nothing


@dataclass(frozen=True, slots=True)
class Wheel:
    """One wheel in `base_link` axes. Use the factories `omni`, `mecanum`, `swerve`.

    Attributes:
        kind: "omni", "mecanum" or "swerve".
        x, y: contact point [m]; of a caster the steering axis.
        yaw: direction in which positive speed drives [rad]; for swerve the zero of the steering angle.
        radius: [m].
        roller: from the rolling direction to the roller axis on the ground [rad], modulo pi; 0 for omni.
        name: for messages; a `Chassis` fills it in.
        max_speed: limit [rad/s], infinite when unknown.
        steer_rate: fastest steering [rad/s], infinite when unknown; swerve only.
        caster: how far the contact trails behind the steering axis [m]; below 0 it runs ahead; swerve only.
        coupling: turns of the wheel against its drive per turn of the steering; swerve only.
    """

    kind: Kind
    x: float
    y: float
    yaw: float
    radius: float
    roller: float = 0.0
    name: str = ""
    max_speed: float = math.inf
    steer_rate: float = math.inf
    caster: float = 0.0
    coupling: float = 0.0

    def __post_init__(self) -> None:
        label = f"wheel {self.name!r}" if self.name else f"{self.kind} wheel at ({self.x:g}, {self.y:g})"
        for field in ("x", "y", "yaw", "radius", "roller", "caster", "coupling"):
            if not math.isfinite(getattr(self, field)):
                raise ChassisError(f"{label}: {field} is {getattr(self, field)}; give a finite number")
        for field in ("radius", "max_speed", "steer_rate"):
            if not getattr(self, field) > 0.0:
                raise ChassisError(f"{label}: {field} is {getattr(self, field):g}; it must be greater than 0")
        if self.kind != "swerve" and abs(math.cos(self.roller)) < MIN_PUSH:
            raise ChassisError(
                f"{label}: its rollers run free along the rolling direction (roller angle "
                f"{math.degrees(self.roller):g} deg), so it drives nothing; use 0 for omni, +-45 deg for Mecanum"
            )

    @classmethod
    def omni(
        cls, x: float, y: float, yaw: float, radius: float, *, name: str = "", max_speed: float = math.inf
    ) -> "Wheel":
        """Omni wheel: its rollers run free across the rolling direction."""
        return cls("omni", float(x), float(y), float(yaw), float(radius), 0.0, name, float(max_speed))

    @classmethod
    def mecanum(
        cls,
        x: float,
        y: float,
        yaw: float,
        radius: float,
        roller: float,
        *,
        name: str = "",
        max_speed: float = math.inf,
    ) -> "Wheel":
        """Mecanum wheel; `roller` [rad] belongs to the roller that touches the ground.

        A usual base has front left -45, front right +45, rear left +45, rear right -45 degrees.
        """
        return cls("mecanum", float(x), float(y), float(yaw), float(radius), float(roller), name, float(max_speed))

    @classmethod
    def swerve(
        cls,
        x: float,
        y: float,
        radius: float,
        *,
        yaw: float = 0.0,
        name: str = "",
        max_speed: float = math.inf,
        steer_rate: float = math.inf,
        caster: float = 0.0,
        coupling: float = 0.0,
    ) -> "Wheel":
        """Steered wheel; its steering angle counts from `yaw` [rad], counter-clockwise."""
        wheel = cls("swerve", float(x), float(y), float(yaw), float(radius), 0.0, name, float(max_speed))
        return replace(wheel, steer_rate=float(steer_rate), caster=float(caster), coupling=float(coupling))

    @classmethod
    def from_paper(cls, alpha: float, beta: float, gamma: float, l: float, r: float, *, name: str = "") -> "Wheel":  # noqa: E741
        """Wheel from paper 000's parameters: centre at l (cos alpha, sin alpha), axle along beta, roller at gamma.

        Rolling direction beta + 90 deg, roller axis beta - gamma, so `roller` = -90 deg - gamma (gamma modulo pi).
        """
        roller = -math.pi / 2 - gamma
        kind: Kind = "omni" if abs(math.sin(roller)) < 1e-12 else "mecanum"
        return cls(kind, l * math.cos(alpha), l * math.sin(alpha), beta + math.pi / 2, r, roller, name)

    @classmethod
    def of(cls, spec: "WheelSpec") -> "Wheel":
        """The wheel that a robot file describes."""
        roller = spec.roller if spec.kind == "mecanum" else 0.0
        wheel = cls(spec.kind, spec.x, spec.y, spec.yaw, spec.radius, roller, spec.name, spec.max_speed_rad_s)
        if spec.steering is None:
            return wheel
        servo = spec.steering
        return replace(wheel, steer_rate=servo.rate_rad_s, caster=servo.caster_m, coupling=servo.coupling)

    @property
    def steered(self) -> bool:
        """Whether its direction is commanded too."""
        return self.kind == "swerve"

    @property
    def max_rim_speed(self) -> float:
        """Limit of the rim speed [m/s]."""
        return self.max_speed * self.radius

    @property
    def push_axis(self) -> float:
        """Direction [rad] in which the ground can push this wheel: its roller axis."""
        return self.yaw + self.roller

    @property
    def best_lever(self) -> float:
        """Rim speed per yaw rate [m] with the rollers mounted the better way, +roller or -roller.

        |x a_y - y a_x| / |a.e|; the whole distance for a steered wheel.
        """
        if self.steered:
            return math.hypot(self.x, self.y)
        ways = (self.yaw + self.roller, self.yaw - self.roller)
        return max(abs(self.x * math.sin(a) - self.y * math.cos(a)) for a in ways) / abs(math.cos(self.roller))

    @property
    def rows(self) -> Array:
        """Its rows of the Jacobian: (1, 3) [rad/s per twist] fixed, (2, 3) [m/s per twist] steered.

        The two rows of a steered wheel are the velocity of its contact (of a caster's axis) along and across `yaw`.
        """
        if self.steered:
            c, s = math.cos(self.yaw), math.sin(self.yaw)
            return np.array([[c, s, self.x * s - self.y * c], [-s, c, self.x * c + self.y * s]])
        ax, ay = math.cos(self.push_axis), math.sin(self.push_axis)
        return np.array([[ax, ay, self.x * ay - self.y * ax]]) / (self.radius * math.cos(self.roller))

    def roller_speed(self, twist: ArrayLike) -> Array:
        """Surface speed [m/s] of the roller on the ground along its free direction, for twists (..., 3).

        Paper 000 eq. 14 row 2: u = s.v / s.f with s across the rolling direction, f across the roller axis.
        """
        twist = twists(twist)
        c, s = math.cos(self.yaw), math.sin(self.yaw)
        across = np.array([-s, c, self.x * c + self.y * s])
        return np.asarray(twist @ across / math.cos(self.roller))

    def named(self, name: str) -> "Wheel":
        """The same wheel under a name."""
        return replace(self, name=name)
