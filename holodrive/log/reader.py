"""From a log file to a `Run`, with all that a damaged file still holds."""

import logging
import math
import os
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from holodrive import robots, worlds
from holodrive.errors import LogError
from holodrive.log import blocks, sensing
from holodrive.log.blocks import CHANNELS, tick_template
from holodrive.log.messages import (
    decode_event,
    decode_laser_scan,
    decode_metrics,
    decode_scan,
    decode_text,
    json_object,
)
from holodrive.log.rows import columns_of, run_of_rows
from holodrive.log.run import Run
from holodrive.log.salvage import Salvage, salvage
from holodrive.robots.spec import Robot
from holodrive.types import Array, Event, Pose, Scan
from holodrive.worlds.spec import World

S = TypeVar("S")
T = TypeVar("T")
_log = logging.getLogger(__name__)
MAGIC_START = b"\x89MCAP"


@dataclass(frozen=True)
class Content:
    """What a log file of ours holds.

    Attributes:
        robot, world, settings: of the run.
        rows: (T, size) control ticks, see `holodrive.log.rows`.
        damage: one line, empty for a whole file.
    """

    robot: Robot
    world: World | None
    settings: Mapping[str, Any]
    rows: Array
    scans: tuple[Scan, ...]
    events: tuple[Event, ...]
    metrics: Mapping[str, float]
    damage: str


def read(path: str | Path) -> Run:
    """The run that a log file holds, as far as it can be read; `run.damage` tells what could not.

    Raises:
        LogError: there is no such file, it is no log of ours, or its description of the robot is lost.
    """
    path = Path(path)
    content = read_content(path)
    if content.damage:
        _log.warning("%s", content.damage)
    return run_of_rows(
        content.rows,
        content.robot,
        content.world,
        content.settings,
        scans=content.scans,
        events=content.events,
        metrics=content.metrics,
        path=path,
        damage=content.damage,
    )


def read_content(path: Path) -> Content:
    """All that a log file of ours holds; see `read`."""
    data = read_bytes(path)
    if not data:
        raise LogError(f"{path}: the file is empty; a recording killed in its first moment leaves one, record again")
    found = salvage(data)
    by_topic, stamps = _by_topic(found)
    unreadable = 0
    description = _description(path, by_topic.get(blocks.DESCRIPTION.topic, []), found)
    robot = robots.parse(description["robot"], f"{path}:robot.toml")
    world = worlds.parse(description["world"], f"{path}:world.toml") if description["world"] else None
    rows, bad = _rows(by_topic, stamps, robot)
    unreadable += bad
    scans, bad = _scans(by_topic, Pose(0.0, 0.0, 0.0) if robot.lidar is None else robot.lidar.mount)
    unreadable += bad
    events, bad = _decode_all(by_topic.get(blocks.EVENT.topic, []), decode_event)
    unreadable += bad
    metrics, bad = _decode_all(by_topic.get(blocks.METRICS.topic, []), decode_metrics)
    unreadable += bad
    settings, bad = _decode_all([description["settings"]], json_object)
    unreadable += bad
    return Content(
        robot=robot,
        world=world,
        settings=settings[0] if settings else {},
        rows=rows,
        scans=scans,
        events=tuple(events),
        metrics=metrics[-1] if metrics else {},
        damage=_damage(path, found, unreadable, rows),
    )


def read_bytes(path: Path) -> bytes:
    """The bytes of a file, or one line about why not."""
    try:
        return path.read_bytes()
    except OSError as error:
        raise LogError(f"cannot read {path}: {os.strerror(error.errno or 0)}") from None
    except ValueError as error:
        raise LogError(f"cannot read {str(path)!r}: {error}") from None
    except MemoryError:
        raise LogError(f"cannot read {path}: its {path.stat().st_size} bytes do not fit into memory") from None


def _by_topic(found: Salvage) -> tuple[dict[str, list[bytes]], dict[str, list[int]]]:
    """Messages of each topic of ours, and their log times [ns].

    Where a channel's record is lost or damaged, its number tells the topic: it is the same in all our files.
    """
    usual = {channel.number: channel.topic for channel in CHANNELS}
    known = set(usual.values())
    topics = {number: (said & known).pop() for number, said in found.topics.items() if said & known}
    claimed = set(topics.values())
    topics |= {n: topic for n, topic in usual.items() if n not in topics and topic not in claimed}
    out: dict[str, list[bytes]] = {}
    stamps: dict[str, list[int]] = {}
    for channel, stamp, data in found.messages:
        topic = topics.get(channel, "")
        out.setdefault(topic, []).append(data)
        stamps.setdefault(topic, []).append(stamp)
    return out, stamps


