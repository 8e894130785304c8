"""Figures 6 to 9: pose, error, wheel speeds and steering of the robot with BLDC and with DC motors, to both goals."""

import math
from collections.abc import Callable, Sequence

from holodrive import build
from holodrive.experiments.claims import Claim
from holodrive.experiments.experiment import Result, Setting
from holodrive.experiments.pictures import Gallery, paths_over
from holodrive.experiments.swerve import printed, robots
from holodrive.experiments.swerve.robots import Setup
from holodrive.experiments.swerve.runs import BAND, GOALS, Place, Track, drive, told
from holodrive.log.run import Run
from holodrive.reports.plots import Chart, Line
from holodrive.reports.sections import ChartSection, ComparisonSection
from holodrive.types import Array, Pose
from holodrive.worlds.spec import Goal, World

BLDC = (robots.BLDC, robots.FOC, robots.AVERAGED)
DC = (robots.DC_HENRY, robots.DC_MILLI)
SHOWN_S = 10.0  # the figures' time axis; they print none that could be read
MARGIN_M = 1.0
REPLAY_S = 10.0


def figure_6(setting: Setting) -> Result:
    """Pose and error with BLDC motors."""
    return _poses("Figure 6", "Fig. 6", BLDC)


def figure_7(setting: Setting) -> Result:
    """Wheel speeds and steering with BLDC motors."""
    return _wheels("Figure 7", "Fig. 7", BLDC)


def figure_8(setting: Setting) -> Result:
    """Pose and error with DC motors."""
    return _poses("Figure 8", "Fig. 8", DC)


def figure_9(setting: Setting) -> Result:
    """Wheel speeds and steering with DC motors."""
    return _wheels("Figure 9", "Fig. 9", DC)


def replay(setting: Setting) -> Result:
    """The robot with BLDC and with DC motors side by side, module by module, as a recorded run."""
    shown = (robots.BLDC, robots.DC_HENRY, robots.DC_MILLI)
    recorded = tuple(_recorded(setup) for setup in shown)
    names = tuple(setup.name for setup in shown)
    note = f"Goal {told(printed.GOAL_FIGURES)}; {REPLAY_S:g} s of each."
    return Result(sections=(ComparisonSection(recorded, names, "The robots side by side", note),))


def _recorded(setup: Setup) -> Run:
    goal = printed.GOAL_FIGURES
    base = build.simulate(setup.robot, floor(goal), plant="motors")
    return build.drive(
        base,
        "go_to_pose",
        params={"k_xy": setup.k, "k_theta": setup.k},
        duration_s=REPLAY_S,
        stop_on_arrival=False,
    )


def floor(goal: Place) -> World:
    """The open floor about start and goal; the circle is where the robot counts as arrived."""
    side = max(goal[0], goal[1]) + 2.0 * MARGIN_M
    corner = (0.5 * goal[0] - 0.5 * side, 0.5 * goal[1] - 0.5 * side)
    return World(
        "floor", told(goal), size=(side, side), corner=corner, walls=False,
        goal=Goal(
            Pose(goal[0], goal[1], math.radians(goal[2])),
            tolerance_m=BAND * math.hypot(goal[0], goal[1]),
            heading_matters=True,
        ),
    )  # fmt: skip


def _poses(title: str, where: str, setups: Sequence[Setup]) -> Result:
    pictures, charts = [], []
    for goal in GOALS:
        tracks = [drive(setup, goal) for setup in setups]
        ways = [(track.setup.name, track.pose) for track in tracks]
        pictures.append((f"goal {told(goal)}", paths_over(floor(goal), ways, 440.0, 480.0)))
        charts += [
            _over_setups(f"Distance to {told(goal)}", "m", tracks, lambda track: track.error),
            _over_setups(f"Heading left to turn, {told(goal)}", "°", tracks, lambda track: track.heading_error_deg),
        ]
    claim = Claim(where, "pose and error", "drawn", "drawn", "no number", note="the figure's numbers are in its text")
    sections = (Gallery(f"{title}(a): pose", tuple(pictures)), ChartSection(f"{title}(b): error", tuple(charts)))
    return Result((claim,), sections)


def _wheels(title: str, where: str, setups: Sequence[Setup]) -> Result:
    speeds, steers = [], []
    for setup in setups:  # a row of charts each, a column each goal
        for goal in GOALS:
            track = drive(setup, goal)
            speeds.append(_over_wheels(f"{setup.name}, to {told(goal)}", "rpm", track, track.speed_rpm))
            steers.append(_over_wheels(f"{setup.name}, to {told(goal)}", "°", track, track.steer_deg))
    claim = Claim(where, "speed and steering of each wheel", "drawn", "drawn", "no number")
    sections = (
        ChartSection(f"{title}(a): wheel speeds", tuple(speeds)),
        ChartSection(f"{title}(b): steering angles", tuple(steers), "Modules of more than a turn are not wound back."),
    )
    return Result((claim,), sections)


def _over_setups(title: str, unit: str, tracks: Sequence[Track], value: Callable[[Track], Array]) -> Chart:
    lines = []
    for i, track in enumerate(tracks):
        shown = track.time <= SHOWN_S
        dash = (None, "7 3", "2 3")[i]
        lines.append(Line(track.setup.name, track.time[shown], value(track)[shown], i, dash=dash))
    return Chart(title, unit, tuple(lines), low=0.0)


def _over_wheels(title: str, unit: str, track: Track, values: Array) -> Chart:
    shown = track.time <= SHOWN_S
    names = [wheel.name for wheel in track.setup.robot.wheels]
    lines = tuple(Line(name, track.time[shown], values[shown, i], i) for i, name in enumerate(names))
    return Chart(title, unit, lines)
