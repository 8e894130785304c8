"""Pixels without a display: the floor, its obstacles, paths and robots drawn with Pillow."""

import math
from collections.abc import Sequence
from functools import lru_cache
from typing import TYPE_CHECKING, Any

import numpy as np

from holodrive import svg
from holodrive.geometry import compose
from holodrive.log.drawing import Trace
from holodrive.log.shapes import contact, mover_place
from holodrive.log.view import View, scale_bar_length
from holodrive.robots.checks import trail
from holodrive.robots.drawing import hatches
from holodrive.robots.spec import Robot
from holodrive.types import Array, Event, Pose
from holodrive.worlds.drawing import box_corners
from holodrive.worlds.spec import Mover, World

if TYPE_CHECKING:
    from PIL.Image import Image

FINE = 2  # pixels drawn for each pixel shown, each way: smooth edges
WHITE, GRID, MUTED, INK = (255, 255, 255), (227, 230, 234), (91, 102, 117), (29, 37, 48)
THING, THING_EDGE, WALL = (195, 202, 211), (107, 118, 132), (60, 70, 84)
MOVING, MOVING_EDGE = (217, 198, 226), (138, 90, 158)
BLUE, PALE_BLUE, BODY = (0, 114, 178), (222, 236, 246), (255, 255, 255)
GREEN, VERMILION = (0, 158, 115), (213, 94, 0)
Colour = tuple[int, int, int]


class Canvas:
    """A picture of a piece of floor, drawn larger than it is shown."""

    def __init__(self, view: View, size: tuple[int, int], image: "Image | None" = None) -> None:
        from PIL import Image, ImageDraw

        self.view, self.size = view, size
        self.image = image or Image.new("RGB", (FINE * size[0], FINE * size[1]), WHITE)
        self.draw = ImageDraw.Draw(self.image)

    def copy(self) -> "Canvas":
        """The same picture, to draw on."""
        return Canvas(self.view, self.size, self.image.copy())

    def shown(self) -> "Image":
        """The picture at its own size."""
        return self.image.reduce(FINE)

    def at(self, places: Array) -> Array:
        """Drawn pixels (..., 2) of places (..., 2 or more) [m]."""
        return FINE * self.view.pixels(places)

    def line(self, places: Array, colour: Colour, width: float = 1.5, dash: tuple[float, float] | None = None) -> None:
        """A polyline through places (n, 2 or more) [m]; rows that are not finite are gaps; widths and dashes in px."""
        for run in svg.finite_runs(svg.simplify(self.at(places), 0.3)):
            for piece in dashes(run, dash[0] * FINE, dash[1] * FINE) if dash else [run]:
                if len(piece) > 1:
                    flat = [tuple(p) for p in piece.tolist()]
                    self.draw.line(flat, fill=colour, width=max(1, round(width * FINE)), joint="curve")

    def disc(
        self, x: float, y: float, radius: float, fill: Colour | None, edge: Colour | None, width: float = 1.0
    ) -> None:
        """A circle about a place, radius in metres."""
        (px, py), r = self.at(np.array([x, y])), radius * self.view.scale * FINE
        if math.isfinite(px + py):
            self.draw.ellipse((px - r, py - r, px + r, py + r), fill=fill, outline=edge, width=round(width * FINE))

    def polygon(self, places: Array, fill: Colour | None, edge: Colour | None = None) -> None:
        """A filled shape with corners (n, 2) [m]."""
        self.draw.polygon([tuple(p) for p in self.at(places).tolist()], fill=fill, outline=edge)

    def text(
        self, x: float, y: float, content: str, colour: Colour = MUTED, anchor: str = "lm", size: float = 11.0
    ) -> None:
        """Words at a pixel of the picture as shown; anchors are Pillow's."""
        plain = content.replace("−", "-")  # the built-in font has no true minus
        self.draw.text((FINE * x, FINE * y), plain, fill=colour, font=_font(round(FINE * size)), anchor=anchor)


