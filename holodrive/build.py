"""Composition root: names become objects. The only module that knows every kind.

These are the verbs of the package (`hd.load`, `hd.simulate`, `hd.drive` ...); the command line calls them too.
"""

import hashlib
import json
import math
from collections.abc import Callable, Sequence
from dataclasses import replace
from inspect import signature
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from holodrive import __version__, control, estimation, planning, references, robots, worlds
from holodrive import log as logs
from holodrive.errors import HardwareFault, InputError, LogError, with_known
from holodrive.interfaces import Base, Controller, ControllerPlug, Estimator, Plug
from holodrive.log.run import Run
from holodrive.robots.spec import Robot
from holodrive.runtime import Loop, RealTime, Sink
from holodrive.types import Pose
from holodrive.worlds.spec import World

if TYPE_CHECKING:
    from holodrive.calibration.mice import MiceCalibration
    from holodrive.calibration.mouse_moves import Driven, Move, Stand
    from holodrive.calibration.mouse_runs import Accuracy, MouseRun
    from holodrive.calibration.steps import Calibration
    from holodrive.control.custom import Law
    from holodrive.estimation import Evaluation
    from holodrive.sim import Rollout, SimBase

Plant = Literal["first_order", "slip", "pwm_map", "motors"]
DEFAULT_DURATION_S = 60.0
AFTER_TRAJECTORY_S = 2.0  # for the robot to settle at the end


def load(name_or_path: str | Path | Robot, overrides: dict[str, Any] | None = None) -> Robot:
    """A robot by catalog name or file; `overrides` like {"wheel.front.radius": "50 mm"} come on top.

    Raises:
        UnknownName: no such robot in the catalog.
        FileFaults: the file has faults, all of them at once.
    """
    return name_or_path if isinstance(name_or_path, Robot) else robots.load(name_or_path, overrides)


def world(name_or_path: str | Path | World | None) -> World:
    """A world by catalog name or file; None is the open floor.

    Raises:
        UnknownName, FileFaults: as `load`.
    """
    return _world(name_or_path)


def simulate(
    robot: str | Path | Robot,
    world: str | Path | World | None = None,
    *,
    plant: Plant = "first_order",
    seed: int = 0,
    start: ArrayLike | None = None,
    dt_s: float = 1e-3,
) -> "SimBase":
    """A simulated base to drive.

    Args:
        robot, world: by name, file or value; no world is the open floor.
        plant: "first_order" (wheels follow with a lag, no slip), "slip" (motors, grip, battery), "pwm_map" (the
            measured actuators of the robot's [pwm_map], no slip) or "motors" (drives and steerings with their own
            electromechanics, commutation included, no slip).
        seed: of all noise.
        start: pose (x, y, theta) in the world; the world's own when None.
        dt_s: physics step.
    """
    from holodrive.sim import SimBase

    base = SimBase(load(robot), _world(world), plant=plant, seed=seed, start=start, dt_s=dt_s)
    _check_room(base)
    return base


def _check_room(base: "SimBase") -> None:
    from holodrive.obstacles import clearance

    place, pose, radius = base.world, base.truth, base.robot.footprint_radius_m
    if place is None:
        return
    where = (
        f"{base.robot.name} (footprint radius {radius:g} m) cannot start at ({pose.x:g}, {pose.y:g}) m in {place.name}"
    )
    gap = float(clearance(place, [base.time], [pose], radius)[0])
    if gap < 0.0:
        raise InputError(f"{where}: it would stand {-gap:.3g} m inside an obstacle or wall; give another start")
    if place.size is not None and place.walls:
        inside = all(low <= at <= low + side for at, low, side in zip(pose, place.corner, place.size, strict=False))
        if not inside:
            raise InputError(f"{where}: that is outside its walls; give another start")


