"""All messages of one control tick as one block of bytes, and many ticks filled at once.

The recorder keeps rows of numbers (`rows.py`); when a chunk closes, every channel's numbers of all its ticks
are written column by column into a structured array whose item is the whole block. That costs a few
microseconds a tick where encoding message by message costs tens.
"""

import struct
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from holodrive.log import schemas, sensing
from holodrive.log.cdr import Template
from holodrive.log.rows import FIXED, SEQUENCES, Columns
from holodrive.robots.spec import Robot
from holodrive.types import Array

MESSAGE = 0x05  # opcode of an MCAP message record
# opcode, length of what follows, channel, sequence, log time [ns], publish time [ns]
MESSAGE_PREFIX = struct.Struct("<BQHIQQ")
_BEHIND_LENGTH = MESSAGE_PREFIX.size - 9


@dataclass(frozen=True, slots=True)
class ChannelSpec:
    """One channel of our logs: its number is the same in every file, so a damaged file still tells it."""

    number: int
    topic: str
    schema: str


TICK = ChannelSpec(1, "/holodrive/tick", schemas.TICK)
ODOMETRY = ChannelSpec(2, "/odom", schemas.ODOMETRY)
TRUTH = ChannelSpec(3, "/truth", schemas.ODOMETRY)
COMMAND = ChannelSpec(4, "/cmd_vel", schemas.TWIST)
JOINTS = ChannelSpec(5, "/joint_states", schemas.JOINTS)
JOINT_COMMANDS = ChannelSpec(6, "/joint_commands", schemas.JOINTS)
REFERENCE = ChannelSpec(7, "/reference", schemas.POSE)
TRANSFORMS = ChannelSpec(8, "/tf", schemas.TRANSFORMS)
TRANSFORMS_STATIC = ChannelSpec(9, "/tf_static", schemas.TRANSFORMS)
LASER_SCAN = ChannelSpec(10, "/scan", schemas.LASER_SCAN)
SCAN = ChannelSpec(11, "/holodrive/scan", schemas.SCAN)
EVENT = ChannelSpec(12, "/holodrive/events", schemas.EVENT)
DESCRIPTION = ChannelSpec(13, "/holodrive/description", schemas.STRING)
METRICS = ChannelSpec(14, "/holodrive/metrics", schemas.STRING)
IMU = ChannelSpec(15, "/imu", schemas.IMU)
MICE = ChannelSpec(16, "/mice", schemas.MICE)
MOTORS = ChannelSpec(17, "/motors", schemas.MOTORS)
CHANNELS = (
    *(TICK, ODOMETRY, TRUTH, COMMAND, JOINTS, JOINT_COMMANDS, REFERENCE, TRANSFORMS, TRANSFORMS_STATIC),
    *(LASER_SCAN, SCAN, EVENT, DESCRIPTION, METRICS, IMU, MICE, MOTORS),
)


@dataclass
class Block:
    """The messages of one tick: constant bytes, and a structured type that names their holes."""

    data: bytearray = field(default_factory=bytearray)
    starts: list[tuple[int, int]] = field(default_factory=list)  # (channel, offset of its message record)
    _names: list[str] = field(default_factory=list)
    _formats: list[tuple[str, tuple[int, ...]]] = field(default_factory=list)
    _offsets: list[int] = field(default_factory=list)

    def add(self, channel: ChannelSpec, message: Template) -> None:
        """Append the record of one message; its holes are called `<channel number>.<hole>`."""
        start, n = len(self.data), channel.number
        self.starts.append((n, start))
        self.data += MESSAGE_PREFIX.pack(MESSAGE, _BEHIND_LENGTH + len(message.data), n, 0, 0, 0)
        self._hole(f"{n}.sequence", "<u4", start + 11)
        self._hole(f"{n}.times", "<u8", start + 15, 2)
        for hole in message.holes:
            self._hole(f"{n}.{hole.name}", f"<{hole.kind}", start + MESSAGE_PREFIX.size + hole.offset, hole.count)
        self.data += message.data

    def _hole(self, name: str, kind: str, offset: int, count: int = 1) -> None:
        self._names.append(name)
        self._formats.append((kind, (count,)))
        self._offsets.append(offset)

    def copies(self, count: int) -> tuple[NDArray[np.uint8], NDArray[np.void]]:
        """The bytes of the block `count` times, holes still zero, and a structured view (count,) into its holes."""
        kind = np.dtype(
            {"names": self._names, "formats": self._formats, "offsets": self._offsets, "itemsize": len(self.data)}
        )
        # the bytes are kept beside the view: NumPy may drop what lies between the fields when it copies a structure
        raw = np.frombuffer(bytes(self.data) * count, dtype=np.uint8).copy()
        return raw, raw.view(kind)


