"""A world as it is described: what stands, what moves, where a run starts and where it shall go.

Frame `map`: metres, x to the right, y up, heading from the x axis.
"""

import math
from dataclasses import dataclass

from holodrive.types import Pose


@dataclass(frozen=True, slots=True)
class Circle:
    """A round obstacle [m]."""

    x: float
    y: float
    radius: float
    name: str = ""


@dataclass(frozen=True, slots=True)
class Segment:
    """A wall without thickness from (x1, y1) to (x2, y2) [m]."""

    x1: float
    y1: float
    x2: float
    y2: float
    name: str = ""


@dataclass(frozen=True, slots=True)
class Box:
    """A filled rectangle about (x, y), `length` along its own x axis, turned by `theta` [m, m, m, m, rad]."""

    x: float
    y: float
    length: float
    width: float
    theta: float = 0.0
    name: str = ""


@dataclass(frozen=True, slots=True)
class KeyFrame:
    """Where a moving obstacle is at `time` [s, m, m]; straight and even motion between key frames."""

    time: float
    x: float
    y: float


@dataclass(frozen=True, slots=True)
class Mover:
    """A round obstacle on a key-framed path; it waits at the ends, or starts again when `loop`."""

    radius: float
    path: tuple[KeyFrame, ...]
    loop: bool = False
    name: str = ""


@dataclass(frozen=True, slots=True)
class Goal:
    """Where to go, and how near is there."""

    pose: Pose
    tolerance_m: float = 0.02
    tolerance_rad: float = math.radians(2.0)
    heading_matters: bool = False


@dataclass(frozen=True, slots=True)
class World:
    """Arena, obstacles, start and goal.

    Attributes:
        size: (width, height) of the walled arena whose lower left corner is `corner` [m]; None = open floor.
        walls: whether the arena's border is four walls.
        goal: None when the world asks for nothing.
        text: the TOML it came from, "" for one made in code.
    """

    name: str
    title: str = ""
    source: str = ""
    size: tuple[float, float] | None = None
    corner: tuple[float, float] = (0.0, 0.0)
    walls: bool = True
    start: Pose = Pose(0.0, 0.0, 0.0)
    goal: Goal | None = None
    circles: tuple[Circle, ...] = ()
    segments: tuple[Segment, ...] = ()
    boxes: tuple[Box, ...] = ()
    movers: tuple[Mover, ...] = ()
    text: str = ""

    def border(self) -> tuple[Segment, ...]:
        """The four walls of the arena, or none."""
        if self.size is None or not self.walls:
            return ()
        (x, y), (w, h) = self.corner, self.size
        corners = [(x, y), (x + w, y), (x + w, y + h), (x, y + h), (x, y)]
        names = ("south wall", "east wall", "north wall", "west wall")
        return tuple(Segment(*a, *b, name) for a, b, name in zip(corners, corners[1:], names, strict=False))

    def _repr_html_(self) -> str:
        from holodrive.worlds.drawing import world_svg

        return world_svg(self)
