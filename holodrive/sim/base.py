"""A simulated robot for the ordinary loop: the kernels of the roll-out, one call each control period."""

import math
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from holodrive import layout
from holodrive.actuators.bldc import CURRENT_A
from holodrive.errors import InputError
from holodrive.obstacles import obstacle_names, obstacles_of
from holodrive.robots.spec import Robot
from holodrive.sim import model as md
from holodrive.sim import period as kernels
from holodrive.sim import state as st
from holodrive.sim.contact import STANDING
from holodrive.sim.streams import key_of
from holodrive.types import (
    Array,
    DutyCommand,
    Event,
    MotorState,
    Observation,
    Pose,
    Scan,
    Twist,
    WheelCommand,
    WheelState,
)
from holodrive.worlds.spec import World


class SimBase:
    """A described robot in a described world, as an `interfaces.Base`.

    Attributes:
        robot, world: as given.
        plant: "first_order", "slip", "pwm_map" or "motors".
        seed: of all noise.
        dt_s: physics step [s].
    """

    def __init__(
        self,
        robot: Robot,
        world: World | None = None,
        *,
        plant: str = "first_order",
        seed: int = 0,
        start: ArrayLike | None = None,
        dt_s: float = 1e-3,
    ) -> None:
        self._plant = kernels.plant_number(robot, plant)
        self.robot, self.world, self.plant, self.seed, self.dt_s = robot, world, plant, seed, dt_s
        self._model, self._obstacles = md.model_of(robot, dt_s), obstacles_of(world)
        self._names = obstacle_names(world)
        self._key = np.uint64(key_of(seed, 0))  # a plain int would reach the kernels as int64
        self._state, self._event_rows, self._ranges, self._pending = kernels.scratch(self._plant, self._model)
        self._n, self._m, self._mice = len(robot.wheels), len(robot.steered), len(robot.mice)
        self._angles = md.beam_angles(self._model)
        self._offsets = self._model[md.BEAM_PERIOD] * (np.arange(len(self._angles)) + 1.0 - len(self._angles))
        self._rad = self._model[[md.WHEELS + i * md.BLOCK + md.COUNT_RAD for i in range(self._n)]]
        self._scan: Scan | None = None
        self.reset(start)

    def reset(self, start: ArrayLike | None = None) -> None:
        """Back to time 0, at rest at `start` (x, y, theta), or where the world says when None."""
        pose = start_pose(start, self.world)
        kernels.start(
            self._model,
            self._obstacles,
            self._state,
            self._key,
            self._ranges,
            self._pending,
            pose.x,
            pose.y,
            pose.theta,
        )
        self._scan = None

    def observe(self) -> Observation:
        """What the sensors tell now."""
        state, n, m = self._state, self._n, self._m
        position = state[st.COUNT : st.COUNT + n] * self._rad
        wheels = WheelState(
            position, state[st.MEASURED : st.MEASURED + n].copy(), state[st.STEER : st.STEER + m].copy()
        )
        mice = state[st.MICE : st.MICE + 2 * self._mice].reshape(-1, 2).copy() if self._mice else None
        imu = self.robot.imu is not None
        fresh = bool(state[st.SCAN_IS_NEW])
        if fresh:
            self._scan = self._take_scan()
        return Observation(
            time=self.time,
            dt=self.robot.control_period_s,
            wheels=wheels,
            gyro=float(state[st.GYRO]) if imu else None,
            accel=state[st.ACCEL : st.ACCEL + 2].copy() if imu else None,
            mice=mice,
            scan=self._scan,
            scan_is_new=fresh,
        )

    def apply(self, command: WheelCommand | DutyCommand) -> WheelCommand | DutyCommand:
        """Hold the command for one control period; give what was really sent.

        A number that is not finite stops the robot for good: `fault` says so, and all later commands are zero.
        """
        n, m = self._n, self._m
        direct = isinstance(command, DutyCommand)
        values = np.ascontiguousarray(command.duty if isinstance(command, DutyCommand) else command.speeds, float)
        steer = np.ascontiguousarray(command.steer, float)
        if values.shape != (n,) or steer.shape != (m,):
            raise InputError(
                f"{self.robot.name} takes {n} wheel values and {m} steering angles; "
                f"found shapes {values.shape} and {steer.shape}"
            )
        state = self._state
        kernels.accept(self._model, state, self._event_rows, values, steer, direct)
        sent: Any = tuple(state[st.COMMAND : st.COMMAND + n].tolist())
        angles: Any = tuple(state[st.STEER_COMMAND : st.STEER_COMMAND + m].tolist())
        kernels.advance(
            self._plant,
            self._model,
            self._obstacles,
            state,
            self._event_rows,
            self._key,
            self._ranges,
            self._pending,
        )
        return DutyCommand(sent, angles) if direct else WheelCommand(sent, angles)

    def close(self) -> None:
        """Tell the wheels to stop; a simulated robot has nothing to let go of."""
        self._state[st.COMMAND : st.COMMAND + layout.MAX_WHEELS] = 0.0

    @property
    def time(self) -> float:
        """Seconds since start."""
        return float(self._state[st.TICK]) * self.robot.control_period_s

    @property
    def truth(self) -> Pose:
        """Where the robot really is, in the world."""
        return Pose(*self._state[st.POSE : st.POSE + 3].tolist())

    @property
    def true_twist(self) -> Twist:
        """How it really moves, `base_link` axes."""
        return Twist(*self._state[st.TWIST : st.TWIST + 3].tolist())

    @property
    def duty(self) -> Array:
        """(n,) motor duties of the last control period."""
        return np.array(self._state[st.DUTY : st.DUTY + self._n])

    @property
    def true_wheel_speeds(self) -> Array:
        """(n,) real wheel speeds [rad/s]."""
        return np.array(self._state[st.WHEEL_SPEED : st.WHEEL_SPEED + self._n])

    @property
    def motors(self) -> MotorState | None:
        """Currents, torques and powers (n + m) of drives and steerings, means of the last control period.

        None on the plants that do not simulate each motor; NaN for a steering servo.
        """
        if self._plant != kernels.MOTORS:
            return None
        rows = self._motor_rows()
        return MotorState(*(rows[:, st.MOTOR_CURRENT + i].copy() for i in range(4)))

    @property
    def motor_energy_j(self) -> Array | None:
        """(n + m, 3) of drives and steerings since start [J]: electrical, lost in copper, given to the load."""
        if self._plant != kernels.MOTORS:
            return None
        return self._motor_rows()[:, st.MOTOR_INPUT_J : st.MOTOR_INPUT_J + 3].copy()

    @property
    def phase_currents(self) -> Array | None:
        """(n + m, 3) into the phases of each motor now [A]; a brushed motor's current is the first."""
        if self._plant != kernels.MOTORS:
            return None
        return self._motor_rows()[:, CURRENT_A : CURRENT_A + 3].copy()

    def _motor_rows(self) -> Array:
        return self._state[st.MOTOR :].reshape(self._n + self._m, st.MOTOR_ROW)

    @property
    def energy_j(self) -> float:
        """Drawn from the battery since start [J]; NaN with the plants that know no currents."""
        return float(self._state[st.ENERGY]) if self._plant in (kernels.SLIP, kernels.MOTORS) else math.nan

    @property
    def fault(self) -> str:
        """Why the base has stopped for good; "" while all is well."""
        return "a command was not finite" if self._state[st.FAULT] else ""

    def take_events(self) -> list[Event]:
        """What happened since the last call."""
        count = int(self._state[st.N_EVENTS])
        events = [event_of(row, self._names) for row in self._event_rows[:count]]
        self._state[st.N_EVENTS] = 0.0
        return events

    def _take_scan(self) -> Scan:
        lidar = self.robot.lidar
        assert lidar is not None
        return Scan(
            stamp=float(self._state[st.SCAN_TIME]),
            angles=self._angles,
            ranges=self._ranges.copy(),
            offsets=self._offsets,
            mount=lidar.mount,
            range_min=lidar.range_min,
            range_max=lidar.range_max,
        )


