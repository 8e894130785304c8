"""Writes a run to an MCAP file while it happens, so that a killed process loses a quarter of a second at most."""

import json
import logging
import math
import time
from collections.abc import Callable, Mapping
from dataclasses import replace
from pathlib import Path
from types import TracebackType
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray

from holodrive import robots, worlds
from holodrive.errors import LogError
from holodrive.log import blocks
from holodrive.log.blocks import BlockKind, ChannelSpec, TickBlock, message_record, nanoseconds
from holodrive.log.mcap_file import McapFile, Syncer, Taken
from holodrive.log.messages import encode_event, encode_scan, encode_static_transforms, encode_text
from holodrive.log.rows import KIND_TWIST, columns_of
from holodrive.log.run import Tick
from holodrive.robots.spec import Robot
from holodrive.types import Event, Scan
from holodrive.worlds.spec import World

_log = logging.getLogger(__name__)
_CHUNK_S = 0.2  # of wall time and of log time; a chunk that is not closed is what a kill loses
_CHUNK_TICKS = 256
_DESCRIBE_S = 10.0  # the description is said again this often, for damaged files


class Recorder:
    """Writes ticks, scans and events; never raises once it is open, `fault` tells why it stopped.

    Chunks close after 0.2 s of wall time or of log time, whichever is first, and go to the system at once;
    the disk itself is asked every second, in a thread of its own. Robot, world and settings come first in
    the file, so that a run cut off at any moment can still be repeated.

    Args:
        path: of the new file; an older one is replaced, but not one that another recorder is still writing.
        robot, world, settings: what it takes to repeat the run; `settings` must be JSON-able.
        clock: monotonic seconds.

    Raises:
        LogError: the file cannot be made, another recorder is writing it, or the settings cannot be written as JSON.

    Attributes:
        fault: one line about what ended the recording, empty while all is well.
        lost: ticks that came after the fault.
    """

    def __init__(
        self,
        path: str | Path,
        robot: Robot,
        world: World | None = None,
        settings: Mapping[str, Any] | None = None,
        *,
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        self.path, self.fault, self.lost = Path(path), "", 0
        self._clock = clock
        self._columns = columns_of(robot)
        self._robot = robot
        self._mount = None if robot.lidar is None else robot.lidar.mount
        self._description = _description(robot, world, settings or {})
        self._rows = np.empty((_CHUNK_TICKS, self._columns.size))
        self._filled, self._ticks = 0, 0
        self._imu, self._mice, self._motors = False, False, False  # a sensor that was there once keeps its topic
        self._block_kind: BlockKind | None = None
        self._blocks: dict[BlockKind, TickBlock] = {}
        self._others: list[tuple[ChannelSpec, int, bytes]] = []
        self._sequence: dict[int, int] = {}
        self._opened_at, self._opened_time = clock(), math.nan
        self._last_time, self._described_time = 0.0, 0.0
        self._closed = False
        self._sync_error: OSError | None = None
        try:
            self._file = McapFile(self.path)
        except OSError as error:
            raise LogError(_cannot_write(self.path, error)) from None
        try:
            self._begin()
        except OSError as error:
            self._file.abandon()
            raise LogError(_cannot_write(self.path, error)) from None
        self._syncer = Syncer(self._file.sync, self._sync_failed)

    def _begin(self) -> None:
        for name, media_type, key in (
            ("robot.toml", "application/toml", "robot"),
            ("world.toml", "application/toml", "world"),
            ("settings.json", "application/json", "settings"),
        ):
            if self._description[key]:
                self._file.attach(name, media_type, self._description[key])
        self._file.describe("holodrive", {"format": "1", "robot": self._description["name"]})
        self._other(blocks.TRANSFORMS_STATIC, 0.0, encode_static_transforms(self._robot))
        self._describe(0.0)
        self._flush()

    def tick(self, tick: Tick) -> None:
        """Record one control tick."""
        if self.fault or self._closed:
            self.lost += 1
            return
        try:
            if self._sync_error is not None:
                raise self._sync_error
            self._take(tick)
        except Exception as error:  # a recorder never stops a robot
            self._fail(error)

    def _take(self, tick: Tick) -> None:
        row = self._rows[self._filled]
        self._columns.fill(row, tick)
        self._imu = self._imu or tick.gyro is not None or tick.accel is not None
        self._mice = self._mice or (tick.mice is not None and self._columns.k > 0)
        is_twist = bool(row[self._columns["decided_kind"].start] == KIND_TWIST)
        self._motors = self._motors or tick.motors is not None
        kind = BlockKind(tick.truth is not None, is_twist, self._imu, self._mice, self._motors)
        if kind != self._block_kind:
            self._flush()  # the rows before have other channels than this one
            self._rows[0], self._block_kind = row, kind
        if math.isnan(self._opened_time):
            self._opened_time = tick.time
        self._filled += 1
        self._ticks += 1
        self._last_time = tick.time
        self._flush_when_due(tick.time)

    def scan(self, scan: Scan) -> None:
        """Record a scan."""
        self._add(lambda: encode_scan(scan, self._mount), scan.stamp)

    def event(self, event: Event) -> None:
        """Record an event; its chunk closes at once, for it may be the last thing that happens."""
        self._add(lambda: (blocks.EVENT, encode_event(event)), event.time, flush=True)

    def close(self, metrics: Mapping[str, float] | None = None) -> None:
        """Write what is left, the metrics and the index; harmless when called twice."""
        if self._closed:
            return
        self._closed = True
        self._syncer.stop()
        if self.fault:
            return
        try:
            if metrics is not None:
                text = json.dumps({name: float(value) for name, value in metrics.items()})
                self._other(blocks.METRICS, self._last_time, encode_text(text))
                self._flush()
                self._file.describe("metrics", {name: repr(float(value)) for name, value in metrics.items()})
            self._flush()
            self._file.finish()
        except Exception as error:
            self._fail(error)

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    def _add(self, encode: Callable[[], tuple[ChannelSpec, bytes]], time_s: float, *, flush: bool = False) -> None:
        if self.fault or self._closed:
            return
        try:
            channel, data = encode()
            self._other(channel, time_s, data)
            if flush:
                self._flush()
        except Exception as error:
            self._fail(error)

    def _other(self, channel: ChannelSpec, time_s: float, data: bytes) -> None:
        self._others.append((channel, int(nanoseconds(np.array(time_s))), data))

    def _describe(self, time_s: float) -> None:
        self._described_time = time_s
        self._other(blocks.DESCRIPTION, time_s, encode_text(json.dumps(self._description)))

    def _flush_when_due(self, time_s: float) -> None:
        # half a nanosecond of slack, so that 20 ticks of 10 ms are a chunk and not 21
        due = (
            self._filled == _CHUNK_TICKS
            or time_s - self._opened_time >= _CHUNK_S - 5e-10
            or self._clock() - self._opened_at >= _CHUNK_S
        )
        if due:
            if time_s - self._described_time >= _DESCRIBE_S:
                self._describe(time_s)
            self._flush()

    def _flush(self) -> None:
        """Close the chunk: rows first, then what else came since the last one."""
        parts: list[bytes] = []
        index: dict[int, list[NDArray[np.uint64]]] = {}
        size = 0
        if self._filled:
            data, stamps, starts = self._encode_rows()
            offsets = np.arange(0, len(data), len(data) // self._filled, dtype=np.uint64)
            for channel, start in starts:
                index[channel] = [np.stack([stamps, offsets + np.uint64(start)], axis=-1)]
            parts.append(data)
            size = len(data)
        for spec, stamp, message in self._others:
            record = message_record(spec.number, self._sequence.get(spec.number, 0), stamp, message)
            self._sequence[spec.number] = self._sequence.get(spec.number, 0) + 1
            index.setdefault(spec.number, []).append(np.array([[stamp, size]], dtype=np.uint64))
            parts.append(record)
            size += len(record)
        self._filled, self._others = 0, []
        self._opened_at, self._opened_time = self._clock(), math.nan
        if parts:
            self._file.chunk(b"".join(parts), {channel: np.concatenate(each) for channel, each in index.items()})

    def _encode_rows(self) -> tuple[bytes, NDArray[np.uint64], list[tuple[int, int]]]:
        assert self._block_kind is not None
        encoder = self._blocks.get(self._block_kind)
        if encoder is None:
            encoder = TickBlock(self._columns, self._robot, self._block_kind)
            self._blocks[self._block_kind] = encoder
        data, stamps = encoder.encode(self._rows[: self._filled], self._ticks - self._filled)
        return data, stamps, encoder.block.starts

    def _sync_failed(self, error: OSError) -> None:
        # called by the thread that syncs: the next tick stops the recording, so that only one thread touches the file
        self._sync_error = error

    def _fail(self, error: Exception) -> None:
        """Stop recording, say so once, leave the file readable."""
        if self.fault:
            return
        if isinstance(error, OSError):
            self.fault = _cannot_write(self.path, error)
        else:
            self.fault = f"log {self.path}: recording stopped: {type(error).__name__}: {error}"
        _log.error("%s", self.fault)
        self._syncer.stop(wait=False)  # a disk that hangs must not hold up the loop
        self._file.abandon()


def _description(robot: Robot, world: World | None, settings: Mapping[str, Any]) -> dict[str, str]:
    """What it takes to repeat the run, as texts."""
    try:
        text = json.dumps(dict(settings))
    except (TypeError, ValueError) as error:
        raise LogError(f"the settings of a run must be JSON-able to be recorded: {error}") from None
    return {
        "name": robot.name,
        "robot": _faithful_text(robot),
        "world": "" if world is None else _faithful_text(world),
        "settings": text,
    }


def _faithful_text(thing: Robot | World) -> str:
    """TOML that reads as exactly this robot or world: its own text, unless the value was changed after reading."""
    form: Any = robots if isinstance(thing, Robot) else worlds
    if thing.text and replace(form.parse(thing.text, thing.name), text="") == replace(thing, text=""):
        return thing.text
    return str(form.dump(thing))


def _cannot_write(path: Path, error: OSError) -> str:
    """One line for people."""
    if not path.parent.is_dir():
        return f"cannot write the log {path}: no folder {str(path.parent)!r}; make it, or choose another place"
    reason = error.strerror or str(error)
    if isinstance(error, Taken):
        return f"cannot write the log {path}: {reason}; close that one, or choose another place"
    return f"cannot write the log {path}: {reason}; free some space or choose another place"
