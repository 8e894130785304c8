"""A base: named wheels, the matrices that they make, and the maps between twists and wheels.

`inverse` goes from body to wheels, `forward` from wheels to body (the two names are often swapped elsewhere).

Rows of `jacobian`, in the order of the wheels: a fixed wheel has one row [rad/s per twist]; a steered wheel has two,
its contact velocity along and across its zero direction [m/s per twist]. A pure swerve base thus has the contact
map stacked (2n, 3). Least squares is unweighted over those rows, with one exception that makes units agree: in a
base that mixes both kinds, rows of steered wheels count divided by the mean wheel radius.
"""

from collections.abc import Iterable, Mapping, Sequence
from functools import cached_property, lru_cache
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from holodrive.errors import ChassisError
from holodrive.kinematics import acceleration, caster, limits, solve
from holodrive.kinematics.judge import WARN_CONDITION, Verdict, judge
from holodrive.kinematics.polytope import Polytope
from holodrive.kinematics.scalar import Scalar
from holodrive.kinematics.settings import POWERED, POWERED_CASTER
from holodrive.kinematics.shapes import common_shape, numbers, read_only, short, twists, vectors, wheel_values
from holodrive.kinematics.wheel import Wheel
from holodrive.types import Array, WheelCommand

if TYPE_CHECKING:
    from holodrive.robots.spec import Robot


