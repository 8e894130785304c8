"""The interactive replay: what moves, packed for the page's script, and the close-up of the robot it animates."""

import base64
import json
import math
from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from holodrive import svg
from holodrive.geometry import compose
from holodrive.log.drawing import best_pose
from holodrive.log.run import Run
from holodrive.log.shapes import robot_shape, text_width
from holodrive.log.view import View
from holodrive.reports.charts import position_error
from holodrive.robots.spec import Robot
from holodrive.types import Array, Pose, Scan
from holodrive.worlds.spec import World

FRAME_RATE_HZ, MOST_FRAMES = 25.0, 900
MOST_SCANS, MOST_BEAMS = 150, 120
_UNKNOWN = 65535  # of 16 bits; the page turns it back into NaN

CLOSE_UP = 300.0  # px, side of the close-up
_REACH_SHARE = 0.30  # of the side that the footprint's radius takes


def pack(values: Array) -> dict[str, Any]:
    """An array (n, k) as 16-bit numbers in base64: value = low + step * number, per column; NaN stays unknown."""
    values = np.asarray(values, dtype=np.float64)
    values = values.reshape(len(values), -1)
    known = np.isfinite(values)
    low = np.where(known, values, np.inf).min(axis=0, initial=np.inf)
    high = np.where(known, values, -np.inf).max(axis=0, initial=-np.inf)
    low, high = np.where(np.isfinite(low), low, 0.0), np.where(np.isfinite(high), high, 0.0)
    step = np.where(high > low, (high - low) / (_UNKNOWN - 1), 1.0)
    numbers = np.where(known, np.rint((np.where(known, values, low) - low) / step), _UNKNOWN).astype("<u2")
    return {
        "k": values.shape[1],
        "low": [float(f"{v:.9g}") for v in low],
        "step": [float(f"{v:.9g}") for v in step],
        "data": base64.b64encode(numbers.tobytes()).decode("ascii"),
    }


def frames(time: Array) -> NDArray[np.intp]:
    """Indices of the ticks that a screen shows: about 25 a second, at most 900, first and last among them."""
    if len(time) < 2:
        return np.arange(len(time))
    span = float(time[-1] - time[0])
    count = int(min(len(time), MOST_FRAMES, max(2, math.ceil(span * FRAME_RATE_HZ) + 1)))
    wanted = np.linspace(time[0], time[-1], count)
    return np.unique(np.clip(np.searchsorted(time, wanted - 1e-9), 0, len(time) - 1)).astype(np.intp)


def track(run: Run, name: str, close_up: bool) -> dict[str, Any]:
    """One run for the page's script: poses, and for the close-up wheels, speeds, steering and scans."""
    at = frames(run.time)
    pose = best_pose(run)
    packed: dict[str, Any] = {
        "name": name,
        "time": pack(run.time[at]),
        "pose": pack(pose[at]),
        "error": pack(position_error(pose, run.reference)[at]),
        "twist": pack(run.twist[at]),
        "end": float(run.time[-1]) if len(run.time) else 0.0,
    }
    if close_up:
        packed |= {
            "commands": pack(run.wheel_commands[at]),
            "speeds": pack(run.wheel_speeds[at]),
            "steer": pack(run.steer[at] if run.steer.shape[1] else run.steer_commands[at]),
            "drift": pack(position_error(run.estimate, run.pose)[at]),
            "wheels": [
                {"x": w.x, "y": w.y, "yaw": w.yaw, "steered": w.kind == "swerve", "top": w.max_speed_rad_s}
                for w in run.robot.wheels
            ],
            "top_speed": _top_speed(run),
            "scans": scans(run),
        }
    return packed


def scans(run: Run) -> dict[str, Any] | None:
    """Where the beams of the scans ended [m, in the map], each placed by the pose at the time of its own beam."""
    if not run.scans:
        return None
    some = run.scans[:: max(1, math.ceil(len(run.scans) / MOST_SCANS))]
    count = min([MOST_BEAMS, *(len(scan.ranges) for scan in some)])
    if not count:
        return None
    pose = best_pose(run)
    hits = np.stack([scan_hits(scan, run.time, pose, count) for scan in some])
    origins = np.stack([compose(pose_at(np.array(scan.stamp), run.time, pose), scan.mount)[:2] for scan in some])
    return {
        "beams": count,
        "time": pack(np.array([scan.stamp for scan in some])),
        "origin": pack(origins),
        "x": pack(hits[..., 0].reshape(-1)),
        "y": pack(hits[..., 1].reshape(-1)),
    }


def scan_hits(scan: Scan, time: Array, pose: Array, count: int) -> Array:
    """Ends (count, 2) [m] in the map of evenly picked beams; NaN where nothing came back."""
    pick = np.linspace(0, len(scan.ranges) - 1, count).round().astype(int)
    at = compose(pose_at(scan.stamp + scan.offsets[pick], time, pose), scan.mount)
    heading = at[:, 2] + scan.angles[pick]
    with np.errstate(invalid="ignore"):  # infinite = no return
        ends = at[:, :2] + scan.ranges[pick, None] * np.stack([np.cos(heading), np.sin(heading)], axis=-1)
    return np.where(np.isfinite(scan.ranges[pick])[:, None], ends, np.nan)


