"""What stands and moves on a floor as SVG: obstacles, moving obstacles, goals, robots, collisions.

Every element has a class, for pages with a palette of their own, and a light colour for a picture on its own.
"""

import math
from collections.abc import Iterable
from html import escape

import numpy as np

from holodrive import svg
from holodrive.geometry import compose
from holodrive.log.view import View
from holodrive.robots.drawing import hatches
from holodrive.robots.spec import Robot, WheelSpec
from holodrive.types import Array, Event, Pose
from holodrive.worlds.spec import Mover, World

BLUE, ORANGE, GREEN, VERMILION = "#0072B2", "#E69F00", "#009E73", "#D55E00"  # told apart by colour-blind readers
INK, MUTED = "#1d2530", "#5b6675"

LABEL: dict[str, object] = {
    "class_": "label",
    "font_size": 11,
    "fill": INK,
    "font_family": "sans-serif",
    "text_anchor": "middle",
}


def mover_place(mover: Mover, time: Array) -> Array:
    """Places (..., 2) [m] of a moving obstacle at times (...) [s]."""
    frames = np.array([(k.time, k.x, k.y) for k in mover.path], dtype=np.float64)
    time = np.asarray(time, dtype=np.float64)
    if mover.loop and frames[-1, 0] > frames[0, 0]:
        again = frames[0, 0] + np.mod(time - frames[0, 0], frames[-1, 0] - frames[0, 0])
        time = np.where(time > frames[0, 0], again, time)
    return np.stack([np.interp(time, frames[:, 0], frames[:, i]) for i in (1, 2)], axis=-1)


def world_shapes(world: World, view: View, until: float = 0.0, *, moving: bool = True) -> str:
    """Walls, obstacles with their names, and where moving obstacles went until a time [s]."""
    fill: dict[str, object] = {"class_": "obstacle", "fill": "#c3cad3", "stroke": "#6b7684", "stroke_width": 1}
    parts = [mover_shape(mover, view, until) for mover in world.movers if moving]
    labels = []
    for circle in world.circles:
        cx, cy, radius = view.x(circle.x), view.y(circle.y), circle.radius * view.scale
        parts.append(svg.element("circle", cx=cx, cy=cy, r=radius, **fill))
        labels.append(_name(circle.name, cx, cy, 2 * radius, radius))
    for box in world.boxes:
        rect = svg.element(
            "rect", x=-0.5 * box.length, y=-0.5 * box.width, width=box.length, height=box.width,
            vector_effect="non-scaling-stroke", **fill,
        )  # fmt: skip
        parts.append(view.place(Pose(box.x, box.y, box.theta), rect))
        labels.append(
            _name(
                box.name,
                view.x(box.x),
                view.y(box.y),
                view.scale * min(box.length, box.width),
                0.5 * view.scale * min(box.length, box.width),
            )
        )
    walls = [*world.border(), *world.segments]
    if walls:
        d = "".join(svg.path_data(view.pixels(np.array([[wall.x1, wall.y1], [wall.x2, wall.y2]]))) for wall in walls)
        parts.append(
            svg.element(
                "path", class_="wall", d=d, stroke="#3c4654", stroke_width=3, stroke_linecap="square", fill="none"
            )
        )
    labels += [
        _name(s.name, view.x(0.5 * (s.x1 + s.x2)), view.y(0.5 * (s.y1 + s.y2)), 0.0, 4.0) for s in world.segments
    ]
    return "".join(parts) + "".join(labels)


def mover_shape(mover: Mover, view: View, until: float) -> str:
    """The trace of a moving obstacle with an outline where it began and a body where it is at the end."""
    first = mover.path[0].time
    ends = mover_place(mover, np.array([0.0, until]))
    keys = np.array([k.time for k in mover.path])
    period = keys[-1] - first if mover.loop else 0.0
    rounds = np.arange(min(math.ceil(until / period), 2)) if period > 0.0 else np.zeros(1)
    times = np.unique(np.concatenate([[0.0, until], *(keys + n * period for n in rounds)]))
    radius = mover.radius * view.scale
    trace = view.path(
        mover_place(mover, times[(times >= 0.0) & (times <= until)]),
        class_="mover-trace", stroke="#8a5a9e", stroke_width=1.5, stroke_dasharray="2 4",
    )  # fmt: skip
    (x0, y0), (x1, y1) = view.pixels(ends)
    outline = svg.element("circle", class_="mover-start", cx=x0, cy=y0, r=radius, fill="none", stroke="#8a5a9e",
                          stroke_dasharray="3 3")  # fmt: skip
    body = svg.element("circle", class_="mover", cx=x1, cy=y1, r=radius, fill="#d9c6e2", stroke="#8a5a9e")
    return trace + outline + svg.element("g", body, _name(mover.name, x1, y1, 2 * radius, radius), class_="last")