def start_pose(start: ArrayLike | None, world: World | None) -> Pose:
    """The pose that was asked for, else the world's, else the origin.

    Raises:
        InputError: not three finite numbers.
    """
    if start is None:
        return world.start if world else Pose(0.0, 0.0, 0.0)
    array = np.asarray(start, dtype=np.float64)
    if array.shape != (3,) or not np.all(np.isfinite(array)):
        raise InputError(f"a start pose is (x, y, theta) in metres and radians; found {array.tolist()}")
    return Pose(*array.tolist())


def event_of(row: Array, names: tuple[str, ...]) -> Event:
    """A row of the event table as a value."""
    values = row.tolist()
    time, pose = values[st.EVENT_TIME], Pose(*values[st.EVENT_POSE : st.EVENT_POSE + 3])
    if values[st.EVENT_KIND] == st.COMMAND_FAULT:
        return Event(time, "fault", "a command was not finite; the wheels are stopped", pose)
    robot, mover = values[st.EVENT_ROBOT_SPEED], values[st.EVENT_MOVER_SPEED]
    obstacle = names[int(values[st.EVENT_OBSTACLE])]
    data = {
        "place": values[st.EVENT_PLACE : st.EVENT_PLACE + 2],
        "obstacle": obstacle,
        "robot_speed_m_s": robot,
        "mover_speed_m_s": mover,
        "moved": who_moved(robot, mover),
    }
    text = f"touched {obstacle} at ({data['place'][0]:.3f}, {data['place'][1]:.3f}) m, {data['moved']} moved"
    return Event(time, "collision", text, pose, data)


def who_moved(robot_m_s: float, mover_m_s: float) -> str:
    """ "robot", "obstacle", "both" or "neither" moved faster than a crawl when they met."""
    moved = (robot_m_s > STANDING, mover_m_s > STANDING)
    return {(True, False): "robot", (False, True): "obstacle", (True, True): "both", (False, False): "neither"}[moved]
