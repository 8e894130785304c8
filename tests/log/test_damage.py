"""Claims about reading what is left of a damaged log: all other chunks and one line, never a traceback."""

import json
import os
import struct
import sys
from pathlib import Path

import numpy as np
import pytest
from logged import scan, ticks

from holodrive import log, robots
from holodrive.errors import FileFaults, LogError
from holodrive.log import Recorder, blocks
from holodrive.log.blocks import ChannelSpec, message_record
from holodrive.log.cdr import ENCAPSULATION
from holodrive.log.mcap_file import MAGIC, McapFile
from holodrive.log.messages import encode_text
from holodrive.log.salvage import salvage
from holodrive.robots.spec import Robot
from holodrive.types import Event, Pose

CHUNK_TICKS = 21  # 0.2 s, both ends counted


@pytest.fixture(scope="module")
def whole(hybrid3: Robot, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A log of 10 s with scans and an event."""
    path = tmp_path_factory.mktemp("log") / "whole.mcap"
    assert hybrid3.lidar is not None
    with Recorder(path, hybrid3, None, {"seed": 1}, clock=lambda: 0.0) as recorder:
        for i, each in enumerate(ticks(hybrid3, 300)):
            recorder.tick(each)
            if i % 10 == 0:
                recorder.scan(scan(each.time, 36, hybrid3.lidar.mount))
        recorder.event(Event(1.0, "collision", "wall", Pose(0, 0, 0)))
    return path


def damaged(whole: Path, tmp_path: Path, data: bytes) -> Path:
    path = tmp_path / "damaged.mcap"
    path.write_bytes(data)
    return path


def read_or_one_line(path: Path) -> int:
    """Ticks that were read; 0 when the reader refuses, which it does in one line."""
    try:
        run = log.read(path)
    except LogError as error:
        return 0 if len(str(error).splitlines()) == 1 else -1
    assert "\n" not in run.damage
    return len(run.time)


def test_a_flipped_bit_costs_one_chunk_at_most(whole: Path, tmp_path: Path) -> None:
    """Wherever the bit is: 300 places, in record heads and lengths too."""
    data = whole.read_bytes()
    rng = np.random.default_rng(0)
    places = [*rng.integers(0, len(data), 200), *range(0, 60), *range(len(data) - 40, len(data))]
    names = [i for i in range(len(data)) if data.startswith(b"/holodrive/tick", i)]  # in channel records: no check sum
    places += [name + k for name in names for k in range(-20, 20)]
    for place in places:
        broken = bytearray(data)
        broken[place] ^= 1 << int(rng.integers(8))
        assert read_or_one_line(damaged(whole, tmp_path, bytes(broken))) >= 300 - CHUNK_TICKS, place


@pytest.mark.campaign
def test_ten_thousand_flipped_bits(whole: Path, tmp_path: Path) -> None:
    data, rng = whole.read_bytes(), np.random.default_rng(1)
    for place in rng.integers(0, len(data), 10_000):
        broken = bytearray(data)
        broken[place] ^= 1 << int(rng.integers(8))
        assert read_or_one_line(damaged(whole, tmp_path, bytes(broken))) >= 300 - CHUNK_TICKS, place


def test_a_damaged_chunk_is_told_in_one_line(whole: Path, tmp_path: Path) -> None:
    data = bytearray(whole.read_bytes())
    chunk = [i for i in range(len(data)) if data[i : i + 8] == b"\x04\x00\x00\x00zstd"][5]
    data[chunk + 40] ^= 0xFF
    path = damaged(whole, tmp_path, bytes(data))
    run = log.read(path)
    assert len(run.time) == 300 - CHUNK_TICKS
    assert run.damage == f"{path}: 1 of 16 chunks are damaged and left out"


def test_a_file_cut_anywhere_gives_all_that_comes_before(whole: Path, tmp_path: Path) -> None:
    data = whole.read_bytes()
    last = 0
    for size in np.linspace(1, len(data) - 1, 80).astype(int):
        count = read_or_one_line(damaged(whole, tmp_path, data[:size]))
        assert count >= last
        last = count
    assert last == 300


@pytest.mark.parametrize("length", [1, 16, 500, 20_000])
def test_overwritten_removed_and_inserted_bytes_cost_only_what_they_hit(
    length: int, whole: Path, tmp_path: Path
) -> None:
    data = whole.read_bytes()
    rng = np.random.default_rng(length)
    for _ in range(25):
        place = int(rng.integers(0, len(data) - length))
        noise = rng.integers(0, 256, length, dtype=np.uint8).tobytes()
        hit = 2 + length // 1000  # chunks
        for broken in (
            data[:place] + noise + data[place + length :],
            data[:place] + data[place + length :],
            data[:place] + noise + data[place:],
        ):
            assert read_or_one_line(damaged(whole, tmp_path, broken)) >= 300 - CHUNK_TICKS * hit


def test_garbage_is_refused_in_one_line(tmp_path: Path) -> None:
    rng = np.random.default_rng(3)
    for head in (b"", b"\x89MCAP0\r\n", b"PK\x03\x04", b"\x89MCAP0\r\n" * 20):
        data = head + rng.integers(0, 256, 5000, dtype=np.uint8).tobytes()
        path = tmp_path / "garbage.mcap"
        path.write_bytes(data)
        with pytest.raises(LogError, match="no readable description of the robot"):
            log.read(path)


def test_random_chunks_with_good_check_sums_never_raise() -> None:
    """What only a malicious file holds: the sums are right, the content is not."""
    rng = np.random.default_rng(4)
    from mcap import records
    from mcap.data_stream import RecordBuilder

    for size in [*range(60), 1000]:
        content = rng.integers(0, 16, size, dtype=np.uint8).tobytes()
        builder = RecordBuilder()
        records.Chunk("", content, 0, 0, 0, len(content)).write(builder)
        builder.write(content)
        salvage(b"\x89MCAP0\r\n" + builder.end())  # type: ignore[no-untyped-call]


def test_an_empty_file_and_no_file_are_told(tmp_path: Path) -> None:
    (tmp_path / "empty.mcap").write_bytes(b"")
    with pytest.raises(LogError, match="the file is empty"):
        log.read(tmp_path / "empty.mcap")
    with pytest.raises(LogError, match="No such file"):
        log.read(tmp_path / "none.mcap")
    with pytest.raises(LogError, match="Is a directory"):
        log.read(tmp_path)


def test_a_log_of_another_program_is_told(tmp_path: Path) -> None:
    from mcap.writer import Writer

    path = tmp_path / "other.mcap"
    writer = Writer(str(path))
    writer.start("ros2", "other")
    schema = writer.register_schema("std_msgs/msg/String", "ros2msg", b"string data\n")
    channel = writer.register_channel("/chatter", "cdr", schema)
    writer.add_message(channel, 0, b"\x00\x01\x00\x00\x02\x00\x00\x00a\x00", 0)
    writer.finish()
    with pytest.raises(LogError, match=r"not of holodrive \(topics: /chatter\)"):
        log.read(path)


def test_a_log_rewritten_by_other_tools_is_still_read(whole: Path, tmp_path: Path) -> None:
    """Other channel numbers, other chunks, another compression."""
    from mcap.reader import make_reader
    from mcap.writer import CompressionType, Writer

    path = tmp_path / "rewritten.mcap"
    writer = Writer(str(path), compression=CompressionType.NONE)
    writer.start("ros2", "other")
    channels: dict[str, int] = {}
    with whole.open("rb") as file:
        for schema, channel, message in make_reader(file).iter_messages():
            assert schema is not None
            if channel.topic not in channels:
                number = writer.register_schema(schema.name, schema.encoding, schema.data)
                channels[channel.topic] = writer.register_channel(channel.topic, "cdr", number)
            writer.add_message(channels[channel.topic], message.log_time, message.data, message.publish_time)
    writer.finish()
    assert log.compare(log.read(whole), log.read(path)) == ()


def test_the_description_is_repeated_so_that_losing_the_first_is_no_loss(tmp_path: Path) -> None:
    robot = robots.load("omni3")
    path = tmp_path / "long.mcap"
    with Recorder(path, robot, clock=lambda: 0.0) as recorder:
        for each in ticks(robot, 1100):
            recorder.tick(each)
    data = path.read_bytes()
    assert len(log.read(damaged(path, tmp_path, data[60_000:])).time) > 900


def made(path: Path, robot_: Robot, *messages: tuple[ChannelSpec, bytes], **description: str) -> Path:
    """A file with good check sums, a description (its parts as given) and some messages."""
    parts = {"robot": robot_.text, "world": "", "settings": "{}"} | description
    all_messages = [(blocks.DESCRIPTION, encode_text(json.dumps(parts))), *messages]
    records = b"".join(message_record(channel.number, 0, 0, data) for channel, data in all_messages)
    file = McapFile(path)
    file.chunk(records, {blocks.DESCRIPTION.number: np.zeros((1, 2), dtype=np.uint64)})
    file.finish()
    return path


DEEP = "[" * 100_000
HUGE = b"\xff\xff\xff\xff"  # length of a sequence
NONSENSE: dict[str, tuple[ChannelSpec, bytes]] = {
    "metrics nested too deep": (blocks.METRICS, encode_text(DEEP)),
    "metrics that are no float": (blocks.METRICS, encode_text(f'{{"a": 1{"0" * 400}}}')),
    "metrics cut": (blocks.METRICS, b"\x00\x01"),
    "an event": (blocks.EVENT, ENCAPSULATION + bytes(32) + HUGE),
    "a scan": (blocks.SCAN, ENCAPSULATION + bytes(48) + HUGE),
    "a laser scan": (blocks.LASER_SCAN, ENCAPSULATION + bytes(8) + HUGE),
    "a tick": (blocks.TICK, ENCAPSULATION + HUGE * 10),
    "a reading of an IMU": (blocks.IMU, ENCAPSULATION + HUGE * 10),
    "a reading of mice": (blocks.MICE, b""),
}


@pytest.mark.parametrize("what", NONSENSE)
def test_a_message_that_makes_no_sense_is_counted(what: str, hybrid3: Robot, tmp_path: Path) -> None:
    path = made(tmp_path / "run.mcap", hybrid3, NONSENSE[what])
    assert log.read(path).damage == f"{path}: 1 messages make no sense"


def test_settings_that_make_no_sense_are_counted(hybrid3: Robot, tmp_path: Path) -> None:
    for settings in (DEEP, "5", "{"):
        run = log.read(made(tmp_path / "run.mcap", hybrid3, settings=settings))
        assert (run.settings, run.damage.endswith("1 messages make no sense")) == ({}, True)


def test_a_robot_or_world_that_makes_no_sense_is_told_in_one_line(hybrid3: Robot, tmp_path: Path) -> None:
    for parts in ({"robot": "x = [\n"}, {"robot": "x = " + DEEP}, {"robot": "\x00\x01"}, {"world": "zzz"}):
        with pytest.raises(FileFaults) as error:
            log.read(made(tmp_path / "run.mcap", hybrid3, **parts))
        assert len(str(error.value).splitlines()) == 1
        assert f"{tmp_path / 'run.mcap'}:{next(iter(parts))}.toml" in str(error.value)


def test_lengths_beyond_all_memory_are_told_in_one_line(tmp_path: Path) -> None:
    """Of records, of what a chunk unpacks to, of the file itself."""
    path = tmp_path / "huge.mcap"
    for length, unpacked in ((2**64 - 1, 0), (2**62, 2**62), (148, 2**62), (148, 2**27)):
        head = struct.pack("<QQQII4sQ", 0, 0, unpacked, 0, 4, b"zstd", max(0, length - 48))
        path.write_bytes(MAGIC + b"\x06" + struct.pack("<Q", length) + head + bytes(100))
        with pytest.raises(LogError, match="no readable description of the robot") as error:
            log.read(path)
        assert len(str(error.value).splitlines()) == 1


def test_a_file_that_memory_cannot_hold_is_told(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def read_bytes(path: Path) -> bytes:
        raise MemoryError

    (tmp_path / "big.mcap").write_bytes(bytes(12))
    monkeypatch.setattr(Path, "read_bytes", read_bytes)
    with pytest.raises(LogError, match="its 12 bytes do not fit into memory"):
        log.read(tmp_path / "big.mcap")


def test_what_is_no_log_at_all_is_told_in_one_line(tmp_path: Path) -> None:
    for path in (Path(sys.executable), Path("a\x00b"), tmp_path, Path(os.devnull)):
        with pytest.raises(LogError) as error:
            log.read(path)
        assert len(str(error.value).splitlines()) == 1
