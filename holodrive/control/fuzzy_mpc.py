"""Fuzzy avoidance with model predictive control (future work of the first paper).

The fuzzy avoidance says where to go for the next two seconds: with the moving reference while the way is free, along
its own reaction where it is not. The MPC makes of that the best motion that the wheels can do and that keeps out of
all that the lidar has seen. Where it finds none, the fuzzy avoidance drives itself. The barrier has the last word.
"""

import math
from dataclasses import dataclass
from typing import ClassVar, Literal

import numpy as np

from holodrive import geometry, layout
from holodrive.control import avoidance
from holodrive.control.avoidance import give_way, guided, hold_back
from holodrive.control.fuzzy_avoidance import FuzzyAvoidance
from holodrive.control.go_to_pose import GoToPose, go_to_pose_kernel
from holodrive.control.half_planes import half_planes
from holodrive.control.mpc import Horizon, Mpc
from holodrive.control.parameters import checked
from holodrive.control.pid import top_speeds
from holodrive.errors import InputError
from holodrive.interfaces import CommandKind
from holodrive.leaf import leaf
from holodrive.observation_array import empty_observation, fill_observation
from holodrive.perception.scan_points import ROW
from holodrive.robots.spec import Robot
from holodrive.types import Array, Decision, Estimate, Observation, Reference, Twist

_LOOK_M = 1.0  # obstacles farther than this from the hull give no half-plane: the horizon does not reach them


def extrapolated(reference: Reference, times: Array) -> Array:
    """Poses (K, 3) of a moving reference at `times` (K,) [s] from now: on at its speed along its present arc.

    A controller knows the present of its reference only; speed along the path and curvature stay what they are.
    """
    (x, y, theta), (vx, vy, omega), (ax, ay, _) = reference.pose, reference.twist, reference.accel
    square = vx * vx + vy * vy
    turn = times * ((vx * ay - vy * ax) / square if square > 0.0 else 0.0)
    along = times * np.sinc(turn / (2.0 * math.pi))  # chord of the arc, which points half the turn ahead
    c, s = along * np.cos(0.5 * turn), along * np.sin(0.5 * turn)
    return np.stack([x + c * vx - s * vy, y + s * vx + c * vy, theta + omega * times], axis=-1)


@leaf
def room_about(memory, params, places, pose, radius, out):  # type: ignore[no-untyped-def]
    """Half-planes (N, k, 3) about places (N, 3) from the points that the fuzzy avoidance keeps; see `half_planes`."""
    beams = int(params[avoidance.BEAMS])
    at = avoidance.VARIABLE + ROW * int(params[avoidance.HISTORY])
    xs, ys = memory[at : at + beams], memory[at + beams : at + 2 * beams]
    scratch = memory[memory.shape[0] - 3 * beams :]  # its memory ends with what it expects nothing back of
    reach = radius + _LOOK_M
    half_planes(xs, ys, int(memory[avoidance.POINTS]), places, pose[0], pose[1], radius, reach, scratch, out)


@leaf
def last_word(obs, memory, params, command):  # type: ignore[no-untyped-def]
    """What the fuzzy avoidance does last of all, on a twist that comes from elsewhere: give way, hold back."""
    if not math.isfinite(command[0] + command[1] + command[2]):
        return
    beams = int(params[avoidance.BEAMS])
    at = avoidance.VARIABLE + ROW * int(params[avoidance.HISTORY])
    xs, ys = memory[at : at + beams], memory[at + beams : at + 2 * beams]
    near, scratch = memory[at + 3 * beams : at + 7 * beams], memory[memory.shape[0] - 3 * beams :]
    x, y, theta = obs[layout.POSE], obs[layout.POSE + 1], obs[layout.POSE + 2]
    c, s = math.cos(theta), math.sin(theta)
    give_way(obs, memory, params, xs, ys, int(memory[avoidance.POINTS]), x, y, c, s, command)
    hold_back(obs, memory, params, near, x, y, c, s, scratch, command)


