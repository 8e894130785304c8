"""A world from above as SVG: x to the right, y up; SVG's y points down, so signs are turned here."""

import math

from holodrive import svg
from holodrive.types import Pose
from holodrive.worlds.spec import Box, Mover, World

INK, OBSTACLE, WALL, MOVER, START, GOAL = "#333", "#c9c9c9", "#555", "#E69F00", "#0072B2", "#009E73"
Bounds = tuple[float, float, float, float]


def world_svg(world: World, *, size: int = 420, names: bool = True) -> str:
    """A whole picture; its longer side has `size` pixels."""
    x0, y0, x1, y1 = bounds(world)
    scale = size / max(x1 - x0, y1 - y0)
    width, height = (x1 - x0) * scale, (y1 - y0) * scale
    left, top = x0 * scale, -y1 * scale
    ground = svg.element("rect", x=left, y=top, width=width, height=height, fill="#fff")
    view = f"{left:.5g} {top:.5g} {width:.5g} {height:.5g}"
    title = f"{world.name}: {world.title}" if world.title else world.name
    return svg.document(
        width, height, ground, world_shapes(world, scale=scale, names=names), view_box=view, title=title
    )


def bounds(world: World, margin: float = 0.3) -> Bounds:
    """(x0, y0, x1, y1) around all that there is [m], with a margin; 4 m about the start where there is nothing."""
    xs, ys = [world.start.x], [world.start.y]
    if world.goal is not None:
        xs.append(world.goal.pose.x)
        ys.append(world.goal.pose.y)
    if world.size is not None:
        xs += [world.corner[0], world.corner[0] + world.size[0]]
        ys += [world.corner[1], world.corner[1] + world.size[1]]
    for c in world.circles:
        xs += [c.x - c.radius, c.x + c.radius]
        ys += [c.y - c.radius, c.y + c.radius]
    for s in world.segments:
        xs += [s.x1, s.x2]
        ys += [s.y1, s.y2]
    for b in world.boxes:
        xs += [x for x, _ in box_corners(b)]
        ys += [y for _, y in box_corners(b)]
    for m in world.movers:
        xs += [k.x + side * m.radius for k in m.path for side in (-1, 1)]
        ys += [k.y + side * m.radius for k in m.path for side in (-1, 1)]
    least = max(0.0, 2.0 - 0.5 * max(max(xs) - min(xs), max(ys) - min(ys))) if world.size is None else 0.0
    room = margin + least
    return min(xs) - room, min(ys) - room, max(xs) + room, max(ys) + room


def world_shapes(world: World, *, scale: float = 100.0, names: bool = True) -> str:
    """Arena, obstacles, start and goal as one SVG group, `scale` pixels a metre."""
    parts = []
    for c in world.circles:
        parts.append(_disc(c.x, c.y, c.radius, scale, fill=OBSTACLE, stroke=INK))
    for b in world.boxes:
        shape = svg.points((scale * x, -scale * y) for x, y in box_corners(b))
        parts.append(svg.element("polygon", points=shape, fill=OBSTACLE, stroke=INK))
    for s in (*world.segments, *world.border()):
        ends = {"x1": scale * s.x1, "y1": -scale * s.y1, "x2": scale * s.x2, "y2": -scale * s.y2}
        parts.append(svg.element("line", **ends, stroke=WALL, stroke_width=3, stroke_linecap="round"))
    parts += [_mover(mover, scale) for mover in world.movers]
    parts += _ends(world, scale)
    if names:
        parts += _names(world, scale)
    return svg.element("g", *parts, font_family="sans-serif", font_size=10, fill=INK)


def box_corners(box: Box) -> list[tuple[float, float]]:
    """The corners of a box in order [m]."""
    c, s = math.cos(box.theta), math.sin(box.theta)
    u, v = 0.5 * box.length, 0.5 * box.width
    return [(box.x + c * a - s * b, box.y + s * a + c * b) for a, b in ((u, v), (-u, v), (-u, -v), (u, -v))]


def _mover(mover: Mover, scale: float) -> str:
    first = mover.path[0]
    line = svg.points((scale * k.x, -scale * k.y) for k in mover.path)
    path = svg.element("polyline", points=line, fill="none", stroke=MOVER, stroke_dasharray="4 3")
    return path + _disc(first.x, first.y, mover.radius, scale, fill=MOVER, stroke=INK)


def _ends(world: World, scale: float) -> list[str]:
    parts = [_arrow(world.start, scale, START)]
    if world.goal is not None:
        goal = world.goal
        near = goal.tolerance_m
        parts.append(_disc(goal.pose.x, goal.pose.y, near, scale, fill="none", stroke=GOAL, stroke_dasharray="3 2"))
        if goal.heading_matters:
            parts.append(_arrow(goal.pose, scale, GOAL))
        else:
            x, y = scale * goal.pose.x, -scale * goal.pose.y
            cross = f"M{x - 6:.5g} {y:.5g}h12M{x:.5g} {y - 6:.5g}v12"
            parts.append(svg.element("path", d=cross, stroke=GOAL, stroke_width=2))
    return parts


def _names(world: World, scale: float) -> list[str]:
    places = [(c.name, c.x, c.y, c.radius) for c in world.circles]
    places += [(m.name, m.path[0].x, m.path[0].y, m.radius) for m in world.movers]
    below = [
        svg.text(scale * x, scale * (radius - y) + 11.0, name, text_anchor="middle")
        for name, x, y, radius in places
        if name
    ]
    boxes = [svg.text(scale * b.x, 4.0 - scale * b.y, b.name, text_anchor="middle") for b in world.boxes if b.name]
    walls = [
        svg.text(scale * 0.5 * (s.x1 + s.x2) + 6.0, 14.0 - scale * 0.5 * (s.y1 + s.y2), s.name)
        for s in world.segments
        if s.name
    ]
    return below + boxes + walls


def _arrow(pose: Pose, scale: float, colour: str) -> str:
    """A dart of 18 pixels at the pose."""
    x, y = scale * pose.x, -scale * pose.y
    corners = [
        (x + 11.0 * math.cos(pose.theta + turn), y - 11.0 * math.sin(pose.theta + turn))
        for turn in (0.0, 2.5, math.pi, -2.5)
    ]
    corners[2] = (x, y)
    return svg.element("polygon", points=svg.points(corners), fill=colour)


def _disc(x: float, y: float, radius: float, scale: float, **attributes: object) -> str:
    return svg.element("circle", cx=scale * x, cy=-scale * y, r=scale * radius, **attributes)
