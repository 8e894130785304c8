"""Tracker by model predictive control with the limits of the wheels, on the place that the lag will lead to.

    z = p + what has been commanded and is still to come            (`wheel_model`: delay, lag)
    z_(k+1) = z_k + dt (u_k + d)                                    d: disturbance, by the observer of `dob`
    min  sum |z_(k+1) - z_r(k+1)|^2_Q + |u_k - f_k|^2_R + |u_k - u_(k-1)|^2_S,   |J R(h_k)^T u_k| <= w_max

`control.mpc` has the problem. With a lag, z moves as the command says (see `pose_loop`), so the quadratic program
needs no state for the wheels; the reference is taken as far ahead, z_r = r(t + delay) + lag r'(t + delay), and
f = z_r'. Without the observer a disturbance would leave an error that lasts, as it does with any model that does not
know of it.
"""

import math
from dataclasses import dataclass
from functools import cached_property
from typing import ClassVar

import numpy as np

from holodrive import geometry, layout
from holodrive.control import wheel_model
from holodrive.control.disturbance_observer import AHEAD, DISTURBANCE, Dob, foresee, to_wheels, wanted
from holodrive.control.mpc import Horizon, Mpc, limit_rows
from holodrive.control.parameters import checked
from holodrive.errors import InputError
from holodrive.interfaces import CommandKind
from holodrive.observation_array import empty_observation, fill_observation
from holodrive.robots.spec import Robot
from holodrive.types import Array, Decision, Estimate, Observation, Reference, WheelCommand

# where to look for good values (`holodrive tune`)
BOUNDS: dict[str, tuple[float, float] | tuple[float, float, str]] = {
    "r_xy": (1e-4, 1.0, "log"),
    "r_theta": (1e-4, 1.0, "log"),
    "s_xy": (1e-5, 1.0, "log"),
    "s_theta": (1e-5, 1.0, "log"),
    "q_s": (0.02, 1.0, "log"),
    "q_theta_s": (0.02, 1.0, "log"),
}


def course(reference: Reference, times: Array, held_s: float) -> tuple[Array, Array]:
    """Where a moving reference will be, and its velocity, if it goes on along its present arc.

    A controller knows the present of its reference only. What speeds it up or slows it down is carried on for `held_s`.

    Args:
        reference: at present.
        times: (K,) from now [s].
        held_s: [s].

    Returns:
        Poses (K, 3) and their time derivatives (K, 3), world axes.
    """
    (x, y, theta), (vx, vy, omega), (ax, ay, alpha) = reference.pose, reference.twist, reference.accel
    speed, push = math.hypot(vx, vy), math.hypot(ax, ay)
    along, bend = push, 0.0
    cx, cy = (ax / push, ay / push) if push > 0.0 else (0.0, 0.0)
    if speed > 0.0:
        cx, cy = vx / speed, vy / speed
        along, bend = cx * ax + cy * ay, (cx * ay - cy * ax) / speed**2
    held = np.minimum(times, held_s)
    gained = held * times - 0.5 * held**2  # distance per acceleration
    way, pace = np.maximum(speed * times + along * gained, 0.0), np.maximum(speed + along * held, 0.0)
    turn = bend * way
    chord = way * np.sinc(turn / (2.0 * math.pi))
    px, py = _turned(chord * cx, chord * cy, 0.5 * turn)
    ux, uy = _turned(pace * cx, pace * cy, turn)
    poses = np.stack([x + px, y + py, theta + omega * times + alpha * gained], axis=-1)
    return poses, np.stack([ux, uy, omega + alpha * held], axis=-1)