def drive(
    base: Base,
    controller: "str | Controller | ControllerPlug | Law" = "go_to_pose",
    *,
    goal: ArrayLike | None = None,
    waypoints: ArrayLike | None = None,
    trajectory: references.Table | None = None,
    estimator: str | Estimator = "auto",
    params: dict[str, Any] | None = None,
    duration_s: float | None = None,
    log: str | Path | None = None,
    stop_on_arrival: bool = True,
    real_time: bool = False,
    keep_s: float | None = None,
    progress: Callable[[float], None] | None = None,
) -> Run:
    """Drive a base until arrival, a fault, Ctrl-C or `duration_s`, and give the whole run.

    Args:
        base: from `simulate`, or a real one.
        controller: a name of `control.names()`, a function `f(reference, estimate, observation) -> Twist`,
            a plug with a kernel, or an object with `step` and `reset`.
        goal: (x, y) keeps the heading, (x, y, theta) turns; the world's goal when nothing is said.
        waypoints: (K, 2 or 3) to pass, the last to stop at.
        trajectory: a table from `planning` or `references`.
        estimator: a name of `estimation.names()` or an object with `step` and `reset`; "auto" takes wheel odometry,
            or the mice of a robot without encoders.
        params: of the controller, over its defaults.
        duration_s: on the robot's clock; 60 s, or a trajectory's length and 2 s, when None.
        log: MCAP file to write.
        stop_on_arrival: end when the controller says it is there (default); a trajectory runs to its end either way.
        real_time: keep to the wall clock.
        keep_s: how much of the end of the run stays in memory [s], all when None; metrics and log have all of it.
        progress: called with the time of each tick [s].

    Raises:
        InputError: names, goals or parameters that cannot be.
    """
    robot, place = base.robot, getattr(base, "world", None)
    start = Pose(*getattr(base, "truth", Pose(0.0, 0.0, 0.0)))
    table = _reference(place, start, goal, waypoints, trajectory)
    length = _length(duration_s, table)
    asked_for_nothing = goal is None and waypoints is None and trajectory is None
    if isinstance(controller, str):
        params = control.with_arrival(controller, params, place if asked_for_nothing else None)
    if estimator == "auto":
        estimator = estimation.default_name(robot)
    settings = _settings(base, controller, estimator, params, table, start, length, stop_on_arrival)
    driver = control.controller(controller, robot, params)
    believer = estimation.estimator(estimator, robot) if isinstance(estimator, str) else estimator
    keep_ticks = None if keep_s is None else max(1, round(keep_s / robot.control_period_s))
    builder = logs.RunBuilder(robot, place, settings, keep_ticks=keep_ticks)
    recorder = logs.Recorder(log, robot, place, settings) if log is not None else None
    try:
        sinks: tuple[Sink, ...] = (builder, recorder) if recorder else (builder,)
        loop = Loop(base, driver, believer, references.ReferenceFollower(table), sinks)
        loop.reset(start)
        loop.run(length, stop_on_arrival=stop_on_arrival, pace=RealTime() if real_time else None, progress=progress)
        run = builder.build()
        values = builder.metrics(getattr(base, "energy_j", math.nan))
        if recorder:
            recorder.close(values)
        damage = f"the log is not whole: {recorder.fault}" if recorder and recorder.fault else ""
        return replace(run, metrics=values, damage=damage, path=Path(log) if log else None)
    finally:
        if recorder:
            recorder.close()
        base.close()


def plan(
    robot: str | Path | Robot,
    world: str | Path | World,
    planner: str = "visibility",
    *,
    start: ArrayLike | None = None,
    goal: ArrayLike | None = None,
    margin_m: float = 0.05,
    seed: int = 0,
    **options: Any,
) -> planning.Plan:
    """A way past what stands in a world; `plan(...).reference(robot)` is the trajectory that follows it.

    Args:
        robot, world: by name, file or value.
        planner: a name of `planning.PLANNERS`.
        start, goal: (x, y) or (x, y, heading); the world's own when None.
        margin_m: kept free around the robot, for what its tracker strays.
        seed: of planners that search at random.
        options: of the planner.

    Raises:
        UnknownName: no such planner, robot or world.
        InputError: no goal, no way, or an option that the planner does not have.
    """
    search = planning.planner(planner)
    known = set(signature(search).parameters) - {"world", "footprint_m", "start", "goal", "margin_m", "seed"}
    for name in options:
        if name not in known:
            raise InputError(f"planner {planner} has no option {name!r}{with_known(name, sorted(known))}")
    if "seed" in signature(search).parameters:
        options["seed"] = seed
    footprint = load(robot).footprint_radius_m
    return search(_world(world), footprint, start=start, goal=goal, margin_m=margin_m, **options)


