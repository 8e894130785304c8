"""One scan of a run: as the lidar saw it, and on the floor beside what really stands there."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from html import escape
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from holodrive import perception, svg
from holodrive.errors import InputError
from holodrive.geometry import compose
from holodrive.log import view as views
from holodrive.log.drawing import Trace, best_pose, bounds_of, drawn, framed
from holodrive.log.run import Run
from holodrive.log.shapes import BLUE, GREEN, LABEL, ORANGE, VERMILION, ghost_shape, mover_place, world_shapes
from holodrive.log.view import View
from holodrive.reports import parts
from holodrive.reports.replay import pose_at
from holodrive.svg import number
from holodrive.types import Array, Pose, Scan
from holodrive.worlds.spec import Circle, World

if TYPE_CHECKING:
    from holodrive.perception import Cluster, Sectors

NEAR_M = 0.1  # mean distance of a cluster's points from a round obstacle's edge, below which it is that obstacle
_NUMBER = LABEL | {"class_": "number", "fill": "#5b6675"}
_SECTORS = ("DH", "DL", "DR")


class Fit(NamedTuple):
    """A cluster in the world, and the round obstacle that it shows, None when it shows none."""

    x: float
    y: float
    radius: float
    seen: int
    truth: Circle | None

    @property
    def centre_error_m(self) -> float:
        """Distance of the centres; NaN without an obstacle to compare."""
        return math.hypot(self.x - self.truth.x, self.y - self.truth.y) if self.truth else math.nan

    @property
    def radius_error_m(self) -> float:
        """Fitted less true radius; NaN without an obstacle to compare."""
        return self.radius - self.truth.radius if self.truth else math.nan


@dataclass(frozen=True)
class Look:
    """One scan and what perception makes of it.

    Attributes:
        scan: as recorded.
        pose: of the robot at the scan's stamp, in the map; NaN when it is not known.
        points: (k, 2) valid, de-skewed points in `base_link` [m].
        sectors: least distances ahead, left, right from the robot's centre [m].
        clusters: in `base_link`.
        fits: the same in the map, each with the obstacle that it shows; empty without a pose.
    """

    scan: Scan
    pose: Pose
    points: Array
    sectors: tuple[float, float, float]
    clusters: "tuple[Cluster, ...]"
    fits: tuple[Fit, ...]


@dataclass(frozen=True)
class LidarSection:
    """One scan of a run.

    Attributes:
        run: with scans.
        time_s: the scan whose stamp is nearest to it; None takes the one with the nearest return.
        name: heading.
    """

    run: Run
    time_s: float | None = None
    name: str = ""

    @property
    def title(self) -> str:
        """The heading."""
        return self.name or f"Lidar of {self.run.robot.name}"

    def html(self) -> str:
        """What stands under the heading."""
        return lidar_html(self.run, self.time_s)

    def _repr_html_(self) -> str:
        """For notebooks: the page of this section alone."""
        from holodrive.reports.page import report

        return report(self)._repr_html_()


def lidar_html(run: Run, time_s: float | None = None) -> str:
    """Both pictures of a scan and the numbers of its fits; a line where nothing was scanned."""
    if not run.scans:
        return parts.note("No scan was recorded.")
    one = look(run, time_s)
    dh, dl, dr = (f"{number(d, 2)} m" for d in one.sectors)
    facts = {"time": f"{number(one.scan.stamp, 2)} s", "ahead (DH)": dh, "left (DL)": dl, "right (DR)": dr}
    beams, good = len(one.scan.ranges), int(np.isfinite(one.scan.ranges).sum())
    facts |= {"beams": str(beams), "with a return": str(good), "clusters": str(len(one.clusters))}
    pictures = [polar_svg(one)] + ([floor_svg(run, one)] if np.isfinite(one.pose).all() else [])
    figures = "".join(f"<figure>{picture}</figure>" for picture in pictures)
    return parts.fact_list(facts) + f'<div class="charts two">{figures}</div>' + _fit_table(one.fits)


def look(run: Run, time_s: float | None = None) -> Look:
    """A scan of a run, read as a controller reads it.

    Raises:
        InputError: no scan was recorded.
    """
    if not run.scans:
        raise InputError("the run has no scans; a robot with a lidar records them")
    if time_s is None:
        nearest = [np.min(s.ranges, initial=np.inf, where=np.isfinite(s.ranges) & (s.ranges > 0.0)) for s in run.scans]
        scan = run.scans[int(np.argmin(nearest))]
    else:
        scan = run.scans[int(np.argmin([abs(s.stamp - time_s) for s in run.scans]))]
    poses = best_pose(run)
    pose = Pose(*pose_at(np.array(scan.stamp), run.time, poses).tolist())
    twist = _twist(run, scan.stamp)
    points = perception.points(scan, twist)
    step = abs(float(scan.angles[1] - scan.angles[0])) if len(scan.angles) > 1 else math.radians(1.0)
    found = perception.clusters(points, step_rad=step)
    return Look(scan, pose, points, perception.sectors(scan, twist=twist), found, _fits(run, pose, scan.stamp, found))


def polar_svg(one: Look, limits: "Sectors | None" = None, size: float = 460.0) -> str:
    """The scan about the robot, ahead is up: returns, sectors with their nearest return, fitted circles."""
    limits = limits or perception.Sectors()
    distances = np.linalg.norm(one.points, axis=1)
    reach = max(1.05 * float(distances.max(initial=0.5)), 0.5)
    to = _Polar(0.5 * size, 0.5 * size + 14.0, (0.5 * size - 34.0) / reach)
    rings, decimals = svg.ticks(0.0, reach, 4)
    marks = []
    for ring in rings[rings > 0.0].tolist():
        marks.append(svg.element("circle", class_="grid", cx=to.x, cy=to.y, r=ring * to.scale, fill="none",
                                 stroke="#e3e6ea"))  # fmt: skip
        marks.append(svg.text(to.x + 4, to.y + ring * to.scale - 4, f"{svg.number(ring, decimals)} m",
                              **(_NUMBER | {"text_anchor": "start"})))  # fmt: skip
    edges = ((-limits.th4_deg, -limits.th1_deg), (-limits.th3_deg, -limits.th4_deg), (-limits.th1_deg, -limits.th2_deg))
    for i, (limit, distance) in enumerate(zip(edges, one.sectors, strict=True)):
        marks.append(_sector(to, i, limit, min(distance, reach), reach))
    dots = "".join(svg.path_data(to.pixels(p[None, :])) for p in one.points)
    marks.append(svg.element("path", class_="hits", d=dots, stroke=VERMILION, stroke_width=3, stroke_linecap="round",
                             fill="none"))  # fmt: skip
    marks += [
        svg.element("circle", class_="truth", cx=float(x), cy=float(y), r=c.radius * to.scale, fill="none",
                    stroke=BLUE, stroke_width=1.5, stroke_dasharray="4 3")
        for c in one.clusters if _is_round(c)
        for x, y in to.pixels(np.array([[c.x, c.y]]))
    ]  # fmt: skip
    nose = svg.points([(to.x, to.y - 9), (to.x - 6, to.y + 6), (to.x + 6, to.y + 6)])
    marks.append(svg.element("polygon", class_="nose", points=nose, fill=BLUE))
    marks += [
        _sector_name(to, limit, reach, f"{name} {number(distance, 2)} m")
        for limit, distance, name in zip(edges, one.sectors, _SECTORS, strict=True)
    ]
    bold = {"class_": "chart-title", "font_size": 13, "font_weight": 600, "text_anchor": "start"}
    title = svg.text(8, 17, f"Scan at {number(one.scan.stamp, 2)} s, ahead is up", **(LABEL | bold))
    said = ", ".join(f"{n} {number(d, 2)} m" for n, d in zip(_SECTORS, one.sectors, strict=True))
    words = f"Polar scan at {one.scan.stamp:.2f} s with {len(one.points)} returns: {said}."
    return svg.document(size, size + 14.0, title, *marks, title=words, class_="scan")


def floor_svg(run: Run, one: Look, width: float = 460.0, height: float = 480.0) -> str:
    """The scan's points in the world, and the circles fitted to them beside the obstacles that are there."""
    place = compose(one.pose, np.column_stack([one.points, np.zeros(len(one.points))]))[:, :2]
    seen = views.around([place], 0.05)
    view = View.fit(views.union(seen, bounds_of([run])), width, height, header=26.0)
    dots = "".join(svg.path_data(p[None, :]) for p in view.pixels(place))
    fitted = [
        svg.element("circle", class_="truth", cx=view.x(f.x), cy=view.y(f.y), r=f.radius * view.scale, fill="none",
                    stroke=BLUE, stroke_width=2, stroke_dasharray="4 3")
        for f in one.fits if math.isfinite(f.radius)
    ]  # fmt: skip
    poses = best_pose(run)
    before = Trace("path", poses[run.time <= one.scan.stamp], "estimate", ORANGE, None, 1.6)
    legend = [before, Trace("fitted circle", np.empty((0, 3)), "truth", BLUE, "4 3", 2.0),
              Trace("scan", np.empty((0, 3)), "hits", VERMILION, "0.1 5", 3.0)]  # fmt: skip
    return framed(
        view,
        legend,
        f"Scan at {one.scan.stamp:.2f} s on the floor with {len(fitted)} fitted circles.",
        world_shapes(run.world, view, one.scan.stamp) if run.world else "",
        drawn(before, view),
        view.place(one.pose, ghost_shape(run.robot)),
        svg.element("path", class_="hits", d=dots, stroke=VERMILION, stroke_width=3, stroke_linecap="round"),
        *fitted,
    )