class Chassis:
    """Wheels on one rigid body. Built once, immutable, judged when built.

    Attributes:
        wheels: (n) in order; every array of wheel values has this order.
        names: their names.
        jacobian: (rows, 3), see the module's text.
        least_squares: (3, rows) the pseudo-inverse that `forward` uses.
        row: (n,) first row of each wheel.
        steered: indices of the steered wheels, the order of steering arrays (m,).
        casters, couplings: (m,) of the steered wheels [m, 1], see `kinematics.caster`.
        castered: whether any contact trails behind its axis.
        trails: 0 without casters and couplings; 2 where the command pipeline drives all modules as powered casters,
            which it does when each trails (or runs ahead) by `settings.POWERED_CASTER` or more; else 1.
        verdict: rank, condition and characteristic length.
        warnings: sentences about a poor but usable layout.
    """

    def __init__(self, wheels: Mapping[str, Wheel] | Sequence[Wheel]) -> None:
        self.wheels = _named(wheels)
        self.names = tuple(wheel.name for wheel in self.wheels)
        blocks = [wheel.rows for wheel in self.wheels]
        self.row = np.cumsum([0, *(len(block) for block in blocks)])[:-1]
        self.steered = tuple(i for i, wheel in enumerate(self.wheels) if wheel.steered)
        self.casters = np.array([self.wheels[i].caster for i in self.steered])
        self.couplings = np.array([self.wheels[i].coupling for i in self.steered])
        self.castered = bool(np.any(self.casters != 0.0))
        powered = self.castered and bool(np.all(np.abs(self.casters) >= POWERED_CASTER))
        self.trails = POWERED if powered else int(self.castered or bool(np.any(self.couplings != 0.0)))
        self.jacobian = _clean(np.concatenate(blocks))
        self.row_scale = _row_scale(self.wheels)  # (rows,) brings mixed rows to one unit
        self.verdict: Verdict = judge(self.wheels, self.jacobian * self.row_scale[:, None])
        if self.verdict.lost:
            raise ChassisError(f"{'; '.join(self.verdict.lost)}: {self.verdict.cause}. {_ADVICE}")
        self.warnings = _warnings(self.verdict)
        # with the columns in one unit the inverse loses no more digits than the condition number says
        column = np.array([1.0, 1.0, 1.0 / self.verdict.length])
        inverse = np.linalg.pinv(self.jacobian * self.row_scale[:, None] * column) * self.row_scale
        self.least_squares = _clean(column[:, None] * inverse)
        # `of` gives one chassis to many users
        for array in (self.jacobian, self.least_squares, self.row, self.row_scale, self.casters, self.couplings):
            read_only(array)

    @classmethod
    def of(cls, robot: "Robot") -> "Chassis":
        """The chassis of a described robot; built once for each."""
        return _of(robot)

    @property
    def rank(self) -> int:
        """Motions that the wheels can tell apart; 3, for a chassis with less is refused."""
        return self.verdict.rank

    @property
    def condition(self) -> float:
        """Condition number of J diag(1, 1, 1/L_c): 1 is perfect, above 10 is poor."""
        return self.verdict.condition

    @property
    def characteristic_length(self) -> float:
        """L_c [m]: mean rim speed per yaw rate, with rollers mounted the better way."""
        return self.verdict.length

    @property
    def redundancy(self) -> int:
        """Rows beyond the three unknowns; 0 means that the wheels cannot contradict each other."""
        return len(self.jacobian) - 3

    @cached_property
    def scalar(self) -> Scalar:
        """The same maps for plain floats, several times faster for one tick."""
        return Scalar(self)

    @cached_property
    def max_speeds(self) -> Array:
        """(n,) wheel speed limits [rad/s]."""
        return read_only(np.array([wheel.max_speed for wheel in self.wheels]))

    @cached_property
    def radii(self) -> Array:
        """(n,) wheel radii [m]."""
        return read_only(np.array([wheel.radius for wheel in self.wheels]))

    @cached_property
    def fixed_rows(self) -> Array:
        """Rows of the wheels that are not steered."""
        fixed = [self.row[i] for i in range(len(self.wheels)) if i not in self.steered]
        return read_only(np.array(fixed, dtype=np.intp))

    @cached_property
    def steered_rows(self) -> Array:
        """First rows of the steered wheels."""
        return read_only(np.array([self.row[i] for i in self.steered], dtype=np.intp))

    def inverse(self, twist: ArrayLike, centre: ArrayLike = (0.0, 0.0)) -> WheelCommand:
        """Wheels for a twist: body -> wheels.

        Args:
            twist: (..., 3) velocity of the point `centre` in `base_link` axes [m/s, m/s, rad/s].
            centre: (..., 2) point [m] whose velocity is meant, so that a pure rotation turns about it.

        Returns:
            speeds (..., n) [rad/s] and steer (..., m) [rad]. A steered wheel gets the plain polar form: speed >= 0,
            angle in (-pi, pi], no optimisation; with a caster the angle at which it does not slip while the twist
            lasts (`kinematics.caster.steady_inverse`).
        """
        if self.castered:
            return caster.steady_inverse(self, about(twist, centre))
        rows = self.wheel_rows(about(twist, centre))
        if not self.steered:
            return WheelCommand(rows, np.empty((*rows.shape[:-1], 0)))
        along, across = rows[..., self.steered_rows], rows[..., self.steered_rows + 1]
        speeds = rows[..., self.row]
        index = list(self.steered)
        speeds[..., index] = np.hypot(along, across) / self.radii[index]
        return WheelCommand(speeds, np.arctan2(across, along))

    def powered_inverse(self, twist: ArrayLike, steer: ArrayLike) -> caster.PoweredRates:
        """Wheel speeds and steering rates of powered casters for a twist; see `kinematics.caster`."""
        return caster.powered_inverse(self, twist, steer)

    def forward(self, speeds: ArrayLike, steer: ArrayLike | None = None, steer_rates: ArrayLike | None = None) -> Array:
        """Twist (..., 3) of the body that fits the wheels best: wheels -> body, least squares.

        Args:
            speeds: (..., n) [rad/s].
            steer: (..., m) steering angles [rad]; needed when the base has steered wheels, refused when it has none.
            steer_rates: (..., m) how fast they turn [rad/s]; matters with casters only, 0 when not given.
        """
        rows = self.rows_of(speeds, steer, steer_rates)
        if not self.castered:
            return np.asarray(rows @ self.least_squares.T)
        return np.asarray(np.einsum("...ij,...j->...i", self.inverse_at(self.matrix_at(steer)), rows))

    def matrix_at(self, steer: ArrayLike | None) -> Array:
        """The Jacobian (rows, 3); with casters (..., rows, 3), for it changes with the steering angles (..., m)."""
        angles = self.steering(steer, "steering angles") if self.castered else None
        return self.jacobian if angles is None else caster.contact_jacobian(self, angles)

    def inverse_at(self, matrix: Array) -> Array:
        """Least-squares inverse (..., 3, rows) of what `matrix_at` gave."""
        return caster.contact_inverse(self, matrix) if self.castered else self.least_squares

    def solve(
        self,
        speeds: ArrayLike,
        steer: ArrayLike | None = None,
        weights: ArrayLike | None = None,
        wheel_sigma: ArrayLike | None = None,
        steer_rates: ArrayLike | None = None,
    ) -> solve.Solution:
        """Like `forward`, with residual, slip and covariance; see `holodrive.kinematics.solve.solve`."""
        return solve.solve(self, speeds, steer, weights, wheel_sigma, steer_rates)

    def inverse_acceleration(
        self, twist: ArrayLike, accel: ArrayLike, centre: ArrayLike = (0.0, 0.0)
    ) -> acceleration.WheelAcceleration:
        """Wheel and steering rates for the rate of a twist; see `holodrive.kinematics.acceleration`."""
        return acceleration.inverse_acceleration(
            self, about(twist, centre), about(accel, centre, "the rate of a twist")
        )

    def forward_acceleration(
        self,
        speeds: ArrayLike,
        rates: ArrayLike,
        steer: ArrayLike | None = None,
        steer_rates: ArrayLike | None = None,
        steer_accels: ArrayLike | None = None,
    ) -> Array:
        """Rate of the twist (..., 3) from wheel and steering rates, least squares."""
        return acceleration.forward_acceleration(self, speeds, rates, steer, steer_rates, steer_accels)

    def saturate(self, twist: ArrayLike) -> limits.Applied:
        """Twists (..., 3) scaled into what the wheels can do, direction kept; scale and binding wheel come along."""
        return limits.saturate(self, twist)

    def max_speed(self, direction: ArrayLike, omega: ArrayLike = 0.0) -> Array:
        """Largest speed (...) [m/s] towards `direction` (...) [rad] while turning with `omega` (...) [rad/s]."""
        return limits.max_speed(self, direction, omega)

    @cached_property
    def polytope(self) -> Polytope:
        """The set of twists that the wheel speed limits allow."""
        return Polytope(self)

    def wheel_rows(self, twist: ArrayLike) -> Array:
        """J . twist, (..., rows) in the units of the rows."""
        return np.asarray(twists(twist) @ self.jacobian.T)

    def rows_of(self, speeds: ArrayLike, steer: ArrayLike | None = None, steer_rates: ArrayLike | None = None) -> Array:
        """What wheels that turn so say about J . twist: (..., rows)."""
        speeds = wheel_values(speeds, self.names, "wheel speeds")
        angles = self.steering(steer, "steering angles")
        if angles is None:
            return speeds
        index = list(self.steered)
        rim = speeds[..., index] * self.radii[index]
        shape = common_shape(speeds=rim.shape[:-1], steer=angles.shape[:-1])
        rows = np.empty((*shape, len(self.jacobian)))
        rows[..., self.row] = speeds
        rows[..., self.steered_rows] = rim * np.cos(angles)
        rows[..., self.steered_rows + 1] = rim * np.sin(angles)
        rates = None if steer_rates is None else self.steering(steer_rates, "rates of steering")
        return rows if rates is None or not self.castered else caster.swept(self, rows, angles, rates)

    def steering(self, values: ArrayLike | None, what: str) -> Array | None:
        """What a caller passed for the steered wheels, as (..., m); None where the base has none."""
        names = tuple(self.names[i] for i in self.steered)
        if names and values is None:
            raise ChassisError(f"this base needs {what} (..., {len(names)}), one for each of {', '.join(names)}")
        if names:
            return wheel_values(values if values is not None else (), names, what)
        # `inverse` answers with an empty array, which may come back
        if values is not None and numbers(values, what).shape[-1:] != (0,):
            raise ChassisError(f"{what} {short(values)} for a base that has no steered wheel; leave them out")
        return None

    def __repr__(self) -> str:
        kinds = ", ".join(f"{wheel.name}: {wheel.kind}" for wheel in self.wheels)
        return f"Chassis({kinds}; condition {self.condition:.3g})"


