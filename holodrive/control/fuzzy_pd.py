"""A fuzzy-PD on each of forward, sideways and turning, with the feed-forward and the limits of `pid`."""

import math
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from holodrive import layout
from holodrive.control.fuzzy import packing
from holodrive.control.fuzzy.kernel import evaluate_into
from holodrive.control.fuzzy.sets import Set
from holodrive.control.fuzzy.system import Rule, System, Variable
from holodrive.control.parameters import checked
from holodrive.control.pid import top_speeds
from holodrive.errors import InputError
from holodrive.interfaces import CommandKind
from holodrive.kinematics.kernel import wrap
from holodrive.leaf import leaf
from holodrive.robots.spec import Robot
from holodrive.types import Array

NAMES = ("NB", "NS", "Z", "PS", "PB")  # negative big, negative small, zero, positive small, positive big
# of the error e and its derivative de: what is done (P. J. Macvicar-Whelan, Fuzzy rules for man-machine interaction
# in industrial plants, Int. J. Man-Machine Studies 8, 1976): the sum of both, cut at the ends
TABLE = (
    ("NB", "NB", "NB", "NS", "Z"),  # e is NB, de from NB to PB
    ("NB", "NB", "NS", "Z", "PS"),
    ("NB", "NS", "Z", "PS", "PB"),
    ("NS", "Z", "PS", "PB", "PB"),
    ("Z", "PS", "PB", "PB", "PB"),
)
(_SPAN, _RATE, _GAIN) = (0, 2, 4)  # two each: position, heading
_FEED, _V_MAX, _W_MAX, _ARRIVE_M, _ARRIVE_RAD, _SPEC = range(6, 12)
_X, _OUT, _WORK = 0, 2, 3  # of the memory: scratch of the fuzzy system

# where to look for good values (`holodrive tune`)
BOUNDS: dict[str, tuple[float, float]] = {
    "span_m": (0.02, 1.0),
    "span_m_s": (0.3, 10.0),
    "gain_m_s": (0.05, 1.0),
    "span_rad": (0.05, 3.0),
    "span_rad_s": (1.0, 60.0),
    "gain_rad_s": (0.1, 5.0),
    "small_in": (0.1, 0.9),
    "small_out": (0.1, 0.9),
}


@leaf
def fuzzy_pd_kernel(obs, memory, params, command):  # type: ignore[no-untyped-def]
    """u = U f(e / E, de / D) + feed-forward on each axis of the body, f the fuzzy system.

    memory: scratch only.
    """
    theta = obs[layout.POSE + 2]
    c, s = math.cos(theta), math.sin(theta)
    wx, wy = obs[layout.REF_POSE] - obs[layout.POSE], obs[layout.REF_POSE + 1] - obs[layout.POSE + 1]
    ex, ey, et = c * wx + s * wy, c * wy - s * wx, wrap(obs[layout.REF_POSE + 2] - theta)
    fx, fy = obs[layout.REF_TWIST], obs[layout.REF_TWIST + 1]
    fx, fy, ft = c * fx + s * fy, c * fy - s * fx, obs[layout.REF_TWIST + 2]
    feed = params[_FEED]
    ux = _axis(params, memory, 0, ex, fx - obs[layout.TWIST]) + feed * fx
    uy = _axis(params, memory, 0, ey, fy - obs[layout.TWIST + 1]) + feed * fy
    ut = _axis(params, memory, 1, et, ft - obs[layout.TWIST + 2]) + feed * ft
    scale = min(1.0, params[_V_MAX] / max(math.hypot(ux, uy), 1e-12))
    command[0], command[1] = scale * ux, scale * uy
    command[2] = min(max(ut, -params[_W_MAX]), params[_W_MAX])
    near = math.hypot(ex, ey) <= params[_ARRIVE_M] and abs(et) <= params[_ARRIVE_RAD]
    command[layout.ARRIVED] = 1.0 if near and obs[layout.REF_LAST] != 0.0 else 0.0


@leaf
def _axis(params, memory, axis, error, rate):  # type: ignore[no-untyped-def]
    memory[_X], memory[_X + 1] = error / params[_SPAN + axis], rate / params[_RATE + axis]
    evaluate_into(params[_SPEC:], memory[_X:_OUT], 1.0, memory[_OUT:_WORK], memory[_WORK:])
    return params[_GAIN + axis] * memory[_OUT]