def rollout(
    robot: str | Path | Robot,
    world: str | Path | World | Sequence[World] | None = None,
    controller: str | ControllerPlug = "go_to_pose",
    *,
    estimator: "str | Plug | None" = "auto",
    n: int | None = None,
    params: Any = None,
    **options: Any,
) -> "Rollout":
    """Many runs at once, compiled; the options are those of `holodrive.sim.rollout`.

    Args:
        robot, world: by name, file or value; a list of n worlds gives each run its own.
        controller: a name of `control.names()`, or any plug with a kernel.
        estimator: a name of `estimation.names()`, "auto" (as `drive`), or any plug with a kernel; None lets the
            controller know the truth.
        n: how many robots; as many as there are references or worlds in a list, else 1, when None.
        params: a dict over the controller's defaults; or packed, (p,) or (n, p).
    """
    from holodrive import sim

    described = load(robot)
    place = [_world(one) for one in world] if isinstance(world, list | tuple) else _world(world)  # type: ignore[arg-type]
    if n is None and isinstance(place, list):
        n = len(place)
    packed = None if isinstance(params, dict) else params
    if isinstance(controller, str):
        given = params if isinstance(params, dict) else None
        worlds_goals = "reference" not in options and "goals" not in options
        places = place if isinstance(place, list) else [place]
        plugs = [
            control.compiled(controller, control.with_arrival(controller, given, one if worlds_goals else None))
            for one in places
        ]
        controller = plugs[0]
        if packed is None and len(plugs) > 1:
            packed = np.array([plug.pack(described) for plug in plugs])
    if estimator == "auto":
        estimator = estimation.default_name(described)
    believer = estimation.plug(estimator) if isinstance(estimator, str) else estimator
    return sim.rollout(described, place, controller, estimator=believer, n=n, params=packed, **options)


def calibrate_steps(
    base: Base,
    *,
    counts: int | None = None,
    levels: int = 20,
    step_s: float = 1.5,
    stray_m: float = 0.5,
    estimator: str | Estimator = "auto",
    progress: Callable[[float], None] | None = None,
) -> "Calibration":
    """Step a base's motors open-loop, group by group, and find its linearizer; it stays about where it is.

    Args:
        base: from `simulate`, or a real one; it needs a free circle of `stray_m` around it.
        counts: PWM counts of full duty; those of the robot's [pwm_map], or 255, when None.
        levels: PWM values to see moving in each direction.
        step_s: how long each is held [s].
        stray_m: how far the robot may get from its place [m].
        estimator: how a diagonal of a Mecanum base is measured; "auto" takes the mice, or the encoders without.
        progress: called with the time of each tick [s].

    Raises:
        InputError: a base that cannot measure how its wheels move, or numbers that cannot be.
        HardwareFault: it strayed, did not come to rest, or did not move; its wheels have been stopped.
    """
    from holodrive.calibration import step_log, steps
    from holodrive.control.duty_steps import DutySteps

    robot = base.robot
    try:
        groups = steps.groups_of(robot)
        full = counts if counts is not None else robot.pwm_map.counts if robot.pwm_map else 255
        wheels = tuple((group.wheels, group.diagonal, group.resolution_m) for group in groups)
        plug = DutySteps(wheels, counts=full, levels=levels, step_s=step_s, stray_m=stray_m)
        if estimator == "auto":
            mice = groups[0].diagonal and len(robot.mice) >= 2
            estimator = "mouse_odometry" if mice else estimation.default_name(robot)
        believer = estimation.estimator(estimator, robot) if isinstance(estimator, str) else estimator
        kept, start = step_log.StepLog(), Pose(*getattr(base, "truth", Pose(0.0, 0.0, 0.0)))
        still = references.ReferenceFollower(references.fixed_goal(start))
        loop = Loop(base, control.controller(plug, robot), believer, still, (kept,), calibration=True)
        loop.reset(start)
        ending = loop.run(plug.longest_s, progress=progress)
    finally:
        base.close()
    if ending.why == "interrupted":
        raise KeyboardInterrupt
    fault = loop.fault or loop.decision.fault or ("" if ending.why == "arrived" else "the schedule did not end in time")
    if fault:
        raise HardwareFault(f"{robot.name} is not calibrated: {fault}; all wheels are stopped")
    return steps.calibrate(robot, kept.records(robot, groups, full), full, measured_elsewhere=False)