def about(twist: ArrayLike, centre: ArrayLike, what: str = "a twist") -> Array:
    """Twist (..., 3) of the base from the velocity of its point `centre` (..., 2) [m]."""
    twist, centre = twists(twist, what), vectors(centre, 2, "the centre", "x and y [m]")
    if centre.ndim > 1:
        common_shape(twist=twist.shape[:-1], centre=centre.shape[:-1])
    omega = twist[..., 2]
    vx, vy = twist[..., 0] + omega * centre[..., 1], twist[..., 1] - omega * centre[..., 0]
    return np.stack([vx, vy, np.broadcast_to(omega, vx.shape)], axis=-1)


_ADVICE = "Move or turn a wheel, or change a roller angle, so that not all push axes are parallel or meet in one point"


@lru_cache(maxsize=64)
def _of(robot: "Robot") -> Chassis:
    return Chassis([Wheel.of(spec) for spec in robot.wheels])


def _named(wheels: Mapping[str, Wheel] | Sequence[Wheel]) -> tuple[Wheel, ...]:
    pairs = _pairs(wheels)
    for key, wheel in pairs:
        if not isinstance(wheel, Wheel):
            raise ChassisError(f"wheel {key} is {short(wheel)}; make it with Wheel.omni, Wheel.mecanum or Wheel.swerve")
    if isinstance(wheels, Mapping):
        named = tuple(wheel.named(str(name)) for name, wheel in pairs)
    else:
        _default_names_free(pairs)
        named = tuple(wheel if wheel.name else wheel.named(f"wheel{i}") for i, wheel in pairs)
    if not named:
        raise ChassisError("a chassis without wheels; give at least three fixed wheels or two steered ones")
    names = [wheel.name for wheel in named]
    if twice := sorted({name for name in names if names.count(name) > 1}):
        raise ChassisError(f"two wheels are called {twice[0]!r}; every wheel needs a name of its own")
    return named


