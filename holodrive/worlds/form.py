"""The tables of a world file, as pydantic forms. Descriptions serve editors, faults and the reference."""

import math
from typing import Annotated

from pydantic import Field

from holodrive.files.edge import Angle, Coordinate, Form, Quantity

Size = Annotated[float, Quantity("length", 0.0, 1e4, above_low=True)]
Time = Annotated[float, Quantity("time", 0.0, 1e7)]


class WorldForm(Form):
    """The world as a whole."""

    name: str = Field(description="a short name")
    title: str = Field(default="", description="one line for people")
    source: str = Field(default="", description="where the numbers come from")
    accept: list[str] = Field(default=[], description='faults that are meant: "goal-in-obstacle"')


class Point(Form):
    """A point of the map."""

    x: Coordinate = Field(description="a length, to the right")
    y: Coordinate = Field(description="a length, up")


class ArenaForm(Form):
    """The rectangle that the world fills. Without width and height the floor is open."""

    width: Size | None = Field(default=None, description="along x")
    height: Size | None = Field(default=None, description="along y")
    corner: Point = Field(default=Point(x=0.0, y=0.0), description="its lower left corner")
    walls: bool = Field(default=True, description="four walls around it")


class StartForm(Form):
    """Where the robot's centre is at first."""

    x: Coordinate = Field(default=0.0, description="a length, to the right")
    y: Coordinate = Field(default=0.0, description="a length, up")
    heading: Angle = Field(default=0.0, description="counter-clockwise from the x axis")


class GoalForm(Form):
    """Where it shall go."""

    x: Coordinate = Field(description="a length, to the right")
    y: Coordinate = Field(description="a length, up")
    heading: Angle | None = Field(default=None, description="counter-clockwise from the x axis; without it any")
    tolerance: Annotated[float, Quantity("length", 0.0, 1e4, above_low=True)] = Field(
        default=0.02, description="how near is there"
    )
    heading_tolerance: Annotated[float, Quantity("angle", 0.0, 3.2, above_low=True)] = Field(
        default=math.radians(2.0), description="how near in heading"
    )
    heading_matters: bool | None = Field(default=None, description="true when a heading is written")


class CircleForm(Form):
    """A round obstacle."""

    name: str = Field(default="", description="for people and --set")
    x: Coordinate = Field(description="a length, to the right")
    y: Coordinate = Field(description="a length, up")
    radius: Size = Field(description='a length such as "15 cm"')


class WallForm(Form):
    """A straight wall without thickness."""

    name: str = Field(default="", description="for people and --set")
    start: Point = Field(alias="from", description="one end, such as { x = 0, y = 0 }")
    end: Point = Field(alias="to", description="the other end")


class BoxForm(Form):
    """A filled rectangle."""

    name: str = Field(default="", description="for people and --set")
    x: Coordinate = Field(description="of the middle, to the right")
    y: Coordinate = Field(description="of the middle, up")
    length: Size = Field(description="along its own x axis")
    width: Size = Field(description="the size across its x axis")
    yaw: Angle = Field(default=0.0, description="of its own x axis")


class KeyFrameForm(Form):
    """Where a moving obstacle is at a time."""

    time: Time = Field(description="since the start")
    x: Coordinate = Field(description="a length, to the right")
    y: Coordinate = Field(description="a length, up")


class MoverForm(Form):
    """A round obstacle that moves straight and evenly from key frame to key frame."""

    name: str = Field(default="", description="for people and --set")
    radius: Size = Field(description='a length such as "20 cm"')
    path: list[KeyFrameForm] = Field(description='key frames such as { time = "2 s", x = 1, y = 0.5 }')
    loop: bool = Field(default=False, description="start again after the last key frame instead of waiting there")
