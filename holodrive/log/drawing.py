"""A run as a picture: its path over its world. Reports build on these shapes, notebooks show them as they are.

Every element has a class, for pages with a palette of their own, and a light colour for a picture on its own.
"""

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from html import escape
from typing import TYPE_CHECKING

import numpy as np

from holodrive import svg
from holodrive.geometry import compose
from holodrive.log import view as views
from holodrive.log.view import Bounds, View
from holodrive.log.words import joined, ordered, told, words
from holodrive.robots.spec import Robot
from holodrive.types import Array, Event, Pose
from holodrive.worlds.spec import Mover, World

if TYPE_CHECKING:
    from holodrive.log.run import Run

BLUE, ORANGE, GREEN, VERMILION = "#0072B2", "#E69F00", "#009E73", "#D55E00"  # told apart by colour-blind readers
INK, MUTED = "#1d2530", "#5b6675"

_LABEL: dict[str, object] = {
    "class_": "label",
    "font_size": 11,
    "fill": INK,
    "font_family": "sans-serif",
    "text_anchor": "middle",
}


@dataclass(frozen=True)
class Trace:
    """A line on the floor: poses (T, 2 or 3) [m], its name in the legend, its class and its light colour."""

    name: str
    poses: Array
    class_: str
    colour: str
    dash: str | None = None
    width: float = 2.0


def traces(run: "Run") -> list[Trace]:
    """What a run left on the floor: reference, estimate and truth, as far as they are known."""
    lines = [
        Trace("reference", changes(run.reference), "reference", GREEN, "1 5", 2.5),
        Trace("estimate", run.estimate, "estimate", ORANGE, "6 4", 1.8),
        Trace("true path", run.pose, "truth", BLUE, None, 2.2),
    ]
    return [line for line in lines if np.isfinite(line.poses[:, :2]).all(axis=1).any()]


def changes(poses: Array) -> Array:
    """Poses without repetitions of the one before: waypoints stand out, standing costs nothing."""
    if len(poses) < 2:
        return poses
    same = (poses[1:, :2] == poses[:-1, :2]).all(axis=1) | np.isnan(poses[1:, :2]).any(axis=1)
    return np.asarray(poses[np.concatenate([[True], ~same])])


def best_pose(run: "Run") -> Array:
    """The true poses (T, 3), or the believed ones where no truth is known."""
    return run.pose if np.isfinite(run.pose).all(axis=-1).any() else run.estimate


def mover_place(mover: Mover, time: Array) -> Array:
    """Places (..., 2) [m] of a moving obstacle at times (...) [s]."""
    frames = np.array([(k.time, k.x, k.y) for k in mover.path], dtype=np.float64)
    time = np.asarray(time, dtype=np.float64)
    if mover.loop and frames[-1, 0] > frames[0, 0]:
        time = frames[0, 0] + np.mod(time - frames[0, 0], frames[-1, 0] - frames[0, 0])
    return np.stack([np.interp(time, frames[:, 0], frames[:, i]) for i in (1, 2)], axis=-1)


def bounds_of(runs: Sequence["Run"]) -> Bounds:
    """The piece of floor worth showing: the world, or the run alone where the world is far larger than the run."""
    reach = max((run.robot.footprint_radius_m for run in runs), default=0.1)
    driven = views.around([poses for run in runs for poses in (run.pose, run.estimate, run.reference)], 1.6 * reach)
    world = next((run.world for run in runs if run.world is not None), None)
    if world is None:
        return views.union(driven)
    around = views.union(driven, extent(world))
    if driven is None:
        return around
    wide = max(driven[2] - driven[0], driven[3] - driven[1])
    if max(around[2] - around[0], around[3] - around[1]) <= 5.0 * wide:
        return around
    return (driven[0] - 0.5 * wide, driven[1] - 0.5 * wide, driven[2] + 0.5 * wide, driven[3] + 0.5 * wide)


def extent(world: World) -> Bounds | None:
    """The box about everything in a world [m]; None for a floor with nothing on it."""
    box = None
    if world.size is not None:
        (x, y), (w, h) = world.corner, world.size
        edge = 0.02 * max(w, h) if world.walls else 0.0
        box = (x - edge, y - edge, x + w + edge, y + h + edge)
    rounds = [(c.x, c.y, c.radius) for c in world.circles]
    rounds += [(b.x, b.y, 0.5 * math.hypot(b.length, b.width)) for b in world.boxes]
    rounds += [(k.x, k.y, m.radius) for m in world.movers for k in m.path]
    boxes = [(x - r, y - r, x + r, y + r) for x, y, r in rounds]
    ends = [np.array([[s.x1, s.y1], [s.x2, s.y2]]) for s in world.segments]
    if box is None and not boxes and not ends:
        return None
    return views.union(box, views.around(ends, 0.0), *boxes)


