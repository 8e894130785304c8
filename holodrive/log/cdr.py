"""CDR, the byte format of ROS 2 messages (little-endian XCDR1), written once as a template with holes.

All messages of one channel have the same length, so a message is laid out once; later many of them are
filled column by column through one NumPy structured array. Numbers are aligned to their size, counted from
behind the four bytes of the encapsulation header.
"""

import struct
from collections.abc import Sequence
from dataclasses import dataclass, field

from holodrive.errors import LogError

ENCAPSULATION = b"\x00\x01\x00\x00"
_SIZES = {"f8": 8, "f4": 4, "i4": 4, "u4": 4}


@dataclass(frozen=True, slots=True)
class Hole:
    """Where `count` numbers of a NumPy kind ("f8", "f4", "i4", "u4") go."""

    name: str
    kind: str
    offset: int
    count: int


@dataclass
class Template:
    """One message: constant bytes and the holes in them."""

    data: bytearray = field(default_factory=lambda: bytearray(ENCAPSULATION))
    holes: list[Hole] = field(default_factory=list)

    def align(self, size: int) -> None:
        """Pad to a multiple of `size`."""
        self.data += bytes(-(len(self.data) - len(ENCAPSULATION)) % size)

    def count(self, value: int) -> None:
        """Length of a sequence."""
        self.align(4)
        self.data += struct.pack("<I", value)

    def string(self, text: str) -> None:
        """A string; its length counts the closing zero."""
        raw = text.encode()
        self.count(len(raw) + 1)
        self.data += raw + b"\x00"

    def numbers(self, *values: float) -> None:
        """Constant float64 numbers."""
        self.align(8)
        self.data += struct.pack(f"<{len(values)}d", *values)

    def stamp(self, seconds: int, nanoseconds: int) -> None:
        """A constant builtin_interfaces/Time."""
        self.align(4)
        self.data += struct.pack("<II", seconds, nanoseconds)

    def hole(self, name: str, kind: str = "f8", count: int = 1) -> None:
        """Room for `count` numbers; nothing, not even padding, for none."""
        if count:
            self.align(_SIZES[kind])
            self.holes.append(Hole(name, kind, len(self.data), count))
            self.data += bytes(_SIZES[kind] * count)

    def sequence(self, name: str, count: int, kind: str = "f8") -> None:
        """Room for a sequence of `count` numbers, its length before it."""
        self.count(count)
        self.hole(name, kind, count)

    def header(self, frame: str, stamp: str = "stamp") -> None:
        """std_msgs/Header; `stamp` is the hole of (seconds, nanoseconds)."""
        self.hole(stamp, "u4", 2)
        self.string(frame)

    def strings(self, texts: Sequence[str]) -> None:
        """A sequence of strings."""
        self.count(len(texts))
        for text in texts:
            self.string(text)


class Reader:
    """Reads one message from its first field to its last; every overrun is a `LogError`."""

    def __init__(self, data: bytes) -> None:
        if data[:4] != ENCAPSULATION:
            raise LogError(f"a message starts with {data[:4].hex()}, expected little-endian CDR 00010000")
        self._data, self._at = data, 4

    def numbers(self, count: int, kind: str = "d") -> tuple[float, ...]:
        """The next `count` numbers of a `struct` kind ("d" float64, "f" float32, "I" uint32)."""
        size = struct.calcsize(kind)
        if count:
            self._at += -(self._at - 4) % size
        end = self._at + count * size
        if end > len(self._data):
            raise LogError(f"a message of {len(self._data)} bytes ends before its fields do")
        values = struct.unpack_from(f"<{count}{kind}", self._data, self._at)
        self._at = end
        return values

    def sequence(self, kind: str = "d") -> tuple[float, ...]:
        """The next sequence of numbers."""
        return self.numbers(int(self.numbers(1, "I")[0]), kind)

    def string(self) -> str:
        """The next string."""
        length = int(self.numbers(1, "I")[0])
        end = self._at + length
        if length < 1 or end > len(self._data):
            raise LogError(f"a message of {len(self._data)} bytes ends before its text does")
        raw = self._data[self._at : end - 1]
        self._at = end
        return raw.decode("utf-8", errors="replace")