class _Polar(NamedTuple):
    """The robot's place on the picture [px] and its scale [px/m]."""

    x: float
    y: float
    scale: float

    def pixels(self, xy: Array) -> Array:
        """Pixels (n, 2) of places (n, 2) in `base_link`: ahead is up, left is left."""
        return np.stack([self.x - self.scale * xy[:, 1], self.y - self.scale * xy[:, 0]], axis=-1)

    def arc(self, start_deg: float, end_deg: float, radius: float) -> Array:
        """(n, 2) pixels of an arc, counter-clockwise angles from ahead."""
        if start_deg < end_deg - 180.0 or end_deg < start_deg - 180.0:
            start_deg += 360.0 * (1.0 if start_deg < end_deg else -1.0)
        angle = np.radians(np.linspace(start_deg, end_deg, 24))
        return self.pixels(radius * np.stack([np.cos(angle), np.sin(angle)], axis=-1))


def _sector(to: _Polar, index: int, limits: tuple[float, float], distance: float, reach: float) -> str:
    """The limits of a sector, filled as far as its nearest return."""
    hub, colour = (to.x, to.y), (BLUE, ORANGE, GREEN)[index]
    rim = to.arc(*limits, reach)
    rays = svg.path_data(np.vstack([rim[:1], hub, rim[-1:]]))
    filled = svg.path_data(np.vstack([hub, to.arc(*limits, distance), hub])) + "z"
    line: dict[str, object] = {"stroke": colour, "stroke_opacity": 0.5, "stroke_dasharray": "2 4"}
    return svg.element("path", d=rays, fill="none", **line) + svg.element(
        "path", d=filled, fill=colour, fill_opacity=0.25, stroke=colour
    )


