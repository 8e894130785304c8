"""Synthetic runs: what a report has to draw, made without simulator or loop."""

import math
from collections.abc import Callable
from html.parser import HTMLParser

import numpy as np
import pytest

from holodrive.log.run import Run
from holodrive.robots.spec import Encoder, Lidar, Motor, Robot, Steering, WheelSpec
from holodrive.types import Event, Pose, Scan
from holodrive.worlds.spec import Box, Circle, Goal, KeyFrame, Mover, Segment, World

MOTOR = Motor("jgb37", "dc", 12.0, 2.3, 4.8, 6.0)


def hybrid3() -> Robot:
    spokes = {
        "front": (0.0, 90.0, "omni", 0.0),
        "right": (-120.0, -30.0, "mecanum", 45.0),
        "left": (120.0, -150.0, "mecanum", -45.0),
    }
    wheels = tuple(
        WheelSpec(
            name,
            kind,
            0.23 * math.cos(math.radians(at)),
            0.23 * math.sin(math.radians(at)),
            math.radians(yaw),
            0.051,
            MOTOR,
            2.3,
            roller=math.radians(roller),
            width=0.045,
            encoder=Encoder(2000.0),
        )
        for name, (at, yaw, kind, roller) in spokes.items()
    )
    return Robot("hybrid3", wheels, 3.26, 0.1, 0.27, title="one omni and two Mecanum wheels", lidar=Lidar("a1"))


def mecanum4() -> Robot:
    wheels = tuple(
        WheelSpec(name, "mecanum", x, y, 0.0, 0.03, MOTOR, 20.0, roller=math.radians(roller), width=0.03)
        for name, x, y, roller in (
            ("fl", 0.08, 0.08, -45),
            ("fr", 0.08, -0.08, 45),
            ("rl", -0.08, 0.08, 45),
            ("rr", -0.08, -0.08, -45),
        )
    )
    return Robot("mecanum4", wheels, 1.5, 0.02, 0.14)


def swerve3() -> Robot:
    wheels = tuple(
        WheelSpec(
            name,
            "swerve",
            0.3 * math.cos(a),
            0.3 * math.sin(a),
            0.0,
            0.06,
            MOTOR,
            30.0,
            width=0.04,
            steering=Steering(),
        )
        for name, a in (("front", 0.0), ("right", -2 * math.pi / 3), ("left", 2 * math.pi / 3))
    )
    return Robot("swerve3", wheels, 12.0, 0.8, 0.4)


def course() -> World:
    return World(
        "course",
        "the first paper's course",
        size=(3.0, 5.0),
        start=Pose(0.5, 0.5, 0.0),
        goal=Goal(Pose(0.5, 4.5, math.pi / 2), 0.05, heading_matters=True),
        circles=(Circle(2.0, 1.2, 0.25, "obstacle 1"), Circle(0.5, 2.6, 0.2, "obstacle 2")),
        boxes=(Box(2.4, 3.6, 0.6, 0.3, 0.4, "box"),),
        segments=(Segment(0.0, 3.5, 0.6, 3.5, "shelf"),),
        movers=(
            Mover(0.15, (KeyFrame(0.0, 2.5, 2.4), KeyFrame(8.0, 1.6, 2.9), KeyFrame(16.0, 2.5, 2.4)), True, "cart"),
        ),
    )


def rays(world: World, pose, angles) -> np.ndarray:
    """Distances to walls and circles."""
    heading = pose[2] + angles
    d = np.stack([np.cos(heading), np.sin(heading)], -1)
    best = np.full(len(angles), np.inf)
    for s in [*world.border(), *world.segments]:
        e = np.array([s.x2 - s.x1, s.y2 - s.y1])
        o = np.array([s.x1, s.y1]) - pose[:2]
        det = d[:, 0] * -e[1] + d[:, 1] * e[0]
        with np.errstate(divide="ignore", invalid="ignore"):
            t = (o[0] * -e[1] + o[1] * e[0]) / det
            u = (d[:, 0] * o[1] - d[:, 1] * o[0]) / det
        best = np.where((t > 0) & (u >= 0) & (u <= 1), np.minimum(best, t), best)
    for c in world.circles:
        o = np.array([c.x, c.y]) - pose[:2]
        b = d @ o
        disc = b * b - o @ o + c.radius**2
        t = b - np.sqrt(np.maximum(disc, 0))
        best = np.where((disc > 0) & (t > 0), np.minimum(best, t), best)
    return best


