"""All the whole chunks of an MCAP file, whatever happened to the rest of it.

MCAP has no mark to find one's place again after damage, so a reader that follows the lengths loses all that comes
behind one wrong byte. Chunks are recognised here by their own form (a compression name, then lengths that agree),
wherever they are; each counts only when its check sum does. What lies between them is read record by record as far
as it goes.
"""

import struct
import zlib
from collections.abc import Iterator
from dataclasses import dataclass, field

import zstandard

from holodrive.log.mcap_file import MAGIC

_CHANNEL, _MESSAGE, _CHUNK, _ATTACHMENT = 0x04, 0x05, 0x06, 0x09
_FOOTER = 0x02
_KNOWN = range(0x01, 0x10)
# start, end, uncompressed size, CRC, length of the compression's name
_CHUNK_HEAD = struct.Struct("<QQQII")
_LARGEST = 1 << 28  # bytes that one chunk may unpack to; more is damage or malice
_COMPRESSIONS = (b"zstd", b"lz4", b"")


@dataclass
class Salvage:
    """What of a file can be read.

    Attributes:
        messages: (channel, log time [ns], data) in the order of the file, chunk by chunk.
        topics: channel -> topics that its records say; they have no check sum, so a damaged one may say another.
        attachments: name -> text of those whose check sum is right.
        chunks: how many whole chunks there are; `lost_chunks`: how many are there but damaged.
        lost_bytes: that could not be understood.
        finished: whether the file was closed properly.
    """

    messages: list[tuple[int, int, bytes]] = field(default_factory=list)
    topics: dict[int, set[str]] = field(default_factory=dict)
    attachments: dict[str, str] = field(default_factory=dict)
    chunks: int = 0
    lost_chunks: int = 0
    lost_bytes: int = 0
    finished: bool = False
    missing: str = ""  # a compression that this machine cannot unpack


def salvage(data: bytes) -> Salvage:
    """Read the bytes of a whole file; never raises for what they are."""
    found = Salvage()
    at = len(MAGIC) if data.startswith(MAGIC) else 0
    for start, end in (*_chunks(data), (len(data), len(data))):
        if start < at:
            continue  # inside what was read already
        _between(data, at, start, found)
        if end > start:
            _read_chunk(data[start + 9 : end], found)
        at = end
    return found


def _chunks(data: bytes) -> Iterator[tuple[int, int]]:
    """(start, end) of everything that has the form of a chunk, in order."""
    # the name of the compression is the one thing in a chunk that is always the same
    at = data.find(b"\x04\x00\x00\x00zstd")
    while at >= 0:
        start = at - 9 - (_CHUNK_HEAD.size - 4)
        if start >= 0 and data[start] == _CHUNK and at + 16 <= len(data):
            (length,) = struct.unpack_from("<Q", data, start + 1)
            (packed,) = struct.unpack_from("<Q", data, at + 8)
            if length == packed + _CHUNK_HEAD.size + 4 + 8 and start + 9 + length <= len(data):
                yield start, start + 9 + length
        at = data.find(b"\x04\x00\x00\x00zstd", at + 1)


def _between(data: bytes, start: int, end: int, found: Salvage) -> None:
    """Read the records from `start` on; count what of them makes no sense."""
    while start < end:
        if data[start : start + len(MAGIC)] == MAGIC and start + len(MAGIC) == end:
            return
        opcode = data[start]
        if start + 9 > end or opcode not in _KNOWN:
            break
        (length,) = struct.unpack_from("<Q", data, start + 1)
        if start + 9 + length > end:
            break
        _record(opcode, data[start + 9 : start + 9 + length], found)
        start += 9 + length
    if start < end:
        found.lost_bytes += end - start


def _record(opcode: int, body: bytes, found: Salvage) -> None:
    if opcode == _CHANNEL:
        _read_channel(body, found)
    elif opcode == _CHUNK:
        _read_chunk(body, found)
    elif opcode == _MESSAGE:
        _read_messages(struct.pack("<BQ", _MESSAGE, len(body)) + body, found)
    elif opcode == _ATTACHMENT:
        _read_attachment(body, found)
    elif opcode == _FOOTER:
        found.finished = True


def _read_channel(body: bytes, found: Salvage) -> None:
    if len(body) >= 8:
        number, _, length = struct.unpack_from("<HHI", body)
        topic = body[8 : 8 + length]
        if len(topic) == length:
            found.topics.setdefault(number, set()).add(topic.decode("utf-8", errors="replace"))


def _read_attachment(body: bytes, found: Salvage) -> None:
    if len(body) < 20 or zlib.crc32(body[:-4]) != struct.unpack_from("<I", body, len(body) - 4)[0]:
        return
    # the sum is right, so the lengths are what was written
    at, texts = 16, []
    for _ in range(2):
        (length,) = struct.unpack_from("<I", body, at)
        texts.append(body[at + 4 : at + 4 + length])
        at += 4 + length
        if at + 8 > len(body):
            return
    found.attachments[texts[0].decode("utf-8", errors="replace")] = body[at + 8 : -4].decode("utf-8", errors="replace")


def _read_chunk(body: bytes, found: Salvage) -> None:
    records = _unpack(body, found)
    if records is None or not _read_messages(records, found):
        found.lost_chunks += 1
    else:
        found.chunks += 1


def _unpack(body: bytes, found: Salvage) -> bytes | None:
    """The records of a chunk, None when its check sum says that they are not what was written."""
    if len(body) < _CHUNK_HEAD.size:
        return None
    _, _, size, crc, length = _CHUNK_HEAD.unpack_from(body)
    name = body[_CHUNK_HEAD.size : _CHUNK_HEAD.size + length]
    packed = body[_CHUNK_HEAD.size + length + 8 :]
    if name not in _COMPRESSIONS or size > _LARGEST:
        return None
    if name == b"lz4":
        found.missing = "lz4"
        return None
    records = _unzstd(packed, size) if name else packed
    if records is None or len(records) != size or (crc and zlib.crc32(records) != crc):
        return None
    return records


def _unzstd(packed: bytes, size: int) -> bytes | None:
    try:
        # the size inside the frame may lie; the chunk's own was bounded above
        if zstandard.frame_content_size(packed) not in (size, -1):
            return None
        return zstandard.ZstdDecompressor().decompress(packed, max_output_size=max(size, 1))
    except zstandard.ZstdError:
        return None


def _read_messages(records: bytes, found: Salvage) -> bool:
    """Take the messages out of the records of a chunk; False, and none, when they do not fit together."""
    at, messages = 0, []
    while at < len(records):
        if at + 9 > len(records):
            return False
        opcode, length = struct.unpack_from("<BQ", records, at)
        body = at + 9
        at = body + length
        if at > len(records):
            return False
        if opcode == _MESSAGE:
            if length < 22:
                return False
            channel, _, stamp = struct.unpack_from("<HIQ", records, body)
            messages.append((channel, stamp, records[body + 22 : at]))
        elif opcode == _CHANNEL:
            _read_channel(records[body:at], found)
    found.messages += messages
    return True