def goal_shape(world: World, view: View) -> str:
    """Start and goal: a small ring, and a target with the tolerance and, where it matters, the heading."""
    x, y = view.x(world.start.x), view.y(world.start.y)
    parts = [svg.element("circle", class_="start", cx=x, cy=y, r=4, fill="#fff", stroke=INK, stroke_width=1.5)]
    if world.goal is not None:
        pose = world.goal.pose
        x, y = view.x(pose.x), view.y(pose.y)
        ring = max(6.0, world.goal.tolerance_m * view.scale)
        cross = f"M{x - ring - 4:.1f} {y:.1f}h{2 * ring + 8:.1f}M{x:.1f} {y - ring - 4:.1f}v{2 * ring + 8:.1f}"
        mark: dict[str, object] = {"class_": "goal", "fill": "none", "stroke": GREEN, "stroke_width": 1.8}
        parts += [svg.element("circle", cx=x, cy=y, r=ring, **mark), svg.element("path", d=cross, **mark)]
        if world.goal.heading_matters:
            tip = compose(pose, (2.2 * (ring + 4) / view.scale, 0.0, 0.0))
            parts.append(view.path(np.array([pose[:2], tip[:2]]), **mark))
    return "".join(parts)


def robot_shape(robot: Robot, steer: Array | None = None) -> str:
    """A robot from above in metres in `base_link` (y up): outline, heading, wheels with the rollers at the ground.

    Args:
        robot: as described.
        steer: (m,) steering angles [rad]; zero when not known.
    """
    reach, thin = robot.footprint_radius_m, "non-scaling-stroke"
    hull = svg.points([(w.x, w.y) for w in sorted(robot.wheels, key=lambda w: math.atan2(w.y, w.x))])
    nose = svg.points([(0.34 * reach, -0.16 * reach), (0.34 * reach, 0.16 * reach), (0.66 * reach, 0.0)])
    parts = [
        svg.element("circle", class_="footprint", r=reach, fill="#0072B2", fill_opacity=0.12, stroke=BLUE,
                    stroke_opacity=0.7, vector_effect=thin),
        svg.element("polygon", class_="body", points=hull, fill="#fff", fill_opacity=0.45, stroke=INK,
                    stroke_opacity=0.5, stroke_linejoin="round", vector_effect=thin),
        svg.element("polygon", class_="nose", points=nose, fill=BLUE),
    ]  # fmt: skip
    angles = dict(zip(robot.steered, np.zeros(len(robot.steered)) if steer is None else steer, strict=False))
    for i, wheel in enumerate(robot.wheels):
        turn = wheel.yaw + float(np.nan_to_num(angles.get(i, 0.0)))
        parts.append(
            svg.element(
                "g", _tyre(wheel),
                class_="wheel", data_wheel=i,
                transform=f"translate({wheel.x:.4f} {wheel.y:.4f})rotate({math.degrees(turn):.2f})",
            )
        )  # fmt: skip
    return "".join(parts)


def _tyre(wheel: WheelSpec) -> str:
    """One wheel from above, rolling along x; stripes lie along the axis of the roller that touches the ground."""
    thin, r, width = "non-scaling-stroke", wheel.radius, wheel.width
    tyre = svg.element("rect", class_="tyre", x=-r, y=-0.5 * width, width=2 * r, height=width,
                       rx=0.15 * width, fill="#3c4654", stroke=INK, vector_effect=thin)  # fmt: skip
    stripes = [((-0.6 * r, 0.0), (0.6 * r, 0.0))] if wheel.kind == "swerve" else hatches(wheel)
    d = "".join(f"M{a[0]:.4f} {a[1]:.4f}L{b[0]:.4f} {b[1]:.4f}" for a, b in stripes)
    return tyre + svg.element("path", class_="roller", d=d, stroke="#fff", fill="none", vector_effect=thin)


def ghost_shape(robot: Robot, class_: str = "ghost") -> str:
    """A robot as a pale outline with its heading, in metres in `base_link`."""
    reach, thin = robot.footprint_radius_m, "non-scaling-stroke"
    return svg.element("circle", class_=class_, r=reach, fill=BLUE, fill_opacity=0.05, stroke=BLUE, stroke_opacity=0.4,
                       vector_effect=thin) + svg.element(
        "path", class_=class_, d=f"M0 0H{reach:.4f}", stroke=BLUE, stroke_opacity=0.6, vector_effect=thin
    )  # fmt: skip


def contact(event: Event) -> tuple[float, float]:
    """Where it happened [m]: the place of contact, or the robot's where none is known."""
    x, y = event.data.get("place", event.pose[:2])
    return float(x), float(y)


def collision_shapes(events: Iterable[Event], view: View) -> str:
    """A cross where something was touched."""
    marks = []
    for event in events:
        if event.kind != "collision":
            continue
        x, y = contact(event)
        if not (math.isfinite(x) and math.isfinite(y)):
            continue
        px, py = view.x(x), view.y(y)
        d = f"M{px - 5:.1f} {py - 5:.1f}l10 10m0 -10l-10 10"
        title = svg.element("title", escape(f"{event.time:.2f} s: {event.text}"))
        marks.append(
            svg.element("path", title, class_="collision", d=d, stroke=VERMILION, stroke_width=2.5, fill="none")
        )
    return "".join(marks)


def text_width(content: str, size: float = 11.0) -> float:
    """About how wide a text is [px]; there is no font to measure here."""
    return 0.56 * size * len(content)


def _name(name: str, x: float, y: float, room: float, above: float) -> str:
    """The name of a thing: inside when it fits, above it otherwise."""
    if not name:
        return ""
    inside = text_width(name) <= room
    halo = {"class_": "label halo", "stroke": "#fff", "stroke_width": 3, "stroke_linejoin": "round"}
    look = LABEL if inside else LABEL | halo
    return svg.text(x, y + 4 if inside else y - above - 5, name, paint_order="stroke", **look)
