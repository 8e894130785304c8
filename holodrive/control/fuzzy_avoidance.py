"""Fuzzy obstacle avoidance with a lidar on the way to a goal: the controller of the first paper, completed."""

import math
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Any, ClassVar, Literal, NamedTuple

import numpy as np

from holodrive.control import avoidance, fuzzy
from holodrive.control.avoidance import fuzzy_avoidance_kernel, guided
from holodrive.control.fuzzy import profiles
from holodrive.control.fuzzy.packing import work_size
from holodrive.control.fuzzy.system import System
from holodrive.control.parameters import checked
from holodrive.errors import InputError
from holodrive.interfaces import CommandKind
from holodrive.kinematics.chassis import Chassis
from holodrive.perception.sector_ranges import RangeFrom, Sectors
from holodrive.robots.spec import Lidar, Robot
from holodrive.types import Array

Motor = Literal["own", "22rpm", "deg_s", "mm_s", "table_x"]
# rad/s at output +-300: the paper's motor; outputs as degrees a second; what Table X's mean of 0.211 m/s takes
OMEGA_RAD_S = {"22rpm": 22.0 * math.pi / 30.0, "deg_s": math.radians(300.0), "table_x": 7.82}
EVADE_SPEED = 1.35  # of evasive motions, in shares of cruising speed
FAR_M = 3.0  # what the paper's program takes for no return; its universe ends at 2.5 m
INPUT_NAMES, OUTPUT_NAMES = ("DH", "DL", "DR"), ("L", "R")  # distances ahead, left, right; left and right wheel
FULL_MM_S = 300.0  # outputs as mm/s of a differential drive's wheels

# what a number is when neither the user nor the profile says it
DEFAULTS = {
    "offset_m": 0.12,
    "head_deg": 22.5,
    "side_deg": 67.5,
    "corridor_margin_m": 0.06,
    "look_m": 1.2,
    "blocked_m": 0.35,
    "free_m": 0.80,
    "k_heading": 1.5,
    "max_turn_rad_s": 1.0,
    "slow_m": 0.3,
    "barrier_gain": 2.0,
    "barrier_margin_m": 0.045,
    "horizon_s": 4.0,
    "evade_margin_m": 0.10,
    "patience_s": 6.0,
    "inertia_s": 0.2,
}
# What a profile brings beside its sets and rules. Those of `tuned` and its break points were found by
# holodrive tune hybrid3_table_x -c fuzzy --worlds course --metric success --budget 9600 --runs 40 --sigma 0.12 --seed 1
#     --validate 300 --held-out 3000
BY_PROFILE: dict[str, dict[str, float]] = {
    "tuned": {
        "offset_m": 0.138,
        "head_deg": 15.99,
        "side_deg": 72.13,
        "corridor_margin_m": 0.0641,
        "look_m": 1.163,
        "blocked_m": 0.37,
        "free_m": 0.9077,
        "k_heading": 2.219,
        "max_turn_rad_s": 1.157,
        "barrier_gain": 1.005,
        "barrier_margin_m": 0.0598,
        "inertia_s": 0.3074,
    },
}
# what is worth tuning, and where (`holodrive tune`): field -> (lowest, highest)
BOUNDS = {
    "n_top": (100.0, 500.0),
    "n_foot": (250.0, 800.0),
    "m_top": (300.0, 1200.0),
    "f_foot": (400.0, 1500.0),
    "f_top": (600.0, 2200.0),
    "offset_m": (0.0, 0.23),
    "head_deg": (12.0, 40.0),
    "side_deg": (45.0, 120.0),
    "corridor_margin_m": (0.0, 0.15),
    "look_m": (0.5, 2.0),
    "blocked_m": (0.20, 0.45),
    "free_m": (0.50, 1.50),
    "k_heading": (0.5, 4.0),
    "max_turn_rad_s": (0.5, 2.0),
    "barrier_gain": (1.0, 5.0),
    "barrier_margin_m": (0.01, 0.06),
    "inertia_s": (0.0, 0.5),
}