class BlockKind(NamedTuple):
    """Which messages a tick has: the true pose, a decided twist, an IMU's reading, those of mice, of motors."""

    truth: bool
    command: bool
    imu: bool
    mice: bool
    motors: bool


class TickBlock:
    """Writes rows as messages.

    Args:
        at: the row layout.
        robot: whose joints and sensors they are.
        kind: which messages.
    """

    def __init__(self, at: Columns, robot: Robot, kind: BlockKind) -> None:
        self._at, self._robot, self._kind = at, robot, kind
        wheel_names = [wheel.name for wheel in robot.wheels]
        steer_names = [f"{wheel_names[i]}_steer" for i in robot.steered]
        block = Block()
        block.add(TICK, tick_template(at))
        block.add(ODOMETRY, _odometry("odom", "base_link"))
        if kind.truth:
            block.add(TRUTH, _odometry("map", "base_link_truth"))
        if kind.command:
            block.add(COMMAND, _twist())
        block.add(JOINTS, _joints(wheel_names, steer_names, effort=True))
        block.add(JOINT_COMMANDS, _joints(wheel_names, steer_names, effort=False))
        block.add(REFERENCE, _pose("map"))
        block.add(TRANSFORMS, transform("odom", "base_link"))
        if kind.imu:
            block.add(IMU, sensing.imu_template(robot))
        if kind.mice:
            block.add(MICE, sensing.mice_template(robot))
        if kind.motors:
            block.add(MOTORS, sensing.motors_template(robot))
        self.block = block

    def encode(self, rows: Array, first: int) -> tuple[bytes, NDArray[np.uint64]]:
        """The records of rows (k, size), whose first is tick number `first`, and their log times (k,) [ns]."""
        at = self._at
        raw, out = self.block.copies(len(rows))
        stamps = nanoseconds(rows[:, at["time"].start])
        for number, _ in self.block.starts:
            out[f"{number}.sequence"][:, 0] = np.arange(first, first + len(rows))
            out[f"{number}.times"] = stamps[:, None]
        seconds = np.stack([stamps // 1_000_000_000, stamps % 1_000_000_000], axis=-1)
        for number, _ in self.block.starts[1:]:
            out[f"{number}.stamp"] = seconds
        head = at["decided_wheels"].start
        out["1.fixed"] = rows[:, :head]
        for name, _ in SEQUENCES:
            if at.counts[name]:
                out[f"1.{name}"] = rows[:, at[name]]
        _fill_odometry(out, 2, rows[:, at["estimate"]], rows[:, at["estimate_twist"]], rows[:, at["covariance"]])
        if self._kind.truth:
            _fill_odometry(out, 3, rows[:, at["truth"]], rows[:, at["true_twist"]])
        if self._kind.command:
            decided = rows[:, at["decided_twist"]]
            out["4.linear"], out["4.angular"] = decided[:, :2], decided[:, 2:]
        self._fill_joints(out, rows)
        _fill_pose(out, 7, rows[:, at["reference"]])
        _fill_pose(out, 8, rows[:, at["estimate"]])
        if self._kind.imu:
            sensing.fill_imu(out, 15, self._robot, rows[:, at["gyro"]], rows[:, at["accel"]])
        if self._kind.mice:
            sensing.fill_mice(out, 16, rows[:, at["mice"]])
        if self._kind.motors:
            sensing.fill_motors(out, 17, rows[:, at["motors"]])
        return raw.tobytes(), stamps

    def _fill_joints(self, out: NDArray[np.void], rows: Array) -> None:
        at = self._at
        for hole in ("5.position", "5.velocity", "5.effort", "6.position", "6.velocity"):
            out[hole] = np.nan
        out["5.position"][:, : at.n] = rows[:, at["wheel_position"]]
        out["5.position"][:, at.n :] = rows[:, at["steer"]]
        out["5.velocity"][:, : at.n] = rows[:, at["wheel_speed"]]
        out["5.effort"][:, : at.n] = rows[:, at["duty"]]
        out["6.position"][:, at.n :] = rows[:, at["applied_steer"]]
        out["6.velocity"][:, : at.n] = rows[:, at["applied_wheels"]]


def nanoseconds(time: Array) -> NDArray[np.uint64]:
    """Log times [ns] of times [s]; what is before zero or not a time is 0."""
    return (np.nan_to_num(np.clip(time, 0.0, 1.8e10), nan=0.0) * 1e9).round().astype(np.uint64)


def message_record(channel: int, sequence: int, stamp: int, message: bytes) -> bytes:
    """The MCAP record of one message."""
    return MESSAGE_PREFIX.pack(MESSAGE, _BEHIND_LENGTH + len(message), channel, sequence, stamp, stamp) + message


def tick_template(at: Columns) -> Template:
    """holodrive_msgs/Tick with its fixed fields as one hole."""
    message = Template()
    message.hole("fixed", count=sum(count for _, count in FIXED))
    for name, _ in SEQUENCES:
        message.sequence(name, at.counts[name])
    return message


def transform(parent: str, child: str) -> Template:
    """tf2_msgs/TFMessage of one transform."""
    message = Template()
    message.count(1)
    message.header(parent)
    message.string(child)
    _pose_holes(message)
    return message


def _odometry(frame: str, child: str) -> Template:
    message = Template()
    message.header(frame)
    message.string(child)
    _pose_holes(message)
    message.hole("covariance", count=36)
    _twist_holes(message)
    message.numbers(*[0.0] * 36)
    return message


def _pose(frame: str) -> Template:
    message = Template()
    message.header(frame)
    _pose_holes(message)
    return message


def _pose_holes(message: Template) -> None:
    message.hole("xy", count=2)
    message.numbers(0.0, 0.0, 0.0)  # z, then x and y of the quaternion
    message.hole("turn", count=2)


def _twist() -> Template:
    message = Template()
    message.header("base_link")
    _twist_holes(message)
    return message


def _twist_holes(message: Template) -> None:
    message.hole("linear", count=2)
    message.numbers(0.0, 0.0, 0.0)
    message.hole("angular")


def _joints(wheels: list[str], steered: list[str], *, effort: bool) -> Template:
    """sensor_msgs/JointState: wheels first, then steering joints; a joint's unknown values are NaN."""
    names = [*wheels, *steered]
    message = Template()
    message.header("base_link")
    message.strings(names)
    message.sequence("position", len(names))
    message.sequence("velocity", len(names))
    message.sequence("effort", len(names) if effort else 0)
    return message


def _fill_pose(out: NDArray[np.void], number: int, pose: Array) -> None:
    out[f"{number}.xy"] = pose[:, :2]
    half = 0.5 * pose[:, 2]
    out[f"{number}.turn"] = np.stack([np.sin(half), np.cos(half)], axis=-1)


# where (x, y, theta) x (x, y, theta) lies in a 6 x 6 covariance of (x, y, z, roll, pitch, yaw)
_COVARIANCE_PLACES = np.array([6 * i + j for i in (0, 1, 5) for j in (0, 1, 5)])


def _fill_odometry(
    out: NDArray[np.void], number: int, pose: Array, twist: Array, covariance: Array | None = None
) -> None:
    _fill_pose(out, number, pose)
    out[f"{number}.linear"], out[f"{number}.angular"] = twist[:, :2], twist[:, 2:]
    if covariance is not None:
        out[f"{number}.covariance"][:, _COVARIANCE_PLACES] = covariance
