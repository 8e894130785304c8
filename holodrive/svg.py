"""SVG elements as text: the few that robots, worlds and plots are drawn with."""

import math
from html import escape

import numpy as np
from numpy.typing import ArrayLike

from holodrive.types import Array


def element(name: str, *children: str, **attributes: object) -> str:
    """`<name a="b">children</name>`; `_` in attribute names becomes `-`, a trailing `_` goes, None is left out."""
    text = "".join(
        f' {key.rstrip("_").replace("_", "-")}="{_value(value)}"'
        for key, value in attributes.items()
        if value is not None
    )
    return f"<{name}{text}>{''.join(children)}</{name}>" if children else f"<{name}{text}/>"


def text(x: float, y: float, content: str, **attributes: object) -> str:
    """A text element with escaped content."""
    return element("text", escape(content), x=x, y=y, **attributes)


def document(
    width: float, height: float, *children: str, view_box: str | None = None, title: str = "", **attributes: object
) -> str:
    """A whole SVG picture of `width` x `height` pixels; `title` is also what screen readers say."""
    head = element("title", escape(title)) if title else ""
    return element(
        "svg",
        head,
        *children,
        xmlns="http://www.w3.org/2000/svg",
        width=width,
        height=height,
        viewBox=view_box or f"0 0 {_value(width)} {_value(height)}",
        role="img",
        **({"aria_label": title} if title else {}),
        **attributes,
    )


def points(pairs: object) -> str:
    """`x,y x,y ...` for polylines and polygons, from an (n, 2) array or list."""
    return " ".join(f"{x:.5g},{y:.5g}" for x, y in pairs)  # type: ignore[attr-defined]


def path_data(xy: ArrayLike) -> str:
    """The `d` of a polyline through (n, 2) pixels, in tenths of a pixel; rows that are not finite are gaps.

    A point between two gaps becomes a line of no length, which a round line cap shows as a dot.
    """
    parts = []
    for run in finite_runs(xy):
        tenths = np.rint(run * 10.0).astype(np.int64)
        steps = np.diff(tenths, axis=0)
        steps = steps[np.any(steps != 0, axis=1)]
        start = f"M{_tenth(tenths[0, 0])}{_tenth(tenths[0, 1], after=True)}"
        body = "".join(_tenth(x, after=i > 0) + _tenth(y, after=True) for i, (x, y) in enumerate(steps.tolist()))
        parts.append(start + (f"l{body}" if body else "h0"))
    return "".join(parts)


def finite_runs(xy: ArrayLike) -> list[Array]:
    """The stretches (k, 2) of an (n, 2) array between its rows with NaN or infinity."""
    xy = np.asarray(xy, dtype=np.float64).reshape(-1, 2)
    good = np.isfinite(xy).all(axis=1)
    edges = np.flatnonzero(np.diff(np.concatenate([[False], good, [False]]).astype(np.int8)))
    return [xy[a:b] for a, b in zip(edges[::2], edges[1::2], strict=True)]


def simplify(xy: ArrayLike, tolerance: float = 0.2) -> Array:
    """A polyline (k, 2) within `tolerance` of the given (n, 2) one (Ramer, Douglas, Peucker); gaps (NaN rows) stay."""
    gap = np.full((1, 2), np.nan)
    pieces: list[Array] = []
    for run in finite_runs(xy):
        pieces += [_simplify_run(_thin(run, 0.5 * tolerance), tolerance), gap]
    return np.concatenate(pieces[:-1]) if pieces else np.empty((0, 2))


def ticks(low: float, high: float, count: int = 5) -> tuple[Array, int]:
    """About `count` round numbers (steps of 1, 2 or 5) in [low, high], and the decimals they need."""
    span = high - low
    if not (math.isfinite(span) and span > 0.0):
        return np.array([low if math.isfinite(low) else 0.0]), 0
    raw = span / max(count, 1)
    power = 10.0 ** math.floor(math.log10(raw))
    step = power * min((1, 2, 5, 10), key=lambda m: abs(math.log(m * power / raw)))
    first, last = math.ceil(low / step - 1e-9), math.floor(high / step + 1e-9)
    return np.arange(first, last + 1, dtype=np.float64) * step, max(0, -math.floor(math.log10(step) + 1e-9))


def number(value: float, decimals: int) -> str:
    """A number for reading: fixed decimals, a true minus sign, no minus zero; an em dash for NaN."""
    if math.isnan(value):
        return "—"
    if math.isinf(value):
        return "∞" if value > 0 else "−∞"
    text = f"{value:.{decimals}f}"
    if not text.strip("-0."):
        text = text.lstrip("-")
    return text.replace("-", "−")


def _thin(run: Array, cell: float) -> Array:
    """Without consecutive points in the same cell of a fine grid, so that hours of standing cost nothing."""
    grid = np.floor(run / cell)
    keep = np.ones(len(run), dtype=bool)
    keep[1:-1] = np.any(grid[1:-1] != grid[:-2], axis=1)
    return run[keep]


def _simplify_run(run: Array, tolerance: float) -> Array:
    keep = np.zeros(len(run), dtype=bool)
    keep[[0, -1]] = True
    stack = [(0, len(run) - 1)]
    while stack:
        a, b = stack.pop()
        if b - a < 2:
            continue
        chord, offsets = run[b] - run[a], run[a + 1 : b] - run[a]
        length = math.hypot(chord[0], chord[1])
        if length > 0.0:
            along = np.clip((offsets @ chord) / length**2, 0.0, 1.0)
            offsets = offsets - along[:, None] * chord
        distance = np.hypot(offsets[:, 0], offsets[:, 1])
        far = int(np.argmax(distance))
        if distance[far] > tolerance:
            middle = a + 1 + far
            keep[middle] = True
            stack += [(a, middle), (middle, b)]
    return run[keep]


def _tenth(tenths: int, after: bool = False) -> str:
    """A number of tenths, as short as SVG allows; `after` another number, so that it may need a space before it."""
    sign, whole, rest = ("-" if tenths < 0 else ""), *divmod(abs(int(tenths)), 10)
    body = f"{whole or ''}.{rest}" if rest else str(whole)
    return f"{sign}{body}" if sign or not after else f" {body}"


def _value(value: object) -> str:
    return f"{value:.5g}" if isinstance(value, float) else escape(str(value), quote=True)