class Rerun(NamedTuple):
    """A recorded run, the same run computed anew, and where they differ (nowhere, when all is well)."""

    recorded: Run
    again: Run
    differences: tuple[logs.Difference, ...]


def rerun(run: str | Path | Run, progress: Callable[[float], None] | None = None) -> Rerun:
    """Compute a recorded run anew from what its log says of itself, and compare number by number.

    A run that was stopped, or whose log was cut off, is compared as far as it went.

    Raises:
        LogError: the log is of a real robot, or its controller is not one that has a name.
    """
    recorded = run if isinstance(run, Run) else logs.read(run)
    settings = recorded.settings
    if "plant" not in settings:
        raise LogError("this log does not say how it was simulated; only simulated runs can be run again")
    if len(recorded.time) and recorded.time[0] > 0.0:
        raise LogError(
            f"this run began {recorded.time[0]:g} s after its base did; only a fresh base can be simulated again"
        )
    if settings["controller"] not in control.names():
        raise LogError(f"this run was driven by {settings['controller']!r}, which has no registered name to find it by")
    base = simulate(
        recorded.robot,
        recorded.world,
        plant=settings["plant"],
        seed=settings["seed"],
        start=settings["start"],
        dt_s=settings["dt_s"],
    )
    again = drive(
        base,
        settings["controller"],
        trajectory=planning.from_recipe(settings["reference"]),
        estimator=settings["estimator"],
        params=settings["params"],
        duration_s=_as_far(recorded),
        stop_on_arrival=settings["stop_on_arrival"],
        progress=progress,
    )
    cut = replace(again, events=again.events[: len(recorded.events)]) if _cut_off(recorded) else again
    told = tuple(event for event in recorded.events if event.kind != "stop")
    return Rerun(recorded, again, logs.compare(replace(recorded, events=told), cut))


def _cut_off(run: Run) -> bool:
    return run.ended == "interrupted" or not run.metrics


def _as_far(run: Run) -> float:
    """How long the run was to last [s], or lasted where it was cut off."""
    if _cut_off(run) and len(run.time):
        return float(run.time[-1]) + run.robot.control_period_s
    return float(run.settings["duration_s"])


def replay(path: str | Path, run: str | None = None, robot: str | Path | Robot | None = None) -> "Evaluation":
    """A recording of a real robot (or one of our logs): integrate its wheel odometry, judge it by the truth in it.

    Args:
        path: a recording in any known format (docs/recordings.md), or the name of one that ships.
        run: which run of a file that holds several.
        robot: whose geometry to use; the recording's own when None.

    Raises:
        LogError: nothing there, or nothing that can be read.
        FileFaults: a recording of the user's with faults, all of them at once.
    """
    from holodrive.log import recordings

    recording = recordings.read(path, run)
    return estimation.evaluate(recording, load(robot if robot is not None else recording.robot))