def _sector_name(to: _Polar, limits: tuple[float, float], reach: float, label: str) -> str:
    """Far enough out that the names of neighbours stay apart."""
    x, y = to.arc(*limits, 0.68 * reach)[12].tolist()
    halo: dict[str, object] = {"class_": "label halo", "stroke": "#fff", "stroke_width": 3, "paint_order": "stroke"}
    return svg.text(x, y, label, **(LABEL | halo))


def _twist(run: Run, time: float) -> tuple[float, float, float]:
    """Body twist at a time; standing where it is not known."""
    if not len(run.time):
        return 0.0, 0.0, 0.0
    row = run.twist[int(np.argmin(np.abs(run.time - time)))]
    vx, vy, omega = np.nan_to_num(row).tolist()
    return vx, vy, omega


def _fits(run: Run, pose: Pose, time: float, found: "Sequence[Cluster]") -> tuple[Fit, ...]:
    if not np.isfinite(pose).all():
        return ()
    circles = _circles(run.world, time) if run.world else []
    result = []
    for one in found:
        x, y = compose(pose, np.array([one.x, one.y, 0.0]))[:2].tolist()
        points = compose(pose, np.column_stack([one.points, np.zeros(len(one.points))]))[:, :2]
        radius = one.radius if _is_round(one) else math.inf
        result.append(Fit(x, y, radius, len(points), _shown(points, circles)))
    return tuple(result)


def _is_round(one: "Cluster") -> bool:
    """Whether a circle says something about it: the arc bends enough, and the circle is not far larger than it."""
    return math.isfinite(one.radius) and one.is_round


def _circles(world: World, time: float) -> list[Circle]:
    """Everything round, moving things where they are then."""
    moved = [(m, mover_place(m, np.array(time)).tolist()) for m in world.movers]
    return [*world.circles, *(Circle(x, y, m.radius, m.name) for m, (x, y) in moved)]


def _shown(points: Array, circles: Sequence[Circle]) -> Circle | None:
    """The round obstacle on whose edge the points lie."""
    gaps = [float(np.abs(np.hypot(points[:, 0] - c.x, points[:, 1] - c.y) - c.radius).mean()) for c in circles]
    best = int(np.argmin(gaps)) if gaps else -1
    return circles[best] if gaps and gaps[best] < NEAR_M else None


def _fit_table(fits: Sequence[Fit]) -> str:
    """Round clusters with their errors against the world; how many others there were."""
    shown = [fit for fit in fits if math.isfinite(fit.radius)]
    heads = ("obstacle", "points", "centre x, y, m", "radius, mm", "centre error, mm", "radius error, mm")
    rows = "".join(
        "<tr>"
        + f'<th scope="row">{escape(f.truth.name or "round obstacle") if f.truth else "none known there"}</th>'
        + "".join(
            f'<td class="number">{cell}</td>'
            for cell in (
                str(f.seen), f"{number(f.x, 2)}, {number(f.y, 2)}", number(1e3 * f.radius, 0),
                number(1e3 * f.centre_error_m, 0), number(1e3 * f.radius_error_m, 0),
            )
        )
        + "</tr>"
        for f in shown
    )  # fmt: skip
    others = len(fits) - len(shown)
    line = (
        parts.note(f"{others} more cluster{'s' * (others != 1)} with no round shape, such as walls.") if others else ""
    )
    if not shown:
        return line
    head = "".join(f'<th scope="col" class="{"number" * (i > 0)}">{h}</th>' for i, h in enumerate(heads))
    return f'<div class="scroll"><table><thead><tr>{head}</tr></thead><tbody>{rows}</tbody></table></div>{line}'