def _description(path: Path, messages: list[bytes], found: Salvage) -> dict[str, str]:
    """The first description that can be read; the recorder repeats it, and attaches its parts to the file."""
    for data in messages:
        try:
            description = json_object(decode_text(data))
            return {key: str(description[key]) for key in ("robot", "world", "settings")}
        except (LogError, KeyError):
            continue
    if "robot.toml" in found.attachments:
        texts = found.attachments
        keys = {"robot": "robot.toml", "world": "world.toml", "settings": "settings.json"}
        return {key: texts.get(name, "") for key, name in keys.items()}
    if found.missing:
        raise LogError(f"{path}: its chunks are packed with {found.missing}; rewrite it with zstd (mcap compress)")
    topics = sorted(set().union(*found.topics.values()))
    if found.chunks and topics and not any(topic.startswith("/holodrive/") for topic in topics):
        names = ", ".join(topics[:5])
        raise LogError(f"{path}: an MCAP file, but not of holodrive (topics: {names}); export it as CSV to replay it")
    raise LogError(f"{path}: no readable description of the robot ({_count(found)}); nothing can be told without it")


def _rows(by_topic: Mapping[str, list[bytes]], stamps: Mapping[str, list[int]], robot: Robot) -> tuple[Array, int]:
    """Ticks (T, size), and how many messages have another form than this robot's."""
    at = columns_of(robot)
    topic = blocks.TICK.topic
    raw, good, holes = sensing.alike(by_topic.get(topic, []), tick_template(at))
    rows = np.full((len(raw), at.size), np.nan)
    start = 0
    for hole in holes.values():
        rows[:, start : start + hole.count] = sensing.numbers(raw, hole)
        start += hole.count
    bad = len(good) - len(raw)
    ticks = _stamps(stamps, topic)[good]
    for channel, read_all, columns in (
        (blocks.IMU, sensing.read_imu, slice(at["gyro"].start, at["accel"].stop)),
        (blocks.MICE, sensing.read_mice, at["mice"]),
        (blocks.MOTORS, sensing.read_motors, at["motors"]),
    ):
        values, good = read_all(by_topic.get(channel.topic, []), robot)
        place = sensing.ticks_of(_stamps(stamps, channel.topic)[good], ticks)
        rows[place[place >= 0], columns] = values[place >= 0]
        bad += len(good) - len(values)
    return rows, bad


def _stamps(stamps: Mapping[str, list[int]], topic: str) -> NDArray[np.uint64]:
    return np.array(stamps.get(topic, []), dtype=np.uint64)


def _scans(by_topic: Mapping[str, list[bytes]], mount: Pose) -> tuple[tuple[Scan, ...], int]:
    laser, bad = _decode_all(by_topic.get(blocks.LASER_SCAN.topic, []), lambda data: decode_laser_scan(data, mount))
    own, bad_own = _decode_all(by_topic.get(blocks.SCAN.topic, []), decode_scan)
    scans = sorted([*laser, *own], key=lambda scan: scan.stamp) if own else laser
    return tuple(scans), bad + bad_own


def _decode_all(messages: list[S], decode: Callable[[S], T]) -> tuple[list[T], int]:
    out: list[T] = []
    bad = 0
    for data in messages:
        try:
            out.append(decode(data))
        except (LogError, ValueError, IndexError):
            bad += 1
    return out, bad


def _damage(path: Path, found: Salvage, unreadable: int, rows: Array) -> str:
    """One line about what is not there, empty when all is."""
    faults = []
    if found.lost_chunks:
        faults.append(f"{found.lost_chunks} of {found.chunks + found.lost_chunks} chunks are damaged and left out")
    if found.lost_bytes:
        faults.append(f"{found.lost_bytes} bytes make no sense")
    if unreadable:
        faults.append(f"{unreadable} messages make no sense")
    if not found.finished:
        last = rows[-1, 0] if len(rows) else math.nan
        faults.append(
            "the recording was not closed" + ("" if math.isnan(last) else f", its last tick is at {last:.3f} s")
        )
    return f"{path}: {'; '.join(faults)}" if faults else ""


def _count(found: Salvage) -> str:
    return f"{found.chunks} whole chunks, {found.lost_chunks} damaged, {found.lost_bytes} bytes without sense"
