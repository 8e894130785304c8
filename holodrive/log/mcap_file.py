"""An MCAP file that grows chunk by chunk, each chunk complete on disk before the next begins.

The records come from the `mcap` package, which has no way to close a chunk on time; the order of things and
the chunks are ours. A file that was never finished lacks only its index at the end.
"""

import contextlib
import errno
import os
import struct
import sys
import threading
import zlib
from collections.abc import Callable, Mapping
from importlib import metadata
from pathlib import Path
from typing import BinaryIO, cast

import numpy as np
import zstandard
from mcap import records
from mcap.data_stream import RecordBuilder
from mcap.opcode import Opcode
from mcap.well_known import MessageEncoding, SchemaEncoding
from numpy.typing import NDArray

from holodrive.log import schemas
from holodrive.log.blocks import CHANNELS

if sys.platform != "win32":
    import fcntl

MAGIC = b"\x89MCAP0\r\n"
_COMPRESSION = "zstd"
_LEVEL = 1  # level 3 saves 6 % of the file for twice the time


class Taken(OSError):
    """Somebody else is writing this file."""


class McapFile:
    """Writes one file. Every call that fails raises `OSError` and leaves the file at its last whole record.

    Args:
        path: where; an older file of that name is replaced.

    Raises:
        Taken: somebody else is writing this file.
    """

    def __init__(self, path: Path) -> None:
        self._file = _open_alone(path)
        self._end = 0
        self._compressor = zstandard.ZstdCompressor(level=_LEVEL)
        self._schemas = {
            name: records.Schema(id=number, name=name, encoding=SchemaEncoding.ROS2, data=schemas.schema(name).encode())
            for number, name in enumerate(dict.fromkeys(channel.schema for channel in CHANNELS), start=1)
        }
        self._channels = [
            records.Channel(
                id=channel.number,
                topic=channel.topic,
                message_encoding=MessageEncoding.CDR,
                metadata={},
                schema_id=self._schemas[channel.schema].id,
            )
            for channel in CHANNELS
        ]
        self._chunks: list[records.ChunkIndex] = []
        self._attachments: list[records.AttachmentIndex] = []
        self._metadata: list[records.MetadataIndex] = []
        self._counts: dict[int, int] = {}
        self._start_time, self._end_time = 0, 0
        try:
            self._write(MAGIC)
            self._record(records.Header(profile="ros2", library=f"holodrive {_version()}"))
            for record in (*self._schemas.values(), *self._channels):
                self._record(record)
        except OSError:
            self.abandon()
            raise

    def attach(self, name: str, media_type: str, text: str) -> None:
        """A file inside the file."""
        data = text.encode()
        offset, length = self._record(
            records.Attachment(create_time=0, log_time=0, name=name, media_type=media_type, data=data)
        )
        self._attachments.append(
            records.AttachmentIndex(
                offset=offset,
                length=length,
                log_time=0,
                create_time=0,
                data_size=len(data),
                name=name,
                media_type=media_type,
            )
        )

    def describe(self, name: str, values: Mapping[str, str]) -> None:
        """A metadata record."""
        offset, length = self._record(records.Metadata(name=name, metadata=dict(values)))
        self._metadata.append(records.MetadataIndex(offset=offset, length=length, name=name))

    def chunk(self, messages: bytes, index: Mapping[int, NDArray[np.uint64]]) -> None:
        """A chunk and its message index.

        Args:
            messages: message records, one behind the other.
            index: channel -> (k, 2) log time [ns] and offset in `messages`, as unsigned integers.
        """
        start = min(int(entries[:, 0].min()) for entries in index.values())
        end = max(int(entries[:, 0].max()) for entries in index.values())
        packed = self._compressor.compress(messages)
        chunk = records.Chunk(
            compression=_COMPRESSION,
            data=packed,
            message_start_time=start,
            message_end_time=end,
            uncompressed_crc=zlib.crc32(messages),
            uncompressed_size=len(messages),
        )
        builder = RecordBuilder()
        chunk.write(builder)
        length, offsets = builder.count, {}
        for channel, entries in index.items():
            offsets[channel] = self._end + builder.count
            builder.write(struct.pack("<BQHI", Opcode.MESSAGE_INDEX, 6 + 16 * len(entries), channel, 16 * len(entries)))
            builder.write(entries.astype("<u8").tobytes())
        offset = self._write(_taken(builder))
        self._chunks.append(
            records.ChunkIndex(
                chunk_length=length,
                chunk_start_offset=offset,
                compression=_COMPRESSION,
                compressed_size=len(packed),
                message_end_time=end,
                message_index_length=self._end - offset - length,
                message_index_offsets=offsets,
                message_start_time=start,
                uncompressed_size=len(messages),
            )
        )
        for channel, entries in index.items():
            self._counts[channel] = self._counts.get(channel, 0) + len(entries)
        self._start_time = min(self._start_time, start) if len(self._chunks) > 1 else start
        self._end_time = max(self._end_time, end)

    def finish(self) -> None:
        """Write the index at the end and close."""
        self._record(records.DataEnd(data_section_crc=0))
        start = self._end
        builder = RecordBuilder()
        groups = self._summary_groups()
        offsets = []
        for opcode, group in groups:
            first = builder.count
            for record in group:
                record.write(builder)
            offsets.append(
                records.SummaryOffset(
                    group_opcode=opcode, group_start=start + first, group_length=builder.count - first
                )
            )
        offset_start = start + builder.count
        for offset in offsets:
            offset.write(builder)
        summary = _taken(builder)
        footer = struct.pack("<BQQQ", Opcode.FOOTER, 20, start, offset_start)
        self._write(summary + footer + struct.pack("<I", zlib.crc32(footer, zlib.crc32(summary))) + MAGIC)
        self.sync()
        self._close()

    def _summary_groups(self) -> list[tuple[Opcode, list[records.McapRecord]]]:
        statistics = records.Statistics(
            attachment_count=len(self._attachments),
            channel_count=len(self._channels),
            channel_message_counts=self._counts,
            chunk_count=len(self._chunks),
            message_count=sum(self._counts.values()),
            metadata_count=len(self._metadata),
            message_start_time=self._start_time,
            message_end_time=self._end_time,
            schema_count=len(self._schemas),
        )
        groups: list[tuple[Opcode, list[records.McapRecord]]] = [
            (Opcode.SCHEMA, [*self._schemas.values()]),
            (Opcode.CHANNEL, [*self._channels]),
            (Opcode.STATISTICS, [statistics]),
            (Opcode.CHUNK_INDEX, [*self._chunks]),
            (Opcode.ATTACHMENT_INDEX, [*self._attachments]),
            (Opcode.METADATA_INDEX, [*self._metadata]),
        ]
        return [(opcode, group) for opcode, group in groups if group]

    def sync(self) -> None:
        """Wait until all that was written is on the disk itself."""
        try:
            number = self._file.fileno()
        except ValueError:
            return  # closed meanwhile by the thread that writes
        os.fsync(number)

    def abandon(self) -> None:
        """Close without an index; what was written stays readable. Never fails: the fault was told before."""
        with contextlib.suppress(OSError):
            self._close()

    def _close(self) -> None:
        if not self._file.closed:
            _let_go(self._file)
            self._file.close()

    def _record(self, record: records.McapRecord) -> tuple[int, int]:
        """Write one record; its offset and length."""
        builder = RecordBuilder()
        record.write(builder)
        data = _taken(builder)
        return self._write(data), len(data)

    def _write(self, data: bytes) -> int:
        """Write all of `data` or, after a failure or Ctrl-C, none of it; its offset."""
        offset, view = self._end, memoryview(data)
        try:
            while view:
                taken = self._file.write(view)
                if not taken:  # a pipe that is full and does not wait
                    raise BlockingIOError(errno.EAGAIN, "it takes no more data")
                view = view[taken:]
        except BaseException:
            # a torn record would only be noise behind the last good one; what failed is told either way
            with contextlib.suppress(OSError):
                self._file.truncate(offset)
                self._file.seek(offset)
            raise
        self._end += len(data)
        return offset


