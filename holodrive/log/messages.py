"""Messages that are not of every tick: scans, events, texts, the mounts of sensors. Encoders and decoders."""

import json
import math
import struct
from functools import lru_cache
from typing import Any

import numpy as np

from holodrive.errors import LogError
from holodrive.log.blocks import LASER_SCAN, SCAN, ChannelSpec
from holodrive.log.cdr import Reader, Template
from holodrive.log.sensing import IMU_FRAME, mouse_frame
from holodrive.robots.spec import Robot
from holodrive.types import Array, Event, Pose, Scan

LASER_FRAME = "laser"
_EVEN_RAD = 1e-6  # beams that lie this near to even steps are an even scan
_EVEN_S = 1e-6


def encode_text(text: str) -> bytes:
    """std_msgs/String."""
    message = Template()
    message.string(text)
    return bytes(message.data)


def decode_text(data: bytes) -> str:
    """The text of a std_msgs/String."""
    return Reader(data).string()


def encode_event(event: Event) -> bytes:
    """holodrive_msgs/Event; what of `data` JSON does not know is written as its text."""
    message = Template()
    message.numbers(event.time, *event.pose)
    message.string(event.kind)
    message.string(event.text)
    message.string(json.dumps(event.data, default=_plain))
    return bytes(message.data)


def decode_event(data: bytes) -> Event:
    """An event as it was, tuples in its data as lists."""
    reader = Reader(data)
    time, x, y, theta = reader.numbers(4)
    kind, text = reader.string(), reader.string()
    return Event(time, kind, text, Pose(x, y, theta), json_object(reader.string()))


def decode_metrics(data: bytes) -> dict[str, float]:
    """The numbers of a JSON object in a std_msgs/String."""
    values = json_object(decode_text(data))
    try:
        return {name: float(value) for name, value in values.items() if isinstance(value, int | float)}
    except OverflowError as error:
        raise LogError(f"a metric is no number: {error}") from None


def json_object(text: str) -> dict[str, Any]:
    """A JSON object.

    Raises:
        LogError: it is something else, or nested deeper than can be read.
    """
    try:
        value = json.loads(text)
    except (ValueError, RecursionError) as error:
        raise LogError(f"not JSON: {error}") from None
    if not isinstance(value, dict):
        raise LogError(f"JSON of {type(value).__name__}, expected an object")
    return value


def encode_static_transforms(robot: Robot) -> bytes:
    """tf2_msgs/TFMessage: `map` to `odom`, and `base_link` to the frame of each sensor.

    `odom` and `map` are one: an estimator starts at the robot's pose in the world, not at zero.
    """
    frames = [("map", "odom", Pose(0.0, 0.0, 0.0))]
    if robot.lidar is not None:
        frames.append(("base_link", LASER_FRAME, robot.lidar.mount))
    if robot.imu is not None:
        frames.append(("base_link", IMU_FRAME, robot.imu.mount))
    frames += [("base_link", mouse_frame(mouse.name), mouse.mount) for mouse in robot.mice]
    message = Template()
    message.count(len(frames))
    for parent, child, pose in frames:
        message.stamp(0, 0)
        message.string(parent)
        message.string(child)
        message.numbers(pose.x, pose.y, 0.0, 0.0, 0.0, math.sin(0.5 * pose.theta), math.cos(0.5 * pose.theta))
    return bytes(message.data)


def encode_scan(scan: Scan, mount: Pose | None) -> tuple[ChannelSpec, bytes]:
    """sensor_msgs/LaserScan where that can tell the scan, else holodrive_msgs/Scan.

    A LaserScan has even beams, the first at its stamp, and float32 numbers; its mount is the robot file's (`mount`).
    """
    step, period = _even_steps(scan)
    if scan.mount != mount or math.isnan(step) or math.isnan(period):
        message = Template()
        message.numbers(scan.stamp, *scan.mount, scan.range_min, scan.range_max)
        for values in (scan.angles, scan.ranges, scan.offsets):
            message.count(len(values))
            if len(values):
                message.numbers(*np.asarray(values).tolist())
        return SCAN, bytes(message.data)
    beams = len(scan.ranges)
    data, (stamp_at, numbers_at, ranges_at) = _laser_template(beams)
    out = bytearray(data)
    # the first beam of a scan at the start of a run lies before time zero; ROS time may be negative
    struct.pack_into("<iI", out, stamp_at, *divmod(round((scan.stamp + float(scan.offsets[0])) * 1e9), 1_000_000_000))
    first, last = float(scan.angles[0]), float(scan.angles[0]) + step * (beams - 1)
    struct.pack_into("<7f", out, numbers_at, first, last, step, period, period * beams, scan.range_min, scan.range_max)
    out[ranges_at : ranges_at + 4 * beams] = np.asarray(scan.ranges).astype("<f4").tobytes()
    return LASER_SCAN, bytes(out)


def decode_laser_scan(data: bytes, mount: Pose) -> Scan:
    """A scan of a sensor_msgs/LaserScan."""
    reader = Reader(data)
    (seconds,), (nanos,) = reader.numbers(1, "i"), reader.numbers(1, "I")
    reader.string()
    first, _, step, period, _, range_min, range_max = reader.numbers(7, "f")
    ranges = np.array(reader.sequence("f"))
    index = np.arange(len(ranges), dtype=np.float64)
    back = index - (len(ranges) - 1.0)
    return Scan(
        stamp=seconds + 1e-9 * nanos - (float(back[0]) * period if len(back) else 0.0),
        angles=first + step * index,
        ranges=ranges,
        offsets=period * back,
        mount=mount,
        range_min=range_min,
        range_max=range_max,
    )


def decode_scan(data: bytes) -> Scan:
    """A scan of a holodrive_msgs/Scan."""
    reader = Reader(data)
    stamp, x, y, theta, range_min, range_max = reader.numbers(6)
    angles, ranges, offsets = (np.array(reader.sequence()) for _ in range(3))
    return Scan(stamp, angles, ranges, offsets, Pose(x, y, theta), range_min, range_max)


@lru_cache(maxsize=8)
def _laser_template(beams: int) -> tuple[bytes, tuple[int, int, int]]:
    """A LaserScan with nothing filled in, and where its stamp, its seven numbers and its ranges go."""
    message = Template()
    message.header(LASER_FRAME)
    message.hole("numbers", "f4", 7)
    message.sequence("ranges", beams, "f4")
    message.count(0)
    stamp, numbers, ranges = message.holes
    return bytes(message.data), (stamp.offset, numbers.offset, ranges.offset)


def _even_steps(scan: Scan) -> tuple[float, float]:
    """Angle [rad] and time [s] from beam to beam; NaN where the beams are not even."""
    if len(scan.ranges) < 2 or not len(scan.ranges) == len(scan.angles) == len(scan.offsets):
        return math.nan, math.nan
    turns = np.diff(scan.angles)
    step = _mean_if_even(turns - 2.0 * np.pi * np.round((turns - turns[0]) / (2.0 * np.pi)), _EVEN_RAD)
    period = _mean_if_even(np.diff(scan.offsets), _EVEN_S)
    return step, period if abs(scan.offsets[-1]) <= _EVEN_S and period >= 0.0 else math.nan


def _mean_if_even(steps: Array, tolerance: float) -> float:
    return float(np.mean(steps)) if float(np.ptp(steps)) <= tolerance else math.nan


def _plain(value: object) -> object:
    """NumPy values as JSON numbers and lists, anything else as text."""
    return value.tolist() if isinstance(value, np.ndarray | np.generic) else str(value)