class DifferentialView(NamedTuple):
    """A base seen as one with a left and a right wheel: speed ahead and yaw rate at full command.

    With L and R in -1..1, v = v_top (L + R) / 2 and omega = w_top (R - L) / 2. For the paper's base that is its
    eq. 19 with v_y = 0: v = (R + L) / 53.56, omega = (R - L) / 9.02 with wheel speeds in rad/s.
    """

    v_top_m_s: float
    w_top_rad_s: float

    @classmethod
    def of(cls, robot: Robot, motor: Motor = "own") -> "DifferentialView":
        """Of a robot: as far as its hardest working wheel lets it go straight ahead, and turn."""
        if motor == "mm_s":
            half_track = max(math.hypot(wheel.x, wheel.y) for wheel in robot.wheels)
            return cls(FULL_MM_S / 1000.0, FULL_MM_S / 1000.0 / half_track)
        omega = OMEGA_RAD_S.get(motor) or min(wheel.max_speed_rad_s for wheel in robot.wheels)
        chassis = Chassis.of(robot)
        ahead, turning = (np.max(np.abs(chassis.inverse(twist).speeds)) for twist in ((1.0, 0.0, 0.0), (0.0, 0.0, 1.0)))
        return cls(
            min(float(omega / ahead), robot.limits.speed_m_s), min(float(omega / turning), robot.limits.yaw_rate_rad_s)
        )