def floor(canvas: Canvas) -> None:
    """Grid with numbers, and the scale bar."""
    view, draw = canvas.view, canvas.draw
    x0, y0, x1, y1 = view.bounds
    right, bottom = view.left + view.width, view.top + view.height
    steps, decimals = svg.ticks(0.0, max(x1 - x0, y1 - y0), max(2, int(max(view.width, view.height) // 70)))
    step = float(steps[1] - steps[0]) if len(steps) > 1 else 1.0
    for x in np.arange(math.ceil(x0 / step - 1e-9), math.floor(x1 / step + 1e-9) + 1) * step:
        column = FINE * view.x(x)
        draw.line((column, FINE * view.top, column, FINE * bottom), fill=GRID, width=FINE)
        canvas.text(view.x(x), bottom + 9, svg.number(x, decimals), anchor="mm")
    for y in np.arange(math.ceil(y0 / step - 1e-9), math.floor(y1 / step + 1e-9) + 1) * step:
        row = FINE * view.y(y)
        draw.line((FINE * view.left, row, FINE * right, row), fill=GRID, width=FINE)
        canvas.text(view.left - 6, view.y(y), svg.number(y, decimals), anchor="rm")
    length, label = scale_bar_length(view)
    row, left = bottom + 25, right - length * view.scale
    for a, b in (((left, row - 4), (left, row + 4)), ((left, row), (right, row)), ((right, row - 4), (right, row + 4))):
        draw.line((FINE * a[0], FINE * a[1], FINE * b[0], FINE * b[1]), fill=WALL, width=round(1.5 * FINE))
    canvas.text(left - 6, row, label, anchor="rm")


def world(canvas: Canvas, place: World) -> None:
    """What stands: obstacles with their names, walls, start and goal. What moves is drawn by `mover`."""
    for circle in place.circles:
        canvas.disc(circle.x, circle.y, circle.radius, THING, THING_EDGE)
    for box in place.boxes:
        canvas.polygon(np.array(box_corners(box)), THING, THING_EDGE)
    for wall in (*place.border(), *place.segments):
        canvas.line(np.array([[wall.x1, wall.y1], [wall.x2, wall.y2]]), WALL, 3.0)
    for circle in place.circles:
        _name(canvas, circle.name, circle.x, circle.y, circle.radius)
    for box in place.boxes:
        _name(canvas, box.name, box.x, box.y, 0.5 * min(box.length, box.width))
    for moving in place.movers:
        times = np.array([key.time for key in moving.path])
        canvas.line(mover_place(moving, times), MOVING_EDGE, 1.2, (2, 4))
    canvas.disc(place.start.x, place.start.y, 4.0 / canvas.view.scale, WHITE, INK, 1.5)
    if place.goal is not None:
        pose, reach = place.goal.pose, max(6.0 / canvas.view.scale, place.goal.tolerance_m)
        canvas.disc(pose.x, pose.y, reach, None, GREEN, 1.8)
        out = reach + 4.0 / canvas.view.scale
        for dx, dy in ((out, 0.0), (0.0, out)):
            canvas.line(np.array([[pose.x - dx, pose.y - dy], [pose.x + dx, pose.y + dy]]), GREEN, 1.6)
        if place.goal.heading_matters:
            canvas.line(np.array([pose[:2], compose(pose, (2.2 * out, 0.0, 0.0))[:2]]), GREEN, 1.6)


def mover(canvas: Canvas, moving: Mover, time: float) -> None:
    """A moving obstacle where it is at a time [s]."""
    x, y = mover_place(moving, np.array(time))
    canvas.disc(x, y, moving.radius, MOVING, MOVING_EDGE)
    _name(canvas, moving.name, x, y, moving.radius)


def robot(canvas: Canvas, described: Robot, pose: Array, steer: Array) -> None:
    """A robot with its wheels, rollers and heading; nothing where its pose is not known."""
    if not np.isfinite(pose).all():
        return
    reach = described.footprint_radius_m
    canvas.disc(pose[0], pose[1], reach, PALE_BLUE, BLUE)

    def placed(corners: Sequence[tuple[float, float]], frame: Any = (0.0, 0.0, 0.0)) -> Array:
        local = compose(frame, np.array([(x, y, 0.0) for x, y in corners]))
        return np.asarray(compose(pose, local))[:, :2]

    hull = sorted(((w.x, w.y) for w in described.wheels), key=lambda p: math.atan2(p[1], p[0]))
    canvas.polygon(placed(hull), BODY, THING_EDGE)
    canvas.polygon(placed([(0.34 * reach, -0.16 * reach), (0.34 * reach, 0.16 * reach), (0.66 * reach, 0.0)]), BLUE)
    angles = dict(zip(described.steered, np.nan_to_num(steer), strict=False))
    for i, wheel in enumerate(described.wheels):
        frame = Pose(wheel.x, wheel.y, wheel.yaw + float(angles.get(i, 0.0)))
        r, h, c = wheel.radius, 0.5 * wheel.width, trail(wheel)
        canvas.polygon(placed([(r - c, h), (-r - c, h), (-r - c, -h), (r - c, -h)], frame), WALL, INK)
        if wheel.kind != "swerve" and wheel.width * canvas.view.scale > 4.0:
            for stripe in hatches(wheel):
                canvas.line(placed(stripe, frame), WHITE, 0.6)


def outline(canvas: Canvas, pose: Array, reach: float) -> None:
    """A robot as a pale ring with its heading."""
    canvas.disc(pose[0], pose[1], reach, None, (166, 203, 226))
    canvas.line(np.array([pose[:2], compose(pose, (reach, 0.0, 0.0))[:2]]), (166, 203, 226), 1.2)


def collisions(canvas: Canvas, events: Sequence[Event], until: float = math.inf) -> None:
    """Crosses where something was touched until a time [s]."""
    arm = 5.0 / canvas.view.scale
    for event in events:
        if event.kind == "collision" and event.time <= until:
            x, y = contact(event)
            if math.isfinite(x + y):
                canvas.line(np.array([[x - arm, y - arm], [x + arm, y + arm]]), VERMILION, 2.5)
                canvas.line(np.array([[x - arm, y + arm], [x + arm, y - arm]]), VERMILION, 2.5)


def legend(canvas: Canvas, lines: Sequence[Trace], row: float) -> None:
    """Names of lines beside a piece of each."""
    x = canvas.view.left
    for line in lines:
        ends = np.array([[x, row], [x + 22, row]]) * FINE
        for piece in dashes(ends, *(FINE * d for d in trace_dash(line))) if line.dash else [ends]:
            canvas.draw.line(
                [tuple(p) for p in piece.tolist()], fill=colour(line.colour), width=round(line.width * FINE)
            )
        canvas.text(x + 27, row, line.name, INK)
        x += 27 + canvas.draw.textlength(line.name, font=_font(11 * FINE)) / FINE + 16


def trace(canvas: Canvas, line: Trace) -> None:
    """A line on the floor."""
    canvas.line(line.poses, colour(line.colour), line.width, trace_dash(line) if line.dash else None)


def trace_dash(line: Trace) -> tuple[float, float]:
    """On and off lengths [px] of a dashed line; dots are given a body, as no round caps are drawn."""
    on, off = (float(part) for part in (line.dash or "1 0").split()[:2])
    return max(on, 2.0), off


def dashes(pixels: Array, on: float, off: float) -> list[Array]:
    """A polyline (n, 2) cut into pieces of length `on` with gaps of `off`."""
    steps = np.hypot(*np.diff(pixels, axis=0).T)
    way = np.concatenate([[0.0], np.cumsum(steps)])
    if way[-1] <= 0.0 or on + off <= 0.0:
        return [pixels]
    pieces = []
    for begin in np.arange(0.0, way[-1], on + off):
        end = min(begin + on, way[-1])
        inside = way[(way > begin) & (way < end)]
        s = np.concatenate([[begin], inside, [end]])
        pieces.append(np.column_stack([np.interp(s, way, pixels[:, i]) for i in (0, 1)]))
    return pieces


def colour(text: str) -> Colour:
    """`#rrggbb` as numbers."""
    return int(text[1:3], 16), int(text[3:5], 16), int(text[5:7], 16)


def _name(canvas: Canvas, name: str, x: float, y: float, radius: float) -> None:
    if not name:
        return
    wide = canvas.draw.textlength(name, font=_font(11 * FINE)) / FINE
    inside = wide <= 2.0 * radius * canvas.view.scale
    row = canvas.view.y(y) - (0.0 if inside else radius * canvas.view.scale + 8.0)
    canvas.text(canvas.view.x(x), row, name, INK, anchor="mm")


@lru_cache(maxsize=8)
def _font(size: int) -> Any:
    from PIL import ImageFont

    return ImageFont.load_default(size=size)
