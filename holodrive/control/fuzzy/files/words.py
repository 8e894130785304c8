"""What the writers of the three formats share: numbers as text, refusals, and shapes that go by several names."""

from collections.abc import Iterable

from holodrive.control.fuzzy.sets import SetKind
from holodrive.control.fuzzy.system import System
from holodrive.errors import InputError

FORMAT_NAMES = {"fis": "a MATLAB .fis file", "fcl": "FCL (IEC 61131-7)", "fml": "FML (IEEE 1855)", "c": "the C export"}


def number(value: float) -> str:
    """The shortest text that reads back as the same number, without ".0"."""
    value = float(value)
    return str(int(value)) if value.is_integer() and abs(value) < 1e15 else repr(value)


def numbers(values: Iterable[float]) -> str:
    """Numbers with spaces between them."""
    return " ".join(map(number, values))


def cannot(system: System, format: str, what: str, instead: str = "") -> InputError:
    """The error of a system that has what a format cannot say; to be raised."""
    text = f"{FORMAT_NAMES[format]} cannot say {what} (fuzzy system {system.name!r})"
    return InputError(" ".join((text + (f"; {instead}" if instead else "")).split()))


def refuse_fuzzylab(system: System, format: str) -> None:
    """No format knows the compatibility switch."""
    if system.fuzzylab:
        raise cannot(
            system,
            format,
            "that the outputs are swapped and sampled as fuzzylab does",
            "write dataclasses.replace(system, fuzzylab=False)",
        )


def straightened(params: tuple[float, ...]) -> tuple[SetKind | str, tuple[float, ...]]:
    """A polyline under its simplest name: triangle, trapezoid, `falling` or `rising` (one side), or polyline.

    A polyline is level beyond its ends, so points of the same height there say nothing and are dropped.
    """
    points = list(zip(params[::2], params[1::2], strict=True))
    while len(points) > 2 and points[0][1] == points[1][1]:
        points.pop(0)
    while len(points) > 2 and points[-1][1] == points[-2][1]:
        points.pop()
    places, heights = tuple(x for x, _ in points), tuple(mu for _, mu in points)
    if heights == (1.0, 0.0) and places[0] < places[1]:
        return "falling", places
    if heights == (0.0, 1.0) and places[0] < places[1]:
        return "rising", places
    if heights == (0.0, 1.0, 0.0) and places[0] < places[2]:
        return "triangle", places
    if heights == (0.0, 1.0, 1.0, 0.0) and places[0] < places[3]:
        return "trapezoid", places
    return "polyline", params
