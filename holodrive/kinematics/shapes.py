"""Arrays that a caller passed: numbers of the right shape, or one line that says what was found and what is allowed."""

import numpy as np
from numpy.typing import ArrayLike

from holodrive.errors import ChassisError, InputError
from holodrive.types import Array


def vectors(value: ArrayLike, size: int, what: str, parts: str) -> Array:
    """`value` as float64 (..., size); `parts` says what its last axis holds."""
    array = numbers(value, what)
    if array.shape[-1:] != (size,):
        raise InputError(f"{what} has shape {array.shape}; expected (..., {size}): {parts}")
    return array


def twists(value: ArrayLike, what: str = "a twist") -> Array:
    """`value` as float64 (..., 3)."""
    return vectors(value, 3, what, "vx, vy [m/s] and omega [rad/s]")


def numbers(value: ArrayLike, what: str) -> Array:
    """`value` as float64 of any shape."""
    try:
        return np.asarray(value, dtype=np.float64)
    except (TypeError, ValueError):
        raise InputError(f"{what} is {short(value)}; expected an array of numbers") from None


def common_shape(**shapes: tuple[int, ...]) -> tuple[int, ...]:
    """The leading axes of several arrays, broadcast; names of the arguments go into the message."""
    try:
        return np.broadcast_shapes(*shapes.values())
    except ValueError:
        found = ", ".join(f"{name} {shape}" for name, shape in shapes.items())
        raise InputError(f"leading axes do not fit together: {found}; make them equal or 1") from None


def wheel_values(value: ArrayLike, names: tuple[str, ...], what: str) -> Array:
    """`value` as float64 (..., n), one number for each of the wheels `names`."""
    array = numbers(value, what)
    if array.shape[-1:] != (len(names),):
        raise ChassisError(
            f"{what} have shape {array.shape}; expected (..., {len(names)}), one for each of {', '.join(names)}"
        )
    return array


def read_only(array: Array) -> Array:
    """The same array, that nobody can write any more."""
    array.flags.writeable = False
    return array


def short(value: object) -> str:
    """A value in one line of at most 60 characters."""
    text = " ".join(repr(value).split())
    return text if len(text) <= 60 else text[:57] + "..."