def pose_at(when: Array, time: Array, pose: Array) -> Array:
    """Poses (..., 3) at times (...) between ticks; held before the first and after the last."""
    return np.stack([np.interp(when, time, pose[:, i]) for i in range(3)], axis=-1)


def data(runs: Sequence[Run], names: Sequence[str], view: View, world: World | None) -> str:
    """Everything that the page's script needs, as JSON that may stand in a script element."""
    movers = world.movers if world else ()
    x, y = view.bounds[:2]
    content = {
        "view": {"x": x, "y": y, "scale": view.scale, "left": view.left, "base": view.top + view.height},
        "tracks": [track(run, name, close_up=len(runs) == 1) for run, name in zip(runs, names, strict=True)],
        "movers": [{"path": [[k.time, k.x, k.y] for k in m.path], "loop": m.loop} for m in movers],
        "events": [{"t": e.time, "kind": e.kind, "text": e.text} for run in runs for e in run.events],
        "close": {"scale": CLOSE_UP * _REACH_SHARE / runs[0].robot.footprint_radius_m, "centre": 0.5 * CLOSE_UP},
    }
    return json.dumps(_plain(content), separators=(",", ":"), allow_nan=False).replace("<", "\\u003c")


def close_up(robot: Robot) -> str:
    """The robot large, forward up, with room for the script's arrows at every wheel."""
    half = 0.5 * CLOSE_UP
    scale = CLOSE_UP * _REACH_SHARE / robot.footprint_radius_m
    body = svg.element(
        "g", robot_shape(robot), transform=f"translate({half} {half})scale({scale:.4f} {-scale:.4f})rotate(90)"
    )
    arrows = [
        svg.element("path", class_=f"arrow {kind}", data_wheel=i, fill="none")
        for i in range(len(robot.wheels))
        for kind in ("commanded", "measured")
    ]
    labels = []
    for wheel in robot.wheels:
        away = math.hypot(wheel.x, wheel.y) or 1.0
        out = scale * (robot.footprint_radius_m + 0.12 * robot.footprint_radius_m)
        x, y = half - wheel.y / away * out, half - wheel.x / away * out
        anchor = "start" if x > half + 8 else "end" if x < half - 8 else "middle"
        wide = text_width(wheel.name, 12)
        x = min(max(x, wide + 2 if anchor == "end" else 2), CLOSE_UP - (wide + 2 if anchor == "start" else 2))
        labels.append(
            svg.text(x, y + (4 if anchor != "middle" else -2 if y < half else 12), wheel.name, class_="label halo",
                     text_anchor=anchor, font_size=12)
        )  # fmt: skip
    title = f"{robot.name} from above, forward up, with its {len(robot.wheels)} wheels"
    return svg.document(
        CLOSE_UP, CLOSE_UP, body, *arrows, svg.element("path", class_="arrow velocity", fill="none"), *labels,
        title=title, class_="close-up",
    )  # fmt: skip


def live_layer(runs: Sequence[Run], world: World | None, view: View) -> str:
    """What the script moves over the scene: beams, trails, moving obstacles, robots."""
    movers = [
        svg.element(
            "g",
            svg.element("circle", class_="mover", r=mover.radius * view.scale),
            svg.text(0, 4, mover.name, class_="label halo", font_size=11, text_anchor="middle") if mover.name else "",
            class_="live-mover",
        )
        for mover in (world.movers if world else ())
    ]
    robots = [
        svg.element(
            "g",
            robot_shape(run.robot),
            class_=f"live-robot r{i}",
            transform=view.transform(Pose(*_first(best_pose(run)))),
        )
        for i, run in enumerate(runs)
    ]
    trails = [svg.element("path", class_=f"trail r{i}", fill="none") for i in range(len(runs))]
    beams = svg.element("path", class_="beams", fill="none") + svg.element("path", class_="hits", fill="none")
    return svg.element("g", beams, *movers, *trails, *robots, class_="live", visibility="hidden")


def _first(poses: Array) -> Array:
    good = np.flatnonzero(np.isfinite(poses).all(axis=-1))
    return poses[good[0]] if len(good) else np.zeros(3)


def _top_speed(run: Run) -> float:
    speed = np.hypot(run.twist[:, 0], run.twist[:, 1])
    return float(np.nanmax(speed)) if np.isfinite(speed).any() else 0.0


def _plain(value: Any) -> Any:
    """JSON without NaN or infinity (both become null) and without digits that nobody sees."""
    if isinstance(value, dict):
        return {key: _plain(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [_plain(item) for item in value]
    if isinstance(value, float):
        return float(f"{value:.9g}") if math.isfinite(value) else None
    return value
