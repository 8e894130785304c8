"""IMU, mice and motors of every tick as messages, and which tick a reading that was read back belongs to.

A reading has the log time of its tick. It is a message of its own, beside `holodrive_msgs/msg/Tick`, so that a log
without these sensors, or from before they were recorded, has just one topic less.
"""

from collections import Counter
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from holodrive.log.cdr import ENCAPSULATION, Hole, Template
from holodrive.robots.spec import Robot
from holodrive.types import Array, MotorState

IMU_FRAME = "imu"
_NAN = float("nan")
_NOT_MEASURED = -1.0  # sensor_msgs/Imu: as the first number of a covariance, there is no such reading


def mouse_frame(name: str) -> str:
    """The frame in whose axes a mouse counts."""
    return f"mouse_{name}"


def imu_template(robot: Robot) -> Template:
    """sensor_msgs/Imu; what a planar IMU does not measure is NaN, a covariance that nobody knows 0."""
    gyro = 0.0 if robot.imu is None else robot.imu.gyro_noise_rad_s**2
    accel = 0.0 if robot.imu is None else robot.imu.accel_noise_m_s2**2
    message = Template()
    message.header(IMU_FRAME)
    message.numbers(0.0, 0.0, 0.0, 1.0)
    message.numbers(_NOT_MEASURED, *[0.0] * 8)
    message.numbers(_NAN, _NAN)
    message.hole("gyro")
    message.hole("gyro_variance")
    message.numbers(*[0.0] * 7, gyro)
    message.hole("accel", count=2)
    message.numbers(_NAN)
    message.hole("accel_variance")
    message.numbers(0.0, 0.0, 0.0, accel, *[0.0] * 4)
    return message


def mice_template(robot: Robot) -> Template:
    """holodrive_msgs/Mice."""
    message = Template()
    message.header("base_link")
    message.strings([mouse.name for mouse in robot.mice])
    message.sequence("x", len(robot.mice))
    message.sequence("y", len(robot.mice))
    return message


def motor_names(robot: Robot) -> list[str]:
    """Drives by their wheels, then steerings."""
    names = [wheel.name for wheel in robot.wheels]
    return [*names, *(f"{names[i]}_steer" for i in robot.steered)]


def motors_template(robot: Robot) -> Template:
    """holodrive_msgs/Motors."""
    names = motor_names(robot)
    message = Template()
    message.header("base_link")
    message.strings(names)
    for name in MotorState._fields:
        message.sequence(name, len(names))
    return message


def fill_imu(out: NDArray[np.void], number: int, robot: Robot, gyro: Array, accel: Array) -> None:
    """Write yaw rates (T, 1) [rad/s] and specific forces (T, 2) [m/s^2] into the holes of channel `number`."""
    variance = 0.0 if robot.imu is None else robot.imu.accel_noise_m_s2**2
    out[f"{number}.gyro"], out[f"{number}.accel"] = gyro, accel
    out[f"{number}.gyro_variance"] = np.where(np.isnan(gyro), _NOT_MEASURED, 0.0)
    out[f"{number}.accel_variance"] = np.where(np.isnan(accel).any(axis=1), _NOT_MEASURED, variance)[:, None]


def fill_mice(out: NDArray[np.void], number: int, mice: Array) -> None:
    """Write displacements (T, 2 k) [m], x and y of one mouse after the other, into the holes of channel `number`."""
    out[f"{number}.x"], out[f"{number}.y"] = mice[:, ::2], mice[:, 1::2]


def fill_motors(out: NDArray[np.void], number: int, motors: Array) -> None:
    """Write the numbers (T, 4 k) of one motor after the other into the holes of channel `number`."""
    for i, name in enumerate(MotorState._fields):
        out[f"{number}.{name}"] = motors[:, i::4]


def read_motors(messages: Sequence[bytes], robot: Robot) -> tuple[Array, NDArray[np.bool_]]:
    """Numbers (g, 4 k) of one motor after the other, and which of M messages are good (M,)."""
    raw, good, holes = alike(messages, motors_template(robot))
    each = np.stack([numbers(raw, holes[name]) for name in MotorState._fields], axis=-1)
    return each.reshape(len(raw), len(MotorState._fields) * len(motor_names(robot))), good


def read_imu(messages: Sequence[bytes], robot: Robot) -> tuple[Array, NDArray[np.bool_]]:
    """Yaw rate and specific force (g, 3) of the good ones of M messages, and which are good (M,)."""
    raw, good, holes = alike(messages, imu_template(robot))
    return np.concatenate([numbers(raw, holes["gyro"]), numbers(raw, holes["accel"])], axis=1), good


def read_mice(messages: Sequence[bytes], robot: Robot) -> tuple[Array, NDArray[np.bool_]]:
    """Displacements (g, 2 k), x and y of one mouse after the other, and which of M messages are good (M,)."""
    raw, good, holes = alike(messages, mice_template(robot))
    if not robot.mice:
        return np.empty((len(raw), 0)), good
    both = np.stack([numbers(raw, holes["x"]), numbers(raw, holes["y"])], axis=-1)
    return both.reshape(len(raw), 2 * len(robot.mice)), good


def alike(
    messages: Sequence[bytes], template: Template
) -> tuple[NDArray[np.uint8], NDArray[np.bool_], dict[str, Hole]]:
    """Bytes (g, size) of the messages that have the template's size, which they are (M,), and its holes."""
    size = len(template.data)
    good = [len(data) == size and data[:4] == ENCAPSULATION for data in messages]
    joined = b"".join(data for data, is_good in zip(messages, good, strict=True) if is_good)
    raw = np.frombuffer(joined, dtype=np.uint8).reshape(-1, size)
    return raw, np.array(good, dtype=np.bool_), {hole.name: hole for hole in template.holes}


def numbers(raw: NDArray[np.uint8], hole: Hole) -> Array:
    """The float64 numbers (g, count) of one hole in the bytes (g, size) of messages."""
    return np.ascontiguousarray(raw[:, hole.offset : hole.offset + 8 * hole.count]).view("<f8")


def ticks_of(stamps: NDArray[np.uint64], ticks: NDArray[np.uint64]) -> NDArray[np.int64]:
    """Which tick (K,) each reading belongs to, by log times [ns] (K,) and (T,); -1 where there is none.

    Where ticks share a time, the first reading of that time is of the first of them, and so on.
    """
    if np.array_equal(stamps, ticks):
        return np.arange(len(ticks))
    place = {key: i for i, key in enumerate(_numbered(ticks))}
    return np.array([place.get(key, -1) for key in _numbered(stamps)], dtype=np.int64)


def _numbered(stamps: NDArray[np.uint64]) -> list[tuple[int, int]]:
    """Each stamp with how many of the same came before it."""
    seen: Counter[int] = Counter()
    out = []
    for stamp in stamps.tolist():
        out.append((stamp, seen[stamp]))
        seen[stamp] += 1
    return out