def world_shapes(world: World, view: View, until: float = 0.0) -> str:
    """Walls, obstacles with their names, and where moving obstacles went until a time [s]."""
    fill: dict[str, object] = {"class_": "obstacle", "fill": "#c3cad3", "stroke": "#6b7684", "stroke_width": 1}
    parts = [mover_shape(mover, view, until) for mover in world.movers]
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
        svg.element("polygon", class_="body", points=hull, fill="#fff", fill_opacity=0.65, stroke=INK,
                    stroke_opacity=0.5, stroke_linejoin="round", vector_effect=thin),
        svg.element("polygon", class_="nose", points=nose, fill=BLUE),
    ]  # fmt: skip
    angles = dict(zip(robot.steered, np.zeros(len(robot.steered)) if steer is None else steer, strict=False))
    for i, wheel in enumerate(robot.wheels):
        turn = wheel.yaw + float(np.nan_to_num(angles.get(i, 0.0)))
        parts.append(
            svg.element(
                "g", _tyre(wheel.radius, wheel.width, wheel.roller if wheel.kind != "swerve" else None),
                class_="wheel", data_wheel=i,
                transform=f"translate({wheel.x:.4f} {wheel.y:.4f})rotate({math.degrees(turn):.2f})",
            )
        )  # fmt: skip
    return "".join(parts)


def _tyre(radius: float, width: float, roller: float | None) -> str:
    """One wheel from above, rolling along x; stripes lie along the axis of the roller that touches the ground."""
    thin = "non-scaling-stroke"
    tyre = svg.element("rect", class_="tyre", x=-radius, y=-0.5 * width, width=2 * radius, height=width,
                       rx=0.15 * width, fill="#3c4654", stroke=INK, vector_effect=thin)  # fmt: skip
    if roller is None:
        arrow = f"M{-0.6 * radius:.4f} 0H{0.6 * radius:.4f}"
        return tyre + svg.element("path", class_="roller", d=arrow, stroke="#fff", fill="none", vector_effect=thin)
    return tyre + svg.element("path", class_="roller", d=_stripes(radius, 0.5 * width, roller), stroke="#fff",
                              stroke_width=1, fill="none", vector_effect=thin)  # fmt: skip


def _stripes(radius: float, half: float, roller: float) -> str:
    """Lines at the angle `roller` inside the rectangle |x| < radius, |y| < half."""
    c, s = math.cos(roller), math.sin(roller)
    lines = []
    for k in np.linspace(-0.8, 0.8, 5):
        if abs(s) < 0.2:  # rollers along the rolling direction: short dashes one behind the other
            x, y, length = k * radius, 0.45 * half * (-1 if round(5 * k) % 2 else 1), 0.14 * radius
        else:
            x, y, length = k * radius, 0.0, 0.85 * half / abs(s)
        ends = np.array([(x - length * c, y - length * s), (x + length * c, y + length * s)])
        ends[:, 0] = np.clip(ends[:, 0], -radius, radius)
        lines.append(f"M{ends[0, 0]:.4f} {ends[0, 1]:.4f}L{ends[1, 0]:.4f} {ends[1, 1]:.4f}")
    return "".join(lines)


def moments(poses: Array, reach: float, most: int = 9) -> list[int]:
    """Indices of poses spread evenly over the way, first and last among them, so far apart that bodies stay apart."""
    good = np.flatnonzero(np.isfinite(poses).all(axis=-1))
    if not len(good):
        return []
    steps = np.hypot(*np.diff(poses[good, :2], axis=0).T)
    way = np.concatenate([[0.0], np.cumsum(steps)])
    count = int(np.clip(way[-1] / max(2.2 * reach, 1e-6), 1, most))
    return [int(i) for i in dict.fromkeys(good[np.searchsorted(way, np.linspace(0.0, way[-1], count + 1))])]


def ghost_shape(robot: Robot, class_: str = "ghost") -> str:
    """A robot as a pale outline with its heading, in metres in `base_link`."""
    reach, thin = robot.footprint_radius_m, "non-scaling-stroke"
    return svg.element("circle", class_=class_, r=reach, fill=BLUE, fill_opacity=0.05, stroke=BLUE, stroke_opacity=0.4,
                       vector_effect=thin) + svg.element(
        "path", class_=class_, d=f"M0 0H{reach:.4f}", stroke=BLUE, stroke_opacity=0.6, vector_effect=thin
    )  # fmt: skip


def collision_shapes(events: Iterable[Event], view: View) -> str:
    """A cross where something was touched."""
    marks = []
    for event in events:
        if event.kind != "collision":
            continue
        x, y = (float(event.data.get(k, getattr(event.pose, k))) for k in ("x", "y"))
        if not (math.isfinite(x) and math.isfinite(y)):
            continue
        px, py = view.x(x), view.y(y)
        d = f"M{px - 5:.1f} {py - 5:.1f}l10 10m0 -10l-10 10"
        title = svg.element("title", escape(f"{event.time:.2f} s: {event.text}"))
        marks.append(
            svg.element("path", title, class_="collision", d=d, stroke=VERMILION, stroke_width=2.5, fill="none")
        )
    return "".join(marks)


