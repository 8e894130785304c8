"""Checks that controllers' parameters share: finite, of the right sign, one line when not."""

import math
from dataclasses import fields
from types import NoneType
from typing import Any, get_args, get_type_hints

from holodrive.errors import InputError, did_you_mean, with_known
from holodrive.robots.spec import Robot

_WORDS = {"true": True, "yes": True, "on": True, "1": True, "false": False, "no": False, "off": False, "0": False}


def checked(plug: Any, positive: tuple[str, ...] = (), not_negative: tuple[str, ...] = ()) -> None:
    """Refuse NaN anywhere, wrong signs where named, and words that a Literal does not allow.

    A field may also be plain text, yes or no, or `float | None`: None leaves the number to somebody else.

    Raises:
        InputError: naming the parameter, what was found and what is allowed.
    """
    hints = get_type_hints(type(plug))
    for field in fields(plug):
        value, name = getattr(plug, field.name), f"{type(plug).__name__}.{field.name}"
        hint = hints[field.name]
        words = [word for word in get_args(hint) if isinstance(word, str)]
        if words:
            if value not in words:
                raise InputError(f"{name} is {value!r}; allowed: {', '.join(words)}{did_you_mean(str(value), words)}")
            continue
        if value is None and NoneType in get_args(hint):
            continue
        if hint is str or hint is bool:
            if not isinstance(value, hint):
                raise InputError(f"{name} is {value!r}; it must be {'text' if hint is str else 'true or false'}")
            continue
        if isinstance(value, bool) or not isinstance(value, int | float):
            raise InputError(f"{name} is {value!r}; it must be a number")
        if math.isnan(value):
            raise InputError(f"{name} is NaN; it must be a number")
        if field.name in positive and not value > 0.0:
            raise InputError(f"{name} is {value:g}; it must be above 0")
        if field.name in not_negative and value < 0.0:
            raise InputError(f"{name} is {value:g}; it must be 0 or more")


def made(kind: str, cls: Any, params: dict[str, Any]) -> Any:
    """An instance of the parameter class with `params` set; numbers, yes and no may come as text.

    Raises:
        InputError: unknown parameter (with the near one) or a value that is not a number.
    """
    known = [field.name for field in fields(cls)]
    hints = get_type_hints(cls)
    values: dict[str, Any] = {}
    for name, value in params.items():
        if name not in known:
            raise InputError(f"{kind} has no parameter {name!r}{with_known(name, known)}")
        values[name] = _read(value, hints[name])
    return cls(**values)


def speed_of_slowest_wheel(robot: Robot) -> float:
    """Rim speed [m/s] that every wheel of the robot can reach."""
    return min(wheel.max_speed_rad_s * wheel.radius for wheel in robot.wheels)


def _read(value: Any, hint: Any) -> Any:
    """What a text means to a field; whatever cannot be read stays as it is for `checked` to name."""
    if not isinstance(value, str) or hint is str:
        return value
    if hint is bool:
        return _WORDS.get(value.lower(), value)
    if value.lower() == "none" and NoneType in get_args(hint):
        return None
    try:
        return float(value)
    except ValueError:
        return value
