"""A run that moves: GIF frames by Pillow, and an SVG that plays itself."""

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from holodrive import svg
from holodrive.log.drawing import best_pose, bounds_of, described, drawn, framed, moments, traces
from holodrive.log.run import Run
from holodrive.log.shapes import collision_shapes, goal_shape, mover_place, robot_shape, world_shapes
from holodrive.log.view import View
from holodrive.reports import raster
from holodrive.reports.raster import Canvas
from holodrive.reports.replay import pose_at, scan_hits
from holodrive.types import Array

if TYPE_CHECKING:
    from PIL.Image import Image

Progress = Callable[[float], None]
MOST_FRAMES = 300
HEADER = 30.0  # px for the legend or the clock


@dataclass(frozen=True)
class Pace:
    """When frames are taken and how fast they are shown.

    Attributes:
        times: (F,) run time of each frame [s].
        frame_s: how long each is shown [s].
        speed: run seconds that pass in one second of film.
    """

    times: Array
    frame_s: float
    speed: float

    @classmethod
    def of(cls, run: Run, fps: float = 10.0, speed: float | None = None) -> "Pace":
        """Real time when at most 300 frames will do, else as much faster as it takes; or as fast as is said."""
        span = float(run.time[-1] - run.time[0]) if len(run.time) else 0.0
        frame_s = round(100.0 / fps) / 100.0  # a GIF counts hundredths of a second
        if speed is None:
            fit = span / (MOST_FRAMES * frame_s)
            speed = 1.0 if fit <= 1.0 else float(np.ceil(fit))
        count = int(np.floor(span / (frame_s * speed) + 1e-9)) + 1
        start = run.time[0] if len(run.time) else 0.0
        times: Array = float(start) + np.arange(count, dtype=np.float64) * (frame_s * speed)
        if span > times[-1] - start + 1e-9:
            times = np.append(times, run.time[-1]).astype(np.float64)
        return cls(times, frame_s, speed)


def still(run: Run, size: int) -> Canvas:
    """The final picture: world, all paths, the robot at several moments."""
    canvas = _canvas(run, size)
    raster.floor(canvas)
    poses, reach = best_pose(run), run.robot.footprint_radius_m
    if run.world is not None:
        raster.world(canvas, run.world)
        for moving in run.world.movers:
            raster.mover(canvas, moving, float(run.time[-1]) if len(run.time) else 0.0)
    shown = moments(poses, reach)
    for i in shown[:-1]:
        raster.outline(canvas, poses[i], reach)
    if shown:
        raster.robot(canvas, run.robot, poses[shown[-1]], run.steer[shown[-1]])
    lines = traces(run)
    for line in lines:
        raster.trace(canvas, line)
    raster.collisions(canvas, run.events)
    raster.legend(canvas, lines, 18.0)
    return canvas


def gif(run: Run, path: Path, size: int, pace: Pace, progress: Progress | None = None) -> None:
    """Write the run as an animated GIF whose longer side has `size` px."""
    from PIL.Image import Dither

    ground = _canvas(run, size)
    raster.floor(ground)
    if run.world is not None:
        raster.world(ground, run.world)
    for line in traces(run):
        if line.class_ == "reference":
            raster.trace(ground, line)
    palette = still(run, size).shown().quantize(128)
    frames: list[Image] = []
    poses, before = best_pose(run), pace.times[0]
    for time in pace.times:
        inside = (run.time >= before) & (run.time <= time)
        ground.line(poses[inside], raster.BLUE, 2.2)
        before = time
        frames.append(_frame(run, ground, poses, float(time), pace).quantize(palette=palette, dither=Dither.NONE))
        if progress:
            progress(len(frames) / len(pace.times))
    shown_ms = [round(1000 * pace.frame_s)] * (len(frames) - 1) + [2000]  # rest at the end before it starts again
    frames[0].save(
        path, format="GIF", save_all=True, append_images=frames[1:], duration=shown_ms, loop=0, optimize=True
    )