@dataclass(frozen=True)
class LtvMpc:
    """Pose tracker by LTV-MPC; commands wheel speeds, drives in the ordinary loop only.

    Attributes:
        steps, dt_s: of the horizon.
        q_xy, q_theta, r_xy, r_theta, s_xy, s_theta: weights of pose error, twist beside the reference's and its change,
            see `Horizon`; far from all limits sqrt(q / r) is about the gain of the loop [1/s].
        accel_share: of the robot's acceleration limits that is planned with.
        max_iterations: of the solver, for one solution.
        q_s, q_theta_s, trust: of the disturbance observer, see `Dob`; a trust of 0 does without it.
        still_m_s, lag_s, delay_s: of the wheels, see `Dob`.
        max_speed_m_s, max_yaw_rate_rad_s: while the MPC has no answer; its own limits are those of the wheels.
        arrive_m, arrive_rad: how near is there.
        rest_m, rest_rad: how near the wheels are let alone at a reference that rests.
    """

    steps: int = 12
    dt_s: float = 0.05
    q_xy: float = 1.0
    q_theta: float = 0.25
    r_xy: float = 0.04
    r_theta: float = 0.01
    s_xy: float = 0.001
    s_theta: float = 0.00025
    accel_share: float = 1.0
    max_iterations: int = 500
    q_s: float = 0.08
    q_theta_s: float = 0.2
    trust: float = 0.5
    still_m_s: float = 0.001
    lag_s: float | None = None
    delay_s: float = 0.0
    max_speed_m_s: float = math.inf
    max_yaw_rate_rad_s: float = math.inf
    arrive_m: float = 0.02
    arrive_rad: float = math.radians(2.0)
    rest_m: float = 1e-4
    rest_rad: float = 1e-3

    command_kind: ClassVar[CommandKind] = "wheels"

    def __post_init__(self) -> None:
        checked(
            self,
            positive=("steps", "dt_s", "q_xy", "q_theta", "r_xy", "r_theta", "accel_share", "max_iterations"),
            not_negative=("s_xy", "s_theta"),
        )
        for name in ("steps", "max_iterations"):
            if getattr(self, name) != int(getattr(self, name)):
                raise InputError(f"LtvMpc.{name} is {getattr(self, name)}; it must be a whole number")
        self.inner  # noqa: B018  it checks what is its own

    @cached_property
    def inner(self) -> Dob:
        """The observer and the wheels' model inside; it drives while the MPC has no answer."""
        return Dob(
            kp=math.sqrt(self.q_xy / self.r_xy), kp_theta=math.sqrt(self.q_theta / self.r_theta),
            q_s=self.q_s, q_theta_s=self.q_theta_s, trust=self.trust, still_m_s=self.still_m_s, lag_s=self.lag_s,
            delay_s=self.delay_s, max_speed_m_s=self.max_speed_m_s, max_yaw_rate_rad_s=self.max_yaw_rate_rad_s,
            arrive_m=self.arrive_m, arrive_rad=self.arrive_rad, rest_m=self.rest_m, rest_rad=self.rest_rad,
        )  # fmt: skip

    def controller(self, robot: Robot) -> "LtvMpcController":
        """A controller for this robot, at its beginning."""
        return LtvMpcController(self, robot)