@dataclass(frozen=True)
class FuzzyMpc:
    """Pose tracker that keeps off obstacles: fuzzy avoidance whose wish a model predictive controller carries out.

    Attributes:
        steps, dt_s: of the horizon.
        period_s: how often the MPC is solved; in between its first move is held, in world axes.
        q_xy, q_theta, r_xy, r_theta, s_xy, s_theta: weights of pose error, twist and its change, see `Horizon`.
        accel_share: of the robot's acceleration limits that is planned with; gentle starts slip less, which odometry
            needs more than the tracker needs haste.
        planes: how many half-planes each step of the horizon has for obstacles.
        margin_m: that the MPC keeps to all that the lidar has seen, beside the footprint.
        max_iterations: of the solver, for one solution.
        k_xy, k_theta: of the wish that the fuzzy avoidance is asked to blend [1/s].
        profile, no_rule, barrier: of the fuzzy avoidance, see `FuzzyAvoidance`.
        max_speed_m_s, max_yaw_rate_rad_s: of the command; infinite leaves it to the wheels' limits.
        arrive_m, arrive_rad: how near is there.
    """

    steps: int = 20
    dt_s: float = 0.1
    period_s: float = 0.05
    q_xy: float = 1.0
    q_theta: float = 0.25
    r_xy: float = 0.02
    r_theta: float = 0.005
    s_xy: float = 0.2
    s_theta: float = 0.02
    accel_share: float = 0.8
    planes: int = 3
    margin_m: float = 0.03
    max_iterations: int = 500
    k_xy: float = 1.5
    k_theta: float = 1.0
    profile: str = "repaired"
    no_rule: Literal["hold_then_stop", "stop", "default", "raise"] = "hold_then_stop"
    barrier: bool = True
    max_speed_m_s: float = math.inf
    max_yaw_rate_rad_s: float = math.inf
    arrive_m: float = 0.02
    arrive_rad: float = math.radians(2.0)

    command_kind: ClassVar[CommandKind] = "twist"
    needs_lidar: ClassVar[bool] = True

    def __post_init__(self) -> None:
        weights = ("r_xy", "r_theta", "s_xy", "s_theta", "planes", "margin_m")
        checked(self, positive=("steps", "dt_s", "q_xy", "q_theta", "max_iterations"), not_negative=weights)
        for name in ("steps", "planes", "max_iterations"):
            if getattr(self, name) != int(getattr(self, name)):
                raise InputError(f"FuzzyMpc.{name} is {getattr(self, name)}; it must be a whole number")

    @property
    def fuzzy(self) -> FuzzyAvoidance:
        """The fuzzy avoidance inside; its barrier waits for the MPC's answer."""
        return FuzzyAvoidance(profile=self.profile, no_rule=self.no_rule, barrier=False)

    def controller(self, robot: Robot) -> "FuzzyMpcController":
        """A controller for this robot, at its beginning."""
        return FuzzyMpcController(self, robot)