def smooth(points, n):
    points = np.asarray(points, float)
    s = np.concatenate([[0], np.cumsum(np.hypot(*np.diff(points, axis=0).T))])
    u = np.linspace(0, s[-1], n)
    xy = np.stack([np.interp(u, s, points[:, i]) for i in (0, 1)], -1)
    half = n // 40
    total = np.cumsum(np.pad(xy, ((half + 1, half), (0, 0)), mode="edge"), axis=0)
    return (total[2 * half + 1 :] - total[: -2 * half - 1]) / (2 * half + 1)


def make_run(
    robot=None, world=None, *, name="go_to_pose", seed=0, seconds=30.0, via=None, bulge=0.0, scans=True
) -> Run:
    robot = robot or hybrid3()
    world = world or course()
    rng = np.random.default_rng(seed)
    n = round(seconds / robot.control_period_s)
    time = (np.arange(n) + 1) * robot.control_period_s
    via = via or [(0.5, 0.5), (1.25 + bulge, 1.5), (1.3 + bulge, 3.2), (0.5, 4.5)]
    xy = smooth(via, n)
    theta = np.pi / 2 * np.sin(time / seconds * 4)
    pose = np.column_stack([xy, theta])
    drift = np.cumsum(rng.normal(0, 0.0004, (n, 3)), axis=0)
    reference = pose + np.array([0.03, 0.02, 0.03]) * np.sin(time * 0.7)[:, None]
    w = len(robot.wheels)
    m = len(robot.steered)
    top = robot.wheels[0].max_speed_rad_s
    speeds = top * 0.8 * np.sin(time[:, None] * np.linspace(0.3, 0.8, w) + np.arange(w))
    commands = np.clip(speeds * 1.1, -top, top)
    speeds = speeds + rng.normal(0, 0.02 * top, (n, w))
    steer = np.cumsum(rng.normal(0, 0.01, (n, m)), axis=0)
    angles = np.linspace(-math.pi, math.pi, 360, endpoint=False)
    revolutions = []
    if scans and robot.lidar:
        for i in range(9, n, 10):
            r = rays(world, pose[i], angles) * (1 + rng.normal(0, 0.005, 360))
            revolutions.append(Scan(float(time[i]), angles, r, np.zeros(360), range_min=0.15, range_max=12.0))
    rate = np.gradient(pose, time, axis=0)
    twist = np.column_stack(
        [
            np.cos(theta) * rate[:, 0] + np.sin(theta) * rate[:, 1],
            -np.sin(theta) * rate[:, 0] + np.cos(theta) * rate[:, 1],
            rate[:, 2],
        ]
    )
    bump = n // 2
    events = (
        Event(
            float(time[bump]),
            "collision",
            "touched obstacle 2; the robot moved",
            Pose(*pose[bump]),
            {"place": [0.72, 2.6], "moved": "robot"},
        ),
        Event(float(time[-1]), "arrived", "goal reached", Pose(*pose[-1])),
    )
    length = float(np.hypot(*np.diff(xy, axis=0).T).sum())
    return Run(
        robot=robot,
        world=world,
        settings={
            "id": f"7f3a9{seed}",
            "controller": name,
            "params": {"kp": 1.2, "kd": [0.1, 0.2]},
            "plant": "slip",
            "seed": seed,
            "reference": "waypoints",
            "duration": seconds,
            "version": "0.1.0",
        },
        time=time,
        pose=pose,
        estimate=pose + drift,
        covariance=np.tile(np.eye(3) * 1e-4, (n, 1, 1)),
        reference=reference,
        twist=twist,
        decided=twist * 1.05,
        wheel_commands=commands,
        wheel_speeds=speeds,
        steer_commands=steer + 0.02,
        steer=steer,
        duty=np.clip(commands / top, -1, 1),
        slip=np.abs(rng.normal(0, 0.003, n)),
        scans=tuple(revolutions),
        events=events,
        metrics={
            "arrived": 1.0,
            "time_s": seconds - seed,
            "path_length_m": length,
            "turns": 6.0,
            "min_clearance_m": 0.021 * (seed + 1),
            "collisions": 1.0,
            "moved_collisions": 0.0,
            "iae_m_s": 1.234 + seed / 10,
            "ise_m2_s": 0.0567,
            "rms_error_m": 0.0312 + seed * 0.004,
            "max_error_m": 0.081,
            "final_error_m": 0.0123,
            "final_heading_error_rad": 0.021,
            "energy_j": 123.4,
            "saturated_share": 0.12,
            "mean_speed_m_s": length / seconds,
        },
    )


