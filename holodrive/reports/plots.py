"""Line charts over time as SVG: round ticks, units on the axes, gaps where a value is unknown, peaks kept."""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from holodrive import svg
from holodrive.log.shapes import text_width
from holodrive.types import Array

# Okabe and Ito's palette, told apart by colour-blind readers; the page's style has a second one for the dark
COLOURS = ("#0072B2", "#E69F00", "#009E73", "#D55E00", "#CC79A7", "#56B4E9", "#8a6d00", "#5b6675")
DASHES = (None, "7 3", "2 3", "9 3 2 3")

_LEFT, _RIGHT, _TOP, _BOTTOM = 46.0, 10.0, 46.0, 34.0  # px about the plot area
_LEGEND_ROW = 16.0  # px
_NUMBER: dict[str, object] = {"class_": "number", "font_size": 11, "fill": "#5b6675", "font_family": "sans-serif"}


@dataclass(frozen=True)
class Line:
    """One line: x (n,) and y (n,), its name, the number of its colour, and whether it is a pale companion.

    `area` fills what lies between it and the lower edge of the plot.
    """

    name: str
    x: Array
    y: Array
    colour: int = 0
    pale: bool = False
    dash: str | None = None
    area: bool = False


@dataclass(frozen=True)
class Chart:
    """Lines on common axes.

    Attributes:
        title: words; `unit` is that of all lines.
        lines: what is drawn; those without a finite value are left out.
        x_name, x_unit: of the common axis.
        low, high: limits that the vertical axis must at least have; None takes them from the data.
        least: smallest span of the vertical axis, so that rounding noise does not fill a chart.
        marks: times of events, drawn as thin lines down the plot.
    """

    title: str
    unit: str
    lines: tuple[Line, ...]
    x_name: str = "time"
    x_unit: str = "s"
    low: float | None = None
    high: float | None = None
    least: float = 0.0
    marks: tuple[float, ...] = ()
    width: float = 460.0
    height: float = 220.0

    def known(self) -> list[Line]:
        """Lines with at least one finite value."""
        return [line for line in self.lines if np.isfinite(line.y).any()]

    def svg(self) -> str:
        """The chart as one SVG document; `data-*` tell a page where its plot area and time axis are."""
        lines = self.known()
        box = Axes.of(self, lines)
        parts = [
            svg.text(8, 17, self.title + (f", {self.unit}" if self.unit else ""), class_="chart-title", font_size=13,
                     font_weight=600, fill="#1d2530", font_family="sans-serif"),
            _legend(lines, self.width, 35.0) if len(lines) > 1 or any(line.name for line in lines) else "",
            box.grid(self),
            *(self._mark(box, time) for time in self.marks if box.x0 <= time <= box.x1),
            *(_curve(box, line) for line in lines),
        ]  # fmt: skip
        if not lines:
            parts.append(
                svg.text(0.5 * self.width, 0.55 * self.height, "not recorded", text_anchor="middle", **_NUMBER)
            )
        return svg.document(
            self.width, self.height, *parts, title=self.described(), class_="chart",
            data_x0=box.left, data_x1=box.left + box.width, data_y0=box.top, data_y1=box.top + box.height,
            data_t0=float(box.x0), data_t1=float(box.x1), data_time=1 if self.x_unit == "s" else None,
        )  # fmt: skip

    def described(self) -> str:
        """What the chart shows, in one sentence with its extremes."""
        known = self.known()
        if not known:
            return f"{self.title}: not recorded."
        low, high = (f([f(line.y[np.isfinite(line.y)]) for line in known]) for f in (min, max))
        names = ", ".join(line.name for line in known if line.name)
        unit = f" {self.unit}" if self.unit else ""
        return f"{self.title} over {self.x_name}{': ' + names if names else ''}; from {low:.3g} to {high:.3g}{unit}."

    def _mark(self, box: "Axes", time: float) -> str:
        x = float(box.column(np.array([time]))[0])
        d = f"M{x:.1f} {box.top:.1f}v{box.height:.1f}"
        return svg.element("path", class_="event-mark", d=d, stroke="#D55E00", stroke_dasharray="2 3", fill="none")