class Syncer:
    """Calls `sync` about once a second in a thread of its own, so that a slow disk does not hold up the loop.

    Args:
        sync: what to call; when it fails, its error goes to `report` and the thread ends.
    """

    def __init__(self, sync: Callable[[], None], report: Callable[[OSError], None], period_s: float = 1.0) -> None:
        self._sync, self._report, self._period_s = sync, report, period_s
        self._stop = threading.Event()
        self._thread = threading.Thread(target=self._run, name="holodrive-log-sync", daemon=True)
        self._thread.start()

    def stop(self, *, wait: bool = True) -> None:
        """End the thread and, unless told otherwise, wait for it."""
        self._stop.set()
        if wait:
            self._thread.join()

    def _run(self) -> None:
        while not self._stop.wait(self._period_s):
            try:
                self._sync()
            except OSError as error:
                self._report(error)
                return


def _open_alone(path: Path) -> BinaryIO:
    """An empty file that nobody else writes with this function; the system forgets the lock with the process."""
    # not "wb": that would empty another recorder's file before the lock could say no
    file = cast(
        BinaryIO, os.fdopen(os.open(path, os.O_WRONLY | os.O_CREAT | getattr(os, "O_BINARY", 0), 0o666), "wb", 0)
    )
    try:
        _lock(file)
        if os.fstat(file.fileno()).st_size:
            file.truncate(0)
    except OSError:
        file.close()
        raise
    return file


def _lock(file: BinaryIO) -> None:
    if sys.platform == "win32":
        return
    try:
        fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        raise Taken(errno.EAGAIN, "another recording is still writing it") from None
    except OSError:
        return  # a file system without locks, as some network ones are: recording matters more


def _let_go(file: BinaryIO) -> None:
    """Give the lock back at once: children that were forked meanwhile share the open file, and would keep it."""
    if sys.platform != "win32":
        with contextlib.suppress(OSError):
            fcntl.flock(file, fcntl.LOCK_UN)


def _taken(builder: RecordBuilder) -> bytes:
    return bytes(builder.end())  # type: ignore[no-untyped-call]


def _version() -> str:
    try:
        return metadata.version("holodrive")
    except metadata.PackageNotFoundError:
        return "0"
