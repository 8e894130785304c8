"""A run as a picture: its path over its world. Reports build on this, notebooks show it as it is."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from html import escape
from typing import TYPE_CHECKING

import numpy as np

from holodrive import svg
from holodrive.log import view as views
from holodrive.log.shapes import (
    BLUE,
    GREEN,
    LABEL,
    ORANGE,
    collision_shapes,
    ghost_shape,
    goal_shape,
    robot_shape,
    text_width,
    world_shapes,
)
from holodrive.log.view import Bounds, View
from holodrive.log.words import joined, ordered, told, words
from holodrive.types import Array, Pose
from holodrive.worlds.spec import World

if TYPE_CHECKING:
    from holodrive.log.run import Run


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


def moments(poses: Array, reach: float, most: int = 9) -> list[int]:
    """Indices of poses spread evenly over the way, first and last among them, so far apart that bodies stay apart."""
    good = np.flatnonzero(np.isfinite(poses).all(axis=-1))
    if not len(good):
        return []
    steps = np.hypot(*np.diff(poses[good, :2], axis=0).T)
    way = np.concatenate([[0.0], np.cumsum(steps)])
    count = int(np.clip(way[-1] / max(2.2 * reach, 1e-6), 1, most))
    return [int(i) for i in dict.fromkeys(good[np.searchsorted(way, np.linspace(0.0, way[-1], count + 1))])]


def legend(lines: Sequence[Trace], left: float, row: float, extra: Sequence[tuple[str, str]] = ()) -> str:
    """Names of lines beside a piece of each, in one row; `extra` are pairs (mark, name)."""
    parts, x = [], left
    for line in lines:
        parts.append(
            svg.element("path", class_=line.class_, d=f"M{x:.1f} {row - 4:.1f}h22", stroke=line.colour,
                        stroke_width=line.width, stroke_dasharray=line.dash, fill="none", stroke_linecap="round")
            + svg.text(x + 27, row, line.name, **(LABEL | {"text_anchor": "start"}))
        )  # fmt: skip
        x += 27 + text_width(line.name) + 16
    for mark, name in extra:
        parts.append(
            mark.format(x=x + 5, y=row - 4) + svg.text(x + 14, row, name, **(LABEL | {"text_anchor": "start"}))
        )
        x += 14 + text_width(name) + 16
    return svg.element("g", *parts, class_="legend") if parts else ""


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