@dataclass(frozen=True)
class FuzzyAvoidance:
    """Sectors of the scan to a fuzzy reaction; the goal while the way to it is free; a barrier round everything.

    With g the degree to which a corridor to the goal is free, the command is g times "straight to the goal" and 1 - g
    times the rules' answer. A motion that would meet something that moves is exchanged for one that does not, and
    none is faster towards any point of the scan than a barrier allows. A goal that comes no nearer is approached by
    a via point. Tuama and Hadi give the rules and leave out goal, corridor, barriers and the policy where no rule
    fires; those are ours. Without a scan for `stale_scans` scan times it stops (fault 1); before the first it stands.
    A scan of which most beams tell nothing (NaN, nearer than the sensor can tell) counts as none.

    Attributes:
        profile: a fuzzy system: a name of `fuzzy.names()` or a file. Three inputs DH, DL, DR, two outputs L, R.
        mode: "holonomic" goes to the goal in any direction; "differential" ahead only, as the paper's robot.
        motor: wheel speed [rad/s] at full output: "own" is the robot's slowest wheel's; the paper's 22 rpm; outputs
            as deg/s; as mm/s of a differential drive; or the 7.82 rad/s without which Table X is impossible.
        no_rule: where no rule fires: hold the last answer for `hold_scans` scans, then stop; stop; the outputs'
            defaults; or end the run (fault 2).
        range_from: distances are from the robot's centre ("sensor"), less its radius ("hull"), or less `offset_m`.
        barrier, seek_goal, median, clamp, fuzzylab_compat: whether to keep off points and movers, to heed the goal at
            all, to remove single outliers, to bring distances into the universe, to behave as the paper's library.
        movers_in_rules: whether what moves is seen by the rules and the corridor too.
        n_top, n_foot, m_top, f_foot, f_top: break points of all inputs' sets, see `fuzzy.profiles.with_breaks`, in
            the system's units (mm); 0 keeps the profile's own.
        offset_m: for `range_from="offset"`. head_deg, side_deg: where the sectors ahead and at the sides end.
        corridor_margin_m: beside the footprint. look_m: how far the corridor reaches.
        blocked_m, free_m: distance of the first point in the corridor that makes g 0, and 1.
        k_heading: [1/s] of the turn to the goal, up to max_turn_rad_s. slow_m: where it begins to slow down.
        inertia_s: time constant of g, so that noise at the corridor's edge does not make the robot waver.
        patience_s: after which a goal that comes no nearer is approached by a via point.
        barrier_gain: [1/s]; barrier_margin_m: outside the footprint.
        horizon_s: how far ahead motions among movers are played out; evade_margin_m: what they keep from movers.
        cruise_m_s: on a free way; what the rules answer where everything is far when None.
        hold_scans, stale_scans: in scans. look_s: seconds of the corridor where another's wish is `guided`.
        arrive_m, arrive_rad: how near is there; pi asks for no heading.

    A number that is None is the profile's, or one of `DEFAULTS`.
    """

    profile: str = "repaired"
    mode: Literal["holonomic", "differential"] = "holonomic"
    motor: Motor = "own"
    no_rule: Literal["hold_then_stop", "stop", "default", "raise"] = "hold_then_stop"
    range_from: RangeFrom = "offset"
    barrier: bool = True
    seek_goal: bool = True
    median: bool = True
    clamp: bool = True
    fuzzylab_compat: bool = False
    n_top: float = 0.0
    n_foot: float = 0.0
    m_top: float = 0.0
    f_foot: float = 0.0
    f_top: float = 0.0
    offset_m: float | None = None
    head_deg: float | None = None
    side_deg: float | None = None
    corridor_margin_m: float | None = None
    look_m: float | None = None
    blocked_m: float | None = None
    free_m: float | None = None
    k_heading: float | None = None
    max_turn_rad_s: float | None = None
    slow_m: float | None = None
    barrier_gain: float | None = None
    barrier_margin_m: float | None = None
    horizon_s: float | None = None
    evade_margin_m: float | None = None
    patience_s: float | None = None
    inertia_s: float | None = None
    movers_in_rules: bool = False
    cruise_m_s: float | None = None
    hold_scans: float = 3.0
    stale_scans: float = 2.5
    look_s: float = 3.0
    arrive_m: float = 0.02
    arrive_rad: float = math.radians(2.0)

    command_kind: ClassVar[CommandKind] = "twist"
    kernel: ClassVar[Any] = staticmethod(fuzzy_avoidance_kernel)
    needs_lidar: ClassVar[bool] = True
    faults: ClassVar[dict[int, str]] = {
        avoidance.SCAN_IS_OLD: "the newest scan is too old to drive by",
        avoidance.NO_RULE_FIRED: "no fuzzy rule fires",
    }

    def __post_init__(self) -> None:
        checked(
            self,
            positive=(
                *("look_m", "slow_m", "free_m", "barrier_gain", "cruise_m_s", "stale_scans", "look_s", "horizon_s"),
                *("patience_s", "arrive_m", "arrive_rad", "head_deg", "side_deg"),
            ),
            not_negative=(
                *("n_top", "n_foot", "m_top", "f_foot", "f_top", "offset_m", "corridor_margin_m", "barrier_margin_m"),
                *("evade_margin_m", "inertia_s", "blocked_m", "k_heading", "max_turn_rad_s", "hold_scans"),
            ),
        )
        if self.number("free_m") <= self.number("blocked_m"):
            raise InputError(
                f"FuzzyAvoidance.free_m is {self.number('free_m'):g}; it must be above blocked_m, "
                f"{self.number('blocked_m'):g}"
            )

    def number(self, name: str) -> float:
        """One of the numbers, whoever says it."""
        own = getattr(self, name)
        return float(BY_PROFILE.get(self.profile, {}).get(name, DEFAULTS[name]) if own is None else own)

    @property
    def system(self) -> System:
        """The fuzzy system with its break points."""
        breaks = (self.n_top, self.n_foot, self.m_top, self.f_foot, self.f_top)
        return _system(self.profile, self.fuzzylab_compat, breaks if any(breaks) else None)

    def resolved(self) -> "FuzzyAvoidance":
        """The same with every number said that the profile or `DEFAULTS` say: where tuning starts.

        Break points are those of DR, which are all inputs' own once a profile is repaired.
        """
        breaks = (self.n_top, self.n_foot, self.m_top, self.f_foot, self.f_top)
        sets = self.system.inputs[2].sets
        if not any(breaks) and [one.kind for one in sets] == ["trapezoid", "triangle", "trapezoid"]:
            n, m, f = (one.params for one in sets)
            breaks = (n[2], n[3], m[1], f[0], f[1])
        names = ("n_top", "n_foot", "m_top", "f_foot", "f_top")
        said = dict(zip(names, breaks, strict=True)) | {name: self.number(name) for name in DEFAULTS}
        return replace(self, **said)  # type: ignore[arg-type]

    def memory_size(self, robot: Robot) -> int:
        """Poses of one scan time, its points, and scratch."""
        lidar = _lidar(robot)
        return avoidance.memory_size(lidar.beams, _history(robot, lidar), work_size(self.system.packed))

    def pack(self, robot: Robot) -> Array:
        """As the indices of `control.avoidance` say."""
        p = avoidance
        lidar, system, view = _lidar(robot), self.system, DifferentialView.of(robot, self.motor)
        far_mm = min(variable.high for variable in system.inputs)
        full = max(max(abs(variable.low), abs(variable.high)) for variable in system.outputs)
        radius, clamp = robot.footprint_radius_m, self.clamp and not self.fuzzylab_compat
        fastest = math.hypot(view.v_top_m_s, view.v_top_m_s)
        gain, margin = self.number("barrier_gain"), self.number("barrier_margin_m")
        head, side = self.number("head_deg"), self.number("side_deg")
        cruise = self.cruise_m_s or _cruise(system, full) * view.v_top_m_s
        packed = np.zeros(p.SPEC)
        for place, value in {
            p.HOLONOMIC: float(self.mode == "holonomic"),
            p.NO_RULE: ("hold_then_stop", "stop", "default", "raise").index(self.no_rule),
            p.BARRIER: float(self.barrier),
            p.SEEK: float(self.seek_goal),
            p.V_TOP: view.v_top_m_s,
            p.W_TOP: view.w_top_rad_s,
            p.CRUISE: cruise,
            p.OFFSET: {"sensor": 0.0, "hull": radius, "offset": self.number("offset_m")}[self.range_from],
            p.FAR: far_mm / 1000.0 if clamp else max(FAR_M, far_mm / 1000.0),
            p.K_HEADING: self.number("k_heading"),
            p.MAX_TURN: self.number("max_turn_rad_s"),
            p.SLOW: self.number("slow_m"),
            p.HALF_WIDTH: radius + self.number("corridor_margin_m"),
            p.LOOK: self.number("look_m"),
            p.BLOCKED: self.number("blocked_m"),
            p.FREE: self.number("free_m"),
            p.FOOTPRINT: radius,
            p.MARGIN: margin,
            p.GAIN: gain,
            # what the robot can come near to before the scan after next, and where the barrier begins
            p.NEAR: radius + margin + fastest / gain + 2.0 * fastest / lidar.rate_hz,
            p.STALE: self.stale_scans / lidar.rate_hz,
            p.HOLD_SCANS: self.hold_scans,
            p.ARRIVE_M: self.arrive_m,
            p.ARRIVE_RAD: self.arrive_rad,
            p.MEDIAN: float(self.median),
            p.HISTORY: _history(robot, lidar),
            p.BEAMS: lidar.beams,
            p.UNIT_IN: 1000.0,
            p.UNIT_OUT: 1.0 / full,
            p.CLAMP: float(clamp),
            p.DEFAULT_L: _default(system, 0) / full,
            p.DEFAULT_R: _default(system, 1) / full,
            p.LOOK_S: self.look_s,
            p.PATIENCE: self.number("patience_s"),
            p.INERTIA: max(self.number("inertia_s"), 1e-9),
            p.FASTEST: fastest,
            p.HORIZON: self.number("horizon_s"),
            p.EVADE_MARGIN: self.number("evade_margin_m"),
            p.EVADE_SPEED: EVADE_SPEED * cruise,
            p.MOVERS_IN_RULES: float(self.movers_in_rules),
        }.items():
            packed[place] = value
        x, y, theta = lidar.mount
        packed[p.SENSOR : p.SENSOR + 6] = (x, y, math.cos(theta), math.sin(theta), lidar.range_min, lidar.range_max)
        packed[p.EDGES : p.EDGES + 12] = Sectors(head, side, 360.0 - side, 360.0 - head).edges
        return np.concatenate([packed, system.packed])