def calibrate_mice(
    robot: str | Path | Robot,
    runs: "str | Path | Sequence[MouseRun] | None" = None,
    *,
    turns: float | None = None,
    length_m: float | None = None,
    accuracy: "Accuracy | None" = None,
    plant: Plant = "first_order",
    seed: int = 0,
    per_axis: bool = False,
    progress: Callable[[float], None] | None = None,
) -> "MiceCalibration":
    """Scale, mounting angle and lever arm of each mouse, from a spin and two straight runs or any known track.

    Args:
        robot: whose mice; of what its file says of them only names, noise and the nominal resolution are used.
        runs: a CSV file of runs, a log (.mcap) with truth or wheel odometry, or runs; None simulates this robot,
            drives the moves and measures them as a person with a tape would.
        turns, length_m: of the moves (5.5 and 1 m when None); of runs in a CSV file that does not say.
        accuracy: of tape, turns and tracks.
        plant, seed: of the simulation.
        per_axis: tell the scales of a mouse's two axes apart.
        progress: called with the simulated time [s].

    Raises:
        InputError: a robot without mice, or runs that no calibration can use (a FileFaults where a file is at fault).
    """
    from holodrive.calibration import mice, mouse_csv, mouse_log, mouse_moves
    from holodrive.calibration.mouse_runs import Accuracy

    described = load(robot)
    if not described.mice:
        raise InputError(f"{described.name} has no mice to calibrate; add [sensor.mouse.NAME] to its file")
    if single := [mouse.name for mouse in described.mice if mouse.axes != "xy"]:
        raise InputError(
            f"mouse {single[0]} of {described.name} is a measuring wheel; this calibrates mice with two axes"
        )
    names = [mouse.name for mouse in described.mice]
    exact = accuracy or Accuracy()
    found: Sequence[MouseRun]
    if runs is None:
        driven = drive_mice(described, turns=turns, length_m=length_m, accuracy=exact, plant=plant, seed=seed,
                            progress=progress)  # fmt: skip
        found = [mouse_moves.run_of(each, exact) for each in driven]
    elif isinstance(runs, str | Path):
        if str(runs).endswith(".mcap"):
            found = mouse_log.runs_of(logs.read(runs), names, exact)
        else:
            found = mouse_csv.read_csv(runs, names, turns=turns, length_m=length_m, accuracy=accuracy)
    else:
        found = runs
    return mice.calibrate(
        found,
        names,
        described.footprint_radius_m,
        nominal_m=[mouse.resolution_m for mouse in described.mice],
        noise_relative=[mouse.noise_relative for mouse in described.mice],
        per_axis=per_axis,
    )


def drive_mice(
    robot: str | Path | Robot,
    *,
    turns: float | None = None,
    length_m: float | None = None,
    accuracy: "Accuracy | None" = None,
    plant: Plant = "first_order",
    seed: int = 0,
    progress: Callable[[float], None] | None = None,
) -> "list[Driven]":
    """The moves that calibrate mice, driven by a simulated robot and measured with a tape; see `calibrate_mice`."""
    from holodrive.calibration import mouse_moves
    from holodrive.calibration.mouse_runs import Accuracy

    base = simulate(robot, plant=plant, seed=seed)
    chosen = mouse_moves.moves(base.robot, 5.5 if turns is None else turns, 1.0 if length_m is None else length_m)
    generator, begin = np.random.default_rng(seed), base.truth

    def stand(move: "Move") -> "Stand":
        nonlocal begin
        before, begin = begin, base.truth
        return mouse_moves.by_tape(before, begin, accuracy or Accuracy(), generator)

    try:
        return [_driven(base, move, stand, progress) for move in chosen]
    finally:
        base.close()


