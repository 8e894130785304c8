"""A control surface as a shaded mesh seen from above the front corner; places without a value are holes."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from holodrive import svg
from holodrive.control.fuzzy.shape import breaks, shapes
from holodrive.control.fuzzy.system import System
from holodrive.errors import InputError
from holodrive.log.shapes import LABEL, VERMILION
from holodrive.types import Array

LINES = 26  # of the mesh along each input, besides its break points
_NUMBER = LABEL | {"class_": "number", "fill": "#5b6675"}
# cividis, which people with every kind of colour vision order the same way (Nuñez, Anderton, Renslow 2018)
_RAMP = np.array([(0, 34, 78), (53, 69, 108), (102, 105, 112), (148, 142, 119), (200, 184, 102), (254, 232, 56)])
_BESIDE = 1e-3  # share of the range: a gap of no width is drawn as a slit of this half width


@dataclass(frozen=True)
class Surface:
    """One output over two inputs.

    Attributes:
        x, y: (nx,), (ny,) places of the two inputs, rising, in their units.
        z: (nx, ny) the output, NaN where no rule fires.
        names, units: of x, y and z.
        held: what the other inputs were held at, in words.
        low, high: range of the vertical axis.
    """

    x: Array
    y: Array
    z: Array
    names: tuple[str, str, str]
    units: tuple[str, str, str]
    held: str
    low: float
    high: float

    def svg(self, width: float = 460.0, height: float = 420.0) -> str:
        """The picture as one SVG document."""
        box = _Box(self, width, height)
        title = f"{self.names[2]} over {self.names[0]} and {self.names[1]}"
        known = self.z[np.isfinite(self.z)]
        span = f"from {known.min():.3g} to {known.max():.3g}" if known.size else "nowhere known"
        parts = [
            svg.text(8, 17, title, **(LABEL | {"class_": "chart-title", "font_size": 13, "font_weight": 600,
                                              "text_anchor": "start"})),
            svg.text(8, 33, self.held, **(_NUMBER | {"text_anchor": "start"})) if self.held else "",
            box.floor(), box.holes(), box.mesh(), box.axes(),
        ]  # fmt: skip
        if np.isnan(self.z).any():
            key = svg.element("path", d=f"M8 {height - 12:.0f}h16", stroke=VERMILION, stroke_width=3)
            words = svg.text(30, height - 8, "no rule fires", **(_NUMBER | {"text_anchor": "start"}))
            parts.append(key + words)
        where = f", {self.held}" if self.held else ""
        return svg.document(width, height, *parts, title=f"{title}{where}: {span}.", class_="surface")


def surface(
    system: System,
    across: tuple[str, str],
    output: int = 0,
    held: Sequence[float] | None = None,
    clamp: bool = True,
    lines: int = LINES,
) -> Surface:
    """An output over two inputs.

    Args:
        system: to show.
        across: names of the two inputs.
        output: number of the output, from 0.
        held: (n_in,) values of all inputs, of which the other ones are used; by default the middles of their ranges.
        clamp: as for `evaluate`.
        lines: of the mesh along each input.

    Raises:
        UnknownName: no such input.
        InputError: the same input twice.
    """
    i, j = (system.input_index(name) for name in across)
    if i == j:
        raise InputError(f"a surface needs two different inputs; found {across[0]!r} twice")
    base = np.array([0.5 * (v.low + v.high) for v in system.inputs] if held is None else held, dtype=np.float64)
    x, y = _places(system, i, lines), _places(system, j, lines)
    points = np.tile(base, (len(x), len(y), 1))
    points[..., i], points[..., j] = x[:, None], y[None, :]
    z = system.evaluate(points, clamp)[..., output]
    a, b, out = system.inputs[i], system.inputs[j], system.outputs[output]
    others = [(v.name, base[k], v.unit) for k, v in enumerate(system.inputs) if k not in (i, j)]
    words = ", ".join(f"{name} = {value:g}{' ' + unit if unit else ''}" for name, value, unit in others)
    return Surface(x, y, z, (a.name, b.name, out.name), (a.unit, b.unit, out.unit), words, out.low, out.high)


def side_by_side(pictures: Sequence[Surface], width: float = 460.0, height: float = 420.0) -> str:
    """Several surfaces as one SVG document."""
    inner = [
        svg.element("svg", one.svg(width, height), x=k * width, y=0.0, width=width, height=height)
        for k, one in enumerate(pictures)
    ]
    names = ", ".join(one.names[2] for one in pictures)
    return svg.document(len(pictures) * width, height, *inner, title=f"Control surfaces of {names}.")


def _places(system: System, index: int, lines: int) -> Array:
    """Evenly spread places and all break points; where an input has a gap, places on both sides of it."""
    variable = system.inputs[index]
    span = variable.high - variable.low
    curves = shapes(variable)
    even = np.linspace(variable.low, variable.high, lines)
    inner = np.unique(np.concatenate([[variable.low, variable.high], *(curve.x for curve in curves)]))
    if len(inner) > 2 * lines:  # curved sets have hundreds
        inner = np.array([variable.low, variable.high])
    points = breaks(curves, variable.low, variable.high) if curves else inner
    gaps = [p for p in points.tolist() if curves and all(curve.at(p) <= 0.0 for curve in curves)]
    beside = [p + side * _BESIDE * span for p in gaps for side in (-1.0, 0.0, 1.0)]
    inner = inner[(inner >= variable.low) & (inner <= variable.high)]
    far = even[np.all(np.abs(even[:, None] - inner[None, :]) > 0.2 * span / lines, axis=1)]
    places = np.unique(np.concatenate([far, inner, beside]))
    return places[(places >= variable.low) & (places <= variable.high)]


class _Box:
    """The oblique box: x along its front left edge, y along its front right one, both rising away from the eye."""

    def __init__(self, shown: Surface, width: float, height: float) -> None:
        self.shown = shown
        self.half, self.depth = 0.5 * width - 52.0, 0.27 * (height - 90.0)
        self.tall = height - 104.0 - 2.0 * self.depth
        self.middle, self.top = 0.5 * width + 8.0, 46.0 + self.tall
        self.u = 1.0 - (shown.x - shown.x[0]) / (shown.x[-1] - shown.x[0])
        self.v = 1.0 - (shown.y - shown.y[0]) / (shown.y[-1] - shown.y[0])

    def pixel(self, u: Array, v: Array, h: Array) -> Array:
        """Pixels (..., 2) of places u, v in 0..1 away from the back corner, at heights h in 0..1."""
        px = self.middle + (u - v) * self.half
        return np.stack(np.broadcast_arrays(px, self.top + (u + v) * self.depth - h * self.tall), axis=-1)

    def heights(self) -> Array:
        """(nx, ny) in 0..1."""
        return (self.shown.z - self.shown.low) / (self.shown.high - self.shown.low)

    def mesh(self) -> str:
        """Shaded four-sided pieces, the far ones first."""
        h = self.heights()
        low, high = (float(f(h[np.isfinite(h)], initial=e)) for f, e in ((np.min, 1.0), (np.max, 0.0)))
        tint = (h - low) / max(high - low, 1e-9)
        corners = self.pixel(self.u[:, None], self.v[None, :], h)
        pieces = []
        for i in range(len(self.u) - 1):
            for j in range(len(self.v) - 1):
                four = h[[i, i + 1, i + 1, i], [j, j, j + 1, j + 1]]
                if np.isfinite(four).all():
                    pixels = corners[[i, i + 1, i + 1, i], [j, j, j + 1, j + 1]]
                    slope = (four[0] + four[3] - four[1] - four[2]) / max(self.u[i] - self.u[i + 1], 1e-3)
                    near = self.u[i] + self.v[j]
                    pieces.append((near, _piece(pixels, float(tint[i : i + 2, j : j + 2].mean()), float(slope))))
        return svg.element("g", *(text for _, text in sorted(pieces, key=lambda pair: pair[0])))

    def floor(self) -> str:
        """The lower plane and the two back walls, with lines at round numbers."""
        d = []
        for axis in ("x", "y"):
            for value in self.ticks(axis)[0].tolist():
                d.append(self._across(axis, value))
        zs, _ = self.ticks("z")
        for value in zs.tolist():
            level = (value - self.shown.low) / (self.shown.high - self.shown.low)
            d.append(svg.path_data(self.pixel(np.array([0.0, 0.0, 1.0]), np.array([1.0, 0.0, 0.0]), np.array(level))))
        edge = self.pixel(np.array([0.0, 1.0, 1.0, 0.0, 0.0]), np.array([0.0, 0.0, 1.0, 1.0, 0.0]), np.zeros(5))
        return svg.element("path", class_="grid", d="".join(d) + svg.path_data(edge), stroke="#e3e6ea", fill="none")

    def _across(self, axis: str, value: float) -> str:
        """The line of one value over the floor and up the wall behind it."""
        one = self.shown.x if axis == "x" else self.shown.y
        at = 1.0 - (value - one[0]) / (one[-1] - one[0])
        along, rise = np.array([1.0, 0.0, 0.0]), np.array([0.0, 0.0, 1.0])
        held = np.full(3, at)
        return svg.path_data(self.pixel(held, along, rise) if axis == "x" else self.pixel(along, held, rise))

    def holes(self) -> str:
        """On the lower plane, where there is no value."""
        pieces = []
        bad = np.isnan(self.shown.z)
        for i in range(len(self.u) - 1):
            for j in range(len(self.v) - 1):
                if bad[i : i + 2, j : j + 2].any():
                    u, v = self.u[[i, i + 1, i + 1, i]], self.v[[j, j, j + 1, j + 1]]
                    pieces.append(svg.path_data(self.pixel(u, v, np.zeros(4))) + "z")
        hole: dict[str, object] = {"fill": VERMILION, "stroke": VERMILION, "stroke_width": 1.5}
        return svg.element("path", d="".join(pieces), **hole) if pieces else ""

    def ticks(self, axis: str) -> tuple[Array, int]:
        """Round numbers of an axis."""
        shown = self.shown
        low, high = {"x": (shown.x[0], shown.x[-1]), "y": (shown.y[0], shown.y[-1]), "z": (shown.low, shown.high)}[axis]
        return svg.ticks(float(low), float(high), 5)

    def axes(self) -> str:
        """Numbers along the front edges and the left one, and names."""
        x, y = self.spot(0.0, 1.0, 1.0)
        name = svg.text(x, y - 10.0, _named(self.shown, 2), **LABEL)
        return svg.element("g", self._front("x"), self._front("y"), self._levels(), name)

    def _front(self, axis: str) -> str:
        """Numbers and name of the axis along the front left (x) or front right edge (y)."""
        first = axis == "x"
        side, anchor = (-1.0, {"text_anchor": "end"}) if first else (1.0, {"text_anchor": "start"})
        one = self.shown.x if first else self.shown.y
        values, decimals = self.ticks(axis)
        parts = []
        for value in values.tolist():
            at = 1.0 - (value - one[0]) / (one[-1] - one[0])
            x, y = self.spot(at, 1.0) if first else self.spot(1.0, at)
            parts.append(svg.text(x + 6.0 * side, y + 12.0, svg.number(value, decimals), **(_NUMBER | anchor)))
        x, y = self.spot(0.5, 1.0) if first else self.spot(1.0, 0.5)
        parts.append(svg.text(x + 30.0 * side, y + 30.0, _named(self.shown, 0 if first else 1), **(LABEL | anchor)))
        return "".join(parts)

    def _levels(self) -> str:
        """Numbers up the left edge; the lowest would stand where the first axis ends."""
        values, decimals = self.ticks("z")
        low, high = self.shown.low, self.shown.high
        parts = []
        for value in values[values > low].tolist():
            x, y = self.spot(0.0, 1.0, (value - low) / (high - low))
            parts.append(svg.text(x - 6.0, y + 4.0, svg.number(value, decimals), **(_NUMBER | {"text_anchor": "end"})))
        return "".join(parts)

    def spot(self, u: float, v: float, h: float = 0.0) -> tuple[float, float]:
        """One pixel."""
        x, y = self.pixel(np.array(u), np.array(v), np.array(h)).tolist()
        return x, y


def _piece(pixels: Array, height: float, slope: float) -> str:
    shade = 0.82 + 0.18 * np.tanh(slope)  # lit from the side on which x is small
    place = np.clip(height, 0.0, 1.0) * (len(_RAMP) - 1)
    low = min(int(place), len(_RAMP) - 2)
    colour = (_RAMP[low] + (place - low) * (_RAMP[low + 1] - _RAMP[low])) * shade
    fill = "#" + "".join(f"{int(c):02x}" for c in colour)
    edge = "#" + "".join(f"{int(0.8 * c):02x}" for c in colour)
    return svg.element("path", d=svg.path_data(pixels) + "z", fill=fill, stroke=edge, stroke_width=0.4)


def _named(shown: Surface, index: int) -> str:
    name, unit = shown.names[index], shown.units[index]
    return f"{name}, {unit}" if unit else name