def _lidar(robot: Robot) -> Lidar:
    if robot.lidar is None:
        raise InputError(
            f"robot {robot.name} has no lidar, and fuzzy avoidance cannot see without one; give it one: "
            '--set sensor.lidar.model=rplidar-a1, overrides={"sensor.lidar.model": "rplidar-a1"} or [sensor.lidar] '
            "in its file"
        )
    return robot.lidar


def _history(robot: Robot, lidar: Lidar) -> int:
    return math.ceil(1.0 / (lidar.rate_hz * robot.control_period_s)) + 3


def _default(system: System, output: int) -> float:
    value = system.outputs[output].default
    return value if math.isfinite(value) else 0.0


def _cruise(system: System, full: float) -> float:
    """Share of full speed that the rules answer where everything is far; half where they say nothing."""
    answer = system.evaluate([variable.high for variable in system.inputs])
    share = float(np.mean(answer)) / full
    return share if share > 0.0 else 0.5


@lru_cache(maxsize=64)
def _system(profile: str, compat: bool, breaks: tuple[float, ...] | None) -> System:
    system = _wired(fuzzy.load(profile, fuzzylab_compat=compat), profile)
    return system if breaks is None else profiles.with_breaks(system, *breaks)


def _wired(system: System, profile: str) -> System:
    """The system with its variables in the order of the wires, found by name; units other than mm are refused."""
    inputs, outputs = [one.name for one in system.inputs], [one.name for one in system.outputs]
    if sorted(inputs) != sorted(INPUT_NAMES) or sorted(outputs) != sorted(OUTPUT_NAMES):
        raise InputError(
            f"fuzzy system {profile!r} has the inputs {', '.join(inputs)} and the outputs {', '.join(outputs)}; "
            f"avoidance takes {', '.join(INPUT_NAMES)} [mm] and gives {', '.join(OUTPUT_NAMES)}"
        )
    for one in system.inputs:
        if one.unit not in ("", "mm"):
            raise InputError(f"input {one.name} of fuzzy system {profile!r} is in {one.unit}; avoidance measures in mm")
    if (inputs, outputs) == (list(INPUT_NAMES), list(OUTPUT_NAMES)):
        return system
    into = [inputs.index(name) for name in INPUT_NAMES]
    out = [outputs.index(name) for name in OUTPUT_NAMES]
    rules = tuple(
        replace(rule, inputs=tuple(rule.inputs[i] for i in into), outputs=tuple(rule.outputs[i] for i in out))
        for rule in system.rules
    )
    return replace(
        system,
        inputs=tuple(system.inputs[i] for i in into),
        outputs=tuple(system.outputs[i] for i in out),
        rules=rules,
    )