@dataclass(frozen=True)
class Axes:
    """The plot area [px] and the range of values on it."""

    left: float
    top: float
    width: float
    height: float
    x0: float
    x1: float
    y0: float
    y1: float

    @classmethod
    def of(cls, chart: Chart, lines: Sequence[Line]) -> "Axes":
        """Axes that hold every finite value, with a little air above and below."""
        times = [line.x[np.isfinite(line.x)] for line in lines]
        x0, x1 = _range(np.concatenate(times) if times else np.zeros(0))
        x0 = 0.0 if 0.0 < x0 < 0.05 * x1 else x0  # the first tick is one period after zero
        values = _framing(lines)
        limits = [np.array([v]) for v in (chart.low, chart.high) if v is not None]
        y0, y1 = _range(np.concatenate([*values, *limits]) if values or limits else np.zeros(0))
        if y1 - y0 < chart.least:
            middle = 0.5 * (y0 + y1)
            y0 = y0 if y0 == chart.low else middle - 0.5 * chart.least
            y1 = y0 + chart.least
        air = 0.06 * (y1 - y0)
        y0 = y0 if y0 in (chart.low, 0.0) else y0 - air
        y1 = y1 if y1 == chart.high else y1 + air
        named = len(lines) > 1 or any(line.name for line in lines)
        top = _TOP + _LEGEND_ROW * (_legend_places(lines, chart.width)[-1][1] if named else 0) - 18.0 * (not named)
        return cls(_LEFT, top, chart.width - _LEFT - _RIGHT, chart.height - top - _BOTTOM, x0, x1, y0, y1)

    def column(self, x: Array) -> Array:
        """Pixels across."""
        return np.asarray(self.left + (x - self.x0) / (self.x1 - self.x0) * self.width)

    def row(self, y: Array) -> Array:
        """Pixels down."""
        return np.asarray(self.top + self.height - (y - self.y0) / (self.y1 - self.y0) * self.height)

    def grid(self, chart: Chart) -> str:
        """Grid lines with their numbers, and the name of the time axis."""
        xs, x_decimals = svg.ticks(self.x0, self.x1, 6)
        ys, y_decimals = svg.ticks(self.y0, self.y1, max(3, int(self.height // 30)))
        right, bottom = self.left + self.width, self.top + self.height
        rows, columns = self.row(ys), self.column(xs)
        d = "".join(f"M{self.left:.1f} {row:.1f}H{right:.1f}" for row in rows)
        d += "".join(f"M{column:.1f} {bottom:.1f}v4" for column in columns)
        zero = f"M{self.left:.1f} {self.row(np.zeros(1))[0]:.1f}H{right:.1f}" if self.y0 <= 0.0 <= self.y1 else ""
        texts = [
            svg.text(self.left - 6, row + 4, svg.number(y, y_decimals), text_anchor="end", **_NUMBER)
            for row, y in zip(rows.tolist(), ys.tolist(), strict=True)
        ]
        texts += [
            _column_number(column, bottom + 16, svg.number(x, x_decimals), chart.width)
            for column, x in zip(columns.tolist(), xs.tolist(), strict=True)
        ]
        name = f"{chart.x_name}, {chart.x_unit}" if chart.x_unit else chart.x_name
        texts.append(svg.text(right, bottom + 29, name, text_anchor="end", **_NUMBER))
        return (
            svg.element("path", class_="grid", d=d, stroke="#e3e6ea", fill="none")
            + (svg.element("path", class_="zero", d=zero, stroke="#9aa4b0", fill="none") if zero else "")
            + svg.element("g", *texts)
        )


def decimate(x: Array, y: Array, buckets: int) -> tuple[Array, Array]:
    """First, least, greatest and last value of each of `buckets` equal stretches, in order: peaks and gaps stay.

    Returns x and y unchanged when there are fewer than four values a bucket.
    """
    if len(x) <= 4 * buckets:
        return x, y
    edges = np.linspace(0, len(x), buckets + 1).astype(np.int64)
    keep: list[int] = []
    for a, b in pairwise(edges.tolist()):
        piece = y[a:b]
        good = np.flatnonzero(np.isfinite(piece))
        picks = [0, b - a - 1]
        if len(good):
            picks += [int(good[np.argmin(piece[good])]), int(good[np.argmax(piece[good])])]
            if len(good) < len(piece):
                picks.append(int(np.flatnonzero(~np.isfinite(piece))[0]))  # the gap is seen even if it is short
        keep += [a + i for i in sorted(set(picks))]
    index = np.array(keep)
    return x[index], y[index]


def _curve(box: Axes, line: Line) -> str:
    x, y = decimate(line.x, line.y, int(box.width / 2))
    rows = np.clip(box.row(y), box.top, box.top + box.height)  # only pale lines can reach beyond
    pixels = np.column_stack([box.column(x), rows])
    return (_filled(box, pixels, line) if line.area else "") + svg.element(
        "path", class_=f"line c{line.colour % len(COLOURS)}" + (" pale" if line.pale else ""),
        d=svg.path_data(svg.simplify(pixels, 0.3)), stroke=COLOURS[line.colour % len(COLOURS)], fill="none",
        stroke_width=3.5 if line.pale else 1.5, stroke_opacity=0.35 if line.pale else None,
        stroke_dasharray=line.dash, stroke_linejoin="round", stroke_linecap="round",
    )  # fmt: skip


def _filled(box: Axes, pixels: Array, line: Line) -> str:
    bottom = box.top + box.height
    d = "".join(
        svg.path_data(np.vstack([(run[0, 0], bottom), *run, (run[-1, 0], bottom)])) + "z"
        for run in svg.finite_runs(pixels)
    )
    return svg.element("path", d=d, fill=COLOURS[line.colour % len(COLOURS)], fill_opacity=0.25) if d else ""


def _framing(lines: Sequence[Line]) -> list[Array]:
    """The values that set the axis: pale companions stretch it to three times the solid lines' reach, not more.

    A controller may ask for thirty times what a base can do; what the base did must stay readable.
    """
    solid = [line.y[np.isfinite(line.y)] for line in lines if not line.pale]
    reach = max((float(np.abs(values).max()) for values in solid if len(values)), default=np.inf)
    limit = 3.0 * reach if reach > 0.0 else np.inf
    pale = [np.clip(line.y[np.isfinite(line.y)], -limit, limit) for line in lines if line.pale]
    return solid + pale


def _column_number(column: float, row: float, number: str, width: float) -> str:
    """A number under its tick, moved to the left where it would be cut off at the edge of the chart."""
    return svg.text(min(column, width - 0.5 * text_width(number) - 1.0), row, number, text_anchor="middle", **_NUMBER)


def _legend_places(lines: Sequence[Line], width: float) -> list[tuple[float, int]]:
    """Where each named line's entry begins [px], and in which row; at least one place."""
    places, x, row = [], _LEFT, 0
    for line in (one for one in lines if one.name):
        wide = 23.0 + 6.6 * len(line.name)
        if x > _LEFT and x + wide > width - 2.0:
            x, row = _LEFT, row + 1
        places.append((x, row))
        x += wide + 14.0
    return places or [(_LEFT, 0)]


def _legend(lines: Sequence[Line], width: float, top: float) -> str:
    parts, named = [], [one for one in lines if one.name]
    for line, (x, row) in zip(named, _legend_places(lines, width), strict=False):
        y = top + _LEGEND_ROW * row
        parts.append(
            svg.element("path", class_=f"line c{line.colour % len(COLOURS)}" + (" pale" if line.pale else ""),
                        d=f"M{x:.1f} {y - 4:.1f}h18", stroke=COLOURS[line.colour % len(COLOURS)],
                        stroke_width=3.5 if line.pale else 2, stroke_opacity=0.35 if line.pale else None,
                        stroke_dasharray=line.dash)
            + svg.text(x + 23, y, line.name, **(_NUMBER | {"class_": "label", "fill": "#1d2530"}))
        )  # fmt: skip
    return svg.element("g", *parts, class_="legend")


def _range(values: Array) -> tuple[float, float]:
    """Least and greatest; a range of some width even for one value or none."""
    if not len(values):
        return 0.0, 1.0
    low, high = float(values.min()), float(values.max())
    if high - low > 1e-12 * max(abs(low), abs(high), 1e-300):
        return low, high
    half = 0.5 * abs(low)
    return (low - half, high + half) if half > 0.0 else (0.0, 1.0)