class LtvMpcController:
    """An `interfaces.Controller`.

    Attributes:
        solutions, fallbacks: how often the MPC was solved since the reset, and how often it had no answer.
    """

    command_kind: CommandKind = "wheels"

    def __init__(self, plug: LtvMpc, robot: Robot) -> None:
        self.plug = plug
        horizon = Horizon(
            int(plug.steps), plug.dt_s, plug.q_xy, plug.q_theta, plug.r_xy, plug.r_theta, plug.s_xy, plug.s_theta,
            0, robot.control_period_s, plug.accel_share,
        )  # fmt: skip
        self._mpc = Mpc(robot, horizon, int(plug.max_iterations))
        self._times: Array = plug.dt_s * np.arange(float(horizon.steps))
        self._lag = wheel_model.lag_of(robot) if plug.lag_s is None else plug.lag_s
        self._limits = limit_rows(robot)
        self._params = plug.inner.pack(robot)
        self._memory = np.zeros(plug.inner.memory_size(robot))
        self._observation = empty_observation(robot.lidar.beams if robot.lidar else 0)
        self._command = np.zeros(layout.COMMAND_SIZE)
        self._no_planes = np.zeros((horizon.steps, 0, 3))
        self._wheels, self._steered = len(robot.wheels), len(robot.steered)
        self.reset()

    def reset(self) -> None:
        """Forget everything."""
        self._mpc.reset()
        self._memory[:] = 0.0
        self._last = np.zeros(3)  # twist commanded last, world axes
        self._turns = np.zeros(len(self._times))  # headings of the plan before, from its beginning
        self._told = False
        self.solutions = self.fallbacks = 0

    def step(self, reference: Reference, estimate: Estimate, observation: Observation) -> Decision:
        """One tick."""
        obs, memory, params, command = self._observation, self._memory, self._params, self._command
        fill_observation(obs, observation, estimate, reference)
        command[:] = 0.0
        foresee(obs, memory, params)
        rests = wanted(obs, memory, params, command)
        arrived, fault = command[layout.ARRIVED] != 0.0, ""
        if not rests and np.all(np.isfinite(command[:3])):
            fault = self._solve(reference, np.array(estimate.pose), observation.dt)
        self._last = _rotation(estimate.pose.theta) @ command[:3]
        to_wheels(obs, memory, params, command)
        out = command.tolist()
        steer = tuple(out[layout.COMMAND_STEER : layout.COMMAND_STEER + self._steered])
        return Decision(WheelCommand(tuple(out[: self._wheels]), steer), arrived, fault)

    def _solve(self, reference: Reference, pose: Array, dt: float) -> str:
        """The plan's first move into the command; without a plan, what to tell people, once."""
        ahead, disturbance = self._memory[AHEAD : AHEAD + 3], self._memory[DISTURBANCE : DISTURBANCE + 3]
        half = _rotation(pose[2] + 0.5 * ahead[2])
        here = pose + half @ ahead
        turn, step = _rotation(here[2]), self.plug.dt_s
        # a move is replaced after one tick, so its wanted twist is that of its first tick, not of the whole step
        times = np.concatenate([self._times, self._times + dt])
        poses, velocities = course(reference, times + self.plug.delay_s, self.plug.delay_s + step)
        before, after = np.split((poses + self._lag * velocities - here) @ turn, 2)
        moves = (after - before) / dt
        error = before[0] + np.array([0.0, 0.0, geometry.wrap(before[0, 2]) - before[0, 2]])
        places = self._in_reach(error + step * np.cumsum(moves, axis=0))
        drift = np.stack([_rotation(angle) @ disturbance for angle in self._turns])
        plan = self._mpc.plan(
            places - step * np.cumsum(drift, axis=0),
            moves - drift,
            turn.T @ self._last,
            self._turns,
            self._no_planes,
        )
        self.solutions += 1
        if plan.solved:
            self._turns[1:] = step * np.cumsum(plan.twists[:-1, 2] + drift[:-1, 2])
            self._command[:3] = plan.twists[0]
            return ""
        self.fallbacks += 1
        self._turns[:] = 0.0
        first, self._told = not self._told, True
        return f"MPC: {plan.why}; the pose loop drives until there is a plan again" if first else ""

    def _in_reach(self, places: Array) -> Array:
        """`places` (N, 3) from where the base is now, none farther than it can be by then.

        What is out of reach is pulled in along its straight line: the program alone would go the way in which the
        wheels make most of the distance, not the straight one.
        """
        loads = np.abs(places @ self._limits.T).max(axis=1) / (self._times + self.plug.dt_s)
        return np.asarray(places / np.maximum(loads, 1.0)[:, None])


def _turned(x: Array, y: Array, angle: Array) -> tuple[Array, Array]:
    c, s = np.cos(angle), np.sin(angle)
    return c * x - s * y, s * x + c * y


def _rotation(theta: float) -> Array:
    """From axes of the base to those of the world, turning kept."""
    c, s = math.cos(theta), math.sin(theta)
    return np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])


__all__ = ["BOUNDS", "LtvMpc", "LtvMpcController", "course"]