class LastTick(NamedTuple):
    """What the controller saw and thought at its last tick, for people.

    Attributes:
        inputs: DH, DL, DR in the system's units, as of the last scan.
        outputs: L, R of the rules; NaN where none fired.
        weight: of the goal; 1 is a free way.
        scans, silent_scans: how many scans came, and at how many of them no rule fired.
    """

    inputs: tuple[float, float, float]
    outputs: tuple[float, float]
    weight: float
    scans: int
    silent_scans: int


def last(controller: Any) -> LastTick:
    """The last tick of a `fuzzy` controller of the ordinary loop.

    Raises:
        InputError: another controller.
    """
    memory = getattr(controller, "memory", None)
    if memory is None or not isinstance(getattr(controller, "plug", None), FuzzyAvoidance):
        raise InputError(
            f"{controller!r} is no fuzzy avoidance controller; make one: control.controller('fuzzy', robot)"
        )
    p = avoidance
    return LastTick(
        tuple(memory[p.INPUTS : p.INPUTS + 3].tolist()),
        tuple(memory[p.OUTPUTS : p.OUTPUTS + 2].tolist()),
        float(memory[p.WEIGHT]),
        int(memory[p.SCANS]),
        int(memory[p.SILENT_TOTAL]),
    )


__all__ = ["BOUNDS", "BY_PROFILE", "DEFAULTS", "DifferentialView", "FuzzyAvoidance", "LastTick", "guided", "last"]