def _driven(
    base: Base, move: "Move", stand: "Callable[[Move], Stand]", progress: Callable[[float], None] | None
) -> "Driven":
    """One move on any base; `stand` says afterwards where the robot stands."""
    from holodrive.calibration import mouse_moves

    still = references.ReferenceFollower(references.fixed_goal((0.0, 0.0, 0.0)))
    loop = Loop(base, mouse_moves.OpenLoop(move), mouse_moves.Blind(), still)
    loop.reset(Pose(0.0, 0.0, 0.0))
    time, counts = [], []
    # a driver gives metres by the file's resolution: whole counts again, which is what a mouse really tells
    resolution = np.array([mouse.resolution_m for mouse in base.robot.mice])[:, None]
    while not loop.decision.arrived:
        tick = loop.step()
        if loop.fault:
            raise InputError(f"run {move.name!r} was stopped: {loop.fault}")
        time.append(tick.time)
        counts.append(np.round(np.asarray(tick.mice) / resolution))
        if progress is not None:
            progress(tick.time)
    return mouse_moves.Driven(move, np.array(time), np.array(counts), stand(move))


def _settings(
    base: Base,
    controller: Any,
    estimator: Any,
    params: dict[str, Any] | None,
    table: references.Table,
    start: Pose,
    length: float,
    stop_on_arrival: bool,
) -> dict[str, Any]:
    """What it takes to repeat the run; its `id` is a hash of all that, robot and world included."""
    settings: dict[str, Any] = {
        "version": __version__,
        "robot": base.robot.name,
        "world": getattr(getattr(base, "world", None), "name", ""),
        "controller": _name(controller),
        "estimator": _name(estimator),
        "params": params or {},
        "reference": table.recipe,
        "start": [float(value) for value in start],
        "duration_s": length,
        "stop_on_arrival": stop_on_arrival,
    }
    for name in ("plant", "seed", "dt_s"):
        if hasattr(base, name):
            settings[name] = getattr(base, name)
    whole = json.dumps([settings, base.robot.text, getattr(getattr(base, "world", None), "text", "")], default=str)
    settings["id"] = hashlib.blake2b(whole.encode(), digest_size=4).hexdigest()
    return settings


def _name(thing: Any) -> str:
    return thing if isinstance(thing, str) else getattr(thing, "__name__", type(thing).__name__)


def _length(duration_s: float | None, table: references.Table) -> float:
    length = duration_s
    if length is None:
        length = table.duration_s + AFTER_TRAJECTORY_S if table.duration_s else DEFAULT_DURATION_S
    if not (length > 0.0 and math.isfinite(length)):
        raise InputError(f"a run takes a time above 0; found {length} s")
    return length


def _reference(
    place: World | None,
    start: Pose,
    goal: ArrayLike | None,
    waypoints: ArrayLike | None,
    trajectory: references.Table | None,
) -> references.Table:
    """The one reference that was asked for; the world's goal when nothing was."""
    asked = [
        name
        for name, value in (("goal", goal), ("waypoints", waypoints), ("trajectory", trajectory))
        if value is not None
    ]
    if len(asked) > 1:
        raise InputError(f"a run has one reference; found {' and '.join(asked)}")
    if trajectory is not None:
        return trajectory
    if waypoints is not None:
        return references.waypoints(
            [_pose(point, start, "a way point") for point in np.atleast_2d(np.asarray(waypoints, float))]
        )
    if goal is not None:
        return references.fixed_goal(_pose(np.asarray(goal, float), start, "a goal"))
    if place is None or place.goal is None:
        where = f"world {place.name!r}" if place else "the base"
        raise InputError(
            f"{where} has no goal; give one: goal=(x, y) or (x, y, theta), waypoints=... or trajectory=..."
        )
    pose = place.goal.pose
    return references.fixed_goal(pose if place.goal.heading_matters else (pose.x, pose.y, start.theta))


def _pose(value: Any, start: Pose, what: str) -> tuple[float, float, float]:
    if value.shape not in ((2,), (3,)):
        raise InputError(f"{what} is (x, y) or (x, y, theta); found {value.tolist()}")
    return (float(value[0]), float(value[1]), float(value[2]) if len(value) == 3 else start.theta)


def _world(name_or_path: str | Path | World | None) -> World:
    return name_or_path if isinstance(name_or_path, World) else worlds.load(name_or_path or "open")