@pytest.fixture(scope="session")
def run() -> Run:
    return make_run()


@pytest.fixture(scope="session")
def short_run() -> Run:
    return make_run(seconds=2.0)


@pytest.fixture(scope="session")
def runs() -> list[Run]:
    return [
        make_run(name=c, seed=i, seconds=10.0, bulge=b)
        for i, (c, b) in enumerate([("go_to_pose", 0.0), ("pid", 0.35), ("fuzzy", -0.2)])
    ]


@pytest.fixture
def blank_run() -> Run:
    """One tick, nothing known."""
    robot = hybrid3()
    nan = np.full((1, 3), np.nan)
    return Run(
        robot=robot,
        world=None,
        settings={},
        time=np.zeros(1),
        pose=nan,
        estimate=nan,
        covariance=np.full((1, 3, 3), np.nan),
        reference=nan,
        twist=nan,
        decided=nan,
        wheel_commands=nan,
        wheel_speeds=nan,
        steer_commands=np.empty((1, 0)),
        steer=np.empty((1, 0)),
        duty=nan,
        slip=np.full(1, np.nan),
        metrics={"iae_m_s": math.nan},
    )


VOID = {"meta", "input", "br", "link", "img"}


class Page(HTMLParser):
    """Elements of a page with their attributes, and the text between them; a tag that is not closed fails."""

    def __init__(self, html: str) -> None:
        super().__init__(convert_charrefs=True)
        self.open: list[str] = []
        self.elements: list[tuple[str, dict[str, str]]] = []
        self.texts: list[str] = []
        self.scripts: list[tuple[dict[str, str], str]] = []
        self.feed(html)
        self.close()
        assert self.open == []

    def handle_starttag(self, tag, attrs):
        self.elements.append((tag, dict(attrs)))
        if tag not in VOID:
            self.open.append(tag)

    def handle_startendtag(self, tag, attrs):
        self.elements.append((tag, dict(attrs)))

    def handle_endtag(self, tag):
        assert self.open.pop() == tag

    def handle_data(self, data):
        if self.open and self.open[-1] == "script":
            self.scripts.append((self.elements[-1][1], data))
        elif not self.open or self.open[-1] != "style":
            self.texts.append(data)

    def all(self, tag: str) -> list[dict[str, str]]:
        return [attributes for name, attributes in self.elements if name == tag]

    @property
    def text(self) -> str:
        return " ".join(" ".join(self.texts).split())


@pytest.fixture(scope="session")
def parse() -> Callable[[str], Page]:
    return Page


@pytest.fixture(scope="session")
def make() -> Callable[..., Run]:
    return make_run


@pytest.fixture(scope="session")
def bodies() -> dict[str, Callable[[], Robot]]:
    return {"hybrid3": hybrid3, "mecanum4": mecanum4, "swerve3": swerve3}