def legend(lines: Sequence[Trace], left: float, row: float, extra: Sequence[tuple[str, str]] = ()) -> str:
    """Names of lines beside a piece of each, in one row; `extra` are pairs (mark, name)."""
    parts, x = [], left
    for line in lines:
        parts.append(
            svg.element("path", class_=line.class_, d=f"M{x:.1f} {row - 4:.1f}h22", stroke=line.colour,
                        stroke_width=line.width, stroke_dasharray=line.dash, fill="none", stroke_linecap="round")
            + svg.text(x + 27, row, line.name, **(_LABEL | {"text_anchor": "start"}))
        )  # fmt: skip
        x += 27 + text_width(line.name) + 16
    for mark, name in extra:
        parts.append(
            mark.format(x=x + 5, y=row - 4) + svg.text(x + 14, row, name, **(_LABEL | {"text_anchor": "start"}))
        )
        x += 14 + text_width(name) + 16
    return svg.element("g", *parts, class_="legend") if parts else ""


def text_width(content: str, size: float = 11.0) -> float:
    """About how wide a text is [px]; there is no font to measure here."""
    return 0.56 * size * len(content)


def picture(run: "Run", width: float = 640.0, height: float = 560.0) -> str:
    """The path of a run over its world as one SVG document."""
    return scene(run, View.fit(bounds_of([run]), width, height, header=26.0))


def scene(run: "Run", view: View, over: str = "") -> str:
    """The picture in a given view; `over` is drawn on top, inside the plot area."""
    lines, poses, world = traces(run), best_pose(run), run.world
    shown = moments(poses, run.robot.footprint_radius_m)
    ghosts = [view.place(Pose(*poses[i]), ghost_shape(run.robot), class_="moment") for i in shown[:-1]]
    return framed(
        view,
        lines,
        described(run),
        goal_shape(world, view) if world else "",
        world_shapes(world, view, float(run.time[-1]) if len(run.time) else 0.0) if world else "",
        *ghosts,
        last_robot(run, view, "last"),
        *(drawn(line, view) for line in lines),
        collision_shapes(run.events, view),
        over,
    )


def framed(view: View, lines: Sequence[Trace], title: str, *children: str) -> str:
    """A document with grid, numbers, scale bar and legend about children cut at the plot area."""
    wide, high = view.picture
    wide = max(wide, view.left + sum(43 + text_width(line.name) for line in lines))
    frame = (views.axis_names(view), views.scale_bar(view), legend(lines, view.left, 18.0))
    return svg.document(wide, high, views.grid(view), clipped(view, *children), *frame, title=title, class_="scene")


def drawn(line: Trace, view: View) -> str:
    """A trace on the floor."""
    return view.path(
        line.poses, class_=line.class_, stroke=line.colour, stroke_width=line.width, stroke_dasharray=line.dash,
        stroke_linecap="round", stroke_linejoin="round",
    )  # fmt: skip


def last_robot(run: "Run", view: View, class_: str) -> str:
    """The robot where it was last known to be."""
    poses = best_pose(run)
    good = np.flatnonzero(np.isfinite(poses).all(axis=-1))
    if not len(good):
        return ""
    steer = run.steer[good[-1]] if run.steer.shape[1] else None
    return view.place(Pose(*poses[good[-1]]), robot_shape(run.robot, steer), class_=class_)


def clipped(view: View, *children: str) -> str:
    """Children cut at the border of the plot area, by an inner SVG so that no id is needed."""
    box = f"{view.left:.2f} {view.top:.2f} {view.width:.2f} {view.height:.2f}"
    return svg.element("svg", *children, x=view.left, y=view.top, width=view.width, height=view.height, viewBox=box)


def described(run: "Run") -> str:
    """One sentence for those who cannot see the picture."""
    where = run.world.name if run.world else "an open floor"
    poses = best_pose(run)
    good = poses[np.isfinite(poses).all(axis=-1)]
    if not len(good):
        return f"Path of {run.robot.name} on {where}: no pose is known."
    (x0, y0), (x1, y1) = good[0, :2], good[-1, :2]
    return f"Path of {run.robot.name} on {where} from ({x0:.2f}, {y0:.2f}) m to ({x1:.2f}, {y1:.2f}) m."


def notebook(run: "Run") -> str:
    """Metrics and picture of a run as a piece of HTML, for notebooks."""
    rows = []
    for name in ordered(run.metrics):
        unit, (value,) = told(name, [run.metrics[name]])
        rows.append(f"<tr><td>{escape(words(name).label)}</td><td>{escape(joined(value, unit))}</td></tr>")
    controller = run.settings.get("controller", "")
    title = " · ".join(str(part) for part in (run.robot.name, run.world and run.world.name, controller) if part)
    return (
        f"<figure><figcaption><b>{escape(title)}</b></figcaption>{picture(run, 480, 420)}"
        f"<table>{''.join(rows)}</table></figure>"
    )


def _name(name: str, x: float, y: float, room: float, above: float) -> str:
    """The name of a thing: inside when it fits, above it otherwise."""
    if not name:
        return ""
    inside = text_width(name) <= room
    halo = {"class_": "label halo", "stroke": "#fff", "stroke_width": 3, "stroke_linejoin": "round"}
    look = _LABEL if inside else _LABEL | halo
    return svg.text(x, y + 4 if inside else y - above - 5, name, paint_order="stroke", **look)