def _default_names_free(pairs: list[tuple[int, Wheel]]) -> None:
    """Refuse a given name that is the default name of a wheel without one."""
    given = {wheel.name: number for number, wheel in pairs if wheel.name}
    for number, wheel in pairs:
        if not wheel.name and (owner := given.get(f"wheel{number}")):
            raise ChassisError(
                f"wheel {owner} is called 'wheel{number}', which would be the name of wheel {number}; "
                f"give wheel {number} a name too"
            )


def _pairs(wheels: Any) -> list[tuple[Any, Any]]:
    """Keys and wheels of a mapping; numbers from 1 and wheels of a sequence."""
    if isinstance(wheels, Mapping):
        return list(wheels.items())
    if isinstance(wheels, str) or not isinstance(wheels, Iterable):
        raise ChassisError(
            f"the wheels are {short(wheels)}; give a list or a dict of Wheel.omni, Wheel.mecanum or Wheel.swerve"
        )
    return list(enumerate(wheels, 1))


def _row_scale(wheels: Sequence[Wheel]) -> Array:
    """1 for every row, but 1 / (mean radius) for steered rows beside fixed ones."""
    mixed = len({wheel.steered for wheel in wheels}) == 2
    steered = len(wheels) / sum(wheel.radius for wheel in wheels) if mixed else 1.0
    scales: list[Any] = [[steered, steered] if wheel.steered else [1.0] for wheel in wheels]
    return np.concatenate(scales)


def _clean(matrix: Array) -> Array:
    """Entries that are rounding of an exact zero, such as cos(90 deg), become zero."""
    limit = 4e-16 * np.max(np.abs(matrix), axis=0, keepdims=True)
    return np.ascontiguousarray(np.where(np.abs(matrix) <= limit, 0.0, matrix))


def _warnings(verdict: Verdict) -> tuple[str, ...]:
    if verdict.condition <= WARN_CONDITION:
        return ()
    return (
        f"condition {verdict.condition:.3g} is above {WARN_CONDITION:g}: some motion needs far faster wheels than "
        "another, and odometry is as much worse there",
    )
