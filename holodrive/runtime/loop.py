"""The one loop: observe, estimate, reference, command, gate, apply, record.

The same loop drives a simulated and a real base; the controller cannot tell them apart.
"""

import math
from collections.abc import Callable
from typing import NamedTuple, Protocol

from holodrive.interfaces import Base, Controller, Estimator, ReferenceSource
from holodrive.kinematics.pipeline import CommandPipeline
from holodrive.log.run import Tick
from holodrive.runtime.gate import GateLimits, GateState, gate
from holodrive.types import Command, Decision, DutyCommand, Event, Observation, Pose, Scan, Twist, WheelCommand

FAULT_HOLD_S = 0.5  # how long a stopped robot is still recorded after a fault


class Sink(Protocol):
    """Whoever records: a log file, a run in memory, a view."""

    def tick(self, tick: Tick) -> None:
        """One control tick."""
        ...

    def scan(self, scan: Scan) -> None:
        """A new scan."""
        ...

    def event(self, event: Event) -> None:
        """Something that happened."""
        ...


class Ending(NamedTuple):
    """Why a run ended ("arrived", "duration", "fault", "interrupted") and when [s]."""

    why: str
    time: float


class Loop:
    """One base, one controller, one estimator, one reference: `step` is one control tick, `run` is all of them."""

    def __init__(
        self,
        base: Base,
        controller: Controller,
        estimator: Estimator,
        reference: ReferenceSource,
        sinks: tuple[Sink, ...] = (),
        *,
        calibration: bool = False,
    ) -> None:
        self.base, self.controller, self.estimator, self.reference = base, controller, estimator, reference
        self.sinks = sinks
        self.decision: Decision = Decision(Twist(0.0, 0.0, 0.0))
        self._pipeline = CommandPipeline(base.robot)
        self._limits = GateLimits.of(base.robot, calibration)
        self._gate = GateState()
        self._began: float | None = None
        self._arrived = False
        self._suspect = 0

    @property
    def fault(self) -> str:
        """What the gate has latched; "" while all is well."""
        return self._gate.fault

    def reset(self, pose: Pose) -> None:
        """Start anew from a known pose."""
        self.controller.reset()
        self.estimator.reset(pose)
        self.reference.reset()
        self._pipeline.reset()
        self._gate = GateState()
        self._began, self._arrived, self._suspect = None, False, 0
        self.decision = Decision(Twist(0.0, 0.0, 0.0))

    def step(self) -> Tick:
        """One control tick; what it saw and did goes to the sinks and is given back."""
        observation = self.base.observe()
        estimate = self.estimator.step(observation)
        reference = self.reference.step(self._since_start(observation), estimate.pose)
        was_silent = self.decision.no_rule
        self.decision = self.controller.step(reference, estimate, observation)
        verdict = gate(self._for_motors(self.decision.command, observation), self._gate, self._limits)
        truth, twist = getattr(self.base, "truth", None), getattr(self.base, "true_twist", None)
        if verdict.reason and not self._gate.fault:
            self._tell_fault(verdict.reason, observation.time, truth or estimate.pose)
        self._gate = verdict.state
        applied = self.base.apply(verdict.command)
        tick = Tick(
            time=observation.time,
            estimate=estimate,
            reference=reference,
            decided=self.decision.command,
            applied=applied if isinstance(applied, WheelCommand) else WheelCommand((math.nan,) * len(applied.duty)),
            wheels=observation.wheels,
            truth=truth,
            true_twist=twist,
            duty=getattr(self.base, "duty", None),
            gyro=observation.gyro,
            accel=observation.accel,
            mice=observation.mice,
            motors=getattr(self.base, "motors", None),
        )
        self._record(tick, observation)
        if self.decision.no_rule and not was_silent:
            text = "no fuzzy rule fires; the controller acts by its policy for that"
            self._emit(Event(tick.time, "no_rule", text, self._place(tick), {}))
        self._tell_suspects(estimate.suspect, tick)
        return tick

    def _tell_suspects(self, suspect: int, tick: Tick) -> None:
        """An event for each ground sensor that the estimator has ceased to trust, or trusts again."""
        changed, self._suspect = suspect ^ self._suspect, suspect
        for k, mouse in enumerate(self.base.robot.mice):
            if changed >> k & 1:
                lost = bool(suspect >> k & 1)
                what = (
                    "contradicts the others: lifted off, slipping or dead; it is left out" if lost else "agrees again"
                )
                data = {"sensor": mouse.name, "trusted": not lost}
                self._emit(Event(tick.time, "sensor", f"mouse {mouse.name} {what}", self._place(tick), data))

    @staticmethod
    def _place(tick: Tick) -> Pose:
        return tick.truth or tick.estimate.pose

    def _since_start(self, observation: Observation) -> float:
        """Time since the first tick [s]: a base's clock need not begin at 0, and modules may stand at any angle."""
        if self._began is None:
            self._began = observation.time
            steer = tuple(float(angle) for angle in observation.wheels.steer)
            if steer and all(math.isfinite(angle) for angle in steer):
                self._pipeline.reset(steer)
                self._gate = GateState("", steer)
        return observation.time - self._began

    def run(
        self,
        duration_s: float,
        *,
        stop_on_arrival: bool = True,
        pace: Callable[[float], None] | None = None,
        progress: Callable[[float], None] | None = None,
    ) -> Ending:
        """Tick until arrival, a fault, Ctrl-C or `duration_s`; the wheels are stopped at the end in every case.

        Args:
            duration_s: from the first tick, on the robot's clock.
            stop_on_arrival: end when the controller says that it is there.
            pace: called before each tick with its time since the first [s]; sleeps to keep to the wall clock.
            progress: called after each tick with its time since the first [s].
        """
        period, until, faulted, count = self.base.robot.control_period_s, duration_s, False, 0
        began = time = 0.0
        try:
            while True:
                if pace is not None:
                    pace(count * period)
                time = self.step().time
                began = time if count == 0 else began
                count += 1
                if progress is not None:
                    progress(time - began)
                if self.fault and not faulted:
                    faulted, until = True, min(until, time - began + FAULT_HOLD_S)
                if self._arrived and stop_on_arrival and not faulted:
                    return Ending("arrived", time)
                if time - began + 1.5 * period > until:
                    return Ending("fault" if faulted else "duration", time)
        except KeyboardInterrupt:
            self._emit(Event(time, "stop", "stopped by the user", self._pose(), {}))
            return Ending("interrupted", time)
        finally:
            self.base.close()

    def _for_motors(self, command: Command, observation: Observation) -> WheelCommand | DutyCommand:
        match command:
            case Twist():
                return self._pipeline.step(command, observation.dt)
            case WheelCommand():
                return self._pipeline.saturate(command)
            case _:
                return command

    def _record(self, tick: Tick, observation: Observation) -> None:
        for sink in self.sinks:
            sink.tick(tick)
            if observation.scan_is_new and observation.scan is not None:
                sink.scan(observation.scan)
        if self.decision.arrived and not self._arrived and not self.fault:
            self._arrived = True
            self._emit(Event(tick.time, "arrived", "arrived", self._place(tick), {}))
        if self.decision.fault:
            self._emit(Event(tick.time, "fault", self.decision.fault, self._place(tick), {}))
        take = getattr(self.base, "take_events", None)
        for event in take() if take is not None else ():
            self._emit(event)

    def _tell_fault(self, reason: str, time: float, pose: Pose) -> None:
        text = f"{reason}; the controller decided {self.decision.command}; all wheels are stopped"
        self._emit(Event(time, "gate", text, pose, {}))

    def _pose(self) -> Pose:
        return getattr(self.base, "truth", None) or Pose(math.nan, math.nan, math.nan)

    def _emit(self, event: Event) -> None:
        for sink in self.sinks:
            sink.event(event)