def animated_svg(run: Run, width: float, height: float, pace: Pace) -> str:
    """The path picture with the robot and moving obstacles driving in it, without any script."""
    view = View.fit(bounds_of([run]), width, height, header=26.0)
    poses = pose_at(pace.times, run.time, best_pose(run))
    keep = np.isfinite(poses).all(axis=-1)
    lines, world = traces(run), run.world
    total = max(pace.frame_s * (len(pace.times) - 1), 1e-3)
    movers = [
        svg.element(
            "g",
            _animate("translate", view.pixels(mover_place(moving, pace.times)), pace.times, total),
            svg.element("circle", class_="mover", r=moving.radius * view.scale, fill="#d9c6e2", stroke="#8a5a9e"),
        )
        for moving in (world.movers if world else ())
    ]
    robot = ""
    if keep.any():
        turn = _animate("rotate", -np.degrees(poses[keep, 2:3]), pace.times[keep], total)
        body = svg.element("g", robot_shape(run.robot), transform=f"scale({view.scale:.4f} {-view.scale:.4f})")
        move = _animate("translate", view.pixels(poses[keep]), pace.times[keep], total)
        robot = svg.element("g", move, svg.element("g", turn, body), class_="live-robot")
    still_world = world_shapes(world, view, 0.0, moving=False) if world else ""
    shapes = (goal_shape(world, view) if world else "", still_world, *(drawn(line, view) for line in lines))
    return framed(view, lines, described(run), *shapes, *movers, robot, collision_shapes(run.events, view))


def _animate(kind: str, values: Array, times: Array, total: float) -> str:
    """An endless animation of a transform through rows of values at run times."""
    share = (times - times[0]) / max(times[-1] - times[0], 1e-9)
    if len(share) < 2:
        values, share = np.repeat(values[:1], 2, axis=0), np.array([0.0, 1.0])
    share[-1] = 1.0
    return svg.element(
        "animateTransform", attributeName="transform", type=kind, dur=f"{total:.2f}s", repeatCount="indefinite",
        values=";".join(" ".join(f"{v:.2f}" for v in row) for row in values),
        keyTimes=";".join(f"{s:.4f}".rstrip("0").rstrip(".") or "0" for s in share),
    )  # fmt: skip


def _frame(run: Run, ground: Canvas, poses: Array, time: float, pace: Pace) -> "Image":
    canvas = ground.copy()
    for moving in run.world.movers if run.world else ():
        raster.mover(canvas, moving, time)
    tick = int(np.clip(np.searchsorted(run.time, time, side="right") - 1, 0, len(run.time) - 1))
    _scan_dots(run, canvas, poses, time)
    raster.robot(canvas, run.robot, poses[tick], run.steer[tick])
    raster.collisions(canvas, run.events, time)
    rate = "" if pace.speed == 1.0 else f"  at {pace.speed:g} times real speed"
    canvas.text(canvas.view.left, 16.0, f"{run.robot.name}   {time:.1f} s{rate}", raster.INK, size=12.0)
    return canvas.shown()


def _scan_dots(run: Run, canvas: Canvas, poses: Array, time: float) -> None:
    """Where the beams of the newest scan ended."""
    newest = next((scan for scan in reversed(run.scans) if scan.stamp <= time), None)
    if newest is None or not len(newest.ranges):
        return
    hits = scan_hits(newest, run.time, poses, min(90, len(newest.ranges)))
    for x, y in canvas.at(hits[np.isfinite(hits).all(axis=-1)]):
        canvas.draw.ellipse((x - 2.5, y - 2.5, x + 2.5, y + 2.5), fill=raster.VERMILION)


def _canvas(run: Run, size: int) -> Canvas:
    view = View.fit(bounds_of([run]), size, size, header=HEADER - 10.0)
    wide, high = view.picture
    # room for the clock and the legend over narrow floors; even sizes suit every player of films
    return Canvas(view, (2 * round(max(wide, 300.0) / 2), 2 * round(high / 2)))