@dataclass(frozen=True)
class FuzzyPd:
    """Pose tracker with one fuzzy-PD per axis: the fuzzy counterpart of `pid` (25 rules, see `TABLE`).

    The controller of the first paper's Tables XI and XII is not published; this is the standard one. Its axes are
    those of the body, so that where the world has its x axis changes nothing. Near zero it is a PD with the gains
    (small_out / small_in) gain / span; it saturates at `gain`.

    Attributes:
        span_m, span_rad: error that is fully "big".
        span_m_s, span_rad_s: rate of the error that is fully "big".
        gain_m_s, gain_rad_s: command at "big".
        small_in: where "small" errors and rates are full, as a share of the spans.
        small_out: what is done at "small", as a share of the gains.
        feed_forward: share of the reference's own velocity that is added.
        max_speed_m_s, max_yaw_rate_rad_s: of the command; infinite takes what the slowest wheel's rim can do.
        arrive_m, arrive_rad: how near is there.
    """

    span_m: float = 0.2
    span_m_s: float = 3.0
    gain_m_s: float = 0.3
    span_rad: float = 1.0
    span_rad_s: float = 15.0
    gain_rad_s: float = 1.5
    small_in: float = 0.5
    small_out: float = 0.5
    feed_forward: float = 1.0
    max_speed_m_s: float = math.inf
    max_yaw_rate_rad_s: float = math.inf
    arrive_m: float = 0.02
    arrive_rad: float = math.radians(2.0)

    command_kind: ClassVar[CommandKind] = "twist"
    kernel: ClassVar[Any] = staticmethod(fuzzy_pd_kernel)

    def __post_init__(self) -> None:
        checked(self, positive=(*BOUNDS, "max_speed_m_s", "max_yaw_rate_rad_s", "arrive_m", "arrive_rad"))
        for name in ("small_in", "small_out"):
            if not getattr(self, name) < 1.0:
                raise InputError(f"FuzzyPd.{name} is {getattr(self, name):g}; it must be between 0 and 1")

    def system(self) -> System:
        """The fuzzy system f(e, de), both from -1 to 1 as shares of their spans; out as a share of the gain."""
        return system(self.small_in, self.small_out)

    def memory_size(self, robot: Robot) -> int:
        """Scratch of the fuzzy system."""
        return _WORK + packing.work_size(self.system().packed)

    def pack(self, robot: Robot) -> Array:
        """As the kernel's index constants say, the packed fuzzy system at the end."""
        speed, yaw_rate = top_speeds(robot)
        numbers = [
            self.span_m,
            self.span_rad,
            self.span_m_s,
            self.span_rad_s,
            self.gain_m_s,
            self.gain_rad_s,
            self.feed_forward,
            min(self.max_speed_m_s, speed),
            min(self.max_yaw_rate_rad_s, yaw_rate),
            self.arrive_m,
            self.arrive_rad,
        ]
        return np.concatenate([numbers, self.system().packed])


def system(small_in: float = 0.5, small_out: float = 0.5) -> System:
    """Five triangles for each of e and de that sum to 1 everywhere, five singletons, product and weighted average.

    So between the sets f is bilinear; with `small_in` = `small_out` it is e + de wherever no rule is cut at the ends.
    """
    s = small_in
    feet = ((-1.0, -1.0, -s), (-1.0, -s, 0.0), (-s, 0.0, s), (0.0, s, 1.0), (s, 1.0, 1.0))
    sets = tuple(Set(name, "triangle", params) for name, params in zip(NAMES, feet, strict=True))
    levels = (-1.0, -small_out, 0.0, small_out, 1.0)
    actions = tuple(Set(name, "constant", (level,)) for name, level in zip(NAMES, levels, strict=True))
    rules = tuple(
        Rule((i, j), (NAMES.index(action) + 1,)) for i, row in enumerate(TABLE, 1) for j, action in enumerate(row, 1)
    )
    return System(
        "fuzzy_pd",
        (Variable("e", -1.0, 1.0, sets), Variable("de", -1.0, 1.0, sets)),
        (Variable("u", -1.0, 1.0, actions),),
        rules,
        kind="sugeno",
        conjunction="prod",
        defuzzification="wtaver",
        source="P. J. Macvicar-Whelan, Int. J. Man-Machine Studies 8, 1976: rule table of a PD",
    )