class FuzzyMpcController:
    """An `interfaces.Controller`.

    Attributes:
        solutions, fallbacks: how often the MPC was solved since the reset, and how often it had no answer.
    """

    command_kind: CommandKind = "twist"

    def __init__(self, plug: FuzzyMpc, robot: Robot) -> None:
        self.plug = plug
        horizon = Horizon(
            int(plug.steps), plug.dt_s, plug.q_xy, plug.q_theta, plug.r_xy, plug.r_theta, plug.s_xy, plug.s_theta,
            int(plug.planes), plug.period_s, plug.accel_share,
        )  # fmt: skip
        wish = GoToPose(
            plug.k_xy, plug.k_theta, "world", 1.0, plug.max_speed_m_s, plug.max_yaw_rate_rad_s, plug.arrive_m,
            plug.arrive_rad,
        )  # fmt: skip
        self._mpc = Mpc(robot, horizon, int(plug.max_iterations))
        self._times: Array = plug.dt_s * np.arange(horizon.steps + 1.0)
        self._wish, self._fastest = wish.pack(robot), min(plug.max_speed_m_s, top_speeds(robot)[0])
        self._reach = robot.footprint_radius_m + plug.margin_m
        self._fuzzy = plug.fuzzy.pack(robot)
        self._memory = np.zeros(plug.fuzzy.memory_size(robot))
        self._observation = empty_observation(robot.lidar.beams if robot.lidar else 0)
        self._command = np.zeros(layout.COMMAND_SIZE)
        self._nothing = np.zeros(0)  # memory of the wish's law
        self._room = np.zeros((horizon.steps, horizon.planes, 3))
        self.reset()

    def reset(self) -> None:
        """Forget everything."""
        self._mpc.reset()
        self._memory[:] = 0.0
        self._last = np.zeros(3)  # twist commanded last, world axes
        self._plan: _Kept | None = None
        self._due, self._told = -math.inf, False
        self.solutions = self.fallbacks = 0

    def step(self, reference: Reference, estimate: Estimate, observation: Observation) -> Decision:
        """One tick."""
        obs, command, pose = self._observation, self._command, np.array(estimate.pose)
        fill_observation(obs, observation, estimate, reference)
        command[:] = 0.0
        go_to_pose_kernel(obs, self._nothing, self._wish, command)
        arrived, wish = command[layout.ARRIVED] != 0.0, command[:3].copy()
        guided(obs, self._memory, self._fuzzy, wish, command)
        number = int(command[layout.FAULT])
        fault = FuzzyAvoidance.faults.get(number, "")
        turn = _rotation(pose[2])
        if not self._sees() or not math.isfinite(command[0]):
            self._plan = None  # it stands, or hands the NaN on to the gate
        elif observation.time >= self._due - 1e-9:
            self._due = observation.time + self.plug.period_s
            fault = fault or self._solve(reference, pose, command[:3].copy(), observation.time)
        if self._plan is not None:
            command[:3] = self._plan.first @ turn
        if self.plug.barrier:
            last_word(obs, self._memory, self._fuzzy, command)
        self._last = turn @ command[:3]
        return Decision(Twist(*command[:3].tolist()), arrived, fault, bool(command[layout.NO_RULE]))

    def _sees(self) -> bool:
        """Whether the fuzzy avoidance has a scan to drive by."""
        return bool(self._memory[avoidance.SCANS] > 0.0 and self._memory[avoidance.FAULT] == 0.0)

    def _solve(self, reference: Reference, pose: Array, reaction: Array, time: float) -> str:
        """A new plan; without one, what to tell people, once."""
        path = self._path(reference, pose, reaction)
        headings, places = np.zeros(len(path) - 1), path[1:]
        if self._plan is not None:
            expected = self._plan.at(time + self._times)
            headings = expected[:-1, 2] - pose[2]
            headings[0] = 0.0
            places = expected[1:]
        turn = _rotation(pose[2])
        room_about(self._memory, self._fuzzy, np.ascontiguousarray(places), pose, self._reach, self._room)
        self._room[:, :, :2] = self._room[:, :, :2] @ turn[:2, :2]
        wanted = (path - pose) @ turn
        plan = self._mpc.plan(
            wanted[1:], np.diff(wanted, axis=0) / self.plug.dt_s, turn.T @ self._last, headings, self._room
        )
        self.solutions += 1
        if plan.solved:
            twists = plan.twists @ turn.T
            steps = np.concatenate([np.zeros((1, 3)), self._mpc.problem.poses(twists)])
            self._plan = _Kept(twists[0], time + self._times, pose + steps)
            return ""
        self.fallbacks += 1
        self._plan, first, self._told = None, not self._told, True
        return f"MPC: {plan.why}; the fuzzy avoidance drives until there is a plan again" if first else ""

    def _path(self, reference: Reference, pose: Array, reaction: Array) -> Array:
        """Poses (N + 1, 3) that are wanted now and at the end of each step, world frame, headings near the present.

        The moving reference, no farther than the base can get; as far as the way is not free (the fuzzy avoidance's
        own measure), where the twist leads that its rules and the wish were blended to.
        """
        path = extrapolated(reference, self._times) - pose
        path[:, 2] += geometry.wrap(path[0, 2]) - path[0, 2]
        far = np.hypot(path[:, 0], path[:, 1])
        path[:, :2] *= np.minimum(1.0, self._fastest * self._times / np.maximum(far, 1e-12))[:, None]
        free = self._memory[avoidance.WEIGHT]
        own = geometry.exp(self._times[:, None] * reaction)
        own[:, :2] = own[:, :2] @ _rotation(pose[2])[:2, :2].T
        own[:, 2] = self._times * reaction[2]
        return np.asarray(pose + free * path + (1.0 - free) * own)


@dataclass(frozen=True)
class _Kept:
    """A plan between solutions: its first move (3,), and poses (N + 1, 3) at times (N + 1,), world frame."""

    first: Array
    times: Array
    poses: Array

    def at(self, times: Array) -> Array:
        """Poses (K, 3) where the base is expected; the last one after the end."""
        return np.stack([np.interp(times, self.times, self.poses[:, i]) for i in range(3)], axis=-1)


def _rotation(theta: float) -> Array:
    """From axes of the base to those of the world, turning kept."""
    c, s = math.cos(theta), math.sin(theta)
    return np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
